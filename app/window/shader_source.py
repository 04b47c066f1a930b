"""GLSL from shaders/: one file per program, both stages in it, other files pasted in where it says so."""

from __future__ import annotations

import re
from pathlib import Path

_FOLDER = Path(__file__).resolve().parent.parent.parent / "shaders"
_INCLUDE = re.compile(r'^#include "([^"]+)"$', re.MULTILINE)


def stage_source(name: str, stage: str, *switches: str) -> str:
    """The text of one stage of a program.

    Args:
        name: the program's file without its suffix.
        stage: "VERTEX_STAGE" or "FRAGMENT_STAGE", which the file tests with #ifdef.
        switches: what else it may test so.

    Raises:
        FileNotFoundError: no such file, or one that it includes.
    """
    body = _INCLUDE.sub(lambda match: _read(match.group(1)), _read(f"{name}.glsl"))
    defined = "".join(f"#define {switch}\n" for switch in (stage, *switches))
    return f"#version 330 core\n{defined}{body}"


def _read(filename: str) -> str:
    return (_FOLDER / filename).read_text(encoding="utf-8")
