"""Whether a JPEG's scans, which may each hold a part of its picture, are all there (ITU-T T.81)."""

from __future__ import annotations

import re

_MARKER = re.compile(rb"\xff([^\x00\x01\xd0-\xd8\xff])")
"""One that a segment follows; those within the data of a scan, and what is filled up before one, are none."""
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
_SCAN, _END = 0xDA, 0xD9
_MOST_COMPONENTS = 4
_ALL = (1 << 64) - 1
"""The coefficients of a block, a bit for each."""


def has_all_scans(data: bytes) -> bool:
    """Whether a scan begins in a JPEG for each of its first picture's coefficients, down to its last bit.

    A progressive picture that ends between two of its scans looks whole, and is as coarse as the first are.
    """
    missing, at = {}, 2
    while found := _MARKER.search(data, at):
        kind, at = found[1][0], found.end()
        length = int.from_bytes(data[at : at + 2], "big")
        segment = data[at + 2 : at + length]
        if kind == _END or len(segment) < length - 2:
            break
        if kind in _FRAMES and not missing:
            missing = dict.fromkeys(segment[6 : 6 + 3 * _MOST_COMPONENTS : 3], _ALL)
        elif kind == _SCAN and segment:
            finished = _finished(segment)
            missing = {component: left & ~finished.get(component, 0) for component, left in missing.items()}
        at += length
    return not any(missing.values())


def _finished(scan: bytes) -> dict[int, int]:
    """By component, the coefficients whose last bit lies in the scan that has this header."""
    count = scan[0]
    first, last, bits = scan[1 + 2 * count : 4 + 2 * count]
    finished = (2 << last) - (1 << first) if first <= last and not bits & 15 else 0
    return dict.fromkeys(scan[1 : 1 + 2 * count : 2], finished)
