"""What relight bench --files makes of its runs."""

import subprocess
import sys

import numpy as np
import pytest

from app.cli import bench_files
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
    assert "| EXR | 5.0 | 1.5 | 900 | 16 |" in bench_files.as_markdown(found)


def test_the_photo_is_enlarged_to_its_size():
    image = bench_files._enlarged(Photo(np.full((40, 60, 3), 0.2, np.float32)))
    assert abs(image.width * image.height - 24_000_000) < 20_000
    assert abs(image.width / image.height - 1.5) < 0.01


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
