"""File formats, one module each, with what their headers say of colour, size and camera."""
