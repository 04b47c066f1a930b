"""A quick tier on the surface that a finer one has found: what runs, what is shared, and that history adds nothing."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_relighter import EDIT, computed, some_light, some_photo

from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.networks.bundle import load_bundle, save_bundle
from relight_core.pipeline.quality import Tier, tier_of
from relight_core.pipeline.relighter import Relighter

LIVE, FINAL = replace(EDIT, quality="live"), replace(EDIT, quality="final")
LIVE_ON_FINAL = replace(EDIT, quality="live", surface_of="final")
BOX, OTHER_BOX = FaceBox(24, 20, 72, 76), FaceBox(4, 4, 20, 20)


def images(*edits, relighter):
    return [relighter.relight(some_light(), edit).image for edit in edits]


def test_a_surface_that_is_known_is_not_found_again(relighter):
    relighter.relight(some_light(), FINAL)
    quick = relighter.relight(some_light(1), LIVE_ON_FINAL)
    assert "specular_shadow" in computed(quick)
    assert not computed(quick) & {"delight", "relief", "normals", "albedo", "source_light"}


def test_a_slider_that_is_moved_and_let_go_finds_nothing_of_the_light_again(relighter):
    for edit in (FINAL, LIVE_ON_FINAL):
        relighter.relight(some_light(), edit)
    let_go = relighter.relight(some_light(), replace(FINAL, shadow=0.5))
    moved_again = relighter.relight(some_light(), replace(LIVE_ON_FINAL, shadow=0.4))
    for moved in (let_go, moved_again):
        assert {"sliders", "detail"} <= computed(moved)
        assert not computed(moved) & {"irradiance", "detail_fit"}


def test_one_that_is_not_known_is_not_waited_for(relighter):
    on_its_own, plain = images(LIVE_ON_FINAL, LIVE, relighter=relighter)
    np.testing.assert_array_equal(on_its_own, plain)
    assert "delight" in computed(relighter.relight(some_light(), FINAL))


@pytest.mark.parametrize("grey", [False, True])
def test_the_picture_is_that_of_the_tier_alone(weights, small_and_seeing_faces, grey):
    photo = some_photo()
    if grey:
        photo = Photo(np.repeat(photo.linear.mean(-1, keepdims=True), 3, -1))
    before, fresh = Relighter(weights), Relighter(weights)
    for relighter in (before, fresh):
        relighter.set_portrait(photo)
    plain, _, after = images(LIVE, FINAL, LIVE_ON_FINAL, relighter=before)
    (alone,) = images(replace(EDIT, quality=tier_of("live").on_surface_of(tier_of("final"))), relighter=fresh)
    np.testing.assert_array_equal(after, alone)
    assert np.abs(after - plain).max() > 1e-3
    np.testing.assert_array_equal(images(LIVE, relighter=before)[0], plain)


def test_a_face_that_is_new_is_not_mixed_with_those_that_are_known(relighter):
    photo = some_photo()
    relighter.set_portrait(photo, boxes=[BOX])
    relighter.relight(some_light(), FINAL)
    relighter.set_portrait(photo, boxes=[BOX, OTHER_BOX])
    on_its_own, plain = images(LIVE_ON_FINAL, LIVE, relighter=relighter)
    np.testing.assert_array_equal(on_its_own, plain)


def test_everything_that_decides_about_a_surface_is_taken_over():
    quick, fine = (
        Tier(64, 32, 32, 16, False, pair="narrow"),
        Tier(96, 64, 64, 32, True, True, True, "fp32", "wide", True, True),
    )
    assert quick.on_surface_of(fine).surface_key == fine.surface_key
    assert replace(quick.on_surface_of(fine), **of_surface(quick)) == quick, "and nothing else"


@pytest.mark.parametrize(
    "change",
    [{"size": 96}, {"delight_size": 64}, {"network_size": 64}, {"mirrored": True}, {"precision": "fp32"}],
)
def test_a_tier_that_sees_the_photo_in_another_way_has_a_surface_of_its_own(change):
    """Else a bench would measure one tier on what another one has found."""
    tier = Tier(64, 32, 32, 16, False)
    other = replace(tier, **change)
    assert other.surface_key != tier.surface_key
    assert tier.on_surface_of(other) != tier
    assert tier.on_surface_of(other).surface_key == other.surface_key


def test_a_tier_with_another_relief_shares_the_surface_alone():
    tier = Tier(64, 32, 32, 16, False)
    other = replace(tier, relief_size=32)
    assert (other.surface_key, other.begun_key) == (tier.surface_key, tier.begun_key)
    assert other.relief_key != tier.relief_key


def of_surface(tier):
    names = ("delight_size", "network_size", "mirrored", "looks_twice", "precision", "apart_from", "level_of")
    return {name: getattr(tier, name) for name in names}


def test_a_tier_on_its_own_surface_is_that_tier(relighter):
    relighter.relight(some_light(), FINAL)
    again = relighter.relight(some_light(), replace(FINAL, surface_of="final"))
    assert not computed(again) - {"channels"}


def test_the_plan_is_that_of_the_picture(relighter):
    relighter.relight(some_light(), FINAL)
    relighter.relight(some_light(), LIVE_ON_FINAL)
    plan = relighter.plan(some_light(), LIVE_ON_FINAL)
    assert plan.effect("shadow").state == "reused"
    assert relighter.plan(some_light(), LIVE).effect("shadow").state == "computed"


def test_a_quality_that_nobody_knows(relighter):
    with pytest.raises(InputError, match="finest"):
        relighter.relight(some_light(), replace(EDIT, surface_of="finest"))


@pytest.mark.parametrize("edit", [LIVE, FINAL, LIVE_ON_FINAL])
def test_who_got_ready_has_only_the_light_left_to_do(relighter, weights, edit):
    relighter.relight(some_light(), FINAL)
    relighter.get_ready(some_light(), edit)
    shown = relighter.relight(some_light(1), edit)
    once = {"view", "delight", "normals", "relief", "albedo", "source_light", "begun", "residual", "edges", "makeup"}
    assert not computed(shown) & once
    assert "specular_shadow" in computed(shown)
    fresh = Relighter(weights)
    fresh.set_portrait(some_photo())
    fresh.relight(some_light(), FINAL)
    np.testing.assert_array_equal(fresh.relight(some_light(1), edit).image, shown.image)


def test_getting_ready_takes_nothing_from_the_picture_in_force(relighter):
    relighter.relight(some_light(), FINAL)
    relighter.get_ready(some_light(), LIVE_ON_FINAL)
    assert not computed(relighter.relight(some_light(), FINAL)) - {"channels"}


def test_nobody_gets_ready_without_a_portrait(weights):
    with pytest.raises(InputError, match="no portrait"):
        Relighter(weights).get_ready(some_light(), LIVE)


def test_the_photos_own_light_is_as_bright_in_the_draft_as_at_rest(weights, tmp_path, small_and_seeing_faces):
    bundle = load_bundle(weights)
    bundle.composition.head.bias.data -= 0.2
    save_bundle(tmp_path / "darkening.safetensors", bundle)
    relighter = Relighter(tmp_path / "darkening.safetensors")
    relighter.set_portrait(some_photo())
    own, uncorrected = relighter.estimated_light("final"), replace(tier_of("draft"), correction=False)
    at_rest, moving = (
        relighter.relight(own, edit).image for edit in (FINAL, replace(EDIT, quality=uncorrected, surface_of="final"))
    )
    assert moving.mean() == pytest.approx(at_rest.mean(), rel=0.02)
