"""One baked head as one file: compressed, checksummed (by the zip's CRC), versioned, written whole or not at all.

Version 2 stores differences between neighbouring pixels as integers, visibility in blocks of pixels, and
compresses with LZMA. Version 1, half floats and rows of pixels under deflate, is still read.
"""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from relight_core.dataset import shard_coding as coding
from relight_core.dataset.archive import read_arrays
from relight_core.dataset.bake import BakedHead
from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_decode_integers, srgb_encode
from relight_core.imaging.files import whole_file

VERSION = 2

_ARRAYS = {
    1: ("covered", "size", "normal", "depth", "uv", "material", "label", "visibility"),
    2: ("covered", "size", "normal", "depth", "uv", "material", "label", "visibility", "albedo"),
}
_MEND = "delete it and run 'relight dataset bake' again"


def write_shard(path: Path, head: BakedHead) -> None:
    """Store a head; see `shard_coding` for what rounding costs."""
    albedo = np.empty((0, 3)) if head.albedo is None else head.albedo
    order = coding.blockwise(head.covered)
    arrays = {
        "version": np.int32(VERSION),
        "covered": np.packbits(head.covered),
        "size": np.int32(head.size),
        "normal": coding.differences(coding.code_normals(head.normal)),
        "depth": coding.differences(coding.code_depth(head.depth)),
        "uv": coding.differences(coding.code_uv(head.uv)),
        "material": head.material,
        "label": head.label,
        "visibility": coding.reorder_bits(head.visibility, len(order), order),
        "albedo": np.round(srgb_encode(np.clip(albedo, 0, 1)) * 255).astype(np.uint8),
    }
    with whole_file(path) as beside, zipfile.ZipFile(beside, "w", zipfile.ZIP_LZMA) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w") as file:
                np.lib.format.write_array(file, np.asarray(array, order="C"), allow_pickle=False)


def read_shard(path: Path) -> BakedHead:
    """Load a head; raises InputError for a damaged file or one of an unknown version."""
    version = int(read_arrays(path, ("version",), "a baked head", _MEND)["version"])
    if version not in _ARRAYS:
        raise InputError(f"{path}: baked by another version; {_MEND}")
    data = read_arrays(path, _ARRAYS[version], "a baked head", _MEND)
    try:
        size = int(data["size"])
        covered = np.unpackbits(data["covered"], count=size * size).view(bool).reshape(size, size)
        head = BakedHead(covered=covered, **(_plain(data) if version == 1 else _coded(data, covered)))
    except (ValueError, TypeError, IndexError) as error:
        raise InputError(f"{path}: damaged head ({error}); {_MEND}") from error
    if len(head.normal) != covered.sum():
        raise InputError(f"{path}: damaged head (pixels are missing); {_MEND}")
    return head


def _plain(data: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    normal = data["normal"].astype(np.float32)
    return {
        "normal": normal / np.linalg.norm(normal, axis=1, keepdims=True),
        "depth": data["depth"].astype(np.float32),
        "uv": data["uv"].astype(np.float32) / 65535,
        "material": data["material"],
        "label": data["label"],
        "visibility": data["visibility"],
    }


def _coded(data: dict[str, np.ndarray], covered: np.ndarray) -> dict[str, np.ndarray | None]:
    back = np.argsort(coding.blockwise(covered))
    return {
        "normal": coding.decode_normals(coding.summed(data["normal"])),
        "depth": coding.decode_depth(coding.summed(data["depth"])),
        "uv": coding.decode_uv(coding.summed(data["uv"])),
        "material": data["material"],
        "label": data["label"],
        "visibility": coding.reorder_bits(data["visibility"], len(back), back),
        "albedo": srgb_decode_integers(data["albedo"]) if len(data["albedo"]) else None,
    }
