"""The square that a head is baked in: rays through its pixels, and as much around the face as in the paper."""

import numpy as np
import pytest

from relight_core.dataset.baking.framing import Framing, project, sample_framing


def test_what_lies_on_a_pixels_ray_is_seen_at_that_pixel():
    origin, toward = Framing((3.0, -2.0), 12.0).rays(8)
    np.testing.assert_allclose(np.linalg.norm(toward, axis=1), 1, atol=1e-6)
    for distance in (200.0, 350.0):
        seen = project(origin + distance * toward).reshape(8, 8, 2)
        np.testing.assert_allclose(seen[0, 0], [3 - 10.5, -2 + 10.5], atol=1e-3)
        np.testing.assert_allclose(seen[7, 4], [3 + 1.5, -2 - 10.5], atol=1e-3)


def test_half_of_the_squares_are_the_papers_and_the_others_are_wider():
    """20 to 40 pixels of 256 around the face leave it 69 to 84 % of the square's side."""
    face = np.array([[-7.0, -10.0, 0.0], [7.0, 10.0, 0.0]])
    framings = [sample_framing(face, np.random.default_rng(seed)) for seed in range(300)]
    shares = np.array([20 / (2 * framing.half_width_cm) for framing in framings])
    assert 0.29 < shares.min() < 0.4
    assert 0.83 < shares.max() < 0.844
    assert (shares > 0.687).mean() == pytest.approx(0.52, abs=0.08)
    offsets = np.abs([np.array(framing.centre_cm) / framing.half_width_cm for framing in framings]).max(1)
    assert np.median(offsets[shares > 0.687]) < 0.04
    # What is wider shows more below the face than above it.
    heights = np.array([framing.centre_cm[1] / framing.half_width_cm for framing in framings])
    assert heights[shares < 0.6].mean() == pytest.approx(-0.08, abs=0.04)
