"""Photos and lights as the engine would have opened them, of a few pixels."""

from dataclasses import replace

import numpy as np

from app.engine.snapshot import OpenLight, OpenPhoto
from app.engine.sources import LightSource, PhotoSource
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment

SKY = LightSource("panorama", "/lights/sky.hdr")


def grey_photo(path=None):
    return Photo(np.full((4, 4, 3), 0.5, np.float32), path=path)


def photo_files(folder, *names):
    """Files by which a photo is known and that nothing reads."""
    for name in names:
        (folder / name).write_bytes(b"pixels")
    return [folder / name for name in names]


def opened_for(source):
    """A grey photo in answer to a wish for one."""
    photo = grey_photo(source.path)
    return OpenPhoto(source, photo, photo.linear.astype(np.float16))


def opened_photo(path=None):
    photo = grey_photo(path)
    return OpenPhoto(PhotoSource(photo), photo, photo.linear.astype(np.float16))


def open_wish(state):
    """The photo that is wished for comes; the light stays as it is."""
    state.accept(replace(state.snapshot, opened=opened_for(state.photo)))


def refuse_photo(state):
    """The photo that is wished for can't be opened."""
    _refuse(state, state.photo)


def refuse_light(state):
    """The light that is wished for can't be opened."""
    _refuse(state, state.light)


def _refuse(state, wish):
    state.accept(replace(state.snapshot, refused=state.snapshot.refused | {wish}))


def open_light(source, lamps=()):
    environment = Environment.from_radiance(np.ones((4, 8, 3)), "even")
    panorama, ball = np.zeros((4, 8, 3), np.uint8), np.zeros((4, 4, 4), np.uint8)
    return OpenLight(source, environment, panorama, ball, environment, lamps=lamps)
