"""What is found once in a photo: the face, the surface, the light it was taken under, the whole person."""
