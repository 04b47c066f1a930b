"""What is known of one face at the networks' size: as a tier of quality sees it, and under a light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_photo.portrait import Portrait
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.stages import Composed, Surface


@dataclass(frozen=True, eq=False)
class Prepared:
    """A portrait as one tier of quality sees it.

    Attributes:
        found: what de-lighting found.
        surface: the same, its albedo flattened where the plan wants that.
        photo_view: (S, S, 3) linear, the view in the photo's own colours.
        seen: the same as the networks see it: without colour where the photo has none but a tone.
        photo_small: (s, s, 3), `seen` at the networks' size.
    """

    portrait: Portrait
    tier: Tier
    found: Surface
    surface: Surface
    photo_view: np.ndarray
    seen: np.ndarray
    photo_small: np.ndarray


@dataclass(frozen=True, eq=False)
class Lit:
    """A prepared portrait under a light, at the networks' size; the same of its nearer view, where that is lit too."""

    light: torch.Tensor
    reflected: torch.Tensor
    effects: Effects
    composed: Composed
    nearer: tuple[Prepared, Lit] | None = None
