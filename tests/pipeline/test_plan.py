"""The plan: what is left out and why, and that no rule errs by more than it says."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relight_core.errors import InputError
from relight_core.lighting.lamps import Lamp
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_light.kept_lights import KeptLights
from relight_core.pipeline.plan import Scene, displayed_change, light_change, make_plan
from relight_core.pipeline.quality import Tier

TIER = Tier(64, 32, 32, 16, False)
SCENE = Scene(TIER, b"light", 0.0, "backdrop", 1.0)
EFFECTS = {
    "foreign_shadow",
    "flattening",
    "source_light",
    "relief",
    "shadow",
    "hard_shadow",
    "specular",
    "correction",
    "residual",
    "sliders",
    "detail",
    "catchlights",
    "background",
    "channels",
}


def states(plan):
    return {effect.name: effect.state for effect in plan.effects}


def everything(stage, key):
    return True


def test_every_effect_is_decided_about_in_words():
    plan = make_plan(SCENE, Edit())
    assert set(states(plan)) == EFFECTS
    assert all(effect.why for effect in plan.effects)


def test_what_changes_nothing_is_skipped_and_says_so():
    plan = make_plan(SCENE, Edit(channels=()))
    skipped = {name for name, state in states(plan).items() if state == "skipped"}
    assert skipped == {"foreign_shadow", "hard_shadow", "sliders", "catchlights", "background", "channels"}
    assert all(plan.effect(name).bound == 0 for name in skipped)


@pytest.mark.parametrize("faces", [1, 2])
def test_a_shadow_from_outside_is_taken_off_where_one_falls_on_a_face(faces):
    plan = make_plan(replace(SCENE, in_foreign_shadow=faces), Edit())
    assert plan.runs("foreign_shadow")
    assert plan.effect("foreign_shadow").bound == 0
    off = make_plan(replace(SCENE, in_foreign_shadow=faces), Edit(forced_off=frozenset({"foreign_shadow"})))
    assert (off.runs("foreign_shadow"), off.effect("foreign_shadow").bound) == (False, None)


def test_black_light_needs_no_network():
    plan = make_plan(replace(SCENE, level=0.0), Edit(channels=()))
    for name in ("flattening", "source_light", "shadow", "specular", "correction", "relief"):
        assert states(plan)[name] == "skipped"


def test_only_small_lamps_call_for_edges_and_another_lamp_for_other_edges():
    near, far = (Lamp((x, 0.0, 0.8), 1.0, 2.0, 1.0) for x in (0.6, -0.6))
    none, one, other = (make_plan(replace(SCENE, lamps=lamps), Edit()) for lamps in ((), (near,), (far,)))
    assert not none.runs("hard_shadow")
    assert none.effect("hard_shadow").bound == 0
    assert one.runs("hard_shadow")
    assert one.keys["specular_shadow"] == other.keys["specular_shadow"]
    assert one.keys["compose"] != other.keys["compose"]


@pytest.mark.parametrize("effects", [{"shadow", "specular"}, {"relief"}, {"hard_shadow"}])
def test_edges_need_a_shadow_or_gloss_and_a_relief(effects):
    scene, edit = replace(SCENE, lamps=(Lamp((0.6, 0.0, 0.8), 1.0, 2.0, 1.0),)), Edit(forced_off=frozenset(effects))
    plan = make_plan(scene, edit)
    assert not plan.runs("hard_shadow")
    assert plan.keys["compose"] == make_plan(replace(scene, lamps=()), edit).keys["compose"]


@pytest.mark.parametrize("left_out", ["shadow", "specular"])
def test_a_lamp_s_gloss_has_edges_without_its_shadow_and_its_shadow_without_gloss(left_out):
    scene = replace(SCENE, lamps=(Lamp((0.6, 0.0, 0.8), 1.0, 2.0, 1.0),))
    assert make_plan(scene, Edit(forced_off=frozenset({left_out}))).runs("hard_shadow")


def test_a_channel_that_is_looked_at_is_made():
    assert make_plan(SCENE, Edit(channels=("source_light",))).runs("source_light")
    without = frozenset({"flattening", "residual"})
    assert not make_plan(SCENE, Edit(channels=("albedo",), forced_off=without)).runs("source_light")
    black = replace(SCENE, level=0.0)
    assert make_plan(black, Edit(channels=("albedo",))).runs("flattening")
    measured = make_plan(black, Edit(channels=("source_light",)))
    assert measured.runs("flattening")
    assert measured.runs("residual")


@pytest.mark.parametrize(("reader", "word"), [("flattening", "flattening"), ("residual", "misses")])
def test_each_reader_needs_the_light_the_photo_was_taken_under(reader, word):
    other = {"flattening", "residual"} - {reader}
    plan = make_plan(SCENE, Edit(channels=(), forced_off=frozenset(other)))
    assert plan.runs("source_light")
    assert word in plan.effect("source_light").why


def test_the_user_has_the_last_word():
    off = make_plan(SCENE, Edit(forced_off=frozenset({"shadow", "detail", "background"}), background="light"))
    assert [off.effect(name).state for name in ("shadow", "detail", "background")] == ["skipped"] * 3
    assert off.effect("shadow").bound is None
    on = make_plan(replace(SCENE, level=0.0), Edit(channels=(), forced_on=frozenset({"correction", "source_light"})))
    assert on.runs("correction")
    assert on.runs("source_light")
    assert on.runs("relief")


def test_what_is_turned_off_says_who_still_uses_it():
    off = make_plan(SCENE, Edit(forced_off=frozenset({"relief", "source_light", "residual"})))
    for name in ("relief", "source_light"):
        assert off.effect(name).state == "skipped"
        assert "flattening still uses it" in off.effect(name).why
    level = make_plan(SCENE, Edit(channels=("source_light",), forced_off=frozenset({"residual"})))
    assert not level.runs("residual")
    assert "source light's level still uses it" in level.effect("residual").why
    alone = make_plan(SCENE, Edit(forced_off=frozenset({"relief", "residual", "flattening"})))
    assert "use" not in alone.effect("relief").why


@pytest.mark.parametrize("reader", ["flattening", "source_light", "residual", "shadow", "specular"])
def test_each_reader_needs_the_relief(reader):
    readers = {"flattening", "source_light", "residual", "shadow", "specular"}
    assert make_plan(SCENE, Edit(forced_off=frozenset(readers - {reader}))).runs("relief")
    assert not make_plan(SCENE, Edit(forced_off=frozenset(readers))).runs("relief")


def test_a_cheap_tier_has_no_networks_until_the_user_wants_them():
    scene = replace(SCENE, tier=replace(TIER, shadow_network=False, correction=False))
    plan = make_plan(scene, Edit())
    assert not plan.shadow_network
    assert not plan.runs("correction")
    assert plan.runs("shadow")
    forced = make_plan(scene, Edit(forced_on=frozenset({"shadow", "correction"})))
    assert forced.shadow_network
    assert forced.runs("correction")
    both = make_plan(scene, Edit(forced_on=frozenset({"specular"})))
    assert "by the network" in both.effect("shadow").why, "one network finds both"


@pytest.mark.parametrize("light_bound", [0.0, 0.003])
def test_where_the_quality_leaves_the_shadow_network_out_no_bound_is_claimed(light_bound):
    scene = replace(SCENE, tier=replace(TIER, shadow_network=False), light_bound=light_bound)
    for name in ("shadow", "specular"):
        assert make_plan(scene, Edit()).effect(name).bound is None
        assert make_plan(scene, Edit(forced_on=frozenset({name}))).effect(name).bound == light_bound
    near = make_plan(scene, Edit(), everything).effect("shadow")
    assert (near.state, "nearly one seen before" in near.why) == ("reused", light_bound > 0)


def test_an_effect_that_does_not_exist_names_those_that_do():
    with pytest.raises(InputError, match="correction"):
        make_plan(SCENE, Edit(forced_off=frozenset({"glow"})))


def test_what_is_kept_is_reused_within_the_bound_of_its_light():
    plan = make_plan(replace(SCENE, light_bound=0.003), Edit(), everything, {"compose": 7.0})
    correction, relief = plan.effect("correction"), plan.effect("relief")
    assert (correction.state, correction.bound, correction.saved_ms) == ("reused", 0.003, 7.0)
    assert "0.3 %" in correction.why
    assert (relief.state, relief.bound) == ("reused", 0.0)


@pytest.mark.parametrize(
    ("change", "untouched", "touched"),
    [
        ({"exposure_ev": 2.0}, {"compose", "sliders", "background", "channels"}, set()),
        ({"shadow": 0.5}, {"compose", "specular_shadow", "panorama"}, {"sliders", "detail", "background"}),
        ({"strength": 0.5}, {"compose", "sliders", "detail", "catchlights", "channels"}, {"strength", "background"}),
        ({"background": "transparent"}, {"compose", "detail", "strength"}, {"background"}),
    ],
)
def test_a_key_names_what_its_stage_reads_and_nothing_else(change, untouched, touched):
    edit = Edit(background="#102030")
    before, after = make_plan(SCENE, edit).keys, make_plan(SCENE, replace(edit, **change)).keys
    assert all(before[name] == after[name] for name in untouched)
    assert all(before[name] != after[name] for name in touched)


PICTURE = {"detail_fit", "sliders", "detail", "strength", "background", "channels"}
HIDDEN = {"specular_shadow", "hard_shadow", "compose", "residual", "catchlights"}


@pytest.mark.parametrize(
    ("effect", "touched"),
    [
        ("shadow", {"compose"} | PICTURE),
        ("specular", {"compose"} | PICTURE),
        ("correction", {"compose", "residual"} | PICTURE),
        ("residual", PICTURE),
        ("detail", PICTURE),
        ("relief", HIDDEN | PICTURE),
        ("flattening", {"surface", "irradiance"} | HIDDEN | PICTURE),
    ],
)
def test_what_is_turned_off_is_made_anew_by_all_that_reads_it_and_nothing_else(effect, touched):
    before, after = (make_plan(SCENE, Edit(forced_off=off)).keys for off in (frozenset(), frozenset({effect})))
    assert {name for name in before if before[name] != after[name]} == touched


def test_a_network_that_is_turned_on_makes_anew_all_that_reads_it():
    cheap = replace(SCENE, tier=replace(TIER, shadow_network=False))
    before, after = (make_plan(cheap, Edit(forced_on=on)).keys for on in (frozenset(), frozenset({"shadow"})))
    assert {name for name in before if before[name] != after[name]} == HIDDEN | PICTURE


def test_eyes_that_mirror_another_light_make_another_picture():
    one, other = (make_plan(replace(SCENE, irises=2, mirrored=light), Edit()).keys for light in ("sun", "sky"))
    assert {name for name in one if one[name] != other[name]} == {"catchlights", "strength", "background"}


def test_another_channel_that_is_looked_at_is_made_and_nothing_else():
    one, other = (make_plan(SCENE, Edit(channels=(name,))).keys for name in ("shadow", "specular"))
    assert {name for name in one if one[name] != other[name]} == {"channels"}


def test_a_turn_of_a_panorama_that_nobody_sees_moves_no_background():
    turned = replace(SCENE, backdrop="turned")
    for background, same in (("#102030", True), ("light", False)):
        edit = Edit(background=background)
        keys = [make_plan(scene, edit).keys["background"] for scene in (SCENE, turned)]
        assert (keys[0] == keys[1]) is same


LIGHT = np.random.default_rng(0).gamma(0.5, 1.0, (16, 32, 3)).astype(np.float32)


@given(st.floats(0.0, 0.2), st.integers(0, 99))
def test_no_sum_over_texels_changes_by_more_than_the_texels(size, seed):
    rng = np.random.default_rng(seed)
    other = LIGHT * np.exp(rng.uniform(-size, size, LIGHT.shape)).astype(np.float32)
    weights = rng.random((50, 512)) * (rng.random((50, 512)) < 0.1)
    before, after = (np.maximum(weights @ light.reshape(512, 3), 1e-3) for light in (LIGHT, other))
    change = light_change(LIGHT, other)
    assert np.abs(np.log(after / before)).max() <= change + 1e-4
    codes = [np.clip(1.055 * np.clip(x, 0.0031308, 1) ** (1 / 2.4) - 0.055, 0, 1) for x in (before, after)]
    assert np.abs(codes[0] - codes[1]).max() <= displayed_change(change) + 1e-4


def serving(lights, group, light, tolerance):
    """The light that serves, as for results that are then computed."""
    served = lights.match(group, light, tolerance)
    lights.keep(group, served)
    return served


def test_asking_which_light_would_serve_keeps_none():
    lights = KeptLights(4)
    lights.match("tier", LIGHT, 2 / 255)
    near = LIGHT * np.float32(1.00001)
    np.testing.assert_array_equal(lights.match("tier", near, 2 / 255).radiance, near)


def test_what_is_computed_for_a_near_light_says_so_too():
    plan = make_plan(replace(SCENE, light_bound=0.003), Edit())
    assert {plan.effect(name).state for name in ("shadow", "detail", "residual")} == {"computed"}
    assert [plan.effect(name).bound for name in ("shadow", "detail", "residual")] == [0.003, 0.003, 0.0]


def test_nearly_the_same_light_finds_the_kept_one():
    lights = KeptLights(4)
    first = serving(lights, "tier", LIGHT, 2 / 255)
    again = serving(lights, "tier", LIGHT * np.float32(1.00001), 2 / 255)
    assert again.name == first.name
    assert 0 < again.bound < 2 / 255
    np.testing.assert_array_equal(again.radiance, LIGHT)


def test_within_a_code_value_nothing_serves_but_the_same_light():
    lights = KeptLights(4)
    serving(lights, "tier", LIGHT, 1 / 255)
    near = LIGHT * np.float32(1.0000002)
    served = serving(lights, "tier", near, 1 / 255)
    assert served.bound == 0
    np.testing.assert_array_equal(served.radiance, near)


def test_another_light_serves_itself():
    lights = KeptLights(4)
    first = serving(lights, "tier", LIGHT, 2 / 255)
    other = np.roll(LIGHT, 1, axis=1)
    second = serving(lights, "tier", other, 2 / 255)
    assert second.name != first.name
    assert second.bound == 0
    np.testing.assert_array_equal(second.radiance, other)


def test_small_changes_do_not_add_up():
    lights = KeptLights(100)
    tolerance, drift = 2 / 255, LIGHT
    for _ in range(200):
        drift = drift * np.float32(1.00001)
        served = serving(lights, "tier", drift, tolerance)
        assert displayed_change(light_change(served.radiance, drift)) <= tolerance + 1e-6


def test_without_tolerance_only_the_same_light_serves():
    lights = KeptLights(4)
    serving(lights, "tier", LIGHT, 0.0)
    assert serving(lights, "tier", LIGHT * np.float32(1.00001), 0.0).bound == 0
    assert serving(lights, "tier", LIGHT, 0.0).bound == 0


def test_groups_and_age_part_lights():
    lights = KeptLights(2)
    serving(lights, "one tier", LIGHT, 0.0)
    near = LIGHT * np.float32(1.00001)
    assert serving(lights, "another tier", near, 2 / 255).bound == 0
    for number in (2, 3):
        serving(lights, "one tier", LIGHT * np.float32(number), 0.0)
    assert serving(lights, "one tier", near, 2 / 255).bound == 0


def test_a_light_that_was_gone_back_to_is_kept_longer():
    lights = KeptLights(2)
    for number in (1, 2, 1, 3):
        serving(lights, "one tier", LIGHT * np.float32(number), 0.0)
    assert serving(lights, "one tier", LIGHT * np.float32(1.00001), 2 / 255).bound > 0


def test_eyes_mirror_a_light_where_irises_are_seen():
    seen = replace(SCENE, irises=2, mirrored="sky")
    assert make_plan(seen, Edit()).runs("catchlights")
    assert make_plan(SCENE, Edit()).effect("catchlights").why.startswith("no iris")
    assert not make_plan(replace(seen, level=0.0), Edit()).runs("catchlights")
    turned = replace(seen, mirrored="sky, turned")
    keys = [make_plan(scene, Edit()).keys for scene in (seen, turned)]
    assert keys[0]["catchlights"] != keys[1]["catchlights"]
    assert keys[0]["background"] != keys[1]["background"]
    assert keys[0]["detail"] == keys[1]["detail"]
    rest_off = Edit(channels=(), forced_off=frozenset({"flattening", "residual"}))
    assert make_plan(seen, rest_off).effect("source_light").why == "the eyes' own catchlights stay under it"
    off = Edit(forced_off=frozenset({"catchlights"}))
    assert make_plan(seen, off).keys == make_plan(turned, off).keys
