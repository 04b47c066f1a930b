"""Everything the user can do, in one table, and what reads it: the keys, the palette, the overlay of help."""
