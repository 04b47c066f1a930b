"""Scarves, collars, necklaces and earrings: around the neck, at the ears, and nowhere on a head without these."""

from dataclasses import replace

import numpy as np
import pytest
from ball_heads import CENTRE, RADIUS, assert_well_formed, ball_head, surface

from relight_core.dataset.garments import adornments
from relight_core.dataset.garments.headwear.ring import COLUMNS, HatRing

KINDS = ("scarf", "collar", "necklace", "earring")


@pytest.fixture(scope="module")
def skin():
    model = ball_head()
    return surface(model, model.mean)


@pytest.fixture(scope="module")
def neck():
    """A ring of 6 cm around an upright axis."""
    return HatRing(np.array([0.0, -10.0, -1.0]), np.eye(3), np.full(COLUMNS + 1, 6.0), 0.0)


@pytest.mark.parametrize("make", [adornments.scarf, adornments.collar, adornments.necklace])
@pytest.mark.parametrize("seed", range(3))
def test_what_is_worn_at_the_neck_goes_around_it(neck, skin, make, seed):
    worn = make(neck, skin, np.random.default_rng(seed))
    assert_well_formed(worn)
    assert worn.label == "cloth"
    local = neck.local(worn.vertices)
    radius = np.hypot(local[:, 0], local[:, 2])
    assert radius.min() > 6
    assert radius.max() < 14
    angles = np.degrees(np.arctan2(local[:, 0], local[:, 2]))
    assert np.histogram(angles, 12, (-180, 180))[0].min() > 0


def test_earrings_hang_from_both_lobes():
    lobes = [np.array([-8.0, -2.0, 0.0]), np.array([8.0, -2.0, 0.0])]
    for seed in range(8):
        worn = adornments.earrings(lobes, np.random.default_rng(seed))
        for side, lobe in zip((-1, 1), lobes, strict=True):
            mine = np.concatenate([g.vertices for g in worn if np.sign(g.vertices[:, 0].mean()) == side])
            assert np.linalg.norm(mine - lobe, axis=1).min() < 1.2
            assert mine[:, 1].max() < lobe[1] + 1.2
        for garment in worn:
            assert_well_formed(garment)


def test_a_scarf_lies_on_the_skin_where_the_neck_is_thicker_than_was_thought(skin):
    within = HatRing(CENTRE - [0, 3, 0], np.eye(3), np.full(COLUMNS + 1, 7.0), 0.0)
    for make in (adornments.scarf, adornments.necklace):
        worn = make(within, skin, np.random.default_rng(0))
        assert (np.linalg.norm(worn.vertices - CENTRE, axis=1) - RADIUS).min() > -0.15


def test_one_head_in_six_wears_something_at_its_neck_and_one_in_eight_earrings_at_its_lobes():
    """The ball is drawn out downward, so that it has a neck."""
    ball = ball_head()
    model = replace(ball, mean=(ball.mean - CENTRE) * np.float32([1, 1.6, 1]) + CENTRE.astype(np.float32))
    skin, about = surface(model, model.mean), adornments.NeckAndEars(model)
    worn = [about.adorn(model.mean, skin, np.random.default_rng(seed)) for seed in range(120)]
    counts = {kind: sum(any(g.name == kind for g in outfit) for outfit in worn) for kind in KINDS}
    assert sum(counts[kind] for kind in KINDS[:3]) / 120 == pytest.approx(0.17, abs=0.08)
    assert min(counts[kind] for kind in KINDS[:3]) > 1
    assert counts["earring"] / 120 == pytest.approx(0.12, abs=0.08)
    for earring in (garment for outfit in worn for garment in outfit if garment.name == "earring"):
        assert earring.vertices[:, 1].max() < 0
        assert np.abs(earring.vertices[:, 0]).max() > 7.9


def test_a_model_without_neck_or_ears_goes_bare(skin):
    model = ball_head()
    worn = [adornments.NeckAndEars(model).adorn(model.mean, skin, np.random.default_rng(seed)) for seed in range(40)]
    # The ball has ears, if round ones, but no neck: its lowest point is above where one would be.
    assert (CENTRE[1] - RADIUS) > -9
    assert {garment.name for garments in worn for garment in garments} == {"earring"}
