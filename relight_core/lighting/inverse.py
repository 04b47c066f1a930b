"""The light that explains a photo, once the surface is known: a first guess, multiplied until it fits."""

from __future__ import annotations

import torch

from relight_core.imaging.tensor_colour import luminance_weights

_ITERATIONS = 10
_TRUST_IN_GUESS = 0.1
"""Weight of the guess beside the photo, in the mean weight that a texel has in it."""
_TRUST_IN_COLOUR = 0.5
"""The power of each channel's quotient beside that of luminance: 1 would follow colours in full, 0 not at all."""
_DARKEST = 1e-3
"""The least radiance of a texel in the guess, in its mean: what is 0 would stay 0."""


@torch.no_grad()
def explain_photo(
    guess: torch.Tensor, transport: torch.Tensor, shading: torch.Tensor, weight: torch.Tensor
) -> torch.Tensor:
    """Change a guessed light so that it lights the surface as the photo shows it.

    Direct light is linear in the environment, so the shading of known pixels is transport times light. Every
    texel is multiplied by how much brighter the photo is than predicted, averaged over the pixels it lights
    (Richardson 1972; Lucy 1974), a few times and held back by the guess. So light stays light: never
    negative, no holes where nothing was known, as smooth as the transport is. At every step colours
    follow by half, since an albedo whose hue is off looks like coloured light: what few pixels tell of keeps the
    guess's hue longer, what many agree in does not.

    Args:
        guess: (T, 3) radiance >= 0 at the scale of `shading`.
        transport: (P, T) response of each pixel to each texel, occlusion included.
        shading: (P, 3) photo over albedo, linear.
        weight: (P,) trust in each pixel, >= 0.

    Returns:
        (T, 3) radiance >= 0; the guess where no pixel is trusted.
    """
    total, known = weight.sum(), weight > 0
    if float(total) <= 0:
        return guess
    transport, shading = transport[known], shading[known]
    trusted = transport * (weight[known] / total)[:, None]
    pull = _TRUST_IN_GUESS * trusted.sum(0).mean()
    if float(pull) <= 0:
        return guess
    start = guess.clamp_min(_DARKEST * float(guess.mean()))
    wanted = trusted.T @ shading.clamp_min(0) + pull * start
    # A product of all pixels with three columns takes as long as this once, and would be needed twenty times.
    both = trusted.T @ transport
    light = start
    for _ in range(_ITERATIONS):
        light = light * _ratio(wanted, both @ light + pull * light)
    return light


def _ratio(wanted: torch.Tensor, predicted: torch.Tensor) -> torch.Tensor:
    """Quotient (T, 3) whose colour is damped toward grey."""
    luminance = luminance_weights(wanted)
    grey = ((wanted @ luminance) / (predicted @ luminance).clamp_min(1e-12))[:, None]
    each = wanted / predicted.clamp_min(1e-12)
    return grey * (each / grey.clamp_min(1e-12)).pow(_TRUST_IN_COLOUR)
