"""The effects panel: the queue, sliders, background, and faces; then quality, export and history."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from imgui_bundle import imgui

from app.document.session_file import NARROWEST_BACKGROUND_DEG
from app.ui import brush_edits, face_edits, theme, widgets
from app.ui.panels import export_panel, history_panel, quality_panel
from app.ui.panels.groups import SPACING_EM, Tool, group, tool_button, tool_width
from app.ui.setting_slider import setting_slider
from app.ui.state import EditorState
from relight_core.pipeline.edit import EDIT_RANGES, Edit

_AT_REST = Edit()
_slider = partial(setting_slider, EDIT_RANGES, _AT_REST)
SHADOW = _slider("shadow", "Shadow", "%.2f", "Deepens or lifts the shadows the light casts; 0 removes them.")
SPECULAR = _slider("specular", "Specular", "%.2f", "Strengthens or mattes the shine on the skin; 0 removes it.")
SOFTNESS = _slider(
    "shadow_softness",
    "Shadow softness",
    "%.2f",
    "Softens the edges of the shadows, as a larger lamp would; 0 leaves them.",
)
TINT = _slider(
    "specular_tint", "Specular tint", "%+.2f", "Colour of the shine: left is cool, right is warm; 0 is the light's own."
)
STRENGTH = _slider(
    "strength", "Strength", "%.2f", "Mixes the new light with the photo's own; 0 leaves the person as photographed."
)
EXPOSURE = widgets.Slider("Exposure", -5.0, 5.0, 0.0, "%+.2f EV", "Brightens or darkens the whole picture, in stops.")
BACKGROUNDS = (
    ("keep", "Photo", "Keep the photo's own background."),
    ("match", "Match", "Keep it, as bright and as tinted as the new light makes the person."),
    ("light", "Light", "Show what the light looks like behind the person."),
    ("transparent", "None", "Cut the person out: a transparent background."),
)
BACKGROUND_BLUR = _slider(
    "background_blur_deg", "Background blur", "%.1f°", "How far out of focus the light behind the person is."
)
BACKGROUND_WIDTH = widgets.Slider(
    "Background width",
    NARROWEST_BACKGROUND_DEG,
    EDIT_RANGES["background_fov_deg"][1],
    _AT_REST.background_fov_deg,
    "%.0f°",
    "How much of the light is seen behind the person; less enlarges it.",
)
COLOUR = "Background colour"
_FACES_IN_ROW = 7
"""The choice of everyone among them."""


def draw(state: EditorState, fonts: theme.Fonts) -> None:
    """The panel's contents, inside its window."""
    _queue(state)
    _effects(state, fonts)
    _backgrounds(state, fonts)
    _faces(state, fonts)
    quality_panel.draw(state, fonts)
    export_panel.draw(state, fonts)
    history_panel.draw(state, fonts)


def _queue(state: EditorState) -> None:
    """Which of the photos that were brought together is open, and the way to the others."""
    if len(state.queue.paths) < 2:
        return
    em = imgui.get_font_size()
    for label, by, tooltip in (("‹", -1, "The photo before.  Page up"), ("›", 1, "The next photo.  Page down")):
        imgui.begin_disabled(state.queue.step(by) is None)
        if imgui.button(label, imgui.ImVec2(2.0 * em, 0.0)):
            state.step_photo(by)
        imgui.end_disabled()
        imgui.set_item_tooltip(tooltip)
        imgui.same_line(0.0, 4.0)
    imgui.align_text_to_frame_padding()
    words = f"Photo {state.queue.label}"
    has_room = imgui.calc_text_size(words).x <= imgui.get_content_region_avail().x
    imgui.text_disabled(words if has_room else state.queue.label)
    widgets.gap(0.4)


def _effects(state: EditorState, fonts: theme.Fonts) -> None:
    untouched = state.edit == Edit(quality=state.edit.quality) and state.light_edit == state.light.opening_edit
    reset = Tool("Reset all", "Puts every slider and the light back.  Ctrl + R", not untouched)
    is_open, pressed = group(state, fonts, "effects", "Effects", tools=(reset,))
    if pressed:
        state.reset()
    if not is_open:
        return
    edit = state.edit
    state.change(
        shadow=widgets.slider(state, SHADOW, edit.shadow),
        shadow_softness=widgets.slider(state, SOFTNESS, edit.shadow_softness),
        specular=widgets.slider(state, SPECULAR, edit.specular),
        specular_tint=widgets.slider(state, TINT, edit.specular_tint),
        strength=widgets.slider(state, STRENGTH, edit.strength),
        exposure_ev=widgets.slider(state, EXPOSURE, edit.exposure_ev),
    )


def _backgrounds(state: EditorState, fonts: theme.Fonts) -> None:
    background = state.edit.background
    words = next((label for value, label, _ in BACKGROUNDS if value == background), background)
    if not group(state, fonts, "background", "Background", words)[0]:
        return
    if state.typing == COLOUR:
        _take_colour(state, widgets.typed_colour(state, _plain_colour(background)))
        return
    swatch = imgui.get_frame_height()
    spacing = 2.0
    width = imgui.get_content_region_avail().x - swatch - spacing
    state.change(background=widgets.segmented(BACKGROUNDS, background, width))
    imgui.same_line(0.0, spacing)
    _colour(state)
    if state.edit.background == "light":
        state.change(
            background_blur_deg=widgets.slider(state, BACKGROUND_BLUR, state.edit.background_blur_deg),
            background_fov_deg=widgets.slider(state, BACKGROUND_WIDTH, state.edit.background_fov_deg),
        )


def _colour(state: EditorState) -> None:
    """A plain colour behind the person; outlined while it is what is seen there."""
    background = state.edit.background
    words = "A plain colour behind the person: click to choose it."
    picked = widgets.swatch(state, COLOUR, _plain_colour(background), words, in_bytes=True)
    if background.startswith("#"):
        corner, end = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        imgui.get_window_draw_list().add_rect(corner, end, theme.packed(theme.ACCENT), 4.0, 1.5)
    _take_colour(state, picked)


def _plain_colour(background: str) -> tuple[float, ...]:
    """The colour of a background, or the first to choose from; red, green and blue in [0, 1]."""
    colour = background if background.startswith("#") else "#30343a"
    return tuple(value / 255 for value in bytes.fromhex(colour[1:]))


def _take_colour(state: EditorState, picked: Sequence[float] | None) -> None:
    if picked is not None:
        state.change(background=widgets.hex_of(picked))


def _faces(state: EditorState, fonts: theme.Fonts) -> None:
    """Who is relit, and the ways to correct where they are and what belongs to them."""
    faces = state.snapshot.faces
    state.pointing_at_faces = False
    if state.snapshot.opened is None:
        return
    imgui.begin_group()
    _faces_title(state, fonts, len(faces))
    if len(faces) > 1:
        everyone = ("", "All", "Relight everyone.")
        single = ((str(i), str(i + 1), "Relight this person alone.") for i in range(len(faces)))
        choices = (everyone, *single)
        only = face_edits.wished_face(state)
        current = "" if only is None else str(only)
        chosen = widgets.segmented(choices, current, most_in_row=_FACES_IN_ROW)
        if chosen != current:
            state.choose_face(int(chosen) if chosen else None)
    imgui.end_group()
    state.pointing_at_faces = imgui.is_item_hovered()


def _faces_title(state: EditorState, fonts: theme.Fonts, count: int) -> None:
    """How many there are; the buttons that show their boxes and take up the brush are at the right end of the line.

    The latter is there while the picture is still to come, so that nothing moves under the mouse.
    """
    boxes = Tool("Boxes…", "Move or resize the boxes of the faces, add one that was missed.  Shift + F")
    words = "Paint what belongs to the person and was missed, or what does not.  Shift + O"
    outline = Tool("Outline…", words, state.snapshot.picture is not None)
    tools = ((boxes, state.faces.is_open), (outline, state.brush.is_open))
    end = imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x
    widgets.heading(fonts, "No face" if count == 0 else "Face" if count == 1 else f"{count} faces")
    spacing = SPACING_EM * imgui.get_font_size()
    clicked = None
    for place, (tool, is_on) in enumerate(tools):
        imgui.same_line(end - sum(tool_width(later) for later, _ in tools[place:]) + spacing)
        if tool_button(tool, is_on):
            clicked = tool
    if clicked is boxes:
        face_edits.switch(state)
    elif clicked is outline:
        brush_edits.switch(state)
