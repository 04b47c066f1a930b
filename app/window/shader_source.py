"""GLSL from shaders/: one file per program, both stages in it, other files pasted in where it says so."""

from __future__ import annotations

import re
from pathlib import Path

import moderngl

_FOLDER = Path(__file__).resolve().parent.parent.parent / "shaders"
_INCLUDE = re.compile(r'^#include "([^"]+)"$', re.MULTILINE)


def shader_program(context: moderngl.Context, name: str, *switches: str) -> moderngl.Program:
    """A program, compiled from its file.

    Args:
        name: the file's, without its suffix.
        switches: what it may test with #ifdef.

    Raises:
        FileNotFoundError: no such file, or one that it includes.
        moderngl.Error: the driver can't compile it.
    """
    return context.program(*(_stage(name, stage, *switches) for stage in ("VERTEX_STAGE", "FRAGMENT_STAGE")))


def _stage(name: str, *switches: str) -> str:
    body = _INCLUDE.sub(lambda match: _read(match.group(1)), _read(f"{name}.glsl"))
    defined = "".join(f"#define {switch}\n" for switch in switches)
    return f"#version 330 core\n{defined}{body}"


def _read(filename: str) -> str:
    return (_FOLDER / filename).read_text(encoding="utf-8")
