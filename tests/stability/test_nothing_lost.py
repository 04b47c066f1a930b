"""Killed, full, read-only, hostile places: the old file or the new one is there, and the message is clear."""

import json
import os
import subprocess
import sys
from pathlib import Path

import kill_everywhere
import numpy as np
import pytest
import torch
from safetensors import safe_open

from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes, whole_file
from relight_core.imaging.read import read_photo
from relight_core.imaging.write import write_image
from relight_core.lighting.environment import read_environment
from relight_core.lighting.rig_description import read_rig
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle
from relight_core.pipeline.relighter import WEIGHTS
from relight_core.resources import resource_path
from relight_core.training.optimiser import Optimiser
from relight_core.training.state import Progress, make_state


def test_killed_before_each_of_its_steps_every_writer_leaves_the_old_or_the_new():
    script = Path(__file__).with_name("kill_everywhere.py")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    counts = json.loads(done.stdout)
    assert len(counts) == 11
    assert min(counts.values()) >= 3, counts


def test_a_kind_of_writer_that_is_not_there_is_not_passed_over(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["kill_everywhere.py", "settings", "PNG"])
    with pytest.raises(SystemExit) as ended:
        kill_everywhere.main()
    assert ended.value.code == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert "'PNG' is none of png," in told.err


def test_a_disk_that_fills_up_leaves_the_old_weights(tmp_path, monkeypatch):
    path = tmp_path / "w.safetensors"
    path.write_bytes(b"old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="no space left"):
        save_bundle(path, NetworkBundle(BundleConfig.tiny()))
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["w.safetensors"]


READERS = [read_photo, read_environment, read_rig, load_bundle, file_bytes]


@pytest.mark.parametrize("read", READERS)
def test_a_pipe_never_blocks_a_reader(tmp_path, read):
    os.mkfifo(tmp_path / "pipe.png")
    with pytest.raises(InputError, match="not a regular file"):
        read(tmp_path / "pipe.png")


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="no such device here")
@pytest.mark.parametrize("read", READERS)
def test_a_device_without_end_is_refused(read):
    with pytest.raises(InputError, match="not a regular file"):
        read(Path("/dev/zero"))


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("kind", ["folder", "loop", "dangling", "empty", "missing"])
def test_odd_places_get_one_line(tmp_path, read, kind):
    path = tmp_path / "odd.hdr"
    if kind == "folder":
        path.mkdir()
    elif kind == "loop":
        path.symlink_to(path)
    elif kind == "dangling":
        path.symlink_to(tmp_path / "nowhere")
    elif kind == "empty":
        path.touch()
    with pytest.raises(InputError) as refusal:
        read(path)
    assert "\n" not in str(refusal.value)
    assert "odd.hdr" in str(refusal.value)


@pytest.mark.parametrize("name", ["new\nline.png", "tab\t.png", b"\xff\xfe.png", "\N{PILE OF POO} \u202e.png"])
def test_names_that_are_no_plain_text(tmp_path, name):
    path = tmp_path / (os.fsdecode(name) if isinstance(name, bytes) else name)
    write_image(path, np.full((4, 4, 3), 0.25, np.float32))
    assert read_photo(path).linear.shape == (4, 4, 3)


def test_two_writers_of_one_file_leave_one_of_them_whole(tmp_path):
    path = tmp_path / "a.txt"
    with whole_file(path) as one, whole_file(path) as other:
        assert one != other
        one.write_text("one")
        other.write_text("other")
    assert path.read_text() in ("one", "other")
    assert os.listdir(tmp_path) == ["a.txt"]


def test_the_shipped_weights_carry_their_checksum():
    with safe_open(resource_path(*WEIGHTS), framework="pt") as file:
        assert len(file.metadata()["sha256"]) == 64


def test_a_training_run_never_writes_what_is_not_finite(tmp_path):
    weights = torch.nn.Linear(2, 2)
    average, optimiser = {"a": torch.ones(1)}, Optimiser(weights, 1e-3)
    path = tmp_path / "run.safetensors"
    settings = {"stage": "warm-delight"}
    make_state(settings, Progress(step=1), weights, average, optimiser).write(path)
    before = path.read_bytes()
    average["a"][0] = float("nan")
    with pytest.raises(ValueError, match="not finite"):
        make_state(settings, Progress(step=2), weights, average, optimiser).write(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["run.safetensors"]


def test_a_bit_flipped_in_the_weights_is_noticed(tmp_path):
    path = tmp_path / "w.safetensors"
    save_bundle(path, NetworkBundle(BundleConfig.tiny()))
    data = bytearray(path.read_bytes())
    data[-50] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match="checksum"):
        load_bundle(path)
