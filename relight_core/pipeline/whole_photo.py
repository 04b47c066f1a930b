"""What belongs to a whole photo and to no single face: matte, body around faces, background, picture."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
import torch

from relight_core.imaging.colour import without_colour
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.pipeline.cache import StageCache
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.face_relighter import FaceRelighter
from relight_core.pipeline.face_taken_apart import Workshop
from relight_core.pipeline.per_light.catchlights import Catchlight
from relight_core.pipeline.per_light.rest_of_person import body_shading
from relight_core.pipeline.per_light.sliders import specular_gain
from relight_core.pipeline.per_photo.brush import BrushStroke
from relight_core.pipeline.per_photo.exposing import exposure_about_faces
from relight_core.pipeline.per_photo.first_matte import SeenPeople
from relight_core.pipeline.per_photo.matte import WORKING_PX, DraftMatte, Matte, draft_matte, finish_matte
from relight_core.pipeline.per_photo.person import Canvas, canvas_of, shrunk, whole_person
from relight_core.pipeline.plan import Plan
from relight_core.pipeline.quality import Tier, tier_of
from relight_core.pipeline.results.backdrop import OWN_BACKGROUNDS, Backdrop, backdrop_panorama, make_backdrop
from relight_core.pipeline.results.channels import ViewChange
from relight_core.pipeline.results.channels_together import Channels, channels_together
from relight_core.pipeline.results.display import LARGEST_SIDE, DisplayRecipe, fits_a_recipe, person_layers, recipe_of
from relight_core.pipeline.results.finish import (
    PhotoProperties,
    Placement,
    ViewWeights,
    less_where_unseen,
    mean_gain,
    place_catchlights,
    place_changes,
    place_views,
    weights_if_all_are_seen,
)
from relight_core.pipeline.results.outline_lines import outline_lines
from relight_core.pipeline.results.picture import Picture, PlacedCatchlight, PlacedChange
from relight_core.pipeline.results.strength import mixed

BEFORE_THE_BRUSH = (
    *("small", "draft_matte", "weights", "canvas", "panorama"),
    *("other_faces_delight", "other_faces", "catchlights"),
)
"""Stages that read nothing of what is painted by hand."""

_KEPT_PIXELS = 2560 * 2560
"""Up to this size, a screen's copy of a large square photo, the person's matte and colour stay for the next light;
above they are made band by band."""


class WholePhoto:
    """Puts the relit faces of a photo into it."""

    def __init__(
        self,
        shop: Workshop,
        cache: StageCache,
        photo: Photo,
        faces: Sequence[FaceRelighter],
        strokes: Sequence[BrushStroke],
        others: Sequence[FaceRelighter] = (),
    ) -> None:
        """Compute nothing yet.

        Args:
            cache: keeps the stages; whoever owns it empties it when faces, strokes or others are not the same.
            photo: with what lies over all of it (see `Photo.above_black`); faces are those of the photo without.
            faces: those that are relit, at least one.
            strokes: of the brush, see `Relighter.set_portrait`.
            others: faces of the photo that stay as they are.
        """
        self._shop, self._cache, self._faces, self._others = shop, cache, faces, others
        self._photo, self._in_file = faces[0].portrait.photo, photo
        self._strokes = () if self._photo.is_cut_out else strokes

    @cached_property
    def _canvas(self) -> Canvas:
        """All of the photo, and what lies over it apart."""
        return canvas_of(self._in_file, black=self._photo.black)

    @property
    def monochrome(self) -> bool:
        """Whether no face has a colour of its own, so that the light's colours act on none."""
        return all(face.portrait.monochrome for face in self._faces)

    def picture(
        self,
        changes: Sequence[ViewChange],
        catchlights: Sequence[Sequence[Catchlight]],
        radiance: np.ndarray,
        plan: Plan,
        environment: Environment,
        edit: Edit,
    ) -> Picture:
        """The picture at the photo's own size; nothing of its pixels is computed.

        Args:
            changes: of the faces, in their order.
            catchlights: of the faces' eyes, in their order, under a light of mean luminance 1; none where the plan has
                none.
            radiance: (16, 32, 3) of the light, normalised, as the photo's camera sees it.
        """
        run, matte, placement = self._cache.run, self._matte(), self._placement()
        size = changes[0].gain.shape[0]
        weights = self._weights(placement, size)
        light = torch.from_numpy(radiance)[None].to(self._shop.device)
        in_photo = self._body_in_photo(placement, plan, tier_of(edit.quality))
        rest, placed_changes = run(
            "detail",
            plan.keys["detail"],
            lambda: place_changes(placement, weights, changes, light, in_photo),
            "new light or slider",
        )
        eyes = self._eyes(catchlights, placed_changes, plan, edit, environment.level)
        if edit.strength < 1:
            mix = partial(mixed, rest, placed_changes, eyes, edit.strength)
            rest, placed_changes, eyes = run("strength", plan.keys["strength"], mix, "new light or slider")
        if matte.own_alpha and edit.background in OWN_BACKGROUNDS:
            # Behind a person who was cut out there is nothing but what the cutting left.
            backdrop = Backdrop(transparent=True)
        else:
            backdrop = self._backdrop(plan, environment, edit, placement, rest)
        of_photo = {"exposure": placement.photo.exposure, "catchlights": eyes}
        return Picture(self._canvas, matte, placed_changes, rest, backdrop, **of_photo)

    def shown(
        self, picture: Picture, plan: Plan, longest_side_px: int | None, for_shader: bool
    ) -> tuple[DisplayRecipe | None, np.ndarray | None, np.ndarray | None]:
        """A picture for a screen: a recipe for a shader where it is wished and possible, else its image and alpha.

        Args:
            longest_side_px: no larger than this; None is as large as the photo, 0 is none of the three.
        """
        if longest_side_px == 0:
            return None, None, None
        make = partial(shrunk, self._canvas, longest_side_px)
        canvas = self._cache.of_photo("canvas", longest_side_px, make, "new photo or size", 2)
        picture, key = replace(picture, canvas=canvas), (plan.keys["background"], longest_side_px)
        recipe = self._recipe(picture, key) if for_shader else None
        return (recipe, None, None) if recipe else (None, *self._rendered(picture, key))

    def outline(self, matte: Matte) -> list[np.ndarray]:
        """The lines along a matte of this photo, see `outline_lines`."""
        make = partial(outline_lines, self._small(), matte)
        return self._cache.of_photo("outline_lines", matte, make, "new photo or stroke")

    def _recipe(self, picture: Picture, key: Hashable) -> DisplayRecipe | None:
        """How a shader draws a picture; None where it can't."""
        is_large = picture.size[0] * picture.size[1] > _KEPT_PIXELS or max(picture.size) > LARGEST_SIDE
        if is_large or not fits_a_recipe(picture):
            return None
        make = partial(person_layers, picture.canvas, picture.matte, picture.exposure)
        layers = self._cache.of_photo("layers", picture.size, make, "new photo or size", 2)
        return self._cache.run("recipe", key, lambda: recipe_of(picture, layers), "new light, slider or background")

    def _rendered(self, picture: Picture, key: Hashable) -> tuple[np.ndarray, np.ndarray | None]:
        """A picture's image and alpha."""
        if picture.size[0] * picture.size[1] <= _KEPT_PIXELS:
            make = partial(whole_person, picture.canvas, picture.matte)
            person = self._cache.of_photo("person", picture.size, make, "new photo or size", 2)
            picture = replace(picture, person=person)
        return self._cache.run("paste", key, picture.render, "new light, slider or background")

    def channels_together(
        self, first: Channels, of_others: Sequence[Callable[[], Channels]]
    ) -> Callable[[], list[dict[str, np.ndarray]]]:
        """What makes the channels of all faces of those of each; see `results.channels_together`."""
        return partial(channels_together, self._placement(), first, of_others)

    def _matte(self) -> Matte:
        """The people in the photo, corrected by the brush."""

        def make() -> Matte:
            return finish_matte(self._cache.of_photo("draft_matte", "photo", self._draft_matte), self._strokes)

        return self._cache.of_photo("matte", "photo", make, "new photo or stroke")

    def _placement(self) -> Placement:
        """Where every face's view counts."""

        def place() -> Placement:
            views, masks = zip(*((face.portrait.view, face.mask()) for face in self._faces), strict=True)
            exposure = self._faces[0].portrait.exposure
            photo = PhotoProperties(exposure, self._photo.tone_at(exposure), self._photo.picture)
            return place_views(self._small(), views, self._matte(), self._shop.table, masks, self._strokes, photo)

        return self._cache.of_photo("placement", "photo", place, "new photo or stroke")

    def _weights(self, placement: Placement, size: int) -> tuple[ViewWeights, ...]:
        """How much each view counts, at the size of their maps."""
        make = partial(weights_if_all_are_seen, placement, size)
        weights = self._cache.of_photo("weights", size, make, "new photo or quality", 3)
        if placement.unseen is None:
            return weights
        make = partial(less_where_unseen, placement, weights, size)
        return self._cache.of_photo("weights_where_unseen", size, make, "new stroke or quality", 3)

    def _draft_matte(self) -> DraftMatte | None:
        """The people as seen by one tier, whichever is asked for, so that it depends on no history."""
        portraits = [face.portrait for face in self._faces]
        exposures, crops = [one.exposure for one in portraits], [one.crop for one in portraits]
        exposure = exposure_about_faces(exposures, crops, self._photo.linear.shape[:2])

        def look() -> SeenPeople:
            return SeenPeople(
                people=[face.looks() for face in self._faces],
                faces=[face.face_mask() for face in self._faces],
                others=[face.glances() for face in self._others],
                hair=[face.hair() for face in self._faces],
            )

        return draft_matte(self._photo, look, self._small().linear, exposure)

    def _small(self) -> Canvas:
        """The photo no longer than WORKING_PX, from which smaller copies are made."""
        return self._cache.of_photo("small", "photo", lambda: canvas_of(self._photo, WORKING_PX))

    def _body_in_photo(self, placement: Placement, plan: Plan, tier: Tier) -> np.ndarray | None:
        """What the photo's own light gives the rest of the person; None where the plan has no use for it."""
        if not plan.runs("residual"):
            return None

        def shade() -> np.ndarray:
            light = self._faces[0].own_light_normalised(self._faces[0].prepare(tier))
            return body_shading(placement.body, torch.from_numpy(light)[None].to(self._shop.device))

        return self._cache.of_photo("body_in_photo", tier.relief_key, shade, "new photo or quality", keep=3)

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
            lambda: make_backdrop(
                edit.background,
                panorama,
                lambda: mean_gain(placement, rest),
                placement.photo.exposure,
                self._canvas.black,
            ),
            "new light, slider or background",
        )

    def _eyes(
        self,
        catchlights: Sequence[Sequence[Catchlight]],
        changes: Sequence[PlacedChange],
        plan: Plan,
        edit: Edit,
        level: float,
    ) -> tuple[PlacedCatchlight, ...]:
        """What the eyes of all faces mirror, on top of the faces' changes; `level` is the light's."""
        if not catchlights:
            return ()
        monochrome = [face.portrait.monochrome for face in self._faces]
        make = partial(place_catchlights, catchlights, changes, _gloss(plan, edit, level), monochrome)
        key = (plan.keys["detail"], plan.keys["catchlights"])
        return self._cache.run("placed_catchlights", key, make, "new light or slider")

    def _panorama(self, edit: Edit, environment: Environment) -> np.ndarray:
        """What the photo's camera would see of the light behind the people."""
        seen = backdrop_panorama(edit, environment, self._photo.linear.shape[:2])
        return without_colour(seen) if self.monochrome else seen


def _gloss(plan: Plan, edit: Edit, level: float) -> np.ndarray:
    """(1,) or (3,) by how much brighter eyes mirror a light of this level than one of mean luminance 1."""
    gains = plan.gains(edit)
    gain = specular_gain(gains.specular * plan.runs("specular"), gains.specular_tint)
    return np.float32(level) * np.asarray(gain, np.float32).reshape(-1)
