"""Our own file dialog, for systems that have none: a path that is typed, and what there is to click."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from imgui_bundle import imgui

from app.engine.places import full_path
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
    imgui.set_next_window_size(imgui.ImVec2(width, min((_ROWS + 6) * 1.5 * em, io.display_size.y - em)))
    imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
    imgui.begin("file", None, _FLAGS)
    widgets.heading(fonts, request.title)
    before = request.text
    entered = _line(request)
    if _folder_above_is_wished():
        _look_into(request, _above(request), os.path.basename(request.text))
        # The line would go on with what was typed in it.
        imgui.internal.clear_active_id()
    entered = _rows(request, entered)
    if request.text != before:
        request.row = -1
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
    entered, request.text = widgets.path_input(request.text, flags, partial(_type_on, request))
    return entered


def _type_on(request: FileRequest, data: imgui.InputTextCallbackData) -> int:
    """Put the cursor behind the path, to be typed on; as it gets the keyboard all of it is selected.

    Of a file to save the name stays selected without its suffix, so that what is typed takes its place.
    """
    data.clear_selection()
    data.cursor_pos = data.buf_text_len
    if request.kind == "save":
        start, end = _place_of_name(legible(request.text), request.suffixes)
        data.selection_start, data.selection_end, data.cursor_pos = start, end, end
    return 0


def _place_of_name(path: str, suffixes: Sequence[str]) -> tuple[int, int]:
    """Where a path's last name begins and where its suffix does, in bytes, as Dear ImGui counts."""
    name = os.path.basename(path)
    ending = next((suffix for suffix in suffixes if name.lower().endswith(suffix)), os.path.splitext(name)[1])
    length = len(path.encode())
    return length - len(name.encode()), length - len(ending.encode())


def _folder_above_is_wished() -> bool:
    return imgui.get_io().key_alt and imgui.is_key_pressed(imgui.Key.up_arrow)


def _above(request: FileRequest) -> Path:
    """The folder above the one that is listed; in full, since above "." there would be "." again."""
    return Path(os.path.abspath(os.path.dirname(_in_full(request, request.text)))).parent


def _in_full(request: FileRequest, text: str) -> str:
    """A typed path, which begins in the dialog's folder unless it says where; nothing typed is that folder."""
    return os.path.join(request.folder, os.path.expanduser(text))


def _rows(request: FileRequest, entered: bool) -> bool:
    """What there is to click, or to go to with the arrow keys and Enter.

    Args:
        entered: Enter was pressed.

    Returns:
        Whether what the line holds now is to be taken: it was entered, or a file in the list, or double-clicked there.
    """
    listed = _listed(request)
    folders, files = candidates(listed, request.suffixes)
    shown = (folders + files)[:_MOST]
    moved = _move(request, 1 + (min(len(folders), _MOST) if request.kind == "folder" else len(shown)))
    imgui.begin_child("rows", imgui.ImVec2(0.0, -imgui.get_frame_height_with_spacing()))
    above = _above(request)
    is_at = request.row == 0
    if _row(0, "..   the folder above   (Alt + Up)", is_at, moved and is_at) or (entered and is_at):
        _look_into(request, above, os.path.basename(request.text))
        entered = False
    typed = Path(_in_full(request, request.text))
    for number, path in enumerate(shown, 1):
        is_folder, is_at = number <= len(folders), number == request.row
        is_chosen = not is_folder and str(path) == str(typed)
        # Where a folder is wanted, files only show which folder this is.
        imgui.begin_disabled(request.kind == "folder" and not is_folder)
        clicked = _row(number, f"{path.name}{os.sep if is_folder else ''}", is_chosen or is_at, moved and is_at)
        imgui.end_disabled()
        if clicked or (entered and is_at):
            entered = not is_folder and (not clicked or (is_chosen and imgui.is_mouse_double_clicked(0)))
            _choose(request, path, is_folder, listed)
    more = len(folders) + len(files) - _MOST
    if more > 0:
        imgui.text_disabled(f"{more} more; type how a name begins to find them")
    imgui.end_child()
    return entered


def _move(request: FileRequest, count: int) -> bool:
    """Go up and down between the rows, so many of which can be chosen; whether that was done now."""
    by = imgui.is_key_pressed(imgui.Key.down_arrow) - imgui.is_key_pressed(imgui.Key.up_arrow)
    if not by or imgui.get_io().key_alt:
        return False
    row = request.row + by
    if by > 0 and request.row < 0 and request.kind != "save" and os.path.basename(request.text):
        # Whoever has begun a name wants what is found of it, and not the folder above that.
        row = 1
    request.row = min(max(row, -1), count - 1)
    return True


def _listed(request: FileRequest) -> str:
    """The typed path that the list is made for: a chosen file stays among its neighbours, for the second click."""
    if request.text == request.chosen:
        return request.chosen_among
    path = _in_full(request, request.text)
    return os.path.join(os.path.dirname(path), "") if os.path.isfile(path) else path


def _row(number: int, label: str, is_lit: bool, comes_into_sight: bool) -> bool:
    """One row; the label is drawn by itself, as in the name of a control ## would end it."""
    at = imgui.get_cursor_pos()
    clicked, _ = imgui.selectable(f"##{number}", is_lit, imgui.SelectableFlags_.allow_double_click)
    if comes_into_sight:
        imgui.set_scroll_here_y()
    imgui.set_cursor_pos(at)
    imgui.text_unformatted(legible(label))
    return clicked


def _choose(request: FileRequest, path: Path, is_folder: bool, listed: str) -> None:
    if is_folder:
        # What was typed since is how the folder's name begins.
        _look_into(request, path, os.path.basename(request.chosen))
    else:
        request.text = request.chosen = str(path)
        request.chosen_among = listed


def _look_into(request: FileRequest, folder: Path, name: str) -> None:
    """List a folder; what is to be saved keeps its name there."""
    request.folder = str(folder)
    request.text = request.chosen = os.path.join(folder, name if request.kind == "save" else "")
    request.chosen_among = os.path.join(folder, "")


def _buttons(state: EditorState, request: FileRequest, entered: bool) -> None:
    path = Path(_in_full(request, request.text))
    is_folder = os.path.isdir(path)
    # With a slash behind it the name is a folder's, and a file of that name is not what was meant.
    fits = is_folder if request.kind == "folder" else bool(os.path.basename(request.text)) and not is_folder
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
        request.then([full_path(path)])
    elif entered and is_folder:
        # It was typed without the slash that lists what is in it.
        _look_into(request, path, "")
