"""Large and lying files: memory stays bounded by the pixels there are, whatever a header claims."""

import struct
import zlib
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import pytest
from PIL import Image

from relight_core.errors import InputError
from relight_core.imaging.formats import limits
from relight_core.imaging.formats.png import SIGNATURE, chunk
from relight_core.imaging.read import read_photo, read_radiance
from relight_core.imaging.write import write_image
from relight_core.lighting.environment import read_environment

PEAK = Path("/proc/self/clear_refs")


def peak_mib():
    status = Path("/proc/self/status").read_text()
    return int(next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1]) >> 10


@pytest.fixture
def little_memory():
    """Within it less than 300 MiB may be taken at any time, however much this process, or its parent, took before."""
    if not PEAK.exists():
        pytest.skip("only Linux can forget how much memory a process once took")

    @contextmanager
    def watch():
        PEAK.write_text("5")
        before = peak_mib()
        yield
        assert peak_mib() - before < 300

    return watch


@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_a_large_panorama_takes_little_more_than_its_own_floats(tmp_path, little_memory, suffix):
    """2048 rows: 96 MiB as float32; the rest is a few rows, and the map of 1024 that stays."""
    path, pixels = tmp_path / f"large{suffix}", np.zeros((2048, 4096, 3), np.float16)
    pixels[300:400, 77:500] = 100
    if suffix == ".exr":
        OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": pixels}).write(
            str(path)
        )
    else:
        path.write_bytes(cv2.imencode(".hdr", pixels.astype(np.float32))[1].tobytes())
    with little_memory():
        assert read_environment(path).height == 1024


def exr_claiming(path, width, height, channels=("B", "G", "R")):
    """An EXR whose header claims a size and layers, and that ends there."""

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    layers = b"".join(name.encode() + b"\0" + struct.pack("<iBxxxii", 1, 0, 1, 1) for name in channels) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = [
        attribute("channels", "chlist", layers),
        attribute("compression", "compression", b"\0"),
        attribute("dataWindow", "box2i", box),
        attribute("displayWindow", "box2i", box),
        attribute("lineOrder", "lineOrder", b"\0"),
        attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)),
    ]
    path.write_bytes(b"\x76\x2f\x31\x01\x02\0\0\0" + b"".join(header) + b"\0" + bytes(4096))
    return path


@pytest.mark.parametrize(
    ("width", "height"), [(2**31 - 1, 1), (2**31 - 1, 2**31 - 1), (65536, 32768), (2, 2**30), (20000, 19999)]
)
def test_an_exr_that_claims_two_thousand_million_pixels(tmp_path, little_memory, width, height):
    with little_memory(), pytest.raises(InputError):
        read_radiance(exr_claiming(tmp_path / "a.exr", width, height))


def test_an_exr_of_ten_thousand_layers_is_refused_for_them(tmp_path):
    names = [f"layer{index:06d}.R" for index in range(10_000)]
    with pytest.raises(InputError, match="10000 channels are too many"):
        read_radiance(exr_claiming(tmp_path / "a.exr", 8, 4, names))


def test_an_exr_of_too_many_layers_never_reaches_the_library(tmp_path, monkeypatch):
    """Which would take 17 s for a hundred thousand of them."""
    monkeypatch.setattr(OpenEXR, "File", None)
    names = [f"layer{index:06d}.R" for index in range(100_000)]
    with pytest.raises(InputError, match="100000 channels are too many"):
        read_radiance(exr_claiming(tmp_path / "a.exr", 8, 4, names))


def test_an_exr_whose_display_window_no_memory_is_left_for(tmp_path, monkeypatch):
    """Which may be far larger than the data, of which there are few."""
    path, corners = tmp_path / "a.exr", (np.array((0, 0), np.int32), np.array((99, 99), np.int32))
    OpenEXR.File({"displayWindow": corners}, {"RGB": np.ones((8, 16, 3), np.float16)}).write(str(path))
    assert read_radiance(path).shape == (100, 100, 3)

    def none_left(size, kind):
        raise MemoryError(size, kind)

    monkeypatch.setattr(np, "zeros", none_left)
    with pytest.raises(InputError, match="not enough memory"):
        read_radiance(path)


def test_a_tile_far_larger_than_its_picture(tmp_path):
    path, pixels = tmp_path / "a.exr", np.ones((32, 64, 3), np.float16)
    header = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
    OpenEXR.File(header, {"RGB": pixels}).write(str(path))
    data = path.read_bytes()
    at = data.index(b"tiledesc\0") + len(b"tiledesc\0") + 4
    path.write_bytes(data[: at + 4] + struct.pack("<I", 8388640) + data[at + 8 :])
    with pytest.raises(InputError, match="tiles of"):
        read_radiance(path)


def png_bomb(path, side):
    """A PNG of one colour, a thousandth as large as its pixels."""
    packer = zlib.compressobj(9)
    rows = b"".join(packer.compress(b"\0" * (side * 4 + 1)) for _ in range(side)) + packer.flush()
    header = struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)
    path.write_bytes(SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))
    return path


def test_a_png_that_unpacks_to_more_memory_than_is_free_is_refused(tmp_path, monkeypatch):
    path = png_bomb(tmp_path / "bomb.png", 3000)
    assert path.stat().st_size < 100_000
    monkeypatch.setattr(limits, "free_bytes", lambda: 100 << 20)
    with pytest.raises(InputError, match=r"3000 x 3000 needs about 0\.3 GB of memory and 0\.1 GB are free"):
        read_photo(path)


def test_a_png_too_short_for_the_pixels_it_claims_takes_no_memory_for_them(tmp_path, little_memory):
    path = png_bomb(tmp_path / "bomb.png", 300)
    data = bytearray(path.read_bytes())
    data[16:24] = struct.pack(">II", 19_000, 20_000)
    data[29:33] = struct.pack(">I", zlib.crc32(bytes(data[12:29])))
    path.write_bytes(data)
    with little_memory(), pytest.raises(InputError, match="truncated"):
        read_photo(path)


@pytest.mark.parametrize("lossless", [False, True])
def test_a_webp_too_short_for_the_pixels_it_claims_takes_no_memory_for_them(tmp_path, lossless):
    path = tmp_path / "a.webp"
    Image.new("RGB", (40, 48), (90, 120, 200)).save(path, lossless=lossless)
    data, side = bytearray(path.read_bytes()), 16_383
    if lossless:
        data[21:25] = struct.pack("<I", (side - 1) | (side - 1) << 14)
    else:
        data[26:30] = struct.pack("<HH", side, side)
    path.write_bytes(data)
    with pytest.raises(InputError, match="16383 x 16383 pixels in"):
        read_photo(path)


def test_an_even_picture_may_be_a_short_file(tmp_path):
    """A million pixels in some hundred bytes: strange, and no danger."""
    path = tmp_path / "a.webp"
    Image.new("RGB", (1000, 1000), (90, 120, 200)).save(path, lossless=True)
    assert path.stat().st_size < 200
    assert read_photo(path).linear.shape == (1000, 1000, 3)


def test_a_chunk_that_claims_4_gib_takes_no_memory_for_them(tmp_path, little_memory):
    path = tmp_path / "a.png"
    write_image(path, np.full((40, 48, 3), 0.5, np.float32), bits=16)
    data = path.read_bytes()
    end = data.rindex(b"IEND") - 4
    path.write_bytes(data[:end] + struct.pack(">I", 0xFFFFFF00) + b"eXIf" + data[end:])
    with little_memory(), pytest.raises(InputError):
        read_photo(path)


def test_free_memory_is_known_here_and_nothing_is_refused_where_it_is_not(tmp_path, monkeypatch):
    assert limits.free_bytes() > 1 << 20
    monkeypatch.setattr(limits, "free_bytes", lambda: None)
    write_image(tmp_path / "a.png", np.full((4, 4, 3), 0.5, np.float32))
    assert read_photo(tmp_path / "a.png").linear.shape == (4, 4, 3)
