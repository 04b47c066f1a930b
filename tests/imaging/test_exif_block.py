"""Directories of EXIF and TIFF by their bytes: every kind of value, either order, all layouts."""

import struct

import pytest

from relight_core.imaging.formats.exif_block import Directory, Entry, block_of, laid_out, read_directory

EXIF, LENS, SENSITIVITY = 34665, 42036, 34855

NUMBERS = {3: "H", 4: "I", 5: "II", 8: "h", 9: "i", 10: "ii", 11: "f", 12: "d"}
"""By the kind of value, as `struct` calls them."""

BYTES = {1: b"\1\2\3", 2: b"text\0", 6: b"\xfe\1", 7: b"\0\1\2\3\4", 129: "東京\0".encode()}


def test_every_kind_of_value_is_kept_and_turned_into_the_other_order():
    entries = {500 + kind: Entry(kind, len(data), data) for kind, data in BYTES.items()}
    for kind, code in NUMBERS.items():
        entries[500 + kind] = Entry(kind, 2, struct.pack(">" + 2 * code, *range(3, 3 + 2 * len(code))))
    read = read_directory(block_of(Directory(">", entries, {})))
    assert {tag: (entry.kind, bytes(entry.data)) for tag, entry in read.entries.items()} == {
        tag: (entry.kind, entry.data) for tag, entry in entries.items()
    }
    turned = read_directory(block_of(read.in_byte_order("<")))
    assert turned.order == "<"
    for kind, data in BYTES.items():
        assert bytes(turned.entries[500 + kind].data) == data
    for kind, code in NUMBERS.items():
        values = struct.unpack("<" + 2 * code, turned.entries[500 + kind].data)
        assert values == tuple(range(3, 3 + 2 * len(code)))


@pytest.mark.parametrize("number", [42, 0x55, 0x4F52, 0x5352])
def test_raw_files_that_are_tiffs_by_another_number_are_read_as_well(number):
    directory = laid_out(Directory("<", {271: Entry(2, 6, b"Maker\0")}, {}), 8)
    head = b"II" + struct.pack("<HI", number, 8)
    assert bytes(read_directory(head + directory).entries[271].data) == b"Maker\0"
    assert read_directory(b"II" + struct.pack("<HI", 41, 8) + directory) is None


@pytest.mark.parametrize(("place_kind", "code"), [(4, "Ixxxx"), (13, "Ixxxx"), (16, "Q"), (18, "Q")])
def test_a_bigtiff_leads_to_its_settings_by_short_and_long_places(place_kind, code):
    head = b"MM" + struct.pack(">HHHQ", 43, 8, 0, 16)
    first = struct.pack(">QHHQ" + code, 1, EXIF, place_kind, 1, 52) + bytes(8)
    sensitivity = struct.pack(">HHQH6x", SENSITIVITY, 3, 1, 400)
    lens = struct.pack(">HHQ8s", LENS, 2, 8, b"85 mm f\0")
    inner = read_directory(head + first + struct.pack(">Q", 2) + sensitivity + lens + bytes(8)).inner[EXIF]
    assert bytes(inner.entries[LENS].data) == b"85 mm f\0"
    assert struct.unpack(">H", inner.entries[SENSITIVITY].data) == (400,)


def test_tags_stand_in_order_and_values_at_even_places():
    entries = {tag: Entry(2, 5, b"text\0") for tag in (315, 271, 305)}
    table = laid_out(Directory("<", entries, {270: Directory("<", entries, {})}), 8)
    rows = [struct.unpack_from("<HHII", table, 2 + 12 * index) for index in range(4)]
    assert [tag for tag, *_ in rows] == [270, 271, 305, 315]
    assert all(place % 2 == 0 for *_, place in rows)


def test_a_directory_that_is_cut_or_leads_nowhere_says_the_rest():
    head = b"Exif\0\0II*\0" + struct.pack("<I", 8)
    sensitivity = struct.pack("<HHIHxx", SENSITIVITY, 3, 1, 400)
    for directory in (
        struct.pack("<H", 9) + sensitivity,
        struct.pack("<H", 2) + sensitivity + struct.pack("<HHII", EXIF, 4, 1, 99_999) + bytes(4),
    ):
        assert set(read_directory(head + directory).entries) == {SENSITIVITY}


def test_a_block_may_call_itself_exif_twice():
    block = block_of(Directory(">", {271: Entry(2, 6, b"Maker\0")}, {}))
    assert read_directory(b"Exif\0\0" + block).entries.keys() == {271}
