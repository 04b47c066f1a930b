"""What a dropped file is for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.engine.sources import LightSource
from app.ui.state import EditorState


def take_files(state: EditorState, paths: Sequence[Path], x: float, y: float) -> None:
    """Open dropped files: the first photo as the portrait, the first panorama as the light.

    A file dropped on the light panel is a light, a portrait there being one whose light is borrowed.

    Args:
        x, y: where they were dropped, in window units.
    """
    x0, y0, x1, y1 = state.light_panel
    if x0 <= x < x1 and y0 <= y < y1:
        state.choose_light(LightSource.named(str(paths[0])))
        return
    lights = [path for path in paths if is_panorama(path)]
    photos = [path for path in paths if path not in lights]
    if lights:
        state.choose_light(LightSource("panorama", str(lights[0])))
    if photos:
        state.open_photo(photos[0])


def is_panorama(path: Path) -> bool:
    """Whether a file is a light: .hdr always, .exr if it is twice as wide as high."""
    suffix = path.suffix.lower()
    if suffix != ".exr":
        return suffix == ".hdr"
    size = _exr_size(path)
    return size is not None and size[0] == 2 * size[1]


def _exr_size(path: Path) -> tuple[int, int] | None:
    """Width and height as the header states them; None if it can't be read."""
    import OpenEXR

    try:
        with OpenEXR.File(str(path), header_only=True) as file:
            low, high = file.header()["dataWindow"]
    except Exception:
        return None
    return int(high[0] - low[0] + 1), int(high[1] - low[1] + 1)
