"""The right panel: sliders, background, export."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui

from app.ui import export_panel, history_panel, plan_panel, quality_panel, theme, widgets
from app.ui.state import EditorState
from relight_core.lighting.light_edit import LightEdit
from relight_core.pipeline.edit import Edit

SHADOW = widgets.Slider(
    "Shadow", 0.0, 2.0, 1.0, "%.2f", "Deepens or lifts the shadows the light casts; 0 removes them."
)
SPECULAR = widgets.Slider(
    "Specular", 0.0, 2.0, 1.0, "%.2f", "Strengthens or mattes the shine on the skin; 0 removes it."
)
EXPOSURE = widgets.Slider("Exposure", -5.0, 5.0, 0.0, "%+.2f EV", "Brightens or darkens the whole picture, in stops.")
BACKGROUNDS = (
    ("keep", "Photo", "Keep the photo's own background."),
    ("match", "Match", "Keep it, as bright and as tinted as the new light makes the person."),
    ("light", "Light", "Show what the light looks like behind the person."),
    ("transparent", "None", "Cut the person out: a transparent background."),
)
BACKGROUND_BLUR = widgets.Slider(
    "Background blur", 0.0, 20.0, 1.0, "%.1f°", "How far out of focus the light behind the person is."
)
MOST_FACES = 6


def draw(state: EditorState, fonts: theme.Fonts) -> None:
    """The panel's contents, inside its window."""
    _queue(state)
    _effects(state, fonts)
    widgets.gap(0.8)
    quality_panel.draw(state, fonts)
    plan_panel.draw(state, fonts)
    widgets.gap(0.8)
    _faces(state, fonts)
    export_panel.draw(state, fonts)
    widgets.gap(0.8)
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
    imgui.text_disabled(f"Photo {state.queue.label}")
    widgets.gap(0.4)


def _effects(state: EditorState, fonts: theme.Fonts) -> None:
    widgets.heading(fonts, "Effects")
    state.change(shadow=widgets.slider(state, SHADOW, state.edit.shadow))
    state.change(specular=widgets.slider(state, SPECULAR, state.edit.specular))
    state.change(exposure_ev=widgets.slider(state, EXPOSURE, state.edit.exposure_ev))
    widgets.gap(0.1)
    imgui.text_disabled("Background")
    state.change(background=widgets.segmented(BACKGROUNDS, state.edit.background))
    _background(state)
    widgets.gap(0.1)
    untouched = state.edit == Edit(quality=state.edit.quality) and state.light_edit == LightEdit()
    imgui.begin_disabled(untouched)
    if imgui.button("Reset all", imgui.ImVec2(-1.0, 0.0)):
        state.reset()
    imgui.end_disabled()
    imgui.set_item_tooltip("Puts every slider and the light back.")


def _background(state: EditorState) -> None:
    """A colour behind the person; what of the light is seen there."""
    background = state.edit.background
    colour = background if background.startswith("#") else "#30343a"
    shown = [int(colour[index : index + 2], 16) / 255 for index in (1, 3, 5)]
    flags = imgui.ColorEditFlags_.no_inputs | imgui.ColorEditFlags_.no_label
    changed, picked = imgui.color_edit3("background colour", shown, flags)
    if imgui.is_item_active():
        state.hand_on_control = True
    imgui.set_item_tooltip("A plain colour behind the person.")
    if changed:
        state.change(background="#" + "".join(f"{round(value * 255):02x}" for value in picked))
    imgui.same_line()
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Colour" if not background.startswith("#") else background)
    if background == "light":
        state.change(background_blur_deg=widgets.slider(state, BACKGROUND_BLUR, state.edit.background_blur_deg))


def _faces(state: EditorState, fonts: theme.Fonts) -> None:
    opened, faces = state.snapshot.opened, state.snapshot.faces
    state.pointing_at_faces = False
    if opened is None or not faces or len(faces) < 2:
        return
    widgets.heading(fonts, "Face")
    count = min(len(faces), MOST_FACES)
    everyone = ("", "All", "Relight everyone.")
    single = ((str(i), str(i + 1), "Relight this person alone; 1 is the largest face.") for i in range(count))
    choices = (everyone, *single)
    current = "" if opened.source.face_index is None else str(opened.source.face_index)
    imgui.begin_group()
    chosen = widgets.segmented(choices, current)
    imgui.end_group()
    state.pointing_at_faces = imgui.is_item_hovered()
    if chosen != current:
        state.choose_face(int(chosen) if chosen else None)
    widgets.gap(0.8)


def export_path(state: EditorState, suffix: str) -> Path:
    """Where an export with this suffix goes, as the path line says."""
    path = Path(state.export_path or "portrait-relit")
    known = path.suffix.lower() in (".png", ".exr", ".jpg", ".jpeg", ".tif", ".tiff")
    return path.with_suffix(suffix) if known else path.with_name(path.name + suffix)
