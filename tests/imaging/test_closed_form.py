"""Soft edges in closed form."""

import numpy as np
import pytest

from relight_core.imaging.closed_form import closed_form_matte


def soft_disc(size=48):
    """A disc whose edge is 8 pixels soft, before a wall; its true matte."""
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    matte = np.clip((size / 4 - np.hypot(x, y)) / 8 + 0.5, 0, 1)
    person, wall = np.array([0.8, 0.5, 0.3]), np.array([0.1, 0.2, 0.6])
    return matte[..., None] * person + (1 - matte[..., None]) * wall, matte


def test_soft_edges_are_found_from_a_guess_that_knows_none():
    guide, truth = soft_disc()
    guess = np.full(truth.shape, 0.5)
    guess[truth > 0.98], guess[truth < 0.02] = 1, 0
    matte = closed_form_matte(guide, guess)
    assert matte.dtype == np.float32
    assert np.abs(matte - truth).mean() < 0.03
    assert np.abs(np.where(guess == 0.5, matte - truth, 0)).max() < 0.15
    assert matte.min() >= 0
    assert matte.max() <= 1


def test_what_nobody_is_sure_of_joins_the_side_whose_colour_it_continues():
    guide = np.full((32, 32, 3), 0.2)
    guide[:, 16:] = 0.9
    guess = np.full((32, 32), 0.5)
    guess[:, :4], guess[20:, 28:] = 0.02, 0.98
    matte = closed_form_matte(guide, guess)
    assert matte[4, 26] > 0.8
    assert matte[28, 12] < 0.2


@pytest.mark.parametrize("size", [(1, 1), (2, 30), (3, 3)])
def test_tiny_pictures_and_pictures_of_one_colour(size):
    guess = np.linspace(0, 1, size[0] * size[1]).reshape(size)
    matte = closed_form_matte(np.zeros((*size, 3)), guess)
    assert matte.shape == size
    assert matte.dtype == np.float32
    assert np.isfinite(matte).all()


@pytest.mark.parametrize("side", range(4))
def test_soft_edges_are_found_up_to_the_border_of_the_picture(side):
    guide, truth = (np.rot90(whole[24:], side) for whole in soft_disc())
    guess = np.full(truth.shape, 0.5)
    guess[truth > 0.98], guess[truth < 0.02] = 1, 0
    border = [np.rot90(one, -side)[0] for one in (closed_form_matte(guide, guess), truth, guess)]
    matte, truth, guess = border
    assert np.abs(matte - truth)[guess == 0.5].max() < 0.1
    assert ((matte > 0.2) & (matte < 0.8)).sum() >= 8


def test_colours_beyond_both_sides_are_no_more_than_all_and_no_less_than_none():
    guide, guess = np.full((24, 24, 3), 0.4), np.zeros((24, 24))
    guide[:, 12], guess[:, 12] = 0.6, 1
    guide[:, 13:], guess[:, 13:] = 0.9, 0.5
    for likely, end in ((guess, 1.0), (1 - guess, 0.0)):
        assert (closed_form_matte(guide, likely)[:, 13:] == end).all()
