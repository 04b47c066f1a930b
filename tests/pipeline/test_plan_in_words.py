"""What the plan says about each effect: whether it is computed or reused, why, how far off it may be, what it saves."""

import math
from dataclasses import replace

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.lighting.lamps import Lamp
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.plan import Scene, displayed_change, light_change, make_plan, plan_of_own_light
from relight_core.pipeline.quality import Tier

LAMP = Lamp((0.6, 0.0, 0.8), 1.0, 2.0, 1.0)
TIER = Tier(64, 32, 32, 16, False)
EVERYTHING = Scene(TIER, b"light", 0.0, "backdrop", 1.0, (LAMP,), "sky", 2, 1)
EDIT = Edit(shadow=0.5, background="#203040")
STAGES = {
    "foreign_shadow": "delight",
    "flattening": "albedo",
    "source_light": "source_light",
    "relief": "relief",
    "shadow": "specular_shadow",
    "hard_shadow": "hard_shadow",
    "specular": "specular_shadow",
    "correction": "compose",
    "residual": "residual",
    "sliders": "sliders",
    "detail": "detail",
    "catchlights": "catchlights",
    "background": "background",
    "channels": "channels",
}


@pytest.mark.parametrize("kept", sorted(set(STAGES.values())))
def test_an_effect_is_reused_where_its_own_stage_is_kept_and_computed_for_any_other(kept):
    plan = make_plan(EVERYTHING, EDIT, lambda stage, key: stage == kept)
    reused = {effect.name for effect in plan.effects if effect.state == "reused"}
    assert reused == {effect for effect, stage in STAGES.items() if stage == kept}
    assert {effect.state for effect in plan.effects} == {"reused", "computed"}
    assert all(plan.runs(effect) for effect in STAGES)


@pytest.mark.parametrize(("background", "follows"), [("match", True), ("light", False), ("#203040", False)])
@pytest.mark.parametrize("kept", [True, False])
def test_what_a_light_makes_is_as_far_off_as_the_light_that_serves(background, follows, kept):
    scene, edit = replace(EVERYTHING, light_bound=0.003), replace(EDIT, background=background)
    plan = make_plan(scene, edit, lambda stage, key: kept)
    off = {effect.name for effect in plan.effects if effect.bound == 0.003}
    of_light = {"shadow", "hard_shadow", "specular", "correction", "sliders", "detail", "catchlights", "channels"}
    assert off == (of_light | {"background"} if follows else of_light)
    assert {effect.bound for effect in plan.effects if effect.name not in off} == {0.0}


def test_where_the_user_or_the_quality_has_decided_no_bound_is_claimed():
    coarse = replace(EVERYTHING, tier=replace(TIER, correction=False))
    assert make_plan(coarse, EDIT).effect("correction").bound is None
    without = make_plan(EVERYTHING, replace(EDIT, forced_off=frozenset({"relief"})))
    assert without.effect("relief").bound is None
    assert without.effect("hard_shadow").bound is None


def test_each_effect_says_what_the_user_decided_whatever_becomes_of_it():
    edit = replace(EDIT, forced_on=frozenset({"shadow", "correction"}), forced_off=frozenset({"residual"}))
    plan = make_plan(EVERYTHING, edit, lambda stage, key: stage == "compose")
    told = {name: (plan.effect(name).state, plan.effect(name).forced) for name in ("shadow", "correction", "residual")}
    assert told == {"shadow": ("computed", True), "correction": ("reused", True), "residual": ("skipped", False)}
    assert plan.effect("detail").forced is None


def test_it_says_what_time_is_saved_and_of_two_effects_of_one_network_once():
    times = {"specular_shadow": 7.0, "compose": 5.0, "residual": 3.0}
    edit = replace(EDIT, forced_off=frozenset({"residual"}))
    plan = make_plan(EVERYTHING, edit, lambda stage, key: stage != "compose", times)
    saved = {name: plan.effect(name).saved_ms for name in ("shadow", "specular", "correction", "residual", "detail")}
    assert saved == {"shadow": 7.0, "specular": 0.0, "correction": 0.0, "residual": 3.0, "detail": None}


@pytest.mark.parametrize("effect", ["foreign_shadow", "sliders", "detail"])
def test_no_time_is_saved_by_leaving_a_part_out_of_a_stage_that_runs_all_the_same(effect):
    stages = dict.fromkeys(("delight", "sliders", "detail"), 9.0)
    edit = replace(EDIT, forced_off=frozenset({effect}))
    assert make_plan(EVERYTHING, edit, typical_ms=stages).effect(effect).saved_ms is None


@pytest.mark.parametrize(("left_out", "saved_ms"), [({"shadow"}, 0.0), ({"shadow", "specular"}, 7.0)])
def test_leaving_shadow_out_saves_the_network_s_time_only_if_gloss_is_left_out_too(left_out, saved_ms):
    plan = make_plan(EVERYTHING, replace(EDIT, forced_off=frozenset(left_out)), typical_ms={"specular_shadow": 7.0})
    assert plan.effect("shadow").saved_ms == saved_ms


def test_it_counts_lamps_and_readers_as_people_do():
    assert make_plan(EVERYTHING, EDIT).effect("hard_shadow").why.startswith("1 lamp so small")
    two = replace(EVERYTHING, lamps=(LAMP, replace(LAMP, toward=(-0.6, 0.0, 0.8))))
    assert make_plan(two, EDIT).effect("hard_shadow").why.startswith("2 lamps so small")
    off = replace(EDIT, forced_off=frozenset({"source_light"}))
    why = make_plan(EVERYTHING, off).effect("source_light").why
    assert why == "turned off by you; flattening and residual and catchlights still use it"
    off = replace(EDIT, forced_off=frozenset({"source_light", "flattening", "residual"}))
    assert make_plan(EVERYTHING, off).effect("source_light").why == "turned off by you; catchlights still uses it"
    off = replace(EDIT, channels=("albedo",), forced_off=frozenset({"residual"}))
    assert make_plan(EVERYTHING, off).effect("residual").why == "turned off by you"


@pytest.mark.parametrize(
    ("change", "touched"),
    [
        ({"level": 2.0}, {"sliders", "detail", "strength", "background", "channels"}),
        ({"irises": 1}, {"catchlights", "strength", "background"}),
        ({"lamps": ()}, {"hard_shadow", "compose", "detail_fit", "sliders", "detail", "catchlights", "strength"}),
    ],
)
def test_another_scene_makes_anew_what_reads_it(change, touched):
    before, after = (make_plan(scene, EDIT).keys for scene in (EVERYTHING, replace(EVERYTHING, **change)))
    named = {name for name in before if before[name] != after[name]}
    assert named - {"background", "channels"} == touched - {"background", "channels"}
    assert touched <= named


@pytest.mark.parametrize(("effect", "moved"), [("sliders", {"shadow": 0.5}), ("background", {"background": "light"})])
def test_what_is_turned_off_makes_nothing_anew_when_it_is_moved(effect, moved):
    off = Edit(forced_off=frozenset({effect}))
    one, other = (make_plan(EVERYTHING, edit).keys for edit in (off, replace(off, **moved)))
    changed = {name for name in one if one[name] != other[name]}
    assert changed <= {"panorama"}


def test_another_relief_is_measured_anew_on_the_face_that_was_taken_apart():
    coarser = replace(EVERYTHING, tier=replace(TIER, relief_size=8))
    one, other = (make_plan(scene, EDIT).keys for scene in (EVERYTHING, coarser))
    assert one["delight"] == other["delight"]
    assert all(one[name] != other[name] for name in ("albedo", "source_light", "relief"))


def test_what_is_turned_on_runs_though_nothing_reads_it_and_only_if_there_is_such_an_effect():
    readers = frozenset({"flattening", "source_light", "residual", "shadow", "specular"})
    alone = replace(EDIT, forced_off=readers, forced_on=frozenset({"relief"}))
    assert make_plan(EVERYTHING, alone).runs("relief")
    assert make_plan(EVERYTHING, Edit(channels=None)).runs("channels"), "none is named: all are made"
    with pytest.raises(InputError, match="glow"):
        make_plan(EVERYTHING, Edit(forced_on=frozenset({"glow"})))


def test_the_photo_is_modelled_under_its_own_light_whatever_is_asked_for():
    plan = plan_of_own_light(TIER)
    assert all(plan.runs(name) for name in ("shadow", "specular", "correction", "residual", "detail"))
    assert not plan.runs("sliders")


def test_lights_are_told_apart_down_to_a_hundred_thousandth_and_the_same_light_changes_nothing():
    dark = np.zeros((16, 32, 3), np.float32)
    assert light_change(dark, dark + np.float32(2e-5)) == pytest.approx(math.log(2), rel=1e-4)
    assert light_change(dark + np.float32(2e-5), dark) == pytest.approx(math.log(2), rel=1e-4)
    assert light_change(dark, dark + np.float32(9e-6)) == 0
    assert displayed_change(0.0) == 0
