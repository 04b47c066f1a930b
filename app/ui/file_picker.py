"""Our own file dialog, for systems that have none: a path that is typed, and what there is to click."""

from __future__ import annotations

import os
from pathlib import Path

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.asking import FileRequest
from app.ui.file_dialogs import candidates
from app.ui.state import EditorState
from relight_core.imaging.files import legible

_FLAGS = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.no_move | imgui.WindowFlags_.no_saved_settings
_ROWS = 12
_WRONG = {"open": "There is no such file", "save": "That is a folder; add a name", "folder": "There is no such folder"}


def draw(state: EditorState, fonts: theme.Fonts) -> None:
    """The dialog, in the middle of the window, while there is something to ask for."""
    request = state.picking
    if request is None:
        return
    io, em = imgui.get_io(), imgui.get_font_size()
    width = min(40 * em, io.display_size.x - 2 * em)
    imgui.set_next_window_pos(
        imgui.ImVec2(io.display_size.x / 2, io.display_size.y / 2), imgui.Cond_.always, imgui.ImVec2(0.5, 0.5)
    )
    imgui.set_next_window_size(imgui.ImVec2(width, (_ROWS + 6) * 1.5 * em))
    imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
    imgui.begin("file", None, _FLAGS)
    widgets.heading(fonts, request.title)
    if imgui.is_window_appearing() or not imgui.is_any_item_active():
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(-1.0)
    entered, request.text = widgets.path_input(request.text, imgui.InputTextFlags_.enter_returns_true)
    entered |= _rows(request)
    _buttons(state, request, entered)
    imgui.end()
    imgui.pop_style_var()


def _rows(request: FileRequest) -> bool:
    """What there is to click; True where a file was double-clicked, which takes it at once."""
    taken = False
    imgui.begin_child("rows", imgui.ImVec2(0.0, -imgui.get_frame_height_with_spacing()))
    folder = Path(os.path.expanduser(request.text))
    above = folder.parent if request.text.endswith(os.sep) else folder.parent.parent
    if imgui.selectable("..   the folder above", False)[0]:
        request.text = os.path.join(above, "")
    # A file that is chosen stays among its neighbours, where a second click meets it.
    chosen = str(folder) if os.path.isfile(folder) else None
    for path in candidates(os.path.join(folder.parent, "") if chosen else request.text, request.suffixes):
        is_folder = os.path.isdir(path)
        label = f"{path.name}{os.sep if is_folder else ''}"
        # Where a folder is wanted, files only show which folder this is.
        imgui.begin_disabled(request.kind == "folder" and not is_folder)
        if imgui.selectable(legible(label), str(path) == chosen, imgui.SelectableFlags_.allow_double_click)[0]:
            taken = str(path) == chosen and imgui.is_mouse_double_clicked(0)
            request.text = os.path.join(path, "") if is_folder else str(path)
        imgui.end_disabled()
    imgui.end_child()
    return taken


def _buttons(state: EditorState, request: FileRequest, entered: bool) -> None:
    path = Path(os.path.expanduser(request.text))
    fits = os.path.isdir(path) if request.kind == "folder" else bool(path.name) and not os.path.isdir(path)
    if request.kind == "open":
        fits = fits and os.path.exists(path)
    imgui.begin_disabled(not fits)
    chosen = imgui.button({"open": "Open", "save": "Save", "folder": "Choose"}[request.kind])
    imgui.end_disabled()
    imgui.same_line()
    cancelled = imgui.button("Cancel")
    if not fits and path.name:
        imgui.same_line()
        imgui.text_disabled(_WRONG[request.kind])
    if cancelled or imgui.is_key_pressed(imgui.Key.escape):
        state.picking = None
    elif fits and (chosen or entered):
        state.picking = None
        request.then([path])
