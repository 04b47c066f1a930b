"""Two data sets by what a network learns from them: the measures, and training that is done once."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from synthetic_heads import write_balls, write_lights

from relight_core.dataset import stream
from relight_core.dataset.painting.texture import TexturePool
from relight_core.errors import InputError
from relight_core.evaluation import dataset_effect
from relight_core.evaluation.dataset_effect import DelitFace, TrainingSettings, measure, trained
from relight_core.face.find import FaceBox
from relight_core.imaging.write import write_image
from relight_core.networks.bundle import BundleConfig, NetworkBundle

SIZE = 32


def person(tone, contrast=1.0, slope=0.0, albedo_slope=0.0):
    """A face of one tone with a pattern on it, lit more from one side by `slope` stops from edge to edge."""
    pattern = np.random.default_rng(0).normal(0, 0.3, (SIZE, SIZE))
    across = np.linspace(-0.5, 0.5, SIZE)
    photo = 2.0 ** (tone + pattern + slope * across)
    albedo = 2.0 ** (tone + contrast * pattern + albedo_slope * across)
    face = np.zeros((SIZE, SIZE), bool)
    face[4:-4, 4:-4] = True
    shown = (encode(np.repeat(x[..., None], 3, -1)) for x in (photo, albedo))
    return DelitFace(*shown, np.zeros((SIZE, SIZE, 3)), face)


def encode(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055).astype(np.float32)


def test_an_albedo_with_the_photos_edges_keeps_all_detail_and_a_flat_one_none():
    assert measure([person(-2)]).detail == pytest.approx(1, abs=1e-3)
    assert measure([person(-2, contrast=0.0)]).detail == pytest.approx(0, abs=1e-3)
    assert measure([person(-2, contrast=-1.0)]).detail == pytest.approx(-1, abs=1e-3)


@pytest.mark.parametrize("turned", [False, True])
def test_edges_of_both_directions_count_and_what_is_nearly_black_has_none(turned):
    seen = person(-2)
    stripes = encode(np.broadcast_to(0.3 + 0.1 * np.cos(np.arange(SIZE))[:, None, None], (SIZE, SIZE, 1)))
    image = np.repeat(stripes.swapaxes(0, 1) if turned else stripes, 3, -1)
    assert measure([replace(seen, photo_srgb=image, albedo_srgb=image)]).detail == pytest.approx(1, abs=1e-3)
    assert measure([person(-9)]).detail == 0


def test_people_of_one_tone_have_no_spread_and_of_two_half_their_distance():
    assert measure([person(-2), person(-2)]).spread == pytest.approx(0, abs=1e-5)
    assert measure([person(-1.5), person(-4.5)]).spread == pytest.approx(1.5, abs=0.01)


def test_light_left_is_the_part_of_the_sides_difference_that_the_albedo_keeps():
    assert measure([person(-2, slope=2, albedo_slope=1)]).light_left == pytest.approx(0.5, abs=0.05)
    assert measure([person(-2, slope=-2, albedo_slope=0)]).light_left == pytest.approx(0, abs=0.1)
    assert np.isnan(measure([person(-2)]).light_left)
    aside = person(-2, slope=2, albedo_slope=1)
    aside.face[:, :20] = False
    # The halves of a face of eight columns, which all lie right of the picture's middle.
    aside.albedo_srgb[:, :24], aside.albedo_srgb[:, 24:] = 0.3, 0.6
    aside.photo_srgb[:, :24], aside.photo_srgb[:, 24:] = 0.3, 0.6
    assert measure([aside]).light_left == pytest.approx(1, abs=1e-3)


def test_no_face_gives_no_figures():
    nobody = person(-2)
    nobody.face[:] = False
    figures = measure([nobody])
    assert np.isnan([figures.detail, figures.spread, figures.light_left]).all()


def test_a_face_of_a_few_pixels_tells_no_detail():
    seen = person(-2)
    seen.face[:] = False
    seen.face[4:9, 4:10] = True
    assert np.isnan(measure([seen]).detail)
    assert measure([seen]).spread == 0


@pytest.fixture
def two_faces(tmp_path, monkeypatch):
    """Photos of which the second alone has faces, small ones: a grey at the left, before a white at the right."""
    paths = [tmp_path / "nobody.png", tmp_path / "two.png"]
    picture = np.full((40, 120, 3), 0.1, np.float32)
    picture[:, 80:] = 0.8
    for path, image in zip(paths, (0 * picture + 0.05, picture), strict=True):
        write_image(path, image)
    monkeypatch.setattr(dataset_effect, "find_faces", lambda photo: [])
    monkeypatch.setattr(dataset_effect, "find_small_faces", lambda photo: [1] if photo.linear.max() > 0.5 else [])
    boxes = [FaceBox(15, 15, 25, 25), FaceBox(95, 15, 105, 25)]
    monkeypatch.setattr(dataset_effect, "choose_faces", lambda photo: boxes)
    monkeypatch.setattr(dataset_effect, "load_bundle", lambda path: NetworkBundle(BundleConfig.tiny()))
    return paths


def test_photos_with_a_face_however_small_are_shown_by_their_first(two_faces):
    assert dataset_effect.photos_of_people(two_faces) == two_faces[1:]
    with pytest.raises(InputError, match=r"nobody\.png: no face in this photo"):
        dataset_effect.photos_of_people(two_faces[:1])
    with pytest.raises(InputError, match="no face in any"):
        dataset_effect.photos_of_people(two_faces[:1] * 2)
    networks = {name: NetworkBundle(BundleConfig.tiny()).eval() for name in ("plain", "varied")}
    shown = dataset_effect.compare_photos(networks, two_faces[1:], 16)
    assert [name for name, _ in shown.pictures] == [
        "photo",
        "albedo, plain",
        "albedo, varied",
        "normal, plain",
        "normal, varied",
    ]
    photo = shown.pictures[0][1]
    assert photo.shape == (16, 16, 3)
    assert photo.mean() == pytest.approx(float(encode(np.float32(0.1))), abs=0.01)
    assert (shown.photos, set(shown.figures)) == (1, {"plain", "varied"})


@pytest.mark.parametrize("plain", [True, False])
def test_a_network_is_trained_once_and_gives_the_same_weights_again(tmp_path, monkeypatch, plain):
    monkeypatch.setattr(stream, "TexturePool", partial(TexturePool, count=2))
    write_balls(tmp_path / "heads", 0, 2)
    write_lights(tmp_path / "lights.npz", 6)
    settings = TrainingSettings(steps=2, size=16, pairs=1, width=4)

    def train(name, settings=settings, lights="lights.npz", plain=plain):
        where = tmp_path / f"{name}.safetensors"
        return trained(tmp_path / "heads", tmp_path / lights, settings, where, lambda *_: None, plain=plain)

    first, again = train("one").state_dict(), train("two").state_dict()
    assert all((first[name] == again[name]).all() for name in first)
    written = (tmp_path / "one.safetensors").stat().st_mtime_ns
    with pytest.raises(InputError, match="trained otherwise"):
        train("one", replace(settings, steps=3))
    with pytest.raises(InputError, match="trained otherwise"):
        train("one", plain=not plain)
    write_lights(tmp_path / "others.npz", 7)
    with pytest.raises(InputError, match="trained otherwise"):
        train("one", lights="others.npz")
    kept = train("one").state_dict()
    assert (tmp_path / "one.safetensors").stat().st_mtime_ns == written
    assert all((first[name] == kept[name]).all() for name in first)
