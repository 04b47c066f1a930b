"""The panels' settings as commands, for the palette alone: with it the keyboard reaches all that has no key."""

from __future__ import annotations

from dataclasses import replace

from app.ui import face_edits, widgets
from app.ui.actions.action import Action, has_photo, has_picture
from app.ui.export_name import choose_form
from app.ui.panels import effects_panel, export_panel, light_panel, quality_panel
from app.ui.state import EditorState

_EFFECTS = (
    effects_panel.SHADOW,
    effects_panel.SOFTNESS,
    effects_panel.SPECULAR,
    effects_panel.TINT,
    effects_panel.EXPOSURE,
)


def setting_actions(state: EditorState) -> tuple[Action, ...]:
    """One for each slider, to type its number, and one for each choice, in the order of the panels."""
    return (
        _type(light_panel.ROTATION, "light"),
        *(_type(slider, "effects") for slider in _EFFECTS),
        *(_background(*choice) for choice in effects_panel.BACKGROUNDS),
        *_faces(state),
        *(_quality(*choice) for choice in quality_panel.TIERS),
        *(_form(*choice) for choice in export_panel.FORMS),
        Action(
            "Export a turntable as PNGs",
            "File",
            (),
            "The light turning once around, as numbered files in a new folder",
            lambda state: state.asking.wish("turntable_pictures"),
            available=has_picture,
        ),
    )


def _type(slider: widgets.Slider, panel: str) -> Action:
    def run(state: EditorState) -> None:
        state.panels = replace(state.panels, **{panel: True})
        if panel == "effects":
            state.groups = replace(state.groups, effects=True)
        widgets.begin_typing(state, slider)

    return Action(f"Set {slider.label.lower()}", "Light and effects", (), _sentence(slider.help), run)


def _background(value: str, label: str, words: str) -> Action:
    return Action(
        f"Background: {label}",
        "Light and effects",
        (),
        _sentence(words),
        lambda state: state.change(background=value),
        is_on=lambda state: state.edit.background == value,
    )


def _faces(state: EditorState) -> tuple[Action, ...]:
    """Who is relit, where that is a choice."""
    count = len(state.snapshot.faces)
    if count < 2:
        return ()
    return (_face("all", None), *(_face(str(index + 1), index) for index in range(count)))


def _face(words: str, index: int | None) -> Action:
    return Action(
        f"Faces: {words}",
        "Faces",
        (),
        "Relight everyone" if index is None else "Relight this person alone",
        lambda state: state.choose_face(index),
        available=has_photo,
        is_on=lambda state: has_photo(state) and face_edits.wished_face(state) == index,
    )


def _quality(wish: str, label: str, words: str) -> Action:
    def run(state: EditorState) -> None:
        state.quality = replace(state.quality, wish=wish)

    return Action(
        f"Quality: {label}", "Quality", (), _sentence(words), run, is_on=lambda state: state.quality.wish == wish
    )


def _form(form: str, label: str, words: str) -> Action:
    return Action(
        f"Export kind: {label}",
        "File",
        (),
        _sentence(words),
        lambda state: choose_form(state, form),
        available=has_picture,
        is_on=lambda state: state.export.form == form,
    )


def _sentence(words: str) -> str:
    """A tooltip as the palette tells it: in one line, without the full stop."""
    return " ".join(words.split()).rstrip(".")
