"""Inverse lighting: the light under which a known surface looks as in the photo."""

from __future__ import annotations

import torch

from relight_core.imaging.tensor_colour import luminance_weights

_ITERATIONS = 10
_TRUST_IN_GUESS = 0.1
"""Weight of the guess, as a multiple of the mean weight that the photo has over texels."""
_TRUST_IN_COLOUR = 0.5
"""Exponent of each channel's ratio relative to that of luminance: 1 would follow colours fully, 0 not at all."""
_DARKEST = 1e-3
"""Least radiance of a texel of the guess, as a multiple of its mean: a texel of 0 would stay 0."""


@torch.no_grad()
def explain_photo(
    guess: torch.Tensor, transport: torch.Tensor, shading: torch.Tensor, weight: torch.Tensor
) -> torch.Tensor:
    """Change a guessed light until it shades the surface as the photo shows it.

    Direct light is linear in the environment: the shading of the pixels is transport times light. A few times over,
    every texel is multiplied by the ratio of the photo to the prediction, averaged over the pixels that it lights
    (Richardson 1972; Lucy 1974), with the guess as a regulariser. So the light is never negative, has no holes where
    the photo says nothing, and is as smooth as the transport.

    Colours change by only half of that ratio in each iteration, since an albedo with a wrong hue looks like coloured
    light. Where few pixels say something, the light keeps the guess's hue longer than where many agree.

    Args:
        guess: (T, 3) radiance >= 0 at the scale of `shading`.
        transport: (P, T) response of each pixel to each texel, occlusion included.
        shading: (P, 3) photo over albedo, linear.
        weight: (P,) trust in each pixel, >= 0.

    Returns:
        (T, 3) radiance >= 0; the guess if no pixel is trusted.
    """
    total, known = weight.sum(), weight > 0
    if float(total) <= 0:
        return guess
    transport, shading = transport[known], shading[known]
    weighted = transport * (weight[known] / total)[:, None]
    guess_weight = _TRUST_IN_GUESS * weighted.sum(0).mean()
    if float(guess_weight) <= 0:
        return guess
    start = guess.clamp_min(_DARKEST * float(guess.mean()))
    wanted = weighted.T @ shading.clamp_min(0) + guess_weight * start
    # This (T, T) product costs about as much as one pass over all pixels, and saves two passes per iteration.
    normal_matrix = weighted.T @ transport
    light = start
    for _ in range(_ITERATIONS):
        light = light * _ratio(wanted, normal_matrix @ light + guess_weight * light)
    return light


def _ratio(wanted: torch.Tensor, predicted: torch.Tensor) -> torch.Tensor:
    """Ratio (T, 3) whose colour is damped toward grey."""
    luminance = luminance_weights(wanted)
    grey = ((wanted @ luminance) / (predicted @ luminance).clamp_min(1e-12))[:, None]
    each = wanted / predicted.clamp_min(1e-12)
    return grey * (each / grey.clamp_min(1e-12)).pow(_TRUST_IN_COLOUR)
