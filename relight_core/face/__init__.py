"""Faces in a photo: find, crop, paste."""
