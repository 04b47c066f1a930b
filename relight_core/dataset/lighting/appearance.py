"""How a lit head looks to the camera: its own gloss, light through skin, shadows of things beside it.

The targets of training are lit with the paper's one gloss and hard skin; photographs are not.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.dataset.baking.bake import SKIN, BakedHead
from relight_core.dataset.lighting.illumination import Illumination, illuminate_past, reflect
from relight_core.dataset.lighting.interreflection import OwnView, bounced
from relight_core.dataset.lighting.occluders import Occluder, silhouette
from relight_core.face.gloss import gloss_of
from relight_core.lighting.reflection import GLOSS, Gloss

_SCATTER = np.array([1.0, 0.45, 0.25], np.float32)
"""How far red, green and blue travel in skin, relative to red (Jensen et al. 2001, skin1, rounded)."""


@dataclass(frozen=True)
class Appearance:
    """What a photo of a lit head shows; nothing of it is ever a target.

    Attributes:
        irradiance, specular: (K, P, 3) like `Illumination`, with the head's own gloss, past an occluder.
        scatter_px: deviation of red light's way through skin, in pixels; 0 for hard skin.
        hidden: (S, S) bool where an occluder stands in the picture, or None.
    """

    irradiance: np.ndarray
    specular: np.ndarray
    scatter_px: float
    hidden: np.ndarray | None

    def radiance(self, head: BakedHead, albedo: np.ndarray, own: OwnView, k: int) -> np.ndarray:
        """What leaves each pixel toward the camera under light `k`, (P, 3)."""
        irradiance = self.irradiance[k] + bounced(head, own, albedo, self.irradiance[k])
        if self.scatter_px > 0:
            irradiance = _through_skin(head, irradiance, self.scatter_px)
        return albedo * irradiance + self.specular[k]


def appear(
    head: BakedHead,
    normal: np.ndarray,
    lights: np.ndarray,
    reference: Illumination,
    gloss: Gloss,
    occluder: Occluder | None = None,
    scatter_px: float = 0.0,
    dullness: float = 1.0,
) -> Appearance:
    """The head as photographed, `reference` being what the same lights do to it undisturbed.

    Args:
        dullness: of hair and cloth, the exponent of what they have of the gloss; 0 gives them that of skin.
    """
    share = gloss_of(head.label, dullness)
    if occluder is None:
        own = reference.specular if (gloss, dullness) == (GLOSS, 1) else reflect(head, normal, lights, gloss) * share
        return Appearance(reference.irradiance, own, scatter_px, None)
    irradiance, own = illuminate_past(head, normal, lights, gloss, occluder)
    own = own * share
    hidden = silhouette(occluder, head)
    return Appearance(irradiance, own, scatter_px, hidden if hidden.any() else None)


def _through_skin(head: BakedHead, irradiance: np.ndarray, scatter_px: float) -> np.ndarray:
    """Irradiance (P, 3) blurred over skin, red the most, as light that enters beside a pixel leaves at it."""
    skin = np.isin(head.material, SKIN).astype(np.float32)
    image, weight = head.scatter(irradiance * skin[:, None]), head.scatter(skin)
    result = irradiance.copy()
    for channel, reach in enumerate(_SCATTER * scatter_px):
        spread = cv2.GaussianBlur(weight, (0, 0), float(reach))[head.covered]
        light = cv2.GaussianBlur(image[..., channel], (0, 0), float(reach))[head.covered]
        result[:, channel] = np.where(skin > 0, light / np.maximum(spread, 1e-3), irradiance[:, channel])
    return result
