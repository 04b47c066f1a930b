"""The samples of the person network: a photo with people in it, and the outline of the one that is meant."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import torch

from relight_core.dataset.baking.shard import read_shard
from relight_core.dataset.camera import camera_gain, through_camera
from relight_core.dataset.cutouts.arms import with_arm
from relight_core.dataset.cutouts.cutouts import Cutout, cut_out, place
from relight_core.dataset.cutouts.hats import with_hat
from relight_core.dataset.cutouts.mane import with_mane
from relight_core.dataset.cutouts.scenery.behind import with_something_behind
from relight_core.dataset.cutouts.scenery.panoramas import read_places
from relight_core.dataset.cutouts.scenery.pool import SceneryPool
from relight_core.dataset.lighting.appearance import appear
from relight_core.dataset.lighting.lights import sample_network_lights
from relight_core.dataset.painting.skin import paint
from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.samples import light_head
from relight_core.dataset.stream import Ingredients, SampleStream, textured
from relight_core.face.crop import Crop
from relight_core.face.person_view import FACE_SHARE, face_in_view, inside_photo, person_view
from relight_core.lighting.reflection import GLOSS

_CUTOUTS_PER_HEAD, _SAMPLES_PER_CUTOUT, _SCENES_PER_HEAD = 5, 12, 3
_WILD_SHARE, _ACCOMPANIED_SHARE, _CAMOUFLAGED_SHARE, _TURNED_SHARE = 0.3, 0.35, 0.25, 0.4
_TURN_DEG = 12.0
_BACKED_SHARE = 0.3
_ADDED = {with_mane: 0.15, with_hat: 0.2, with_arm: 0.15}
"""In this order: a hat lies on hair, and an arm before both."""
_CLOSEST, _FARTHEST = 0.62, 3.0
_HALVED_SHARE = 0.08


@dataclass(frozen=True)
class Cast:
    """One person in several lights and paints, and scenes to put people before."""

    people: list[Cutout]
    scenery: SceneryPool


class OutlineStream(SampleStream):
    """Single photos as the person network sees them, and how much of each pixel is the person that is meant.

    Each item is a dict of tensors: "photo_srgb" (3, S, S), 0 beyond the photo's borders; "inside" (1, S, S), 1
    where there is a photo; "face" (1, S, S), 1 in the square of the face that is meant; "person" (1, S, S). Lit
    heads are cut out and put before drawn scenes, others beside and behind them, bodies below their busts.

    Args:
        places: a folder of panoramas, views into which are scenes as well; None does without.

    Raises:
        InputError: no panoramas there, or one that can't be read.
    """

    def __init__(
        self,
        folder: Path,
        lights: Path,
        split: str,
        size: int,
        seed: int,
        *,
        places: Path | None = None,
        **where: int,
    ):
        often = {"lights_per_head": _CUTOUTS_PER_HEAD, "paints_per_head": _CUTOUTS_PER_HEAD * _SAMPLES_PER_CUTOUT}
        super().__init__(folder, lights, split, size, seed, **often, **where)
        # Read here, once, and not by every worker.
        self.panoramas = read_places(places) if places else ()

    def _light(self, path: Path, ingredients: Ingredients, rng: np.random.Generator) -> Cast:
        scenery = SceneryPool(ingredients.pool, rng, _SCENES_PER_HEAD, self.panoramas)
        return Cast(self._cutouts(path, ingredients, rng), scenery)

    def _sample(
        self, casts: dict[int, Cast], turn: int, pool: TexturePool, rng: np.random.Generator
    ) -> dict[str, torch.Tensor]:
        people = [person for place in sorted(casts) for person in casts[place].people]
        # Where no face is seen of a head, it is anybody's turn.
        chosen = casts[turn].people or people
        scenery = casts[int(rng.integers(len(casts)))].scenery
        return outline_sample(people, chosen[rng.integers(len(chosen))], self.size, scenery, pool, rng)

    def _cutouts(self, path: Path, ingredients: Ingredients, rng: np.random.Generator) -> list[Cutout]:
        """One person in several lights and paints, at the shard's own size, whatever the samples' is."""
        head, pool, library = read_shard(path), ingredients.pool, ingredients.library
        normal = textured(head, pool, rng)
        lights = sample_network_lights(library, rng, self.lights_per_head)
        lit = light_head(head, normal, lights)
        appearance = appear(head, normal, lights, lit.illumination, GLOSS)
        found = []
        for k, light in enumerate(lights):
            albedo = paint(head, pool, rng, wild=bool(rng.random() < _WILD_SHARE))
            radiance = head.scatter(appearance.radiance(head, albedo, lit.own, k))
            white_level = float(lit.illumination.irradiance[k].mean())
            gain = camera_gain(radiance, head.covered, light, white_level, rng)
            found.append(cut_out(radiance * gain, head.covered, head.scatter(head.label), rng))
        return [cutout for cutout in found if cutout is not None]


def outline_sample(
    people: list[Cutout], meant: Cutout, size: int, scenery: SceneryPool, pool: TexturePool, rng: np.random.Generator
) -> dict[str, torch.Tensor]:
    """One photo of the person that is meant, at times with some of the people; see `OutlineStream`."""
    person = meant.mirrored() if rng.random() < 0.5 else meant
    left, top, right, bottom = _frame(person.known, rng)
    crop, photo_size = Crop(left, top, 1 / FACE_SHARE), (top + bottom, left + right)
    view = person_view(crop, photo_size)
    face_px, centre = size / view.side, view.from_photo(np.array([left, top]), size)
    placed = place(person, size, centre, face_px, pool, rng)
    for add, share in _ADDED.items():
        if rng.random() < share:
            placed = add(placed, centre, face_px, pool, rng)
    image = scenery.view(size, rng)
    if rng.random() < _BACKED_SHARE:
        image = with_something_behind(image, scenery.view(size, rng), centre, face_px, rng)
    if rng.random() < _CAMOUFLAGED_SHARE:
        image = _camouflaged(image, placed, rng)
    while rng.random() < _ACCOMPANIED_SHARE:
        image = _with_neighbour(image, people, centre, face_px, pool, rng)
    alpha = placed[..., 3:]
    inside = inside_photo(view, photo_size, size)[..., None]
    found = replace(crop, centre_x=left + rng.normal(0, 0.05), centre_y=top + rng.normal(0, 0.05))
    found = replace(found, side=crop.side * np.exp(rng.normal(0, 0.08)))
    face = face_in_view(view, found, size)
    return _photographed(image * (1 - alpha) + placed[..., :3], np.dstack([inside, face, alpha * inside]), rng)


def _photographed(exposed: np.ndarray, planes: np.ndarray, rng: np.random.Generator) -> dict[str, torch.Tensor]:
    """A picture and its planes, (S, S, 3) each, turned a little at times: heads lean, and so their views do."""
    if rng.random() < _TURNED_SHARE:
        exposed, planes = _turned(exposed, planes, float(rng.normal(0, _TURN_DEG)))
    # Last, as in life: noise and JPEG's blocks stay as the camera made them.
    photo = through_camera(exposed, rng) * planes[..., :1]
    stack = np.clip(np.dstack([photo, planes]), 0, 1).astype(np.float32)
    planes = torch.from_numpy(stack).permute(2, 0, 1).contiguous()
    return {"photo_srgb": planes[:3], "inside": planes[3:4], "face": planes[4:5], "person": planes[5:6]}


def _turned(exposed: np.ndarray, planes: np.ndarray, turn_deg: float) -> tuple[np.ndarray, np.ndarray]:
    size = len(exposed)
    turn = cv2.getRotationMatrix2D((size / 2, size / 2), turn_deg, 1.0)
    exposed = cv2.warpAffine(exposed.astype(np.float32), turn, (size, size), borderMode=cv2.BORDER_REPLICATE)
    return exposed, cv2.warpAffine(planes.astype(np.float32), turn, (size, size))


def _frame(known: tuple[float, float, float, float], rng: np.random.Generator) -> np.ndarray:
    """How far the photo reaches to the left, top, right and bottom of the face's middle, in faces.

    At times a border runs through the face.
    """
    wide = np.exp(rng.uniform(np.log(_CLOSEST), np.log(_FARTHEST)))
    reach = np.maximum(wide * rng.uniform(0.8, 1.6, 4), 0.58)
    if rng.random() < _HALVED_SHARE:
        reach[rng.integers(4)] = rng.uniform(0.05, 0.5)
    return np.minimum(reach, np.maximum(known, 0.5))


def _camouflaged(image: np.ndarray, person: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A background of the colour of some part of the person."""
    rows, columns = np.nonzero(person[..., 3] > 0.9)
    if len(rows) == 0:
        return image
    at = rng.integers(len(rows))
    wanted = person[rows[at], columns[at], :3]
    return image * (np.maximum(wanted, 1e-3) / np.maximum(image.mean((0, 1)), 1e-3))


def _with_neighbour(
    image: np.ndarray,
    people: list[Cutout],
    centre: np.ndarray,
    face_px: float,
    pool: TexturePool,
    rng: np.random.Generator,
) -> np.ndarray:
    """Somebody else behind and beside, or farther off, in focus or not."""
    size, other = len(image), people[rng.integers(len(people))]
    if min(other.known) < 1:
        return image
    scale = np.exp(rng.uniform(np.log(0.3), np.log(1.1)))
    aside = [rng.choice([-1.0, 1.0]) * rng.uniform(0.7, 2.2), rng.normal(0, 0.35)]
    layer = place(other, size, centre + face_px * np.array(aside), face_px * scale, pool, rng)
    if rng.random() < 0.6:
        layer = cv2.GaussianBlur(layer, (0, 0), size * 10 ** rng.uniform(-2.6, -1.5))
    return image * (1 - layer[..., 3:]) + layer[..., :3] * np.float32(2 ** rng.normal(0, 0.6))
