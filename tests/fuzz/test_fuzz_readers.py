"""A short run of the fuzzer, and that it finds what it looks for."""

import gc
import mmap
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

import fuzz
from fuzz_corpus import Reader, readers
from fuzz_mutations import damaged

from relight_core.errors import InputError
from relight_core.imaging.formats import exr
from relight_core.imaging.read import read_radiance
from relight_core.imaging.write import write_exr_layers

SCRIPT = Path(__file__).with_name("fuzz.py")


def test_no_reader_lets_anything_but_an_input_error_out():
    run = subprocess.run([sys.executable, SCRIPT, "--count", "12", "--seed", "7"], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.count("12 files, 0 faults") == 24


def test_damage_is_the_same_for_the_same_seed():
    data = bytes(range(256)) * 4
    made = [damaged(data, np.random.default_rng(5)) for _ in range(2)]
    assert made[0] == made[1]
    assert made[0] != data


def refuses(path):
    raise InputError("no")


def fails_on_some(path):
    if path.read_bytes()[:1] > b"\x80":
        raise KeyError("a fault")


def dies_on_some(path):
    if path.read_bytes()[:1] > b"\x80":
        os._exit(9)


@pytest.mark.parametrize(("read", "word"), [(fails_on_some, "KeyError"), (dies_on_some, "died")])
def test_faults_and_deaths_are_found_and_the_next_files_still_tried(read, word):
    faults = fuzz.fuzz_reader(Reader(read, [b"\x80" * 8, b"\xff" * 8], ".x"), 30, seed=0).faults
    assert 3 < len(faults) < 30
    assert all(word in fault for fault in faults.values())


def hangs_on_some(path):
    while path.read_bytes()[:1] > b"\x80":
        pass


def test_a_reader_that_hangs_is_found_and_the_next_files_still_tried(monkeypatch):
    monkeypatch.setattr(fuzz, "_HUNG_S", 0.3)
    found = fuzz.fuzz_reader(Reader(hangs_on_some, [b"\x80" * 8, b"\xff" * 8], ".x"), 4, seed=3)
    assert 0 < len(found.faults) < 4
    assert all("no answer" in fault for fault in found.faults.values())


def test_refusing_is_no_fault():
    found = fuzz.fuzz_reader(Reader(refuses, [b"abc"], ".x"), 10, seed=0)
    assert (found.faults, found.refused) == ({}, 10)


def takes_200_mib(path):
    gc.collect()
    return np.ones(200 << 17)


def collects_and_attacks(*arguments, attack=fuzz.attack):
    gc.collect()
    attack(*arguments)


HELD = []


def lets_go_and_attacks(*arguments, attack=fuzz.attack):
    HELD.clear()
    attack(*arguments)


@pytest.mark.parametrize("attack", [fuzz.attack, collects_and_attacks, lets_go_and_attacks])
def test_a_reader_that_takes_too_much_memory_is_found_whatever_garbage_the_process_had(monkeypatch, attack):
    monkeypatch.setattr(fuzz, "LARGEST_MIB", 100)
    monkeypatch.setattr(fuzz, "attack", attack)
    HELD[:] = [np.ones(300 << 17)]
    garbage = [np.ones(300 << 17)]
    garbage.append(garbage)
    del garbage
    found = fuzz.fuzz_reader(Reader(takes_200_mib, [b"abc"], ".x"), 2, seed=0)
    HELD.clear()
    assert "MiB of memory" in found.faults[0]
    assert found.most_mib > 150


def test_a_reader_that_takes_too_much_memory_is_found_where_the_c_library_kept_freed_memory(monkeypatch):
    monkeypatch.setattr(fuzz, "LARGEST_MIB", 100)
    np.ones(31 << 17)  # once freed, glibc takes blocks up to its size from the heap
    blocks = [np.ones(16 << 17) for _ in range(30)]
    lies_above_them = [np.ones(1 << 12) for _ in range(200)]
    del blocks
    found = fuzz.fuzz_reader(Reader(takes_200_mib, [b"abc"], ".x"), 1, seed=0)
    del lies_above_them
    assert "MiB of memory" in found.faults[0]


def test_a_reader_that_takes_too_much_memory_is_found_where_the_process_has_reserved_more_than_it_may(monkeypatch):
    monkeypatch.setattr(fuzz, "LARGEST_MIB", 100)
    with mmap.mmap(-1, 12 << 30, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, prot=mmap.PROT_READ):
        found = fuzz.fuzz_reader(Reader(takes_200_mib, [b"abc"], ".x"), 1, seed=0)
    assert "MiB of memory" in found.faults[0]


@pytest.mark.parametrize(("name", "number"), [("photo", 3376), ("photo", 9379), ("hdr", 5897), ("tiff", 2622)])
def test_files_that_once_did_harm(tmp_path, name, number):
    reader = readers(tmp_path)[name]
    path = tmp_path / f"mutant{reader.suffix}"
    path.write_bytes(fuzz.mutant(reader.seeds, 0, number))
    with pytest.raises(InputError):
        reader.read(path)


@pytest.mark.parametrize("resolution", ["-Y 8 +X \u00b9\u00b9", "-Y 8 +X " + "9" * 5000, "-Y 99999999 +X 99999999"])
def test_radiance_headers_that_claim_no_size(tmp_path, resolution):
    path = tmp_path / "a.hdr"
    path.write_bytes(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{resolution}\n".encode("latin-1") + bytes(64))
    with pytest.raises(InputError):
        read_radiance(path)


def test_an_exr_of_too_many_channels_is_refused_before_it_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(exr, "MAX_SAMPLES", 8 * 16 * 6)
    noise = np.ones((8, 16, 3), np.float32)
    write_exr_layers(tmp_path / "a.exr", {"RGB": noise, "albedo": noise})
    assert read_radiance(tmp_path / "a.exr").shape == (8, 16, 3)
    write_exr_layers(tmp_path / "b.exr", {"RGB": noise, "albedo": noise, "normal": noise})
    with pytest.raises(InputError, match="9 channels"):
        read_radiance(tmp_path / "b.exr")
