"""Profiles that are tables (CMYK, Lab, scanners' RGB), at 8 bits through LittleCMS."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image, ImageCms


def convert_8_bit(values: np.ndarray, icc: bytes) -> np.ndarray | None:
    """(H, W, 1 or 3) uint8 in any profile to (H, W, 3) uint8 sRGB; None if the profile is unusable."""
    image = Image.fromarray(values[..., 0] if values.shape[-1] == 1 else values)
    try:
        return np.asarray(_convert_image(image, icc))
    except (ImageCms.PyCMSError, OSError, ValueError):
        return None


def through_library_profile(image: Image.Image, icc: bytes | None) -> np.ndarray:
    """A CMYK or LAB image in a profile, or in none that is usable, to (H, W, 3) uint8 sRGB."""
    if icc is not None:
        try:
            return np.asarray(_convert_image(image, icc))
        except (ImageCms.PyCMSError, OSError, ValueError):
            pass
    if image.mode == "LAB":
        lab = ImageCms.createProfile("LAB")
        return np.asarray(ImageCms.profileToProfile(image, lab, ImageCms.createProfile("sRGB"), outputMode="RGB"))
    return np.asarray(image.convert("RGB"))


def _convert_image(image: Image.Image, icc: bytes) -> Image.Image:
    profile = ImageCms.ImageCmsProfile(io.BytesIO(icc))
    return ImageCms.profileToProfile(
        image,
        profile,
        ImageCms.createProfile("sRGB"),
        renderingIntent=ImageCms.Intent.RELATIVE_COLORIMETRIC,
        outputMode="RGB",
        flags=ImageCms.Flags.BLACKPOINTCOMPENSATION,
    )
