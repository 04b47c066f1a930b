"""What stands behind people in photographs, drawn, or seen in panoramas."""
