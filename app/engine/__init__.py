"""Everything slow, off the window's thread: opening, relighting, thumbnails and export. Knows no window."""
