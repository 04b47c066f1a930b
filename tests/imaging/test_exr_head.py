"""How many channels an EXR's head lists, in one part or in several, whole or cut."""

import struct

import pytest

from relight_core.imaging.formats.exr_head import most_channels

IN_PARTS = 0x1000


def attribute(name, kind, content):
    return name + b"\0" + kind + b"\0" + struct.pack("<I", len(content)) + content


def part(count):
    """One part's attributes, its channels between others."""
    channels = b"".join(b"layer.%d\0" % i + struct.pack("<iB3xii", 1, 0, 1, 1) for i in range(count)) + b"\0"
    others = attribute(b"name", b"string", b"part"), attribute(b"lineOrder", b"lineOrder", b"\0")
    return others[0] + attribute(b"channels", b"chlist", channels) + others[1] + b"\0"


def head(*parts, flags=0):
    return b"\x76\x2f\x31\x01" + struct.pack("<I", 2 | flags) + b"".join(parts)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (head(part(3)), 3),
        (head(part(5000)), 5000),
        (head(part(3), part(7), part(2), b"\0", flags=IN_PARTS), 7),
        (head(part(3), part(7), flags=0), 3),
        (head(part(4), part(7)[:30], flags=IN_PARTS), 4),
        (head(b"\0"), 0),
        (head(b"x" * 1000), 0),
        (b"\x76\x2f", 0),
        (b"", 0),
    ],
)
def test_the_fullest_part_counts_as_far_as_the_head_goes(tmp_path, data, expected):
    (tmp_path / "a.exr").write_bytes(data)
    assert most_channels(tmp_path / "a.exr") == expected
