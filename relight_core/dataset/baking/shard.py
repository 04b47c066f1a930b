"""One baked head as one file: compressed, checksummed (by the zip's CRC), versioned, written whole or not at all.

Version 3 stores quantised values as residuals of a prediction from neighbouring pixels, and visibility bits in Morton
order, and compresses with LZMA. Version 2 (finer quantisation, differences between consecutive pixels) and version 1
(half floats in row order under deflate) are still read.
"""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from relight_core.dataset.archive import read_arrays
from relight_core.dataset.baking import shard_coding as coding
from relight_core.dataset.baking.bake import BakedHead
from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_decode_integers, srgb_encode
from relight_core.imaging.files import whole_file

VERSION = 3

_UNPAINTED = ("covered", "size", "normal", "depth", "uv", "material", "label", "visibility")
_ARRAYS = {1: _UNPAINTED, 2: (*_UNPAINTED, "albedo"), 3: (*_UNPAINTED, "albedo")}
_MEND = "delete it and run 'relight dataset bake' again"


def write_shard(path: Path, head: BakedHead) -> None:
    """Store a head; see `shard_coding` for what rounding costs."""
    albedo = np.empty((0, 3)) if head.albedo is None else head.albedo
    order = coding.morton_order(head.covered)
    arrays = {
        "version": np.int32(VERSION),
        "covered": np.packbits(head.covered),
        "size": np.int32(head.size),
        "normal": coding.prediction_residuals(coding.code_normals(head.normal), head.covered),
        "depth": coding.prediction_residuals(coding.code_depth(head.depth)[:, None], head.covered),
        "uv": coding.prediction_residuals(coding.code_uv(head.uv), head.covered),
        "material": head.material,
        "label": head.label,
        "visibility": coding.reorder_bits(head.visibility, len(order), order),
        "albedo": np.round(srgb_encode(np.clip(albedo, 0, 1)) * 255).astype(np.uint8),
    }
    with whole_file(path) as beside, zipfile.ZipFile(beside, "w", zipfile.ZIP_LZMA) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w") as file:
                np.lib.format.write_array(file, np.asarray(array, order="C"), allow_pickle=False)


def shard_size(path: Path) -> int:
    """The side of a head's images in pixels; raises InputError for a damaged file."""
    return _number(path, "size")


def read_shard(path: Path) -> BakedHead:
    """Load a head; raises InputError for a damaged file or one of an unknown version."""
    version = _number(path, "version")
    if version not in _ARRAYS:
        raise InputError(f"{path}: baked by another version; {_MEND}")
    data = read_arrays(path, _ARRAYS[version], "a baked head", _MEND)
    try:
        size = int(data["size"])
        covered = np.unpackbits(data["covered"], count=size * size).view(bool).reshape(size, size)
        head = BakedHead(covered=covered, **_DECODERS[version](data, covered))
    except (ValueError, TypeError, IndexError) as error:
        raise InputError(f"{path}: damaged head ({error}); {_MEND}") from error
    if len(head.normal) != covered.sum():
        raise InputError(f"{path}: damaged head (pixels are missing); {_MEND}")
    return head


def _number(path: Path, name: str) -> int:
    value = read_arrays(path, (name,), "a baked head", _MEND)[name]
    if value.shape or value.dtype.kind not in "iu":
        raise InputError(f"{path}: damaged head (its {name} is no number); {_MEND}")
    return int(value)


def _decode_version_1(data: dict[str, np.ndarray], _covered: np.ndarray) -> dict[str, np.ndarray]:
    normal = data["normal"].astype(np.float32)
    return {
        "normal": normal / np.linalg.norm(normal, axis=1, keepdims=True),
        "depth": data["depth"].astype(np.float32),
        "uv": data["uv"].astype(np.float32) / 65535,
        "material": data["material"],
        "label": data["label"],
        "visibility": data["visibility"],
    }


def _decode_version_2(data: dict[str, np.ndarray], covered: np.ndarray) -> dict[str, np.ndarray | None]:
    normal, depth, uv = (coding.from_differences(data[name]) for name in ("normal", "depth", "uv"))
    return _decoded(data, covered, (normal, depth, uv), coding.VERSION_2)


def _decode_version_3(data: dict[str, np.ndarray], covered: np.ndarray) -> dict[str, np.ndarray | None]:
    normal, depth, uv = (coding.from_residuals(data[name], covered) for name in ("normal", "depth", "uv"))
    return _decoded(data, covered, (normal, depth[:, 0], uv), coding.VERSION_3)


def _decoded(
    data: dict[str, np.ndarray], covered: np.ndarray, codes: tuple[np.ndarray, ...], precision: coding.Precision
) -> dict[str, np.ndarray | None]:
    back = np.argsort(coding.morton_order(covered))
    normal, depth, uv = codes
    return {
        "normal": coding.decode_normals(normal, precision.normal),
        "depth": coding.decode_depth(depth, precision.depth),
        "uv": coding.decode_uv(uv, precision.uv),
        "material": data["material"],
        "label": data["label"],
        "visibility": coding.reorder_bits(data["visibility"], len(back), back),
        "albedo": srgb_decode_integers(data["albedo"]) if len(data["albedo"]) else None,
    }


_DECODERS = {1: _decode_version_1, 2: _decode_version_2, 3: _decode_version_3}
