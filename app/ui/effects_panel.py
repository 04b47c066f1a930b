"""The right panel: sliders, background, export."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui

from app.ui import history_panel, plan_panel, quality_panel, theme, widgets
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
    ("light", "Light", "Show what the light looks like behind the person."),
    ("transparent", "None", "Cut the person out: a transparent background."),
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
    _export(state, fonts)
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
    widgets.gap(0.1)
    untouched = state.edit == Edit(quality=state.edit.quality) and state.light_edit == LightEdit()
    imgui.begin_disabled(untouched)
    if imgui.button("Reset all", imgui.ImVec2(-1.0, 0.0)):
        state.reset()
    imgui.end_disabled()
    imgui.set_item_tooltip("Puts every slider and the light back.")


def _faces(state: EditorState, fonts: theme.Fonts) -> None:
    opened, faces = state.snapshot.opened, state.snapshot.faces
    state.pointing_at_faces = False
    if opened is None or not faces or len(faces) < 2:
        return
    widgets.heading(fonts, "Face")
    count = min(len(faces), MOST_FACES)
    choices = tuple(
        (str(index), str(index + 1), "Relight this person; 1 is the largest face.") for index in range(count)
    )
    current = str(opened.source.face_index or 0)
    imgui.begin_group()
    chosen = widgets.segmented(choices, current)
    imgui.end_group()
    state.pointing_at_faces = imgui.is_item_hovered()
    if chosen != current:
        state.choose_face(int(chosen))
    widgets.gap(0.8)


def _export(state: EditorState, fonts: theme.Fonts) -> None:
    widgets.heading(fonts, "Export")
    imgui.begin_disabled(state.snapshot.picture is None)
    imgui.set_next_item_width(-1.0)
    _, state.export_path = imgui.input_text("##path", state.export_path, imgui.InputTextFlags_.elide_left)
    if state.export_path:
        imgui.set_item_tooltip(f"{state.export_path}\nA number is added to the name if there is such a file.")
    half = (imgui.get_content_region_avail().x - 4.0) / 2
    if imgui.button("Save PNG", imgui.ImVec2(half, 0.0)):
        state.export_wanted = ".png"
    imgui.set_item_tooltip("The picture as you see it, 8 bits.  E")
    imgui.same_line(0.0, 4.0)
    if imgui.button("Save EXR", imgui.ImVec2(half, 0.0)):
        state.export_wanted = ".exr"
    imgui.set_item_tooltip("Linear radiance for compositing; the channels in a second file.  Shift + E")
    imgui.end_disabled()


def export_path(state: EditorState, suffix: str) -> Path:
    """Where an export with this suffix goes, as the path line says."""
    path = Path(state.export_path or "portrait-relit")
    known = path.suffix.lower() in (".png", ".exr", ".jpg", ".jpeg", ".tif", ".tiff")
    return path.with_suffix(suffix) if known else path.with_name(path.name + suffix)
