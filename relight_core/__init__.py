"""Portrait relighting by explicit reflectance channels, usable from Python with no window and no GL."""

__version__ = "0.1.0"
