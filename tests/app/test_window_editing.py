"""The real window: a photo opened, its light turned and added to, undone, saved, exported."""

import glfw
import numpy as np
from PIL import Image

from app.document.session_file import read_session
from relight_core.imaging.write import write_image
from relight_core.lighting.soft_box import SoftBox
from relight_core.lighting.sphere import uv_of
from relight_core.lighting.summary import average_direction


def test_open_turn_slide_undo_save_and_export(opened, photo_path):
    state = opened.window.state
    opened.light("split")
    first = opened.picture_pixels(96, 128)
    opened.drag(opened.panorama(0.25), opened.panorama(0.75))
    turned = opened.picture_pixels(96, 128)
    yaw_deg = state.edit.yaw_deg
    opened.drag(opened.knobs()[0], (opened.width, opened.knobs()[0][1]))
    assert state.edit.shadow > 1.5
    names = [step.name for step in state.history.steps]
    assert names[:2] == ["Open person.png", "Light: Split"]
    assert names[2] == f"Turn light to {round(yaw_deg)}°".replace("-", "\N{MINUS SIGN}")
    assert len(names) == 4
    opened.key(glfw.KEY_Z, ctrl=True)
    assert state.edit.shadow == 1.0
    assert np.array_equal(opened.picture_pixels(96, 128), turned)
    opened.key(glfw.KEY_Z, ctrl=True)
    assert np.array_equal(opened.picture_pixels(96, 128), first)
    opened.key(glfw.KEY_Y, ctrl=True)
    assert state.edit.yaw_deg == yaw_deg
    opened.key(glfw.KEY_S, ctrl=True)
    assert read_session(photo_path.with_name("person.relight.json")).document == state.document()
    assert not state.is_unsaved()
    opened.key(glfw.KEY_E)
    opened.window.exporter.close()
    with Image.open(photo_path.with_name("person-relit.png")) as saved:
        assert np.abs(np.asarray(saved.convert("RGB"), int) - opened.picture_pixels(96, 128)).max() <= 1
        assert float(saved.text["relightYawDeg"]) == yaw_deg


def test_keys_let_go_within_one_frame_are_still_a_chord(opened):
    state, window = opened.window.state, opened.window
    opened.light("split")
    fits = state.view
    window.on_key(None, glfw.KEY_LEFT_CONTROL, 0, glfw.PRESS, 0)
    opened.frames(1)
    window.on_key(None, glfw.KEY_Z, 0, glfw.PRESS, glfw.MOD_CONTROL)
    window.on_key(None, glfw.KEY_LEFT_CONTROL, 0, glfw.RELEASE, glfw.MOD_CONTROL)
    window.on_key(None, glfw.KEY_Z, 0, glfw.RELEASE, 0)
    window.on_key(None, glfw.KEY_W, 0, glfw.PRESS, 0)
    window.on_key(None, glfw.KEY_W, 0, glfw.RELEASE, 0)
    opened.frames(5)
    opened.settle()
    assert state.light.name == "rembrandt", "Ctrl + Z undid"
    assert state.view == fits, "and was no Z"
    assert state.look.compare == "wipe", "nor was the W after it a Ctrl + W"


def test_a_drag_that_took_no_longer_than_a_frame_reaches_as_far_as_the_hand(opened):
    state, window = opened.window.state, opened.window
    x, y = opened.knobs()[0]
    opened.move((x, y))

    def quickly(start, *path):
        window.on_mouse_move(None, *start)
        window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, 0)
        for place in path:
            window.on_mouse_move(None, *place)
        window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE, 0)
        opened.frames(4)
        opened.settle()

    quickly((x, y), (x + 30, y), (opened.width, y))
    assert state.edit.shadow == 2.0
    quickly(opened.panorama(0.25), opened.panorama(0.5))
    assert abs(state.edit.yaw_deg - 90.0) < 1.0
    opened.move(opened.centre())
    assert abs(state.edit.yaw_deg - 90.0) < 1.0, "and the hand has let go"


def test_a_press_that_comes_with_a_key_and_a_movement_begins_where_it_was_pressed(opened):
    x, y = opened.centre()
    opened.key(glfw.KEY_F)
    opened.move((x - 100, y - 80))
    window = opened.window
    # All of it while one frame was made.
    window.on_key(None, glfw.KEY_F9, 0, glfw.PRESS, 0)
    window.on_key(None, glfw.KEY_F9, 0, glfw.RELEASE, 0)
    window.on_mouse_move(None, x, y)
    window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, 0)
    opened.frames(6)
    window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE, 0)
    opened.frames(2)
    assert window.state.view.fit


def test_the_highlight_on_the_ball_follows_the_hand(opened):
    state = opened.window.state
    opened.frames(2)

    def from_the_right():
        return average_direction(state.snapshot.light.environment, state.edit.yaw_deg)[0]

    before, (x, y) = from_the_right(), state.look.ball_at
    opened.drag((x, y), (x - 12, y))
    assert from_the_right() < before - 0.1
    far = state.edit.yaw_deg
    opened.drag((x, y), (x + 12, y))
    assert abs(state.edit.yaw_deg) < 1e-6
    opened.hold(glfw.KEY_LEFT_SHIFT, glfw.MOD_SHIFT)
    opened.window.on_mouse_move(None, x, y)
    opened.window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, glfw.MOD_SHIFT)
    opened.window.on_mouse_move(None, x - 12, y)
    opened.window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE, glfw.MOD_SHIFT)
    opened.frames(5)
    opened.release(glfw.KEY_LEFT_SHIFT)
    assert abs(state.edit.yaw_deg - 0.2 * far) < 0.01


def test_a_soft_box_is_added_moved_and_deleted_on_the_panorama(opened):
    state = opened.window.state
    opened.double_click(opened.panorama(0.5))
    (box,) = state.light_edit.boxes
    assert abs(abs(box.azimuth_deg) - 180.0) < 3.0
    assert opened.window.engine.snapshot().light.edit == state.light_edit
    u, _ = uv_of(box.direction)
    opened.drag(opened.panorama(u), opened.panorama(u + 0.25))
    (moved,) = state.light_edit.boxes
    assert abs(moved.azimuth_deg - 90.0) < 4.0
    assert state.edit.yaw_deg == 0.0
    opened.key(glfw.KEY_DELETE)
    assert state.light_edit.boxes == ()
    opened.key(glfw.KEY_Z, ctrl=True)
    assert state.light_edit.boxes == (moved,)


def test_a_lights_own_lamp_is_moved_and_put_back(opened):
    state = opened.window.state
    opened.light("split")
    split = opened.picture_pixels(96, 128).astype(int)
    opened.key(glfw.KEY_M)
    assert [box.name for box in state.light_edit.boxes] == ["key"]
    assert np.abs(opened.picture_pixels(96, 128) - split).max() <= 1
    opened.drag(opened.panorama(0.75), opened.panorama(0.25))
    assert abs(state.light_edit.boxes[0].azimuth_deg + 90.0) < 4.0
    assert state.edit.yaw_deg == 0.0
    assert average_direction(opened.window.engine.snapshot().light.environment)[0] < -0.4
    assert [step.name for step in state.history.steps[-2:]] == ["Take the light's lamps apart", "Move key"]
    opened.key(glfw.KEY_M)
    assert state.light_edit.boxes == ()
    assert np.array_equal(opened.picture_pixels(96, 128), split)


def test_a_click_on_the_face_places_a_lamp_and_the_picture_answers(opened):
    state = opened.window.state
    before = opened.picture_pixels(96, 128).astype(float)
    opened.key(glfw.KEY_B)
    assert state.aim.target == "bright"
    opened.click((opened.centre()[0] + 20, opened.centre()[1] + 10))
    opened.settle()
    assert state.aim.target == ""
    (box,) = state.light_edit.boxes
    assert box != SoftBox()
    assert box.direction[0] > 0.2
    assert np.abs(opened.picture_pixels(96, 128) - before).max() > 5


def test_a_click_on_a_photo_that_is_not_relit_yet_reads_no_face_of_the_photo_before(opened, relighter, tmp_path):
    state = opened.window.state
    write_image(tmp_path / "other.png", np.full((96, 128, 3), 0.2, np.float32))
    relighter.gate.clear()
    opened.window.on_drop(None, [str(tmp_path / "other.png")], opened.centre())
    while state.snapshot.opened.source is not state.photo:
        opened.frames()
    opened.hold(glfw.KEY_B)
    opened.release(glfw.KEY_B)
    opened.click((opened.centre()[0] + 20, opened.centre()[1] + 10))
    assert state.light_edit.boxes == ()
    assert "still being relit" in state.message().text
    relighter.gate.set()
    opened.settle()
    opened.click((opened.centre()[0] + 20, opened.centre()[1] + 10))
    opened.settle()
    assert len(state.light_edit.boxes) == 1


def test_a_click_beside_the_face_tells_so_and_lets_one_try_again(opened):
    state = opened.window.state
    opened.key(glfw.KEY_K)
    beside, on_it = opened.centre(), (opened.centre()[0] + 20, opened.centre()[1] + 10)
    opened.click((beside[0], beside[1] - 31))
    opened.settle()
    assert state.light_edit.boxes == ()
    assert state.aim.target == "highlight"
    assert "no face there" in state.message().text
    opened.click(on_it)
    opened.settle()
    assert len(state.light_edit.boxes) == 1
    assert state.message() is None
    assert state.aim.target == ""


def test_what_a_click_beside_the_face_was_told_leaves_with_the_tool(opened):
    state = opened.window.state
    opened.key(glfw.KEY_K)
    opened.click((opened.centre()[0], opened.centre()[1] - 31))
    opened.settle()
    assert "no face there" in state.message().text
    opened.key(glfw.KEY_ESCAPE)
    assert state.aim.target == ""
    assert state.message() is None
