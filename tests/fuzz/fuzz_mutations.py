"""Damage to files, from a seed: what a bad disk, a cut download or an enemy would do."""

from __future__ import annotations

import struct
import zlib

import numpy as np

_EXTREMES = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
_PNG = b"\x89PNG\r\n\x1a\n"
_WORDS = (b"nan", b"inf", b"-1", b"1e999", b"[[", b"{" * 60, b'"', b"\0", b"\xff\xfe", b"9" * 400, b"true", b"null")


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """A copy with one to four injuries, most of them near the start, where headers are."""
    injured = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        if injured:
            _INJURIES[rng.integers(len(_INJURIES))](injured, rng)
    # A wrong checksum would end the reading of a PNG before anything interesting happens.
    return _with_right_checksums(bytes(injured)) if rng.random() < 0.7 else bytes(injured)


def _place(data: bytearray, rng: np.random.Generator) -> int:
    end = len(data) if rng.random() < 0.3 else min(len(data), 300)
    return int(rng.integers(0, max(end, 1)))


def _bit(data: bytearray, rng: np.random.Generator) -> None:
    data[_place(data, rng)] ^= 1 << int(rng.integers(8))


def _byte(data: bytearray, rng: np.random.Generator) -> None:
    data[_place(data, rng)] = int(rng.integers(256))


def _number(data: bytearray, rng: np.random.Generator) -> None:
    at, extreme = _place(data, rng), _EXTREMES[rng.integers(len(_EXTREMES))]
    form = ("<I", ">I", "<H", ">H")[rng.integers(4)]
    packed = struct.pack(form, extreme & (0xFFFF if form[1] == "H" else 0xFFFFFFFF))
    data[at : at + len(packed)] = packed


def _cut(data: bytearray, rng: np.random.Generator) -> None:
    del data[int(rng.integers(0, len(data))) :]


def _drop(data: bytearray, rng: np.random.Generator) -> None:
    at = _place(data, rng)
    del data[at : at + int(rng.integers(1, 40))]


def _repeat(data: bytearray, rng: np.random.Generator) -> None:
    at = _place(data, rng)
    data[at:at] = data[at : at + int(rng.integers(1, 200))] * int(rng.integers(1, 5))


def _word(data: bytearray, rng: np.random.Generator) -> None:
    at = _place(data, rng)
    data[at:at] = _WORDS[rng.integers(len(_WORDS))]


_INJURIES = (_bit, _byte, _byte, _number, _number, _cut, _drop, _repeat, _word)


def _with_right_checksums(data: bytes) -> bytes:
    """A PNG's chunks with the checksums of what they now hold; other files as they are."""
    if not data.startswith(_PNG):
        return data
    rebuilt, at = bytearray(_PNG), len(_PNG)
    while at + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        body = data[at + 4 : at + 8 + length]
        if len(body) < 4 + length:
            break
        rebuilt += data[at : at + 4] + body + struct.pack(">I", zlib.crc32(body))
        at += 12 + length
    return bytes(rebuilt + data[at:])
