"""Looking at pictures in the real window: keys, panels, zoom, comparisons and overlays, judged by pixels."""

import time
from dataclasses import replace

import glfw
import numpy as np
import pytest
from PIL import Image
from window_hand import HEIGHT, WIDTH, Hand, close_to

from app.ui.channels import PHOTO, RESULT
from app.ui.panels.status_line import _under_the_mouse
from app.ui.viewport import placing, viewport_notes
from app.ui.viewport.probe import reading
from app.window import gl_pictures
from app.window.window import EditorWindow


def test_the_panels_can_be_hidden_and_resized_and_are_remembered(display, relighter, tmp_path):
    path = tmp_path / "settings" / "settings.json"
    window = EditorWindow(lambda: relighter, size=(WIDTH, HEIGHT), settings_path=path)
    hand = Hand(window, (WIDTH, HEIGHT))
    width = hand.viewport_width()
    hand.drag((255, 300), (305, 300))
    assert hand.viewport_width() == width - 50
    hand.key(glfw.KEY_F8)
    assert hand.viewport_width() == width - 50 + 240
    hand.key(glfw.KEY_TAB)
    assert hand.viewport_width() == WIDTH
    hand.key(glfw.KEY_TAB)
    window.close()
    again = EditorWindow(lambda: relighter, size=(WIDTH, HEIGHT), settings_path=path)
    try:
        hand = Hand(again, (WIDTH, HEIGHT))
        hand.settle()
        assert hand.viewport_width() == WIDTH - 305
        hand.key(glfw.KEY_F8)
        assert hand.viewport_width() == width - 50
        hand.double_click((305, 300))
        assert hand.viewport_width() == width
    finally:
        again.close()


def test_zooming_keeps_the_spot_under_the_mouse_and_z_shows_every_pixel_there(opened):
    x, y = opened.centre()
    at = (x + 90, y - 60)
    opened.key(glfw.KEY_F)
    opened.move(at)
    spot = opened.window.state.look.spot
    opened.wheel(5, ctrl=True)
    assert opened.window.state.look.spot == pytest.approx(spot, abs=0.7)
    opened.key(glfw.KEY_Z)
    assert opened.window.state.view.zoom == 1.0
    assert opened.window.state.look.spot == pytest.approx(spot, abs=1.5)
    opened.key(glfw.KEY_Z)
    assert opened.window.state.view.fit


def test_plus_and_minus_zoom_about_the_mouse(opened):
    x, y = opened.centre()
    opened.move((x - 40, y + 30))
    spot, zoom = opened.window.state.look.spot, opened.window.state.view.zoom
    opened.key(glfw.KEY_EQUAL)
    assert opened.window.state.view.zoom == pytest.approx(1.2 * zoom)
    opened.move((x - 40, y + 30))
    assert opened.window.state.look.spot == pytest.approx(spot, abs=1.0)
    opened.key(glfw.KEY_MINUS)
    assert opened.window.state.view.zoom == pytest.approx(zoom)


def test_every_number_key_shows_its_picture(opened):
    names = ["photo", "albedo", "normal", "parsing", "source_light", "specular", "shadow", "composition", "result"]
    seen = []
    for number, name in enumerate(names, 1):
        opened.key(glfw.KEY_0 + number)
        assert opened.window.state.shown == name
        seen.append(opened.viewport())
    # The fake's photo and composition differ from each other, and so do all the rest.
    for one in range(len(seen)):
        for other in range(one):
            assert (seen[one] != seen[other]).any(), (names[one], names[other])


def test_a_shadow_that_was_taken_off_has_a_picture_as_long_as_it_is(opened, relighter):
    window = opened.window
    opened.key(glfw.KEY_0)
    assert window.state.shown == RESULT
    relighter.in_foreign_shadow = True
    window.state.change(yaw_deg=20.0)
    opened.settle()
    opened.key(glfw.KEY_0)
    assert window.state.shown_name() == "foreign_shadow"
    opened.click((WIDTH / 2 - 20, HEIGHT - 80))
    assert window.state.shown == "parsing"
    opened.key(glfw.KEY_0)
    window.state.change(forced_off=frozenset({"foreign_shadow"}))
    opened.settle()
    assert window.state.shown_name() == RESULT
    opened.click((WIDTH / 2, HEIGHT - 80))
    assert window.state.shown == "source_light"


def test_clicking_a_thumbnail_shows_it_large(opened):
    opened.click((WIDTH / 2, HEIGHT - 80))
    assert opened.window.state.shown == "source_light"


def test_a_wipe_shows_the_photo_left_of_its_line_and_the_result_right_of_it(opened, photo_path):
    result = opened.picture_pixels(96, 128)
    photo = np.asarray(Image.open(photo_path), np.float32) / 255
    opened.key(glfw.KEY_W)
    wiped = opened.picture_pixels(96, 128)
    assert close_to(wiped[:, :62], photo[:, :62])
    assert (wiped[:, 66:] == result[:, 66:]).all()
    x, y = opened.centre()
    opened.drag((x, y), (x + 40, y))
    assert opened.window.state.look.wipe_at == pytest.approx(104 / 128, abs=0.02)
    wiped = opened.picture_pixels(96, 128)
    assert close_to(wiped[:, :100], photo[:, :100])
    assert (wiped[:, 108:] == result[:, 108:]).all()
    opened.key(glfw.KEY_W)
    assert (opened.picture_pixels(96, 128) == result).all()


@pytest.mark.parametrize(("key", "share"), [(glfw.KEY_W, 0.05), (glfw.KEY_Y, 0.25)])
def test_the_value_under_the_mouse_is_of_the_picture_it_is_over(opened, key, share):
    opened.key(key)
    state, (middle, y) = opened.window.state, opened.centre()
    for side, name in ((-1, PHOTO), (1, RESULT)):
        opened.move((middle + side * share * state.look.viewport_px[0], y))
        x, row = map(int, state.look.spot)
        codes = reading(state.snapshot, name, 0.0, x, row).codes
        assert _under_the_mouse(state).split()[2:] == f"R {codes[0]} G {codes[1]} B {codes[2]}".split()


@pytest.mark.parametrize("key", [glfw.KEY_W, glfw.KEY_Y])
def test_the_names_of_two_pictures_do_not_lie_over_what_the_next_click_does(opened, monkeypatch, key):
    tops = {}
    for module in (placing, viewport_notes):
        monkeypatch.setattr(module, "note", lambda words, x, y, *_: tops.update({words: y}))
    opened.key(key)
    opened.key(glfw.KEY_K)
    (hint,) = (y for words, y in tops.items() if words.startswith("Click where the highlight"))
    assert [abs(tops[name] - hint) > 22.5 for name in ("Photo", "Result")] == [True, True]


def test_dragging_beside_the_wipes_line_moves_the_picture_and_the_line_with_it(opened):
    opened.key(glfw.KEY_W)
    x, y = opened.centre()
    opened.drag((x + 60, y), (x + 100, y + 10))
    assert opened.window.state.look.wipe_at == 0.5
    assert opened.window.state.view.centre_x == pytest.approx(64 - 40)
    opened.drag((x + 40, y), (x, y))
    assert opened.window.state.look.wipe_at == pytest.approx(0.5 - 40 / 128, abs=0.02)


def test_side_by_side_moves_both_pictures_together(opened, photo_path):
    opened.key(glfw.KEY_Y)
    opened.see_every_pixel()
    photo = np.asarray(Image.open(photo_path), np.float32) / 255
    shown = opened.viewport()
    half = (shown.shape[1] - 2) // 2
    top, left = round(shown.shape[0] / 2) - 48, round(half / 2) - 64
    assert close_to(shown[top : top + 96, left : left + 128], photo)
    x, y = opened.centre()
    opened.drag((x + 100, y), (x + 80, y + 15))
    moved = opened.viewport()
    assert (moved[15:, : half - 20] == shown[:-15, 20:half]).all()
    assert (moved[15:, half + 2 : -20] == shown[:-15, half + 22 :]).all()


def test_clipping_stripes_appear_only_where_the_screen_runs_out(opened):
    opened.window.state.change(exposure_ev=1.2)
    opened.frames(1)
    plain = opened.picture_pixels(96, 128).astype(int)
    opened.key(glfw.KEY_J)
    striped = opened.picture_pixels(96, 128).astype(int)
    radiance = opened.window.state.snapshot.picture.relit.image * 2**1.2
    over = (radiance >= 1.0).any(axis=2)
    clear = (radiance < 0.99).all(axis=2)
    assert over.any()
    assert (striped[clear] == plain[clear]).all()
    changed = np.abs(striped - plain).sum(axis=2) > 30
    assert 0.3 < changed[over].mean() < 0.8


def test_what_is_no_number_is_painted_magenta(opened, relighter, monkeypatch):
    relight = relighter.relight

    def broken(*asked, **how):
        relit = relight(*asked, **how)
        relit.image[40:50, 60:70] = np.nan
        return relit

    monkeypatch.setattr(relighter, "relight", broken)
    opened.key(glfw.KEY_J)
    opened.key(glfw.KEY_RIGHT)
    shown = opened.picture_pixels(96, 128)
    assert (shown[41:49, 61:69] == (255, 0, 217)).all()
    assert not (shown[:38] == (255, 0, 217)).all(axis=2).any()


def test_the_difference_is_grey_where_nothing_changed_and_coloured_where_light_did(opened, relighter, monkeypatch):
    relight = relighter.relight

    def two_stops(*asked, **how):
        relit = relight(*asked, **how)
        relit.image[:] = relighter.photo.linear
        relit.image[:, :40] *= 4.0
        relit.image[:, 80:] *= 0.25
        return relit

    monkeypatch.setattr(relighter, "relight", two_stops)
    opened.key(glfw.KEY_D)
    opened.key(glfw.KEY_RIGHT)
    shown = opened.picture_pixels(96, 128).astype(int)
    brighter, same, darker = (shown[20:80, start : start + 30].reshape(-1, 3) for start in (5, 45, 90))
    assert np.abs(same - 44).max() <= 2
    assert (brighter[:, 0] - brighter[:, 2] > 100).all()
    assert (darker[:, 2] - darker[:, 0] > 100).all()


def test_false_colour_paints_specular_and_leaves_other_pictures_alone(opened):
    opened.key(glfw.KEY_6)
    grey = opened.viewport().astype(int)
    opened.key(glfw.KEY_C)
    coloured = opened.viewport().astype(int)
    middle = grey.shape[0] // 2
    assert np.ptp(grey[middle - 20 : middle + 20], axis=2).max() == 0
    assert np.ptp(coloured[middle - 20 : middle + 20], axis=2).max() > 100
    opened.key(glfw.KEY_2)
    assert np.abs(opened.viewport()[middle, opened.viewport().shape[1] // 2].astype(int) - (255, 0, 0)).max() <= 2


def test_histogram_and_waveform_follow_the_exposure_and_can_be_put_away(opened):
    panel = (slice(10, 90), slice(WIDTH - 226, WIDTH - 14))
    opened.key(glfw.KEY_F)
    before = opened.window.screenshot()[panel]
    opened.window.state.change(exposure_ev=-2.0)
    assert (opened.window.screenshot()[panel] != before).any()
    opened.key(glfw.KEY_V)
    assert opened.window.state.look.scope == "waveform"
    opened.key(glfw.KEY_V)
    assert opened.window.state.look.scope == "off"
    opened.key(glfw.KEY_H)
    opened.click((WIDTH - 120, 50))
    assert opened.window.state.look.scope == "waveform"


def test_the_scopes_may_lag_while_a_hand_moves_something_and_follow_when_it_rests(opened, monkeypatch):
    pictures, snapshot = opened.window.pictures, opened.window.state.snapshot
    before = pictures.extremes("result")
    white = np.full_like(snapshot.picture.screen, 4.0)
    pictures.update(replace(snapshot, picture=replace(snapshot.picture, screen=white)))
    clock = time.monotonic()
    monkeypatch.setattr(gl_pictures.time, "monotonic", lambda: clock)
    pictures._followed_s["scopes"] = clock
    pictures.hurried = True
    assert pictures.extremes("result") == before
    clock += 2.0
    assert pictures.extremes("result").too_bright == 1.0
    pictures.update(snapshot)
    pictures.hurried = False
    assert pictures.extremes("result") == before


def test_in_a_hurry_a_frame_brings_one_thing_that_only_follows_up_to_date(opened, monkeypatch):
    window, pictures, counted = opened.window, opened.window.pictures, []
    opened.frames(2)
    clock = time.monotonic() + 60.0
    monkeypatch.setattr(gl_pictures.time, "monotonic", lambda: clock)
    for name in ("scope", "extremes"):
        real = getattr(pictures._scopes, name)
        monkeypatch.setattr(
            pictures._scopes, name, lambda *a, name=name, real=real: (counted.append(name), real(*a))[1]
        )
    pictures.begin_frame(window.state.edit.exposure_ev, True)
    for key in ("scopes", "extremes"):
        pictures._follows_now(key)
    clock += 0.6
    pictures.begin_frame(window.state.edit.exposure_ev, True)
    pictures.scope("histogram", "result")
    pictures._follows_now("scopes")
    assert pictures.extremes("result") is not None
    assert "extremes" not in counted, "the scopes have had this frame"
    pictures.begin_frame(window.state.edit.exposure_ev, True)
    pictures.extremes("result")
    assert "extremes" in counted


def test_drawn_in_software_the_viewport_is_coarser_only_while_a_hand_moves_something(opened):
    opened.frames()
    finest = opened.viewport()
    opened.window.state.hand_on_control = True
    opened.frames()
    coarse = opened.viewport()
    assert coarse.shape[:2] == tuple(-(-length // 2) for length in finest.shape[:2])
    middle = (slice(coarse.shape[0] // 2 - 20, coarse.shape[0] // 2 + 20),) * 2
    averages = finest[: coarse.shape[0] * 2, : coarse.shape[1] * 2]
    averages = averages[: averages.shape[0] // 2 * 2, : averages.shape[1] // 2 * 2]
    averages = averages.reshape(averages.shape[0] // 2, 2, -1, 2, 3).mean((1, 3))
    assert np.abs(coarse[middle].astype(float) - averages[middle]).mean() < 3
    opened.frames(2)
    assert (opened.viewport() == finest).all()


def test_dragging_the_lit_ball_turns_the_light_and_the_ball_follows(opened):
    opened.light("split")
    ball = (255 + 12 + 39, HEIGHT - 141 - 12 - 39)
    around = (slice(ball[1] - 25, ball[1] + 25), slice(ball[0] - 25, ball[0] + 25))
    before = opened.window.screenshot()[around].astype(int)
    opened.drag(ball, (ball[0] + 30, ball[1]))
    assert opened.window.state.edit.yaw_deg < -30
    turned = opened.window.screenshot()[around].astype(int)
    assert np.abs(turned - before).mean() > 5
    opened.key(glfw.KEY_L)
    hidden = opened.window.screenshot()[around]
    assert hidden.std() < 1


def test_probe_and_timings_are_drawn_only_while_switched_on(opened):
    opened.window.shelf.wait()
    opened.move(opened.centre())
    for key in (glfw.KEY_I, glfw.KEY_T):
        before = opened.window.screenshot().astype(int)
        opened.key(key)
        assert np.abs(opened.window.screenshot() - before).sum() > 10000
        opened.key(key)
        assert (opened.window.screenshot() == before).all()


def test_a_channel_of_a_leaning_head_lies_turned_on_the_photo(opened, relighter, monkeypatch):
    opened.key(glfw.KEY_3)
    upright = opened.picture_pixels(64, 64)
    relight = relighter.relight
    monkeypatch.setattr(relighter, "relight", lambda *asked, **how: replace(relight(*asked, **how), roll_deg=90.0))
    opened.key(glfw.KEY_RIGHT)
    turned = opened.picture_pixels(64, 64)
    assert (upright != np.rot90(upright)).any()
    assert np.abs(turned.astype(int) - np.rot90(upright)).max() <= 1


def test_ctrl_counts_as_soon_as_it_is_pressed_and_no_longer_than_it_is_held(opened):
    """X11 states with a modifier's own event what was held before it."""
    window = opened.window
    opened.move(opened.centre())
    window.on_key(None, glfw.KEY_LEFT_CONTROL, 0, glfw.PRESS, 0)
    window.on_wheel(None, 0.0, 1.0)
    opened.frames(3)
    zoomed = window.state.view
    assert (zoomed.zoom > 1.0, window.state.edit.yaw_deg) == (True, 0.0)
    window.on_key(None, glfw.KEY_LEFT_CONTROL, 0, glfw.RELEASE, glfw.MOD_CONTROL)
    window.on_wheel(None, 0.0, 1.0)
    opened.frames(3)
    assert window.state.view == zoomed
    assert window.state.edit.yaw_deg != 0.0


def test_in_a_hurry_the_pixels_of_a_new_picture_are_not_asked_for_at_once(opened, monkeypatch):
    window, asked = opened.window, []
    opened.frames(2)
    slot = type(window.pictures._slots["result"])
    array = slot.array.fget
    monkeypatch.setattr(slot, "array", property(lambda self: asked.append(self) or array(self)))
    window.pictures._followed_s["scopes"] = time.monotonic() + 60.0
    opened.move(opened.panorama(0.5))
    opened.button(True)
    asked.clear()
    opened.window.on_mouse_move(None, *opened.panorama(0.6))
    picture = window.state.snapshot.picture
    opened.settle()
    assert window.state.snapshot.picture is not picture
    assert asked == []
    opened.button(False)
    opened.settle()
    assert asked
