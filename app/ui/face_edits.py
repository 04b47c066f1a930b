"""Correcting where the faces are: what the tool over the picture and the commands do to the state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from app.document.face_boxes import MOST_FACES
from app.engine.sources import PhotoSource
from app.ui.viewport.face_boxes import FaceGrab
from relight_core.face.find import FaceBox

if TYPE_CHECKING:
    from app.ui.state import EditorState


@dataclass
class FaceTool:
    """The boxes over the picture.

    Attributes:
        is_open: they are in sight and can be moved.
        before: the photo as it was wished for when they came into sight.
        selected: which one is worked on, or -1.
        held: what the mouse holds.
        pane: in which of the viewport's panes it does so.
        moving: the boxes as they are while they are dragged; they count once the drag ends.
    """

    is_open: bool = False
    before: PhotoSource | None = None
    selected: int = -1
    held: FaceGrab | None = None
    pane: int = 0
    moving: tuple[FaceBox, ...] | None = None

    def let_go(self) -> None:
        """Forget the drag."""
        self.held, self.moving = None, None


def is_corrected(state: EditorState) -> bool:
    """Whether the photo that is wanted has boxes of its own, instead of those that the finder sees."""
    return state.photo is not None and state.photo.boxes is not None


def wished_boxes(state: EditorState) -> tuple[FaceBox, ...]:
    """Where the faces are to be: as corrected, else as found; none while they are being found again."""
    photo, opened = state.photo, state.snapshot.opened
    if photo is None or opened is None or not opened.shows(photo):
        return ()
    if photo.boxes is not None:
        return photo.boxes
    return state.snapshot.faces if opened.source.boxes is None else ()


def wished_face(state: EditorState) -> int | None:
    """Which face of the open photo is to be relit alone; None is all of them."""
    photo = state.photo if state.is_at_work() else state.photo_left or state.snapshot.opened.source
    return photo.face_index


def is_searching(state: EditorState) -> bool:
    """Whether the finder is at work on the photo in sight."""
    photo, opened = state.photo, state.snapshot.opened
    if photo is None or opened is None or photo is opened.source or photo.boxes is not None:
        return False
    return opened.source.boxes is not None or not opened.shows(photo)


def switch(state: EditorState) -> None:
    """Show the boxes, or put them away with what was changed."""
    if state.faces.is_open:
        done(state)
    else:
        show(state)


def show(state: EditorState) -> None:
    """Show the boxes over the picture."""
    if not state.is_at_work():
        return
    state.make_room_for_a_tool()
    only = 0 if len(wished_boxes(state)) == 1 else -1
    state.faces = FaceTool(True, state.photo, only)


def done(state: EditorState) -> None:
    """Put the boxes away; they stay as they are."""
    state.faces = FaceTool()


def cancel(state: EditorState) -> None:
    """Forget the drag; where there is none, put the boxes back as they were when they came into sight, and away."""
    if state.faces.held is not None:
        state.faces.let_go()
        return
    before, photo = state.faces.before, state.photo
    done(state)
    if before is not None and photo is not None:
        was, now = ((wish.face_index, wish.boxes) for wish in (before, photo))
        if was != now:
            _wish(state, before.boxes, before.face_index)


def finish_drag(state: EditorState) -> None:
    """What was dragged counts from now on."""
    tool, boxes = state.faces, wished_boxes(state)
    moving = tool.moving
    tool.let_go()
    if moving is None or moving == boxes:
        return
    if len(moving) > MOST_FACES:
        state.asking.tell(f"A photo has at most {MOST_FACES} faces; remove one first", True)
        return
    is_new = len(moving) > len(boxes)
    # Who draws a box wants to see that face relit, whichever was relit alone until then.
    _wish(state, moving, None if is_new else state.photo.face_index)
    tool.selected = len(moving) - 1 if is_new else tool.selected


def remove(state: EditorState) -> None:
    """Take the selected box away."""
    tool, boxes = state.faces, wished_boxes(state)
    at = tool.selected
    if not 0 <= at < len(boxes):
        return
    index = state.photo.face_index
    if index is not None:
        index = None if index == at else index - (index > at)
    tool.let_go()
    tool.selected = -1
    _wish(state, (*boxes[:at], *boxes[at + 1 :]), index)


def find_again(state: EditorState) -> None:
    """Let the finder say again where the faces are."""
    state.faces.let_go()
    state.faces.selected = -1
    _wish(state, None, None)


def _wish(state: EditorState, boxes: tuple[FaceBox, ...] | None, face_index: int | None) -> None:
    if not state.is_at_work():
        # Another photo is on its way, which has faces of its own.
        return
    state.photo = replace(state.photo.on(state.snapshot.opened.photo), face_index=face_index, boxes=boxes)
