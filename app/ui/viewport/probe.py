"""The values of every picture and channel at one spot of the photo."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.engine.snapshot import Snapshot
from app.engine.sources import RelitLike
from app.ui.channels import CHANNELS, PHOTO, RESULT
from app.ui.viewport.panes import LIGHTS
from relight_core.face.parsing import CLASSES
from relight_core.imaging.view_transform import apply_view
from relight_core.pipeline.results.channel_view import channel_to_srgb
from relight_core.pipeline.results.layers import channel_at


@dataclass(frozen=True)
class Reading:
    """One row of the probe.

    Attributes:
        name: of app.ui.channels.CHANNELS.
        linear: one or three numbers as the channel is exported; none where the spot lies outside it.
        codes: what the screen shows, 0 to 255.
        word: instead of numbers, for parsing.
    """

    name: str
    linear: tuple[float, ...] = ()
    codes: tuple[int, ...] = ()
    word: str = ""


def readings(snapshot: Snapshot, exposure_ev: float, x: float, y: float) -> list[Reading]:
    """Every picture and channel at a spot of the photo, in the filmstrip's order; see `reading`."""
    found = (reading(snapshot, channel.name, exposure_ev, x, y) for channel in CHANNELS)
    return [row for row in found if row is not None]


def reading(snapshot: Snapshot, name: str, exposure_ev: float, x: float, y: float) -> Reading | None:
    """One picture or channel at a spot of the photo; None where there is no such picture yet, and for lights.

    Args:
        exposure_ev: of the result; only what the screen shows of it follows.
        x, y: in photo pixels, pixel i spanning i to i + 1.
    """
    if snapshot.opened is None or name in LIGHTS:
        return None
    if name == PHOTO:
        return _of_picture(PHOTO, snapshot.opened.photo.linear, x, y, 0.0)
    picture = snapshot.picture_in_sight
    if picture is None:
        return None
    if name == RESULT:
        return _of_result(snapshot, x, y, exposure_ev)
    return _of_channel(name, picture.relit, x, y) if name in picture.relit.channels else None


def _of_result(snapshot: Snapshot, x: float, y: float, exposure_ev: float) -> Reading:
    """The result at the photo's own size, whatever size is on the screen."""
    relit = snapshot.picture.relit
    if relit.full is None:
        scale = relit.image.shape[1] / snapshot.opened.photo.linear.shape[1]
        return _of_picture(RESULT, relit.image, x * scale, y * scale, exposure_ev)
    try:
        texel, _ = relit.full.pixel(math.floor(y), math.floor(x))
    except IndexError:
        return Reading(RESULT)
    return Reading(RESULT, _numbers(texel), _codes(apply_view(texel[None], exposure_ev)))


def _of_picture(name: str, linear: np.ndarray, x: float, y: float, exposure_ev: float) -> Reading:
    texel = _texel(linear, x, y)
    if texel is None:
        return Reading(name)
    return Reading(name, _numbers(texel), _codes(apply_view(texel[None], exposure_ev)))


def _of_channel(name: str, relit: RelitLike, x: float, y: float) -> Reading:
    """As the channel is exported, and as the screen shows it."""
    found = channel_at(relit, name, math.floor(x), math.floor(y))
    if found is None:
        return Reading(name)
    held, exported = found
    texel = np.asarray(held, np.int64 if name == "parsing" else np.float32)
    shown = _codes(channel_to_srgb(name, texel[None, None]))
    if name == "parsing":
        return Reading(name, codes=shown, word=CLASSES[min(max(int(held), 0), len(CLASSES) - 1)])
    return Reading(name, _numbers(exported), shown)


def _texel(image: np.ndarray, x: float, y: float) -> np.ndarray | None:
    column, row = math.floor(x), math.floor(y)
    inside = 0 <= row < image.shape[0] and 0 <= column < image.shape[1]
    return np.asarray(image[row, column]) if inside else None


def _numbers(texel: np.ndarray) -> tuple[float, ...]:
    return tuple(float(value) for value in np.atleast_1d(texel))


def _codes(srgb: np.ndarray) -> tuple[int, ...]:
    return tuple(int(round(float(value) * 255)) for value in np.clip(srgb, 0, 1).ravel()[:3])
