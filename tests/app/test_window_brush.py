"""The real window: the outline corrected with the brush, taken back, saved and handed on."""

import glfw
import numpy as np
import pytest
from imgui_bundle import imgui
from test_window_faces import drag_on_the_photo, on_the_screen

from app.document.session_file import read_session
from app.ui import brush_edits
from app.ui.viewport.tool_card import Button, _row_width, _rows
from relight_core.imaging.read import read_photo
from relight_core.imaging.view_transform import apply_view
from relight_core.imaging.write import write_image

GREEN, RED = (89, 217, 115), (242, 89, 82)


@pytest.fixture
def brush(opened):
    """A photo at one screen pixel for each of its own, and the brush taken up."""
    opened.see_every_pixel()
    opened.key(glfw.KEY_O, shift=True)
    assert opened.window.state.brush.is_open
    return opened


def alt_drag_on_the_photo(hand, start, end):
    hand.hold(glfw.KEY_LEFT_ALT, glfw.MOD_ALT)
    hand.move(on_the_screen(hand, *start))
    for at, action in ((start, glfw.PRESS), (end, glfw.RELEASE)):
        hand.move(on_the_screen(hand, *at))
        hand.window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, action, glfw.MOD_ALT)
        hand.frames(2)
    hand.release(glfw.KEY_LEFT_ALT)
    hand.settle()


def has_colour(pixels, colour):
    """Whether some pixel is nearly of a colour, as a thin line is at its middle."""
    return bool((np.abs(pixels.astype(float) - colour).max(-1) < 30).any())


def is_amber_in(pixels):
    """Whether a line of the outline's colour crosses pixels that are nearly grey."""
    return bool((pixels[..., 0].astype(int) - pixels[..., 2]).max() > 70)


def test_what_is_painted_reaches_the_relighter_one_step_each_and_is_saved(brush, relighter, photo_path):
    state = brush.window.state
    drag_on_the_photo(brush, (20, 20), (60, 30))
    alt_drag_on_the_photo(brush, (90, 80), (100, 80))
    added, taken = state.photo.strokes
    assert relighter.strokes == (added, taken)
    np.testing.assert_allclose([added.points[0], added.points[-1]], [(20, 20), (60, 30)], atol=1.5)
    assert (added.adds, taken.adds) == (True, False)
    names = [step.name for step in state.history.steps]
    assert names[1:] == ["Add to the person", "Take from the person"]
    brush.key(glfw.KEY_S, ctrl=True)
    saved = read_session(photo_path.with_name("person.relight.json")).document
    assert saved == state.document()
    brush.key(glfw.KEY_Z, ctrl=True)
    assert relighter.strokes == (added,)
    assert state.photo.strokes == (added,)


def test_escape_puts_the_outline_back_and_enter_keeps_it(brush, relighter):
    state = brush.window.state
    drag_on_the_photo(brush, (20, 20), (60, 30))
    brush.key(glfw.KEY_ENTER)
    assert not state.brush.is_open
    kept = state.photo.strokes
    assert len(kept) == 1
    brush.key(glfw.KEY_O, shift=True)
    drag_on_the_photo(brush, (20, 60), (60, 70))
    brush.key(glfw.KEY_ESCAPE)
    brush.settle()
    assert state.photo.strokes == relighter.strokes == kept
    assert not state.brush.is_open


def test_x_turns_the_brush_over_and_its_colour_shows_it(brush):
    state = brush.window.state
    spot = on_the_screen(brush, 64, 80)
    radius = state.brush.radius_em * imgui.get_font_size()
    row, column = round(spot[1]), round(spot[0] + radius)
    for colour, other in ((GREEN, RED), (RED, GREEN)):
        brush.move(spot)
        ring = brush.window.screenshot()[row - 2 : row + 3, column - 3 : column + 4]
        assert has_colour(ring, colour)
        assert not has_colour(ring, other)
        brush.key(glfw.KEY_X)


def test_the_outline_is_drawn_and_gone_with_the_tool(brush, relighter):
    relighter.outline = [np.array([(40, 30), (90, 30), (90, 70), (40, 70)], np.float32)]
    brush.move(brush.centre())
    brush.wheel(1)
    brush.settle()
    brush.move((brush.width / 2, brush.height - 3))
    x, y = on_the_screen(brush, 65, 30)
    line = slice(round(y) - 2, round(y) + 3), slice(round(x) - 5, round(x) + 5)
    assert is_amber_in(brush.window.screenshot()[line])
    brush.key(glfw.KEY_ENTER)
    assert not is_amber_in(brush.window.screenshot()[line])


@pytest.mark.parametrize("zoom", [1.0, 4.0])
def test_the_brush_is_as_wide_on_the_screen_at_any_zoom(brush, zoom):
    state = brush.window.state
    state.view = type(state.view)(False, zoom, 64.0, 48.0)
    drag_on_the_photo(brush, (60, 44), (66, 48))
    assert state.photo.strokes[0].radius_px * zoom == pytest.approx(1.2 * 15.0, rel=0.02)


def test_painting_moves_no_picture_and_the_wheel_still_turns_the_light(brush):
    state = brush.window.state
    view, yaw_deg = state.view, state.edit.yaw_deg
    drag_on_the_photo(brush, (20, 20), (60, 30))
    assert state.view == view
    brush.wheel(1)
    assert state.edit.yaw_deg != yaw_deg


def test_nothing_is_computed_before_the_brush_is_lifted(brush, relighter):
    portraits, relights = len(relighter.portraits), len(relighter.relights)
    brush.move(on_the_screen(brush, 30, 30))
    brush.button(True)
    for x in (40, 50, 60):
        brush.move(on_the_screen(brush, x, 30))
        brush.settle()
    assert len(brush.window.state.brush.painting.points) > 2
    assert (len(relighter.portraits), len(relighter.relights)) == (portraits, relights)
    brush.key(glfw.KEY_ESCAPE)
    brush.button(False)
    brush.settle()
    assert brush.window.state.photo.strokes == ()
    assert len(relighter.portraits) == portraits


def test_a_batch_takes_the_strokes_of_a_photo_for_that_photo_only(brush, photo_path, relighter, tmp_path, monkeypatch):
    other = photo_path.with_name("other.png")
    other.write_bytes(photo_path.read_bytes())
    drag_on_the_photo(brush, (20, 20), (60, 30))
    strokes, seen, set_portrait = brush.window.state.photo.strokes, [], relighter.set_portrait

    def noting(photo, *asked):
        seen.append(asked[2])
        set_portrait(photo, *asked)

    monkeypatch.setattr(relighter, "set_portrait", noting)
    brush.window._deeds._outputs.batch_over([photo_path, other], tmp_path / "relit")
    brush.settle()
    brush.window.exporter.close()
    assert seen == [strokes, ()]


def test_a_stroke_is_in_sight_until_the_picture_has_it(brush, relighter):
    relighter.gate.clear()
    brush.move(on_the_screen(brush, 20, 20))
    brush.button(True)
    brush.move(on_the_screen(brush, 60, 20))
    brush.button(False)
    brush.move((brush.width / 2, brush.height - 3))
    x, y = (round(part) for part in on_the_screen(brush, 40, 20))
    painted = brush.window.screenshot()[y, x].astype(float)
    relighter.gate.set()
    brush.settle()
    brush.frames(2)
    bare = brush.window.screenshot()[y, x].astype(float)
    assert painted[1] - painted[0] > bare[1] - bare[0] + 20, "greener"


def test_the_photo_below_the_brush_is_the_photo(brush, photo_path):
    brush.key(glfw.KEY_1)
    shown = brush.picture_pixels(96, 128)
    assert np.abs(shown - apply_view(read_photo(photo_path).linear) * 255).max() <= 1


def test_no_outline_of_the_photo_before_lies_over_the_next(brush, relighter, tmp_path):
    state = brush.window.state
    relighter.outline = [np.array([[10, 10], [60, 10], [60, 60]], float)]
    brush.key(glfw.KEY_X)
    brush.key(glfw.KEY_ENTER)
    write_image(tmp_path / "other.png", np.full((96, 128, 3), 0.2, np.float32))
    relighter.gate.clear()
    brush.window.on_drop(None, [str(tmp_path / "other.png")], brush.centre())
    while state.snapshot.opened.source is not state.photo:
        brush.frames()
    brush.hold(glfw.KEY_O, glfw.MOD_SHIFT)
    brush.release(glfw.KEY_O)
    brush.frames(2)
    outline, is_open = list(state.brush.outline), state.brush.is_open
    relighter.gate.set()
    brush.settle()
    assert is_open
    assert outline == []


def test_a_stroke_painted_just_before_a_photo_that_is_refused_stays(brush, tmp_path):
    state = brush.window.state
    (tmp_path / "bad.jpg").write_bytes(b"no picture")
    brush_edits.begin(state, (20, 20), 8, True)
    brush_edits.lift(state)
    (stroke,) = state.photo.strokes
    state.remember(1e9)
    state.open_photo(tmp_path / "bad.jpg")
    brush.settle()
    assert state.photo.strokes == (stroke,) == state.snapshot.opened.source.strokes
    assert state.history.steps[-1].name == "Add to the person"


def test_the_brush_is_not_taken_up_for_a_photo_that_may_not_come(brush, tmp_path):
    """Esc would put back the outline of that one."""
    state = brush.window.state
    drag_on_the_photo(brush, (20, 20), (60, 30))
    brush.key(glfw.KEY_ENTER)
    strokes = state.photo.strokes
    (tmp_path / "bad.jpg").write_bytes(b"no picture")
    state.open_photo(tmp_path / "bad.jpg")
    brush_edits.show(state)
    brush.settle()
    brush.key(glfw.KEY_ESCAPE)
    assert state.photo.strokes == strokes != ()


@pytest.mark.parametrize(("room", "labels"), [(1000, [4]), (250, [3, 1]), (150, [2, 2]), (1, [1, 1, 1, 1])])
def test_the_card_has_all_its_buttons_in_a_narrow_viewport(brush, room, labels):
    buttons = [Button(label, "", print) for label in ("Take away", "-", "As found", "Done")]
    rows = _rows(buttons, room)
    assert [len(row) for row in rows] == labels
    assert [button for row in rows for button in row] == buttons
    assert all(_row_width(row) <= room or len(row) == 1 for row in rows)
