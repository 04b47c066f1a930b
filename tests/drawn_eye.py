"""A drawn eye: skin, an almond of white, and an iris with its pupil, under a lid."""

import numpy as np

CLASSES = 14
LEFT_EYE, RIGHT_EYE = 4, 5


def draw_eyes(irises, size=(200, 300), iris=0.05, pupil=0.01, white=0.5, skin=0.4, opened=1.0, specks=()):
    """A photo (H, W, 3), linear, with an eye about each iris (x, y, radius).

    Args:
        opened: 0 is closed.
        specks: (x, y, radius) of catchlights, in pixels.
    """
    fine = 4
    y, x = (np.mgrid[0 : size[0] * fine, 0 : size[1] * fine] + 0.5) / fine
    seen = np.full(x.shape, skin)
    for at_x, at_y, radius in irises:
        almond = np.hypot((x - at_x) / (2.4 * radius), (y - at_y) / (0.95 * radius * max(opened, 1e-6))) < 1
        away = np.hypot(x - at_x, y - at_y) / radius
        inside = np.where(away < 0.35, pupil, np.where(away < 1, iris, white))
        seen = np.where(almond, inside, seen)
    for at_x, at_y, radius in specks:
        seen = np.where(np.hypot(x - at_x, y - at_y) < radius, 2.0, seen)
    seen = seen.reshape(size[0], fine, size[1], fine).mean((1, 3))
    return np.repeat(seen[..., None], 3, axis=-1).astype(np.float32)


def parse_eyes(irises, view, size=128):
    """Probabilities (14, S, S) in a view that see each iris's eye, lids included; the left one first."""
    parsing = np.zeros((CLASSES, size, size), np.float32)
    parsing[1] = 1
    places = (np.stack(np.meshgrid(*[np.arange(size) + 0.5] * 2), -1)).reshape(-1, 2)
    photo = view.to_photo(places, size).reshape(size, size, 2)
    for label, (x, y, radius) in zip((LEFT_EYE, RIGHT_EYE), irises, strict=False):
        eye = np.hypot((photo[..., 0] - x) / (2.4 * radius), (photo[..., 1] - y) / (1.1 * radius)) < 1
        parsing[label][eye], parsing[1][eye] = 1, 0
    return parsing
