"""Images in and out: files, colour, the view transform, resampling, guided detail."""
