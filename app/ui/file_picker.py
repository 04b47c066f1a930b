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
_MOST = 200
"""Rows that are drawn at all."""
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
    entered = _line(request)
    entered |= _rows(request)
    _buttons(state, request, entered)
    imgui.end()
    imgui.pop_style_var()


def _line(request: FileRequest) -> bool:
    """The line for the path, which always has the keyboard; True where Enter was pressed."""
    flags = imgui.InputTextFlags_.enter_returns_true
    if imgui.is_window_appearing() or not imgui.is_any_item_active():
        imgui.set_keyboard_focus_here()
        flags |= imgui.InputTextFlags_.callback_always
    imgui.set_next_item_width(-1.0)
    entered, request.text = widgets.path_input(request.text, flags, _type_on)
    return entered


def _type_on(data: imgui.InputTextCallbackData) -> int:
    """Put the cursor behind the path, to be typed on; as it gets the keyboard all of it is selected."""
    data.clear_selection()
    data.cursor_pos = data.buf_text_len
    return 0


def _rows(request: FileRequest) -> bool:
    """What there is to click; True where a file was double-clicked, which takes it at once."""
    taken = False
    imgui.begin_child("rows", imgui.ImVec2(0.0, -imgui.get_frame_height_with_spacing()))
    folder = Path(os.path.expanduser(request.text))
    above = folder.parent if request.text.endswith(os.sep) else folder.parent.parent
    listed = _listed(request)
    if imgui.selectable("..   the folder above", False)[0]:
        request.text = os.path.join(above, "")
    folders, files = candidates(listed, request.suffixes)
    for number, path in enumerate((folders + files)[:_MOST]):
        is_folder = number < len(folders)
        is_chosen = not is_folder and str(path) == str(folder)
        # Where a folder is wanted, files only show which folder this is.
        imgui.begin_disabled(request.kind == "folder" and not is_folder)
        if _row(number, f"{path.name}{os.sep if is_folder else ''}", is_chosen):
            taken = is_chosen and imgui.is_mouse_double_clicked(0)
            _choose(request, path, is_folder, listed)
        imgui.end_disabled()
    more = len(folders) + len(files) - _MOST
    if more > 0:
        imgui.text_disabled(f"{more} more; type how a name begins to find them")
    imgui.end_child()
    return taken


def _listed(request: FileRequest) -> str:
    """The typed path that the list is made for: a chosen file stays among its neighbours, for the second click."""
    if request.text == request.chosen:
        return request.chosen_among
    path = os.path.expanduser(request.text)
    return os.path.join(os.path.dirname(path), "") if os.path.isfile(path) else request.text


def _row(number: int, label: str, is_chosen: bool) -> bool:
    """One row; the label is drawn by itself, as in the name of a control ## would end it."""
    at = imgui.get_cursor_pos()
    clicked, _ = imgui.selectable(f"##{number}", is_chosen, imgui.SelectableFlags_.allow_double_click)
    imgui.set_cursor_pos(at)
    imgui.text_unformatted(legible(label))
    return clicked


def _choose(request: FileRequest, path: Path, is_folder: bool, listed: str) -> None:
    request.text = os.path.join(path, "") if is_folder else str(path)
    if not is_folder:
        request.chosen, request.chosen_among = request.text, listed


def _buttons(state: EditorState, request: FileRequest, entered: bool) -> None:
    path = Path(os.path.expanduser(request.text))
    is_folder = os.path.isdir(path)
    fits = is_folder if request.kind == "folder" else bool(path.name) and not is_folder
    if request.kind == "open":
        fits = fits and os.path.exists(path)
    imgui.begin_disabled(not fits)
    chosen = imgui.button({"open": "Open", "save": "Save", "folder": "Choose"}[request.kind])
    imgui.end_disabled()
    imgui.same_line()
    cancelled = imgui.button("Cancel")
    # Before a file is named there is nothing wrong yet.
    if not fits and path.name and not (is_folder and request.kind == "open"):
        imgui.same_line()
        imgui.text_disabled(_WRONG[request.kind])
    if cancelled or imgui.is_key_pressed(imgui.Key.escape):
        state.picking = None
    elif fits and (chosen or entered):
        state.picking = None
        request.then([path])
