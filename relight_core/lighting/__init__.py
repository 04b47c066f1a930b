"""Light: lat-long environment maps, light rigs, irradiance and specular lobes."""
