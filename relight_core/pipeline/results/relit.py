"""A relit portrait, with all that was found on the way to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from relight_core.face.find import FaceBox
from relight_core.pipeline.cache import Stage
from relight_core.pipeline.plan import Effect
from relight_core.pipeline.results.display import DisplayRecipe
from relight_core.pipeline.results.picture import Picture


@dataclass(frozen=True, eq=False)
class Relit:
    """A relit portrait. Its arrays are read-only, since the Relighter keeps them for its next pictures.

    Attributes:
        image: (H, W, 3) float32 linear radiance at the size that was asked for, without `Edit.exposure_ev`; None
            where there is a recipe instead, or none was asked for.
        alpha: (H, W) float32 in [0, 1], of an `image` whose background was taken away; else None.
        channels: views (S, S, 3) or (S, S) float32 by name, as far as `Edit.channels` asks for them: "photo",
            "albedo", "normal" (unit vectors, in the axes of the square, which `roll_deg` turns), "parsing" (int
            labels), "specular", "shadow" and "composition" (linear, at the light's level), where shadows from outside
            were taken off the photo "foreign_shadow" (the share of light that they keep away, [0, 1]), and the lights
            "source_light" and "target_light" (16, 32, 3). Albedo, normals, specular and shadows fade to 0 at the
            person's outline.
        faces: the boxes of the faces that were relit, in photo pixels; the channels are the first one's.
        stages: what each stage did, in the order in which they ended.
        plan: what was decided about each effect, and why.
        full: the picture at the photo's own size, computed where it is asked for.
        window: x0, y0, x1, y1 of the square the channels show, in photo pixels; it may reach beyond the photo.
        roll_deg: how far that square is turned about its middle, as `Crop.roll_deg`.
        recipe: what a shader needs to draw the picture, at the size that was asked for.
        level_as_in_photo_ev: gives the stops by which the light's level has to change for the first face to be as
            bright as in the photo, at most 4 or as many as it is called with; worked out where it is asked for.
        outline: gives the outlines of the people, each (n, 2) with x, y in photo pixels; worked out where it is asked
            for, as long as the portrait is the same.
        channels_together: gives the channels of every face, where there are several, mixed where their views meet, with
            normals in camera space; none for one face alone. Worked out where it is asked for, on any thread.
        networks_ended_s: when the last network had run, on the clock of `time.perf_counter`.
    """

    image: np.ndarray | None
    alpha: np.ndarray | None
    channels: dict[str, np.ndarray]
    faces: list[FaceBox]
    stages: dict[str, Stage] = field(default_factory=dict)
    plan: tuple[Effect, ...] = ()
    full: Picture | None = None
    window: tuple[float, float, float, float] | None = None
    roll_deg: float = 0.0
    recipe: DisplayRecipe | None = None
    level_as_in_photo_ev: Callable[..., float] = lambda most_stops=0.0: 0.0
    outline: Callable[[], list[np.ndarray]] = list
    networks_ended_s: float | None = None
    channels_together: Callable[[], list[dict[str, np.ndarray]]] = list

    def __post_init__(self) -> None:
        object.__setattr__(self, "image", _read_only(self.image))
        object.__setattr__(self, "alpha", _read_only(self.alpha))
        object.__setattr__(self, "channels", {name: _read_only(channel) for name, channel in self.channels.items()})

    @property
    def size(self) -> tuple[int, int]:
        """(height, width) at the photo's own size."""
        return self.full.size if self.full is not None else self.image.shape[:2]


def _read_only(array: np.ndarray | None) -> np.ndarray | None:
    """A view that can't be written through: what it shows is kept, and the next picture may be made from it."""
    if array is None:
        return None
    view = array.view()
    view.setflags(write=False)
    return view
