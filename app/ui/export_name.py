"""Where a picture goes that was named in the panel: a line that may say anything while it is typed."""

from __future__ import annotations

from pathlib import Path

from app.engine.places import from_home

_ALIKE = ((".png",), (".exr",), (".jpg", ".jpeg"), (".tif", ".tiff"))
"""The suffixes of each kind of picture."""


def named_as(path: Path, suffix: str) -> Path:
    """The path as the name of a kind of file, "me.relight.json" being one of ".json".

    A name that says so stays as it is, of another kind of picture it is this one's; else the suffix is added.
    """
    own, kind = path.suffix.lower(), Path("any" + suffix).suffix
    alike = next((group for group in _ALIKE if kind in group), (kind,))
    if own in alike:
        return path
    are_pictures = all(any(one in group for group in _ALIKE) for one in (own, kind))
    return path.with_suffix(suffix) if are_pictures else path.with_name(path.name + suffix)


def named_place(typed: str, suggested: Path, suffix: str | None) -> Path:
    """The whole path of what was typed; what names no file, such as "/", means the suggested one.

    Args:
        suggested: the place beside the photo, in whose folder a name alone lies.
        suffix: the kind of file it becomes; None leaves it as it was typed.
    """
    path = suggested.parent / from_home(Path(typed))
    if not typed or Path(typed).name in ("", "~", ".."):
        path = suggested
    return path if suffix is None else named_as(path, suffix)
