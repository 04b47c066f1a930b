"""The panels. They alone call Dear ImGui, and `window.gl_interface` that draws its lists: the binding can change."""
