"""Small good pictures in every format and flavour."""

from __future__ import annotations

import io
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import tifffile
from PIL import Image, ImageCms

from relight_core.imaging.write import write_exr_layers

_HEIC = Path(__file__).resolve().parents[1] / "imaging" / "heic"
_TIFF_CODECS = ("raw", "tiff_lzw", "packbits", "tiff_deflate", "jpeg", "zstd", "lzma")


def _picture(kind: type = np.uint8, channels: int = 3) -> np.ndarray:
    noise = np.random.default_rng(0).integers(0, 256, (20, 24, channels))
    return (noise * (257 if kind is np.uint16 else 1)).astype(kind)


def photos() -> list[bytes]:
    """A picture in each format of photos and in many of their flavours."""
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
    return [*encoded, *hdrs()]


def hdrs() -> list[bytes]:
    """A Radiance picture."""
    return [cv2.imencode(".hdr", np.random.default_rng(1).random((8, 16, 3)).astype(np.float32) * 4)[1].tobytes()]


def exrs(folder: Path) -> list[bytes]:
    """The EXRs that the program itself writes."""
    noise = np.random.default_rng(2).random((8, 16, 3)).astype(np.float32)
    rgba = np.dstack([noise, noise[..., 0]])
    found = []
    for half, layers in ((True, {"RGB": noise}), (False, {"RGBA": rgba, "albedo": noise})):
        path = folder / "seed.exr"
        write_exr_layers(path, layers, half=half, header={"software": "relight"})
        found.append(path.read_bytes())
    return found


def pictures_by_kind() -> dict[str, list[bytes]]:
    """The formats of photos one by one, each in several flavours."""
    smooth = np.linspace(0, 255, 40 * 48 * 3).reshape(40, 48, 3).astype(np.uint8)
    colour, grey = Image.fromarray(smooth), Image.fromarray(smooth[..., 0])
    alpha = Image.fromarray(np.dstack([smooth, smooth[..., 0]]))
    bits = grey.convert("1")
    deep = [cv2.imencode(".png", smooth.astype(np.uint16) * 257)[1].tobytes()]
    tiffs = [_saved(colour, "TIFF", compression=codec) for codec in _TIFF_CODECS]
    for array, codec in ((smooth.astype(np.uint16) * 257, None), (smooth.astype(np.float32), "zlib")):
        buffer = io.BytesIO()
        tifffile.imwrite(buffer, array, photometric="rgb", compression=codec)
        tiffs.append(buffer.getvalue())
    for kind in (np.uint16, np.float16):
        buffer = io.BytesIO()
        layout = {"photometric": "rgb", "planarconfig": "separate", "compression": "zlib"}
        tifffile.imwrite(buffer, np.moveaxis(smooth, 2, 0).astype(kind), **layout)
        tiffs.append(buffer.getvalue())
    return {
        "jpeg": [
            *(_saved(colour, "JPEG", quality=90, subsampling=s) for s in (0, 2)),
            _saved(colour, "JPEG", progressive=True),
            _saved(colour, "JPEG", restart_marker_blocks=2),
            _saved(colour.convert("CMYK"), "JPEG"),
            _saved(grey, "JPEG"),
        ],
        "png": [*(_saved(image, "PNG") for image in (colour, alpha, grey, bits, colour.quantize(16))), *deep],
        "tiff": [*tiffs, _saved(bits, "TIFF", compression="group4"), _saved(alpha, "TIFF"), _saved(grey, "TIFF")],
        "webp": [_saved(alpha, "WEBP", lossless=True), _saved(alpha, "WEBP", quality=60), _saved(colour, "WEBP")],
        "avif": [_saved(colour, "AVIF"), _saved(alpha, "AVIF")],
        "heic": [path.read_bytes() for path in sorted(_HEIC.glob("*.heic"))],
    }


def _saved(image: Image.Image, kind: str, **options) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def coded_exrs(folder: Path) -> list[bytes]:
    """EXRs in every compression, in lines and in tiles, and one of two parts."""
    ramp = np.linspace(0, 4, 32 * 64 * 3).reshape(32, 64, 3)
    codecs = [getattr(OpenEXR, name) for name in dir(OpenEXR) if name.endswith("_COMPRESSION")]
    path, found = folder / "coded.exr", []
    for codec in codecs:
        for kind in (np.float16, np.float32):
            header = {"compression": codec, "type": OpenEXR.scanlineimage}
            if kind == np.float16:
                header |= {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
            OpenEXR.File(header, {"RGB": ramp.astype(kind)}).write(str(path))
            found.append(path.read_bytes())
    colour, depth = {"RGB": ramp.astype(np.float32)}, {"Z": np.ones((32, 64), np.float32)}
    parts = [
        OpenEXR.Part({"type": OpenEXR.scanlineimage}, channels, name)
        for name, channels in (("picture", colour), ("depth", depth))
    ]
    OpenEXR.File(parts).write(str(path))
    return [*found, path.read_bytes()]
