"""Photos of many people: each view's neighbours have a say in it, and nobody else is asked."""

from dataclasses import replace

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.imaging.photo import Photo
from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import canvas_of
from relight_core.pipeline.results import channels_together as channels_together_module
from relight_core.pipeline.results import finish
from relight_core.pipeline.results.channels_together import channels_together

ROW = tuple(Crop(50.0 + 100.0 * index, 50.0, 120.0) for index in range(6))
"""Six views; each reaches over those beside it and over no others."""
ASLANT = tuple(Crop(50.0 + 150.0 * index, 50.0, 120.0, 45.0) for index in range(4))
"""Four whose corners alone meet."""


def placed_in_a_row(people=(), views=ROW):
    flat, whole = np.full((100, 600, 3), 0.3, np.float32), np.ones((1, 1), np.float32)
    matte = Matte(0 * whole, whole, flat[:1, :1], flat[:1, :1], whole)
    return finish.place_views(canvas_of(Photo(flat)), views, matte, ReflectionTable(), people)


@pytest.mark.parametrize("views", [ROW, ASLANT], ids=["row", "aslant"])
@pytest.mark.parametrize("reach", [None, 1.0, 2.5])
def test_weights_of_a_view_are_as_if_all_others_were_asked(monkeypatch, views, reach):
    """People may be known farther than their views reach, or not at all."""
    mask = np.tile(np.linspace(1, 0, 32, dtype=np.float32), (32, 1))
    people = () if reach is None else tuple((mask, replace(view, side=view.side * reach)) for view in views)
    placement = placed_in_a_row(people, views)
    nearby = finish.weights_on_views(placement, 32)
    monkeypatch.setattr(finish, "_may_meet", lambda one, other: True)
    for few, all_asked in zip(nearby, finish.weights_on_views(placement, 32), strict=True):
        assert [weight is None for weight in few.of_views] == [weight is None for weight in all_asked.of_views]
        for one, other in zip((*few.of_views, few.of_rest), (*all_asked.of_views, all_asked.of_rest), strict=True):
            np.testing.assert_array_equal(one, other)


def test_weights_of_a_view_ask_its_neighbours_alone(monkeypatch):
    placement, weigh, asked = placed_in_a_row(), finish._weight, []

    def noted(view, places, photo_size):
        asked.append(view)
        return weigh(view, places, photo_size)

    monkeypatch.setattr(finish, "_weight", noted)
    finish.weights_on_views(placement, 32)
    assert [asked.count(view) for view in ROW] == [2, 3, 3, 3, 3, 2]


def test_people_who_are_unseen_change_the_weights_of_views_that_hold_them_alone():
    placement = placed_in_a_row()
    weights, unseen = finish.weights_on_views(placement, 32), np.zeros((100, 600), np.float32)
    unseen[40:60, 20:30] = 1
    placement = replace(placement, unseen=unseen)
    first, *others = finish.less_where_unseen(placement, weights, 32)
    assert all(one is before for one, before in zip(others, weights[1:], strict=True))
    assert (first.of_views[0][16, 9], first.of_rest[16, 9]) == (0, 1)
    assert weights[0].of_views[0][16, 9] == 1
    assert first.of_views[0][16, 20] == weights[0].of_views[0][16, 20]


def test_channels_of_a_crowd_fade_where_people_are_unseen():
    unseen = np.zeros((100, 600), np.float32)
    unseen[40:60, 20:30] = 1
    albedo = {"albedo": np.ones((32, 32, 3), np.float32)}
    everyone, some = (
        channels_together(placement, albedo, [lambda: albedo] * (len(ROW) - 1))[0]["albedo"]
        for placement in (placed_in_a_row(), replace(placed_in_a_row(), unseen=unseen))
    )
    assert everyone[16, 9] == pytest.approx(1)
    assert some[16, 9] == pytest.approx(0)
    assert some[16, 20] == pytest.approx(1)


def test_where_a_shadow_from_outside_falls_on_one_face_the_others_have_none():
    shadow, albedo = np.full((32, 32, 3), 0.5, np.float32), {"albedo": np.ones((32, 32, 3), np.float32)}
    others = [lambda: albedo | {"foreign_shadow": shadow}, *[lambda: albedo] * (len(ROW) - 2)]
    together = channels_together(placed_in_a_row(), albedo, others)
    levels = [float(one["foreign_shadow"][16, 16].mean()) for one in together]
    assert levels == pytest.approx([0, 0.5, 0, 0, 0, 0])
    without = channels_together(placed_in_a_row(), albedo, [lambda: albedo] * (len(ROW) - 1))
    assert {name for one in without for name in one} == {"albedo"}


def across_the_photo(view):
    """Where each pixel of a view's maps lies, pixels from the photo's left, (32, 32, 1)."""
    columns = view.centre_x - 60 + (np.arange(32, dtype=np.float32) + 0.5) * 3.75
    return np.broadcast_to(columns[None, :, None], (32, 32, 1))


def test_a_neighbour_s_channels_are_seen_where_they_lie_in_the_photo():
    first, *others = [{"albedo": across_the_photo(view)} for view in ROW]
    for view, one in zip(
        ROW, channels_together(placed_in_a_row(), first, [lambda o=o: o for o in others]), strict=True
    ):
        # A neighbour's view ends a little further in.
        np.testing.assert_allclose(one["albedo"][:, 1:-1], across_the_photo(view)[:, 1:-1], atol=0.5)


def test_where_two_views_count_as_much_their_channels_are_mixed_and_labels_are_one_or_the_other():
    first, *others = [
        {"albedo": np.full((32, 32), 1.0 + number, np.float32), "parsing": np.full((32, 32), label, np.int32)}
        for number, label in enumerate((2, 13, 2, 2, 2, 2))
    ]
    together = channels_together(placed_in_a_row(), first, [lambda other=other: other for other in others])
    across, labels = together[0]["albedo"][16], together[0]["parsing"][16]
    assert across[16] == pytest.approx(1)
    assert 1.3 < across[29] < 1.8
    assert across[31] > 1.9
    assert (np.diff(across) >= -1e-6).all()
    assert labels.dtype == np.int32
    assert (labels[16], labels[31]) == (2, 13)
    assert set(np.unique(labels)) == {2, 13}


def test_only_channels_that_every_face_has_are_shown():
    albedo, light = {"albedo": np.ones((32, 32, 3), np.float32)}, {"source_light": np.ones((16, 32, 3), np.float32)}
    for first in (albedo | {"specular": np.ones((32, 32))}, light | albedo, albedo | light):
        together = channels_together(placed_in_a_row(), first, [lambda: albedo] * 5)
        assert [set(one) for one in together] == [{"albedo"}] * 6


@pytest.mark.parametrize(("roll_deg", "expected"), [(90.0, (0, 1, 0)), (-90.0, (0, -1, 0)), (0.0, (1, 0, 0))])
def test_normals_of_a_leaning_face_are_as_the_camera_sees_them(roll_deg, expected):
    placement = placed_in_a_row(views=(Crop(50.0, 50.0, 120.0, roll_deg),))
    normal = {"normal": np.broadcast_to(np.float32([1, 0, 0]), (32, 32, 3))}
    (one,) = channels_together(placement, normal, [])
    np.testing.assert_allclose(one["normal"][16, 16], expected, atol=1e-6)


@pytest.mark.parametrize(("weight", "shown"), [(0.2, 1.0), (0.05, 1.0), (0.025, 0.5), (0.0, 0.0)])
def test_channels_fade_where_a_view_counts_for_less_than_a_twentieth(monkeypatch, weight, shown):
    weights = finish.ViewWeights((np.full((32, 32, 1), weight, np.float32),), None)
    monkeypatch.setattr(channels_together_module, "weights_on_views", lambda placement, size: (weights,))
    (one,) = channels_together(placed_in_a_row(views=ROW[:1]), {"albedo": np.ones((32, 32, 3), np.float32)}, [])
    np.testing.assert_allclose(one["albedo"], shown, rtol=1e-5)
