"""A light as the user has changed it: level, colour and blur of a base light, and soft boxes added to it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.colour_temperature import WHITE_KELVIN, kelvin_to_rgb
from relight_core.lighting.enlarge import draw_finer
from relight_core.lighting.environment import Environment
from relight_core.lighting.light_blur import LARGEST_BLUR_DEG, blur_light
from relight_core.lighting.own_lamps import room_of
from relight_core.lighting.panorama import mean_luminance, shrink
from relight_core.lighting.soft_box import SOFT_BOX_RANGES, SoftBox, soft_box_radiance
from relight_core.lighting.summary import meter_reading, metered_level_ev

MOST_BOXES = 16
MOST_LEVEL_EV = 10.0
LIGHT_EDIT_RANGES = {
    "level_ev": (-MOST_LEVEL_EV, MOST_LEVEL_EV),
    "base": (0.0, 2.0),
    "saturation": (0.0, 2.0),
    "warmth": (-1.0, 1.0),
    "tint": (-1.0, 1.0),
    "blur_deg": (0.0, LARGEST_BLUR_DEG),
}
DRAWN_HEIGHT = 256
"""Rows that soft boxes are drawn with: enough for edges that the networks' light, of 16 rows, can't resolve."""

DRAFT_HEIGHT = 64
"""Rows that are enough while the user drags something."""

_TINT_STOPS = 0.7
"""Stops that red and blue gain on green at a tint of 1."""


@dataclass(frozen=True)
class LightEdit:
    """What the user changed about a light; the defaults change nothing.

    Attributes:
        level_ev: stops, [-10, 10], over the whole light.
        base: how much of the light stays beneath the soft boxes, [0, 2]; 0 leaves only them.
        saturation: [0, 2]; 0 is grey.
        warmth: [-1, 1]: 1 makes daylight look like a 2800 K lamp, -1 like 11200 K.
        tint: [-1, 1], from green to magenta.
        blur_deg: standard deviation of the blur, [0, 90].
        boxes: soft boxes, at most 16 in the editor; colour, blur and base don't affect them.
        metered: the base light is brought to the level that suits a photo, whatever its file's units.
        apart: the light's own lamps are removed from it, and only the room remains beneath the boxes (see
            `taken_apart`). Has no effect on a light without lamps.
    """

    level_ev: float = 0.0
    base: float = 1.0
    saturation: float = 1.0
    warmth: float = 0.0
    tint: float = 0.0
    blur_deg: float = 0.0
    boxes: tuple[SoftBox, ...] = ()
    metered: bool = False
    apart: bool = False

    @property
    def added_boxes(self) -> tuple[SoftBox, ...]:
        """The soft boxes that the user added: those that did not come from the light's own lamps."""
        return tuple(box for box in self.boxes if not box.name)

    @property
    def added(self) -> LightEdit:
        """The part of the edit that makes sense for any light: the added soft boxes and, if there are any, `base`."""
        boxes = self.added_boxes
        return LightEdit(base=self.base if boxes else 1.0, boxes=boxes)

    @property
    def changes_shape(self) -> bool:
        """Whether more than the level is changed."""
        return replace(self, level_ev=0.0, metered=False) != LightEdit()


def edit_light(light: Environment, edit: LightEdit, draft: bool = False) -> Environment:
    """The light with the edit applied.

    Colour and blur keep the mean luminance of the base; a soft box of intensity 1 lights a card that faces it
    as brightly as the unedited light does a face on its brightest side (`summary.meter_reading`).

    Args:
        light: the base.
        edit: what to change.
        draft: draw with fewer rows, in a fraction of the time.

    Returns:
        `light` itself if nothing changes.

    Raises:
        InputError: a setting out of its range, of the light or of a soft box.
    """
    _check_ranges("light", edit, LIGHT_EDIT_RANGES)
    for box in edit.boxes:
        _check_ranges("soft box", box, SOFT_BOX_RANGES)
    stops = edit.level_ev + (metered_level_ev(light) if edit.metered else 0.0)
    if edit.changes_shape:
        height = DRAFT_HEIGHT if draft else max(DRAWN_HEIGHT, light.height)
        radiance = _coloured(_beneath(light, edit.apart, height), edit)
        parts = [blur_light(radiance, edit.blur_deg) * np.float32(edit.base)]
        # A box without light would add nothing, but make a coarse map be upsampled.
        if boxes := tuple(box for box in edit.boxes if box.intensity > 0 and not box.off):
            parts.append(_drawn(boxes, meter_reading(light), draft))
        level = light.level or 1.0
        larger = max(len(part) for part in parts)
        edited = Environment.of_parts(sum(draw_finer(part, larger) for part in parts), parts, light.name)
        light = edited.at_level(edited.level * level)
    return light if stops == 0.0 else light.at_level(light.level * 2.0**stops)


def _check_ranges(what: str, settings: LightEdit | SoftBox, ranges: dict[str, tuple[float, float]]) -> None:
    for name, (low, high) in ranges.items():
        if not low <= getattr(settings, name) <= high:
            raise InputError(f"a {what}'s {name} is from {low:g} to {high:g}, not {getattr(settings, name)}")


def taken_apart(edit: LightEdit, own: tuple[SoftBox, ...]) -> LightEdit:
    """The same light with its own lamps as soft boxes, listed before the added ones, over the room that remains.

    `edit.base` scales each lamp as it scaled the light. Saturation, warmth, tint and blur don't affect soft boxes, so
    they now act on the room alone.

    Args:
        own: the lamps of the base (`own_lamps.own_lamps`).
    """
    lamps = tuple(replace(lamp, intensity=lamp.intensity * edit.base) for lamp in own)
    return replace(edit, boxes=(*lamps, *edit.added_boxes), apart=True)


def put_together(edit: LightEdit) -> LightEdit:
    """The reverse of `taken_apart`: the light in one piece, with the boxes that were added to it.

    Without added boxes `base` becomes 1: if the room had been darkened to 0 beneath the lamps, nothing would be lit.
    """
    added = edit.added
    return replace(edit, boxes=added.boxes, base=added.base, apart=False)


def _beneath(light: Environment, apart: bool, height: int) -> np.ndarray:
    """The light's shape or, if taken apart, its room, (h, 2h, 3) with at most `height` rows; cached for all edits."""

    def find(shape: np.ndarray) -> np.ndarray:
        room = room_of(light) if apart else None
        whole = shape if room is None else room
        return shrink(whole, height) if len(whole) > height else whole

    return light.of_shape(("beneath an edit", apart, height), find)


def _coloured(shape: np.ndarray, edit: LightEdit) -> np.ndarray:
    """A map with saturation, warmth and tint applied; its mean luminance is kept."""
    if (edit.saturation, edit.warmth, edit.tint) == (1.0, 0.0, 0.0):
        return shape
    before = mean_luminance(shape)
    grey = (shape @ REC709_LUMINANCE.astype(np.float32))[..., None]
    mixed = np.maximum(grey + np.float32(edit.saturation) * (shape - grey), 0.0)
    mixed *= grey / np.maximum((mixed @ REC709_LUMINANCE.astype(np.float32))[..., None], np.float32(1e-20))
    mixed *= colour_gain(edit.warmth, edit.tint).astype(np.float32)
    after = mean_luminance(mixed)
    return mixed * np.float32(before / after if after > 0 else 1.0)


def colour_gain(warmth: float, tint: float) -> np.ndarray:
    """(3,) gains of luminance 1 that warm or cool a white light and push it to green or magenta."""
    warm = kelvin_to_rgb(WHITE_KELVIN * 2.0**-warmth)
    gain = warm * np.exp2(_TINT_STOPS * tint * np.array([0.5, -0.5, 0.5]))
    return gain / (gain @ REC709_LUMINANCE)


def _drawn(boxes: tuple[SoftBox, ...], unit: float, draft: bool) -> np.ndarray:
    """The soft boxes on a black panorama; `unit` is the luminance of an intensity of 1, where 0 counts as 1."""
    height = DRAFT_HEIGHT if draft else DRAWN_HEIGHT
    return sum(soft_box_radiance(box, height, unit or 1.0) for box in boxes)
