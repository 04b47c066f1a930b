"""EXR files of other kinds than lines of red, green and blue floats, and larger ones than there is room for."""

import struct

import Imath
import numpy as np
import OpenEXR
import pytest

from relight_core.errors import InputError
from relight_core.imaging.formats import limits
from relight_core.imaging.formats.exr import exr_size
from relight_core.imaging.read import read_photo, read_radiance
from relight_core.imaging.write import write_image

GREY = np.full((4, 6), 0.5, np.float32)


def written(path, channels, **header):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **header}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))
    return path


def claiming(path, width, height, windows=(b"dataWindow", b"displayWindow")):
    """The file with other windows in its head."""
    data = path.read_bytes()
    for window in windows:
        at = data.index(window + b"\0box2i\0") + len(window) + 11
        data = data[:at] + struct.pack("<4i", 0, 0, width - 1, height - 1) + data[at + 16 :]
    path.write_bytes(data)
    return path


def test_a_deep_exr_is_refused_for_what_it_is(tmp_path):
    samples = np.empty((3, 4), object)
    for place in np.ndindex(3, 4):
        samples[place] = np.ones(2, np.float32)
    header = {"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.deepscanline}
    path = written(tmp_path / "a.exr", dict.fromkeys("RGB", samples), **header)
    with pytest.raises(InputError, match="a deep EXR.*export it flat"):
        read_photo(path)


def test_the_picture_is_known_by_any_of_its_usual_names_and_is_else_the_first_layer(tmp_path):
    for name in ("Main.Combined", "Composite", "a.beauty", "RGBA", "rgb"):
        channels = {f"AO.{letter}": GREY for letter in "RGB"} | {f"{name}.{letter}": 4 * GREY for letter in "RGB"}
        np.testing.assert_array_equal(read_radiance(written(tmp_path / "a.exr", channels)), 2.0)
    unnamed = {f"{name}.{letter}": value * GREY for name, value in (("b", 3), ("a", 1), ("c", 5)) for letter in "RGB"}
    np.testing.assert_array_equal(read_radiance(written(tmp_path / "b.exr", unnamed)), 0.5)


def test_the_transparency_of_a_layer_is_its_own(tmp_path):
    channels = {"A": 0.25 * GREY, "beauty.A": GREY} | {f"beauty.{letter}": GREY for letter in "RGB"}
    photo = read_photo(written(tmp_path / "a.exr", channels))
    np.testing.assert_array_equal(photo.alpha, 0.5)
    np.testing.assert_array_equal(photo.linear, 1.0)


def test_chroma_in_a_layer_is_told_too(tmp_path):
    with pytest.raises(InputError, match="luminance and chroma"):
        read_photo(written(tmp_path / "a.exr", {f"main.{name}": GREY for name in ("Y", "RY", "BY")}))


def sampled(path, quarters):
    """Red, green, blue and alpha, some of which have a quarter of the pixels."""
    kind, header = Imath.PixelType(Imath.PixelType.FLOAT), OpenEXR.Header(6, 4)
    header["channels"] = {name: Imath.Channel(kind, *((2, 2) if name in quarters else (1, 1))) for name in "RGBA"}
    file = OpenEXR.OutputFile(str(path), header)
    file.writePixels({name: (GREY[::2, ::2] if name in quarters else GREY).tobytes() for name in "RGBA"}, 4)
    file.close()
    return path


def test_colours_of_other_sizes_are_told_and_such_transparency_left_out(tmp_path):
    with pytest.raises(InputError, match="colour channels differ in size"):
        read_photo(sampled(tmp_path / "a.exr", "B"))
    photo = read_photo(sampled(tmp_path / "b.exr", "A"))
    assert photo.alpha is None
    np.testing.assert_array_equal(photo.linear, 0.5)


@pytest.mark.parametrize(("size", "is_read"), [((1024, 1024), True), ((1025, 16), False), ((16, 1025), False)])
def test_tiles_far_larger_than_the_picture_are_refused(tmp_path, size, is_read):
    tiles = OpenEXR.TileDescription()
    tiles.xSize, tiles.ySize = size
    path = written(tmp_path / "a.exr", dict.fromkeys("RGB", GREY), type=OpenEXR.tiledimage, tiles=tiles)
    if is_read:
        np.testing.assert_array_equal(read_radiance(path), 0.5)
    else:
        with pytest.raises(InputError, match=rf"tiles of {size[0]} x {size[1]} exceed the picture"):
            read_radiance(path)


def test_a_hundred_channels_are_read_and_five_thousand_refused(tmp_path):
    many = {f"pass{i}.V": GREY for i in range(97)} | dict.fromkeys("RGB", GREY)
    np.testing.assert_array_equal(read_radiance(written(tmp_path / "a.exr", many)), 0.5)
    names = b"".join(b"c%d\0" % i + struct.pack("<iB3xii", 2, 0, 1, 1) for i in range(5000)) + b"\0"
    head = b"\x76\x2f\x31\x01" + struct.pack("<I", 2) + b"channels\0chlist\0" + struct.pack("<I", len(names))
    (tmp_path / "b.exr").write_bytes(head + names + b"\0")
    with pytest.raises(InputError, match="5000 channels are too many"):
        read_radiance(tmp_path / "b.exr")


def test_sixteen_hundred_million_samples_are_the_most(tmp_path, monkeypatch):
    monkeypatch.setattr(limits, "free_bytes", lambda: None)
    path = written(tmp_path / "a.exr", dict.fromkeys("RGBAZXYW", GREY))
    assert exr_size(claiming(path, 20_000, 10_000)) == (20_000, 10_000)
    with pytest.raises(InputError, match="8 channels of 20000 x 10001 are too many; export fewer layers"):
        exr_size(claiming(path, 20_000, 10_001))


def test_neither_the_data_nor_what_is_shown_of_them_is_above_400_megapixels(tmp_path):
    for window in (b"dataWindow", b"displayWindow"):
        path = claiming(written(tmp_path / "a.exr", dict.fromkeys("RGB", GREY)), 20_001, 20_000, [window])
        with pytest.raises(InputError, match="20001 x 20000 is above 400 megapixels"):
            read_radiance(path)


def test_an_exr_needs_room_for_its_colour_and_some_rows(tmp_path, monkeypatch):
    path = written(tmp_path / "a.exr", dict.fromkeys("RGB", GREY))
    monkeypatch.setattr(limits, "free_bytes", lambda: 18 * 24)
    assert read_radiance(path).shape == (4, 6, 3)
    monkeypatch.setattr(limits, "free_bytes", lambda: 16 * 24)
    with pytest.raises(InputError, match="needs about .* of memory"):
        read_radiance(path)


def test_memory_that_runs_out_on_the_way_is_called_so(tmp_path, monkeypatch):
    def none_left(_):
        raise MemoryError

    path = written(tmp_path / "a.exr", dict.fromkeys("RGB", GREY))
    monkeypatch.setattr(OpenEXR, "InputFile", none_left)
    with pytest.raises(InputError, match="not enough memory is free"):
        read_radiance(path)


def test_notes_in_any_script_are_kept(tmp_path):
    write_image(tmp_path / "a.exr", np.dstack([GREY] * 3), notes={"light": "Glanz über 東京"})
    with OpenEXR.File(str(tmp_path / "a.exr"), header_only=True) as file:
        assert file.header()["light"] == "Glanz über 東京"
