"""The window: glfw, OpenGL 3.3 core, textures. Knows nothing of tensors, and draws what Dear ImGui lists."""
