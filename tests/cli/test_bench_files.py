"""What relight bench --files makes of its runs."""

import subprocess
import sys

import numpy as np
import pytest

from app.cli import bench_files
from relight_core.errors import InputError
from relight_core.imaging.photo import Photo


def test_kinds_take_turns_and_medians_are_told(monkeypatch):
    seen, told = [], []

    def once(source, output):
        seen.append(output.suffix)
        assert source.stat().st_size > 0
        # The second of three rounds was disturbed.
        return {
            "whole_s": 9.0 if len(seen) in range(5, 9) else 5.0,
            "after_networks_s": 1.5,
            "peak_mib": 900.4,
            "file_mb": 16.5,
        }

    monkeypatch.setattr(bench_files, "_relit_once", once)
    monkeypatch.setattr(bench_files, "_PIXELS", 10_000)
    photo = Photo(np.full((20, 30, 3), 0.2, np.float32))
    found = bench_files.time_files(photo, 3, lambda done, total: told.append((done, total)))
    assert seen == [".png", ".jpg", ".tif", ".exr"] * 3
    assert told[-1] == (12, 12)
    assert found[".exr"] == {"whole_s": 5.0, "after_networks_s": 1.5, "peak_mib": 900.4, "file_mb": 16.5}
    page = bench_files.as_markdown(found).splitlines()
    assert page[0] == "| 24 MP JPEG to | whole program, s | after the networks, s | peak memory, MiB | file, MB |"
    assert page[-1] == "| EXR | 5.0 | 1.5 | 900 | 16 |"


def test_the_photo_is_enlarged_to_its_size():
    image = bench_files._enlarged(Photo(np.full((40, 60, 3), 0.2, np.float32)))
    assert abs(image.width * image.height - 24_000_000) < 20_000
    assert abs(image.width / image.height - 1.5) < 0.01
    # Brighter than its radiance, as files are encoded, and with a camera's grain.
    codes = np.asarray(image.crop((0, 0, 200, 200)), np.float32)
    assert 100 < codes.mean() < 160
    assert 1.5 < codes.std() < 3


def test_a_run_is_told_in_seconds_and_megabytes(tmp_path, monkeypatch):
    asked = []

    def witnessed(words):
        asked.extend(words)
        (tmp_path / "relit.png").write_bytes(bytes(2_500_000))
        return '{"after_networks_ms": 1500}', 5.0, 900.0

    monkeypatch.setattr(bench_files, "_witnessed", witnessed)
    found = bench_files._relit_once(tmp_path / "photo.jpg", tmp_path / "relit.png")
    assert found == {"whole_s": 5.0, "after_networks_s": 1.5, "peak_mib": 900.0, "file_mb": 2.5}
    assert {"render", str(tmp_path / "photo.jpg"), "--json", str(tmp_path / "relit.png")} <= set(asked)


def test_a_photo_that_can_t_be_relit_is_told_without_the_copy_that_is_gone(monkeypatch):
    def failed(words):
        raise subprocess.CalledProcessError(2, words)

    monkeypatch.setattr(bench_files, "_witnessed", failed)
    monkeypatch.setattr(bench_files, "_PIXELS", 10_000)
    with pytest.raises(InputError, match="^the photo can't be relit.*choose one with a face after --photos$"):
        bench_files.time_files(Photo(np.full((20, 30, 3), 0.2, np.float32)), 1, lambda *_: None)


def test_the_peak_is_the_programs_own_and_not_the_benchs():
    held = np.ones(60_000_000)
    del held
    said, seconds, peak_mib = bench_files._witnessed([sys.executable, "-c", "print('one\\ntwo')"])
    assert said.split() == ["one", "two"]
    assert seconds > 0
    assert 1 < peak_mib < 200


def test_a_program_that_fails_is_not_timed():
    with pytest.raises(subprocess.CalledProcessError):
        bench_files._witnessed([sys.executable, "-c", "raise SystemExit(2)"])
