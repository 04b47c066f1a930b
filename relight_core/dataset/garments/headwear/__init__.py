"""Hats, caps, scarves, helmets and ornaments made for the head that wears them."""
