"""Samples that are learnt from several times: how often, which, and the same from wherever a run goes on."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import torch

from relight_core.dataset.samples import mirrored
from relight_core.training.half_kept import halved
from relight_core.training.replay import Replay, mirrored_pairs, replayed

SIZE = 4


def chunk(number, pairs=2):
    """Pairs that tell their number in every channel."""
    told = torch.arange(pairs * number, pairs * (number + 1)).float()

    def image(*shape):
        return told.reshape(-1, *[1] * len(shape)).expand(-1, *shape).clone()

    return {
        "image": image(2, 3, SIZE, SIZE),
        "normal": image(3, SIZE, SIZE),
        "label": torch.zeros(pairs, SIZE, SIZE, dtype=torch.long),
        "light": image(2, 16, 32, 3) + 1 / 3,
    }


def maker(asked=None, pairs=2):
    def make(first):
        if asked is not None:
            asked.append(first)
        return (chunk(number, pairs) for number in itertools.count(first))

    return make


def numbers_of(batch):
    return batch["image"][:, 0, 0, 0, 0].int().tolist()


def drawn(replay, count, first=0, asked=None):
    return list(itertools.islice(replayed(maker(asked, replay.chunk), replay, first, "cpu"), count))


REPLAY = Replay(uses=3, pairs=6, chunk=2, kept=20, seed=5)


def test_every_pair_is_learnt_from_as_often_as_was_asked_for():
    uses = np.bincount(sum((numbers_of(batch) for batch in drawn(REPLAY, 900)), []), minlength=1700)
    assert uses[100:1700].mean() == pytest.approx(3, rel=0.03)
    assert uses[1900:].sum() == 0


def test_a_batch_has_no_pair_twice_and_none_but_the_newest():
    for number, batch in enumerate(drawn(REPLAY, 60)):
        pairs = numbers_of(batch)
        assert len(set(pairs)) == 6
        made = 6 + 2 * number
        assert made - 22 <= min(pairs)
        assert max(pairs) < made


def test_batches_are_the_same_from_wherever_a_run_goes_on():
    whole, asked = drawn(REPLAY, 40), []
    rest = drawn(REPLAY, 10, first=30, asked=asked)
    assert asked[0] > 0
    for one, other in zip(whole[30:], rest, strict=True):
        for name in one:
            assert torch.equal(one[name], other[name]), name


@pytest.mark.parametrize("chunk", [2, 4, 5])
def test_a_window_smaller_than_a_batch_holds_a_batch(chunk):
    small = Replay(uses=2, pairs=6, chunk=chunk, kept=1, seed=0)
    assert all(len(set(numbers_of(batch))) == 6 for batch in drawn(small, 20))


def test_every_batch_is_drawn_anew_by_seed_and_number_and_half_of_the_pairs_are_mirrored():
    others = replace(REPLAY, seed=6)
    places, mirrored_ones = zip(*(REPLAY.drawn(number) for number in range(100, 300)), strict=True)
    assert len({tuple(drawn) for drawn in places}) == 200
    assert np.mean(mirrored_ones) == pytest.approx(0.5, abs=0.06)
    assert all(not np.array_equal(others.drawn(100 + n)[0], drawn) for n, drawn in enumerate(places))
    for first, again in zip(REPLAY.drawn(100), REPLAY.drawn(100), strict=True):
        np.testing.assert_array_equal(first, again)


def test_images_are_kept_in_half_precision_lights_as_they_are():
    batch = drawn(REPLAY, 1)[0]
    assert batch["label"].dtype == torch.int64
    assert batch["image"].dtype == batch["light"].dtype == torch.float32
    assert float(batch["light"].frac().max()) == pytest.approx(1 / 3, abs=1e-5)
    kept = halved({"image": torch.full((1,), 1 / 3), "label": torch.zeros(1, dtype=torch.long)})
    assert (kept["image"].dtype, kept["label"].dtype) == (torch.float16, torch.uint8)


def test_mirrored_pairs_are_as_the_data_set_mirrors_its_samples():
    generator = torch.Generator().manual_seed(0)
    batch = {
        "image": torch.rand(2, 2, 3, SIZE, SIZE, generator=generator),
        "normal": torch.rand(2, 3, SIZE, SIZE, generator=generator),
        "label": torch.randint(14, (2, SIZE, SIZE), generator=generator),
        "light": torch.rand(2, 2, 16, 32, 3, generator=generator),
    }
    result = mirrored_pairs(batch, torch.tensor([False, True]))
    expected = mirrored(
        {
            "image": batch["image"][1, 0].permute(1, 2, 0).numpy(),
            "normal": batch["normal"][1].permute(1, 2, 0).numpy(),
            "label": batch["label"][1].numpy(),
            "light": batch["light"][1, 0].numpy(),
        }
    )
    assert torch.equal(result["image"][1, 0], torch.from_numpy(expected["image"]).permute(2, 0, 1))
    assert torch.equal(result["normal"][1], torch.from_numpy(expected["normal"]).permute(2, 0, 1))
    assert result["label"][1].tolist() == expected["label"].tolist()
    assert torch.equal(result["light"][1, 0], torch.from_numpy(expected["light"]))
    assert all(torch.equal(result[name][0], batch[name][0]) for name in batch)


@pytest.mark.parametrize("wrong", [{"uses": 0}, {"pairs": 0}, {"chunk": 0}, {"kept": 0}])
def test_nothing_to_draw_from_is_refused(wrong):
    with pytest.raises(ValueError, match="1 or more"):
        Replay(**{"uses": 2, "pairs": 4, "chunk": 2, "kept": 8, "seed": 0} | wrong)
