"""Small good files of every kind that the program reads: what the fuzzer starts from."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import tifffile
from PIL import Image, ImageCms

from relight_core.imaging.write import write_exr_layers
from relight_core.resources import resource_path


@dataclass(frozen=True)
class Reader:
    """One of the program's readers.

    Attributes:
        read: opens a file; may raise InputError and nothing else.
        seeds: good files, as bytes.
        suffix: of the files.
    """

    read: Callable[[Path], object]
    seeds: list[bytes]
    suffix: str


def readers(folder: Path) -> dict[str, Reader]:
    """Every reader by name; `folder` is scratch space."""
    from app.document.document import Document, LightRef, PhotoRef
    from app.document.light_file import SavedLight, read_light, write_light
    from app.document.session_file import read_session, write_session
    from app.settings import Settings, read_settings, write_settings
    from relight_core.dataset.lights import load_lights
    from relight_core.dataset.shard import read_shard
    from relight_core.imaging.read import read_photo
    from relight_core.lighting.environment import read_environment
    from relight_core.lighting.rig_description import read_rig
    from relight_core.networks.bundle import load_bundle
    from relight_core.training import recipe

    exr = _exr(folder)
    write_settings(folder / "settings.json", Settings(window_size=(800, 600)))
    write_session(folder / "seed.relight.json", Document(photo=PhotoRef(folder / "photo.png")))
    write_light(folder / "seed.light.json", SavedLight(LightRef("rig", "rembrandt"), yaw_deg=20.0))
    recipes = (Path(recipe.__file__).parent / "recipes").glob("*.toml")
    rigs = [path.read_bytes() for path in sorted(resource_path("rigs").glob("*.toml"))]
    return {
        "photo": Reader(read_photo, [*_photos(), *exr], ".image"),
        "hdr": Reader(read_environment, [_hdr()], ".hdr"),
        "exr": Reader(read_environment, exr, ".exr"),
        "rig": Reader(read_rig, rigs, ".toml"),
        "recipe": Reader(lambda path: recipe.load_recipe(str(path)), [path.read_bytes() for path in recipes], ".toml"),
        "session": Reader(read_session, [(folder / "seed.relight.json").read_bytes()], ".relight.json"),
        "light": Reader(read_light, [(folder / "seed.light.json").read_bytes()], ".json"),
        "weights": Reader(load_bundle, [_weights(folder)], ".safetensors"),
        "shard": Reader(read_shard, [_shard(folder)], ".npz"),
        "lights": Reader(lambda path: load_lights(path, "train"), [_light_library(folder)], ".npz"),
        "settings": Reader(read_settings, [(folder / "settings.json").read_bytes()], ".json"),
    }


def _picture(kind: type = np.uint8, channels: int = 3) -> np.ndarray:
    noise = np.random.default_rng(0).integers(0, 256, (20, 24, channels))
    return (noise * (257 if kind is np.uint16 else 1)).astype(kind)


def _photos() -> list[bytes]:
    colour, alpha = Image.fromarray(_picture()), Image.fromarray(_picture(channels=4))
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    exif = Image.Exif()
    exif[274] = 6
    pictures = [
        (colour, "JPEG", {"icc_profile": profile, "exif": exif}),
        (colour, "JPEG", {"progressive": True}),
        (colour.convert("CMYK"), "JPEG", {}),
        (alpha, "PNG", {"icc_profile": profile}),
        (colour.quantize(16), "PNG", {}),
        (colour, "TIFF", {"compression": "tiff_lzw"}),
        (alpha, "WEBP", {"lossless": True}),
        (colour, "BMP", {}),
        (colour.quantize(16), "GIF", {}),
    ]
    encoded = []
    for image, kind, options in pictures:
        buffer = io.BytesIO()
        image.save(buffer, kind, **options)
        encoded.append(buffer.getvalue())
    encoded.append(cv2.imencode(".png", _picture(np.uint16))[1].tobytes())
    for array in (_picture(np.uint16), (_picture() / 255).astype(np.float32)):
        buffer = io.BytesIO()
        tifffile.imwrite(buffer, array, photometric="rgb", compression="zlib")
        encoded.append(buffer.getvalue())
    return [*encoded, _hdr()]


def _hdr() -> bytes:
    return cv2.imencode(".hdr", np.random.default_rng(1).random((8, 16, 3)).astype(np.float32) * 4)[1].tobytes()


def _exr(folder: Path) -> list[bytes]:
    noise = np.random.default_rng(2).random((8, 16, 3)).astype(np.float32)
    rgba = np.dstack([noise, noise[..., 0]])
    found = []
    for half, layers in ((True, {"RGB": noise}), (False, {"RGBA": rgba, "albedo": noise})):
        path = folder / "seed.exr"
        write_exr_layers(path, layers, half=half, header={"software": "relight"})
        found.append(path.read_bytes())
    return found


def _weights(folder: Path) -> bytes:
    from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle

    path = folder / "seed.safetensors"
    save_bundle(path, NetworkBundle(BundleConfig.tiny()))
    return path.read_bytes()


def _shard(folder: Path) -> bytes:
    from synthetic_heads import ball

    from relight_core.dataset.shard import write_shard

    write_shard(folder / "seed.npz", ball())
    return (folder / "seed.npz").read_bytes()


def _light_library(folder: Path) -> bytes:
    from synthetic_heads import write_lights

    write_lights(folder / "lights.npz", 40)
    return (folder / "lights.npz").read_bytes()
