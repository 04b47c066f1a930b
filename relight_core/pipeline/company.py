"""People in one photo stand in one light.

How bright a surface is and how bright its light, one face alone can't tell, and where the light comes from it tells
roughly. Several faces know more: the light they share is taken from all of them, and what tells a dark face from
a pale one beside it is their albedo. So everyone's skin stays as it is beside the others', and all of them are the
photo again under the light it was taken in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from relight_core.lighting.panorama import normalise_light
from relight_core.pipeline.plan import Plan
from relight_core.pipeline.quality import Tier

_MOST_ALBEDO = math.log(2.0)
"""By what one face is brighter than the others, its albedo is, up to about a stop; what is more, the light near it."""

_LEAST_KNOWN = 1e-6
"""A box over black, where there is nobody, says nothing of how bright the others are."""


class Member(Protocol):
    """A face, and what it knows by itself."""

    def estimate(self, tier: Tier) -> np.ndarray:
        """The source light (16, 32, 3) as the photo's camera sees it, of mean luminance 1."""

    def exposure(self, tier: Tier) -> float:
        """The level at which the company's light gives the face its brightness in the photo."""

    def model_level(self, tier: Tier, plan: Plan) -> float:
        """The level at which the whole model of the face under the source light is as bright as the photo."""


class Company:
    """The faces of one photo that are relit together.

    Attributes:
        faces: two or more.
    """

    def __init__(self, faces: Sequence[Member]):
        self.faces = tuple(faces)

    def light(self, tier: Tier) -> np.ndarray:
        """The light (16, 32, 3) that all of them stand in, as the camera sees it, of mean luminance 1."""
        return normalise_light(np.mean([face.estimate(tier) for face in self.faces], axis=0))

    def albedo_gain(self, face: Member, tier: Tier) -> float:
        """What brings one face's albedo to the level of the others', above 1/2 and below 2."""
        brighter = _log(face.exposure(tier)) - _mean_log([one.exposure(tier) for one in self.faces])
        return math.exp(_MOST_ALBEDO * math.tanh(brighter / _MOST_ALBEDO))

    def level(self, tier: Tier, plan: Plan) -> float:
        """The level of their light, at which model and photo agree over all of them."""
        return math.exp(_mean_log([face.model_level(tier, plan) for face in self.faces]))


def _mean_log(values: Sequence[float]) -> float:
    """Over those that are known, unless none is."""
    known = [value for value in values if value > _LEAST_KNOWN] or values
    return sum(map(_log, known)) / len(known)


def _log(value: float) -> float:
    return math.log(max(value, 1e-12))
