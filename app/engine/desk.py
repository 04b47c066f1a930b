"""The engine's work without its thread: from what is wanted and what is in force to the next slow step."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextvars import copy_context
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from app.engine.freed_memory import give_back_freed_memory
from app.engine.screen import (
    ball_for_screen,
    channels_for_screen,
    panorama_for_screen,
    radiance_for_screen,
    rig_for_screen,
)
from app.engine.snapshot import OpenLight, OpenPhoto, Picture, Snapshot
from app.engine.sources import (
    BORROWED_AT,
    LightSource,
    PhotoSource,
    RelighterLike,
    Request,
    base_light,
    borrowed_light,
)
from app.engine.tier_meter import TierMeter
from relight_core.errors import InputError, NoFaceError
from relight_core.face.find import FaceBox, find_faces_beyond_doubt
from relight_core.imaging.photo import Photo
from relight_core.imaging.read import read_photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.light_edit import LightEdit, edit_light
from relight_core.lighting.own_lamps import own_lamps
from relight_core.pipeline.edit import Edit

_OWN = LightSource("own")
_KEPT_LIGHTS = 3
"""Lights from files that stay open, for going back and forth; a large panorama takes tens of megabytes."""

_SMALL_PHOTO_PX = 6_000_000
"""Photos of no more pixels are always shown at their own size."""

_FINEST = "final"
"""At this quality lights are drawn finely even while the hand moves."""


@dataclass(frozen=True, eq=False)
class Step:
    """One slow piece of work.

    Attributes:
        activity: what the status line says meanwhile.
        run: does it, and returns the snapshot after it.
        give_up: what stays in force if it fails, such that the same step is not next again.
        is_superseded: whether a newer request makes it needless; it then stops where the library can stop, with
            everything as it was before. A step that is soon done goes on to its end.
    """

    activity: str
    run: Callable[[Snapshot], Snapshot]
    give_up: Callable[[Snapshot], Snapshot]
    is_superseded: Callable[[Request], bool] = lambda newer: False


class Desk:
    """Holds the Relighter and decides what to do next. Used by one thread only.

    Steps are short enough to look at the newest request between them, which is what makes only the newest
    count: a photo that was replaced while it was being decoded never reaches the networks. The search for faces, which
    is not short, is told while it runs.

    Args:
        make_relighter: called when the networks are first needed.
        calibration_path: where the costs of the quality tiers are kept; None neither measures nor keeps them.
    """

    def __init__(
        self,
        make_relighter: Callable[[], RelighterLike],
        calibration_path: Path | None = None,
    ) -> None:
        self._make_relighter = make_relighter
        self._relighter: RelighterLike | None = None
        # A photo that has been read and is not the portrait yet.
        self._loading: tuple[PhotoSource, Photo] | None = None
        # Whose photo is the Relighter's portrait; None while it is that of somebody who lent a light.
        self._portrait: OpenPhoto | None = None
        # The key of the picture that failed last, which is not tried again.
        self._failed: tuple | None = None
        # The portrait and the quality that the Relighter is ready to relight quickly.
        self._ready_for: tuple | None = None
        self._lights: dict[LightSource, OpenLight] = {}
        self._tiers = TierMeter(calibration_path)

    def next_step(self, request: Request, now: Snapshot) -> Step | None:
        """The next step toward the request, or None when what is in force answers it.

        In this order: the photo; the portrait again, after a light was borrowed from another; the light as it was
        asked for, then with what was changed about it; the picture; the outline; and what nobody waits for.
        """
        photo = None if request.photo in now.refused else request.photo
        light = None if request.light in now.refused else request.light
        if self._loading is not None and self._loading[0] is not photo:
            # Read for nothing: another photo is wanted by now, or it was refused.
            self._loading = None
        if photo is not None and photo is not _source(now.opened):
            is_read = self._loading is not None and self._loading[0] is photo
            if is_read and now.light is None and light is not None and light.kind == "rig":
                # Soon there, to be looked at while the networks load.
                return self._toward_light(request, light)
            return self._toward_photo(photo)
        if now.faces and self._portrait is not now.opened:
            return Step(f"Reading {now.opened.source.name}", self._return_to_portrait, _without_portrait)
        if light is not None and self._light_is_due(light, now):
            return self._toward_light(request, light)
        if light is not None and self._light_is_undrawn(request, now):
            draw = partial(self._draw_light, request.light_edit, _is_drafted(request))
            return Step("Drawing the light", draw, partial(_as_if_drawn, request.light_edit))
        if not now.faces or now.light is None:
            return None
        side_px = _longest_side_px(now.opened, request)
        key = _picture_key(now.opened, now.light, request.edit, side_px)
        if key != self._failed and (now.picture is None or key != _key_of(now.picture)):
            return Step(_relighting(now), partial(self._relight, request.edit, side_px), partial(self._skip, key))
        picture = now.picture
        if request.outlined and picture is not None and picture.outline is None and not picture.is_stale:
            return Step("Drawing the outline", _draw_outline, _without_outline)
        # Where there is no picture, nothing of it moves, and what failed once would only fail again.
        moving = None if key == self._failed else request.in_motion
        return self._when_the_hand_rests(moving, now)

    def _when_the_hand_rests(self, moving: Edit | None, now: Snapshot) -> Step | None:
        """What nobody waits for: the panels show it once it is known, or the hand finds it done."""
        if moving is not None and self._ready_for != (now.opened, moving.quality):
            return Step("Getting ready", partial(self._get_ready, moving), lambda now: now)
        if now.own_light is None and _OWN not in now.refused:
            return Step("Estimating the photo's own light", self._estimate_own_light, _refusing(_OWN))
        # In the dark every tier is quick, and none errs.
        if self._tiers.is_due and now.light.environment.level > 0:
            return Step("Measuring the quality tiers", self._measure_tier, self._tiers.give_up)
        return None

    def _get_ready(self, moving: Edit, now: Snapshot) -> Snapshot:
        self._ready_for = now.opened, moving.quality
        self._relighter.get_ready(now.light.environment, moving)
        return now

    def _measure_tier(self, now: Snapshot) -> Snapshot:
        self._tiers.measure_next(self._relighter, now.light.environment)
        return replace(now, tier_costs=self._tiers.costs())

    def _light_is_due(self, light: LightSource, now: Snapshot) -> bool:
        """Whether another light is in force; a photo's own that was set before is not due while it awaits a face."""
        if light.kind == "own":
            if light is now.awaited and not now.faces:
                return False
            return now.opened is not None and (now.light is None or now.light.source is not light)
        return light is not _source(now.light)

    def _light_is_undrawn(self, request: Request, now: Snapshot) -> bool:
        """Whether the light in force lacks what is changed about it, or is a draft while the hand rests."""
        light = now.light
        if light is None or not request.light.same_as(light.source):
            return False
        return light.edit != request.light_edit or (light.is_draft and not _is_drafted(request))

    def _draw_light(self, edit: LightEdit, draft: bool, now: Snapshot) -> Snapshot:
        environment = edit_light(now.light.base, edit, draft)
        # As bright as the base is shown, metered or not, so that a lamp that is added darkens nothing.
        base = edit_light(now.light.base, LightEdit(metered=edit.metered))
        gain = environment.level / base.level if base.level > 0 else 1.0
        panorama = panorama_for_screen(environment, gain)
        return replace(
            now,
            light=replace(now.light, environment=environment, panorama=panorama, edit=edit, is_draft=draft),
        )

    def _toward_photo(self, source: PhotoSource) -> Step:
        refuse, replaced = _refusing(source), partial(_is_of_another_photo, source)
        if self._loading is None or self._loading[0] is not source:
            return Step(f"Opening {source.name}", partial(self._read, source), refuse)
        if self._relighter is None:
            return Step("Loading the networks", self._load_networks, refuse, replaced)
        return Step(f"Reading the face in {source.name}", self._set_portrait, refuse, replaced)

    def _read(self, source: PhotoSource, now: Snapshot) -> Snapshot:
        photo = read_photo(source.place) if isinstance(source.place, Path) else source.place
        self._loading = (source, photo)
        if now.opened is not None:
            return now
        return replace(now, coming=OpenPhoto(source, photo, radiance_for_screen(photo.linear, photo.alpha)))

    def _load_networks(self, now: Snapshot) -> Snapshot:
        if self._loading is not None:
            # Importing torch keeps one core busy for a second; faces are found meanwhile, and remembered.
            seen = self._loading[1].above_black.seen
            # The context tells the search when another photo is wanted, whose own would else wait for it.
            look = partial(copy_context().run, find_faces_beyond_doubt, seen)
            threading.Thread(target=look, daemon=True).start()
        self._relighter = self._make_relighter()
        self._tiers.read()
        return now

    def _set_portrait(self, now: Snapshot) -> Snapshot:
        """Make the photo that has been read the portrait in force.

        It may be the one that was open already, with other boxes, strokes or another face chosen: then what the screen
        shows of it stays.
        """
        source, photo = self._loading
        self._loading = None
        seen = next((known for known in (now.coming, now.opened) if known is not None and known.photo is photo), None)
        is_same = seen is not None and seen is now.opened
        # Before the Relighter has the photo: what fails after that would leave the portrait in force another's.
        screen = seen.screen if seen else radiance_for_screen(photo.linear, photo.alpha)
        faces = self._faces_of(source, photo)
        self._tiers.begin_again()
        if not is_same:
            self._tiers.forget_photo()
            # Else they would keep the photo before, which may take hundreds of megabytes.
            self._ready_for = self._failed = None
        self._portrait = OpenPhoto(source, photo, screen)
        is_own = now.light is not None and now.light.source.kind == "own"
        # Where the last face was taken away there is nothing to estimate it anew from.
        light = None if is_own and (faces or not is_same) else now.light
        # A photo in which nobody is seen is no reason to give up what was set for those after it.
        awaited = now.light.source if is_own and light is None else now.awaited
        picture = _as_of_before(now, self._portrait) if faces else None
        now = replace(now, opened=self._portrait, coming=None, light=light, awaited=awaited, faces=faces)
        # Corrections of another photo, which nobody can wish for again, would keep that photo.
        refused = frozenset(wish for wish in now.refused if wish is not _OWN and not _keeps_another(wish, photo))
        return replace(now, own_light=None, picture=picture, refused=refused)

    def _faces_of(self, source: PhotoSource, photo: Photo) -> tuple[FaceBox, ...]:
        """Make a photo the portrait; everyone in it, or nobody, and then the portrait before stays."""
        try:
            wish = source.on(photo)
            self._relighter.set_portrait(photo, wish.face_index, wish.boxes, wish.strokes)
        except NoFaceError:
            return ()
        return tuple(self._relighter.people)

    def _return_to_portrait(self, now: Snapshot) -> Snapshot:
        photo = now.opened.photo
        wish = now.opened.source.on(photo)
        self._relighter.set_portrait(photo, wish.face_index, wish.boxes, wish.strokes)
        self._portrait = now.opened
        return now

    def _toward_light(self, request: Request, light: LightSource) -> Step:
        refuse = _refusing(light)
        if light.kind == "portrait" and self._relighter is None:
            return Step("Loading the networks", self._load_networks, refuse)
        words = "Borrowing the light of" if light.kind == "portrait" else "Reading the light"
        replaced = partial(_is_of_another_light, request)
        return Step(f"{words} {light.title}", partial(self._open_light, light), refuse, replaced)

    def _open_light(self, source: LightSource, now: Snapshot) -> Snapshot:
        if source.kind == "own" and now.own_light is not None:
            return replace(now, light=replace(now.own_light, source=source))
        if source.kind == "own" and not now.faces:
            raise InputError(f"{now.opened.source.name}: there is no face to tell its light by; draw a box over one")
        if source.kind == "rig":
            environment, panorama, ball = rig_for_screen(source.name)
            lamps = own_lamps(environment)
            return replace(now, light=OpenLight(source, environment, panorama, ball, environment, lamps=lamps))
        if source in self._lights:
            return replace(now, light=self._lights[source])
        light = _for_screen(source, self._environment(source))
        if source.kind == "own":
            return replace(now, light=light, own_light=light)
        self._lights = dict([*self._lights.items(), (source, light)][-_KEPT_LIGHTS:])
        return replace(now, light=light)

    def _estimate_own_light(self, now: Snapshot) -> Snapshot:
        now = replace(now, own_light=_for_screen(_OWN, self._environment(_OWN)))
        # The last that is computed once for a photo.
        give_back_freed_memory()
        return now

    def _environment(self, source: LightSource) -> Environment:
        return base_light(source, self._borrow, lambda: self._relighter.estimated_light(BORROWED_AT))

    def _borrow(self, portrait: Path) -> Environment:
        photo = read_photo(portrait)
        self._portrait = self._ready_for = None
        return borrowed_light(self._relighter, photo)

    def _skip(self, key: tuple, now: Snapshot) -> Snapshot:
        self._failed = key
        picture = now.picture_in_sight
        return now if picture is not None and not picture.is_stale else replace(now, picture=None)

    def _relight(self, edit: Edit, longest_side_px: int | None, now: Snapshot) -> Snapshot:
        edit = replace(edit, exposure_ev=0.0)
        relit = self._relighter.relight(now.light.environment, edit, longest_side_px, for_shader=True)
        screen = relit.recipe or radiance_for_screen(relit.image, relit.alpha)
        self._failed = None
        are_all = edit.channels is None and relit.channels
        channels = ({} if are_all else _former_channels(now)) | channels_for_screen(relit.channels)
        picture = Picture(now.opened, now.light, edit, longest_side_px, relit, screen, channels)
        self._tiers.observe(edit.quality, relit.stages)
        return replace(now, picture=picture, tier_costs=self._tiers.costs())


def _relighting(now: Snapshot) -> str:
    """What the status line says while it takes its time: each face of a group takes as long as one alone."""
    count = len(now.faces) if now.opened.source.face_index is None else 1
    return f"Relighting {count} faces" if count > 1 else "Relighting"


def _draw_outline(now: Snapshot) -> Snapshot:
    return replace(now, picture=replace(now.picture, outline=now.picture.relit.outline()))


def _without_outline(now: Snapshot) -> Snapshot:
    return replace(now, picture=replace(now.picture, outline=[]))


def _as_of_before(now: Snapshot, opened: OpenPhoto) -> Picture | None:
    """The picture in force; one of the same photo is to be looked at until its faces are relit anew."""
    picture = now.picture
    if picture is None or picture.opened.photo is not opened.photo:
        return picture
    return replace(picture, opened=opened, is_stale=True)


def _former_channels(now: Snapshot) -> dict:
    """What the last picture of the same portrait showed; stays until a channel is looked at again."""
    return now.picture_in_sight.channels if now.picture_in_sight is not None else {}


def _is_drafted(request: Request) -> bool:
    """Only while the hand moves: at rest a light is drawn finely, whichever quality was chosen."""
    is_quick = request.edit.channels is not None and request.edit.quality != _FINEST
    return is_quick and request.light_edit.changes_shape


def _as_if_drawn(edit: LightEdit, now: Snapshot) -> Snapshot:
    return replace(now, light=replace(now.light, edit=edit, is_draft=False))


def _refusing(source: PhotoSource | LightSource) -> Callable[[Snapshot], Snapshot]:
    def refuse(now: Snapshot) -> Snapshot:
        coming = None if now.coming is not None and now.coming.source is source else now.coming
        return replace(now, refused=now.refused | {source}, coming=coming)

    return refuse


def _keeps_another(wish: PhotoSource | LightSource, photo: Photo) -> bool:
    return isinstance(wish, PhotoSource) and isinstance(wish.place, Photo) and wish.place is not photo


def _is_of_another_photo(source: PhotoSource | None, newer: Request) -> bool:
    """Whether a newer request is for other pixels; corrections of the same ones can follow what is being done."""
    return source is not None and newer.photo is not None and newer.photo.place is not source.place


def _is_of_another_light(request: Request, newer: Request) -> bool:
    """Whether a newer request is for another light than an earlier one, or for another photo, which comes first."""
    is_other = newer.light is not None and newer.light is not request.light
    return is_other or _is_of_another_photo(request.photo, newer)


def _without_portrait(now: Snapshot) -> Snapshot:
    refused = now.refused | {now.opened.source}
    return replace(now, opened=None, picture=None, own_light=None, faces=(), refused=refused)


def _for_screen(source: LightSource, base: Environment) -> OpenLight:
    edit = source.opening_edit
    panorama, ball = panorama_for_screen(base), ball_for_screen(base)
    return OpenLight(source, edit_light(base, edit), panorama, ball, base, edit, lamps=own_lamps(base))


def _source(opened: OpenPhoto | OpenLight | None) -> PhotoSource | LightSource | None:
    return opened.source if opened else None


def _longest_side_px(opened: OpenPhoto, request: Request) -> int | None:
    """How small the picture may be: of a photo that is small itself it is always as large as that."""
    height, width = opened.photo.linear.shape[:2]
    return request.longest_side_px if height * width > _SMALL_PHOTO_PX else None


def _picture_key(opened: OpenPhoto, light: OpenLight, edit: Edit, longest_side_px: int | None) -> tuple:
    return opened, light, replace(edit, exposure_ev=0.0), longest_side_px


def _key_of(picture: Picture) -> tuple | None:
    if picture.is_stale:
        return None
    return _picture_key(picture.opened, picture.light, picture.edit, picture.longest_side_px)
