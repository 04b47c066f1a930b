"""Photos of people who were cut out: what their files hide under alpha 0 is nobody's to see."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tiny_relighter import EDIT, some_light, some_photo

from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import resize_area
from relight_core.pipeline.per_photo import choosing_faces
from relight_core.pipeline.per_photo.person import canvas_of

HIDDEN = [(0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (50.0, 60.0, 70.0)]


def a_share(size=(96, 112)):
    down, across = np.mgrid[: size[0], : size[1]]
    distance = np.hypot((across - 56) / 40, (down - 50) / 44)
    return np.clip((1.1 - distance) / 0.2, 0, 1).astype(np.float32)


def cut_out(hidden, photo=None):
    share = a_share()
    linear = np.where(share[..., None] > 0, (photo or some_photo()).linear, np.float32(hidden))
    return Photo(np.ascontiguousarray(linear, np.float32), share)


@pytest.mark.parametrize("background", ["#808080", "transparent"])
def test_hidden_colours_change_nothing_that_is_seen(relighter, background):
    pictures, edit = [], replace(EDIT, background=background)
    for hidden in HIDDEN:
        photo = cut_out(hidden)
        relighter.set_portrait(photo)
        image, alpha = relighter.relight(some_light(), edit).full.render()
        pictures.append(image[photo.alpha > 0])
        assert alpha is None or np.array_equal(alpha, photo.alpha)
    for other in pictures[1:]:
        np.testing.assert_array_equal(other, pictures[0])


def test_hidden_colours_reach_no_finder(relighter, monkeypatch):
    shown, known = [], {}

    def finder(photo, *judge):
        shown.append(photo.linear)
        return known.setdefault("faces", [FaceBox(24, 20, 72, 76)])

    monkeypatch.setattr(choosing_faces, "find_faces", finder)
    for hidden in HIDDEN[:2]:
        relighter.set_portrait(cut_out(hidden))
    np.testing.assert_array_equal(*shown)


def test_soft_edges_are_relit_in_their_own_colour(relighter):
    photo = cut_out(HIDDEN[1], Photo(np.full((96, 112, 3), 0.4, np.float32)))
    relighter.set_portrait(photo)
    relit = relighter.relight(some_light(), replace(EDIT, background="transparent", forced_off=frozenset({"residual"})))
    full = relit.full
    gain = replace(full, canvas=replace(full.canvas, linear=np.ones_like(photo.linear))).render()[0]
    nothing = replace(full, canvas=replace(full.canvas, linear=np.zeros_like(photo.linear))).render()[0]
    soft = (photo.alpha > 0) & (photo.alpha < 1)
    np.testing.assert_allclose(full.render()[0][soft], (0.4 * (gain - nothing) + nothing)[soft], atol=1e-5)


def test_nor_anything_in_a_preview(relighter):
    previews, share = [], resize_area(a_share(), (24, 28))
    for hidden in HIDDEN:
        relighter.set_portrait(cut_out(hidden))
        previews.append(relighter.relight(some_light(), replace(EDIT, background="#ffffff"), 28).image[share > 0])
    for other in previews[1:]:
        np.testing.assert_array_equal(other, previews[0])


def test_a_smaller_copy_keeps_the_colour_of_its_edge():
    photo = cut_out(HIDDEN[1], Photo(np.full((96, 112, 3), 0.4, np.float32)))
    small = canvas_of(photo, 28)
    assert ((small.alpha > 0) & (small.alpha < 1)).any()
    np.testing.assert_allclose(small.linear[small.alpha > 0], 0.4, atol=1e-5)


@pytest.mark.parametrize("factor", [1e-4, 1e4])
def test_the_grey_behind_a_cut_out_is_in_its_units(factor):
    grey = replace(cut_out(HIDDEN[0], Photo(np.full((96, 112, 3), factor, np.float32))), bits=32).seen.linear
    assert 0.1 < grey.min() / grey.max() < 1.3


@pytest.mark.parametrize(("level", "grey"), [(1.0, 0.18), (0.4, 0.18), (0.05, 0.06), (10.0, 1.8)])
def test_a_cut_out_is_seen_before_a_middle_grey_of_its_brightness(level, grey):
    photo = replace(cut_out(HIDDEN[2], Photo(np.full((96, 112, 3), level, np.float32))), bits=32, path=Path("me.exr"))
    seen = photo.seen
    np.testing.assert_allclose(seen.linear[photo.alpha == 0], grey, rtol=1e-5)
    np.testing.assert_allclose(seen.linear[photo.alpha == 1], level, rtol=1e-5)
    soft = (photo.alpha > 0) & (photo.alpha < 1)
    share = photo.alpha[soft]
    np.testing.assert_allclose(seen.linear[soft][:, 1], share * level + (1 - share) * grey, rtol=1e-5)
    assert (seen.alpha, seen.bits, seen.path) == (None, 32, Path("me.exr"))


def test_a_dark_cut_out_with_a_lit_part_is_not_dark_and_one_of_nothing_is_before_grey():
    linear = np.full((96, 112, 3), 0.02, np.float32)
    linear[40:50] = 0.6
    lit = Photo(linear, a_share())
    np.testing.assert_allclose(lit.seen.linear[lit.alpha == 0], 0.18, rtol=1e-5)
    nothing = Photo(linear, np.zeros((96, 112), np.float32))
    np.testing.assert_allclose(nothing.seen.linear, 0.18, rtol=1e-5)


def test_an_opaque_photo_is_seen_as_it_is():
    photo = some_photo()
    assert photo.seen is photo
    opaque = Photo(photo.linear, np.ones((96, 112), np.float32))
    assert opaque.seen is opaque


class TestWhatIsBlackAndWhite:
    grey = Photo(np.repeat(some_photo().linear[..., 1:2], 3, -1))

    @pytest.mark.parametrize("hidden", HIDDEN)
    def test_hidden_colours_make_no_colour_photo(self, hidden):
        assert cut_out(hidden, self.grey).monochrome

    @pytest.mark.parametrize("hidden", HIDDEN)
    def test_nor_hidden_greys_a_grey_one(self, hidden):
        assert not cut_out(hidden).monochrome

    def test_next_to_a_hidden_lamp_a_floating_point_photo_has_its_colours(self):
        assert not replace(cut_out((5e3, 6e3, 7e3)), bits=32).monochrome

    @pytest.mark.parametrize("hidden", HIDDEN)
    def test_hidden_colours_are_no_part_of_a_tone(self, hidden):
        sepia = Photo(self.grey.linear * np.float32([1.2, 1.0, 0.6]))
        tone = cut_out(hidden, sepia).tone_at(1.0)
        np.testing.assert_allclose(
            tone.at(np.float32([0.1, 0.4]))[:, 2] / tone.at(np.float32([0.1, 0.4]))[:, 0], 0.5, rtol=0.02
        )

    def test_nothing_to_see_has_no_colour(self):
        assert Photo(some_photo().linear, np.zeros((96, 112), np.float32)).monochrome
