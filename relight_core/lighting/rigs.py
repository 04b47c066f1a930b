"""The bundled light rigs, each a TOML file in resources/rigs that is drawn when it is first needed."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from relight_core.errors import InputError
from relight_core.lighting.environment import Environment
from relight_core.lighting.rig_description import Rig, read_rig
from relight_core.lighting.rig_render import Drawn, render_rig
from relight_core.resources import resource_path

RIG_HEIGHT = 256


def rig_names() -> list[str]:
    """Names of the bundled rigs, in alphabetical order."""
    return sorted(path.stem for path in resource_path("rigs").glob("*.toml"))


def read_bundled_rig(name: str) -> Rig:
    """The description of a bundled rig.

    Raises:
        InputError: no rig of that name.
    """
    if name not in rig_names():
        raise InputError(f"no light rig called {name}; there are {', '.join(rig_names())}")
    return read_rig(resource_path("rigs", f"{name}.toml"))


@lru_cache(maxsize=32)
def load_rig(name: str) -> Environment:
    """A bundled rig as a light, 256 x 512; the same object for every call.

    Raises:
        InputError: no rig of that name.
    """
    rig = read_bundled_rig(name)
    light = Environment.from_radiance(render_rig(rig, RIG_HEIGHT), name)
    return replace(light, drawn=Drawn(rig, light.level))
