"""Saving: kind of file, size, place; copying; the turntable; many photos at once."""

from __future__ import annotations

from dataclasses import replace

from imgui_bundle import imgui

from app.engine.exporting import FORMS, PROFILES, QUALITIES, SIDES, ExportSettings
from app.ui import theme, widgets
from app.ui.export_name import choose_form, export_place, form_named, take_named_form
from app.ui.panels.groups import group
from app.ui.state import EditorState
from relight_core.imaging.files import legible
from relight_core.pipeline.results.layers import LAYERS

_FORM_WORDS = {
    ".png": ("PNG", "Lossless, for everything. Keeps transparency."),
    ".jpg": ("JPEG", "Small, for sharing. No transparency."),
    ".tif": ("TIFF", "Lossless, for print and other editors."),
    ".exr": ("EXR", "Linear radiance and the channels as layers, for compositing."),
}
FORM_CHOICES = tuple((form, *_FORM_WORDS[form]) for form in FORMS)
"""Suffix, label and tooltip of each kind of picture."""

QUALITY, NAME = "Export quality", "Export name"
"""What can be typed in here, as of `widgets.begin_typing`."""

_INTEGERS = (("", "8 bit", "For screens."), ("deep", "16 bit", "For further editing."))
_FLOATS = (("", "Half", "16-bit floats: enough for light."), ("deep", "Float", "32-bit floats."))
_PROFILE_WORDS = {
    "srgb": ("sRGB", "Looks the same everywhere; colours that sRGB does not hold are brought into it."),
    "photo": ("As photo", "The photo's own colour profile, with its colours that sRGB does not hold."),
}
PROFILE_CHOICES = tuple((profile, *_PROFILE_WORDS[profile]) for profile in PROFILES)
"""Value, label and tooltip of each."""

_SPACING, _LAYERS_SHARE = 4.0, 0.44
_USUAL_QUALITY = ExportSettings().quality
LAYER_WORDS = {
    "albedo": "Colour without light",
    "normal": "Which way each spot faces",
    "specular": "Shine",
    "shadow": "Shadow",
    "parsing": "Parts of the head, as numbers",
    "composition": "The relit view",
    "foreign_shadow": "What was taken off of shadows from outside, if there are any",
    "matte": "Where the person is",
    "background": "What is seen beside the person",
}


def draw(state: EditorState, fonts: theme.Fonts) -> None:
    """The group's contents, inside its panel."""
    kind = next(label for suffix, label, _ in FORM_CHOICES if suffix == state.export.form)
    if not group(state, fonts, "export", "Export", kind)[0]:
        return
    imgui.begin_disabled(state.snapshot.picture is None)
    form = widgets.segmented(FORM_CHOICES, state.export.form)
    if form != state.export.form:
        choose_form(state, form)
    _depth_and_size(state)
    _profile(state)
    _place_and_layers(state)
    _buttons(state)
    imgui.end_disabled()


def _depth_and_size(state: EditorState) -> None:
    """In a row, or the size below the depth where that has no room for its words."""
    export = state.export
    sizes = max(imgui.calc_text_size(size_words(side)).x for side in SIDES)
    needed = sizes + imgui.get_frame_height() + 2.0 * imgui.get_style().frame_padding.x
    room = imgui.get_content_region_avail().x
    in_a_row = needed <= (room - _SPACING) / 2
    half = (room - _SPACING) / 2 if in_a_row else room
    if export.form == ".jpg":
        with widgets.keyboard_for(state, QUALITY):
            state.export = replace(export, quality=_quality(export.quality, half))
    else:
        chosen = widgets.segmented(depths(export.form), "deep" if export.deep else "", half)
        state.export = replace(export, deep=chosen == "deep")
    if in_a_row:
        imgui.same_line(0.0, _SPACING)
    _size(state)


def has_choice_of_profile(state: EditorState) -> bool:
    """Whether the open photo has a colour profile of its own that the chosen kind of file can be written in."""
    return _has_profile(state) and state.export.form != ".exr"


def _has_profile(state: EditorState) -> bool:
    opened = state.snapshot.opened
    return opened is not None and opened.photo.icc is not None


def _profile(state: EditorState) -> None:
    """The choice of colours, if the photo has a profile. EXR has none, but the row stays, so that no button moves."""
    if not _has_profile(state):
        return
    imgui.begin_disabled(state.export.form == ".exr")
    state.export = replace(state.export, profile=widgets.segmented(PROFILE_CHOICES, state.export.profile))
    imgui.end_disabled()


def depths(form: str) -> tuple[tuple[str, str, str], ...]:
    """The choices of how finely a kind of file holds a number: value, label and tooltip each."""
    return {".jpg": (), ".exr": _FLOATS}.get(form, _INTEGERS)


def size_words(side: int | None) -> str:
    """One of SIDES, in words."""
    return f"{side} px" if side else "Full size"


def layer_title(name: str) -> str:
    """One of LAYERS, in words."""
    return name.replace("_", " ").capitalize()


def with_layer(export: ExportSettings, name: str, is_on: bool) -> ExportSettings:
    """The settings with one layer of an EXR put in or left out."""
    layers = tuple(entry for entry in LAYERS if (is_on if entry == name else entry in export.layers))
    return replace(export, layers=layers)


def _place_and_layers(state: EditorState) -> None:
    """The file's name; for an EXR its layers beside it, so that the buttons below stay where they are."""
    room = imgui.get_content_region_avail().x
    imgui.set_next_item_width(room if state.export.form != ".exr" else (1.0 - _LAYERS_SHARE) * room - _SPACING)
    with widgets.keyboard_for(state, NAME):
        _, state.export_path = widgets.path_input(state.export_path, imgui.InputTextFlags_.elide_left)
    if imgui.is_item_deactivated_after_edit():
        take_named_form(state)
    if state.export_path:
        place = export_place(state, form_named(state.export_path) or state.export.form)
        imgui.set_item_tooltip(f"{legible(str(place))}\nA number is added to the name if there is such a file.")
    if state.export.form == ".exr":
        imgui.same_line(0.0, _SPACING)
        _layers(state)


def _quality(quality: int, width: float) -> int:
    """As high as the row of other files has it, so that the buttons below stay where they are."""
    imgui.set_next_item_width(width)
    for name, colour in (("slider_grab", theme.FAINT), ("slider_grab_active", theme.ACCENT)):
        imgui.push_style_color(getattr(imgui.Col_, name), imgui.ImVec4(*colour))
    low, high = QUALITIES
    _, chosen = imgui.slider_int("##quality", quality, low, high, "Quality %d", imgui.SliderFlags_.always_clamp)
    imgui.pop_style_color(2)
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(0):
        imgui.internal.clear_active_id()
        chosen = _USUAL_QUALITY
    imgui.set_item_tooltip("Higher is larger and better; 92 is hard to tell. Double-click resets it.")
    return chosen


def _layers(state: EditorState) -> None:
    """A list of check boxes that unfolds over the panel."""
    count = len(state.export.layers)
    imgui.set_next_item_width(imgui.get_content_region_avail().x)
    is_open = imgui.begin_combo("##layers", f"{count} layer{'s' * (count != 1)}", imgui.ComboFlags_.height_largest)
    if not is_open:
        imgui.set_item_tooltip("What the file holds beside the picture.")
        return
    for name in LAYERS:
        changed, on = imgui.checkbox(layer_title(name), name in state.export.layers)
        imgui.set_item_tooltip(LAYER_WORDS[name])
        if changed:
            state.export = with_layer(state.export, name, on)
    imgui.end_combo()


def _size(state: EditorState) -> None:
    sizes = [size_words(side) for side in SIDES]
    imgui.set_next_item_width(imgui.get_content_region_avail().x)
    changed, index = imgui.combo("##size", SIDES.index(state.export.longest_side), sizes)
    words = "As large as the photo, or so many pixels along the longer side. A turntable has 1080 at full size."
    imgui.set_item_tooltip(words)
    if changed:
        state.export = replace(state.export, longest_side=SIDES[index])


def _buttons(state: EditorState) -> None:
    with widgets.narrow_buttons():
        _save_or_copy(state)
        film = ("MP4", "turntable_film", "A film of the light turning once around.  Ctrl + T")
        words = "The light turning once around, as numbered PNG files in a new folder."
        _wish_either(state, "Turntable", film, ("PNGs", "turntable_pictures", words))
        _batch(state)


def _save_or_copy(state: EditorState) -> None:
    wishes = (
        ("Save as…", "export_as", "Choose the place; asks before it replaces a file.  Ctrl + E"),
        ("Copy", "copy_picture", "Put the picture on the clipboard.  Ctrl + C"),
    )
    labels = ("Export", *(label for label, _, _ in wishes))
    in_a_row, width = widgets.fit_in_row(labels, imgui.get_content_region_avail().x, _SPACING)
    if imgui.button("Export", imgui.ImVec2(width, 0.0)):
        state.export_wanted = state.export.form
    imgui.set_item_tooltip("Save it there at once.  E")
    for wish in wishes:
        if in_a_row:
            imgui.same_line(0.0, _SPACING)
        _wish(state, *wish, width)


def _batch(state: EditorState) -> None:
    if len(state.queue.paths) < 2:
        room = imgui.get_content_region_avail().x
        _wish(state, "Batch over a folder…", "batch", "Relight all photos of a folder like this one.  Ctrl + B", room)
        return
    like_this = ("Like this", "batch", "Relight all photos opened together like this one.  Ctrl + B")
    words = "Relight each of the photos opened together with the light and the settings it was left or saved with."
    _wish_either(state, "Batch", like_this, ("Each as left", "batch_as_left", f"{words}  Ctrl + Shift + B"))


def _wish_either(state: EditorState, title: str, *choices: tuple[str, str, str]) -> None:
    """A title, and beside it or below it two buttons: label, kind of wish and tooltip of each."""
    labels = [label for label, _, _ in choices]
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(title)
    beside = imgui.calc_text_size(title).x + imgui.get_style().item_spacing.x
    if widgets.fit_in_row(labels, imgui.get_content_region_avail().x - beside, _SPACING)[0]:
        imgui.same_line()
    in_a_row, width = widgets.fit_in_row(labels, imgui.get_content_region_avail().x, _SPACING)
    for index, choice in enumerate(choices):
        if index and in_a_row:
            imgui.same_line(0.0, _SPACING)
        _wish(state, *choice, width)


def _wish(state: EditorState, label: str, kind: str, tooltip: str, width: float) -> None:
    if imgui.button(label, imgui.ImVec2(width, 0.0)):
        state.asking.wish(kind)
    imgui.set_item_tooltip(tooltip)
