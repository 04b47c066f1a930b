"""While a hand moves something the viewport is drawn between two frames, where the processor draws."""

from dataclasses import replace

import numpy as np
import pytest

from app.ui.pictures import Paint
from app.ui.viewport.panes import arrange_panes
from app.window.gl_recipe import RelitSlot

SIZE = (500, 400)


class Frames:
    """Frames of the pictures alone, without panels."""

    def __init__(self, hand):
        self.pictures, self.state = hand.window.pictures, hand.window.state
        self.draw()
        self.pictures.draw_ahead()

    def draw(self, brightness=None, exposure_ev=0.0, hurried=True):
        """One frame; `brightness` is that of a new picture."""
        snapshot = self.state.snapshot
        self.pictures.begin_frame(exposure_ev, hurried)
        if brightness is not None:
            even = np.full_like(snapshot.picture.screen, brightness)
            self.pictures.update(replace(snapshot, picture=replace(snapshot.picture, screen=even)))
        panes = arrange_panes(self.state, SIZE).panes
        self.shown = self.pictures.viewport(panes, SIZE, Paint())
        return self.middle()

    def middle(self):
        pixels = self.pictures.viewport_pixels()
        return int(pixels[pixels.shape[0] // 2, pixels.shape[1] // 2, 0])


@pytest.fixture
def frames(opened):
    return Frames(opened)


def test_a_new_picture_waits_until_the_frame_is_shown_and_is_in_the_next(frames):
    before = frames.middle()
    assert frames.draw(brightness=1.0) == before
    assert frames.pictures.draw_ahead()
    assert frames.pictures.is_ahead
    assert frames.middle() == 255
    assert frames.draw() == 255
    assert not frames.pictures.is_ahead
    assert not frames.pictures.draw_ahead()


def test_of_pictures_that_come_in_every_frame_each_is_seen(frames):
    seen = []
    for brightness in (1.0, 0.0, 1.0):
        frames.draw(brightness)
        frames.pictures.draw_ahead()
        seen.append(frames.middle())
    assert seen == [255, 0, 255]


def test_what_the_shader_alone_answers_is_drawn_at_once(frames):
    frames.draw(brightness=0.2)
    frames.pictures.draw_ahead()
    dark = frames.middle()
    assert frames.draw(exposure_ev=1.0) > dark + 20
    assert not frames.pictures.draw_ahead()


def test_at_rest_everything_is_drawn_at_once_and_nothing_is_left_over(frames):
    frames.draw(brightness=1.0)
    assert frames.draw(hurried=False) == 255
    assert not frames.pictures.draw_ahead()


def test_the_window_shows_in_a_second_frame_what_was_drawn_ahead(opened, relighter):
    window = opened.window
    window.state.hand_on_control = True
    opened.frames()
    window.state.change(yaw_deg=120.0)
    window.state.hand_on_control = True
    opened.frames()
    assert window.engine.wait_until_idle(60)
    window.state.hand_on_control = True
    opened.frames()
    assert window.pictures.is_ahead
    window.state.hand_on_control = True
    opened.frames()
    assert not window.pictures.is_ahead


def test_the_result_s_textures_are_told_whether_a_hand_is_moving_it(opened, monkeypatch):
    told = []
    monkeypatch.setattr(RelitSlot, "show", lambda _slot, _screen, passing=False: told.append(passing) or False)
    snapshot = opened.window.state.snapshot
    for channels in ((), None):
        edit = replace(snapshot.picture.edit, channels=channels)
        opened.window.pictures.update(replace(snapshot, picture=replace(snapshot.picture, edit=edit)))
    assert told == [True, False]
