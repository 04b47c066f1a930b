"""Whether the scans of a JPEG, in whatever order a program writes them, bring all of its picture."""

import pytest

from relight_core.imaging.formats.jpeg_scans import has_all_scans

HUFFMAN, BASELINE, PROGRESSIVE, END = 0xC4, 0xC0, 0xC2, b"\xff\xd9"
ALL = 0, 63


def segment(marker, content):
    return bytes([0xFF, marker]) + (len(content) + 2).to_bytes(2, "big") + bytes(content)


def frame(kind, components=(1, 2, 3)):
    return segment(kind, [8, 0, 16, 0, 16, len(components), *(n for one in components for n in (one, 0x11, 0))])


def scan(components, coefficients, bits=0):
    """With some data, in which marked bytes and restarts count for nothing."""
    head = [len(components), *(n for one in components for n in (one, 0)), *coefficients, bits]
    return segment(0xDA, head) + b"\x12\xff\x00\xc2\xff\xd0\x34"


TABLES = segment(HUFFMAN, [0x11] * 20)
BEGUN = b"\xff\xd8" + TABLES + frame(PROGRESSIVE) + scan([1, 2, 3], (0, 0), 0x01)
LUMA, CHROMA = scan([1], (1, 63)), scan([2], (1, 63)) + scan([3], (1, 63))
LAST_BITS = scan([1, 2, 3], (0, 0), 0x10)


@pytest.mark.parametrize(
    ("data", "is_whole"),
    [
        (b"\xff\xd8" + TABLES + frame(BASELINE) + scan([1, 2, 3], ALL), True),
        (BEGUN + CHROMA + LUMA + LAST_BITS, True),
        (BEGUN + CHROMA + LUMA, False),
        (BEGUN + LUMA + LAST_BITS, False),
        (BEGUN + LUMA + scan([2], (1, 62)) + scan([3], (1, 63)) + LAST_BITS, False),
        # What follows the end is another picture's.
        (BEGUN + LUMA + CHROMA + END + LAST_BITS, False),
        ((BEGUN + LUMA + CHROMA + segment(0xDA, [3, 1, 0, 2, 0, 3, 0, 0, 0, 0x10]))[:-1], False),
    ],
)
def test_every_bit_of_every_coefficient_has_its_scan(data, is_whole):
    assert has_all_scans(data) == is_whole
