"""How files are made as commands, for the palette alone: their kind, size, name and layers, and what has no key."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from app.engine.exporting import SIDES
from app.ui.actions.action import Action, has_picture, sentence
from app.ui.export_name import choose_form
from app.ui.panels import export_panel
from app.ui.panels.groups import type_in
from app.ui.state import EditorState
from relight_core.pipeline.results.layers import LAYERS

_FILE = "File"


def export_actions(state: EditorState) -> tuple[Action, ...]:
    """One for each choice of the export panel that the chosen kind of file has, in its order."""
    form = state.export.form
    return (
        *(_form(*choice) for choice in export_panel.FORM_CHOICES),
        *(_depth(*choice) for choice in export_panel.depths(form)),
        *([_type("Set the JPEG's quality", export_panel.QUALITY, "From 50 to 100")] if form == ".jpg" else []),
        *(_size(side) for side in SIDES),
        *(_profile(*choice) for choice in export_panel.PROFILE_CHOICES if export_panel.has_choice_of_profile(state)),
        _type("Name the export", export_panel.NAME, "Type the name of the file, or its whole path"),
        *(_layer(name) for name in LAYERS if form == ".exr"),
        _choice(
            "Export a turntable as PNGs",
            "The light turning once around, as numbered files in a new folder",
            lambda state: state.asking.wish("turntable_pictures"),
        ),
    )


def _choice(
    name: str, words: str, run: Callable[[EditorState], None], is_on: Callable[[EditorState], bool] | None = None
) -> Action:
    return Action(name, _FILE, (), sentence(words), run, available=has_picture, is_on=is_on)


def _form(form: str, label: str, words: str) -> Action:
    return _choice(
        f"Export kind: {label}",
        words,
        lambda state: choose_form(state, form),
        lambda state: state.export.form == form,
    )


def _depth(value: str, label: str, words: str) -> Action:
    is_deep = value == "deep"

    def run(state: EditorState) -> None:
        state.export = replace(state.export, deep=is_deep)

    return _choice(f"Export depth: {label}", words, run, lambda state: state.export.deep == is_deep)


def _size(side: int | None) -> Action:
    def run(state: EditorState) -> None:
        state.export = replace(state.export, longest_side=side)

    words = "As large as the photo" if side is None else "So many pixels along the longer side, or as the photo has"
    name = f"Export size: {export_panel.size_words(side)}"
    return _choice(name, words, run, lambda state: state.export.longest_side == side)


def _profile(profile: str, label: str, words: str) -> Action:
    def run(state: EditorState) -> None:
        state.export = replace(state.export, profile=profile)

    return _choice(f"Export colours: {label}", words, run, lambda state: state.export.profile == profile)


def _layer(name: str) -> Action:
    def run(state: EditorState) -> None:
        state.export = export_panel.with_layer(state.export, name, name not in state.export.layers)

    words = f"{export_panel.LAYER_WORDS[name]}, beside the picture or not"
    return _choice(
        f"EXR layer: {export_panel.layer_title(name)}", words, run, lambda state: name in state.export.layers
    )


def _type(name: str, label: str, words: str) -> Action:
    return _choice(name, words, lambda state: type_in(state, label, "effects", "export"))
