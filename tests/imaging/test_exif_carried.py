"""EXIF goes from file to file byte for byte, without what tells of the file itself, and never in vain."""

import struct

import numpy as np
import pytest
import tifffile
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from relight_core.imaging.formats.exif_block import Directory, Entry, laid_out, read_directory
from relight_core.imaging.formats.metadata import carried_block
from relight_core.imaging.formats.tiff_exif import exif_of_tiff, with_exif
from relight_core.imaging.read import read_photo
from relight_core.imaging.write import FileStyle, cut, write_bands

MAKER, ORIENTATION, AUTHOR, COPYRIGHT, EXIF, GPS, INTEROPERABILITY = 271, 274, 315, 33432, 34665, 34853, 40965
EXPOSURE_TIME, SENSITIVITY, MAKER_NOTE, COLOUR_SPACE, LENS = 33434, 34855, 37500, 40961, 42036
LATITUDE_SIDE, LATITUDE = 1, 2
UTF_8, LATIN_1 = "© 2024 Jürgen".encode(), "© 2024 Jürgen".encode("latin-1")
IMAGE, ALPHA = np.full((9, 7, 3), 0.3, np.float32), np.full((9, 7), 0.5, np.float32)


def with_copyright(text):
    exif = Image.Exif()
    exif[MAKER], exif[COPYRIGHT] = "Camera", "X" * len(text)
    return exif.tobytes().replace(b"X" * len(text), text)


def written(path, block, bits=8, alpha=None):
    write_bands(path, (9, 7), cut(IMAGE, alpha), alpha is not None, FileStyle(bits, exif=block))
    return path


def said_by(path):
    """What a file says, by Pillow."""
    with Image.open(path) as image:
        exif = image.getexif()
        return dict(exif), *(dict(exif.get_ifd(tag)) for tag in (EXIF, GPS, INTEROPERABILITY))


def full_block(order, note=b"note" * 10):
    """Camera settings and a place, in an order of bytes."""
    exif = Image.Exif()
    exif.endian = order
    exif[MAKER], exif[AUTHOR] = "Camera", "Someone"
    exif[EXIF] = {EXPOSURE_TIME: 0.005, SENSITIVITY: 400, LENS: "A lens of 85 mm", MAKER_NOTE: note}
    exif[GPS] = {LATITUDE_SIDE: "N", LATITUDE: (48.0, 8.0, 30.0)}
    return exif.tobytes()


@pytest.mark.parametrize("text", [UTF_8, LATIN_1])
@pytest.mark.parametrize("source", ["JPEG", "PNG", "WEBP", "TIFF"])
@pytest.mark.parametrize("result", ["b.png", "b.jpg", "b.tif"])
def test_texts_stay_the_bytes_they_are(tmp_path, text, source, result):
    path = tmp_path / "source"
    if source == "TIFF":
        written(path.with_suffix(".tif"), with_copyright(text)).rename(path)
    else:
        Image.new("RGB", (7, 9)).save(path, source, exif=with_copyright(text))
    back = read_photo(written(tmp_path / result, read_photo(path).exif)).exif
    assert bytes(read_directory(back).entries[COPYRIGHT].data) == text + b"\0"


@pytest.mark.parametrize("bits", [8, 16])
def test_texts_of_deep_and_big_tiffs_stay_too(tmp_path, bits):
    codes = np.zeros((4, 5, 3), f"u{bits // 8}")
    for name, big in (("a.tif", False), ("b.tif", True)):
        tag = (COPYRIGHT, "B", len(UTF_8) + 1, UTF_8 + b"\0", True)
        tifffile.imwrite(tmp_path / name, codes, photometric="rgb", bigtiff=big, metadata=None, extratags=[tag])
        assert UTF_8 + b"\0" in read_photo(tmp_path / name).exif


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize(
    ("name", "bits", "alpha"),
    [("a.jpg", 8, None)]
    + [(name, bits, alpha) for name, bits in (("a.png", 8), ("a.tif", 8), ("a.tif", 16)) for alpha in (None, ALPHA)],
)
def test_settings_and_place_arrive_in_every_format(tmp_path, order, name, bits, alpha):
    said, inner, place, _ = said_by(written(tmp_path / name, carried_block(full_block(order)), bits, alpha))
    assert (said[MAKER], said[AUTHOR]) == ("Camera", "Someone")
    assert float(inner[EXPOSURE_TIME]) == 0.005
    assert (inner[LENS], inner[SENSITIVITY]) == ("A lens of 85 mm", 400)
    assert place == {LATITUDE_SIDE: "N", LATITUDE: (48.0, 8.0, 30.0)}
    np.testing.assert_allclose(read_photo(tmp_path / name).linear, 0.3, atol=0.01)


def test_a_png_has_the_block_without_what_jpegs_have_before_it(tmp_path):
    data = written(tmp_path / "a.png", carried_block(full_block("<"))).read_bytes()
    assert data[data.index(b"eXIf") + 4 :].startswith(b"II*\0")


def test_a_deep_tiff_that_says_nothing_stays_silent(tmp_path):
    assert read_photo(written(tmp_path / "a.tif", None, bits=16)).exif is None


def test_what_tells_of_the_file_itself_stays_behind(tmp_path):
    of_the_file = {317: 2, 322: 16, 323: 16, 330: 8, 339: 1}
    block = Image.Exif()
    block[MAKER] = "Camera"
    for tag, value in of_the_file.items():
        block[tag] = value
    assert set(read_directory(carried_block(block.tobytes())).entries) == {MAKER, ORIENTATION}
    config = {"photometric": "rgb", "tile": (16, 16), "compression": "zlib", "predictor": True, "metadata": None}
    tags = [(MAKER, "s", 0, "Camera", True)]
    tifffile.imwrite(tmp_path / "a.tif", np.zeros((40, 40, 3), np.uint8), extratags=tags, **config)
    kept = set(read_directory(read_photo(tmp_path / "a.tif").exif).entries)
    assert MAKER in kept
    assert not kept & {317, 322, 323, 324, 325, 330, 339, 347}


def stored_picture(settings):
    """What a camera says of the picture as it stored it: in Adobe RGB, of 6000 x 4000 pixels."""
    exif = Image.Exif()
    exif[MAKER] = "Camera"
    # White, primaries, coefficients and positions of colour differences.
    exif[318], exif[319], exif[529], exif[531] = (0.31, 0.33), (0.64, 0.33, 0.21, 0.71, 0.15, 0.06), (0.3, 0.6, 0.1), 2
    stored = {COLOUR_SPACE: 65535, 40962: 6000, 40963: 4000, 37122: 4.0, 42240: 2.2, INTEROPERABILITY: {1: "R03"}}
    exif[EXIF] = {**settings, **stored}
    return exif


@pytest.mark.parametrize("result", ["b.png", "b.jpg", "b.tif"])
def test_what_the_camera_says_of_the_stored_picture_stays_behind(tmp_path, result):
    Image.new("RGB", (7, 9)).save(tmp_path / "a.jpg", exif=stored_picture({EXPOSURE_TIME: 0.005}))
    said, inner, _, interoperability = said_by(written(tmp_path / result, read_photo(tmp_path / "a.jpg").exif))
    assert said[MAKER] == "Camera"
    assert not set(said) & {318, 319, 529, 531}
    assert set(inner) == {EXPOSURE_TIME}
    assert interoperability == {}


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_what_a_tiff_says_of_the_stored_picture_stays_behind(tmp_path, kind):
    tifffile.imwrite(tmp_path / "a.tif", np.zeros((9, 7, 3), kind), photometric="rgb", metadata=None, byteorder="<")
    data = (tmp_path / "a.tif").read_bytes()
    settings = {EXPOSURE_TIME: Entry(5, 1, struct.pack("<II", 1, 200)), 40962: Entry(3, 1, struct.pack("<H", 6000))}
    marks = Directory("<", {1: Entry(2, 4, b"R98\0")}, {})
    inner = {EXIF: Directory("<", settings, {INTEROPERABILITY: marks})}
    directory = laid_out(Directory("<", read_directory(data).entries, inner), len(data))
    (tmp_path / "a.tif").write_bytes(data[:4] + struct.pack("<I", len(data)) + data[8:] + directory)
    kept = read_directory(read_photo(tmp_path / "a.tif").exif).inner[EXIF]
    assert set(kept.entries) == {EXPOSURE_TIME}
    assert not kept.inner


def test_exif_of_nothing_but_the_stored_picture_is_none():
    exif = stored_picture({})
    del exif[MAKER]
    assert carried_block(exif.tobytes()) is None


@pytest.mark.parametrize("tag", [37724, 34377, 33723])
def test_programs_own_large_tags_take_nothing_else_with_them(tmp_path, tag):
    tags = [(MAKER, "s", 0, "Camera", True), (tag, "B", 100_000, bytes(100_000), True)]
    codes = np.zeros((8, 9, 3), np.uint8)
    tifffile.imwrite(tmp_path / "a.tif", codes, photometric="rgb", metadata=None, extratags=tags)
    kept = read_directory(read_photo(tmp_path / "a.tif").exif).entries
    assert bytes(kept[MAKER].data) == b"Camera\0"
    assert tag not in kept


@pytest.mark.parametrize(("length", "is_kept"), [(50_000, True), (61_000, False)])
def test_makers_notes_go_where_the_whole_is_too_large(length, is_kept):
    block = carried_block(full_block(">", bytes(length)))
    assert len(block) <= 60_000
    inner = read_directory(block).inner[EXIF].entries
    assert EXPOSURE_TIME in inner
    assert (MAKER_NOTE in inner) == is_kept


def test_damaged_blocks_say_what_they_still_do():
    whole = full_block("<")
    for length in range(0, len(whole), 7):
        block = carried_block(whole[:length])
        assert block is None or block.startswith(b"Exif\0\0")
    assert carried_block("Exif, but as text") is None
    # A directory that says it is its own EXIF directory, 65535 times.
    entry = struct.pack("<HHII", EXIF, 4, 1, 8)
    endless = b"II*\0" + struct.pack("<IH", 8, 65535) + entry * 65535
    assert len(carried_block(endless)) < 200


@pytest.mark.parametrize("bits", [8, 16])
def test_a_tiff_of_ours_that_says_nothing_of_a_camera_is_read_so_at_any_depth(tmp_path, bits):
    assert read_photo(written(tmp_path / "a.tif", None, bits)).exif is None


@pytest.mark.parametrize("more", [b"", b"!"])
def test_a_tiffs_new_directory_stands_at_an_even_place_and_has_all_that_was_said(tmp_path, more):
    tiff = written(tmp_path / "a.tif", None).read_bytes() + more
    whole = with_exif(tiff, full_block("<"))
    (start,) = struct.unpack_from("<I", whole, 4)
    assert start % 2 == 0
    assert whole[8 : len(tiff)] == tiff[8:]
    (tmp_path / "b.tif").write_bytes(whole)
    first, settings, place, _ = said_by(tmp_path / "b.tif")
    assert (first[MAKER], settings[SENSITIVITY], place[LATITUDE_SIDE]) == ("Camera", 400, "N")


def test_a_tiff_in_another_order_or_layout_than_ours_is_left_as_it_is(tmp_path):
    for options in ({"byteorder": ">"}, {"bigtiff": True}):
        tifffile.imwrite(tmp_path / "a.tif", np.zeros((4, 5, 3), np.uint8), photometric="rgb", **options)
        tiff = (tmp_path / "a.tif").read_bytes()
        assert with_exif(tiff, full_block("<")) == tiff


def test_makers_notes_and_blank_texts_of_a_tiff_stay_behind(tmp_path):
    noted = with_exif(written(tmp_path / "a.tif", None).read_bytes(), full_block("<"))
    assert MAKER_NOTE in read_directory(noted).inner[EXIF].entries
    told = read_directory(exif_of_tiff(noted)).inner[EXIF].entries
    assert LENS in told
    assert MAKER_NOTE not in told
    blank = [(AUTHOR, "s", 0, "   ", True)]
    tifffile.imwrite(tmp_path / "b.tif", np.zeros((4, 4), np.uint8), metadata=None, software=False, extratags=blank)
    assert exif_of_tiff((tmp_path / "b.tif").read_bytes()) is None


def test_a_png_of_before_there_was_exif_in_it_has_it_as_text(tmp_path):
    block = full_block("<")
    text = f"\nexif\n    {len(block)}\n" + "\n".join(block.hex()[i : i + 72] for i in range(0, 2 * len(block), 72))
    notes = PngInfo()
    notes.add_text("Raw profile type exif", text, zip=True)
    Image.new("RGB", (7, 9)).save(tmp_path / "a.png", pnginfo=notes)
    assert bytes(read_directory(read_photo(tmp_path / "a.png").exif).entries[AUTHOR].data) == b"Someone\0"


@pytest.mark.parametrize("tag", [273, 700, 33723, 34377, 34675, 37724])
def test_where_pixels_lay_and_what_programs_keep_for_themselves_stay_behind(tag):
    entries = {AUTHOR: Entry(2, 8, b"Someone\0"), tag: Entry(7, 6, b"secret")}
    carried = carried_block(b"Exif\0\0II*\0\x08\0\0\0" + laid_out(Directory("<", entries, {}), 8))
    assert b"Someone" in carried
    assert b"secret" not in carried
    alone = laid_out(Directory("<", {tag: Entry(7, 6, b"secret")}, {}), 8)
    assert carried_block(b"Exif\0\0II*\0\x08\0\0\0" + alone) is None
