"""What a photo's file says beside its pixels, as far as a result may say it too; and files that need developing."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

_ORIENTATION = 274
_PICTURE_ITSELF = (256, 257, 258, 259, 262, 273, 277, 278, 279, 284, 338, 320, 700, 34675, 0x8773)
_UPRIGHT = 1
_LARGEST_BLOCK = 60_000
_RAW_SUFFIXES = (".cr2", ".cr3", ".nef", ".arw", ".dng", ".raf", ".orf", ".rw2", ".pef", ".srw", ".x3f", ".nrw")
_HEIF_BRANDS = (b"heic", b"heix", b"mif1", b"msf1", b"hevc")


def carried_exif(image: Image.Image) -> bytes | None:
    """An opened file's EXIF as a result may carry it: camera, time, place and author, upright, no thumbnail.

    Returns:
        A block that starts with "Exif"; None where there is nothing or it is damaged or too large.
    """
    try:
        exif = image.getexif()
        for tag in _PICTURE_ITSELF:
            exif.pop(tag, None)
        if not len(exif):
            return None
        exif[_ORIENTATION] = _UPRIGHT
        block = exif.tobytes()
    except Exception:
        return None
    return block if len(block) <= _LARGEST_BLOCK else None


def raw_message(data: bytes, path: Path) -> str | None:
    """What to do with a camera's raw file or an iPhone's HEIC; None for other files."""
    if path.suffix.lower() in _RAW_SUFFIXES or data.startswith((b"FUJIFILMCCD-RAW", b"IIRO", b"FOVb")):
        return "a camera's raw file, which must be developed first; export it as a 16-bit TIFF from your raw converter"
    if data[4:8] == b"ftyp" and data[8:12] in _HEIF_BRANDS:
        return "HEIC isn't read here; export it as JPEG, PNG or TIFF"
    return None
