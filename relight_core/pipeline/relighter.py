"""The Relighter: a portrait is set once, slowly, and relit many times, quickly."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
import torch

from relight_core.errors import InputError, NoFaceError
from relight_core.face.find import FaceBox
from relight_core.imaging.colour import without_colour
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.lamps import lamps_of
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import load_bundle
from relight_core.pipeline.cache import Record, StageCache
from relight_core.pipeline.company import Company
from relight_core.pipeline.edit import Edit, check_edit
from relight_core.pipeline.face_relighter import KEPT_LIGHTS, FaceRelighter
from relight_core.pipeline.face_search import FaceSearch
from relight_core.pipeline.face_taken_apart import KEPT_TIERS, Workshop
from relight_core.pipeline.per_light.catchlights import Catchlight, mirrored_key
from relight_core.pipeline.per_light.kept_lights import KeptLights, ServingLight
from relight_core.pipeline.per_photo.brush import BrushStroke, checked_strokes
from relight_core.pipeline.per_photo.choosing_faces import those_chosen
from relight_core.pipeline.per_photo.portrait import checked_boxes, framed
from relight_core.pipeline.plan import Plan, Scene, make_plan
from relight_core.pipeline.prepared import Lit, Prepared
from relight_core.pipeline.quality import Tier, tier_of
from relight_core.pipeline.results.channels import ViewChange
from relight_core.pipeline.results.channels_together import Channels
from relight_core.pipeline.results.relit import Relit
from relight_core.pipeline.whole_photo import BEFORE_THE_BRUSH, WholePhoto
from relight_core.resources import resource_path

WEIGHTS = ("weights", "relight.safetensors")

_NETWORK_STAGES = (
    *("delight", "outline", "wider_outline", "begun"),
    *("specular_shadow", "residual", "compose", "nearer_face"),
)

_OTHERS_APART = "other_faces_delight"

_BRIGHTEST_LEVEL = 1e20
"""Lights beyond it count as this bright: sums over their pictures stay within single precision."""


class Relighter:
    """Takes a portrait apart once and puts it together under any light.

    Not thread-safe: one thread at a time.
    """

    def __init__(self, weights_path: Path | None = None, device: str = "cpu"):
        """Load the networks.

        Args:
            weights_path: a file written by `save_bundle`; None takes the bundled one.
            device: "cpu" or "cuda".

        Raises:
            InputError: the weights are missing or damaged, or PyTorch finds no such device.
        """
        try:
            torch.empty(1, device=device)
        except (AssertionError, RuntimeError) as error:
            raise InputError(f"{device}: PyTorch finds no such device on this machine; use the CPU") from error
        path = Path(weights_path) if weights_path else resource_path(*WEIGHTS)
        bundle = load_bundle(path).for_inference().to(device)
        self._shop = Workshop(bundle, ReflectionTable().to(device), device)
        self._record = Record()
        self._cache = StageCache(self._record)
        self._lights = KeptLights(KEPT_LIGHTS)
        self._people: tuple[FaceBox, ...] = ()
        self._faces: list[FaceRelighter] = []
        self._others: list[FaceRelighter] = []
        self._face_at: dict[FaceBox, FaceRelighter] = {}
        self._whole: WholePhoto | None = None
        # A user who undoes a box by hand need not wait for the search again, which takes longest where it is in vain.
        self._seen: WeakKeyDictionary[Photo, tuple[FaceBox, ...]] = WeakKeyDictionary()

    def set_portrait(
        self,
        photo: Photo,
        face_index: int | None = None,
        boxes: Sequence[FaceBox] | None = None,
        strokes: Sequence[BrushStroke] = (),
    ) -> None:
        """Choose the photo to relight; finds its faces and frames them by their parsing maps.

        Of the photo that is the portrait already, faces whose boxes are as before keep all that is known of them; so
        new strokes of the brush cost a new matte alone.

        Args:
            face_index: which face alone, in order of size or of `boxes`; None for all of them, the largest first. What
                belongs to the others stays as it is.
            boxes: where the faces are, brow to chin and cheek to cheek, where the finder is wrong or sees none.
            strokes: who is person and what is not, where the networks are wrong, from the oldest to the newest.
                Nothing where the photo's own alpha cuts the people out.

        Raises:
            NoFaceError: no face is found, or `boxes` is empty. The previous portrait stays, here and below.
            InputError: there is no face of that index, a box is empty or outside the photo, or a stroke is.
            UnwantedError: nobody waits for the portrait any more, see `relight_core.unwanted`.
        """
        whole, photo = photo, photo.above_black
        strokes, search = checked_strokes(strokes), FaceSearch(self._shop, photo)
        people = tuple(self._found(photo, search) if boxes is None else checked_boxes(photo, boxes))
        chosen, before = those_chosen(photo, people, face_index), (self._faces, self._others)
        self._face_at = self._faces_at(dict.fromkeys((*chosen, *people)), photo, search)
        self._people, self._faces = people, [self._face_at[box] for box in chosen]
        self._others = [face for box, face in self._face_at.items() if box not in chosen]
        self._whole = WholePhoto(self._shop, self._cache, whole, self._faces, strokes, self._others)
        if (self._faces, self._others) == before:
            self._cache.keep_only(BEFORE_THE_BRUSH)
        else:
            for face in set(before[0]).difference(self._faces):
                # A company and its faces know each other, and in such a circle would keep their photo.
                face.join(None)
            self._begin_portrait()

    def _faces_at(self, boxes: Iterable[FaceBox], photo: Photo, search: FaceSearch) -> dict[FaceBox, FaceRelighter]:
        """The faces in some boxes: those of the portrait so far where it is of the same photo, others framed now."""
        known = self._face_at if self._faces and self._faces[0].portrait.photo is photo else {}
        frame = lambda box: framed(photo, box, search.parsing)  # noqa: E731
        return {box: known.get(box) or FaceRelighter(self._shop, frame(box), StageCache()) for box in boxes}

    def _begin_portrait(self) -> None:
        """Forget what was found of other faces, and let those of now share their photo's light."""
        faces = list(dict.fromkeys(self._faces))
        company = Company(faces) if len(faces) > 1 else None
        for face in self._face_at.values():
            face.join(company if face in faces else None)
            face.cache.record = Record()
        self._faces[0].cache.record = self._record
        self._cache.clear()
        self._lights.clear()

    @property
    def people(self) -> tuple[FaceBox, ...]:
        """Everyone in the photo, as `face_index` counts them, also those who are not relit; in photo pixels."""
        return self._people

    def _found(self, photo: Photo, search: FaceSearch) -> tuple[FaceBox, ...]:
        """The photo's faces, looked for once; none where that was in vain before."""
        if photo not in self._seen:
            try:
                self._seen[photo] = tuple(search.faces())
            except NoFaceError:
                self._seen[photo] = ()
                raise
        return self._seen[photo]

    def estimated_light(self, quality: str) -> Environment:
        """The light the photo was taken under, as de-lighting sees it, at the photo's own exposure.

        Raises:
            InputError: no portrait has been set.
        """
        return Environment.from_radiance(self._first().own_light(tier_of(quality)), "borrowed")

    def get_ready(self, environment: Environment, edit: Edit) -> None:
        """Find what `relight` at an edit's quality needs to know of the faces once, whatever light comes.

        Raises:
            InputError: as `relight`.
        """
        edit = self._settled(edit)
        plan = self._planned(environment, edit)[0]
        for face in self._faces:
            face.get_ready(tier_of(edit.quality), plan)

    def forget(self, stage: str) -> None:
        """Drop a stage's results, so that it runs again when next needed; for measuring it."""
        self._cache.forget(stage)
        if stage == "delight":
            self._cache.forget(_OTHERS_APART)
        for face in self._face_at.values():
            face.forget(stage)

    def forget_lights(self) -> None:
        """Drop what came with a light or an edit: the next picture is made anew from what is known of the photo."""
        self._cache.forget_lights()
        for face in self._faces:
            face.forget_lights()

    def plan(self, environment: Environment, edit: Edit) -> Plan:
        """What `relight` would do now; of the picture nothing is computed.

        Raises:
            InputError: as `relight`.
        """
        return self._planned(environment, self._settled(edit))[0]

    def relight(
        self, environment: Environment, edit: Edit, longest_side_px: int | None = None, *, for_shader: bool = False
    ) -> Relit:
        """Light the portrait.

        Only what the scene calls for and what is not known yet is computed; `Relit.plan` says which effects,
        `Relit.stages` which steps. The light's level scales the result like exposure and never reaches a
        network.

        Args:
            longest_side_px: `Relit.image` is made no larger than this, for a screen; None makes it as large
                as the photo, 0 makes none. `Relit.full` gives the full size in any case.
            for_shader: give a recipe instead of an image, unless there are too many faces or pixels for one.

        Raises:
            InputError: no portrait has been set, or the edit asks for something unknown or out of its range.
        """
        if environment.level > _BRIGHTEST_LEVEL:
            environment = environment.at_level(_BRIGHTEST_LEVEL)
        self._record.begin_update()
        edit = self._settled(edit)
        plan, serving = self._planned(environment, edit)
        self._lights.keep(tier_of(edit.quality), serving)
        face, whole, level = self._first(), self._whole, environment.level
        ready, lit, change = self._first_change(serving, plan, edit, level)
        others = self._other_changes(serving, plan, edit, level)
        changes = [change, *(changed for *_, changed in others)]
        catchlights = self._catchlights(serving, plan, edit, environment)
        full = whole.picture(changes, catchlights, serving.radiance, plan, environment, edit)
        recipe, image, alpha = whole.shown(full, plan, longest_side_px, for_shader)
        channels = self._channels(ready, lit, change, plan, edit, environment)
        return Relit(
            image,
            alpha,
            channels,
            faces=[one.portrait.face for one in self._faces],
            stages=dict(self._record.stages),
            plan=plan.effects,
            full=full,
            window=face.portrait.view.window,
            roll_deg=face.portrait.view.roll_deg,
            recipe=recipe,
            level_as_in_photo_ev=partial(face.level_as_in_photo_ev, ready, change),
            outline=partial(whole.outline, full.matte),
            networks_ended_s=self._networks_ended_s(),
            channels_together=self._channels_together(channels, others, plan, edit),
        )

    def _channels(
        self, ready: Prepared, lit: Lit, change: ViewChange, plan: Plan, edit: Edit, environment: Environment
    ) -> dict[str, np.ndarray]:
        """The first face's channels that are looked at, and the light's."""
        channels = self._first().channels(ready, lit, change, plan, edit)
        if edit.looks_at("target_light") and plan.runs("channels"):
            channels["target_light"] = network_light(environment, edit.yaw_deg) * np.float32(environment.level)
        return channels

    def _channels_together(
        self, first: Channels, others: Sequence[tuple[Prepared, Lit, ViewChange]], plan: Plan, edit: Edit
    ) -> Callable[[], list[dict[str, np.ndarray]]]:
        """What makes the channels of several faces, of those of the first and what makes the others'."""
        if not (first and others):
            return list
        faces = zip(self._faces[1:], others, strict=True)
        return self._whole.channels_together(first, [face.channels_later(*parts, plan, edit) for face, parts in faces])

    def _catchlights(
        self, serving: ServingLight, plan: Plan, edit: Edit, environment: Environment
    ) -> tuple[tuple[Catchlight, ...], ...]:
        """What every face's eyes mirror."""
        if not plan.runs("catchlights"):
            self._cache.skip("catchlights", plan.effect("catchlights").why)
            return ()

        def mirror(face: FaceRelighter) -> tuple[Catchlight, ...]:
            ready, lit = face.prepared_and_lit(tier_of(edit.quality), serving, plan)
            return face.catchlights(ready, lit, plan, environment, edit.yaw_deg)

        make = lambda: tuple(mirror(face) for face in self._faces)  # noqa: E731
        return self._cache.run("catchlights", plan.keys["catchlights"], make, "new light")

    def _networks_ended_s(self) -> float | None:
        ends = [cache.record.last_end(_NETWORK_STAGES) for face in self._face_at.values() for cache in face.caches]
        return max((end for end in ends if end is not None), default=None)

    def _first(self) -> FaceRelighter:
        if not self._faces:
            raise InputError("no portrait is open: choose a photo first")
        return self._faces[0]

    def _settled(self, edit: Edit) -> Edit:
        """The edit with the tier that its quality comes to: on another one's surface, where every face has that."""
        check_edit(edit)
        takes_off = edit.forced("foreign_shadow") is not False
        if edit.surface_of is None and takes_off:
            return edit
        tier = replace(tier_of(edit.quality), takes_foreign_shadow_off=takes_off)
        if edit.surface_of is not None:
            other = replace(tier_of(edit.surface_of), takes_foreign_shadow_off=takes_off)
            better = tier.on_surface_of(other)
            tier = better if all(face.knows_surface(better) for face in self._faces) else tier
        return replace(edit, quality=tier, surface_of=None)

    def _planned(self, environment: Environment, edit: Edit) -> tuple[Plan, ServingLight]:
        """The plan for an edit whose tier is settled, and the light whose results serve."""
        caches = self._cache, self._first().cache
        # The scene takes the faces apart, since only then it is known whether a shadow falls on one.
        was_apart = self._first().knows_surface(tier_of(edit.quality))
        light = self._serving(environment, edit)
        scene = self._scene(environment, edit, light)

        def is_kept(stage: str, key: Hashable) -> bool:
            return was_apart if stage == "delight" else any(cache.has(stage, key) for cache in caches)

        return make_plan(scene, edit, is_kept, self._record.typical_ms), light

    def _serving(self, environment: Environment, edit: Edit) -> ServingLight:
        """The light itself, or one that is kept and nearly the same, with the small lamps of the former."""
        radiance = network_light(environment, edit.yaw_deg)
        if self._whole.monochrome:
            radiance = without_colour(radiance)
        light = self._lights.match(tier_of(edit.quality), radiance, 0.0 if edit.forced_on else edit.tolerance)
        return replace(light, lamps=lamps_of(environment, edit.yaw_deg))

    def _scene(self, environment: Environment, edit: Edit, light: ServingLight) -> Scene:
        """What the plan reads besides the edit."""
        tier, backdrop = tier_of(edit.quality), None
        if edit.background == "light":
            backdrop = (environment.fingerprint, edit.yaw_deg, edit.background_fov_deg, edit.background_blur_deg)
        irises, in_foreign_shadow = self._eyes_and_shadows(tier)
        return Scene(
            tier=tier,
            light=light.name,
            light_bound=light.bound,
            backdrop=backdrop,
            level=environment.level,
            lamps=light.lamps,
            mirrored=(mirrored_key(environment), edit.yaw_deg) if irises else None,
            irises=irises,
            in_foreign_shadow=in_foreign_shadow,
        )

    def _eyes_and_shadows(self, tier: Tier) -> tuple[int, int]:
        """How many irises are seen, and on how many faces a shadow falls: known once the faces are taken apart.

        Those beside the first are taken apart in a stage, since what their own caches do is in a record of each.
        """

        def told_by(faces: Sequence[FaceRelighter]) -> np.ndarray:
            shadows = [face.prepare(tier).found.foreign_shadow for face in faces]
            return np.array([sum(len(face.corneas()) for face in faces), sum(one is not None for one in shadows)])

        told = told_by(self._faces[:1])
        if len(self._faces) > 1:
            look = partial(told_by, self._faces[1:])
            told = told + self._cache.of_photo(
                _OTHERS_APART, tier.surface_key, look, "new photo or quality", keep=KEPT_TIERS
            )
        return int(told[0]), int(told[1])

    def _first_change(
        self, serving: ServingLight, plan: Plan, edit: Edit, level: float
    ) -> tuple[Prepared, Lit, ViewChange]:
        """What the light makes of the first face, and what that was made from."""
        face = self._first()
        ready, lit = face.prepared_and_lit(tier_of(edit.quality), serving, plan)
        make = partial(face.change, ready, lit, plan, edit, level)
        return ready, lit, face.cache.run("sliders", plan.keys["sliders"], make, "new light or slider")

    def _other_changes(
        self, serving: ServingLight, plan: Plan, edit: Edit, level: float
    ) -> list[tuple[Prepared, Lit, ViewChange]]:
        """What the light makes of the faces beside the first one, as `_first_change` has it."""
        if len(self._faces) == 1:
            return []

        def change(face: FaceRelighter) -> tuple[Prepared, Lit, ViewChange]:
            ready, lit = face.prepared_and_lit(tier_of(edit.quality), serving, plan)
            return ready, lit, face.change(ready, lit, plan, edit, level)

        return self._cache.run(
            "other_faces",
            plan.keys["sliders"],
            lambda: [change(face) for face in self._faces[1:]],
            "new light or slider",
        )
