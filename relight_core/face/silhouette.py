"""The person as one solid shape, without the holes that a parsing leaves."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.face.parsing import EYES, FACE_LABELS, INDEX, middle_row
from relight_core.face.posterior import posterior
from relight_core.imaging.masks import disc, part_at
from relight_core.imaging.ramp import ramp

_CLOSING_SHARE = 1 / 24
"""Gaps up to this share of the view's side are closed."""
_FAINT_HAT, _PLAIN_HAT = 0.02, 0.032
"""Ramp of a hat's mean probability over the view: from the first on there may be one, from the second on there is."""
_HAT_ODDS = 1.5
"""A hat adds this to the log odds of person well above the eyes."""
_RAMP_SHARE = 0.05
"""Distance above the eyes over which the ramp of `rows_above_the_eyes` rises, as a share of the view's side."""
_EYES = (*EYES, "glasses")
_LEAST_EYES = 5e-4
"""Share of the view that eyes or glasses must cover for their row to be known."""


def solid_person(parsing: np.ndarray) -> np.ndarray:
    """Probability of person with holes filled, and without parts that are not connected to the face.

    Args:
        parsing: (classes, S, S) probabilities.

    Returns:
        (S, S) float32 in [0, 1]; if there is no face, the parsing's own probability of person.
    """
    person = np.clip(1 - parsing[INDEX["background"]], 0, 1).astype(np.float32)
    face = parsing[list(FACE_LABELS)].sum(0) > 0.5
    body = part_at(person > 0.5, face)
    if body is None:
        return person
    filled = _without_holes(body.astype(np.uint8))
    edge = np.maximum(person, cv2.GaussianBlur(filled.astype(np.float32), (0, 0), 0.8) * filled)
    near = cv2.dilate(filled, np.ones((5, 5), np.uint8))
    return (edge * near).astype(np.float32)


def person_with_headwear(parsing: np.ndarray) -> np.ndarray:
    """Probability of person, raised above the eyes if the parsing sees a hat, however faintly.

    Large or unusual hats are mostly taken for background. But they give the class "hat" a mean probability of a few
    hundredths over the view, and bare heads less.

    Args:
        parsing: (classes, S, S), the softmax of the de-lighting network, not yet through `face.posterior`.

    Returns:
        (S, S) float32 in [0, 1].
    """
    likely = posterior(parsing)
    person, hat = 1 - likely[INDEX["background"]], float(likely[INDEX["hat"]].mean())
    plainly = ramp(hat, _FAINT_HAT, _PLAIN_HAT)
    if plainly == 0:
        return person
    odds = np.exp(_HAT_ODDS * plainly * rows_above_the_eyes(parsing)).astype(np.float32)
    return odds * person / (1 + (odds - 1) * person)


def rows_above_the_eyes(parsing: np.ndarray) -> np.ndarray:
    """A ramp over the rows of a parsing (classes, S, S), (S, 1) float32: 0 from the eyes or glasses down, 1 well above.

    Without visible eyes or glasses it is 0 everywhere.
    """
    rows = np.arange(parsing.shape[1], dtype=np.float32)[:, None]
    eyes = middle_row(parsing, _EYES, _LEAST_EYES * len(rows) ** 2)
    return np.zeros_like(rows) if eyes is None else np.clip((eyes - rows) / (_RAMP_SHARE * len(rows)), 0, 1)


def _without_holes(body: np.ndarray) -> np.ndarray:
    """A mask (S, S) with small gaps closed and then all enclosed holes filled."""
    size = len(body)
    kernel = disc(size * _CLOSING_SHARE / 2)
    span = len(kernel)
    padded = cv2.copyMakeBorder(body, span, span, span, span, cv2.BORDER_REPLICATE)
    closed = cv2.morphologyEx(padded, cv2.MORPH_CLOSE, kernel)[span:-span, span:-span]
    outlines, _ = cv2.findContours(closed, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros_like(closed)
    cv2.drawContours(filled, outlines, -1, 1, cv2.FILLED)
    return np.maximum(filled, body)
