"""Batches that are made once, and are the same for whoever asks."""

import itertools
import resource

import pytest
import safetensors.torch
import torch

from relight_core.errors import InputError
from relight_core.training.kept_batches import kept_batches


def maker(asked):
    def make(first):
        asked.append(first)
        for number in itertools.count(first):
            value = torch.full((1, 2, 3, 4, 4), number + 1 / 3)
            yield {"image": value, "light": torch.full((1, 2, 16, 32, 3), 1 / 3), "label": torch.full((1, 4, 4), 13)}

    return make


def some(folder, asked, count, first=0):
    return list(itertools.islice(kept_batches(folder, maker(asked), first), count))


def test_a_batch_is_made_once_and_then_read(tmp_path):
    asked = []
    first, again = some(tmp_path, asked, 3), some(tmp_path, asked, 3)
    assert asked == [0]
    for one, other in zip(first, again, strict=True):
        for name in one:
            assert torch.equal(one[name], other[name])


def test_a_batch_that_the_disk_has_no_room_for_is_told_and_leaves_nothing(tmp_path):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(InputError, match="can't be written"):
            some(tmp_path, [], 1)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list(tmp_path.iterdir())


def test_who_makes_it_meets_it_as_rounded_as_who_reads_it(tmp_path):
    batch = some(tmp_path, [], 1)[0]
    assert batch["image"].dtype == torch.float32
    assert float(batch["image"][0, 0, 0, 0, 0]) == float(torch.tensor(1 / 3).half())
    assert float(batch["light"][0, 0, 0, 0, 0]) == float(torch.tensor(1 / 3))
    assert batch["label"].dtype == torch.int64
    assert batch["label"].unique().tolist() == [13]


def test_only_what_is_missing_is_made(tmp_path):
    asked = []
    some(tmp_path, asked, 4)
    (tmp_path / "batch-000002.safetensors").unlink()
    asked.clear()
    numbers = [int(batch["image"].mean()) for batch in some(tmp_path, asked, 4, first=1)]
    assert numbers == [1, 2, 3, 4]
    assert asked == [2, 4]


def test_a_damaged_batch_is_named(tmp_path):
    some(tmp_path, [], 1)
    (tmp_path / "batch-000000.safetensors").write_bytes(b"x")
    with pytest.raises(InputError, match="batch-000000"):
        some(tmp_path, [], 1)


def test_a_batch_with_one_bit_of_another_value_is_not_learnt_from(tmp_path):
    some(tmp_path, [], 2)
    path = tmp_path / "batch-000001.safetensors"
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"batch-000001.*damaged: its checksum differs.*delete it, it is made again"):
        some(tmp_path, [], 2)
    path.unlink()
    assert len(some(tmp_path, [], 2)) == 2


def test_batches_of_before_there_were_checksums_are_learnt_from(tmp_path):
    expected, path = some(tmp_path, [], 1)[0], tmp_path / "batch-000000.safetensors"
    safetensors.torch.save_file(safetensors.torch.load_file(path), path)
    assert torch.equal(some(tmp_path, [], 1)[0]["image"], expected["image"])


def test_so_many_come_over_and_over_from_any_place_on(tmp_path):
    asked = []
    batches = kept_batches(tmp_path, maker(asked), first=5, among=3)
    assert [int(batch["image"].mean()) for batch in itertools.islice(batches, 5)] == [2, 0, 1, 2, 0]
    assert asked == [2, 0]
