"""The size of the photo that boxes and strokes were made on, as a session's JSON holds it."""

from __future__ import annotations

from pathlib import Path

from app.document.json_fields import Fields
from app.engine.resized import Size
from relight_core.errors import InputError

_KEY = "photo_size"
_LARGEST_PX = 1e6
_SIDES = ("width", "height")


def photo_size_content(size: Size | None) -> dict | None:
    """A size as JSON holds it; None where the photo has not been read."""
    return None if size is None else dict(zip(_SIDES, size, strict=True))


def read_photo_size(fields: Fields, path: Path) -> Size | None:
    """The size in a session; None in one that was saved before there were any.

    Args:
        path: of the session, for messages.

    Raises:
        InputError: a size that is none.
    """
    if fields.is_nothing(_KEY):
        return None
    group = fields.group(_KEY)
    width, height = (group.number(key, 0.0, _LARGEST_PX, 0.0) for key in _SIDES)
    group.finish()
    if not (width >= 1 and height >= 1 and width.is_integer() and height.is_integer()):
        raise InputError(f"{path}: the photo's size is none; mend the file or delete its {_KEY}")
    return int(width), int(height)
