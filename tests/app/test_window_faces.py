"""The real window: boxes over faces, drawn, dragged, taken back and saved."""

import shutil

import glfw
import numpy as np
import pytest
from window_hand import places_drawn

from app.document.session_file import read_session
from app.engine.sources import PhotoSource
from app.ui import brush_edits, face_edits, widgets
from app.ui.viewport.panes import arrange_panes
from relight_core.face.find import FaceBox
from relight_core.imaging.read import read_photo
from relight_core.imaging.view_transform import apply_view


def on_the_screen(hand, x, y, pane=-1):
    """Where a point of the photo is in the window."""
    state = hand.window.state
    hand.frames(1)
    size = state.look.viewport_px
    spot = arrange_panes(state, size).panes[pane].placement
    middle = hand.centre()
    left, top = middle[0] - size[0] / 2, middle[1] - size[1] / 2
    return left + spot.x + x * spot.zoom, top + spot.y + y * spot.zoom


def drag_on_the_photo(hand, start, end, pane=-1):
    hand.drag(on_the_screen(hand, *start, pane), on_the_screen(hand, *end, pane))


@pytest.fixture
def unseen(hand, relighter, photo_path):
    """A photo in which no face is found, at one screen pixel for each of its own."""
    relighter.blind = True
    hand.drop(photo_path)
    hand.see_every_pixel()
    return hand


@pytest.fixture
def buttons(monkeypatch):
    return places_drawn(monkeypatch, widgets, "toggle")


@pytest.mark.parametrize("number", [1, 6, 7, 16])
def test_each_of_many_faces_can_be_chosen_alone(opened, buttons, number):
    state = opened.window.state
    boxes = tuple(FaceBox(6.0 * i, 10.0, 6.0 * i + 30.0, 40.0) for i in range(16))
    state.photo = PhotoSource(state.snapshot.opened.photo, None, boxes)
    opened.settle()
    assert state.snapshot.faces == boxes
    rows = {}
    for label in ("All", *(str(i + 1) for i in range(16))):
        rows.setdefault(buttons[label][1], []).append(label)
    assert [len(row) for row in rows.values()] == [7, 7, 3]
    opened.click(buttons[str(number)])
    opened.settle()
    assert state.photo.face_index == number - 1
    assert state.photo.boxes == boxes


def edges(box):
    return box.x0, box.y0, box.x1, box.y1


def test_where_no_face_is_found_a_box_is_drawn_and_relit_undone_and_saved(unseen, photo_path):
    state = unseen.window.state
    as_it_was = apply_view(read_photo(photo_path).linear) * 255
    assert state.faces.is_open
    assert np.abs(unseen.picture_pixels(96, 128) - as_it_was).max() <= 1
    drag_on_the_photo(unseen, (40, 20), (90, 70))
    (box,) = state.photo.boxes
    np.testing.assert_allclose(edges(box), (40, 20, 90, 70), atol=1.5)
    assert box.width == box.height
    assert np.abs(unseen.picture_pixels(96, 128) - as_it_was).max() > 20, "relit"
    unseen.key(glfw.KEY_ENTER)
    assert not state.faces.is_open
    unseen.key(glfw.KEY_S, ctrl=True)
    saved = read_session(photo_path.with_name("person.relight.json")).document
    assert saved == state.document()
    assert saved.photo.boxes == (box,)
    unseen.key(glfw.KEY_Z, ctrl=True)
    assert state.photo.boxes is None
    assert [step.name for step in state.history.steps] == ["Open person.png", "Add face 1"]
    assert np.abs(unseen.picture_pixels(96, 128) - as_it_was).max() <= 1
    unseen.key(glfw.KEY_Y, ctrl=True)
    assert state.photo.boxes == (box,)


def test_a_session_brings_its_boxes_back(unseen, photo_path, relighter):
    drag_on_the_photo(unseen, (40, 20), (90, 70))
    boxes = unseen.window.state.photo.boxes
    unseen.key(glfw.KEY_S, ctrl=True)
    face_edits.find_again(unseen.window.state)
    unseen.settle()
    assert unseen.window.state.snapshot.faces == ()
    unseen.drop(photo_path.with_name("person.relight.json"))
    unseen.window.state.asking.answer(unseen.window.state.asking.questions[0], 1)
    unseen.settle()
    assert unseen.window.state.snapshot.faces == boxes
    assert relighter.portraits[-1][2] == boxes
    assert not unseen.window.state.is_unsaved()


def test_a_batch_takes_the_boxes_of_a_photo_for_that_photo_only(unseen, photo_path, relighter, tmp_path):
    other = photo_path.with_name("other.png")
    other.write_bytes(photo_path.read_bytes())
    drag_on_the_photo(unseen, (40, 20), (90, 70))
    boxes = unseen.window.state.photo.boxes
    relighter.portraits.clear()
    unseen.window._deeds._outputs.batch_over([photo_path, other], tmp_path / "relit")
    unseen.settle()
    unseen.window.exporter.close()
    assert [path.name for path in (tmp_path / "relit").iterdir()] == ["person.png"]
    assert [portrait[1:] for portrait in relighter.portraits] == [(None, boxes)]
    assert "other.png" in unseen.window.engine.snapshot().message.text


def test_a_batch_relights_who_is_chosen_in_a_photo_and_everyone_in_the_others(opened, photo_path, relighter, tmp_path):
    other = photo_path.with_name("other.png")
    other.write_bytes(photo_path.read_bytes())
    opened.key(glfw.KEY_F, shift=True)
    drag_on_the_photo(opened, (6, 70), (26, 90))
    opened.window.state.choose_face(1)
    opened.settle()
    relighter.portraits.clear()
    opened.window._deeds._outputs.batch_over([photo_path, other], tmp_path / "relit")
    opened.settle()
    opened.window.exporter.close()
    assert [(index, len(boxes)) for _, index, boxes in relighter.portraits] == [(1, 2), (None, 1)]


def test_boxes_are_moved_resized_added_and_removed_one_step_each(opened):
    state = opened.window.state
    (found,) = state.snapshot.faces
    opened.key(glfw.KEY_F, shift=True)
    assert state.faces.selected == 0, "the only one"
    drag_on_the_photo(opened, (64, 48), (70, 44))
    drag_on_the_photo(opened, (102, 76), (82, 56))
    drag_on_the_photo(opened, (6, 70), (26, 90))
    np.testing.assert_allclose(edges(state.photo.boxes[0]), (38, 12, 82, 56), atol=2)
    np.testing.assert_allclose(edges(state.photo.boxes[1]), (6, 70, 26, 90), atol=2)
    assert state.faces.selected == 1
    opened.key(glfw.KEY_DELETE)
    assert len(state.photo.boxes) == 1
    names = [step.name for step in state.history.steps]
    assert names[1:] == ["Move face 1", "Resize face 1", "Add face 2", "Remove face 2"]
    opened.key(glfw.KEY_ESCAPE)
    assert state.photo.boxes is None
    assert state.snapshot.faces == (found,)
    assert state.view.zoom == 1.0, "and the picture stayed where it was"


def test_nothing_is_computed_before_the_hand_lets_go_and_escape_forgets_the_drag(opened, relighter):
    state = opened.window.state
    opened.key(glfw.KEY_F, shift=True)
    portraits, relights = len(relighter.portraits), len(relighter.relights)
    opened.move(on_the_screen(opened, 64, 48))
    opened.button(True)
    for x in (70, 80, 90):
        opened.move(on_the_screen(opened, x, 48))
        opened.settle()
    assert state.faces.moving[0].x0 == pytest.approx(58, abs=2)
    assert (len(relighter.portraits), len(relighter.relights)) == (portraits, relights)
    opened.key(glfw.KEY_ESCAPE)
    opened.button(False)
    opened.settle()
    assert state.faces.is_open
    assert state.photo.boxes is None
    assert len(relighter.portraits) == portraits


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_boxes_follow_the_mouse_at_any_zoom_and_scale(opened, scale):
    state = opened.window.state
    opened.window._graphics.binding.set_scale(scale)
    # At twice the scale the panels leave no room for the card beside the face.
    state.panels = state.panels.all_shown(False)
    opened.key(glfw.KEY_F, shift=True)
    state.view = type(state.view)(False, 2.5, 60.0, 40.0)
    drag_on_the_photo(opened, (64, 48), (74, 52))
    np.testing.assert_allclose(edges(state.photo.boxes[0]), (42, 20, 106, 84), atol=0.5)


def test_beside_the_photo_both_pictures_take_the_mouse(opened):
    state = opened.window.state
    opened.key(glfw.KEY_F, shift=True)
    opened.key(glfw.KEY_Y)
    opened.see_every_pixel()
    drag_on_the_photo(opened, (64, 48), (70, 48), pane=0)
    drag_on_the_photo(opened, (70, 48), (80, 48), pane=1)
    np.testing.assert_allclose(edges(state.photo.boxes[0]), (48, 16, 112, 80), atol=1.5)


def test_the_wipe_can_be_moved_across_a_face_while_its_box_can_too(opened):
    state = opened.window.state
    opened.key(glfw.KEY_F, shift=True)
    opened.key(glfw.KEY_W)
    opened.see_every_pixel()
    drag_on_the_photo(opened, (64, 40), (90, 40))
    assert state.look.wipe_at == pytest.approx(90 / 128, abs=0.02)
    assert state.photo.boxes is None
    drag_on_the_photo(opened, (50, 40), (56, 40))
    assert state.photo.boxes[0].x0 == pytest.approx(38, abs=1.5)


def test_the_wheel_button_moves_the_picture_while_the_left_one_draws(opened):
    state = opened.window.state
    opened.key(glfw.KEY_F, shift=True)
    before = state.view
    opened.move(on_the_screen(opened, 10, 10))
    opened.window.on_mouse_button(None, glfw.MOUSE_BUTTON_MIDDLE, glfw.PRESS, 0)
    opened.frames(2)
    opened.move(on_the_screen(opened, 30, 10))
    opened.window.on_mouse_button(None, glfw.MOUSE_BUTTON_MIDDLE, glfw.RELEASE, 0)
    opened.frames(2)
    assert state.view.centre_x == pytest.approx(before.centre_x - 20, abs=1)
    assert state.photo.boxes is None


def test_what_is_said_about_the_boxes_covers_none(opened):
    state = opened.window.state
    opened.key(glfw.KEY_F, shift=True)
    opened.frames(2)
    assert state.look.covered > 0, "at the top, where no box is"
    height = state.look.viewport_px[1]
    state.view = type(state.view)(False, 1.0, 64.0, 48.0 + height / 2 - 60)
    opened.frames(2)
    assert state.look.covered == 0, "at the foot"


@pytest.mark.parametrize("tool", [face_edits, brush_edits])
def test_the_panels_button_for_a_highlight_puts_the_tool_over_the_picture_away(opened, buttons, tool):
    state = opened.window.state
    tool.show(state)
    opened.frames(2)
    opened.click(buttons["Highlight"])
    opened.click((opened.centre()[0] + 20, opened.centre()[1] + 10))
    opened.settle()
    assert len(state.light_edit.boxes) == 1
    assert not state.faces.is_open
    assert not state.brush.is_open


def test_a_lamp_that_was_to_be_placed_is_not_on_the_next_photo(opened, relighter, photo_path):
    opened.key(glfw.KEY_K)
    assert opened.window.state.aim.target == "highlight"
    relighter.blind = True
    opened.drop(shutil.copy(photo_path, photo_path.with_name("other.png")))
    assert opened.window.state.faces.is_open
    assert opened.window.state.aim.target == ""
