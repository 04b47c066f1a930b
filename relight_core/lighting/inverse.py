"""The light that explains a photo, once the surface is known: linear least squares over a first guess."""

from __future__ import annotations

import torch

_ITERATIONS = 60
_TRUST_IN_GUESS = 0.03


@torch.no_grad()
def explain_photo(
    guess: torch.Tensor, transport: torch.Tensor, shading: torch.Tensor, weight: torch.Tensor
) -> torch.Tensor:
    """Change a guessed light so that it lights the surface as the photo shows it.

    Direct light is linear in the environment, so the shading of known pixels is transport times light.
    Minimised is the weighted squared error plus a pull toward the guess, under light >= 0, by projected
    gradient steps with momentum: texels that no pixel sees keep the guess.

    Args:
        guess: (T, 3) radiance >= 0 at the scale of `shading`.
        transport: (P, T) response of each pixel to each texel, occlusion included.
        shading: (P, 3) photo over albedo, linear.
        weight: (P,) trust in each pixel, >= 0.

    Returns:
        (T, 3) radiance >= 0; the guess where no pixel is trusted.
    """
    total = weight.sum()
    if float(total) <= 0:
        return guess
    share = (weight / total)[:, None]
    gram = transport.T @ (transport * share)
    right = transport.T @ (shading * share)
    stiffness = torch.linalg.matrix_norm(gram, 2)
    pull = _TRUST_IN_GUESS * stiffness
    step = 1 / (stiffness + pull).clamp_min(1e-12)
    light, before = guess.clone(), guess.clone()
    for iteration in range(_ITERATIONS):
        ahead = light + iteration / (iteration + 3) * (light - before)
        before = light
        light = (ahead - step * (gram @ ahead - right + pull * (ahead - guess))).clamp_min(0)
    return light
