"""Layers of one size: every channel lies in the photo where the face is."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.pipeline.results import layers as layers_module
from relight_core.pipeline.results.channels import unrolled
from relight_core.pipeline.results.layers import channel_at, channel_view_of, photo_layers, shrunk_picture
from relight_core.pipeline.results.relit import Relit

HEIGHT, WIDTH, SIDE = 60, 80, 20


def relit(alpha=None):
    image = np.full((HEIGHT, WIDTH, 3), 0.5, np.float32)
    labels = np.full((SIDE, SIDE), 3, np.int32)
    labels[:, SIDE // 2 :] = 7
    channels = {
        "albedo": np.full((SIDE, SIDE, 3), 0.8, np.float32),
        "normal": np.broadcast_to(np.float32([0.6, 0.0, 0.8]), (SIDE, SIDE, 3)),
        "specular": np.full((SIDE, SIDE), 0.2, np.float32),
        "parsing": labels,
    }
    return Relit(image, alpha, channels, [], window=(20.0, 10.0, 60.0, 50.0))


def with_matte(picture, monkeypatch):
    """The same with a person in the middle, at the size of a photo that `image` is the whole of."""
    share = np.zeros((HEIGHT, WIDTH), np.float32)
    share[10:50, 20:60] = 1.0
    monkeypatch.setattr(layers_module, "whole_person", lambda canvas, matte: SimpleNamespace(share=share))
    canvas = SimpleNamespace(photo_size=(HEIGHT, WIDTH), beyond=None)
    full = SimpleNamespace(size=(HEIGHT, WIDTH), changes=(), canvas=canvas, matte=None)
    full.behind = lambda band: (0.5 * (1 - share[band.rows, :, None])) * np.ones(3, np.float32)
    return replace(picture, full=full)


@pytest.mark.parametrize(("longest", "scale"), [(None, 1), (40, 0.5), (500, 1)])
def test_every_layer_has_the_pictures_size_and_lies_where_the_view_is(longest, scale, monkeypatch):
    picture = with_matte(relit(), monkeypatch)
    layers = photo_layers(picture, ["albedo", "normal", "specular", "parsing", "matte", "background"], longest)
    assert {layer.shape[:2] for layer in layers.values()} == {(HEIGHT * scale, WIDTH * scale)}
    inside, outside = (int(30 * scale), int(40 * scale)), (int(4 * scale), int(4 * scale))
    assert np.allclose(layers["albedo"][inside], 0.8, atol=1e-5)
    assert np.allclose(layers["normal"][inside], [0.6, 0.0, 0.8], atol=1e-5)
    assert layers["specular"][inside] == pytest.approx(0.2)
    assert (layers["matte"][inside], layers["matte"][outside]) == (1.0, 0.0)
    assert layers["background"][inside].max() == 0.0
    assert np.allclose(layers["background"][outside], 0.5)
    for name in ("albedo", "normal", "specular", "parsing"):
        assert np.all(layers[name][outside] == 0)


def test_of_several_faces_each_place_shows_the_one_whose_middle_is_nearest():
    views = Crop(20.0, 30.0, 40.0), Crop(50.0, 30.0, 40.0, roll_deg=90.0)
    faces = [{"albedo": np.full((SIDE, SIDE, 3), share, np.float32)} for share in (0.25, 0.75)]
    faces[1]["normal"] = faces[0]["normal"] = np.broadcast_to(np.float32([0.3, 0.0, 0.4]), (SIDE, SIDE, 3))
    canvas = SimpleNamespace(photo_size=(HEIGHT, WIDTH), beyond=None)
    full = SimpleNamespace(size=(HEIGHT, WIDTH), changes=[SimpleNamespace(view=view) for view in views], canvas=canvas)
    layers = photo_layers(replace(relit(), full=full, channels_together=lambda: faces), ["albedo", "normal", "shadow"])
    assert np.allclose(layers["albedo"][30, 2:34], 0.25, atol=1e-5)
    assert np.allclose(layers["albedo"][30, 36:68], 0.75, atol=1e-5)
    assert not layers["albedo"][30, 72:].any()
    assert np.allclose(layers["normal"][30, 2:68], [0.6, 0.0, 0.8], atol=1e-5), "in camera space already"
    assert "shadow" not in layers


def test_views_that_lie_aslant_of_each_other_leave_each_other_s_places_alone():
    views = Crop(25.0, 20.0, 40.0), Crop(50.0, 40.0, 40.0)
    faces = [{"albedo": np.full((SIDE, SIDE), share, np.float32)} for share in (0.25, 0.75)]
    canvas = SimpleNamespace(photo_size=(HEIGHT, WIDTH), beyond=None)
    full = SimpleNamespace(size=(HEIGHT, WIDTH), changes=[SimpleNamespace(view=view) for view in views], canvas=canvas)
    layer = photo_layers(replace(relit(), full=full, channels_together=lambda: faces), ["albedo"])["albedo"]
    for column, row, share in ((10, 10, 0.25), (33, 24, 0.25), (36, 24, 0.25), (36, 38, 0.75), (60, 50, 0.75)):
        assert layer[row, column] == pytest.approx(share, abs=1e-5)
    assert layer[50, 10] == layer[10, 60] == 0


@pytest.mark.parametrize(("length", "expected"), [(0.2, 0.0), (0.3, 1.0), (1.0, 1.0)])
def test_normals_are_of_unit_length_on_the_person_and_none_beside_it(length, expected):
    picture = relit()
    picture.channels["normal"] = np.float32(length) * picture.channels["normal"]
    shown = photo_layers(picture, ["normal"])["normal"][30, 40]
    np.testing.assert_allclose(shown, expected * np.float32([0.6, 0, 0.8]), atol=1e-5)
    held, in_camera = channel_at(picture, "normal", 40, 30)
    np.testing.assert_allclose(held, length * np.float32([0.6, 0, 0.8]), atol=1e-5)
    np.testing.assert_allclose(in_camera, expected * np.float32([0.6, 0, 0.8]), atol=1e-5)


def test_a_leaning_face_s_normal_is_read_as_its_view_and_as_the_camera_sees_it():
    held, in_camera = channel_at(replace(relit(), roll_deg=90.0), "normal", 40, 30)
    np.testing.assert_allclose(held, [0.6, 0, 0.8], atol=1e-5)
    np.testing.assert_allclose(in_camera, [0, 0.6, 0.8], atol=1e-5)
    placed = photo_layers(replace(relit(), roll_deg=90.0), ["normal"])["normal"][30, 40]
    np.testing.assert_allclose(placed, in_camera, atol=1e-5)


def test_a_pixel_is_in_the_view_where_its_middle_is():
    picture = replace(relit(), window=(20.3, 10.3, 60.7, 50.7))
    inside = {place for place in ((20, 30), (60, 30), (40, 10), (40, 50)) if channel_at(picture, "albedo", *place)}
    assert inside == {(20, 30), (60, 30), (40, 10), (40, 50)}
    for place in ((19, 30), (61, 30), (40, 9), (40, 51)):
        assert channel_at(picture, "albedo", *place) is None
    shifted = replace(relit(), window=(20.7, 10.7, 60.3, 50.3))
    for place in ((20, 30), (60, 30), (40, 10), (40, 50)):
        assert channel_at(shifted, "albedo", *place) is None


def test_channels_lie_where_the_first_face_is():
    views = Crop(20.0, 30.0, 40.0), Crop(50.0, 30.0, 40.0)
    full = SimpleNamespace(changes=[SimpleNamespace(view=view) for view in views])
    assert channel_view_of(replace(relit(), full=full)) == views[0]


@dataclass
class Coloured:
    """A picture of a photo with colours outside Rec.709, which are there where they are asked for."""

    canvas: SimpleNamespace
    wide: bool = False
    size: tuple[int, int] = (HEIGHT, WIDTH)
    changes: tuple = ()
    matte: None = None

    def render(self):
        return np.full((HEIGHT, WIDTH, 3), -0.25 if self.wide else 0.0, np.float32), None

    def behind(self, band):
        return np.full((HEIGHT, WIDTH, 3), -0.25 if self.wide else 0.0, np.float32)[band.rows]


def test_layers_keep_colours_outside_rec_709_where_the_photo_has_any():
    canvas = SimpleNamespace(photo_size=(HEIGHT, WIDTH), beyond=np.zeros((2, 2, 3), np.float32))
    layers = photo_layers(replace(relit(), full=Coloured(canvas)), ["background"])
    assert (layers["RGB"] == -0.25).all()
    assert (layers["background"] == -0.25).all()


def test_a_channel_that_becomes_smaller_is_averaged():
    stripes = np.tile(np.float32([0.0, 1.0]), (SIDE, SIDE // 2))
    picture = replace(relit(), channels={"specular": stripes})
    # Eight pixels for twenty stripes, of which each shows two and a half.
    placed = photo_layers(picture, ["specular"], 16)["specular"][4:8, 5:11]
    np.testing.assert_allclose(placed, 0.5, atol=0.11)


def test_labels_are_not_mixed():
    labels = photo_layers(relit(), ["parsing"])["parsing"]
    assert set(np.unique(labels)) == {0.0, 3.0, 7.0}
    assert labels[30, 39] == 3.0
    assert labels[30, 40] == 7.0
    assert (labels != 0).sum() == 1600


def test_alpha_is_multiplied_in_once_and_divided_out_for_straight_files():
    alpha = np.zeros((HEIGHT, WIDTH), np.float32)
    alpha[:, 40:] = 0.5
    cut_out = relit(alpha)
    assert np.allclose(photo_layers(cut_out, [])["RGBA"][30, 70], [0.25, 0.25, 0.25, 0.5])
    image, small_alpha = shrunk_picture(cut_out, 40)
    assert image.shape == (30, 40, 3)
    assert np.allclose(image[15, 30], 0.5)
    assert small_alpha[15, 30] == 0.5


def test_what_a_cut_out_hides_does_not_mix_into_the_edge_of_its_smaller_copy():
    alpha, image = np.zeros((HEIGHT, WIDTH), np.float32), np.full((HEIGHT, WIDTH, 3), 0.5, np.float32)
    alpha[:, 41:], image[:, :41] = 1.0, 9.0
    small, small_alpha = shrunk_picture(replace(relit(alpha), image=image), 40)
    assert small_alpha[15, 19:22].tolist() == [0.0, 0.5, 1.0]
    assert np.allclose(small[15, 20:], 0.5)


def test_a_picture_made_small_for_the_screen_is_exported_at_the_photos_size():
    whole = np.full((HEIGHT, WIDTH, 3), 0.25, np.float32)
    canvas = SimpleNamespace(photo_size=(HEIGHT, WIDTH), beyond=None)
    full = SimpleNamespace(size=(HEIGHT, WIDTH), changes=(), render=lambda: (whole, None), canvas=canvas)
    small = replace(relit(), image=np.zeros((6, 8, 3), np.float32), full=full)
    assert small.size == (HEIGHT, WIDTH)
    assert np.array_equal(photo_layers(small, ["albedo"])["RGB"], whole)
    assert photo_layers(small, ["albedo"])["albedo"][30, 40].min() == pytest.approx(0.8)
    assert np.array_equal(shrunk_picture(small, None)[0], whole)
    drawn_by_a_shader = replace(small, image=None)
    assert np.array_equal(photo_layers(drawn_by_a_shader, [])["RGB"], whole)
    assert shrunk_picture(drawn_by_a_shader, 40)[0].shape == (30, 40, 3)
    assert shrunk_picture(drawn_by_a_shader, 500)[0].shape == (HEIGHT, WIDTH, 3)


def test_layers_that_are_not_there_are_left_out_and_unknown_ones_refused():
    assert "shadow" not in photo_layers(relit(), ["shadow"])
    with pytest.raises(ValueError, match="sparkle"):
        photo_layers(relit(), ["sparkle"])


@pytest.mark.parametrize("roll_deg", [0.0, 30.0, 90.0])
def test_what_faces_the_right_of_a_turned_view_faces_where_that_lies_in_the_photo(roll_deg):
    left, right = Crop(50.0, 40.0, 10.0, roll_deg).to_photo(np.array([[0.0, 0.5], [1.0, 0.5]]), 1)
    across, down = (right - left) / 10
    np.testing.assert_allclose(unrolled(np.float32([1, 0, 0]), roll_deg), [across, -down, 0], atol=1e-6)
    np.testing.assert_allclose(unrolled(np.float32([0, 1, 0]), roll_deg), [down, across, 0], atol=1e-6)
    np.testing.assert_allclose(unrolled(np.float32([0, 0, 1]), roll_deg), [0, 0, 1], atol=1e-6)
