"""Where a picture goes that was named in the panel: a line that may say anything while it is typed."""

from __future__ import annotations

from pathlib import Path

from app.engine.places import from_home

_EXPORT_SUFFIXES = (".png", ".exr", ".jpg", ".jpeg", ".tif", ".tiff")


def named_place(typed: str, suggested: Path, suffix: str | None) -> Path:
    """The whole path of what was typed; what names no file, such as "/", means the suggested one.

    Args:
        suggested: the place beside the photo, in whose folder a name alone lies.
        suffix: the kind of file it becomes; None leaves it as it was typed.
    """
    path = suggested.parent / from_home(Path(typed))
    if not typed or Path(typed).name in ("", "~", ".."):
        path = suggested
    if suffix is None:
        return path
    is_ours = path.suffix.lower() in _EXPORT_SUFFIXES
    return path.with_suffix(suffix) if is_ours else path.with_name(path.name + suffix)
