"""Descriptions of light rigs: area lights in a room or under a sky, read from TOML.

    title = "Rembrandt"
    description = "One soft box, high and to the side."
    white_balance_kelvin = 5600        # lamps of this temperature come out grey

    [room]                             # or [sky]
    kelvin = 5600                      # or colour = [r, g, b], linear
    intensity = 0.04
    gradient = 0.3                     # a brighter ceiling: radiance is proportional to 1 + gradient * height

    [sky]                              # instead of a room; colours are linear
    zenith = [0.16, 0.27, 0.50]
    horizon = [0.80, 0.48, 0.28]
    ground = [0.13, 0.09, 0.06]
    intensity = 0.56
    haze = 0.5                         # from horizon to zenith colours are mixed by height ** haze

    [sky.glow]                         # the bright haze around a sun; optional
    azimuth_deg = 62
    elevation_deg = 8
    width_deg = 46                     # full width at half its radiance
    kelvin = 2700                      # or colour
    intensity = 1.34                   # times the sky's

    [[area_light]]
    name = "key"
    form = "rectangle"                 # or "disc"
    azimuth_deg = 45                   # 0 from the camera's side, positive from the right of the image
    elevation_deg = 40                 # positive from above
    width_deg = 24
    height_deg = 24                    # not for a disc, which has only its width
    hole_deg = 0                       # width of a disc's dark middle, for a ring light
    softness = 0.4                     # share of the half width over which the edge fades
    kelvin = 5000                      # or colour
    intensity = 1.0
    backdrop = false                   # true: part of the room, such as a lit wall, not a lamp that one would move

Intensities are what an incident-light meter reads: the radiance of a white matte card that faces only this lamp, or
that is surrounded on all sides by the room or by one of the sky's colours. So the ratio of a key to a fill is the
ratio of their intensities.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes
from relight_core.lighting.colour_temperature import COOLEST_KELVIN, HOTTEST_KELVIN, WHITE_KELVIN, kelvin_to_rgb

Colour = tuple[float, float, float]

FORMS = ("rectangle", "disc")
"""Shapes of a lamp."""

_RANGES = {
    "azimuth_deg": (-360.0, 360.0),
    "elevation_deg": (-90.0, 90.0),
    "width_deg": (0.5, 170.0),
    "height_deg": (0.5, 170.0),
    "hole_deg": (0.0, 170.0),
    "softness": (0.0, 1.0),
    "intensity": (0.0, 1e4),
    "gradient": (-1.0, 1.0),
    "haze": (0.05, 4.0),
    "kelvin": (COOLEST_KELVIN, HOTTEST_KELVIN),
    "white_balance_kelvin": (COOLEST_KELVIN, HOTTEST_KELVIN),
}

_MOST_COLOUR = 1e4
WIDEST_HOLE = 0.9
"""As a share of a disc's width, for rigs and soft boxes alike: a thinner ring could fall between all texels."""


@dataclass(frozen=True)
class AreaLight:
    """A lamp with edges; angles as seen from the face, colour linear Rec.709 (times intensity).

    Attributes:
        backdrop: it is part of the room, such as a lit wall, and stays when the lamps are removed.
        kelvin: its colour temperature, if a soft box of that temperature has its colour: it was given in kelvin, and
            the rig's white is that of soft boxes, 5600. Otherwise None.
    """

    azimuth_deg: float
    elevation_deg: float
    width_deg: float
    height_deg: float
    colour: Colour
    intensity: float
    softness: float = 0.2
    hole_deg: float = 0.0
    form: str = "rectangle"
    name: str = ""
    backdrop: bool = False
    kelvin: float | None = None


@dataclass(frozen=True)
class Room:
    """Light from all directions; its radiance is proportional to 1 + gradient * height, with height in [-1, 1]."""

    colour: Colour
    intensity: float
    gradient: float = 0.0


@dataclass(frozen=True)
class Glow:
    """The bright haze around a sun: a Gaussian with a full width at half maximum of `width_deg`."""

    azimuth_deg: float
    elevation_deg: float
    width_deg: float
    colour: Colour
    intensity: float


@dataclass(frozen=True)
class Sky:
    """Sky over ground. From horizon to zenith the colours are mixed by height ** haze."""

    zenith: Colour
    horizon: Colour
    ground: Colour
    intensity: float
    haze: float = 0.5
    glow: Glow | None = None


@dataclass(frozen=True)
class Rig:
    """A whole light set-up."""

    title: str
    description: str
    surround: Room | Sky
    area_lights: tuple[AreaLight, ...]


def read_rig(path: str | Path) -> Rig:
    """Read and check a rig's description.

    Raises:
        InputError: unreadable, not TOML, or a setting is unknown, missing or out of range.
    """
    path = Path(path)
    content = file_bytes(path)
    try:
        tables = tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a readable light rig ({error})") from error
    try:
        return parse_rig(tables)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def parse_rig(tables: dict[str, Any]) -> Rig:
    """Check a description that TOML has turned into tables.

    Raises:
        InputError: naming the table and the setting at fault.
    """
    known = {"title", "description", "white_balance_kelvin", "room", "sky", "area_light"}
    _refuse_unknown(tables, known, "the rig")
    white = _number(tables, "white_balance_kelvin", "the rig", WHITE_KELVIN)
    if ("room" in tables) == ("sky" in tables):
        raise InputError("a rig needs either [room] or [sky]")
    surround = _parse_room(tables["room"], white) if "room" in tables else _parse_sky(tables["sky"], white)
    lights = tables.get("area_light", [])
    if not isinstance(lights, list):
        raise InputError("area lights are written [[area_light]], with two brackets")
    area_lights = tuple(_parse_area_light(light, index, white) for index, light in enumerate(lights, 1))
    title, description = (_text(tables, key, "the rig", "") for key in ("title", "description"))
    return Rig(title, description, surround, area_lights)


def _parse_area_light(table: Any, index: int, white: float) -> AreaLight:
    where = f"area_light {index}"
    _refuse_unknown(table, {f.name for f in fields(AreaLight)}, where)
    form = _text(table, "form", where, "rectangle")
    if form not in FORMS:
        raise InputError(f'{where}: form is "rectangle" or "disc", not "{form}"')
    width = _number(table, "width_deg", where)
    if form == "disc" and "height_deg" in table:
        raise InputError(f"{where}: a disc has a width_deg and no height_deg")
    hole = _number(table, "hole_deg", where, 0.0)
    if hole and (form != "disc" or hole > WIDEST_HOLE * width):
        raise InputError(f"{where}: hole_deg belongs to a disc and is at most {WIDEST_HOLE} of its width_deg")
    return AreaLight(
        azimuth_deg=_number(table, "azimuth_deg", where),
        elevation_deg=_number(table, "elevation_deg", where),
        width_deg=width,
        height_deg=width if form == "disc" else _number(table, "height_deg", where),
        colour=_lamp_colour(table, where, white),
        intensity=_number(table, "intensity", where),
        softness=_number(table, "softness", where, 0.2),
        hole_deg=hole,
        form=form,
        name=_text(table, "name", where, ""),
        backdrop=_flag(table, "backdrop", where),
        kelvin=_number(table, "kelvin", where) if "kelvin" in table and white == WHITE_KELVIN else None,
    )


def _parse_room(table: Any, white: float) -> Room:
    where = "room"
    _refuse_unknown(table, {"colour", "kelvin", "intensity", "gradient"}, where)
    colour = _lamp_colour(table, where, white)
    return Room(colour, _number(table, "intensity", where), _number(table, "gradient", where, 0.0))


def _parse_sky(table: Any, white: float) -> Sky:
    where = "sky"
    _refuse_unknown(table, {f.name for f in fields(Sky)}, where)
    zenith, horizon, ground = (_colour(table, key, where) for key in ("zenith", "horizon", "ground"))
    haze = _number(table, "haze", where, 0.5)
    glow = _parse_glow(table["glow"], white) if "glow" in table else None
    return Sky(zenith, horizon, ground, _number(table, "intensity", where), haze, glow)


def _parse_glow(table: Any, white: float) -> Glow:
    where = "sky.glow"
    _refuse_unknown(table, {f.name for f in fields(Glow)} | {"kelvin"}, where)
    angles = [_number(table, key, where) for key in ("azimuth_deg", "elevation_deg", "width_deg")]
    return Glow(*angles, _lamp_colour(table, where, white), _number(table, "intensity", where))


def _refuse_unknown(table: Any, known: set[str], where: str) -> None:
    if not isinstance(table, dict):
        raise InputError(f"{where} must be a table of settings")
    unknown = sorted(set(table) - known)
    if unknown:
        raise InputError(f"{where}: unknown setting {unknown[0]}; known are {', '.join(sorted(known))}")


def _number(table: dict[str, Any], key: str, where: str, default: float | None = None) -> float:
    value = table.get(key, default)
    if value is None:
        raise InputError(f"{where}: {key} is missing")
    low, high = _RANGES[key]
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise InputError(f"{where}: {key} must be a number from {low:g} to {high:g}, not {value!r}")
    return float(value)


def _text(table: dict[str, Any], key: str, where: str, default: str) -> str:
    value = table.get(key, default)
    if not isinstance(value, str):
        raise InputError(f"{where}: {key} must be text in quotes, not {value!r}")
    return value


def _flag(table: dict[str, Any], key: str, where: str) -> bool:
    value = table.get(key, False)
    if not isinstance(value, bool):
        raise InputError(f"{where}: {key} must be true or false, not {value!r}")
    return value


def _colour(table: dict[str, Any], key: str, where: str) -> Colour:
    value = table.get(key)
    numbers = isinstance(value, list) and len(value) == 3
    if not numbers or not all(type(v) in (int, float) and 0 <= v <= _MOST_COLOUR for v in value):
        raise InputError(f"{where}: {key} must be three linear values from 0 to {_MOST_COLOUR:g}, not {value!r}")
    red, green, blue = (float(v) for v in value)
    return red, green, blue


def _lamp_colour(table: dict[str, Any], where: str, white: float) -> Colour:
    """A lamp's colour, given as `colour` or as `kelvin` under a white balance."""
    if ("colour" in table) == ("kelvin" in table):
        raise InputError(f"{where}: needs either colour or kelvin")
    if "colour" in table:
        return _colour(table, "colour", where)
    red, green, blue = kelvin_to_rgb(_number(table, "kelvin", where), white)
    return float(red), float(green), float(blue)
