"""Radiance pictures as other programs than OpenCV write them."""

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.imaging.read import read_radiance

HEIGHT, WIDTH = 16, 32
CODES = np.random.default_rng(3).integers(128, 140, (HEIGHT, WIDTH, 4), np.uint8)
CODES[4:9, 3:20] = CODES[4, 3]
CODES[12:] = CODES[12, 0]
LINEAR = CODES[..., :3] * np.ldexp(1.0, CODES[..., 3:].astype(int) - 136)
RGBE = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"


def by_channels(codes):
    head = bytes([2, 2, codes.shape[1] >> 8, codes.shape[1] & 255])
    return b"".join(head + b"".join(bytes([len(row)]) + row[:, i].tobytes() for i in range(4)) for row in codes)


def by_repetition(codes):
    """Runs of whole pixels across scanlines, their length in as many bytes as it takes."""
    packed, pixels, at = [], codes.reshape(-1, 4), 0
    while at < len(pixels):
        end = at + 1
        while end < len(pixels) and (pixels[end] == pixels[at]).all():
            end += 1
        packed.append(pixels[at].tobytes())
        again = end - at - 1
        while again:
            packed.append(bytes([1, 1, 1, again & 255]))
            again >>= 8
        at = end
    return b"".join(packed)


@pytest.mark.parametrize("pack", [by_channels, by_repetition, np.ndarray.tobytes])
@pytest.mark.parametrize(
    ("size", "stored"),
    [
        ("-Y 16 +X 32", CODES),
        ("+Y 16 +X 32", CODES[::-1]),
        ("-Y 16 -X 32", CODES[:, ::-1]),
        ("+Y 16 -X 32", CODES[::-1, ::-1]),
        ("+X 32 -Y 16", CODES.swapaxes(0, 1)),
        ("+X 32 +Y 16", CODES[::-1].swapaxes(0, 1)),
        ("-X 32 -Y 16", CODES[:, ::-1].swapaxes(0, 1)),
    ],
)
def test_every_order_and_packing(tmp_path, pack, size, stored):
    (tmp_path / "a.hdr").write_bytes(RGBE + size.encode() + b"\n" + pack(stored))
    np.testing.assert_allclose(read_radiance(tmp_path / "a.hdr"), LINEAR, rtol=1e-6)


LONG = b"#?RADIANCE\n# " + b"lamp " * 300 + b"\n\n"


@pytest.mark.parametrize("head", [RGBE.replace(b"\n", b"\r\n"), b"#?RADIANCE\n\n", b"#?RGBE\nEXPOSURE=1\n\n", LONG])
def test_headers_of_other_line_ends_and_lengths_and_without_a_format(tmp_path, head):
    for end in (b"\n", b" \r\n"):
        (tmp_path / "a.hdr").write_bytes(head + b"-Y 16 +X 32" + end + by_channels(CODES))
        np.testing.assert_allclose(read_radiance(tmp_path / "a.hdr"), LINEAR, rtol=1e-6)


@pytest.mark.parametrize(("width", "blue"), [(4, 100), (32, 200)])
def test_a_first_pixel_that_looks_like_the_start_of_a_packed_line_is_a_pixel(tmp_path, width, blue):
    codes = CODES[:, :width].copy()
    codes[0, 0] = 2, 2, blue, 130
    (tmp_path / "a.hdr").write_bytes(RGBE + b"-Y 16 +X %d\n" % width + by_repetition(codes))
    expected = codes[..., :3] * np.ldexp(1.0, codes[..., 3:].astype(int) - 136)
    np.testing.assert_allclose(read_radiance(tmp_path / "a.hdr"), expected, rtol=1e-6)


def test_lines_of_eight_pixels_may_be_packed_by_channels(tmp_path):
    codes = CODES[:, :8].copy()
    # In pixels three of them would say how often the one before comes again.
    codes[..., 0] = 1
    (tmp_path / "a.hdr").write_bytes(RGBE + b"-Y 16 +X 8\n" + by_channels(codes))
    expected = codes[..., :3] * np.ldexp(1.0, codes[..., 3:].astype(int) - 136)
    np.testing.assert_allclose(read_radiance(tmp_path / "a.hdr"), expected, rtol=1e-6)


def test_white_in_xyz_is_white(tmp_path):
    grey = np.full((HEIGHT, WIDTH, 4), 128, np.uint8)
    head = RGBE.replace(b"rgbe", b"xyze")
    (tmp_path / "a.hdr").write_bytes(head + b"-Y 16 +X 32\n" + by_channels(grey))
    np.testing.assert_allclose(read_radiance(tmp_path / "a.hdr"), 0.5, rtol=1e-4)


@pytest.mark.parametrize("lost", [1, 4, 300])
@pytest.mark.parametrize("pack", [by_channels, by_repetition, np.ndarray.tobytes])
def test_incomplete_files_are_refused(tmp_path, pack, lost):
    (tmp_path / "a.hdr").write_bytes(RGBE + b"-Y 16 +X 32\n" + pack(CODES)[:-lost])
    with pytest.raises(InputError, match="not a complete Radiance file"):
        read_radiance(tmp_path / "a.hdr")
