"""A short run of the fuzzer, and that it finds what it looks for."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

import fuzz
from fuzz_corpus import Reader
from fuzz_mutations import damaged

from relight_core.errors import InputError

SCRIPT = Path(__file__).with_name("fuzz.py")


def test_no_reader_lets_anything_but_an_input_error_out():
    run = subprocess.run([sys.executable, SCRIPT, "--count", "15", "--seed", "7"], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.count("15 files, 0 faults") == 8


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
    faults = fuzz.fuzz_reader(Reader(read, [b"\x80" * 8, b"\xff" * 8], ".x"), 30, seed=0)
    assert 3 < len(faults) < 30
    assert all(word in fault for fault in faults.values())


def test_refusing_is_no_fault():
    assert fuzz.fuzz_reader(Reader(refuses, [b"abc"], ".x"), 10, seed=0) == {}
