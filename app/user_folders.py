"""relight's folders among the user's own, where this system keeps such things; they may not exist yet."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def config_folder() -> Path:
    """For settings."""
    return _folder(("APPDATA", "AppData/Roaming"), "Application Support", ("XDG_CONFIG_HOME", ".config"))


def cache_folder() -> Path:
    """For what can be made again."""
    return _folder(("LOCALAPPDATA", "AppData/Local"), "Caches", ("XDG_CACHE_HOME", ".cache"))


def _folder(windows: tuple[str, str], mac: str, others: tuple[str, str]) -> Path:
    """The system's folder: what a variable names, else a place in the user's home; a Mac has a fixed one."""
    if sys.platform == "darwin":
        return Path.home() / "Library" / mac / "relight"
    variable, place = windows if sys.platform == "win32" else others
    return Path(os.environ.get(variable) or Path.home() / place) / "relight"
