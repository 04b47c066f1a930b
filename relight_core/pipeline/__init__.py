"""From a photo to a relit photo: stages, and the Relighter that ties them."""
