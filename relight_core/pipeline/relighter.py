"""The Relighter: a portrait is set once, slowly, and relit many times, quickly."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
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
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.face_relighter import KEPT_LIGHTS, FaceRelighter
from relight_core.pipeline.face_search import FaceSearch
from relight_core.pipeline.face_taken_apart import Workshop
from relight_core.pipeline.per_light.kept_lights import KeptLights, ServingLight
from relight_core.pipeline.per_light.rest_of_person import body_shading
from relight_core.pipeline.per_photo.brush import BrushStroke, checked_strokes
from relight_core.pipeline.per_photo.choosing_faces import those_chosen
from relight_core.pipeline.per_photo.matte import WORKING_PX, DraftMatte, Matte, draft_matte, finish_matte
from relight_core.pipeline.per_photo.person import Canvas, canvas_of, whole_person
from relight_core.pipeline.per_photo.portrait import checked_boxes, framed
from relight_core.pipeline.plan import Plan, Scene, make_plan
from relight_core.pipeline.prepared import Lit, Prepared
from relight_core.pipeline.quality import Tier, tier_of
from relight_core.pipeline.results.backdrop import OWN_BACKGROUNDS, Backdrop, backdrop_panorama, make_backdrop
from relight_core.pipeline.results.channels import ViewChange
from relight_core.pipeline.results.display import DisplayRecipe, person_layers, recipe_of
from relight_core.pipeline.results.finish import Placement, mean_gain, place_changes, place_views, weights_on_views
from relight_core.pipeline.results.outline_lines import outline_lines
from relight_core.pipeline.results.picture import Picture
from relight_core.pipeline.results.relit import Relit
from relight_core.resources import resource_path

WEIGHTS = ("weights", "relight.safetensors")

_KEPT_PIXELS = 6_000_000
"""Up to this size the person's matte and colour stay for the next light; above they are made band by band."""

_BEFORE_THE_BRUSH = ("small", "draft_matte", "canvas", "panorama")
"""Stages that read nothing of what is painted by hand."""

_NETWORK_STAGES = ("delight", "begun", "specular_shadow", "residual", "compose", "nearer_face")

_BRIGHTEST_LEVEL = 1e20
"""Lights beyond it count as this bright: sums over their pictures stay within single precision."""


class Relighter:
    """Takes a portrait apart once and puts it together under any light.

    Not thread-safe: one thread at a time.
    """

    def __init__(self, weights_path: Path | None = None, device: str = "cpu", *, remembers: bool = True):
        """Load the networks.

        Args:
            weights_path: a file written by `save_bundle`; None takes the bundled one.
            device: "cpu" or "cuda".
            remembers: False computes everything anew for every picture, to see what reuse is worth.

        Raises:
            InputError: the weights are missing or damaged.
        """
        path = Path(weights_path) if weights_path else resource_path(*WEIGHTS)
        bundle = load_bundle(path).for_inference().to(device)
        self._shop = Workshop(bundle, ReflectionTable().to(device), device)
        self._remembers, self._record = remembers, Record()
        self._cache = StageCache(self._record)
        self._lights = KeptLights(KEPT_LIGHTS)
        self._people: tuple[FaceBox, ...] = ()
        self._faces: list[FaceRelighter] = []
        self._face_at: dict[FaceBox, FaceRelighter] = {}
        self._strokes: tuple[BrushStroke, ...] = ()
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
            face_index: which face alone, in order of size or of `boxes`; None for all of them, the largest first.
            boxes: where the faces are, brow to chin and cheek to cheek, where the finder is wrong or sees none.
            strokes: who is person and what is not, where the networks are wrong, from the oldest to the newest.
                Nothing where the photo's own alpha cuts the people out.

        Raises:
            NoFaceError: no face is found, or `boxes` is empty. The previous portrait stays, here and below.
            InputError: there is no face of that index, a box is empty or outside the photo, or a stroke is.
        """
        strokes, search = checked_strokes(strokes), FaceSearch(self._shop, photo)
        people = tuple(self._found(photo, search) if boxes is None else checked_boxes(photo, boxes))
        known = self._face_at if self._faces and self._faces[0].portrait.photo is photo else {}

        def face_at(box: FaceBox) -> FaceRelighter:
            return known.get(box) or FaceRelighter(self._shop, framed(photo, box, search.labels), StageCache())

        chosen, before = those_chosen(photo, people, face_index), self._faces
        faces = {box: face_at(box) for box in dict.fromkeys(chosen)}
        self._people, self._face_at, self._faces = people, faces, [faces[box] for box in chosen]
        self._strokes = strokes
        if self._faces == before:
            self._cache.keep_only(_BEFORE_THE_BRUSH)
        else:
            self._begin_portrait()

    def _begin_portrait(self) -> None:
        """Forget what was found of other faces, and let those of now share their photo's light."""
        faces = list(self._face_at.values())
        company = Company(faces) if len(faces) > 1 else None
        for face in faces:
            face.join(company)
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
        for face in self._faces:
            face.forget(stage)

    def plan(self, environment: Environment, edit: Edit) -> Plan:
        """What `relight` would do now; computes nothing.

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
            InputError: no portrait has been set, or the edit asks for something unknown.
        """
        if environment.level > _BRIGHTEST_LEVEL:
            environment = environment.at_level(_BRIGHTEST_LEVEL)
        self._begin_update()
        edit = self._settled(edit)
        plan, serving = self._planned(environment, edit)
        self._lights.keep(tier_of(edit.quality), serving)
        face, level = self._first(), environment.level
        ready, lit, change = self._first_change(serving, plan, edit, level)
        changes = [change, *self._other_changes(serving, plan, edit, level)]
        full, shown = self._finished(changes, serving, plan, environment, edit, longest_side_px)
        key = (plan.keys["background"], longest_side_px)
        recipe = self._recipe(shown, key) if for_shader else None
        image, alpha = (None, None) if recipe or longest_side_px == 0 else self._rendered(shown, key)
        channels = face.channels(ready, lit, change, plan, edit)
        if edit.looks_at("target_light") and plan.runs("channels"):
            channels["target_light"] = network_light(environment, edit.yaw_deg) * np.float32(level)
        boxes = [face.portrait.face for face in self._faces]
        view, done = face.portrait.view, dict(self._record.stages)
        place = {"window": view.window, "roll_deg": view.roll_deg}
        others = {"recipe": recipe, "level_as_in_photo_ev": partial(face.level_as_in_photo_ev, ready, change)}
        outline = partial(outline_lines, self._small(), full.matte)
        others["outline"] = partial(self._cache.run, "outline_lines", full.matte, outline, "new photo or stroke")
        others["networks_ended_s"] = self._networks_ended_s()
        return Relit(image, alpha, channels, boxes, done, plan.effects, full, **place, **others)

    def _networks_ended_s(self) -> float | None:
        ends = [cache.record.last_end(_NETWORK_STAGES) for face in self._faces for cache in face.caches]
        return max((end for end in ends if end is not None), default=None)

    def _begin_update(self) -> None:
        self._record.begin_update()
        if not self._remembers:
            self._cache.clear()
            for face in self._faces:
                face.forget()

    def _first(self) -> FaceRelighter:
        if not self._faces:
            raise InputError("no portrait is open: choose a photo first")
        return self._faces[0]

    def _settled(self, edit: Edit) -> Edit:
        """The edit with the tier that its quality comes to: on another one's surface, where every face has that."""
        if edit.surface_of is None:
            return edit
        better = tier_of(edit.quality).on_surface_of(tier_of(edit.surface_of))
        known = all(face.knows_surface(better) for face in self._faces)
        return replace(edit, quality=better if known else edit.quality, surface_of=None)

    def _planned(self, environment: Environment, edit: Edit) -> tuple[Plan, ServingLight]:
        caches = self._cache, self._first().cache
        tier = tier_of(edit.quality)
        exact = not self._remembers or bool(edit.forced_on)
        radiance = network_light(environment, edit.yaw_deg)
        if self._first().portrait.photo.monochrome:
            radiance = without_colour(radiance)
        light = self._lights.match(tier, radiance, 0.0 if exact else edit.tolerance)
        light = replace(light, lamps=lamps_of(environment, edit.yaw_deg))
        backdrop = None
        if edit.background == "light":
            backdrop = (environment.fingerprint, edit.yaw_deg, edit.background_fov_deg, edit.background_blur_deg)
        scene = Scene(tier, light.name, light.bound, backdrop, environment.level, light.lamps)

        def is_kept(stage: str, key: Hashable) -> bool:
            return any(cache.has(stage, key) for cache in caches)

        return make_plan(scene, edit, is_kept, self._record.typical_ms), light

    def _first_change(
        self, serving: ServingLight, plan: Plan, edit: Edit, level: float
    ) -> tuple[Prepared, Lit, ViewChange]:
        """What the light makes of the first face, and what that was made from."""
        face = self._first()
        ready, lit = face.prepared_and_lit(tier_of(edit.quality), serving, plan)
        make = partial(face.change, ready, lit, plan, edit, level)
        return ready, lit, face.cache.run("sliders", plan.keys["sliders"], make, "new light or slider")

    def _other_changes(self, serving: ServingLight, plan: Plan, edit: Edit, level: float) -> list[ViewChange]:
        """What the light makes of the faces beside the first one."""
        if len(self._faces) == 1:
            return []

        def change(face: FaceRelighter) -> ViewChange:
            return face.change(*face.prepared_and_lit(tier_of(edit.quality), serving, plan), plan, edit, level)

        return self._cache.run(
            "other_faces",
            plan.keys["sliders"],
            lambda: [change(face) for face in self._faces[1:]],
            "new light or slider",
        )

    def _matte(self) -> Matte:
        """The people in the photo, corrected by the brush."""
        return finish_matte(self._cache.run("draft_matte", "photo", self._draft_matte, "new photo"), self._strokes)

    def _draft_matte(self) -> DraftMatte:
        """The people as seen by one tier, whichever is asked for, so that it depends on no history."""
        photo = self._faces[0].portrait.photo
        return draft_matte(photo.linear, (face.looks() for face in self._faces), photo.alpha, self._small().linear)

    def _small(self) -> Canvas:
        """The photo no longer than WORKING_PX, from which smaller copies are made."""
        photo = self._faces[0].portrait.photo
        return self._cache.run("small", "photo", lambda: canvas_of(photo, WORKING_PX), "new photo")

    def _finished(
        self,
        changes: Sequence[ViewChange],
        serving: ServingLight,
        plan: Plan,
        environment: Environment,
        edit: Edit,
        longest_side_px: int | None,
    ) -> tuple[Picture, Picture]:
        """The picture at the photo's size, and at the size that was asked for; nothing of either is computed."""
        photo, run = self._faces[0].portrait.photo, self._cache.run
        views = [face.portrait.view for face in self._faces]
        matte = run("matte", "photo", self._matte, "new photo or stroke")

        def place() -> Placement:
            masks = [face.mask() for face in self._faces]
            return place_views(self._small(), views, matte, self._shop.table, masks, self._strokes)

        placement = run("placement", "photo", place, "new photo or stroke")
        size = changes[0].gain.shape[0]
        weights = run("weights", size, lambda: weights_on_views(placement, size), "new photo or quality", 3)
        light = torch.from_numpy(serving.radiance)[None].to(self._shop.device)
        in_photo = self._body_in_photo(placement, plan, tier_of(edit.quality))
        rest, placed_changes = run(
            "detail",
            plan.keys["detail"],
            lambda: place_changes(placement, weights, changes, light, in_photo),
            "new light or slider",
        )
        if matte.own_alpha and edit.background in OWN_BACKGROUNDS:
            # Behind a person who was cut out there is nothing but what the cutting left.
            backdrop = Backdrop(transparent=True)
        else:
            backdrop = self._backdrop(plan, environment, edit, placement, rest)
        full = Picture(canvas_of(photo), matte, placed_changes, rest, backdrop)
        if longest_side_px == 0:
            return full, full
        canvas = run("canvas", longest_side_px, lambda: canvas_of(photo, longest_side_px), "new photo or size", 2)
        return full, replace(full, canvas=canvas)

    def _body_in_photo(self, placement: Placement, plan: Plan, tier: Tier) -> np.ndarray | None:
        """What the photo's own light gives the rest of the person; None where the plan has no use for it."""
        if not plan.runs("residual"):
            return None

        def shade() -> np.ndarray:
            light = self._first().own_light_normalised(self._first().prepare(tier))
            return body_shading(placement.body, torch.from_numpy(light)[None].to(self._shop.device))

        return self._cache.run("body_in_photo", tier.relief_key, shade, "new photo or quality", keep=3)

    def _recipe(self, picture: Picture, key: Hashable) -> DisplayRecipe | None:
        """How a shader draws a picture; None where it can't."""
        if picture.size[0] * picture.size[1] > _KEPT_PIXELS:
            return None
        canvas, matte, run = picture.canvas, picture.matte, self._cache.run
        layers = run("layers", picture.size, lambda: person_layers(canvas, matte), "new photo or size", 2)
        return run("recipe", key, lambda: recipe_of(picture, layers), "new light, slider or background")

    def _rendered(self, picture: Picture, key: Hashable) -> tuple[np.ndarray, np.ndarray | None]:
        """A picture's image and alpha."""
        if picture.size[0] * picture.size[1] <= _KEPT_PIXELS:
            canvas, matte = picture.canvas, picture.matte
            make = partial(whole_person, canvas, matte)
            picture = replace(picture, person=self._cache.run("person", picture.size, make, "new photo or size", 2))
        return self._cache.run("paste", key, picture.render, "new light, slider or background")

    def _backdrop(
        self, plan: Plan, environment: Environment, edit: Edit, placement: Placement, rest: np.ndarray
    ) -> Backdrop:
        """What is behind the people."""
        if not plan.runs("background"):
            return Backdrop(kept=True)
        panorama = None
        if edit.background == "light":
            make = partial(self._panorama, edit, environment)
            panorama = self._cache.run("panorama", plan.keys["panorama"], make, "new light")
        return self._cache.run(
            "background",
            plan.keys["background"],
            lambda: make_backdrop(edit.background, panorama, lambda: mean_gain(placement, rest)),
            "new light, slider or background",
        )

    def _panorama(self, edit: Edit, environment: Environment) -> np.ndarray:
        """What the photo's camera would see of the light behind the people."""
        photo = self._faces[0].portrait.photo
        seen = backdrop_panorama(edit, environment, photo.linear.shape[:2])
        return without_colour(seen) if photo.monochrome else seen
