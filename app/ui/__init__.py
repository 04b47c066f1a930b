"""The panels. Every call of Dear ImGui in the project is made here, so that the binding can change."""
