"""What libraries print of their own, and processes that have no streams to print to."""

import os
import struct
import sys
import zlib

import numpy as np
import pytest
from PIL import Image

from relight_core.errors import InputError
from relight_core.imaging.formats.png import SIGNATURE, chunk
from relight_core.imaging.read import read_photo, read_radiance
from relight_core.imaging.write import write_exr_layers, write_image

NOISE = np.random.default_rng(2).integers(0, 256, (40, 56, 3)).astype(np.uint8)


@pytest.mark.parametrize("compression", ["tiff_lzw", "tiff_adobe_deflate", "jpeg"])
def test_a_damaged_tiff_is_refused_without_a_word_of_its_library(tmp_path, capfd, compression):
    path = tmp_path / "a.tif"
    Image.fromarray(NOISE).save(path, compression=compression)
    data = bytearray(path.read_bytes())
    data[8:700] = b"\xf7" * 692
    path.write_bytes(data)
    with pytest.raises(InputError, match="damaged"):
        read_photo(path)
    assert capfd.readouterr() == ("", "")


def test_a_deep_png_that_lacks_its_end_is_refused_without_a_word_of_its_library(tmp_path, capfd):
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 6, 4, 16, 0, 0, 0, 0))
    (tmp_path / "a.png").write_bytes(SIGNATURE + header + chunk(b"IDAT", zlib.compress(bytes(4 * 13))))
    with pytest.raises(InputError, match="damaged"):
        read_photo(tmp_path / "a.png")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("closed", [(2,), (0, 2)])
def test_a_process_that_was_given_no_streams_reads_and_writes_exr_files(tmp_path, monkeypatch, closed):
    grey = np.full((4, 6, 3), 0.5, np.float32)
    kept = [os.dup(stream) for stream in closed]
    monkeypatch.setattr(sys, "stderr", None)
    for stream in closed:
        os.close(stream)
    try:
        write_image(tmp_path / "a.exr", grey)
        write_exr_layers(tmp_path / "b.exr", {"RGB": grey})
        read = [read_radiance(tmp_path / name) for name in ("a.exr", "b.exr")]
        with pytest.raises(OSError, match="[Bb]ad file"):
            os.fstat(2)
    finally:
        for stream, copy in zip(closed, kept, strict=True):
            os.dup2(copy, stream)
            os.close(copy)
    np.testing.assert_array_equal(read, [grey, grey])
