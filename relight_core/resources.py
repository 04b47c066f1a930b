"""Where the files that travel with the project lie: weights, light rigs, fonts, the icon."""

from __future__ import annotations

from pathlib import Path

from relight_core.errors import InputError

_ROOT = Path(__file__).resolve().parent.parent / "resources"


def resource_path(*parts: str) -> Path:
    """Path of a bundled file or folder, for example resource_path("rigs", "ring.toml").

    The folder `resources` lies beside the package in the source tree, so the project runs from a
    checkout: `pip install -e .` or `make setup`.

    Raises:
        FileNotFoundError: no such resource.
        InputError: the package was installed without its resources.
    """
    if not _ROOT.is_dir():
        raise InputError(f"no folder {_ROOT}; run from a checkout of the project (make setup, or pip install -e .)")
    path = _ROOT.joinpath(*parts)
    if not path.exists():
        raise FileNotFoundError(f"no resource {'/'.join(parts)} in {_ROOT}")
    return path
