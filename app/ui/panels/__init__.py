"""Around the picture: the light, the effects, saving, the channels, the line below."""
