"""One baked head as one file: compressed, checksummed (by the zip's CRC), versioned, written whole or not at all."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from relight_core.dataset.archive import read_arrays
from relight_core.dataset.bake import BakedHead
from relight_core.errors import InputError
from relight_core.imaging.files import whole_file

VERSION = 1

_ARRAYS = ("covered", "size", "normal", "depth", "uv", "material", "label", "visibility")
_MEND = "delete it and run 'relight dataset bake' again"


def write_shard(path: Path, head: BakedHead) -> None:
    """Store a head; normals and depth as half floats, texture coordinates as 16-bit fractions."""
    with whole_file(path) as beside, open(beside, "wb") as file:
        np.savez_compressed(
            file,
            version=np.int32(VERSION),
            covered=np.packbits(head.covered),
            size=np.int32(head.size),
            normal=head.normal.astype(np.float16),
            depth=head.depth.astype(np.float16),
            uv=np.round(np.clip(head.uv, 0, 1) * 65535).astype(np.uint16),
            material=head.material,
            label=head.label,
            visibility=head.visibility,
        )


def read_shard(path: Path) -> BakedHead:
    """Load a head; raises InputError for a damaged file or one of another version."""
    data = read_arrays(path, ("version",), "a baked head", _MEND)
    if data["version"] != VERSION:
        raise InputError(f"{path}: baked by another version; {_MEND}")
    data = read_arrays(path, _ARRAYS, "a baked head", _MEND)
    try:
        size, normal = int(data["size"]), data["normal"].astype(np.float32)
        return BakedHead(
            covered=np.unpackbits(data["covered"], count=size * size).view(bool).reshape(size, size),
            normal=normal / np.linalg.norm(normal, axis=1, keepdims=True),
            depth=data["depth"].astype(np.float32),
            uv=data["uv"].astype(np.float32) / 65535,
            material=data["material"],
            label=data["label"],
            visibility=data["visibility"],
        )
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: damaged head ({error}); {_MEND}") from error
