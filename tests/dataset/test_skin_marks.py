"""Moles, freckles, birthmarks, scars and tattoos: on skin alone, and of their sizes."""

import numpy as np
import pytest
from synthetic_heads import ball

from relight_core.dataset.painting import skin_marks
from relight_core.dataset.painting.skin import paint
from relight_core.dataset.painting.texture import TexturePool

MARKS = [skin_marks.add_moles, skin_marks.add_freckles, skin_marks.add_birthmark, skin_marks.add_scar]
SIZE = 64


@pytest.fixture(scope="module")
def head():
    """A ball of skin: 20 cm across by its texture coordinates, which run evenly over the picture."""
    made = ball(SIZE)
    row, column = np.nonzero(made.covered)
    uv = np.stack([column, SIZE - row], 1) / SIZE * (20 / 0.8 / 29)
    return made.__class__(**(made.__dict__ | {"uv": uv.astype(np.float32), "material": np.zeros_like(made.material)}))


@pytest.fixture(scope="module")
def pool():
    return TexturePool(np.random.default_rng(0), count=4)


def marked(mark, head, pool, seed, tone=0.4):
    skin = np.full((len(head.uv), 3), tone, np.float32)
    mark(skin, skin_marks.skin_surface(head), pool, np.random.default_rng(seed))
    return skin


@pytest.mark.parametrize("mark", [*MARKS, skin_marks.add_tattoo])
def test_marks_change_a_part_of_the_skin_and_stay_reflectances(head, pool, mark):
    changed = np.zeros(len(head.uv))
    for seed in range(12):
        skin = marked(mark, head, pool, seed)
        assert skin.dtype == np.float32
        assert np.isfinite(skin).all()
        assert skin.min() > 0
        assert skin.max() <= 1
        changed += np.abs(skin - 0.4).max(1) > 0.02
    assert 0 < changed.mean() < 0.7 * 12


def test_sizes_are_in_centimetres(head):
    places = skin_marks.skin_surface(head).places
    assert np.ptp(places[:, 0]) == pytest.approx(20, rel=0.2)
    assert np.ptp(places[:, 1]) == pytest.approx(20, rel=0.2)


def test_moles_are_small_dark_and_brown(head, pool):
    for seed in range(6):
        skin = marked(skin_marks.add_moles, head, pool, seed)
        assert (skin <= 0.4 + 1e-6).all()
        dark = skin[skin[:, 0] < 0.38]
        assert (dark[:, 0] >= dark[:, 1]).all()
        assert (dark[:, 1] >= dark[:, 2]).all()
        assert len(dark) < 0.02 * len(skin)


def test_scars_are_bent_lines_of_7_cm_at_most(head, pool):
    places = skin_marks.skin_surface(head).places
    for seed in range(20):
        scarred = places[np.abs(marked(skin_marks.add_scar, head, pool, seed) - 0.4).max(1) > 0.02]
        assert np.linalg.norm(scarred[:, None] - scarred[None], axis=2).max(initial=0) < 8
        assert len(scarred) < 0.08 * len(places)


def test_tattoos_end_where_they_do_and_are_not_all_over_a_head(head, pool):
    places, across = skin_marks.skin_surface(head).places, []
    for seed in range(20):
        inked = places[np.abs(marked(skin_marks.add_tattoo, head, pool, seed) - 0.4).max(1) > 0.02]
        across.append(np.linalg.norm(np.ptp(inked, axis=0)) if len(inked) else 0.0)
    assert max(across) < 6.3 * 2 * 2**0.5
    assert np.median(across) < 13


def test_birthmarks_are_red_brown_or_pale(head, pool):
    kinds = set()
    for seed in range(24):
        change = marked(skin_marks.add_birthmark, head, pool, seed) - 0.4
        change = change[np.abs(change).max(1) > 0.02].sum(0)
        assert (change <= 0).all() or (change >= 0).all()
        # Blood takes most of green light, and melanin of blue.
        kinds.add("pale" if change[0] > 0 else ("none", "red", "brown")[change.argmin()])
    assert {"pale", "red", "brown"} <= kinds


def test_whoever_is_painted_is_marked(head, pool, monkeypatch):
    monkeypatch.setattr(skin_marks, "_MARKS", ((1.0, lambda skin, *_: skin.fill(0.5)),))
    for seed in range(6):
        albedo = paint(head, pool, np.random.default_rng(seed), wild=False)
        assert 0.45 <= np.median(albedo) <= 0.55


def test_a_mark_stays_on_its_side_of_an_ear_and_off_what_lies_behind():
    """Three sheets: the front of something thin, its back, and skin four centimetres behind it."""
    x, y = (part.ravel().astype(np.float32) for part in np.meshgrid(np.arange(8), np.arange(8)))
    sheets = [np.stack([x, y, np.full_like(x, depth)], 1) for depth in (0.0, -1.0, -4.0)]
    normals = np.repeat(np.float32([[0, 0, 1], [0, 0, -1], [0, 0, 1]]), 64, axis=0)
    surface = skin_marks.SkinSurface(np.arange(192), np.concatenate(sheets), normals)
    for seed in range(12):
        pixels, offset = surface.around(np.random.default_rng(seed))
        assert len(pixels) == len(offset) == 64
        assert len(set(pixels // 64)) == 1
        assert np.hypot(*offset.T).min() == 0


def test_six_heads_in_ten_have_marks(head, pool):
    changed = 0
    for seed in range(80):
        skin = np.full((len(head.uv), 3), 0.4, np.float32)
        skin_marks.mark_skin(skin, head, pool, np.random.default_rng(seed))
        changed += bool((skin != np.float32(0.4)).any())
    assert changed / 80 == pytest.approx(0.6, abs=0.15)


def test_nothing_is_marked_that_is_not_skin(head, pool):
    material = np.where(head.normal[:, 0] > 0, 7, 0).astype(np.uint8)
    half = head.__class__(**(head.__dict__ | {"material": material}))
    for seed in range(20):
        skin = np.full((len(half.uv), 3), 0.4, np.float32)
        skin_marks.mark_skin(skin, half, pool, np.random.default_rng(seed))
        assert (skin[material == 7] == np.float32(0.4)).all()


def test_a_head_without_skin_is_left_alone(head, pool):
    hat = head.__class__(**(head.__dict__ | {"material": np.full_like(head.material, 7)}))
    skin = np.full((len(hat.uv), 3), 0.4, np.float32)
    for seed in range(8):
        skin_marks.mark_skin(skin, hat, pool, np.random.default_rng(seed))
    assert (skin == np.float32(0.4)).all()


def test_the_same_seed_marks_the_same(head, pool):
    for mark in MARKS:
        np.testing.assert_array_equal(marked(mark, head, pool, 3), marked(mark, head, pool, 3))
