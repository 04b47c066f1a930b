"""What the Relighter computes, what it reuses, and that neither shows in the picture."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tiny_relighter import EDIT, NETWORK_STAGES, computed, some_light, some_photo, states

from relight_core.lighting.environment import Environment
from relight_core.lighting.panorama import rotate
from relight_core.lighting.sphere import direction_at
from relight_core.pipeline import cache, face_relighter, stages
from relight_core.pipeline.auto_quality import Calibration
from relight_core.pipeline.cache import computed_ms
from relight_core.pipeline.face_taken_apart import Workshop
from relight_core.pipeline.per_light.fine_edges import FineEdges
from relight_core.pipeline.relighter import Relighter

pytestmark = pytest.mark.usefixtures("small_and_seeing_faces")


def test_first_relighting_computes_every_network_stage(relighter):
    assert computed(relighter.relight(some_light(), EDIT)) >= NETWORK_STAGES


def test_same_again_computes_nothing(relighter):
    first = relighter.relight(some_light(), EDIT)
    again = relighter.relight(some_light(), EDIT)
    assert computed(again) == set()
    np.testing.assert_array_equal(again.image, first.image)


def test_who_writes_into_a_picture_or_a_channel_is_told_instead_of_changing_the_next(relighter):
    edit = replace(EDIT, background="transparent")
    relit = relighter.relight(some_light(), edit)
    for array in (relit.image, relit.alpha, *relit.channels.values()):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0


def test_exposure_computes_nothing(relighter):
    first = relighter.relight(some_light(), EDIT)
    brighter = relighter.relight(some_light(), replace(EDIT, exposure_ev=3.0))
    assert computed(brighter) == set()
    np.testing.assert_array_equal(brighter.image, first.image)


@pytest.mark.parametrize(
    ("slider", "value"), [("specular", 1.7), ("shadow", 1.7), ("specular_tint", 0.8), ("shadow_softness", 1.0)]
)
def test_a_slider_runs_no_network(relighter, slider, value):
    first = relighter.relight(some_light(), EDIT)
    moved = relighter.relight(some_light(), replace(EDIT, **{slider: value}))
    assert computed(moved)
    assert not computed(moved) & (NETWORK_STAGES | {"relief", "irradiance", "matte"})
    assert np.abs(moved.image - first.image).max() > 1e-4


def test_yaw_runs_everything_but_what_the_photo_alone_decides(relighter):
    relighter.relight(some_light(), EDIT)
    turned = relighter.relight(some_light(), replace(EDIT, yaw_deg=40.0))
    assert {"specular_shadow", "compose"} <= computed(turned)
    assert not computed(turned) & {"delight", "relief", "matte", "view"}


def test_a_full_turn_gives_the_same_picture(relighter):
    first = relighter.relight(some_light(), EDIT)
    np.testing.assert_allclose(
        relighter.relight(some_light(), replace(EDIT, yaw_deg=360.0)).image, first.image, atol=1e-5
    )


def test_a_new_photo_and_another_quality_run_everything(relighter):
    relighter.relight(some_light(), EDIT)
    assert computed(relighter.relight(some_light(), replace(EDIT, quality="draft"))) >= NETWORK_STAGES
    relighter.set_portrait(some_photo(1))
    assert computed(relighter.relight(some_light(), EDIT)) >= NETWORK_STAGES


def test_a_turn_that_leaves_the_light_as_it_was_computes_nothing(relighter):
    rows = np.random.default_rng(4).random((32, 1, 3)).astype(np.float32)
    sky = Environment.from_radiance(np.repeat(rows, 64, axis=1))
    relighter.relight(sky, EDIT)
    turned = relighter.relight(sky, replace(EDIT, yaw_deg=33.3))
    assert not computed(turned) & {"specular_shadow", "compose", "detail", "paste"}
    assert {effect.state for effect in turned.plan if effect.name in ("shadow", "correction")} == {"reused"}


def test_only_the_level_of_a_light_runs_no_network(relighter):
    relighter.relight(some_light(), EDIT)
    assert not computed(relighter.relight(some_light(level=3.0), EDIT)) & NETWORK_STAGES


def test_going_back_to_a_light_runs_no_network(relighter):
    for seed in range(5):
        relighter.relight(some_light(seed), EDIT)
    assert not computed(relighter.relight(some_light(0), EDIT)) & NETWORK_STAGES


def test_only_the_channels_that_are_looked_at_are_made(relighter):
    unread = frozenset({"flattening", "residual"})
    relit = relighter.relight(some_light(), replace(EDIT, channels=("normal", "shadow"), forced_off=unread))
    assert set(relit.channels) == {"normal", "shadow"}
    assert not computed(relit) & {"source_light", "albedo"}
    alone = relighter.relight(some_light(1), replace(EDIT, channels=()))
    assert alone.channels == {}
    assert states(alone)["channels"] == "skipped"


def test_the_plan_says_beforehand_what_is_done(relighter):
    for edit in (EDIT, replace(EDIT, shadow=0.4), replace(EDIT, background="light"), replace(EDIT, channels=())):
        foretold = {effect.name: effect.state for effect in relighter.plan(some_light(), edit).effects}
        relit = relighter.relight(some_light(), edit)
        assert {effect.name: effect.state for effect in relit.plan} == foretold
        assert (foretold["correction"] == "computed") == ("compose" in computed(relit))


def test_the_residual_is_measured_with_what_lights_are_reflected_by(relighter, monkeypatch):
    made, reflector = [], stages.reflector
    monkeypatch.setattr(stages, "reflector", lambda *surface: made.append(1) or reflector(*surface))
    relighter.set_portrait(some_photo(), 0)
    relighter.relight(some_light(), EDIT)
    assert len(made) == 1


def test_asking_for_the_plan_changes_no_picture(relighter, weights):
    near = Environment(some_light().shape * np.float32(1.00001), 1.0, "near")
    edit = replace(EDIT, tolerance=2 / 255)
    relighter.plan(some_light(), edit)
    asked = relighter.relight(near, edit).image
    other = Relighter(weights)
    other.set_portrait(some_photo())
    np.testing.assert_array_equal(asked, other.relight(near, edit).image)


@pytest.mark.parametrize(
    "edits",
    [
        [EDIT, replace(EDIT, shadow=0.2), replace(EDIT, specular=2.0, channels=())],
        [EDIT, replace(EDIT, yaw_deg=25.0), EDIT],
        [replace(EDIT, channels=()), replace(EDIT, background="light"), replace(EDIT, background="light", yaw_deg=9.0)],
    ],
)
def test_what_is_left_out_or_reused_changes_nothing(weights, relighter, edits):
    """With the plan's rules and without: every picture is the same."""
    everything = frozenset({"source_light", "relief", "shadow", "specular", "correction", "sliders", "channels"})
    for edit in edits:
        without = Relighter(weights)
        without.set_portrait(some_photo())
        thorough = without.relight(some_light(), replace(edit, channels=None, forced_on=everything))
        np.testing.assert_allclose(relighter.relight(some_light(), edit).image, thorough.image, atol=1e-6)


@pytest.mark.parametrize("effect", ["shadow", "specular", "correction", "detail", "relief"])
def test_an_effect_turned_off_is_gone_and_comes_back(relighter, effect):
    first = relighter.relight(some_light(), EDIT)
    off = relighter.relight(some_light(), replace(EDIT, forced_off=frozenset({effect})))
    assert np.abs(off.image - first.image).max() > 1e-4
    if effect in ("shadow", "specular"):
        assert off.channels[effect].max() == 0
    np.testing.assert_array_equal(relighter.relight(some_light(), EDIT).image, first.image)


@pytest.mark.parametrize(("effect", "other"), [("specular", "shadow"), ("shadow", "specular")])
def test_no_slider_brings_an_effect_back_that_is_turned_off(relighter, effect, other):
    off = replace(EDIT, forced_off=frozenset({effect}), **{other: 0.5})
    image = relighter.relight(some_light(), off).image
    np.testing.assert_array_equal(relighter.relight(some_light(), replace(off, **{effect: 2.0})).image, image)


def test_without_shadow_and_specular_their_network_rests(relighter):
    relit = relighter.relight(some_light(), replace(EDIT, forced_off=frozenset({"shadow", "specular"})))
    assert states(relit)["specular_shadow"] == "skipped"


def test_forced_on_a_near_light_does_not_serve(relighter):
    light, edit = some_light(), replace(EDIT, tolerance=2 / 255)
    relighter.relight(light, edit)
    near = Environment(light.shape * np.float32(1.00001), 1.0, "near")
    assert not computed(relighter.relight(near, edit)) & NETWORK_STAGES
    forced = relighter.relight(near, replace(edit, forced_on=frozenset({"shadow"})))
    assert "specular_shadow" in computed(forced)


def test_times_of_stages_within_stages_are_not_counted_twice(relighter):
    relit = relighter.relight(some_light(), EDIT)
    ended = max(stage.start_ms + stage.ms for stage in relit.stages.values())
    assert sum(stage.ms for stage in relit.stages.values()) <= ended + 1


def test_every_stage_says_why(relighter):
    assert all(stage.why for stage in relighter.relight(some_light(), EDIT).stages.values())


def test_going_back_gives_back_the_former_picture(relighter):
    """Nothing kept from another light, slider, background or quality may show."""
    first = relighter.relight(some_light(), EDIT)
    for edit in (
        replace(EDIT, yaw_deg=90),
        replace(EDIT, shadow=0.3),
        replace(EDIT, background="#ff0000"),
        replace(EDIT, quality="draft"),
    ):
        relighter.relight(some_light(1), edit)
    again = relighter.relight(some_light(), EDIT)
    np.testing.assert_array_equal(again.image, first.image)
    for name, channel in first.channels.items():
        np.testing.assert_array_equal(again.channels[name], channel)


def sun():
    radiance = np.full((64, 128, 3), 0.05, np.float32)
    radiance[24:26, 84:86] = 500
    return Environment.from_radiance(radiance, "sun")


def test_edges_of_shadows_are_drawn_once_for_a_small_lamp_and_never_for_an_even_light(relighter):
    assert "fine_edges" not in states(
        relighter.relight(Environment.from_radiance(np.ones((32, 64, 3), np.float32), "even"), EDIT)
    )
    assert "fine_edges" in computed(relighter.relight(sun(), EDIT))
    assert "fine_edges" not in computed(relighter.relight(sun(), replace(EDIT, shadow=0.5)))
    assert "fine_edges" in computed(relighter.relight(sun(), replace(EDIT, yaw_deg=5.0)))


def test_edges_drawn_for_a_picture_with_detail_serve_none_without(relighter):
    plain = replace(EDIT, forced_off=frozenset({"detail"}))
    relighter.relight(sun(), EDIT)
    after = relighter.relight(sun(), plain)
    assert "fine_edges" in computed(after)
    relighter.forget_lights()
    np.testing.assert_array_equal(relighter.relight(sun(), plain).image, after.image)


@pytest.mark.parametrize(("slider", "drawn"), [({}, True), ({"shadow": 0.0}, False), ({"shadow_softness": 0.5}, False)])
def test_a_shadow_that_is_taken_away_or_softened_leaves_no_fine_edge(relighter, monkeypatch, slider, drawn):
    edit = replace(EDIT, **slider)
    with_edges = relighter.relight(sun(), edit).image
    monkeypatch.setattr(FineEdges, "gain", lambda edges, *sliders: np.ones((*edges.fine.shape, 3), np.float32))
    relighter.forget_lights()
    assert (np.abs(relighter.relight(sun(), edit).image - with_edges).max() > 1e-4) == drawn


@pytest.mark.parametrize(
    "slider", [{"shadow": 0.0}, {"shadow_softness": 1.0}, {"specular": 2.0}, {"specular_tint": 1.0}]
)
def test_sliders_that_are_turned_off_move_nothing_not_even_the_edges_of_shadows(relighter, slider):
    off = replace(EDIT, forced_off=frozenset({"sliders"}))
    at_rest = relighter.relight(sun(), off).image
    relighter.forget_lights()
    np.testing.assert_array_equal(relighter.relight(sun(), replace(off, **slider)).image, at_rest)


@pytest.mark.parametrize("light", [Environment.from_radiance(np.ones((16, 32, 3), np.float32), "even"), sun()])
def test_measuring_the_tiers_finds_nothing_kept_of_a_light_however_it_was_turned_before(relighter, monkeypatch, light):
    ran, relight = [], relighter.relight

    def noted(*arguments, **how):
        relit = relight(*arguments, **how)
        ran.append(computed(relit))
        return relit

    monkeypatch.setattr(relighter, "relight", noted)
    for _ in range(2):
        calibration = Calibration()
        while calibration.costs is None:
            calibration.measure_next(relighter, light)
    # Of each tier in both rounds, at least its five timed updates.
    assert sum({"specular_shadow", "compose"} <= one for one in ran) >= 2 * 3 * 5


def test_turning_a_light_is_relighting_with_the_turned_panorama(relighter):
    edit = replace(EDIT, background="light")
    by_yaw = relighter.relight(sun(), replace(edit, yaw_deg=90.0))
    turned = relighter.relight(Environment(rotate(sun().shape, 90.0), sun().level, "turned"), edit)
    np.testing.assert_allclose(by_yaw.image, turned.image, rtol=1e-3, atol=1e-4)
    for name in ("specular", "shadow", "composition", "target_light"):
        np.testing.assert_allclose(by_yaw.channels[name], turned.channels[name], rtol=1e-3, atol=1e-4)
    still = relighter.relight(sun(), edit)
    assert np.abs(still.channels["shadow"] - turned.channels["shadow"]).max() > 0.01


def test_small_lamps_turn_with_their_light(relighter, monkeypatch):
    asked, harden = [], face_relighter.harden_shadow
    monkeypatch.setattr(face_relighter, "harden_shadow", lambda *parts: asked.append(parts[5]) or harden(*parts))
    relighter.relight(sun(), replace(EDIT, yaw_deg=90.0))
    (lamp,), *_ = asked
    np.testing.assert_allclose(lamp.toward, direction_at(85 / 128 + 0.25, 25 / 64), atol=0.02)


@pytest.mark.parametrize("change", [{"background_fov_deg": 90.0}, {"background_blur_deg": 12.0}, {"yaw_deg": 40.0}])
def test_another_view_of_the_light_behind_is_another_picture(relighter, change):
    edit = replace(EDIT, background="light")
    image = relighter.relight(some_light(), edit).image
    assert np.abs(relighter.relight(some_light(), replace(edit, **change)).image - image).max() > 0.01


def test_of_several_faces_de_lighting_counts_in_the_time_of_an_update_for_each_of_them(relighter, monkeypatch):
    """Told by a clock that goes on by a second with every view that is de-lit, and at no other time."""
    now_s, delight = [0.0], Workshop.delight

    def take_a_second(*given):
        now_s[0] += 1.0
        return delight(*given)

    monkeypatch.setattr(Workshop, "delight", take_a_second)
    monkeypatch.setattr(cache, "time", SimpleNamespace(perf_counter=lambda: now_s[0]))
    relighter.set_portrait(some_photo(1))
    before_s = now_s[0]
    first = relighter.relight(some_light(), EDIT)
    assert len(first.faces) == 2
    assert computed_ms(first.stages) == pytest.approx(1e3 * (now_s[0] - before_s))
    assert first.stages["other_faces_delight"].ms >= 1e3
    assert first.stages["other_faces_delight"].is_of_photo
    turned = relighter.relight(some_light(), replace(EDIT, yaw_deg=40.0))
    assert turned.stages["other_faces_delight"].state == "reused"
    before_s = now_s[0]
    relighter.forget("delight")
    again = relighter.relight(some_light(), EDIT)
    assert again.stages["other_faces_delight"].ms == first.stages["other_faces_delight"].ms
    assert computed_ms(again.stages) == pytest.approx(1e3 * (now_s[0] - before_s))
