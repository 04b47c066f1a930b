"""The window: glfw, OpenGL 3.3 core, textures. Knows nothing of tensors and calls nothing of Dear ImGui."""
