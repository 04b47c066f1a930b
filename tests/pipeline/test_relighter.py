"""The Relighter with tiny random networks: what is reused, what stays linear, what never breaks."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle
from relight_core.pipeline import portrait, quality, stages
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.relighter import Relighter

NETWORK_STAGES = {"delight", "specular_shadow", "compose"}
EDIT = Edit()


@pytest.fixture(scope="module")
def weights(tmp_path_factory):
    torch.manual_seed(3)
    path = tmp_path_factory.mktemp("weights") / "tiny.safetensors"
    bundle = NetworkBundle(BundleConfig.tiny())
    bundle.composition.head.weight.data.normal_(0, 0.02)
    # Untrained logits would leave the person transparent; this bias makes everything skin.
    bundle.delight.head.bias.data[8] = 6.0
    save_bundle(path, bundle)
    return path


@pytest.fixture(autouse=True)
def _small_and_seeing_faces(monkeypatch):
    tiers = {
        "draft": quality.Tier(48, 32, 32, 16, False),
        "live": quality.Tier(64, 32, 32, 16, False),
        "final": quality.Tier(96, 32, 32, 16, True),
    }
    monkeypatch.setattr(quality, "TIERS", tiers)
    monkeypatch.setattr(portrait, "find_faces", lambda photo: [FaceBox(24, 20, 72, 76), FaceBox(4, 4, 20, 20)])


def some_photo(seed=0, size=(96, 112)):
    coarse = np.random.default_rng(seed).random((12, 14, 3))
    linear = np.repeat(np.repeat(coarse, size[0] // 12, 0), size[1] // 14, 1)
    return Photo(np.ascontiguousarray(linear * 0.8 + 0.05, np.float32))


def some_light(seed=0, level=1.0):
    radiance = np.random.default_rng(seed).gamma(0.5, 1, (32, 64, 3)).astype(np.float32)
    shape = Environment.from_radiance(radiance).shape
    return Environment(shape, level, "random")


@pytest.fixture
def relighter(weights):
    relighter = Relighter(weights)
    relighter.set_portrait(some_photo())
    return relighter


def states(relit):
    return {name: stage.state for name, stage in relit.stages.items()}


def computed(relit):
    return {name for name, state in states(relit).items() if state == "computed"}


def test_result_has_the_photo_s_size_and_every_channel(relighter):
    relit = relighter.relight(some_light(), EDIT)
    assert relit.image.shape == (96, 112, 3)
    assert relit.image.dtype == np.float32
    assert relit.alpha is None
    assert len(relit.faces) == 2
    shapes = {name: channel.shape for name, channel in relit.channels.items()}
    assert shapes == {
        "photo": (64, 64, 3),
        "albedo": (64, 64, 3),
        "normal": (64, 64, 3),
        "parsing": (64, 64),
        "specular": (64, 64),
        "shadow": (64, 64),
        "composition": (64, 64, 3),
        "source_light": (16, 32, 3),
        "target_light": (16, 32, 3),
    }
    assert all(np.isfinite(channel).all() for channel in relit.channels.values())
    np.testing.assert_allclose(np.linalg.norm(relit.channels["normal"], axis=-1), 1, atol=1e-3)
    assert relit.channels["parsing"].dtype.kind == "i"


def test_first_relighting_computes_every_network_stage(relighter):
    assert computed(relighter.relight(some_light(), EDIT)) >= NETWORK_STAGES


def test_same_again_computes_nothing(relighter):
    first = relighter.relight(some_light(), EDIT)
    again = relighter.relight(some_light(), EDIT)
    assert computed(again) == set()
    np.testing.assert_array_equal(again.image, first.image)


def test_exposure_computes_nothing(relighter):
    first = relighter.relight(some_light(), EDIT)
    brighter = relighter.relight(some_light(), replace(EDIT, exposure_ev=3.0))
    assert computed(brighter) == set()
    np.testing.assert_array_equal(brighter.image, first.image)


@pytest.mark.parametrize("slider", ["specular", "shadow"])
def test_a_slider_runs_no_network(relighter, slider):
    first = relighter.relight(some_light(), EDIT)
    moved = relighter.relight(some_light(), replace(EDIT, **{slider: 1.7}))
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
    without = Relighter(weights, remembers=False)
    without.set_portrait(some_photo())
    everything = frozenset({"source_light", "relief", "shadow", "specular", "correction", "sliders", "channels"})
    for edit in edits:
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


def test_without_shadow_and_specular_their_network_rests(relighter):
    relit = relighter.relight(some_light(), replace(EDIT, forced_off=frozenset({"shadow", "specular"})))
    assert states(relit)["specular_shadow"] == "skipped"


def test_forced_on_a_near_light_does_not_serve(relighter):
    light = some_light()
    relighter.relight(light, EDIT)
    near = Environment(light.shape * np.float32(1.00001), 1.0, "near")
    assert not computed(relighter.relight(near, EDIT)) & NETWORK_STAGES
    forced = relighter.relight(near, replace(EDIT, forced_on=frozenset({"shadow"})))
    assert "specular_shadow" in computed(forced)


def test_times_of_stages_within_stages_are_not_counted_twice(relighter):
    relit = relighter.relight(some_light(), EDIT)
    ended = max(stage.start_ms + stage.ms for stage in relit.stages.values())
    assert sum(stage.ms for stage in relit.stages.values()) <= ended + 1


def test_every_stage_says_why(relighter):
    for stage in relighter.relight(some_light(), EDIT).stages.values():
        assert stage.why
        assert stage.ms >= 0


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


def test_level_scales_the_composition_exactly(relighter):
    once = relighter.relight(some_light(level=1.0), EDIT).channels
    eightfold = relighter.relight(some_light(level=8.0), EDIT).channels
    for name in ("composition", "specular", "shadow", "target_light"):
        np.testing.assert_array_equal(eightfold[name], 8 * once[name])
    for name in ("albedo", "normal", "parsing", "source_light", "photo"):
        np.testing.assert_array_equal(eightfold[name], once[name])


def test_no_level_leaves_the_networks_range(relighter):
    for level in (1e-20, 1e-6, 1e6, 1e20):
        relit = relighter.relight(some_light(level=level), EDIT)
        assert np.isfinite(relit.image).all()
        assert np.isfinite(relit.channels["composition"]).all()


def test_black_light_makes_a_black_person_without_asking_the_network(relighter):
    black = Environment.from_radiance(np.zeros((16, 32, 3), np.float32))
    relit = relighter.relight(black, EDIT)
    assert states(relit)["specular_shadow"] == "skipped"
    assert np.isfinite(relit.image).all()
    assert relit.channels["composition"].max() == 0
    assert relit.image[40:60, 40:60].max() < 1e-3


@pytest.mark.parametrize(("slider", "sign"), [("specular", 1), ("shadow", -1)])
def test_sliders_move_one_way_only(relighter, slider, sign):
    images = [
        relighter.relight(some_light(), replace(EDIT, **{slider: gain})).channels["composition"]
        for gain in (0.0, 0.5, 1.0, 1.5, 2.0)
    ]
    for one, next_one in zip(images, images[1:], strict=False):
        assert (sign * (next_one - one)).min() >= -1e-6


def test_one_face_may_be_relit_alone(relighter):
    relighter.set_portrait(some_photo(), 0)
    assert len(relighter.relight(some_light(), EDIT).faces) == 1


def test_a_second_face_changes_with_the_first(relighter):
    both = relighter.relight(some_light(), EDIT).image
    relighter.set_portrait(some_photo(), 0)
    alone = relighter.relight(some_light(), EDIT).image
    assert np.abs(both - alone)[4:20, 4:20].mean() > 1e-4


def test_a_box_by_hand_needs_no_finder(relighter, monkeypatch):
    monkeypatch.setattr(portrait, "find_faces", lambda photo: [])
    relighter.set_portrait(some_photo(), box=FaceBox(20, 20, 60, 70, roll_deg=20.0))
    relit = relighter.relight(some_light(), EDIT)
    assert np.isfinite(relit.image).all()
    assert relit.faces[0].x1 > 20
    for box in (FaceBox(5, 5, 5, 40), FaceBox(500, 10, 600, 90), FaceBox(np.nan, 0, 5, 5)):
        with pytest.raises(InputError, match="box"):
            relighter.set_portrait(some_photo(), box=box)


def test_a_smaller_picture_for_the_screen_and_the_full_one_for_a_file(relighter):
    relit = relighter.relight(some_light(), EDIT, longest_side_px=56)
    assert relit.image.shape == (48, 56, 3)
    full, alpha = relit.full.render()
    assert full.shape == (96, 112, 3)
    assert alpha is None
    np.testing.assert_array_equal(relighter.relight(some_light(), EDIT).image, full)


def test_a_smaller_picture_is_reused_too(relighter):
    relighter.relight(some_light(), EDIT, longest_side_px=56)
    assert computed(relighter.relight(some_light(), EDIT, longest_side_px=56)) == set()


def test_the_view_of_the_panorama_is_checked(relighter):
    for wrong in ({"background_fov_deg": 0.0}, {"background_fov_deg": 200.0}, {"background_blur_deg": -1.0}):
        with pytest.raises(InputError, match="degrees"):
            relighter.relight(some_light(), replace(EDIT, background="light", **wrong))


def test_backgrounds(relighter):
    transparent = relighter.relight(some_light(), replace(EDIT, background="transparent"))
    assert transparent.alpha.shape == (96, 112)
    assert ((transparent.alpha >= 0) & (transparent.alpha <= 1)).all()
    for background in ("light", "#30343a", "match"):
        relit = relighter.relight(some_light(), replace(EDIT, background=background))
        assert np.isfinite(relit.image).all()
    with pytest.raises(InputError, match="background"):
        relighter.relight(some_light(), replace(EDIT, background="beach"))


def test_unknown_quality_names_the_known_ones(relighter):
    with pytest.raises(InputError, match="draft"):
        relighter.relight(some_light(), replace(EDIT, quality="best"))


def test_no_portrait_yet(weights):
    with pytest.raises(InputError, match="portrait"):
        Relighter(weights).relight(some_light(), EDIT)
    with pytest.raises(InputError, match="portrait"):
        Relighter(weights).estimated_light()


def test_estimated_light_is_a_light(relighter):
    borrowed = relighter.estimated_light()
    assert borrowed.shape.shape == (16, 32, 3)
    assert np.isfinite(borrowed.shape).all()
    assert borrowed.level > 0
    assert np.isfinite(relighter.relight(borrowed, EDIT).image).all()


def test_a_photo_without_a_face_leaves_the_portrait_as_it_was(relighter, monkeypatch):
    before = relighter.relight(some_light(), EDIT)
    monkeypatch.setattr(portrait, "find_faces", lambda photo: [])
    with pytest.raises(InputError, match="no face"):
        relighter.set_portrait(some_photo(5))
    after = relighter.relight(some_light(), EDIT)
    assert computed(after) == set()
    np.testing.assert_array_equal(after.image, before.image)


@pytest.mark.parametrize("index", [2, -1])
def test_a_face_that_is_not_there(relighter, index):
    with pytest.raises(InputError, match="face number"):
        relighter.set_portrait(some_photo(), index)


def test_faces_are_chosen_by_index(relighter):
    relighter.set_portrait(some_photo(), 1)
    box = relighter.relight(some_light(), EDIT).faces[0]
    assert box.x0 < 24
    assert box.x1 <= 48


HOSTILE = {
    "black": np.zeros((96, 112, 3), np.float32),
    "white": np.ones((96, 112, 3), np.float32),
    "brighter than white": np.full((96, 112, 3), 60000, np.float32),
    "noise": np.random.default_rng(0).random((96, 112, 3), np.float32),
    "checks": (np.indices((96, 112)).sum(0) % 2)[..., None].repeat(3, -1).astype(np.float32) * 50,
    "one colour only": np.float32([1, 0, 0]) * np.ones((96, 112, 1), np.float32),
    "odd size": np.random.default_rng(1).random((97, 113, 3), np.float32),
    "tiny": np.random.default_rng(2).random((9, 11, 3), np.float32),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_photos_stay_finite(weights, name, monkeypatch):
    linear = HOSTILE[name]
    height, width = linear.shape[:2]
    box = FaceBox(width * 0.2, height * 0.2, width * 0.7, height * 0.8)
    monkeypatch.setattr(portrait, "find_faces", lambda photo: [box])
    relighter = Relighter(weights)
    relighter.set_portrait(Photo(np.ascontiguousarray(linear)))
    relit = relighter.relight(some_light(), replace(EDIT, specular=2.0, shadow=2.0))
    assert relit.image.shape == linear.shape
    assert np.isfinite(relit.image).all()
    assert (relit.image >= 0).all()
    assert all(np.isfinite(channel).all() for channel in relit.channels.values())


def test_a_face_beyond_the_border(weights, monkeypatch):
    monkeypatch.setattr(portrait, "find_faces", lambda photo: [FaceBox(-30, -20, 30, 50)])
    relighter = Relighter(weights)
    relighter.set_portrait(some_photo())
    assert np.isfinite(relighter.relight(some_light(), EDIT).image).all()


def test_the_photo_itself_is_never_changed(relighter):
    photo = some_photo()
    before = photo.linear.copy()
    relighter.set_portrait(photo)
    relighter.relight(some_light(), replace(EDIT, background="light"))
    np.testing.assert_array_equal(photo.linear, before)


def test_behind_the_person_the_effects_are_black(weights, monkeypatch):
    left_half = np.zeros((32, 32), np.float32)
    left_half[:, :16] = 1
    monkeypatch.setattr(stages, "solid_person", lambda parsing: left_half)
    relighter = Relighter(weights)
    relighter.set_portrait(some_photo())
    relit = relighter.relight(some_light(), EDIT)
    for name in ("specular", "shadow"):
        channel = relit.channels[name]
        middle = channel.shape[1] // 2
        assert np.abs(channel[:, middle + 4 :]).max() < 1e-4
        assert channel[:, : middle - 4].max() > 1e-3
