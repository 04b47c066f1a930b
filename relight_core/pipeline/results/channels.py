"""The channels as a viewer gets them: arrays at the view's size, whatever size the networks worked at."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
import torch

from relight_core.face.crop import axes_in_photo
from relight_core.face.parsing import BROWS, EYES, INDEX, MOUTH, SKIN, SURELY, skin_share
from relight_core.imaging.colour import without_colour
from relight_core.imaging.guided_detail import carry_detail
from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.light_change import LightChange
from relight_core.imaging.resampling import resize_area, resize_smooth
from relight_core.imaging.tensor_colour import grey
from relight_core.imaging.tensor_images import as_image, enlarge, resized
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.imaging.tone import Tone
from relight_core.imaging.view_of_photo import Materials, ViewOfPhoto
from relight_core.pipeline.edit import LIGHT_CHANNELS, SURFACE_CHANNELS
from relight_core.pipeline.per_light.fine_edges import FineEdges
from relight_core.pipeline.per_light.hints import Effects, as_channels
from relight_core.pipeline.per_light.sliders import SliderChange
from relight_core.pipeline.stages import Surface

_PATTERNED = [INDEX[name] for name in (*EYES, *BROWS, *MOUTH, "hair", "hat", "glasses", "cloth")]
"""Labels of what gets its contrast from colour rather than from shading."""

_SKIN, _EYES, _MOUTH, _WORN = (
    [INDEX[name] for name in names] for names in (SKIN, EYES, MOUTH, (*BROWS, "hair", "hat", "cloth"))
)

_SMOOTH = [INDEX[name] for name in (*EYES, "inner_mouth", "glasses")]
"""Labels of what mirrors light whatever its own colour."""

BRIGHTEST_CHANGE = 1e20
"""No gain or offset is larger."""

_NO_TONE = 1e-4
"""A photo that is as dark shows no tone."""


@dataclass(frozen=True, eq=False)
class ViewChange:
    """What a light makes of a photo's view, to be applied at any resolution: gain * photo + offset.

    Attributes:
        gain, offset: (S, S, 3) float32, >= 0, at the light's level and the sliders' gains.
        level: of the light.
    """

    gain: np.ndarray
    offset: np.ndarray
    level: float

    def apply(self, photo: np.ndarray) -> np.ndarray:
        """The view (T, T, 3), linear, relit; any T."""
        size = photo.shape[:2]
        return resize_smooth(self.gain, size) * photo + resize_smooth(self.offset, size)

    def of_photo_times(self, exposure: float) -> ViewChange:
        """The change of a photo, given as that of the photo times an exposure."""
        if exposure == 1.0:
            return self
        return replace(self, gain=np.minimum(self.gain * np.float32(exposure), np.float32(BRIGHTEST_CHANGE)))

    def toned(self, photo: np.ndarray, tone: Tone | None = None) -> ViewChange:
        """The change for a photo without colour: the light's act by their luminance, and what it adds has its tone.

        Args:
            photo: (T, T, 3) linear, the view, black and white or toned; any T.
            tone: that the photo has at each brightness; None for one at all of them.
        """
        photo = photo if photo.shape == self.gain.shape else resize_area(photo, self.gain.shape[:2])
        grey = without_colour(photo)
        own = np.where(grey > _NO_TONE, photo / np.maximum(grey, _NO_TONE), 1)
        gain, offset = without_colour(self.gain), without_colour(self.offset)
        if tone is not None:
            turned = tone.turned(grey[..., 0], (gain * grey + offset)[..., 0])
            gain, offset = gain * turned, offset * turned
        return replace(self, gain=gain, offset=offset * own)


def at_level(change: np.ndarray, level: float) -> np.ndarray:
    """A gain or offset of any shape at a light's level, [0, 1e20]: infinity times a black pixel would be no number."""
    with np.errstate(over="ignore"):
        return np.clip(change * np.float32(level), 0, np.float32(BRIGHTEST_CHANGE))


def upsampler_for(photo_view: np.ndarray, photo_small: np.ndarray, surface: Surface) -> JointUpsampler:
    """What carries a light's change from the networks' size to (about) the view's.

    Args:
        photo_view: (S, S, 3) linear, the view as the networks see it.
        photo_small: (s, s, 3), the same at their size, which is the surface's.
        surface: says what is bare skin.
    """
    size = photo_small.shape[0]
    factor = max(photo_view.shape[0] // size, 1)
    lattice = (factor * size, factor * size)
    large = photo_view if photo_view.shape[:2] == lattice else resize_area(photo_view, lattice)
    return JointUpsampler(photo_small, large, skin_share(surface.parsing)[0, 0].float().cpu().numpy())


def view_as_seen(photo_small: np.ndarray, surface: Surface) -> ViewOfPhoto:
    """A photo's view at the networks' size (s, s, 3), linear, with the materials in it."""
    return ViewOfPhoto(photo_small, materials_of(as_image(surface.parsing)), SURELY)


def fit_view(view: ViewOfPhoto, reflected: torch.Tensor, effects: Effects, relit: torch.Tensor) -> LightChange:
    """The composed view (1, 3, s, s) as gain and offset of the photo's, normalised light."""
    gloss = effects.specular * reflected[:, 3:] / grey(reflected[:, 3:]).clamp_min(1e-6)
    return view.change_to(as_image(relit), as_image(gloss))


def materials_of(parsing: np.ndarray) -> Materials:
    """The masks of a view of parsing probabilities (s, s, classes)."""
    kinds = _PATTERNED, _SMOOTH, _SKIN, _EYES, _MOUTH, _WORN
    patterned, smooth, skin, eyes, mouth, worn = (parsing[..., labels].sum(-1) for labels in kinds)
    return Materials(patterned, eyes + mouth, 1 - smooth, skin, mouth, worn)


def enlarge_change(
    change: LightChange,
    moved: SliderChange | None,
    upsample: JointUpsampler,
    level: float,
    edges: np.ndarray | None = None,
) -> ViewChange:
    """The change at the view's size, after the sliders and at the light's level.

    Args:
        edges: (S, S, 3) by what to multiply the picture at that size, see `fine_edges.FineEdges.gain`.
    """
    gain, offset = change.gain, change.offset
    if moved is not None:
        gain, offset = change.moved(as_image(moved.kept), as_image(moved.added), as_image(moved.lifted))
    gain, offset = upsample.change(gain, offset, None if moved is None else change.gain)
    if edges is not None:
        gain, offset = gain * edges, offset * edges
    return ViewChange(at_level(gain, level), at_level(offset, level), level)


def surface_channels_of(surface: Surface) -> tuple[str, ...]:
    """Those of SURFACE_CHANNELS that there are: "foreign_shadow" is there where such shadows are."""
    return tuple(name for name in SURFACE_CHANNELS if name != "foreign_shadow" or surface.foreign_shadow is not None)


def surface_channel(name: str, surface: Surface, photo_view: np.ndarray, photo_small: np.ndarray) -> np.ndarray:
    """One of SURFACE_CHANNELS, which no light changes.

    Args:
        photo_view: (S, S, 3) linear, the view at the size of the channels; as the networks see it, but for "photo".
        photo_small: (s, s, 3) linear, the view as the networks saw it.
    """
    size = photo_view.shape[0]
    if name == "photo":
        return photo_view
    if name == "albedo":
        return np.clip(carry_detail(np.clip(photo_view, 0, 1), photo_small, as_image(surface.albedo)), 0, 1)
    if name == "normal":
        return as_image(unit_normals(enlarge(surface.normal, size)))
    if name == "foreign_shadow":
        return as_image(1 - resized(surface.foreign_shadow, size).exp())
    # NumPy: torch takes three times as long over the first axis.
    return enlarge(surface.parsing, size)[0].cpu().numpy().argmax(0).astype(np.int32)


def surface_channels(surface: Surface, photo_view: np.ndarray, photo_small: np.ndarray) -> dict[str, np.ndarray]:
    """Those of SURFACE_CHANNELS that there are; arguments as in `surface_channel`."""
    names = surface_channels_of(surface)
    return {name: surface_channel(name, surface, photo_view, photo_small) for name in names}


def of_person(channel: np.ndarray, surface: Surface) -> np.ndarray:
    """A channel (S, S, C) times how much of each pixel is person.

    Behind the person the networks see no surface, and what they say there is no part of the picture.
    """
    return channel * as_image(enlarge(surface.person, channel.shape[0]))[..., None]


def effect_channels(effects: Effects, size: int, edges: FineEdges | None = None) -> dict[str, np.ndarray]:
    """The channels "specular" and "shadow", (size, size) float32 >= 0, in units of the normalised light.

    Args:
        edges: the finer edges of small lamps' shadows, where there are any.
    """
    shown = as_channels(effects)
    specular, shadow = (as_image(enlarge(effect, size)) for effect in (shown.specular, shown.shadow))
    if edges is not None:
        shadow = np.maximum(shadow + resize_smooth(edges.more_shadow(), (size, size)), 0)
    return {"specular": specular, "shadow": shadow}


def light_channels(
    effects: Mapping[str, np.ndarray],
    change: ViewChange,
    photo_view: np.ndarray,
    names: Collection[str] = LIGHT_CHANNELS,
) -> dict[str, np.ndarray]:
    """What a light makes, as far as it is named: "specular", "shadow" and "composition", at the light's level.

    Args:
        effects: of `effect_channels`.
    """
    level = np.float32(change.level)
    channels = {name: effect * level for name, effect in effects.items() if name in names}
    if "composition" in names:
        channels["composition"] = change.apply(photo_view)
    return channels


def unrolled(normals: np.ndarray, roll_deg: float) -> np.ndarray:
    """Normals (..., 3) of a view that is turned counterclockwise in the photo, in camera space."""
    turn = np.eye(3)
    turn[:2, :2] = axes_in_photo(roll_deg).T  # Normals point up where they are positive, photos go down.
    return normals if roll_deg == 0 else (normals @ turn).astype(normals.dtype)
