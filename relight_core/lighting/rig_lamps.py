"""The lamps of a bundled light as soft boxes, to be moved, resized and coloured like any other."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.rig_description import AreaLight
from relight_core.lighting.rigs import load_rig, read_bundled_rig
from relight_core.lighting.soft_box import SoftBox
from relight_core.lighting.summary import meter_reading


def has_lamps(name: str) -> bool:
    """Whether a bundled rig has lamps that could be moved; a sky alone has none.

    Raises:
        InputError: no rig of that name.
    """
    return any(not lamp.backdrop for lamp in _description(name).area_lights)


_description = lru_cache(maxsize=32)(read_bundled_rig)


def apart(name: str, edit: LightEdit) -> LightEdit:
    """The same light with the rig's lamps as soft boxes before the user's own, and only the room beneath them.

    What `edit.base` leaves of the light it leaves of each lamp. Saturation, warmth, tint and blur touch no soft box:
    from now on they act on the room alone.

    Raises:
        InputError: no rig of that name.
    """
    light = load_rig(name)
    unit = light.level * meter_reading(light)
    lamps = [lamp for lamp in _description(name).area_lights if not lamp.backdrop]
    own = tuple(_as_box(lamp, edit.base / unit) for lamp in lamps)
    return replace(edit, boxes=(*own, *edit.added_boxes), apart=True)


def together(edit: LightEdit) -> LightEdit:
    """The light as it was drawn, with what the user added; the reverse of `apart`."""
    return replace(edit, boxes=edit.added_boxes, apart=False)


def _as_box(lamp: AreaLight, gain: float) -> SoftBox:
    """A lamp as a box, whose intensity is that of the lamp times `gain`."""
    colour = None if lamp.kelvin is not None else lamp.colour
    box = SoftBox(
        azimuth_deg=lamp.azimuth_deg,
        elevation_deg=lamp.elevation_deg,
        width_deg=lamp.width_deg,
        height_deg=lamp.height_deg,
        softness=lamp.softness,
        colour=colour,
        intensity=float(np.dot(lamp.colour, REC709_LUMINANCE)) * lamp.intensity * gain,
        form=lamp.form,
        hole=lamp.hole_deg / lamp.width_deg,
        name=lamp.name or "lamp",
    )
    return box if lamp.kelvin is None else replace(box, kelvin=lamp.kelvin)
