"""Relight a portrait photo: open it in the editor.

Without PHOTO the editor opens a sample portrait; several, or a folder, become a queue. Where there is no display,
relit pictures of one photo, their channels and a turntable sheet are written into the folder out/ instead.
"""

from __future__ import annotations

import argparse
import difflib
import os
import sys
from pathlib import Path

from app.cli.arguments import add_light, user_path
from app.cli.session import light_kind, sample_portrait
from app.cli.streams import say, tell
from relight_core import __version__
from relight_core.errors import InputError

OUT = Path("out")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight`."""
    words = "a portrait photo, a folder of them, or a session saved in the editor"
    parser.add_argument("photos", metavar="PHOTO", nargs="*", type=user_path, help=words)
    add_light(parser, required=False)
    parser.add_argument("--version", action="version", version=f"relight {__version__}")


def run(arguments: argparse.Namespace) -> int:
    """Open the editor, or write files where it can't open; returns the exit code."""
    photos = [_existing(photo) for photo in arguments.photos] or [sample_portrait()]
    if arguments.light is not None:
        light_kind(arguments.light)
    if not has_display():
        return _write_pictures(photos, arguments.light, "there is no display")
    from app.window.run import GraphicsLostError, NoDisplayError, run_editor

    try:
        return run_editor(photos, arguments.light)
    except NoDisplayError as error:
        return _write_pictures(photos, arguments.light, str(error))
    except GraphicsLostError as error:
        tell(f"relight: {error}")
        return 1


def _write_pictures(photos: list[Path], light: str | None, reason: str) -> int:
    from app.cli.demo import write_demo

    if len(photos) > 1 or os.path.isdir(photos[0]):
        raise InputError(f"the editor can't open several photos ({reason}); relight render writes them into files")
    say(f"The editor can't open ({reason}); writing pictures into {OUT}/ instead.")
    write_demo(photos[0], light, OUT)
    return 0


def has_display() -> bool:
    """Whether a window could open: always on macOS and Windows, with X11 or Wayland elsewhere."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _existing(photo: Path) -> Path:
    if os.path.lexists(photo):
        return photo
    from app.cli.main import available_commands

    near = difflib.get_close_matches(str(photo), available_commands(), n=1)
    guess = f"did you mean relight {near[0]}?" if near else "check the path, or see relight --help"
    raise InputError(f"{photo}: no such photo and no such command; {guess}")
