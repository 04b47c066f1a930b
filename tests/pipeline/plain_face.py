"""A face before a wall, as de-lighting sees it: of one colour, but for what is worn or held before it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import torch

from relight_core.pipeline import stages
from relight_core.pipeline.per_photo.second_look import take_apart
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.stages import Surface

SIZE = 96
SKIN, LEFT_EYE, RIGHT_EYE, LIPS, HAIR, CLOTH = 1, 4, 5, 8, 10, 13
TONE, WALL = (0.4, 0.22, 0.15), (0.1, 0.2, 0.6)
MASKS = {
    "blue": (0.38, 0.58, 0.75),
    "red": (0.5, 0.03, 0.04),
    "green": (0.05, 0.25, 0.1),
    "white": (0.8, 0.8, 0.8),
    "black": (0.015, 0.014, 0.016),
}
MASK, MOUTH, FOREHEAD = np.s_[44:80, 26:70], np.s_[54:66, 42:54], np.s_[18:28, 32:64]


def face(mask=None, lips=0.0, parsed_as=SKIN, shade=1.0):
    """The surface of a face before a blue wall, as de-lighting sees it, with a mask of a colour or the mouth bare.

    Args:
        lips: probability of lips about the mouth.
        parsed_as: the class that the mask is taken for.
        shade: of the photo from the eyes on downward.
    """
    rows, columns = np.mgrid[:SIZE, :SIZE]
    person = ((columns - 48) / 34) ** 2 + ((rows - 48) / 46) ** 2 < 1
    label = np.where(person, SKIN, 0)
    label[person & (rows < 14)] = HAIR
    label[33:37, 33:39], label[33:37, 57:63] = RIGHT_EYE, LEFT_EYE
    photo = np.where(person[..., None], TONE, WALL)
    if mask is not None:
        photo[MASK], label[MASK] = mask, parsed_as
    photo[40:] *= shade
    parsing = np.eye(14)[label].transpose(2, 0, 1)
    parsing[:, 58:64, 36:60] *= 1 - lips
    parsing[LIPS, 58:64, 36:60] += lips
    grain = np.random.default_rng(0).normal(0, 0.02, photo.shape)
    as_tensor = lambda image: torch.from_numpy(np.ascontiguousarray(image)).float()[None]  # noqa: E731
    return Surface(
        photo=as_tensor((photo * np.exp(grain)).transpose(2, 0, 1)),
        albedo=torch.tensor(TONE)[None, :, None, None].expand(1, 3, SIZE, SIZE).clone(),
        normal=torch.tensor([0.0, 0, 1])[None, :, None, None].expand(1, 3, SIZE, SIZE),
        relief=torch.zeros(1, 1, SIZE, SIZE),
        parsing=as_tensor(parsing),
        person=as_tensor(person[None]),
        source_light=torch.ones(1, 16, 32, 3),
    )


def take_apart_seeing(monkeypatch, surface, looks_twice=False):
    """What is found in the surface's own view, the network finding that surface in any; and the views it was given."""
    views = []

    def delight(bundle, view, size, device, **how):
        views.append(view)
        return replace(surface, photo=torch.from_numpy(view).movedim(-1, 0)[None])

    monkeypatch.setattr(stages, "delight", delight)
    tier = Tier(SIZE, SIZE, SIZE, 16, False, precision="fp32", looks_twice=looks_twice)
    return take_apart(SimpleNamespace(foreign_shadow=None), view_of(surface), tier, "cpu"), views


def view_of(surface):
    return np.ascontiguousarray(surface.photo[0].movedim(0, -1).numpy())
