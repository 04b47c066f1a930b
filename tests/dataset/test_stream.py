"""The stream of samples: whose they are, in what order, and what is in them."""

import itertools
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from synthetic_heads import ball, write_balls

from relight_core.dataset import stream as stream_module
from relight_core.dataset.baking.shard import write_shard
from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.recipe import load_split
from relight_core.dataset.stream import SampleStream
from relight_core.errors import InputError


@pytest.fixture(autouse=True)
def few_textures(monkeypatch):
    monkeypatch.setattr(stream_module, "TexturePool", partial(TexturePool, count=2))


def whose(samples):
    """The numbers of the heads of `write_numbered`, which their relief tells."""
    return [round(32 * float(item["relief"].max())) - 1 for item in samples]


def write_numbered(folder, count):
    folder.mkdir()
    for number in range(count):
        head = ball()
        write_shard(folder / f"head-{number:07d}.npz", replace(head, depth=np.full_like(head.depth, (number + 1) / 32)))


def test_samples_have_pairs_of_lights_and_one_surface(tmp_path, library):
    write_balls(tmp_path / "heads", 0, 2, size=32)
    stream = SampleStream(
        tmp_path / "heads",
        library,
        "train",
        16,
        0,
        relief_shadow=True,
        lights_per_head=2,
        paints_per_head=2,
        heads_at_once=1,
    )
    item = next(iter(stream))
    shapes = {name: tuple(value.shape) for name, value in item.items()}
    assert shapes == {
        "photo_srgb": (2, 3, 16, 16),
        "image": (2, 3, 16, 16),
        "light": (2, 16, 32, 3),
        "specular": (2, 1, 16, 16),
        "shadow": (2, 1, 16, 16),
        "relief_shadow": (2, 1, 16, 16),
        "shadow_fraction": (2, 1, 16, 16),
        "gloss_fraction": (2, 1, 16, 16),
        "albedo": (3, 16, 16),
        "normal": (3, 16, 16),
        "relief": (1, 16, 16),
        "covered": (1, 16, 16),
        "label": (16, 16),
    }
    assert all(bool(np.isfinite(value.numpy()).all()) for value in item.values())
    assert 0 <= float(item["photo_srgb"].min()) <= float(item["photo_srgb"].max()) <= 1


@pytest.mark.parametrize("first_batch", [1, 3, 5])
def test_a_stream_goes_on_at_any_batch(first_batch, tmp_path, library):
    write_balls(tmp_path / "heads", 0, 3, size=32)

    def stream(**place):
        settings = {"lights_per_head": 2, "paints_per_head": 2, "heads_at_once": 2, "pairs": 2}
        return iter(SampleStream(tmp_path / "heads", library, "train", 16, 7, **settings, **place))

    whole = list(itertools.islice(stream(), 12))
    later = list(itertools.islice(stream(first_batch=first_batch), 2))
    for expected, found in zip(whole[2 * first_batch :], later, strict=False):
        for name, value in expected.items():
            np.testing.assert_array_equal(found[name].numpy(), value.numpy())


def test_of_two_workers_each_has_samples_of_its_own_and_a_run_goes_on_at_any_batch(tmp_path, library, monkeypatch):
    write_numbered(tmp_path / "heads", 24)
    settings = {"plain": True, "photographs": False, "lights_per_head": 2, "paints_per_head": 2, "heads_at_once": 2}

    def samples(worker, count, first_batch=0):
        told = SimpleNamespace(id=worker, num_workers=2)
        monkeypatch.setattr(stream_module, "get_worker_info", lambda: told)
        stream = SampleStream(tmp_path / "heads", library, "train", 16, 3, **settings, pairs=2, first_batch=first_batch)
        return [item["light"].numpy() for item in itertools.islice(stream, count)]

    whole = [samples(worker, 6) for worker in (0, 1)]
    assert not any(np.array_equal(one, other) for one in whole[0] for other in whole[1])
    # The batch numbered 3 is the second worker's second one; after that comes the first worker's third.
    np.testing.assert_array_equal(samples(0, 2, first_batch=3), whole[1][2:4])
    np.testing.assert_array_equal(samples(1, 2, first_batch=3), whole[0][4:6])


def test_another_seed_gives_other_samples_and_the_same_one_the_same(tmp_path, library):
    write_numbered(tmp_path / "heads", 2)
    settings = {"plain": True, "photographs": False, "lights_per_head": 2, "paints_per_head": 1, "heads_at_once": 1}
    heads = tmp_path / "heads"
    one, again, other = (next(iter(SampleStream(heads, library, "train", 16, s, **settings))) for s in (3, 3, 4))
    for name in ("light", "albedo"):
        np.testing.assert_array_equal(one[name], again[name])
        assert not np.array_equal(one[name], other[name])


def test_every_head_comes_once_before_any_comes_again(tmp_path, library):
    write_balls(tmp_path / "heads", 0, 4, size=16)
    stream = SampleStream(tmp_path / "heads", library, "train", 16, 0, heads_at_once=1)
    paths = load_split(tmp_path / "heads", "train")
    for epoch in range(3):
        seen = [stream._head(0, 4 * epoch + part, paths) for part in range(4)]
        assert sorted(seen) == paths


def test_a_batch_is_of_different_heads_and_so_are_the_next(tmp_path, library):
    write_numbered(tmp_path / "heads", 24)
    settings = {"plain": True, "photographs": False, "lights_per_head": 2, "paints_per_head": 3, "heads_at_once": 8}
    samples = SampleStream(tmp_path / "heads", library, "train", 16, 3, **settings, pairs=4)
    found = whose(itertools.islice(samples, 72))
    batches = [found[i : i + 4] for i in range(0, 72, 4)]
    # A head that follows one whose turn is over may have its own in the same batch.
    assert np.mean([len(set(batch)) == 4 for batch in batches]) > 0.6
    assert np.mean([len(set(found[i : i + 12])) for i in range(60)]) > 7
    # 24 heads of 3 samples each, but for those still lit at the end.
    counts = np.bincount(found, minlength=24)
    assert counts.max() <= 8
    assert (counts > 0).sum() >= 20


def test_a_worker_never_has_fewer_heads_than_a_batch_has_pairs(tmp_path, library):
    write_numbered(tmp_path / "heads", 4)
    settings = {"plain": True, "photographs": False, "lights_per_head": 2, "paints_per_head": 50, "heads_at_once": 1}
    samples = SampleStream(tmp_path / "heads", library, "train", 16, 3, **settings, pairs=4)
    assert set(whose(itertools.islice(samples, 4))) == {0, 1, 2, 3}


def test_nothing_is_done_to_a_photo_that_was_taken(tmp_path, library, monkeypatch):
    """Turned and enlarged, noise would be weaker and JPEG's blocks would lean."""
    write_balls(tmp_path / "heads", 0, 2, size=64)
    noise, seen = np.random.default_rng(0).random((64, 64, 3), np.float32), []

    def photograph(radiance, coverage, *_, **__):
        seen.append((radiance, coverage))
        return noise

    monkeypatch.setattr(stream_module, "photograph", photograph)
    samples = SampleStream(tmp_path / "heads", library, "train", 64, 5, lights_per_head=2, heads_at_once=2)
    for item in itertools.islice(samples, 4):
        for photo in item["photo_srgb"]:
            np.testing.assert_array_equal(photo.permute(1, 2, 0).numpy(), noise)
        for radiance, coverage in seen[-2:]:
            covered = item["covered"][0].numpy() > 0.5
            assert (coverage[covered] > 0.5).all()
            assert (radiance[coverage == 0] == 0).all()
            # The head stands in the photo where the channels say.
            assert radiance[covered].mean() > 0.01


def test_no_heads_is_an_input_error(tmp_path, library):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="bake"):
        next(iter(SampleStream(tmp_path / "empty", library, "train", 16, 0)))


@pytest.mark.parametrize("size", [48, 96, 128])
def test_a_size_that_heads_do_not_have_is_refused(size, tmp_path, library):
    write_balls(tmp_path / "heads", 0, 1, size=64)
    with pytest.raises(InputError, match=f"no size of {size}"):
        next(iter(SampleStream(tmp_path / "heads", library, "train", size, 0, heads_at_once=1)))
