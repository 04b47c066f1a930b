"""What samples say of their light, in a mirror too, and what a camera is told of what stands before it."""

import itertools
from functools import partial

import numpy as np
import pytest
from synthetic_heads import write_balls

from relight_core.dataset import stream as stream_module
from relight_core.dataset.lighting.occluders import Occluder
from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.stream import SampleStream
from relight_core.lighting.sphere import directions, solid_angles

GREY = np.float32([0.2126, 0.7152, 0.0722])
TOWARD, SOLID = directions(16, 32).reshape(-1, 3), solid_angles(16, 32).reshape(-1, 1)


@pytest.fixture(autouse=True)
def few_textures(monkeypatch):
    monkeypatch.setattr(stream_module, "TexturePool", partial(TexturePool, count=2))


@pytest.fixture(scope="module")
def heads(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stream") / "heads"
    write_balls(folder, 0, 2, size=32)
    return folder


def items(heads, library, count, **settings):
    settings = {"lights_per_head": 2, "paints_per_head": 4, "heads_at_once": 2} | settings
    return list(itertools.islice(SampleStream(heads, library, "train", 16, 2, **settings), count))


def lit_by(normal, light):
    """What a light does to white of these normals (N, 3)."""
    return np.maximum(normal @ TOWARD.T, 0) @ (light.reshape(-1, 3) * SOLID) / np.pi


@pytest.mark.parametrize("plain", [True, False])
def test_a_sample_is_as_bright_as_its_light_makes_its_surface(heads, library, plain):
    for item in items(heads, library, 8, photographs=False, plain=plain):
        sample = {name: value.numpy() for name, value in item.items()}
        covered = sample["covered"][0] > 0
        normal, albedo = sample["normal"][:, covered].T, sample["albedo"][:, covered].T
        for image, specular, light in zip(sample["image"], sample["specular"], sample["light"], strict=True):
            matt = image[:, covered].T @ GREY - specular[0, covered]
            error = np.abs(matt - (albedo * lit_by(normal, light)) @ GREY)
            # Turned, a light of 16 rows is a little blurred.
            assert error.mean() < (0.02 if plain else 0.05) * matt.mean()
        assert not np.allclose(*sample["light"])


def seen_by_a_camera(monkeypatch, heads, library, count, **settings):
    """Samples, and what the camera was told for both photos of each."""
    told = []

    def photograph(radiance, coverage, light, white, pool, rng, *, hidden, neighbour):
        told.append((radiance, coverage > 0.5, light, white, hidden, neighbour))
        return np.zeros((16, 16, 3), np.float32)

    monkeypatch.setattr(stream_module, "photograph", photograph)
    made = items(heads, library, count, **settings)
    return [(item, told[2 * number : 2 * number + 2]) for number, item in enumerate(made)]


def test_a_camera_is_told_the_light_of_its_own_photo(monkeypatch, heads, library):
    in_mirrors = []
    for item, photos in seen_by_a_camera(monkeypatch, heads, library, 8, plain=True):
        for light, (_, _, told, white, hidden, neighbour) in zip(item["light"].numpy(), photos, strict=True):
            in_mirrors.append(np.array_equal(told[:, ::-1], light))
            assert in_mirrors[-1] or np.array_equal(told, light)
            normal = item["normal"].numpy()[:, item["covered"][0].numpy() > 0].T
            assert white == pytest.approx(lit_by(normal, light).mean(), rel=0.1)
            assert hidden is None
            assert neighbour is None
    assert 0 < sum(in_mirrors) < 16
    ((item, photos),) = seen_by_a_camera(monkeypatch, heads, library, 1)
    for light, (_, _, told, *_) in zip(item["light"].numpy(), photos, strict=True):
        assert not any(np.allclose(one, light) for one in (told, told[:, ::-1])), "it is turned with its head"


def test_nothing_is_to_be_learnt_of_what_an_object_hides(monkeypatch, heads, library):
    before = Occluder(np.float32([[0.2, 0, 2]]), np.float32([0.5]))
    monkeypatch.setattr(stream_module, "sample_occluder", lambda rng: before)
    hiding = []
    for item, photos in seen_by_a_camera(monkeypatch, heads, library, 16, paints_per_head=1):
        for _, coverage, _, _, hidden, _ in photos:
            hiding.append(hidden is not None)
            if hidden is not None:
                assert 20 < (hidden & coverage).sum() < coverage.sum()
                assert item["covered"][0].numpy()[hidden].max() == 0
                assert (item["label"].numpy()[hidden] == 0).mean() > 0.9
    assert 0.05 < np.mean(hiding) < 0.6


def test_some_heads_have_somebody_beside_them_in_both_photos(monkeypatch, heads, library):
    seen = seen_by_a_camera(monkeypatch, heads, library, 40, paints_per_head=40)
    beside = [[neighbour is not None for *_, neighbour in photos] for _, photos in seen]
    assert all(one == other for one, other in beside), "both photos of a pair are of the same company"
    assert 0.05 < np.mean(beside) < 0.45


def test_on_a_part_of_some_photos_lies_another_light(monkeypatch, heads, library):
    real, count = stream_module.with_local_light, []
    monkeypatch.setattr(stream_module, "with_local_light", lambda *given: count.append(1) or real(*given))
    seen_by_a_camera(monkeypatch, heads, library, 20, paints_per_head=20)
    assert 0.05 < len(count) / 40 < 0.45
    count.clear()
    seen_by_a_camera(monkeypatch, heads, library, 10, plain=True)
    assert count == []
