"""The parser, and the arguments that several subcommands share."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from relight_core.errors import InputError
from relight_core.pipeline.edit import BACKGROUNDS, EDIT_RANGES, EFFECTS, TOLERANCE, Edit, is_plain_colour

EXPOSURE_LIMIT_EV = 16.0
_NEGATIVE_FIRST = re.compile(r"-[\d.]")
_NEGATIVE_POWER = re.compile(r"-[\d.]+[eE][-+]?\d+")
_LISTS_OF_NUMBERS = ("--box", "--add-box")


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose complaint is one line, raised as InputError.

    Args:
        takes_several: options may also stand between the photos; not for a parser with subcommands.
    """

    def __init__(self, *, takes_several: bool = False, **settings) -> None:
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False, **settings)
        self._takes_several = takes_several

    def parse_args(self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None):
        """As argparse does, but for what it takes for an option: a list of numbers of which the first is negative, and
        a negative number as programs write it, -1e-05."""
        words = []
        for word in sys.argv[1:] if args is None else args:
            if words and _is_value(word, words[-1]):
                words[-1] += f"={word}"
            else:
                words.append(word)
        # Where argparse looks for options between photos, it forgets that there are none behind "--", and of
        # everything that is missing it names the options first.
        if self._takes_several and words and "--" not in words:
            return super().parse_intermixed_args(words, namespace)
        return super().parse_args(words, namespace)

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message} ({self.prog} --help tells the usage)")


def add_light(parser: argparse.ArgumentParser, *, required: bool) -> None:
    """--light, in the forms that app.cli.session.Session.light understands."""
    parser.add_argument(
        "--light",
        metavar="L",
        type=user_name,
        required=required,
        help="a bundled rig's name (see relight rigs), an .hdr or .exr map, a portrait to borrow from, or a light or "
        "session (.json) saved in the editor",
    )


def user_name(text: str) -> str:
    """What users name, mostly a file; a leading ~ is the home folder, also where no shell has seen to that.

    No name at all, as of a shell's variable that is not set, would mean the current folder with all photos in it.
    """
    if not text:
        raise argparse.ArgumentTypeError("an empty name, as of a variable that is not set; give one")
    return os.path.expanduser(text)


def user_path(text: str) -> Path:
    """A file or folder, as of `user_name`."""
    return Path(user_name(text))


def add_one_photo(
    parser: argparse.ArgumentParser, metavar: str, output_help: str, *, makes_pictures: bool = True
) -> None:
    """What the commands take that relight one photo: PHOTO, light, sliders, -o and --json; see `add_sliders`."""
    parser.add_argument("photo", metavar="PHOTO", type=user_path, help="a portrait photo")
    add_light(parser, required=True)
    add_sliders(parser, makes_pictures=makes_pictures)
    parser.add_argument("-o", "--output", metavar=metavar, type=user_path, required=True, help=output_help)
    add_json(parser)


def add_sliders(parser: argparse.ArgumentParser, *, makes_pictures: bool = True) -> None:
    """--meter, the settings of an Edit, and the face.

    Args:
        makes_pictures: False leaves out what only changes the finished picture: strength, exposure and background.
    """
    parser.add_argument(
        "--meter",
        action="store_true",
        help="let a panorama's brightest side light a face as the bundled rigs do, whatever units its file is in; "
        "other lights stay as they are",
    )
    parser.add_argument(
        "--yaw",
        metavar="DEG",
        type=_finite,
        default=0.0,
        help="turn the light; positive moves the panorama to the right, and a lamp in front of the person to the left",
    )
    if makes_pictures:
        _add_settings_of_the_picture(parser)
    else:
        rest = Edit()
        parser.set_defaults(
            strength=rest.strength,
            exposure=rest.exposure_ev,
            background=rest.background,
            background_fov=rest.background_fov_deg,
            background_blur=rest.background_blur_deg,
        )
    parser.add_argument("--specular", metavar="S", type=_gain, default=1.0, help="gain on highlights, 0 to 2")
    parser.add_argument("--shadow", metavar="S", type=_gain, default=1.0, help="gain on shadows, 0 to 2")
    parser.add_argument(
        "--specular-tint", metavar="T", type=_tint, default=0.0, help="colour of highlights, -1 cool to 1 warm"
    )
    parser.add_argument(
        "--shadow-softness", metavar="S", type=_share, default=0.0, help="softer edges of shadows, 0 to 1"
    )
    _add_effort(parser)
    add_face(parser)


def _add_settings_of_the_picture(parser: argparse.ArgumentParser) -> None:
    """Strength, exposure and background, on which no channel depends."""
    parser.add_argument(
        "--strength",
        metavar="S",
        type=_share,
        default=1.0,
        help="how far the new light takes the photo's place on the person: 0 leaves the photo's own, 0.5 mixes both",
    )
    parser.add_argument("--exposure", metavar="EV", type=_exposure, default=0.0, help="brighten by stops, -16 to 16")
    parser.add_argument(
        "--background",
        metavar="B",
        type=_background,
        default="keep",
        help="keep, match (kept, but dimmed and tinted as the person is), light, transparent or #rrggbb",
    )
    parser.add_argument(
        "--background-fov",
        metavar="DEG",
        type=_field_of_view,
        default=50.0,
        help="how wide the camera sees the light behind, up to 170; 50 by default",
    )
    parser.add_argument(
        "--background-blur",
        metavar="DEG",
        type=_blur,
        default=1.0,
        help="blur of the light behind, 0 to 20; 1 by default",
    )


def _add_effort(parser: argparse.ArgumentParser) -> None:
    """What is computed at all, and how well."""
    parser.add_argument(
        "--quality",
        choices=("draft", "live", "final"),
        default="final",
        help="no network per light, narrow networks, or wide ones (final, the default)",
    )
    parser.add_argument(
        "--force",
        metavar="EFFECT=on|off",
        type=_forced,
        action="append",
        default=[],
        help=f"compute an effect whatever the plan says, or leave it out; may be repeated: {', '.join(EFFECTS)}",
    )
    parser.add_argument(
        "--tolerance",
        metavar="T",
        type=_tolerance,
        default=255 * TOLERANCE,
        help="how much the plan may change the picture by leaving something out, in 255ths; 1 by default",
    )


def add_face(parser: argparse.ArgumentParser) -> None:
    """--face, --box and --add-box, for photos of several people and for faces that are not found."""
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--face", metavar="N", type=_index, default=None, help="only this face, 0 being the largest; all without it"
    )
    which.add_argument(
        "--box",
        metavar="X0,Y0,X1,Y1",
        type=_box,
        action="append",
        default=[],
        help="only the face that is here, found or not: pixels of the photo, brow to chin and cheek to cheek; may be "
        "repeated",
    )
    parser.add_argument(
        "--add-box",
        metavar="X0,Y0,X1,Y1",
        type=_box,
        action="append",
        default=[],
        help="a face that isn't found, beside those that are, and counted after them; may be repeated",
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """--json, for programs that read us."""
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else on stdout")


def edit_from(arguments: argparse.Namespace) -> Edit:
    """The Edit that the sliders' arguments describe; of several wishes about one effect the last one counts."""
    forced = dict(arguments.force)
    return Edit(
        yaw_deg=arguments.yaw,
        exposure_ev=arguments.exposure,
        specular=arguments.specular,
        shadow=arguments.shadow,
        specular_tint=arguments.specular_tint,
        shadow_softness=arguments.shadow_softness,
        strength=arguments.strength,
        background=arguments.background,
        background_fov_deg=arguments.background_fov,
        background_blur_deg=arguments.background_blur,
        quality=arguments.quality,
        forced_on=frozenset(name for name, on in forced.items() if on),
        forced_off=frozenset(name for name, on in forced.items() if not on),
        tolerance=arguments.tolerance / 255,
    )


def _is_value(word: str, option: str) -> bool:
    """Whether a word is what an option before it is set to, although argparse would take it for an option."""
    if option in _LISTS_OF_NUMBERS:
        return _NEGATIVE_FIRST.match(word) is not None
    return option.startswith("--") and option != "--" and _NEGATIVE_POWER.fullmatch(word) is not None


def _finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def _within(text: str, low: float, high: float) -> float:
    value = _finite(text)
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f"{text} lies outside {low:g} to {high:g}")
    return value


def _tint(text: str) -> float:
    return _within(text, *EDIT_RANGES["specular_tint"])


def _share(text: str) -> float:
    return _within(text, 0.0, 1.0)


def _exposure(text: str) -> float:
    return _within(text, -EXPOSURE_LIMIT_EV, EXPOSURE_LIMIT_EV)


def _gain(text: str) -> float:
    return _within(text, *EDIT_RANGES["specular"])


def _field_of_view(text: str) -> float:
    narrowest, widest = EDIT_RANGES["background_fov_deg"]
    degrees = _within(text, narrowest, widest)
    if degrees == 0.0:
        raise argparse.ArgumentTypeError(f"{text} degrees see nothing; the field of view is up to {widest:g}")
    return degrees


def _blur(text: str) -> float:
    return _within(text, *EDIT_RANGES["background_blur_deg"])


def _tolerance(text: str) -> float:
    return _within(text, 0.0, 255.0)


def _forced(text: str) -> tuple[str, bool]:
    name, _, wish = text.partition("=")
    if name not in EFFECTS or wish not in ("on", "off"):
        raise argparse.ArgumentTypeError(f"{text!r} is not one of {', '.join(EFFECTS)} followed by =on or =off")
    return name, wish == "on"


def _index(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is not a face's number; the largest is 0")
    return int(text)


def _box(text: str) -> tuple[float, ...]:
    box = tuple(_finite(part) for part in text.split(","))
    if len(box) != 4:
        raise argparse.ArgumentTypeError(f"{text!r} is no box; it is four numbers: left,top,right,bottom")
    return box


def _background(text: str) -> str:
    if text in BACKGROUNDS:
        return text
    if is_plain_colour(text):
        return text.lower()
    raise argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(BACKGROUNDS)}, #rrggbb")
