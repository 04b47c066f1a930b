"""The rotation that plays by itself is no hand on a control."""

import glfw


def test_what_is_set_while_the_rotation_plays_is_a_step_at_once_and_the_turn_one_at_its_end(opened):
    state = opened.window.state
    state.playing = True
    opened.frames(3)
    state.change(shadow=0.3)
    opened.frames(3)
    assert state.edit.yaw_deg != 0.0
    assert not state.hand_on_control
    assert state.is_moving
    assert [step.name for step in state.history.steps] == ["Open person.png", "Shadow 0.30"]
    state.change(yaw_deg=40.0)
    state.playing = False
    opened.settle()
    assert [step.name for step in state.history.steps][2:] == ["Turn light to 40°"]


def test_a_light_that_was_put_back_turns_no_further(opened):
    state = opened.window.state
    state.change(yaw_deg=40.0)
    state.playing = True
    opened.frames(3)
    opened.key(glfw.KEY_R, ctrl=True)
    opened.frames(3)
    assert (state.playing, state.edit.yaw_deg) == (False, 0.0)


def test_a_turn_that_is_undone_ends_the_playing_and_any_other_step_does_not(opened):
    state = opened.window.state
    state.change(yaw_deg=40.0)
    opened.settle()
    state.change(shadow=0.3)
    opened.settle()
    state.playing = True
    opened.frames(3)
    for playing in (True, False):
        opened.hold(glfw.KEY_Z, glfw.MOD_CONTROL)
        opened.release(glfw.KEY_Z)
        assert state.playing == playing
    opened.frames(3)
    assert (state.edit.yaw_deg, state.edit.shadow) == (0.0, 1.0)
    opened.key(glfw.KEY_Y, ctrl=True)
    assert (state.edit.yaw_deg, state.edit.shadow) == (40.0, 1.0)
