"""What a photo's file says beside its pixels, as far as a result may say it too."""

from __future__ import annotations

from PIL import Image

_ORIENTATION = 274
_PICTURE_ITSELF = (256, 257, 258, 259, 262, 273, 277, 278, 279, 284, 338, 320, 700, 34675, 0x8773)
_UPRIGHT = 1
_LARGEST_BLOCK = 60_000


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


def carried_block(block: bytes | None) -> bytes | None:
    """The same for a file's EXIF as a block of bytes."""
    if not block:
        return None
    image = Image.new("L", (1, 1))
    image.info["exif"] = block
    return carried_exif(image)
