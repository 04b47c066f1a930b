"""What can be set about a light and its soft boxes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from imgui_bundle import imgui

from app.ui import light_edits, theme, widgets
from app.ui.panels.groups import Tool, group, tools_beside
from app.ui.panels.panorama import add_next_box
from app.ui.setting_slider import setting_slider
from app.ui.state import EditorState
from relight_core.imaging.colour import srgb_decode, srgb_encode
from relight_core.lighting.light_edit import LIGHT_EDIT_RANGES, LightEdit
from relight_core.lighting.soft_box import SOFT_BOX_RANGES, SoftBox, box_title
from relight_core.lighting.summary import metered_level_ev

_AT_REST = SoftBox()
"""What a double click brings the sliders of a soft box back to that was added."""

_box_slider = partial(setting_slider, SOFT_BOX_RANGES, _AT_REST)
_light_slider = partial(setting_slider, LIGHT_EDIT_RANGES, LightEdit())

BOX = {
    "intensity": widgets.Slider(
        "Brightness",
        0.0,
        4.0,
        _AT_REST.intensity,
        "%.2f ×",
        "How strong this lamp is; 1 is as strong as the light's brightest side.",
    ),
    "softness": _box_slider("softness", "Soft edge", "%.2f", "0 has a crisp edge, 1 fades from the middle out."),
    "kelvin": widgets.Slider(
        "Colour", 2000.0, 12000.0, _AT_REST.kelvin, "%.0f K", "From candle to blue sky; 5600 is daylight."
    ),
}
LIGHT = {
    "level_ev": widgets.Slider("Level", -4.0, 4.0, 0.0, "%+.2f EV", "Brightens or dims the whole light, in stops."),
    "base": _light_slider(
        "base", "Room", "%.2f", "How much of the light stays besides your soft boxes; 0 leaves only them."
    ),
    "saturation": _light_slider("saturation", "Saturation", "%.2f", "How colourful the light is; 0 is grey."),
    "warmth": _light_slider("warmth", "Warmth", "%+.2f", "Left is cool and blue, right is warm like a bulb."),
    "tint": _light_slider("tint", "Tint", "%+.2f", "Left is greenish, right is pinkish."),
    "blur_deg": widgets.Slider(
        "Blur", 0.0, 60.0, 0.0, "%.0f°", "Spreads the light as a diffuser does: softer shadows, wider highlights."
    ),
}
SHAPES = (
    ("rectangle", "Square", "A soft box, a window, a strip."),
    ("disc", "Round", "A beauty dish, an umbrella, a bulb, a ring light."),
)
HOLE = _box_slider("hole", "Hole", "%.2f", "How much of it is dark in the middle, as of a ring light.")
GEL, GEL_WORDS = "Coloured gel", "A coloured gel in front of this lamp."
RESET_WORDS = "Puts level, colour and blur of the light back."
_SPACING = 4.0
_ADD, _LAMPS, _REMOVE, _METERED = "+  Soft box", "Its lamps", "Remove all", "Metered"
_AS_PHOTO = "The level at which the lit part of the face is as bright as in the photo.  Shift + A"
_ON_THE_FACE = "On the face"
_AIMS = (
    ("highlight", "Highlight", "Then click on the face where the shine should be; drag to fine-tune.  K"),
    ("bright", "Bright side", "Then click on the face where it should be brightest; drag to fine-tune.  B"),
)


def tools(state: EditorState) -> None:
    """Adding a soft box, on the panorama or by the face."""
    with widgets.narrow_buttons():
        _lamp_tools(state)
        _aim_tools(state)


def _aim_tools(state: EditorState) -> None:
    """What places a lamp by a click on the face: in a row, or one below the other."""
    imgui.begin_disabled(state.snapshot.picture is None)
    buttons = sum(_width_of(label) for _, label, _ in _AIMS)
    if buttons + imgui.calc_text_size(_ON_THE_FACE).x + _SPACING < imgui.get_content_region_avail().x:
        imgui.align_text_to_frame_padding()
        imgui.text_disabled(_ON_THE_FACE)
        imgui.same_line()
    room = imgui.get_content_region_avail().x
    in_a_row, width = widgets.fit_in_row([label for _, label, _ in _AIMS], room, _SPACING)
    for index, (aim, label, tooltip) in enumerate(_AIMS):
        if index and in_a_row:
            imgui.same_line(0.0, _SPACING)
        if widgets.toggle(label, state.aim.target == aim, width):
            light_edits.switch_aim(state, aim)
        imgui.set_item_tooltip(("Moves the selected soft box. " if state.selected_box >= 0 else "") + tooltip)
    imgui.end_disabled()


def _width_of(label: str) -> float:
    """How wide a button has to be."""
    return imgui.calc_text_size(label).x + imgui.get_font_size()


def _lamp_tools(state: EditorState) -> None:
    """What adds lamps, moves those of the light itself, and takes all of them away: in a row, or in several."""
    has = {_LAMPS: light_edits.has_lamps(state), _REMOVE: bool(state.light_edit.boxes)}
    words = [word for word, is_there in has.items() if is_there]
    room = imgui.get_content_region_avail().x
    widths = [_width_of(word) for word in (_ADD, *words)]
    in_a_row = sum(widths) + _SPACING * len(words) <= room
    beside = True
    if in_a_row:
        widths[0] = room - sum(widths[1:]) - _SPACING * len(words)
    else:
        beside, width = widgets.fit_in_row(words, room, _SPACING)
        widths = [room] + [width] * len(words)
    if imgui.button(_ADD, imgui.ImVec2(widths[0], 0.0)):
        add_next_box(state)
    imgui.set_item_tooltip("Add a lamp. Drag it on the panorama; its corners resize it.  N")
    for index, (word, width) in enumerate(zip(words, widths[1:], strict=True)):
        if in_a_row or (beside and index):
            imgui.same_line(0.0, _SPACING)
        if word == _LAMPS:
            if widgets.toggle(word, state.light_edit.apart, width):
                light_edits.switch_lamps(state)
            imgui.set_item_tooltip(_lamp_words(state))
        else:
            if imgui.button(word, imgui.ImVec2(width, 0.0)):
                light_edits.delete_boxes(state)
            imgui.set_item_tooltip("Leaves the light without soft boxes.  Shift + Delete")


def _lamp_words(state: EditorState) -> str:
    title = state.light.title
    if state.light_edit.apart:
        return f"The lamps of {title} are soft boxes. Click to put them back as they were.  M"
    return f"Makes the lamps of {title} soft boxes: move, resize, dim and colour them.  M"


def box(state: EditorState, fonts: theme.Fonts) -> None:
    """The selected soft box."""
    index, boxes = state.selected_box, state.light_edit.boxes
    if not light_edits.has_box(state):
        return
    widgets.gap(0.2)
    left = imgui.get_cursor_screen_pos()
    width = imgui.get_content_region_avail().x
    imgui.align_text_to_frame_padding()
    delete, switch = _width_of("Delete"), _width_of("Off")
    tools = delete + _SPACING + switch
    widgets.heading(fonts, widgets.shortened(box_title(boxes, index), width - tools - imgui.get_font_size()))
    imgui.same_line()
    imgui.set_cursor_screen_pos(imgui.ImVec2(left.x + width - tools, left.y))
    if widgets.toggle("Off", boxes[index].off, switch):
        light_edits.switch_box(state)
        return
    imgui.set_item_tooltip("Switch this lamp off, to see what it does; again switches it on.  Shift + M")
    imgui.same_line(0.0, _SPACING)
    if imgui.button("Delete", imgui.ImVec2(delete, 0.0)):
        light_edits.delete_box(state)
        return
    imgui.set_item_tooltip("Take this lamp away.  Delete")
    changed = {field: _lamp_slider(state, spec, field, boxes[index]) for field, spec in BOX.items()}
    if changed["kelvin"] != boxes[index].kelvin:
        changed["colour"] = None
    new = _shaped(state, replace(boxes[index], **changed))
    new = replace(new, colour=_gel(state, new.colour))
    if new != boxes[index]:
        light_edits.put_box(state, index, new)


def _lamp_slider(state: EditorState, spec: widgets.Slider, field: str, lamp: SoftBox) -> float:
    """A slider of a lamp, at rest where the lamp came; the field's value then."""
    at_rest = getattr(light_edits.as_it_came(state, lamp), field)
    return widgets.slider(state, replace(spec, rest=at_rest), getattr(lamp, field))


def _shaped(state: EditorState, lamp: SoftBox) -> SoftBox:
    """Square, round, or a ring."""
    lamp = of_form(lamp, widgets.segmented(SHAPES, lamp.form))
    return replace(lamp, hole=_lamp_slider(state, HOLE, "hole", lamp)) if lamp.is_round else lamp


def of_form(lamp: SoftBox, form: str) -> SoftBox:
    """A lamp as one of SHAPES; of the same area and irradiance whichever."""
    if form == lamp.form:
        return lamp
    side = math.sqrt(lamp.width_deg * lamp.height_deg)
    return replace(lamp, form=form, width_deg=side, height_deg=side)


def light(state: EditorState, fonts: theme.Fonts) -> None:
    """The whole light."""
    edited = light_edits.is_adjusted(state)
    back = Tool("Reset", RESET_WORDS, edited)
    summary = "changed" if edited else "metered" if state.light_edit.metered else ""
    opened, pressed = group(state, fonts, "adjust", "Adjust the light", summary, (back,))
    if pressed:
        light_edits.reset_adjustments(state)
    if not opened:
        return
    _level_tools(state)
    sliders = sliders_of_light(state).items()
    changed = {field: widgets.slider(state, spec, getattr(state.light_edit, field)) for field, spec in sliders}
    state.light_edit = replace(state.light_edit, **changed)
    widgets.gap(0.2)


def sliders_of_light(state: EditorState) -> dict[str, widgets.Slider]:
    """Those of the whole light, by the field each sets; *Room* only where there is something beside it."""
    has_room = bool(state.light_edit.boxes) or state.light_edit.base != 1.0
    return {field: spec for field, spec in LIGHT.items() if field != "base" or has_room}


def _level_tools(state: EditorState) -> None:
    """What sets the level by itself: the face in the photo, and for a panorama a meter."""
    level = LIGHT["level_ev"].label
    if state.typing == level:
        return
    as_photo = Tool("As photo", _AS_PHOTO, enabled=state.snapshot.picture is not None)
    tools = [(as_photo, False)]
    if state.light.kind == "panorama":
        tools.insert(0, (Tool(_METERED, _meter_words(state)), state.light_edit.metered))
    clicked = tools_beside(level, *tools)
    if clicked == _METERED:
        light_edits.meter_light(state)
    elif clicked == as_photo.label:
        state.asking.wish("match_face")


def _meter_words(state: EditorState) -> str:
    light = state.snapshot.light
    is_there = light is not None and light.source.same_as(state.light)
    stops = f" ({metered_level_ev(light.base):+.1f} EV)".replace("-", "\N{MINUS SIGN}") if is_there else ""
    if state.light_edit.metered:
        return (
            f"The panorama is as bright as the bundled lights{stops}, whatever units its file is in.\n"
            "Click for the level that the file gives.  A"
        )
    return f"The panorama is as bright as its file says. Click to make it as bright as the bundled lights{stops}.  A"


def _gel(state: EditorState, colour: tuple[float, float, float] | None) -> tuple[float, float, float] | None:
    """The choice of a coloured gel instead of a temperature, linear Rec.709; None for no gel."""
    shown = gel_on_screen(colour or (1.0, 1.0, 1.0))
    if state.typing == GEL:
        typed = widgets.typed_colour(state, shown)
        return colour if typed is None else gel_from_screen(typed)
    picked = widgets.swatch(state, GEL, shown, GEL_WORDS)
    imgui.same_line()
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(GEL if colour is None else "Gel")
    if colour is not None:
        imgui.same_line()
        if imgui.small_button("Remove"):
            return None
    return colour if picked is None else gel_from_screen(picked)


def gel_on_screen(colour: Sequence[float]) -> tuple[float, ...]:
    """A lamp's colour, linear Rec.709, as sRGB in [0, 1]; one that is too bright for a screen is dimmed to fit."""
    return tuple(map(float, srgb_encode(np.array(colour) / max(1.0, *colour))))


def gel_from_screen(picked: Sequence[float]) -> tuple[float, ...]:
    """The lamp's colour that white things under it have on a screen, from sRGB in [0, 1] to linear Rec.709."""
    return tuple(map(float, srgb_decode(picked)))
