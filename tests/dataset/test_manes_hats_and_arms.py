"""Hair in a great mass, hats and raised arms, laid over people that are cut out."""

import numpy as np
import pytest

from relight_core.dataset.cutouts.arms import with_arm
from relight_core.dataset.cutouts.hats import with_hat
from relight_core.dataset.cutouts.mane import with_mane

SIZE, CENTRE, FACE_PX = 96, np.array([48.0, 44.0]), 24.0
ADDED = [with_mane, with_hat, with_arm]


def person():
    """A white face of 24 pixels on a trunk, premultiplied."""
    made = np.zeros((SIZE, SIZE, 4), np.float32)
    made[32:60, 36:60] = 1
    made[60:, 24:72] = 1
    return made


def premultiplied(image):
    return (
        image.shape == (SIZE, SIZE, 4)
        and np.isfinite(image).all()
        and image.min() >= 0
        and image[..., 3].max() <= 1 + 1e-5
        and float(image[image[..., 3] == 0][:, :3].sum()) == 0
    )


@pytest.mark.parametrize("add", [with_mane, with_arm])
@pytest.mark.parametrize("seed", range(8))
def test_a_person_gets_more_and_loses_nothing(pool, add, seed):
    before = person()
    after = add(before, CENTRE, FACE_PX, pool, np.random.default_rng(seed))
    assert premultiplied(after)
    assert (after[..., 3] >= before[..., 3] - 1e-4).all()
    assert after[..., 3].sum() > before[..., 3].sum() + 5


def test_a_mane_leaves_the_middle_of_the_face_alone_and_stands_off_the_head(pool):
    manes = [with_mane(person(), CENTRE, FACE_PX, pool, np.random.default_rng(seed)) for seed in range(8)]
    for mane in manes:
        np.testing.assert_allclose(mane[42:47, 46:51], 1, atol=1e-3)
    for beside in (slice(0, 34), slice(62, None)):
        assert np.median([mane[20:50, beside, 3].sum() for mane in manes]) > 50


def test_an_arm_is_before_the_person(pool):
    changed = np.zeros((SIZE, SIZE))
    for seed in range(12):
        changed += (
            np.abs(with_arm(person(), CENTRE, FACE_PX, pool, np.random.default_rng(seed)) - person()).max(-1) > 0.1
        )
    assert (changed[person()[..., 3] > 0] > 0).mean() > 0.2


@pytest.mark.parametrize("seed", range(24))
def test_a_hat_leaves_the_face_below_the_eyes_alone_and_hides_all_hair_above_it(pool, seed):
    before = person()
    before[:34, 30:66] = [0, 9, 0, 1]
    after = with_hat(before, CENTRE, FACE_PX, pool, np.random.default_rng(seed))
    assert premultiplied(after)
    np.testing.assert_allclose(after[45:60, 42:54], 1, atol=1e-6)
    np.testing.assert_array_equal(after[66:], before[66:])
    green = after[..., 1] - after[..., [0, 2]].max(-1)
    assert green[:25, 42:54].max() < 6
    assert after[30:34, 46:50, 3].min() > 0.99


def test_some_hats_are_wider_than_heads_and_some_taller(pool):
    hats = [with_hat(person(), CENTRE, FACE_PX, pool, np.random.default_rng(seed))[:40, :, 3] for seed in range(24)]
    wide = [(hat.max(0) > 0.5).sum() for hat in hats]
    tall = [(hat.max(1) > 0.5).sum() for hat in hats]
    assert min(wide) < 36 < 50 < max(wide)
    assert min(tall) < 18 < 26 < max(tall)


def test_where_no_head_is_no_hat_is(pool):
    cut = person()
    cut[:44] = 0
    above = np.array([48.0, -10.0])
    for middle in (CENTRE, above):
        np.testing.assert_array_equal(with_hat(cut, middle, FACE_PX, pool, np.random.default_rng(0)), cut)


@pytest.mark.parametrize("add", ADDED)
def test_all_follow_from_the_seed(pool, add):
    twice = [add(person(), CENTRE, FACE_PX, pool, np.random.default_rng(3)) for _ in range(2)]
    np.testing.assert_array_equal(*twice)


def test_nobody_in_the_picture_is_no_error(pool):
    nobody = np.zeros((SIZE, SIZE, 4), np.float32)
    for add in ADDED:
        assert premultiplied(add(nobody, np.array([-200.0, 44.0]), FACE_PX, pool, np.random.default_rng(0)))
