"""Things between a head and its light, against closed forms."""

import numpy as np
import pytest
from synthetic_heads import ball

from relight_core.dataset.lighting.appearance import appear
from relight_core.dataset.lighting.illumination import illuminate
from relight_core.dataset.lighting.interreflection import own_view
from relight_core.dataset.lighting.occluders import Occluder, positions, sample_occluder, silhouette, transmission
from relight_core.lighting.reflection import Gloss
from relight_core.lighting.sphere import directions, solid_angles

GLOSS = Gloss(0.6, 0.5)
TOWARD = directions(16, 32).reshape(-1, 3)
ORIGIN = np.zeros((1, 3), np.float32)


def ball_at(*centre, radius):
    return Occluder(np.float32([centre]), np.float32([radius]))


def test_a_ball_takes_the_solid_angle_it_fills():
    """A ball of radius r at distance d fills 2 pi (1 - sqrt(1 - (r / d)^2)) of the sphere."""
    taken = 1 - transmission(ball_at(0, 0, 2, radius=1), ORIGIN)[:, 0].numpy()
    angle = float((taken * solid_angles(16, 32).reshape(-1)).sum())
    assert angle == pytest.approx(2 * np.pi * (1 - np.sqrt(1 - 0.25)), rel=0.15)


def test_only_light_from_behind_it_is_taken():
    free = transmission(ball_at(2, 0, 0, radius=0.5), ORIGIN)[:, 0].numpy()
    assert free[TOWARD[:, 0] > 0.99].max() < 0.05
    assert (free[TOWARD[:, 0] < 0.5] == 1).all()


def test_each_of_two_things_takes_its_own_and_only_from_who_has_it_ahead():
    either = Occluder(np.float32([[2, 0, 0], [0, 2, 0]]), np.float32([0.5, 0.5]))
    before, beyond = transmission(either, np.float32([[0, 0, 0], [4, 0, 0]])).numpy().T
    right, left, up = TOWARD[:, 0] > 0.99, TOWARD[:, 0] < -0.99, TOWARD[:, 1] > 0.99
    assert before[right].max() < 0.05
    assert before[up].max() < 0.05
    assert before[left].min() == 1
    assert beyond[right].min() == 1
    assert beyond[left].max() < 0.05


def test_two_things_take_no_more_than_all():
    free = transmission(Occluder(np.float32([[0, 0, 1], [0, 0, 1]]), np.float32([0.9, 0.9])), ORIGIN)
    assert float(free.min()) >= 0
    assert float(free.max()) <= 1


def test_a_lamp_behind_an_occluder_lights_nothing():
    head = ball()
    lamp = np.zeros((1, 16, 32, 3), np.float32)
    lamp[:, 8, 24] = 50
    reference = illuminate(head, head.normal, lamp)
    shadowed = appear(head, head.normal, lamp, reference, GLOSS, ball_at(3, 0, 0, radius=2.5))
    assert reference.irradiance.max() > 0.1
    assert shadowed.irradiance.max() < 1e-3
    assert shadowed.specular.max() < 1e-3


def test_light_through_skin_keeps_its_amount_and_softens_red_the_most():
    head = ball()
    light = np.random.default_rng(0).gamma(0.1, 1, (1, 16, 32, 3)).astype(np.float32)
    light[...] = light[..., :1]
    reference = illuminate(head, head.normal, light)
    albedo, own = np.ones((len(head.normal), 3), np.float32), own_view(head, head.normal)
    soft = appear(head, head.normal, light, reference, GLOSS, scatter_px=3.0).radiance(head, albedo, own, 0)
    hard = appear(head, head.normal, light, reference, GLOSS).radiance(head, albedo, own, 0)
    np.testing.assert_allclose(soft.mean(0), hard.mean(0), rtol=0.1)
    deviation = soft.std(0)
    assert deviation[0] < deviation[1] < deviation[2] < hard.std(0)[2]


def test_an_occluder_in_the_picture_hides_what_is_behind_it():
    head = ball()
    in_front, behind = ball_at(0, 0, 3, radius=0.3), ball_at(0, 0, -3, radius=0.3)
    hidden = silhouette(in_front, head)
    size = head.size
    assert hidden[size // 2, size // 2]
    assert not hidden[0, 0]
    assert not silhouette(behind, head)[size // 2, size // 2]
    assert hidden.sum() == pytest.approx(np.pi * (0.3 * size / 2) ** 2, rel=0.4)
    rows, columns = np.nonzero(silhouette(ball_at(0, 0.5, 3, radius=0.3), head))
    assert rows.max() < size // 2
    assert columns.mean() == (size - 1) / 2
    assert silhouette(ball_at(0.9, 0, -3, radius=0.3), head)[size // 2, -1], "beside the head nothing is before it"


def test_most_occluders_show_in_the_picture_and_the_others_stay_out_of_frame():
    head, rng = ball(), np.random.default_rng(0)
    seen = [silhouette(sample_occluder(rng), head).any() for _ in range(400)]
    assert 0.67 < np.mean(seen) < 0.83


def test_positions_follow_the_picture():
    head = ball()
    points = positions(head)
    assert points[:, 0][head.normal[:, 0] > 0.3].min() > 0
    assert points[0, 1] > 0 > points[-1, 1]


def test_samples_are_finite_and_of_some_size():
    rng = np.random.default_rng(0)
    for _ in range(50):
        occluder = sample_occluder(rng)
        assert np.isfinite(occluder.centres).all()
        assert (occluder.radii > 0).all()
        assert len(occluder.centres) == len(occluder.radii)
