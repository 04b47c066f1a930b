"""What the command line calls to open the editor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.making import make_relighter
from app.window.glfw_window import NoDisplayError
from app.window.graphics import GraphicsLostError

__all__ = ["GraphicsLostError", "NoDisplayError", "run_editor"]


def run_editor(paths: Sequence[Path] = (), light: str | None = None) -> int:
    """Open the editor and return when the user closes it.

    Args:
        paths: what to open at once: portraits, folders of them, a session; what can't be opened is told in the
            window.
        light: a bundled rig's name, an .hdr or .exr panorama, a portrait whose light is borrowed, or a light
            or session file; None leaves a session its own.

    Returns:
        Exit code 0.

    Raises:
        NoDisplayError: there is no display, or none with OpenGL 3.3; nothing was opened.
        GraphicsLostError: the driver failed while the editor ran, and again when it was started anew.
    """
    from app.engine.calibration_file import cache_path
    from app.engine.pace import yield_to_the_window
    from app.engine.places import full_path
    from app.settings import settings_path
    from app.window.dropped import open_named
    from app.window.window import EditorWindow

    kept = {"settings_path": settings_path(), "calibration_path": cache_path()}
    window = EditorWindow(make_relighter, on_engine_start=yield_to_the_window, **kept)
    try:
        # While its folder is still there.
        open_named(window.state, [full_path(path) for path in paths], light)
        window.run()
    finally:
        window.close()
    return 0
