"""From a head, once, to everything that any light needs to light it; and the file that this is kept in."""
