"""The real window on a real X display, driven as a user would, judged by its pixels."""

import threading

import glfw
import numpy as np
import pytest
from PIL import Image
from window_hand import close_to

from relight_core.errors import InputError
from relight_core.imaging.read import read_photo
from relight_core.imaging.view_transform import apply_view
from relight_core.imaging.write import write_image
from relight_core.pipeline.auto_quality import QualityChoice


def test_the_empty_window_shows_no_picture_and_invites_one(hand):
    hand.settle()
    assert hand.viewport().std() == 0
    whole = hand.window.screenshot()
    assert (whole[200:360, 300:740] > 180).any()
    assert hand.window.state.snapshot.picture is None


def test_a_click_on_the_invitation_asks_for_a_file(hand, monkeypatch):
    monkeypatch.setattr(hand.window._deeds._dialogs, "_has_native", False)
    hand.click((hand.centre()[0], 40))
    assert hand.window.state.picking is None
    hand.click(hand.centre())
    assert hand.window.state.picking.kind == "open"


def test_what_is_typed_into_the_file_dialog_does_nothing_to_the_picture_behind_it(opened, monkeypatch, tmp_path):
    window = opened.window
    monkeypatch.setattr(window._deeds._dialogs, "_has_native", False)
    opened.key(glfw.KEY_B, ctrl=True)
    opened.type("5")
    opened.key(glfw.KEY_ENTER)
    opened.type("5")
    assert window.state.shown == "result"
    assert window.state.picking.text.endswith("5")


def test_a_dropped_photo_appears_relit(opened, relighter):
    picture = opened.window.state.snapshot.picture
    assert close_to(opened.picture_pixels(96, 128), apply_view(picture.relit.image))
    assert len(relighter.portraits) == 1


def test_dragging_the_panorama_turns_the_light_to_the_other_side(opened):
    opened.light("split")
    first = opened.picture_pixels(96, 128).astype(np.float32)
    opened.drag(opened.panorama(0.25), opened.panorama(0.75))
    second = opened.picture_pixels(96, 128).astype(np.float32)
    assert abs(abs(opened.window.state.edit.yaw_deg) - 180) < 8
    ratio = second.mean(axis=(0, 2)) / first.mean(axis=(0, 2))
    one, other = ratio[:32].mean(), ratio[-32:].mean()
    assert min(one, other) < 0.9 < 1.1 < max(one, other)


def test_the_wheel_over_the_picture_turns_the_light_and_with_ctrl_zooms(opened):
    opened.move(opened.centre())
    opened.wheel(2)
    yaw_deg, zoom = opened.window.state.edit.yaw_deg, opened.window.state.view.zoom
    assert yaw_deg > 0
    opened.wheel(3, ctrl=True)
    assert opened.window.state.edit.yaw_deg == yaw_deg
    assert opened.window.state.view.zoom > zoom
    opened.key(glfw.KEY_F)
    assert opened.window.state.view.fit


def test_exposure_brightens_without_another_relight(opened, relighter):
    calls = len(relighter.relights)
    before = opened.picture_pixels(96, 128)
    *_, exposure = opened.knobs()
    opened.drag(exposure, (exposure[0] + 20, exposure[1]))
    assert opened.window.state.edit.exposure_ev > 0.3
    after = opened.picture_pixels(96, 128)
    assert (after.astype(int) >= before).all()
    assert after.mean() > before.mean() + 10
    image = opened.window.state.snapshot.picture.relit.image
    assert close_to(after, apply_view(image, opened.window.state.edit.exposure_ev))
    assert len(relighter.relights) == calls


@pytest.mark.parametrize(("which", "field"), [(0, "shadow"), (2, "specular"), (3, "specular_tint")])
def test_an_effect_slider_relights_quickly_while_dragged_and_finally_at_rest(opened, relighter, which, field):
    calls = len(relighter.relights)
    x, y = opened.knobs()[which]
    opened.drag((x, y), (x + 40, y), settle_each_step=True)
    value = getattr(opened.window.state.edit, field)
    assert value > (1.2 if field != "specular_tint" else 0.2)
    edits = relighter.relights[calls:]
    assert edits[0].quality == "live"
    assert edits[-1].quality == "final"
    assert getattr(edits[-1], field) == value


def test_the_strength_slider_relights_down_to_none(opened, relighter):
    x, y = opened.knobs()[4]
    opened.drag((x, y), (x - 400, y))
    assert opened.window.state.edit.strength == 0.0
    assert relighter.relights[-1].strength == 0.0


def test_the_engine_gets_ready_for_the_hand_as_soon_as_its_quality_is_another(hand, relighter, photo_path):
    state = hand.window.state
    state.quality = QualityChoice("final")
    hand.drop(photo_path)
    calls = len(relighter.relights)
    assert relighter.readied == []
    state.quality = QualityChoice("auto")
    hand.settle()
    assert [edit.quality for edit in relighter.readied] == ["live"]
    assert len(relighter.relights) == calls, "at rest the picture is the same"


@pytest.mark.parametrize("shadow", [1.3, 2.5])
def test_a_click_on_a_sliders_knob_moves_nothing_however_long_it_is(opened, shadow):
    opened.window.state.change(shadow=shadow)
    opened.settle()
    (x, y), *_ = opened.knobs()
    opened.move((x + 3, y))
    opened.button(True)
    opened.frames(3)
    opened.button(False)
    assert opened.window.state.edit.shadow == shadow


@pytest.mark.parametrize("off", [-4, 4])
def test_a_sliders_knob_goes_as_far_as_the_hand_wherever_it_is_met(opened, off):
    (x, y), *_ = opened.knobs()
    opened.drag((x + off, y), (x + off + 30, y))
    assert opened.knobs()[0][0] == pytest.approx(x + 30, abs=1)


def test_a_double_click_resets_a_slider(opened):
    x, y = opened.knobs()[0]
    opened.drag((x, y), (x + 60, y))
    assert opened.window.state.edit.shadow > 1.3
    opened.double_click((x + 60, y))
    assert opened.window.state.edit.shadow == 1.0


def test_a_ctrl_click_lets_one_type_a_number_within_the_sliders_range(opened):
    x, y = opened.knobs()[2]
    opened.click((x + 30, y), ctrl=True)
    opened.type("0.25")
    opened.key(glfw.KEY_ENTER)
    assert opened.window.state.edit.specular == pytest.approx(0.25)
    x, y = opened.knobs()[2]
    opened.click((x, y), ctrl=True)
    opened.type("77")
    opened.key(glfw.KEY_ENTER)
    assert opened.window.state.edit.specular == 2.0


def test_number_keys_show_channels_and_not_while_a_number_is_typed(opened):
    opened.key(glfw.KEY_2)
    red, green, blue = opened.viewport()[opened.viewport().shape[0] // 2, opened.viewport().shape[1] // 2]
    assert red > 200
    assert max(green, blue) < 30
    opened.key(glfw.KEY_9)
    assert opened.window.state.shown == "result"
    opened.click(opened.knobs()[0], ctrl=True)
    opened.type("2")
    assert opened.window.state.shown == "result"


def test_holding_space_shows_the_photo_until_it_is_let_go(opened, photo_path):
    relit = opened.picture_pixels(96, 128)
    opened.hold(glfw.KEY_SPACE)
    assert close_to(opened.picture_pixels(96, 128), np.asarray(Image.open(photo_path), np.float32) / 255)
    opened.release(glfw.KEY_SPACE)
    assert (opened.picture_pixels(96, 128) == relit).all()


def test_a_bad_file_leaves_the_picture_and_is_told_in_a_line_that_stays(opened, tmp_path):
    bad = tmp_path / "broken.png"
    bad.write_bytes(b"\x89PNG\r\n\x1a\n but no more")
    before = opened.viewport()
    assert not opened.status_has_error_colour()
    opened.drop(bad)
    assert (opened.viewport() == before).all()
    assert "broken.png" in opened.window.state.message().text
    assert opened.status_has_error_colour()
    opened.move(opened.centre())
    opened.wheel(1)
    assert opened.status_has_error_colour()
    opened.key(glfw.KEY_ESCAPE)
    assert not opened.status_has_error_colour()


def test_a_dropped_panorama_becomes_the_light(opened, relighter, tmp_path):
    radiance = np.zeros((8, 16, 3), np.float32)
    radiance[:, 11:14] = (5.0, 0.0, 0.0)
    path = tmp_path / "lamp.exr"
    write_image(path, radiance)
    opened.drop(path)
    assert relighter.environments[-1].name == "lamp.exr"
    assert opened.window.state.snapshot.opened.source.path.name == "person.png"


def test_a_portrait_dropped_on_the_light_panel_lends_its_light(opened, relighter, photo_path):
    opened.drop(photo_path, at=opened.panorama(0.5))
    assert relighter.environments[-1].name == "estimated"
    assert [source.title for source in opened.window.state.extra_lights] == ["person"]


def test_the_first_photo_is_seen_while_its_face_is_being_read(hand, relighter, photo_path, monkeypatch):
    reading, go_on, read = threading.Event(), threading.Event(), relighter.set_portrait

    def read_slowly(*asked):
        reading.set()
        assert go_on.wait(30)
        read(*asked)

    monkeypatch.setattr(relighter, "set_portrait", read_slowly)
    hand.window.on_drop(None, [str(photo_path)], hand.centre())
    hand.frames(1)
    assert reading.wait(30)
    hand.frames(2)
    seen = hand.viewport()
    go_on.set()
    hand.settle()
    hand.key(glfw.KEY_1)
    assert (hand.viewport() == seen).all()
    assert len(np.unique(seen)) > 20


def test_a_first_photo_that_can_not_be_used_goes_again(hand, photo_path, relighter, monkeypatch):
    def refuse(photo, face_index=None, boxes=None, strokes=()):
        raise InputError(f"{photo.path}: not today")

    monkeypatch.setattr(relighter, "set_portrait", refuse)
    hand.drop(photo_path)
    snapshot = hand.window.state.snapshot
    assert (snapshot.opened, snapshot.coming) == (None, None)
    assert "not today" in snapshot.message.text
    assert len(np.unique(hand.viewport())) == 1


def test_the_window_goes_on_drawing_while_the_networks_are_stuck(opened, relighter):
    relighter.gate.clear()
    opened.move(opened.centre())
    opened.window.on_wheel(None, 0.0, 1.0)
    opened.frames(3)
    before = opened.picture_pixels(96, 128)
    opened.window.state.change(exposure_ev=1.0)
    opened.frames(2)
    assert opened.picture_pixels(96, 128).mean() > before.mean() + 10
    assert opened.window.engine.snapshot().activity == "Relighting"


def test_a_png_export_is_what_is_shown_and_overwrites_nothing(opened, photo_path):
    original = photo_path.read_bytes()
    opened.window.state.change(exposure_ev=0.5)
    opened.settle()
    shown = opened.picture_pixels(96, 128)
    for _ in range(2):
        opened.key(glfw.KEY_E)
    opened.window.exporter.close()
    first, second = photo_path.with_name("person-relit.png"), photo_path.with_name("person-relit-2.png")
    for path in (first, second):
        saved = np.asarray(Image.open(path).convert("RGB"), np.int32)
        assert np.abs(saved - shown).max() <= 1
    assert photo_path.read_bytes() == original
    assert sorted(path.name for path in photo_path.parent.iterdir()) == [
        "person-relit-2.png",
        "person-relit.png",
        "person.png",
    ]


def test_an_exr_export_holds_the_radiance_and_every_channel(opened, photo_path):
    import OpenEXR

    opened.key(glfw.KEY_E, shift=True)
    opened.window.exporter.close()
    picture = read_photo(photo_path.with_name("person-relit.exr"))
    expected = opened.window.state.snapshot.picture.relit.image
    assert np.allclose(picture.linear, expected, rtol=2e-3, atol=1e-4)
    with OpenEXR.File(str(photo_path.with_name("person-relit.exr"))) as file:
        assert {"RGB", "albedo", "normal", "parsing", "specular", "shadow"} <= set(file.channels())
        assert file.header()["relightLight"] == "Rembrandt"
    assert len(list(photo_path.parent.iterdir())) == 2


def test_an_export_to_a_folder_that_is_not_there_is_told(opened, tmp_path):
    opened.window.state.export_path = str(tmp_path / "missing" / "out.png")
    opened.key(glfw.KEY_E)
    opened.window.exporter.close()
    opened.settle()
    message = opened.window.state.message()
    assert message.is_error
    assert "missing" in message.text


def test_a_transparent_background_shows_checks_where_nothing_is(opened):
    opened.window.state.change(background="transparent")
    opened.settle()
    pixels = opened.picture_pixels(96, 128)
    top = pixels[:20].reshape(-1, 3)
    assert (top.min(axis=1) == top.max(axis=1)).all()
    assert len(np.unique(top, axis=0)) == 2
    assert len(np.unique(pixels[40:].reshape(-1, 3), axis=0)) > 100


def test_the_window_can_be_resized_and_scaled_at_any_time(opened):
    for size, scale in (((1300, 900), 1.0), ((800, 560), 1.0), ((1600, 1000), 2.0), ((1024, 700), 1.0)):
        opened.window.screenshot()
        opened.resize(size)
        opened.window.on_scale(None, scale, scale)
        opened.frames(2)
        assert opened.window.screenshot().shape == (size[1], size[0], 3)
        height, width = opened.viewport().shape[:2]
        assert height < size[1]
        assert width < size[0]


def test_another_photo_replaces_the_first_at_once(opened, tmp_path):
    path = tmp_path / "other.png"
    write_image(path, np.broadcast_to(np.float32([0.1, 0.6, 0.1]), (50, 40, 3)))
    opened.drop(path)
    opened.see_every_pixel()
    red, green, blue = opened.picture_pixels(50, 40).reshape(-1, 3).mean(axis=0)
    assert green > 1.5 * max(red, blue)
    assert opened.window.state.export_path.endswith("other-relit.png")


def test_a_group_folds_away_and_opens_again(opened):
    title = (opened.width - 150, 105 + 12 + 10)
    sliders = len(opened.knobs())
    opened.click(title)
    assert not opened.window.state.groups.effects
    assert len(opened.knobs()) == sliders - 6
    opened.click(title)
    assert opened.window.state.groups.effects
    assert len(opened.knobs()) == sliders
