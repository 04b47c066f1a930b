"""The rendered heads: geometry, skin, dressing, baked transport, lighting of samples."""
