"""What the panels show, as textures: implements app.ui.pictures.Pictures with OpenGL."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import glfw
import moderngl
import numpy as np

from app.engine.light_shelf import LightShelf
from app.engine.snapshot import Snapshot
from app.engine.sources import LightSource
from app.ui.channels import PHOTO, RESULT
from app.ui.pictures import Paint, Shown
from app.ui.viewport.panes import Pane
from app.window.damage import WHOLE, Part
from app.window.gl_light_ball import LightBall
from app.window.gl_recipe import RelitSlot
from app.window.gl_scopes import Scopes, is_same_reading
from app.window.gl_textures import Canvas, PictureSlot, TextureSlot
from app.window.gl_viewport import (
    PicturePainter,
    coarseness,
    coarser,
    covered,
    covered_pixels,
    draws_in_software,
    gains_by_supersampling,
)
from app.window.supersampling import MOST_SUPERSAMPLED_PIXELS, SupersamplingDelay
from relight_core.imaging.scopes import Extremes
from relight_core.lighting.environment import Environment

_LAG_S, _BUSY_LAG_S = 0.5, 2.0
"""How far scopes and thumbnails may be behind while a hand moves something, and in frames that have a new picture or
another of them to draw already: each takes time from the picture, so there is one in a frame where that can be."""


class _Viewport(NamedTuple):
    """All that a viewport's canvas depends on.

    Attributes:
        size: width and height in pixels.
        exposures_ev: of each pane's picture.
        versions: of the photo and of each pane's picture, as of `GlPictures._versions`.
    """

    size: tuple[int, int]
    panes: tuple[Pane, ...]
    paint: Paint
    exposures_ev: tuple[float, ...]
    versions: tuple[int, ...]


class _Thumbnail(NamedTuple):
    """All that a thumbnail's canvas depends on: width and height in pixels, its picture's exposure and version."""

    size: tuple[int, int]
    exposure_ev: float
    version: int


class GlPictures:
    """Textures of the engine's newest snapshot, the viewport, and the thumbnails.

    Args:
        context: the window's; current whenever a method is called.
        shelf: where the bundled lights' thumbnails come from.
        canvas_srgb: the colour around the picture.

    Attributes:
        exposure_ev: at which the result is shown.
        hurried: a hand is moving something, so that what is only read may lag a little behind.
        is_ahead: the viewport has been drawn for the next frame.
    """

    def __init__(self, context: moderngl.Context, shelf: LightShelf, canvas_srgb: tuple[float, float, float]) -> None:
        self.exposure_ev, self.hurried, self._busy = 0.0, False, False
        self._context = context
        self._shelf = shelf
        self._painter = PicturePainter(context, canvas_srgb)
        self._slots = {PHOTO: PictureSlot(context), RESULT: RelitSlot(context)}
        self._balls: dict[tuple[str, str], TextureSlot] = {}
        self._panorama = TextureSlot(context, repeat_x=True)
        self._viewport, self._coarse_viewport = Canvas(context, smooth=False, opaque=True), Canvas(context, opaque=True)
        self._seen = self._viewport
        self._in_software, self._supersampling = draws_in_software(context), SupersamplingDelay()
        self._flush = ctypes.CFUNCTYPE(None)(glfw.get_proc_address("glFlush"))
        self._thumbnails = {name: Canvas(context) for name in (PHOTO, RESULT)}
        self._scopes = Scopes(context)
        self._light_ball = LightBall(context)
        self._read: tuple[str, tuple[np.ndarray, float]] | None = None
        self._followed_s: dict[str, float] = {}
        self._environment: Environment | None = None
        self._drawn: dict[str, _Viewport | _Thumbnail] = {}
        self._versions: dict[str, int] = {}
        self._ahead: Callable[[], None] | None = None
        self.is_ahead = False

    def begin_frame(self, exposure_ev: float, hurried: bool) -> None:
        """What is shown from now on is one frame; before `update`."""
        self._ahead, self.is_ahead = None, False
        self._busy = exposure_ev != self.exposure_ev
        self.exposure_ev, self.hurried = exposure_ev, hurried

    def update(self, snapshot: Snapshot) -> None:
        """Upload what the snapshot holds that is not there yet."""
        light, picture = snapshot.light, snapshot.picture_in_sight
        seen = snapshot.opened or snapshot.coming
        self._show(PHOTO, seen.screen if seen else None)
        self._show(RESULT, picture.screen if picture else None, passing=bool(picture) and picture.is_passing)
        # The channel called photo is the face's crop; here the name means the whole photo.
        channels = {name: codes for name, codes in picture.channels.items() if name != PHOTO} if picture else {}
        for name in self._slots.keys() - {PHOTO, RESULT} | channels.keys():
            self._slots.setdefault(name, TextureSlot(self._context))
            self._show(name, channels.get(name))
        self._panorama.show(light.panorama if light else None)
        self._environment = light.environment if light else None
        for known in (light, snapshot.own_light):
            if known is not None and known.source.kind != "rig":
                self._ball_slot(known.source).show(known.ball)

    def size(self, name: str) -> tuple[int, int] | None:
        """Width and height of a picture or channel; None while there is none."""
        slot = self._slots.get(name)
        return slot.size if slot else None

    def thumbnail(self, name: str, side_px: int) -> Shown | None:
        """A picture or channel, ready to look at, no more than `side_px` high and wide where it has to be drawn."""
        size = self.size(name)
        if size is None:
            return None
        if name not in self._thumbnails:
            return _shown(self._slots[name].texture)
        scale = min(1.0, side_px / max(size))
        small = (max(1, round(size[0] * scale)), max(1, round(size[1] * scale)))
        canvas, key = self._thumbnails[name], f"thumbnail {name}"
        wanted = _Thumbnail(small, self._exposure_of(name), self._versions[name])
        if not self._may_lag(key) and self._is_due(key, canvas, wanted):
            self._painter.thumbnail(canvas, self._slots, name, scale, self.exposure_ev)
            self._follows_now(key)
        return _shown(canvas.texture)

    def viewport(self, panes: Sequence[Pane], size: tuple[int, int], paint: Paint) -> Shown:
        """The viewport, `size` pixels large, with the panes' pictures; drawn now if anything changed.

        In a hurry, where the processor draws, a new picture at the same place is left to `draw_ahead`.
        """
        panes, key, canvas = tuple(pane for pane in panes if self.size(pane.name)), "viewport", self._viewport
        exposures = tuple(self._exposure_of(pane.name) for pane in panes)
        # A difference reads the photo too.
        versions = tuple(self._versions.get(name, 0) for name in (PHOTO, *(pane.name for pane in panes)))
        paint = replace(paint, supersampled=self._is_supersampled(panes, size, paint, exposures, versions))
        if self.hurried and self._in_software:
            key, canvas = "coarse viewport", self._coarse_viewport
            panes, size, paint = coarser(panes, size, paint, coarseness(panes, size))
        self._seen = canvas
        drawn, wanted = self._drawn.get(key), _Viewport(size, panes, paint, exposures, versions)
        part = _changing_part(drawn, wanted)
        may_wait = canvas is self._coarse_viewport and _differs_in_versions_alone(drawn, wanted)
        if self._is_due(key, canvas, wanted):
            draw = partial(self._painter.panes, canvas, panes, self._slots, paint, self.exposure_ev, part)
            if may_wait:
                # Until `draw_ahead` has drawn it the canvas shows what it did.
                self._ahead, self._drawn[key] = partial(self._draw_viewport, draw, key, wanted), drawn
            else:
                draw()
        return _shown(canvas.texture)

    def _is_supersampled(self, panes: tuple[Pane, ...], size: tuple[int, int], *look: object) -> bool:
        """Whether the viewport is supersampled in this frame; never while a hand moves something.

        Args:
            look: whatever else decides what the viewport looks like.
        """
        gains = not self.hurried and any(gains_by_supersampling(pane, self._slots) for pane in panes)
        if not self._in_software:
            return gains
        fits = covered_pixels(panes, size) <= MOST_SUPERSAMPLED_PIXELS
        return self._supersampling.is_over((panes, size, look, self.hurried), gains and fits)

    @property
    def is_unfinished(self) -> bool:
        """Whether the viewport will be supersampled if some more frames ask for the same."""
        return self._supersampling.is_pending

    def draw_ahead(self) -> bool:
        """After a frame was shown: draw the viewport for the next one, if it is another; whether it is.

        The processor draws it while the window's thread waits for the display. In one frame with the panels it would
        take longer than the display's step.
        """
        if self._ahead is not None:
            self._ahead()
            self._ahead, self.is_ahead = None, True
            self._flush()
        return self.is_ahead

    def _draw_viewport(self, draw: Callable[[], None], key: str, drawn: _Viewport) -> None:
        draw()
        self._drawn[key] = drawn

    def viewport_pixels(self) -> np.ndarray:
        """(h, w, 3) uint8 sRGB of the viewport as drawn last, row 0 at its top."""
        return self._seen.pixels()

    def colours(self, kind: str) -> Shown:
        """The colours of "scale" (false colour) or "difference", from the least to the most."""
        return _shown(self._painter.colours[kind].texture)

    def scope(self, kind: str, name: str) -> Shown | None:
        """The "histogram" or "waveform" of a picture or channel; computed now if it is another one."""
        if self.size(name) is None:
            return None
        return _shown(self._scopes.scope(kind, *self._readable(name)))

    def extremes(self, name: str) -> Extremes | None:
        """How much of the photo or the result the screen can't show; None for a channel."""
        if name not in (PHOTO, RESULT) or self.size(name) is None:
            return None
        known, is_other = self._scopes.found, self._read is None or self._read[0] != name
        if known is not None and not is_other and self._may_lag("extremes"):
            return known
        found = self._scopes.extremes(*self._readable(name))
        if found is not known:
            self._follows_now("extremes")
        return found

    def _readable(self, name: str) -> tuple[np.ndarray, float]:
        """A picture's pixels and exposure for the scopes; in a hurry those of the one before, for a moment."""
        is_other = self._read is None or self._read[0] != name
        if is_other or not self._may_lag("scopes"):
            # A recipe's pixels are computed when they are asked for.
            slot = self._slots[name]
            wanted = slot.glimpse if self.hurried else slot.array, self._exposure_of(name)
            if is_other or not is_same_reading(self._read[1], *wanted):
                self._read = name, wanted
                self._follows_now("scopes")
        return self._read[1]

    def _may_lag(self, key: str) -> bool:
        """Whether something follows the picture so closely that, in a hurry, it need not be brought up to date."""
        followed_s = self._followed_s.get(key)
        if not self.hurried or followed_s is None:
            return False
        behind_s = time.monotonic() - followed_s
        return behind_s < (_BUSY_LAG_S if self._busy else _LAG_S)

    def _follows_now(self, key: str) -> None:
        self._followed_s[key], self._busy = time.monotonic(), True

    def _show(self, name: str, content: object, **how: bool) -> None:
        changed = self._slots[name].show(content, **how)
        self._busy |= changed
        self._versions[name] = self._versions.get(name, 0) + changed

    def panorama(self) -> Shown | None:
        """The light in force; repeats sideways."""
        return _shown(self._panorama.texture)

    def ball(self, light: LightSource) -> Shown | None:
        """A ball lit by a light, as far as it has been drawn yet."""
        slot = self._ball_slot(light)
        if light.kind == "rig" or slot.texture is None:
            slot.show(self._shelf.ball(light))
        return _shown(slot.texture)

    def light_ball(self, side: int, yaw_deg: float) -> Shown | None:
        """A ball in the light in force, turned, `side` pixels large; None while there is no light."""
        return _shown(self._light_ball.texture(self._environment, side, yaw_deg))

    def close(self) -> None:
        """Free everything."""
        slots = [*self._slots.values(), *self._balls.values(), self._panorama]
        canvases = [self._viewport, self._coarse_viewport, *self._thumbnails.values()]
        for item in [*slots, *canvases, self._scopes, self._light_ball, self._painter]:
            item.close()

    def _ball_slot(self, light: LightSource) -> TextureSlot:
        return self._balls.setdefault((light.kind, light.name), TextureSlot(self._context))

    def _exposure_of(self, name: str) -> float:
        return self.exposure_ev if name == RESULT else 0.0

    def _is_due(self, key: str, canvas: Canvas, wanted: _Viewport | _Thumbnail) -> bool:
        """Fit a canvas to what is wanted on it and note that; whether it must be drawn to show that."""
        same = not canvas.fit(wanted.size) and self._drawn.get(key) == wanted
        self._drawn[key] = wanted
        return not same


def _changing_part(drawn: _Viewport | None, wanted: _Viewport) -> Part:
    """What of the viewport can look other than before: where its pictures lie, if they lay there before."""
    size, panes = wanted.size, wanted.panes
    if drawn is None or drawn.size != size or drawn.panes != panes or not panes:
        return WHOLE
    x0, y0, x1, y1 = zip(*(covered(pane, size) for pane in panes), strict=True)
    return min(x0) / size[0], min(y0) / size[1], max(x1) / size[0], max(y1) / size[1]


def _differs_in_versions_alone(drawn: _Viewport | None, wanted: _Viewport) -> bool:
    """Whether a viewport has all but the versions of its pictures in common with the one before."""
    return drawn is not None and drawn._replace(versions=wanted.versions) == wanted


def _shown(texture: moderngl.Texture | None) -> Shown | None:
    return Shown(texture.glo, *texture.size) if texture else None
