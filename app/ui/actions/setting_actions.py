"""The panels' settings as commands, for the palette alone: with it the keyboard reaches all that has no key."""

from __future__ import annotations

from dataclasses import replace

from app.ui import face_edits, light_edits, widgets
from app.ui.actions.action import Action, has_photo, sentence
from app.ui.actions.export_actions import export_actions
from app.ui.panels import effects_panel, light_controls, light_panel, quality_panel
from app.ui.panels.groups import type_in
from app.ui.state import EditorState
from relight_core.lighting.soft_box import box_title

_LIGHT = "Light and effects"
_EFFECTS = (
    effects_panel.SHADOW,
    effects_panel.SOFTNESS,
    effects_panel.SPECULAR,
    effects_panel.TINT,
    effects_panel.STRENGTH,
    effects_panel.EXPOSURE,
)
_AS_HEX = ", typed like #30343a"
_GEL_WORDS = f"{sentence(light_controls.GEL_WORDS)}{_AS_HEX}"
_COLOUR_WORDS = f"A plain colour behind the person{_AS_HEX}"
_RESET_LIGHT = Action(
    "Reset the adjusted light",
    _LIGHT,
    (),
    sentence(light_controls.RESET_WORDS),
    light_edits.reset_adjustments,
    available=light_edits.is_adjusted,
)
_REMOVE_GEL = Action(
    "Remove the soft box's coloured gel",
    _LIGHT,
    (),
    "Gives the lamp its colour from candle to blue sky back",
    light_edits.remove_gel,
    available=light_edits.has_gel,
)


def setting_actions(state: EditorState) -> tuple[Action, ...]:
    """One for each slider and colour, to type it, and one for each choice, in the order of the panels."""
    return (
        _type(light_panel.ROTATION, "light"),
        *_lamps(state),
        *(
            _type(slider, "light", "adjust", f"Set the light's {slider.label.lower()}")
            for slider in light_controls.sliders_of_light(state).values()
        ),
        _RESET_LIGHT,
        *(_type(slider, "effects", "effects") for slider in _EFFECTS),
        *(_background(*choice) for choice in effects_panel.BACKGROUNDS),
        _type_at("Set the background's colour", effects_panel.COLOUR, _COLOUR_WORDS, "effects", "background"),
        *_light_behind(state),
        *_faces(state),
        *(_quality(*choice) for choice in quality_panel.TIERS),
        *export_actions(state),
    )


def _type(slider: widgets.Slider, panel: str, group: str | None = None, name: str = "") -> Action:
    """Lets a slider's number be typed."""
    return _type_at(name or f"Set {slider.label.lower()}", slider.label, slider.help, panel, group)


def _type_at(name: str, label: str, words: str, panel: str, group: str | None = None) -> Action:
    return Action(name, _LIGHT, (), sentence(words), lambda state: type_in(state, label, panel, group))


def _lamps(state: EditorState) -> tuple[Action, ...]:
    """Which soft box is chosen, and what can be set about that one."""
    boxes = state.light_edit.boxes
    choices = tuple(_choose_box(index, box_title(boxes, index)) for index in range(len(boxes)))
    if not light_edits.has_box(state):
        return choices
    sliders = [*light_controls.BOX.values()]
    if boxes[state.selected_box].is_round:
        sliders.append(light_controls.HOLE)
    typed = (_type(slider, "light", name=f"Set the soft box's {slider.label.lower()}") for slider in sliders)
    gel = _type_at("Set the soft box's coloured gel", light_controls.GEL, _GEL_WORDS, "light")
    return (*choices, *typed, *(_shape(*choice) for choice in light_controls.SHAPES), gel, _REMOVE_GEL)


def _choose_box(index: int, title: str) -> Action:
    def run(state: EditorState) -> None:
        state.selected_box = index

    return Action(
        f"Choose the lamp: {title}",
        _LIGHT,
        (),
        "The soft box that keys and sliders are about from now on",
        run,
        is_on=lambda state: state.selected_box == index,
    )


def _shape(form: str, label: str, words: str) -> Action:
    def run(state: EditorState) -> None:
        index = state.selected_box
        light_edits.put_box(state, index, light_controls.of_form(state.light_edit.boxes[index], form))

    return Action(
        f"Shape of the soft box: {label}",
        _LIGHT,
        (),
        sentence(words),
        run,
        is_on=lambda state: state.light_edit.boxes[state.selected_box].form == form,
    )


def _background(value: str, label: str, words: str) -> Action:
    return Action(
        f"Background: {label}",
        _LIGHT,
        (),
        sentence(words),
        lambda state: state.change(background=value),
        is_on=lambda state: state.edit.background == value,
    )


def _light_behind(state: EditorState) -> tuple[Action, ...]:
    """If the light is the background: how blurred it is, and how much of it is seen."""
    if state.edit.background != "light":
        return ()
    sliders = effects_panel.BACKGROUND_BLUR, effects_panel.BACKGROUND_WIDTH
    return tuple(_type(slider, "effects", "background") for slider in sliders)


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
        f"Quality: {label}", "Quality", (), sentence(words), run, is_on=lambda state: state.quality.wish == wish
    )
