"""Photos of many people: each view's neighbours have a say in it, and nobody else is asked."""

from dataclasses import replace

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.imaging.photo import Photo
from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import canvas_of
from relight_core.pipeline.results import finish
from relight_core.pipeline.results.channels_together import channels_together

ROW = tuple(Crop(50.0 + 100.0 * index, 50.0, 120.0) for index in range(6))
"""Six views; each reaches over those beside it and over no others."""


def placed_in_a_row(people=()):
    flat, whole = np.full((100, 600, 3), 0.3, np.float32), np.ones((1, 1), np.float32)
    matte = Matte(0 * whole, whole, flat[:1, :1], flat[:1, :1], whole)
    return finish.place_views(canvas_of(Photo(flat)), ROW, matte, ReflectionTable(), people)


@pytest.mark.parametrize("known", [False, True])
def test_weights_of_a_view_are_as_if_all_others_were_asked(monkeypatch, known):
    people = tuple((np.eye(32, dtype=np.float32), view) for view in ROW) if known else ()
    placement = placed_in_a_row(people)
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
