"""The editor's record: angles, quality, wishes that were refused."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from opened_things import SKY, open_light, opened_photo

from app.engine.snapshot import Message, OpenPhoto, Snapshot
from app.engine.sources import LightSource, PhotoSource
from app.ui import brush_edits, face_edits
from app.ui.angles import wrap_degrees
from app.ui.channels import in_filmstrip
from app.ui.export_name import choose_form, export_place, export_to
from app.ui.light_edits import AimTool
from app.ui.news import let_news_pass, put_message_away
from app.ui.state import EditorState
from app.ui.viewport.view import View
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.auto_quality import QualityChoice, TierCost


@pytest.mark.parametrize(
    ("given_deg", "wrapped_deg"), [(0, 0), (180, 180), (-180, 180), (181, -179), (-540, 180), (725, 5)]
)
def test_angles_stay_within_half_a_turn(given_deg, wrapped_deg):
    assert wrap_degrees(given_deg) == wrapped_deg


def test_the_filmstrip_has_nine_entries_that_the_number_keys_reach_and_a_tenth_where_there_is_one():
    names = [
        "photo", "albedo", "normal", "parsing", "source_light", "specular", "shadow", "composition", "result"
    ]  # fmt: skip
    usual = in_filmstrip({"photo", "albedo", "shadow"})
    assert [(channel.name, channel.key) for channel in usual] == [
        (name, str(number)) for number, name in enumerate(names, 1)
    ]
    with_shadow = in_filmstrip({"albedo", "foreign_shadow"})
    assert [(channel.name, channel.key) for channel in set(with_shadow) - set(usual)] == [("foreign_shadow", "0")]


def test_quality_drops_only_while_a_hand_changes_something_the_networks_read():
    state = EditorState()
    assert state.request().edit.quality == "final"
    state.hand_on_control = True
    assert state.request().edit.quality == "final"
    state.change(exposure_ev=1.0)
    assert state.request().edit.quality == "final"
    state.change(shadow=0.5)
    assert state.request().edit.quality == "live"
    assert state.request().edit.quality == "live"
    state.hand_on_control = False
    assert state.request().edit.quality == "final"


@pytest.mark.parametrize(
    "moved", [{"strength": 0.5}, {"background": "light", "background_fov_deg": 80.0}, {"background_blur_deg": 9.0}]
)
def test_quality_stays_while_a_hand_moves_what_is_applied_to_the_finished_picture(moved):
    state = EditorState()
    state.request()
    state.hand_on_control = True
    state.change(**moved)
    asked = state.request().edit
    assert (asked.quality, asked.surface_of) == ("final", None)
    state.change(specular=0.5)
    assert state.request().edit.quality == "live"
    state.change(strength=0.25)
    assert state.request().edit.quality == "live", "of the specular that was just set only this is known"


def test_a_request_never_carries_exposure():
    state = EditorState()
    state.change(exposure_ev=3.0)
    assert state.request().edit.exposure_ev == 0.0


def test_refused_wishes_fall_back_to_what_is_in_force():
    state = EditorState()
    opened = opened_photo()
    state.accept(Snapshot(opened=opened))
    bad_photo, bad_light = PhotoSource(opened.photo), LightSource("panorama", "no.exr")
    state.photo, state.light = bad_photo, bad_light
    state.accept(Snapshot(opened=opened, refused=frozenset({bad_photo, bad_light})))
    assert state.photo is opened.source
    assert state.light.kind == "rig"


def test_undo_puts_the_light_its_edit_and_the_sliders_back():
    state = EditorState()
    state.accept(Snapshot(opened=opened_photo(Path("/p/me.png")), light=open_light(state.light)))
    state.photo = state.snapshot.opened.source
    state.remember(0.0)
    state.change(shadow=0.5)
    state.remember(1.0)
    state.light_edit = LightEdit(warmth=0.5)
    state.remember(2.0)
    ring = LightSource("rig", "ring")
    state.choose_light(ring)
    state.remember(3.0)
    assert len(state.history.steps) == 3, "a light that may still be refused is no step"
    state.accept(replace(state.snapshot, light=open_light(ring)))
    state.remember(4.0)
    assert [step.name for step in state.history.steps][1:] == ["Shadow 0.50", "Light warmth +0.50", "Light: Ring"]
    assert state.light_edit == LightEdit()
    state.restore(state.history.undo())
    assert (state.light.name, state.light_edit.warmth) == ("rembrandt", 0.5)
    state.restore(state.history.undo())
    state.restore(state.history.undo())
    assert state.edit.shadow == 1.0
    state.restore(state.history.go(3))
    assert (state.light.name, state.edit.shadow) == ("ring", 0.5)


@pytest.mark.parametrize("act", [lambda state: state.restore(state.history.go(0)), EditorState.reset])
def test_a_level_that_a_picture_has_yet_to_tell_is_not_set_on_what_comes_back(act):
    state = EditorState()
    state.accept(Snapshot(opened=opened_photo(Path("/p/me.png")), light=open_light(state.light)))
    state.photo = state.snapshot.opened.source
    state.remember(0.0)
    state.asking.level = object()
    act(state)
    assert state.asking.level is None


def test_a_slider_is_one_step_however_long_the_hand_is_on_it():
    state = EditorState()
    state.accept(Snapshot(opened=opened_photo(Path("/p/me.png")), light=open_light(state.light)))
    state.photo = state.snapshot.opened.source
    for now_s, (shadow, held) in enumerate(((1.0, False), (0.8, True), (0.6, True), (0.4, True), (0.4, False))):
        state.hand_on_control = held
        state.change(shadow=shadow)
        state.remember(5.0 * now_s)
    assert [step.name for step in state.history.steps] == ["Open me.png", "Shadow 0.40"]


def test_the_lights_that_were_used_last_come_first_in_the_list():
    state = EditorState()
    for name in ("/l/dusk.hdr", "/l/noon.hdr", "/l/dusk.hdr"):
        state.choose_light(LightSource("panorama", name))
        state.accept(replace(state.snapshot, light=open_light(state.light)))
    assert [light.name for light in state.extra_lights] == ["/l/noon.hdr", "/l/dusk.hdr"]


def test_undoing_an_opening_asks_for_the_photo_before(tmp_path):
    state = EditorState()
    for name in ("one.png", "two.png"):
        opened = opened_photo(tmp_path / name)
        state.photo = opened.source
        state.accept(Snapshot(opened=opened, light=open_light(state.light)))
        state.remember(0.0)
    state.restore(state.history.undo())
    assert state.photo.path == tmp_path / "one.png"


def test_a_refused_light_brings_back_the_edit_of_the_one_in_force():
    state = EditorState()
    boxes = LightEdit(level_ev=1.0)
    light = replace(open_light(state.light), edit=boxes)
    state.accept(Snapshot(light=light))
    state.light_edit = boxes
    bad = LightSource("panorama", "no.exr")
    state.choose_light(bad)
    state.accept(Snapshot(light=light, refused=frozenset({bad})))
    assert state.light is light.source
    assert state.light_edit == boxes


def test_where_no_light_is_in_force_yet_the_first_one_takes_the_soft_boxes_over():
    own = LightSource("own")
    state = EditorState(light=own, light_edit=LightEdit(level_ev=1.0, base=0.3, boxes=(SoftBox(),)))
    state.accept(Snapshot(refused=frozenset({own})))
    assert state.light.kind == "rig"
    assert state.light_edit == LightEdit(base=0.3, boxes=(SoftBox(),))


def test_own_light_that_waits_for_a_face_is_kept_and_what_is_set_meanwhile_is_a_step():
    own, edit = LightSource("own"), LightEdit(warmth=0.4, boxes=(SoftBox(),))
    state = EditorState(light=own, light_edit=edit)
    opened = opened_photo(Path("/p/nobody.png"))
    state.photo = opened.source
    state.accept(Snapshot(opened=opened, awaited=own))
    state.remember(0.0)
    state.change(shadow=0.5)
    state.remember(2.0)
    assert (state.light, state.light_edit) == (own, edit)
    assert [step.name for step in state.history.steps] == ["Open nobody.png", "Shadow 0.50"]


def test_a_light_edit_counts_as_moved_by_the_hand():
    state = EditorState()
    state.request()
    state.hand_on_control = True
    state.light_edit = LightEdit(level_ev=1.0)
    assert state.request().edit.quality == "live"
    state.hand_on_control = False
    assert state.request().edit.quality == "final"
    assert state.request().light_edit.level_ev == 1.0


def test_a_message_stays_away_once_put_away_but_the_next_one_shows():
    state = EditorState()
    state.accept(Snapshot(message=Message(1, "no")))
    assert state.message().text == "no"
    put_message_away(state)
    assert state.message() is None
    state.accept(Snapshot(message=Message(2, "no")))
    assert state.message().number == 2


def test_good_news_passes_once_it_has_been_read_and_errors_stay():
    state, now_s = EditorState(), 100.0

    def is_in_sight(number, frames):
        nonlocal now_s
        for _ in range(frames):
            now_s += 0.02
            let_news_pass(state, now_s)
        return state.message() is not None and state.message().number == number

    state.accept(Snapshot(message=Message(1, "Saved me.png")))
    assert is_in_sight(1, frames=300)
    now_s += 3600.0
    assert is_in_sight(1, frames=50), "nobody was there"
    assert not is_in_sight(1, frames=60)
    state.accept(Snapshot(message=Message(2, "Saved me.png")))
    assert is_in_sight(2, frames=300), "said once more it is news again"
    state.accept(Snapshot(message=Message(3, "me.png: no such file", is_error=True)))
    assert is_in_sight(3, frames=3000)


def test_the_name_in_sight_follows_the_kind_of_file(tmp_path):
    state = EditorState()
    state.accept(Snapshot(opened=opened_photo(tmp_path / "me.png")))
    choose_form(state, ".jpg")
    assert state.export_path == "me-relit.jpg"
    assert export_place(state) == tmp_path / "me-relit.jpg"
    state.accept(Snapshot(opened=opened_photo(tmp_path / "you.png")))
    assert state.export_path == "you-relit.jpg"
    state.export_path = "version.2"
    choose_form(state, ".exr")
    assert state.export_path == "version.2.exr"


def test_choosing_a_face_keeps_the_decoded_photo_and_the_export_path(tmp_path):
    state = EditorState()
    opened = opened_photo(tmp_path / "two.png")
    state.accept(Snapshot(opened=opened))
    state.export_path = "elsewhere.png"
    state.choose_face(1)
    assert state.photo.place is opened.photo
    assert state.photo.face_index == 1
    again = OpenPhoto(state.photo, opened.photo, opened.screen)
    state.accept(Snapshot(opened=again))
    assert state.export_path == "elsewhere.png"


def test_an_export_is_named_from_the_photos_folder(tmp_path):
    state = EditorState()
    state.accept(Snapshot(opened=opened_photo(tmp_path / "me.png")))
    assert (state.export_path, export_place(state)) == ("me-relit.png", tmp_path / "me-relit.png")
    state.export_path = "best.png"
    assert export_place(state) == tmp_path / "best.png"
    export_to(state, tmp_path / "other.png")
    assert state.export_path == "other.png"
    export_to(state, tmp_path.parent / "far.png")
    assert export_place(state) == tmp_path.parent / "far.png"


def test_while_the_hand_moves_only_what_fills_the_viewport_is_asked_for():
    state = EditorState()
    state.hand_on_control = True
    state.change(yaw_deg=5.0)
    assert state.request().edit.channels == ()
    state.shown = "shadow"
    state.change(yaw_deg=6.0)
    assert state.request().edit.channels == ("shadow",)
    state.hand_on_control = False
    assert state.request().edit.channels is None


def test_the_budget_decides_the_quality_while_the_hand_moves():
    costs = {"draft": TierCost(8.0, 0.03), "live": TierCost(25.0, 0.01), "final": TierCost(60.0, 0.0)}
    state = EditorState(snapshot=Snapshot(tier_costs=costs), hand_on_control=True)
    for budget_ms, quality in ((10.0, "draft"), (33.0, "live"), (100.0, "final")):
        state.quality = QualityChoice("auto", budget_ms)
        state.change(yaw_deg=budget_ms)
        assert state.request().edit.quality == quality
    state.quality, state.hand_on_control = QualityChoice("draft"), False
    assert state.request().edit.quality == "draft"


def test_at_rest_it_is_known_what_the_hand_will_ask_for():
    state = EditorState(quality=QualityChoice("auto"))
    state.change(shadow=0.5)
    wish = state.request().in_motion
    assert (wish.quality, wish.surface_of, wish.shadow) == ("live", "final", 0.5)
    state.hand_on_control = True
    state.change(shadow=0.7)
    assert state.request().in_motion is None
    state.quality, state.hand_on_control = QualityChoice("final"), False
    assert state.request().in_motion is None


@pytest.mark.parametrize(("wish", "in_motion"), [("auto", "final"), ("live", None), ("draft", None), ("final", None)])
def test_what_moves_is_on_the_surface_that_the_picture_at_rest_has(wish, in_motion):
    state = EditorState(quality=QualityChoice(wish))
    assert state.request().edit.surface_of is None
    state.hand_on_control = True
    state.change(yaw_deg=10.0)
    assert state.request().edit.surface_of == in_motion
    state.hand_on_control = False
    assert state.request().edit.surface_of is None


def test_a_large_photo_is_shown_whole_only_when_one_looks_closer_and_waits():
    snapshot = Snapshot(opened=opened_photo())
    state = EditorState(photo=snapshot.opened.source, snapshot=snapshot)
    assert 1000 < state.request().longest_side_px < 4000
    state.view = View(fit=False, zoom=2.0)
    assert state.request().longest_side_px is None
    state.hand_on_control = True
    state.change(yaw_deg=5.0)
    assert 1000 < state.request().longest_side_px < 4000


def test_a_photo_on_its_way_will_be_all_in_sight_however_near_the_one_before_it_was():
    snapshot = Snapshot(opened=opened_photo())
    state = EditorState(photo=snapshot.opened.source, snapshot=snapshot, view=View(fit=False, zoom=2.0))
    state.open_photo(Path("/photos/next.jpg"))
    assert 1000 < state.request().longest_side_px < 4000
    state = EditorState()
    state.open_photo(Path("/photos/first.jpg"))
    assert 1000 < state.request().longest_side_px < 4000


def test_a_light_that_was_refused_is_tried_again_when_it_is_chosen_again():
    state = EditorState(extra_lights=[SKY])
    state.choose_light(SKY)
    state.accept(Snapshot(refused=frozenset({SKY})))
    assert state.light.kind == "rig"
    state.choose_light(LightSource("panorama", SKY.name))
    state.accept(state.snapshot)
    assert state.light.same_as(SKY)
    assert state.extra_lights == [state.light]


@pytest.mark.parametrize("tool", [face_edits, brush_edits])
def test_a_tool_over_the_picture_stops_what_moves_and_shows_the_whole_photo(tool):
    state, opened = EditorState(playing=True, aim=AimTool("bright"), shown="albedo"), opened_photo(Path("/p/me.png"))
    state.photo = opened.source
    state.snapshot = Snapshot(opened=opened, picture=SimpleNamespace())
    tool.show(state)
    assert (state.playing, state.aim.target, state.shown) == (False, "", "result")
    assert [state.faces.is_open, state.brush.is_open] == [tool is face_edits, tool is brush_edits]


def test_the_next_photo_is_shown_relit_whatever_was_shown_of_the_one_before():
    state = EditorState()
    state.accept(Snapshot(opened=opened_photo(Path("/p/me.png"))))
    state.shown, state.aim.target, state.aim.has_placed = "albedo", "bright", True
    state.accept(Snapshot(opened=opened_photo(Path("/p/you.png"))))
    assert (state.shown, state.aim.target, state.aim.has_placed) == ("result", "", False)
