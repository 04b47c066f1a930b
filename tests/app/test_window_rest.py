"""When the window rests, and what it shows before it does."""

import contextlib
import signal
import time
from types import SimpleNamespace

import glfw
import pytest
from imgui_bundle import imgui

from app.window.rest import Rest


@pytest.fixture
def rests(opened, monkeypatch):
    """What the window's loop waited for; waiting takes no time but the clock's. The loop ends when it sleeps.

    Put callables into `rests.happens` for what a user does after so many waits.
    """
    clock, rests = [time.monotonic()], SimpleNamespace(waits=[], happens={})

    def wait_events():
        rests.waits.append("asleep")
        glfw.set_window_should_close(opened.window.handle, True)

    def wait_events_timeout(seconds):
        happens = rests.happens.pop(len(rests.waits), None)
        rests.waits.append("ticking")
        clock[0] += 0.1 * seconds if happens else seconds
        if happens:
            happens()

    fake = SimpleNamespace(monotonic=lambda: clock[0], sleep=lambda seconds: None)
    monkeypatch.setattr("app.window.rest.time", fake)
    monkeypatch.setattr("app.window.frame_limit.time", fake)
    # What the display itself has to say, such as who has the keyboard, comes at moments of its own.
    monkeypatch.setattr(glfw, "poll_events", lambda: None)
    monkeypatch.setattr(glfw, "wait_events", wait_events)
    monkeypatch.setattr(glfw, "wait_events_timeout", wait_events_timeout)
    return rests


def test_at_rest_the_window_sleeps_until_something_happens(opened, rests):
    opened.window.run()
    assert rests.waits[-1] == "asleep"
    assert rests.waits.count("asleep") == 1
    assert len(rests.waits) < 40


def test_a_question_that_typing_led_to_is_seen_before_the_window_sleeps(opened, rests, monkeypatch):
    state = opened.window.state
    monkeypatch.setattr(opened.window._deeds._dialogs, "_has_native", False)
    opened.key(glfw.KEY_E, ctrl=True)
    state.picking.start.write_bytes(b"in the way")

    def enter():
        assert state.picking is not None
        for action in (glfw.PRESS, glfw.RELEASE):
            opened.window.on_key(None, glfw.KEY_ENTER, 0, action, 0)

    rests.happens[60] = enter
    opened.window.run()
    assert len(rests.waits) > 60
    assert len(state.asking.questions) == 1
    assert state.look.covered > 0, "the card has been drawn"


def test_the_window_does_not_rest_while_keys_wait_to_be_told(opened, rests):
    window = opened.window
    for action in (glfw.PRESS, glfw.RELEASE) * 3:
        window.on_key(None, glfw.KEY_W, 0, action, 0)
    opened.frames(1)
    assert window._graphics.binding.has_more(), "a frame takes in one event of a key"
    while window._graphics.binding.has_more():
        window._wait()
        opened.frames(1)
    assert rests.waits == []
    assert window.state.look.compare == "wipe"
    window._wait()
    assert rests.waits == ["ticking"]


def test_keys_reach_their_window_while_another_one_s_panels_live(request):
    other = imgui.create_context()
    imgui.set_current_context(other)
    opened = request.getfixturevalue("opened")
    try:
        opened.key(glfw.KEY_W)
        assert opened.window.state.look.compare == "wipe"
        for action in (glfw.PRESS, glfw.RELEASE) * 2:
            opened.window.on_key(None, glfw.KEY_W, 0, action, 0)
        assert opened.window._graphics.binding.has_more()
    finally:
        imgui.destroy_context(other)


def test_a_rotation_that_plays_stands_still_in_a_minimised_window_which_sleeps(opened, rests):
    opened.window.state.playing = True
    opened.frames(2)
    yaw_deg = opened.window.state.edit.yaw_deg
    assert yaw_deg != 0.0
    opened.window.on_minimise(None, True)
    opened.window.on_key(None, glfw.KEY_W, 0, glfw.PRESS, 0)
    opened.window.run()
    assert rests.waits[-1] == "asleep"
    assert len(rests.waits) < 60
    assert opened.window.state.edit.yaw_deg == yaw_deg
    opened.window.on_minimise(None, False)
    opened.frames(2)
    assert opened.window.state.edit.yaw_deg != yaw_deg
    assert opened.window.state.look.compare == "wipe", "the key is told as soon as there is a panel to tell"


def test_what_is_told_while_the_window_is_minimised_is_news_when_it_comes_back(opened, monkeypatch):
    window, now_s = opened.window, [1000.0]
    monkeypatch.setattr("app.window.window.time", SimpleNamespace(monotonic=lambda: now_s[0]))

    def is_told(frames):
        for _ in range(frames):
            now_s[0] += 0.2
            window.frame()
        return window.state.message() is not None

    window.on_minimise(None, True)
    window.state.asking.tell("Saved me.png")
    assert is_told(frames=100)
    window.on_minimise(None, False)
    assert is_told(frames=30)
    assert not is_told(frames=20)


def test_a_window_at_rest_hears_that_the_program_is_to_end(opened, rests):
    def interrupt():
        # What a callback of the window system raises is lost.
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    rests.happens[10] = interrupt
    with pytest.raises(KeyboardInterrupt):
        opened.window.run()
    assert len(rests.waits) == 11


def test_a_window_that_has_something_to_look_at_now_and_then_does_not_sleep(monkeypatch):
    rest, later = Rest(), time.monotonic() + 10
    monkeypatch.setattr("app.window.rest.time", SimpleNamespace(monotonic=lambda: later))
    assert rest.is_deep(playing=False, typing=False, waiting=False)
    for busy in ("playing", "typing", "waiting"):
        assert not rest.is_deep(**{"playing": False, "typing": False, "waiting": False, busy: True})
