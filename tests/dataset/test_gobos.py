"""Drawn shadows with edges: what of a lamp gets past something to each pixel of a head."""

import numpy as np
import pytest

from relight_core.dataset.lighting import gobos
from relight_core.dataset.lighting.gobos import sample_gobo

SIZE = 64


def gobo(pool, seed, relief=None):
    relief = np.zeros((SIZE, SIZE), np.float32) if relief is None else relief
    return sample_gobo(relief, pool, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(20))
def test_it_takes_some_share_of_a_lamp(pool, seed):
    passes = gobo(pool, seed)
    assert passes.shape == (SIZE, SIZE)
    assert passes.dtype == np.float32
    assert 0 <= passes.min() <= passes.max() <= 1


def test_most_have_a_shadow_and_a_lit_place_in_view_and_some_have_sharp_edges(pool):
    drawn = [gobo(pool, seed) for seed in range(60)]
    both = [passes.min() < 0.2 and passes.max() > 0.8 for passes in drawn]
    steepest = [max(np.abs(np.diff(passes, axis=axis)).max() for axis in (0, 1)) for passes in drawn]
    assert np.mean(both) > 0.7
    assert np.mean(np.array(steepest) > 0.6) > 0.3
    assert np.mean(np.array(steepest) < 0.4) > 0.15


def test_shadows_and_spots_are_as_frequent(pool):
    lit = np.mean([gobo(pool, seed).mean() for seed in range(100)])
    assert 0.35 < lit < 0.65


def test_what_stands_out_of_a_face_bends_a_shadow_and_nothing_else_does(pool):
    nose = np.zeros((SIZE, SIZE), np.float32)
    nose[24:40, 24:40] = 0.5
    moved = np.zeros(nose.shape)
    for seed in range(12):
        moved += np.abs(gobo(pool, seed, nose) - gobo(pool, seed))
    assert moved[28:36, 28:36].mean() > 0.5
    assert moved[:8].max() < 0.02


DRAWN = 384
"""Side of what is drawn, in pixels; it is 3.2 half-widths of the view wide."""


def drawn(monkeypatch, picture):
    monkeypatch.setattr(gobos, "_draw", lambda pool, rng: np.ascontiguousarray(picture, np.float32))


def half(axis):
    """1 on the left, or above."""
    inside = np.ones((DRAWN, DRAWN))
    inside[(slice(None),) * axis + (slice(DRAWN // 2, None),)] = 0
    return inside


def edges_at(passes, axis):
    """Where, in half-widths of the view, each row's or column's edge lies that a half has, whichever side is lit."""
    first = passes.take(range(4), axis).mean()
    share = passes.mean(axis)
    return 2 * (share if first > 0.5 else 1 - share) - 1


@pytest.mark.parametrize("axis", [0, 1])
def test_what_is_drawn_is_seen_the_right_way_round_and_lit_on_either_side(pool, monkeypatch, axis):
    drawn(monkeypatch, half(axis))
    seen = [gobo(pool, seed) for seed in range(40)]
    assert all(np.abs(edges_at(passes, axis)).mean() < 0.3 for passes in seen)
    lit_first = np.mean([passes.take(range(4), axis).mean() > 0.5 for passes in seen])
    assert 0.25 < lit_first < 0.75


def test_a_straight_edge_wavers_a_little_at_most_and_in_some_not_at_all(pool, monkeypatch):
    drawn(monkeypatch, half(1))
    wavers = np.array([edges_at(gobo(pool, seed), 1).std() for seed in range(40)])
    assert wavers.max() < 0.25
    assert np.mean(wavers < 1e-3) > 0.15
    assert np.mean(wavers > 0.01) > 0.3


def test_what_is_drawn_has_the_size_of_the_view_s_measure(pool, monkeypatch):
    down, across = (np.mgrid[:DRAWN, :DRAWN] + 0.5) / DRAWN * 3.2 - 1.6
    drawn(monkeypatch, np.hypot(down, across) < 0.5)
    shares = [passes.mean() for passes in (gobo(pool, seed) for seed in range(20))]
    # A quarter of pi over four, whether it is the disc that is lit or all else.
    assert np.mean([min(share, 1 - share) for share in shares]) == pytest.approx(0.196, abs=0.02)


@pytest.mark.parametrize("axis", [0, 1])
def test_height_moves_a_shadow_across_and_along_by_about_half_of_itself(pool, monkeypatch, axis):
    drawn(monkeypatch, half(axis))
    raised = np.full((SIZE, SIZE), 0.2, np.float32)
    moved = [edges_at(gobo(pool, seed, raised), axis) - edges_at(gobo(pool, seed), axis) for seed in range(40)]
    ways = np.array([way.mean() for way in moved])
    assert 0.06 < np.abs(ways).mean() < 0.2
    assert ways.min() < 0 < ways.max()


@pytest.mark.parametrize("everywhere", [0, 1])
def test_beyond_what_is_drawn_nothing_begins(pool, monkeypatch, everywhere):
    drawn(monkeypatch, np.full((DRAWN, DRAWN), everywhere))
    for seed in range(10):
        assert np.ptp(gobo(pool, seed, np.full((SIZE, SIZE), 3, np.float32))) < 1e-5


def test_things_of_every_kind_are_drawn(pool, monkeypatch):
    names, drew = ["_edge", "_disc", "_leaves", "_bars", "_branches"], []
    for name in names:
        monkeypatch.setattr(gobos, name, lambda pool, rng, name=name: drew.append(name) or half(0))
    rng = np.random.default_rng(0)
    for _ in range(100):
        gobos._draw(pool, rng)
    assert set(drew) >= set(names)


# The least and the most that one covers of what is drawn, and the most that its soft edges do.
@pytest.mark.parametrize(
    ("name", "least", "most", "blurred"),
    [
        ("_edge", 0.1, 0.9, 0.03),
        ("_disc", 0.001, 0.16, 0.03),
        ("_leaves", 0.15, 0.8, 0.2),
        ("_bars", 0.15, 0.92, 0.15),
        ("_branches", 0.0005, 0.3, 0.05),
    ],
)
def test_a_thing_covers_some_of_the_view_with_an_edge(pool, name, least, most, blurred):
    things = [getattr(gobos, name)(pool, np.random.default_rng(seed)) for seed in range(40)]
    for thing in things:
        assert thing.shape == (DRAWN, DRAWN)
        assert thing.dtype == np.float32
        assert 0 <= thing.min() <= thing.max() <= 1
        assert least <= thing.mean() <= most
        assert np.mean((thing > 0.1) & (thing < 0.9)) < blurred
    middle = slice(DRAWN // 4, -DRAWN // 4)
    assert np.mean([thing[middle, middle].max() == 1 for thing in things]) > 0.8
