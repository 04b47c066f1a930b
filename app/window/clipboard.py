"""Putting a picture on the system's clipboard."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from relight_core.errors import InputError

_LONGEST_S = 20.0


def copy_png(png: bytes) -> None:
    """Put an encoded PNG on the clipboard.

    Raises:
        InputError: this system has no tool for it.
    """
    if sys.platform == "darwin":
        _with_file(
            png, lambda path: ["osascript", "-e", f'set the clipboard to (read (POSIX file "{path}") as «class PNGf»)']
        )
    elif sys.platform == "win32":
        _with_file(png, _windows_command)
    else:
        _run(_linux_command(), png)


def _linux_command() -> list[str]:
    # Both may be installed, and wl-copy fails where there is no Wayland to talk to.
    if os.environ.get("WAYLAND_DISPLAY") and shutil.which("wl-copy"):
        return ["wl-copy", "--type", "image/png"]
    if shutil.which("xclip"):
        return ["xclip", "-selection", "clipboard", "-t", "image/png", "-i"]
    raise InputError("There is no clipboard tool here: install xclip, or wl-clipboard under Wayland")


def _windows_command(path: Path) -> list[str]:
    # Temporary folders lie in the user's own, and users may be called O'Brien.
    quoted = str(path).replace("'", "''")
    script = (
        "Add-Type -AssemblyName System.Windows.Forms, System.Drawing; "
        f"[Windows.Forms.Clipboard]::SetImage([Drawing.Image]::FromFile('{quoted}'))"
    )
    return ["powershell", "-NoProfile", "-STA", "-Command", script]


def _with_file(png: bytes, command: Callable[[Path], list[str]]) -> None:
    with tempfile.TemporaryDirectory(prefix="relight-") as folder:
        path = Path(folder) / "picture.png"
        path.write_bytes(png)
        _run(command(path), None)


def _run(command: list[str], given: bytes | None) -> None:
    try:
        # xclip stays behind to serve the picture; it must not keep a pipe of ours open.
        subprocess.run(
            command,
            input=given,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=_LONGEST_S,
            check=True,
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise InputError(f"The clipboard took no picture ({type(error).__name__}); save it instead") from error
