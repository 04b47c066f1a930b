"""Tensors and words as one safetensors file: equal ones make equal files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping

import torch
from safetensors.torch import save

_LENGTH_BYTES = 8
"""Of the header's own length, before it, and what that is a multiple of."""


def tensor_file(tensors: Mapping[str, torch.Tensor], words: Mapping[str, str]) -> bytes:
    """The file's bytes.

    The library writes the words in the order of a hash table, which is another every time, and weights that differ
    in nothing would be told apart by their digest (`imaging.files.file_digest`).
    """
    data = save(dict(tensors), metadata=dict(words))
    end = _LENGTH_BYTES + int.from_bytes(data[:_LENGTH_BYTES], "little")
    header = json.loads(data[_LENGTH_BYTES:end])
    header["__metadata__"] = dict(sorted(header["__metadata__"].items()))
    text = json.dumps(header, ensure_ascii=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % _LENGTH_BYTES)
    return b"".join([len(text).to_bytes(_LENGTH_BYTES, "little"), text, memoryview(data)[end:]])


def checksum(tensors: Mapping[str, torch.Tensor]) -> str:
    """SHA-256, in hex, of names, types, shapes and values of tensors on the CPU."""
    digest = hashlib.sha256()
    for name in sorted(tensors):
        value = tensors[name]
        digest.update(repr((name, str(value.dtype), tuple(value.shape))).encode())
        digest.update(value.contiguous().reshape(-1).view(torch.uint8).numpy())
    return digest.hexdigest()
