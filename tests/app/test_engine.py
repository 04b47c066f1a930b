"""The engine: newest wins, errors keep the picture, exposure costs nothing. Events instead of sleeps."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from fake_relighter import LONG_S, answered, photos_read

from app.engine.engine import Engine
from app.engine.sources import LightSource, PhotoSource, Request
from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.imaging.write import write_image
from relight_core.lighting.light_edit import LightEdit, edit_light
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke

SPLIT, RING = LightSource("rig", "split"), LightSource("rig", "ring")


def grey_photo(value=0.5, size=(24, 32)):
    return Photo(np.full((*size, 3), value, np.float32))


@pytest.fixture
def engine(relighter):
    engine = Engine(lambda: relighter)
    yield engine
    relighter.gate.set()
    engine.close()


def test_opens_a_photo_and_relights_it_under_the_light(engine, relighter):
    source = PhotoSource(grey_photo())
    snapshot = answered(engine, Request(source, SPLIT, Edit(yaw_deg=30.0)))
    assert snapshot.opened.source is source
    assert snapshot.picture.opened is snapshot.opened
    assert relighter.environments[-1] is snapshot.light.environment
    assert relighter.relights[-1].yaw_deg == 30.0
    assert snapshot.picture.screen.dtype == np.float16
    assert snapshot.picture.screen.shape == (24, 32, 3)
    assert snapshot.picture.channels["albedo"].dtype == np.uint8
    assert snapshot.activity is None


def test_a_cut_out_is_shown_with_its_alpha(engine):
    alpha = np.zeros((24, 32), np.float32)
    alpha[6:18, 8:24] = 0.5
    cut_out = Photo(np.full((24, 32, 3), 0.25, np.float32), alpha)
    screen = answered(engine, Request(PhotoSource(cut_out), SPLIT, Edit())).opened.screen
    np.testing.assert_array_equal(screen[..., 3], alpha)
    np.testing.assert_array_equal(screen[..., :3], 0.5 * np.repeat(alpha[..., None], 3, 2), "what is hidden stays so")


def test_nothing_is_loaded_before_a_photo_is_opened(relighter):
    made = []
    engine = Engine(lambda: made.append(1) or relighter)
    answered(engine, Request(None, SPLIT, Edit()))
    assert made == []
    answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit()))
    answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit()))
    assert made == [1]
    engine.close()


def test_exposure_alone_reruns_nothing(engine, relighter):
    source = PhotoSource(grey_photo())
    before = answered(engine, Request(source, SPLIT, Edit()))
    calls = len(relighter.relights)
    after = answered(engine, Request(source, SPLIT, Edit(exposure_ev=2.0)))
    assert len(relighter.relights) == calls
    assert after.picture is before.picture
    assert all(edit.exposure_ev == 0.0 for edit in relighter.relights)


def test_an_outline_is_drawn_where_it_is_wanted_and_again_for_every_picture(engine, relighter):
    source = PhotoSource(grey_photo())
    relighter.outline = [np.zeros((4, 2), np.float32)]
    plain = Request(source, SPLIT, Edit())
    assert answered(engine, plain).picture.outline is None
    calls = len(relighter.relights)
    assert answered(engine, replace(plain, outlined=True)).picture.outline is relighter.outline
    assert len(relighter.relights) == calls
    relighter.outline = [np.ones((4, 2), np.float32)]
    turned = replace(plain, edit=Edit(yaw_deg=9.0), outlined=True)
    assert answered(engine, turned).picture.outline is relighter.outline


def test_an_outline_that_fails_leaves_the_picture(engine, relighter, monkeypatch):
    def fail():
        raise MemoryError

    monkeypatch.setattr(relighter, "draw_outline", fail)
    snapshot = answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit(), outlined=True))
    assert snapshot.picture.outline == []
    assert snapshot.message.is_error


def test_strokes_are_painted_on_the_portrait_that_is_open(engine, relighter):
    stroke = BrushStroke(((3.0, 4.0),), 2.0, True)
    before = answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit()))
    painted = PhotoSource(before.opened.photo, strokes=(stroke,))
    after = answered(engine, Request(painted, SPLIT, Edit()))
    assert relighter.strokes == (stroke,)
    assert after.opened.screen is before.opened.screen
    assert after.picture.opened is after.opened


CHANGES = [{"yaw_deg": 9.0}, {"shadow": 0.3}, {"specular": 1.7}, {"background": "light"}]


@pytest.mark.parametrize("change", CHANGES)
def test_every_other_slider_relights_once_without_opening_the_photo_again(engine, relighter, change):
    source = PhotoSource(grey_photo())
    answered(engine, Request(source, SPLIT, Edit()))
    calls = len(relighter.relights)
    answered(engine, Request(source, SPLIT, Edit(**change)))
    assert len(relighter.relights) == calls + 1
    assert len(relighter.portraits) == 1


def test_only_the_newest_of_many_requests_is_answered(engine, relighter):
    source = PhotoSource(grey_photo())
    answered(engine, Request(source, SPLIT, Edit()))
    calls = len(relighter.relights)
    relighter.gate.clear()
    while relighter.entered.acquire(blocking=False):
        pass
    engine.submit(Request(source, SPLIT, Edit(yaw_deg=1.0)))
    assert relighter.entered.acquire(timeout=LONG_S)
    for yaw_deg in (2.0, 3.0, 4.0, 5.0):
        engine.submit(Request(source, SPLIT, Edit(yaw_deg=yaw_deg)))
    relighter.gate.set()
    assert engine.wait_until_idle(LONG_S)
    assert [edit.yaw_deg for edit in relighter.relights[calls:]] == [1.0, 5.0]
    assert engine.snapshot().picture.edit.yaw_deg == 5.0


def test_a_result_for_a_photo_that_was_replaced_meanwhile_is_never_published(relighter):
    shown = []
    engine = Engine(lambda: relighter, lambda: shown.append(engine.snapshot().picture))
    first, second = PhotoSource(grey_photo(0.2)), PhotoSource(grey_photo(0.7))
    relighter.gate.clear()
    engine.submit(Request(first, SPLIT, Edit()))
    assert relighter.entered.acquire(timeout=LONG_S)
    engine.submit(Request(second, SPLIT, Edit()))
    relighter.gate.set()
    assert engine.wait_until_idle(LONG_S)
    engine.close()
    sources = {picture.opened.source for picture in shown if picture is not None}
    assert sources == {second}


OUTSIDE = (FaceBox(-40, 0, -8, 30),)
"""What no Relighter takes for the box of a face."""


def test_a_photo_that_can_not_be_used_leaves_everything_as_it_was_and_says_why(engine, relighter):
    good, bad = PhotoSource(grey_photo()), PhotoSource(grey_photo(), None, OUTSIDE)
    before = answered(engine, Request(good, SPLIT, Edit()))
    after = answered(engine, Request(bad, SPLIT, Edit()))
    assert after.picture is before.picture
    assert after.opened is before.opened
    assert bad in after.refused
    assert after.message.is_error
    assert "box of a face" in after.message.text
    on = answered(engine, Request(good, SPLIT, Edit(shadow=0.0)))
    assert on.picture.edit.shadow == 0.0
    assert on.message is after.message


def test_a_refused_photo_is_tried_once_only(engine, relighter):
    bad = PhotoSource(grey_photo(), None, OUTSIDE)
    number = answered(engine, Request(bad, SPLIT, Edit())).message.number
    assert answered(engine, Request(bad, SPLIT, Edit(shadow=0.1))).message.number == number
    again = answered(engine, Request(PhotoSource(bad.place, None, OUTSIDE), SPLIT, Edit()))
    assert again.message.number == number + 1


def test_a_photo_that_was_read_and_refused_is_not_kept(engine, tmp_path, monkeypatch):
    answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit()))
    still_there = photos_read(monkeypatch, grey_photo)
    bad = PhotoSource(tmp_path / "bad.png", None, OUTSIDE)
    assert bad in answered(engine, Request(bad, SPLIT, Edit())).refused
    assert still_there() == [False]


def test_a_file_that_is_no_image_is_told_by_name(engine, tmp_path):
    path = tmp_path / "notes.jpg"
    path.write_text("not an image")
    snapshot = answered(engine, Request(PhotoSource(path), SPLIT, Edit()))
    assert snapshot.opened is None
    assert "notes.jpg" in snapshot.message.text


def test_a_light_of_the_wrong_shape_keeps_the_light_in_force(engine, relighter, tmp_path):
    from relight_core.imaging.write import write_exr_layers

    path = tmp_path / "square.exr"
    write_exr_layers(path, {"RGB": np.ones((16, 16, 3), np.float32)})
    source = PhotoSource(grey_photo())
    before = answered(engine, Request(source, RING, Edit()))
    bad = LightSource("panorama", str(path))
    after = answered(engine, Request(source, bad, Edit()))
    assert after.light is before.light
    assert bad in after.refused
    assert "square.exr" in after.message.text


def test_a_fault_in_the_networks_is_told_and_survived(engine, relighter, caplog):
    source = PhotoSource(grey_photo())
    before = answered(engine, Request(source, SPLIT, Edit()))
    relighter.fail_with = RuntimeError("out of luck")
    after = answered(engine, Request(source, SPLIT, Edit(yaw_deg=5.0)))
    assert after.picture is before.picture
    assert after.message.is_error
    assert "out of luck" in after.message.text
    assert "Traceback" in caplog.text
    relighter.fail_with = None
    assert answered(engine, Request(source, SPLIT, Edit(yaw_deg=6.0))).picture.edit.yaw_deg == 6.0


def test_networks_that_cannot_be_loaded_are_told_and_tried_again_with_the_next_photo(relighter):
    answers = [InputError("relight.safetensors: damaged; fetch it again"), None]

    def make():
        error = answers.pop(0)
        if error:
            raise error
        return relighter

    engine = Engine(make)
    first = answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit()))
    assert first.picture is None
    assert "damaged" in first.message.text
    assert answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit())).picture is not None
    engine.close()


def test_a_borrowed_light_comes_from_the_other_portrait_and_the_first_one_stays(engine, relighter, tmp_path):
    from relight_core.imaging.write import write_image

    path = tmp_path / "friend.png"
    write_image(path, np.broadcast_to(np.float32([0.8, 0.2, 0.2]), (20, 20, 3)))
    source = PhotoSource(grey_photo())
    answered(engine, Request(source, SPLIT, Edit()))
    snapshot = answered(engine, Request(source, LightSource("portrait", str(path)), Edit()))
    tint = snapshot.light.environment.shape.mean(axis=(0, 1))
    assert tint[0] > 3 * tint[1]
    assert snapshot.opened.source is source
    assert relighter.portraits[-1][0] is source.place
    assert snapshot.picture.light is snapshot.light


def test_the_photos_own_light_follows_the_photo(engine, relighter):
    own = LightSource("own")
    red = Photo(np.ascontiguousarray(np.broadcast_to(np.float32([0.9, 0.1, 0.1]), (8, 8, 3))))
    blue = Photo(np.ascontiguousarray(np.broadcast_to(np.float32([0.1, 0.1, 0.9]), (8, 8, 3))))
    first = answered(engine, Request(PhotoSource(red), own, Edit()))
    second = answered(engine, Request(PhotoSource(blue), own, Edit()))
    assert first.light.environment.shape[0, 0, 0] > first.light.environment.shape[0, 0, 2]
    assert second.light.environment.shape[0, 0, 2] > second.light.environment.shape[0, 0, 0]
    assert second.picture.light.environment is second.light.environment


@pytest.mark.parametrize("quality", ["draft", "live", "final"])
def test_the_photos_own_light_is_told_at_one_quality_whichever_is_chosen(engine, relighter, quality):
    source, own = PhotoSource(grey_photo()), LightSource("own")
    answered(engine, Request(source, SPLIT, Edit(quality=quality)))
    answered(engine, Request(source, own, Edit(quality="final")))
    assert relighter.estimated_at == ["final"]


def test_the_start_hook_runs_on_the_engines_thread_before_anything_else(relighter):
    order = []
    engine = Engine(
        lambda: order.append(("make", threading.current_thread())) or relighter,
        on_start=lambda: order.append(("start", threading.current_thread())),
    )
    answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit()))
    engine.close()
    assert [name for name, _ in order] == ["start", "make"]
    assert order[0][1] is order[1][1]
    assert order[0][1] is not threading.main_thread()


def test_submit_never_waits_for_the_networks_and_close_ends_the_thread(relighter):
    engine = Engine(lambda: relighter)
    relighter.gate.clear()
    engine.submit(Request(PhotoSource(grey_photo()), SPLIT, Edit()))
    assert relighter.entered.acquire(timeout=LONG_S)
    engine.submit(Request(PhotoSource(grey_photo()), SPLIT, Edit(yaw_deg=1.0)))
    assert engine.snapshot().activity == "Relighting"
    relighter.gate.set()
    engine.close()
    engine.close()
    assert len(relighter.relights) <= 1
    assert not any(thread.name == "relight-engine" for thread in threading.enumerate())


def test_an_edited_light_relights_once_and_its_draft_is_drawn_again_at_rest(engine, relighter):
    source = PhotoSource(grey_photo())
    answered(engine, Request(source, SPLIT, Edit(quality="final")))
    calls = len(relighter.relights)
    boxes = LightEdit(boxes=(SoftBox(),))
    draft = answered(engine, Request(source, SPLIT, Edit(quality="live", channels=()), boxes))
    assert (draft.light.is_draft, draft.light.edit) == (True, boxes)
    assert draft.light.source is SPLIT
    final = answered(engine, Request(source, SPLIT, Edit(quality="final"), boxes))
    assert not final.light.is_draft
    assert final.light.environment.height > draft.light.environment.height
    assert len(relighter.relights) == calls + 2
    back = answered(engine, Request(source, SPLIT, Edit(quality="final")))
    assert back.light.environment is back.light.base
    assert np.array_equal(back.light.ball, final.light.ball)


@pytest.mark.parametrize("quality", ["draft", "live", "final"])
def test_at_rest_a_light_is_drawn_finely_whichever_quality_is_chosen(engine, quality):
    light = answered(
        engine, Request(PhotoSource(grey_photo()), SPLIT, Edit(quality=quality), LightEdit(warmth=0.5))
    ).light
    assert not light.is_draft
    assert light.environment.height == edit_light(light.base, light.edit).height


def test_a_light_that_cannot_be_drawn_is_told_once_and_the_picture_stays(engine, relighter, monkeypatch):
    source = PhotoSource(grey_photo())
    before = answered(engine, Request(source, SPLIT, Edit()))

    def fail(*_):
        raise InputError("no such light")

    monkeypatch.setattr("app.engine.desk.edit_light", fail)
    after = answered(engine, Request(source, SPLIT, Edit(), LightEdit(level_ev=1.0)))
    assert after.message.text == "no such light"
    assert np.array_equal(after.picture.relit.image, before.picture.relit.image)


def test_a_panorama_is_metered_as_it_is_opened_and_looks_the_same_in_any_units(engine, relighter, tmp_path):
    source = PhotoSource(grey_photo())
    radiance = np.random.default_rng(0).random((16, 32, 3), np.float32)
    seen = []
    for units in (1.0, 16.0):
        path = tmp_path / f"{units:g}.exr"
        write_image(path, units * radiance)
        light = LightSource("panorama", str(path))
        calls = len(relighter.relights)
        metered = answered(engine, Request(source, light, Edit(), light.opening_edit))
        assert len(relighter.relights) == calls + 1
        plain = answered(engine, Request(source, light, Edit(), LightEdit()))
        assert plain.light.environment.level == pytest.approx(units * 0.5, rel=0.1)
        assert np.array_equal(plain.light.panorama, metered.light.panorama)
        brighter = answered(engine, Request(source, light, Edit(), LightEdit(metered=True, level_ev=1.0)))
        seen += [(metered.light.environment.level, brighter.light.environment.level, brighter.light.panorama)]
    assert seen[0][:2] == pytest.approx(seen[1][:2], rel=1e-5)
    assert seen[0][1] == pytest.approx(2.0 * seen[0][0])
    assert np.abs(seen[0][2].astype(int) - seen[1][2]).max() <= 1
    assert seen[0][2].mean() > metered.light.panorama.mean() + 10
