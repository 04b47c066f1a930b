"""Pictures on disk: what was written is read again, and what can't be is told."""

import os
import stat
import sys
import threading
from contextlib import suppress

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from relight_core.errors import InputError
from relight_core.imaging.read import read_photo, read_radiance
from relight_core.imaging.write import FileStyle, write_bands, write_exr_layers, write_image

RNG = np.random.default_rng(0)
LINEAR = RNG.random((12, 17, 3)).astype(np.float32)
ALPHA = RNG.random((12, 17)).astype(np.float32)


def encode(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("name", ["a.png", "a.tif", "A.PNG", "a.TIFF"])
@pytest.mark.parametrize("bits", [8, 16])
def test_round_trip_of_what_files_can_show(tmp_path, name, bits):
    write_image(tmp_path / name, LINEAR, bits=bits)
    back = read_photo(tmp_path / name)
    assert back.bits == bits
    assert back.alpha is None
    assert np.abs(encode(back.linear) - encode(LINEAR)).max() <= 0.51 / (2**bits - 1) + 1e-6


@pytest.mark.parametrize("name", ["a.png", "a.tif"])
@pytest.mark.parametrize("bits", [8, 16])
def test_straight_alpha_keeps_the_colour(tmp_path, name, bits):
    write_image(tmp_path / name, LINEAR, ALPHA, bits=bits)
    back = read_photo(tmp_path / name)
    assert np.abs(back.alpha - ALPHA).max() <= 0.51 / (2**bits - 1)
    assert np.abs(encode(back.linear) - encode(LINEAR)).max() <= 0.51 / (2**bits - 1) + 1e-6


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.exr"])
def test_alpha_that_is_no_share_is_written_as_the_nearest(tmp_path, name):
    alpha = np.full((2, 4), 0.5, np.float32)
    alpha[0] = np.nan, -0.2, 1.5, np.inf
    write_image(tmp_path / name, np.full((2, 4, 3), 0.25, np.float32), alpha, bits=16)
    np.testing.assert_allclose(read_photo(tmp_path / name).alpha, [[0, 0, 1, 1], [0.5] * 4], atol=1e-4)


def test_a_photo_read_and_written_is_the_same_bytes(tmp_path):
    pixels = RNG.integers(0, 256, (9, 10, 3)).astype(np.uint8)
    Image.fromarray(pixels).save(tmp_path / "in.png")
    write_image(tmp_path / "out.png", read_photo(tmp_path / "in.png").linear)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "out.png")), pixels)


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg", ".JPG"])
def test_jpeg_is_close_and_flattens_on_white(tmp_path, suffix):
    smooth, a, b, c = np.full((32, 32, 3), 0.25, np.float32), *(tmp_path / f"{name}{suffix}" for name in "abc")
    write_image(a, smooth, quality=95)
    assert np.abs(read_photo(a).linear - 0.25).max() < 0.01
    write_image(b, smooth, np.zeros((32, 32), np.float32))
    np.testing.assert_allclose(read_photo(b).linear, 1.0, atol=0.01)
    write_image(c, smooth, np.full((32, 32), 0.5, np.float32))
    np.testing.assert_allclose(read_photo(c).linear, 0.625, atol=0.02)


def test_lower_quality_is_a_smaller_file(tmp_path):
    noise = RNG.random((64, 64, 3)).astype(np.float32)
    write_image(tmp_path / "good.jpg", noise, quality=95)
    write_image(tmp_path / "small.jpg", noise, quality=20)
    assert os.path.getsize(tmp_path / "small.jpg") < os.path.getsize(tmp_path / "good.jpg")


@pytest.mark.parametrize("quality", [92, 94, 100])
def test_noise_is_written_as_jpeg(tmp_path, quality):
    # Its file takes more bytes than the picture has pixels.
    noise = np.random.default_rng(0).random((400, 400, 3)).astype(np.float32)
    write_image(tmp_path / "noise.jpg", noise, quality=quality)
    assert os.path.getsize(tmp_path / "noise.jpg") > 400 * 400
    assert read_photo(tmp_path / "noise.jpg").linear.shape == (400, 400, 3)


def test_a_side_that_no_jpeg_holds_is_told(tmp_path):
    long = np.full((1, 65501, 3), 0.5, np.float32)
    with pytest.raises(InputError, match=r"65501 x 1 .*65500.*\.png"):
        write_image(tmp_path / "a.jpg", long)
    assert list(tmp_path.iterdir()) == []
    write_image(tmp_path / "a.jpg", long[:, :65500])
    write_image(tmp_path / "a.png", long)


def test_exposure_reaches_every_format(tmp_path):
    dark = np.full((8, 8, 3), 0.1, np.float32)
    for name in ("a.png", "a.tif", "a.exr", "a.jpg"):
        write_image(tmp_path / name, dark, exposure_ev=2.0)
        np.testing.assert_allclose(read_photo(tmp_path / name).linear, 0.4, atol=0.01)


def test_exr_keeps_radiance_and_multiplies_alpha_in(tmp_path):
    bright = np.full((4, 6, 3), 40.0, np.float32)
    write_image(tmp_path / "a.exr", bright, np.full((4, 6), 0.25, np.float32), bits=32)
    channels = channels_of(tmp_path / "a.exr")
    assert sorted(channels) == ["A", "B", "G", "R"]
    np.testing.assert_array_equal(channels["R"], np.full((4, 6), 10.0))
    np.testing.assert_allclose(read_photo(tmp_path / "a.exr").linear, 40.0)


def channels_of(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: np.array(channel.pixels) for name, channel in file.channels().items()}


def test_named_layers_and_header(tmp_path):
    main = np.dstack([LINEAR, ALPHA])
    layers = {"RGBA": main, "albedo": LINEAR * 0.5, "shadow": ALPHA, "mask": ALPHA[..., None]}
    header = {"light": "split", "yaw_deg": np.float32(30.0), "count": np.int64(3), "none": None, "on": True}
    write_exr_layers(tmp_path / "L.EXR", layers, half=False, header=header)
    channels = channels_of(tmp_path / "L.EXR")
    names = ["A", "B", "G", "R", "albedo.B", "albedo.G", "albedo.R", "mask", "shadow"]
    assert sorted(channels) == names
    np.testing.assert_array_equal(channels["albedo.G"], LINEAR[..., 1] * 0.5)
    np.testing.assert_array_equal(channels["shadow"], ALPHA)
    with OpenEXR.File(str(tmp_path / "L.EXR"), header_only=True) as file:
        stored = dict(file.header())
    assert stored["light"] == "split"
    assert stored["yaw_deg"] == 30.0
    assert stored["count"] == 3
    assert stored["on"] == 1
    assert "none" not in stored
    assert stored["compression"] == OpenEXR.ZIP_COMPRESSION


def test_notes_of_an_exr_are_kept_whatever_their_type_and_leave_its_own_header_alone(tmp_path):
    notes = {"yaw_deg": np.float32(30.0), "count": np.int64(3), "none": None, "light": "split"}
    standard = {"channels": "x", "compression": "x", "dataWindow": "x", "chromaticities": "x"}
    write_image(tmp_path / "n.exr", LINEAR, bits=32, notes=notes | standard)
    with OpenEXR.File(str(tmp_path / "n.exr"), header_only=True) as file:
        stored = dict(file.header())
    assert (stored["yaw_deg"], stored["count"], stored["light"]) == (30.0, 3, "split")
    assert "none" not in stored
    assert stored["compression"] == OpenEXR.ZIP_COMPRESSION
    np.testing.assert_array_equal(read_photo(tmp_path / "n.exr").linear, LINEAR)


@pytest.mark.parametrize("half", [True, False])
def test_arrays_of_any_memory_layout_are_written_right(tmp_path, half):
    big = np.arange(20 * 30 * 3, dtype=np.float64).reshape(20, 30, 3) % 512
    views = {
        "RGB": big[3:15, 4:21][:, ::-1],
        "bgr": big[:12, :17, ::-1],
        "turned": big[:17, :12].swapaxes(0, 1),
        "single": big[:12, :17, 0],
        "fortran": np.asfortranarray(big[:12, :17]),
    }
    write_exr_layers(tmp_path / "v.exr", views, half=half)
    channels = channels_of(tmp_path / "v.exr")
    for index, letter in enumerate("RGB"):
        np.testing.assert_array_equal(channels[letter], views["RGB"][..., index])
        for name in ("bgr", "turned", "fortran"):
            np.testing.assert_array_equal(channels[f"{name}.{letter}"], views[name][..., index])
    np.testing.assert_array_equal(channels["single"], views["single"])


def test_half_is_limited_instead_of_infinite(tmp_path):
    hot = np.full((2, 4, 3), 1e6, np.float32)
    hot[0, 0], hot[0, 1] = np.nan, -1e6
    write_exr_layers(tmp_path / "h.exr", {"RGB": hot})
    np.testing.assert_array_equal(channels_of(tmp_path / "h.exr")["R"][0], [0.0, -65504.0, 65504.0, 65504.0])
    write_exr_layers(tmp_path / "f.exr", {"RGB": hot}, half=False)
    assert channels_of(tmp_path / "f.exr")["R"][1, 1] == 1e6


def test_32_bits_are_cleaned_but_not_limited_and_halves_are(tmp_path):
    hot = np.full((2, 5, 3), 1e6, np.float32)
    hot[0, :4] = np.array([np.nan, np.inf, -1e6, 65504.0])[:, None]
    write_image(tmp_path / "whole.exr", hot, bits=32)
    whole = channels_of(tmp_path / "whole.exr")["G"]
    largest = 3.4028235e38
    np.testing.assert_array_equal(whole[0], np.float32([0.0, largest, -1e6, 65504.0, 1e6]))
    write_image(tmp_path / "brighter.exr", hot, bits=32, exposure_ev=1.0)
    np.testing.assert_array_equal(
        channels_of(tmp_path / "brighter.exr")["G"][0, 1:], np.float32([largest, -2e6, 131008, 2e6])
    )
    write_image(tmp_path / "half.exr", hot, bits=16)
    np.testing.assert_array_equal(
        channels_of(tmp_path / "half.exr")["G"][0], [0.0, 65504.0, -65504.0, 65504.0, 65504.0]
    )


def test_layers_are_written_into_no_other_kind_of_file(tmp_path):
    with pytest.raises(InputError, match=r"a\.png: layers need an EXR file"):
        write_exr_layers(tmp_path / "a.png", {"RGB": LINEAR})
    assert list(tmp_path.iterdir()) == []


def test_integer_labels_can_be_a_layer(tmp_path):
    labels = np.arange(12).reshape(3, 4)
    write_exr_layers(tmp_path / "p.exr", {"parsing": labels})
    np.testing.assert_array_equal(channels_of(tmp_path / "p.exr")["parsing"], labels)


def test_layers_of_different_sizes_are_a_fault_of_the_caller(tmp_path):
    for layers in ({}, {"RGB": LINEAR, "shadow": ALPHA[1:]}, {"two": LINEAR[..., :2]}):
        with pytest.raises(ValueError, match="EXR|layer"):
            write_exr_layers(tmp_path / "x.exr", layers)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "options", "fault"),
    [
        ("a.gif", {}, "png"),
        ("a", {}, "png"),
        ("a.jpg", {"bits": 16}, "8 bits"),
        ("a.jpeg", {"bits": 16}, "8 bits"),
        ("a.png", {"bits": 32}, "8 or 16 bits"),
        ("missing/a.png", {}, "no folder"),
        ("missing/a.exr", {}, "no folder"),
        ("folder.png", {}, "folder"),
    ],
)
def test_places_and_kinds_that_cannot_be_written(tmp_path, name, options, fault):
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(InputError, match=fault) as refusal:
        write_image(tmp_path / name, LINEAR, **options)
    assert "\n" not in str(refusal.value)
    assert name.rsplit("/", 1)[-1] in str(refusal.value)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.png"]


def test_a_read_only_folder(tmp_path):
    if os.geteuid() == 0:
        pytest.skip("root may write anywhere")
    tmp_path.chmod(stat.S_IRUSR | stat.S_IXUSR)
    with pytest.raises(InputError, match="can't be written"):
        write_image(tmp_path / "a.png", LINEAR)


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, name, monkeypatch):
    (tmp_path / name).write_text("old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="no space left"):
        write_image(tmp_path / name, LINEAR)
    assert (tmp_path / name).read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("write", [write_image, lambda path, linear: write_exr_layers(path, {"RGB": linear})])
def test_a_full_disk_is_told_without_the_hidden_file_that_an_exr_is_first_written_to(tmp_path, monkeypatch, write):
    class FullFile:
        def __init__(self, path, _):
            self.path = path

        def writePixels(self, *_):
            raise OSError(f'Failed to write pixel data to image file "{self.path}". No space left on device.')

        def close(self):
            pass

    monkeypatch.setattr(OpenEXR, "OutputFile", FullFile)
    with pytest.raises(InputError) as refusal:
        write(tmp_path / "a.exr", LINEAR)
    assert "(no space left on device)" in str(refusal.value)
    assert ".part" not in str(refusal.value)


def test_a_new_file_has_ordinary_permissions_and_links_are_followed(tmp_path):
    (tmp_path / "real.png").write_text("old")
    (tmp_path / "link.png").symlink_to(tmp_path / "real.png")
    write_image(tmp_path / "link.png", LINEAR)
    assert (tmp_path / "link.png").is_symlink()
    assert Image.open(tmp_path / "real.png").size == (17, 12)
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE((tmp_path / "real.png").stat().st_mode) == 0o666 & ~mask


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_fault_while_the_picture_is_made_is_no_fault_of_the_place(tmp_path, name):
    def bands():
        yield slice(0, 2), np.zeros((2, 4, 3), np.float32), None
        raise RuntimeError("a fault of ours")

    with pytest.raises(RuntimeError, match="a fault of ours"):
        write_bands(tmp_path / name, (4, 4), bands(), False, FileStyle(16))
    assert list(tmp_path.iterdir()) == []


def test_layers_are_written_band_by_band_and_each_is_told_before(tmp_path):
    told, tall = [], np.arange(150 * 4, dtype=np.float32).reshape(150, 4)
    write_exr_layers(
        tmp_path / "a.exr", {"RGB": np.dstack([tall] * 3), "shadow": tall}, half=False, step=lambda *at: told.append(at)
    )
    assert told == [(0, 150), (64, 150), (128, 150)]
    channels = channels_of(tmp_path / "a.exr")
    for name in ("R", "G", "B", "shadow"):
        np.testing.assert_array_equal(channels[name], tall)


def test_a_file_is_read_while_layers_are_written(tmp_path):
    """What keeps a library's messages off the streams is held by one thread at a time, and a large file takes long."""
    write_image(tmp_path / "light.exr", LINEAR)
    read = []

    def step(_row, _rows):
        reader = threading.Thread(target=lambda: read.append(read_radiance(tmp_path / "light.exr")))
        reader.start()
        reader.join(timeout=5)
        assert read

    write_exr_layers(tmp_path / "a.exr", {"RGB": LINEAR}, step=step)
    assert read[0].shape == LINEAR.shape


def test_two_threads_that_read_exr_files_leave_the_streams_alone(tmp_path, monkeypatch):
    """The library's own messages are kept off them, for the whole process at once."""
    both_inside, first_done, real = threading.Barrier(2), threading.Event(), OpenEXR.File

    def file(*arguments, **options):
        with suppress(threading.BrokenBarrierError):
            both_inside.wait(timeout=0.2)
        if threading.current_thread() is not first and not both_inside.broken:
            first_done.wait(timeout=5)
        return real(*arguments, **options)

    def read(name):
        read_radiance(tmp_path / name)
        first_done.set()

    for name in ("a.exr", "b.exr"):
        write_image(tmp_path / name, LINEAR)
    monkeypatch.setattr(OpenEXR, "File", file)
    streams = sys.stdout, os.fstat(2).st_ino
    first, second = (threading.Thread(target=read, args=(name,)) for name in ("a.exr", "b.exr"))
    for thread in (first, second):
        thread.start()
    for thread in (first, second):
        thread.join()
    assert (sys.stdout, os.fstat(2).st_ino) == streams
