"""Shadows from outside: found by a network, taken off the photo, and back where the light is the photo's own."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from tiny_relighter import some_light, some_photo

from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.networks.bundle import load_bundle
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_light.residual import Residual, add_residual
from relight_core.pipeline.per_photo.foreign_shadow import find_foreign_shadow, without_shadow
from relight_core.pipeline.per_photo.second_look import take_apart
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.stages import Composed, Effects, without_colour

TIER = Tier(64, 64, 32, 16, False, precision="fp32")
SKIN, LEFT_EYE, HAIR, CLOTH = 1, 4, 10, 13


class Says(torch.nn.Module):
    """A network that sees a shadow of some logs in the left half, whatever it is shown; mirrored, in the right one."""

    def __init__(self, red=-1.0, green=-1.0, blue=-1.0, columns=128):
        super().__init__()
        self.shadow, self.columns, self.shown = torch.tensor([red, green, blue]), columns, []

    def forward(self, photo, parts):
        self.shown.append((photo, parts))
        logs = torch.zeros(2, 3, 256, 256)
        logs[0, :, :, : self.columns] = self.shadow[:, None, None]
        logs[1, :, :, 256 - self.columns :] = self.shadow[:, None, None]
        return logs


@pytest.fixture
def bundle(weights):
    return load_bundle(weights).for_inference()


def parsing(share=1.0):
    found = torch.zeros(1, 14, 32, 32)
    found[:, SKIN], found[:, 0] = share, 1 - share
    return found


def found_by(bundle, network, person=1.0):
    bundle.foreign_shadow = network
    return find_foreign_shadow(bundle, torch.full((1, 3, 64, 64), 0.3), parsing(person), "fp32")


def test_without_a_network_there_is_none(bundle):
    assert bundle.foreign_shadow is None
    assert found_by(bundle, None) is None


def test_what_it_says_of_the_view_and_of_its_mirror_image_is_averaged(bundle):
    network = Says(-1.0, -0.8, -0.6)
    logs = found_by(bundle, network)
    assert logs.shape == (1, 3, 256, 256)
    torch.testing.assert_close(logs[0, :, 0, 0], torch.tensor([-1.0, -0.8, -0.6]))
    assert (logs[..., 128:] == 0).all()
    photo, parts = network.shown[0]
    assert photo.shape == (2, 3, 256, 256)
    torch.testing.assert_close(parts[:, 0], torch.ones(2, 256, 256))
    assert (parts[:, 1:] == 0).all()


def test_it_is_shown_the_photo_as_a_camera_stores_it_and_its_mirror_image(bundle):
    view = torch.full((1, 3, 512, 512), 0.05)
    # Seen at half the size, columns of 0.2 and 0.4 are 0.3.
    view[..., :256] = torch.tensor([0.2, 0.4]).repeat(128)
    view[:, :, 256:, :256] = 7.0
    found = torch.zeros(1, 14, 256, 256)
    found[:, SKIN, :, :128], found[:, CLOTH, :, 128:] = 1, 1
    bundle.foreign_shadow = network = Says()
    find_foreign_shadow(bundle, view, found, "fp32")
    photo, parts = network.shown[0]
    torch.testing.assert_close(photo[0, :, 60, 60], torch.full((3,), 0.5838), atol=1e-3, rtol=0)
    torch.testing.assert_close(photo[0, :, 60, 200], torch.full((3,), 0.2478), atol=1e-3, rtol=0)
    torch.testing.assert_close(photo[0, :, 200, 60], torch.ones(3))
    assert (parts[0, 0, :, :128] == 1).all()
    assert (parts[0, 3, :, 128:] == 1).all()
    for shown in (photo, parts):
        torch.testing.assert_close(shown[1], shown[0].flip(-1), rtol=0, atol=0)


@pytest.mark.parametrize(
    ("said", "columns", "person"), [(-0.1, 128, 1.0), (-1.0, 1, 1.0), (-1.0, 128, 0.0), (0.5, 128, 1.0)]
)
def test_faint_ones_slivers_those_behind_the_person_and_gleams_are_none(bundle, said, columns, person):
    assert found_by(bundle, Says(said, said, said, columns), person) is None


class Draws(torch.nn.Module):
    """A network that sees shadows where a mask (256, 256) says so."""

    def __init__(self, mask):
        super().__init__()
        self.mask = mask

    def forward(self, photo, parts):
        return -torch.stack([self.mask, self.mask.flip(-1)])[:, None].expand(2, 3, 256, 256)


def dressed():
    """A face in the upper half of the view, a coat in the lower one."""
    found = torch.zeros(1, 14, 256, 256)
    found[:, SKIN, :128], found[:, CLOTH, 128:] = 1, 1
    return found


def shadows_on_somebody(bundle, *places, view=None, person=None):
    mask = torch.zeros(256, 256)
    for rows, columns in places:
        mask[rows, columns] = 1
    return found_where(bundle, mask, view, person)


def found_where(bundle, mask, view=None, person=None):
    bundle.foreign_shadow = Draws(mask)
    view = torch.full((1, 3, 256, 256), 0.3) if view is None else view
    found = find_foreign_shadow(bundle, view, dressed() if person is None else person, "fp32")
    return None if found is None else found[0, 0]


COAT, WHOLE = slice(128, 256), slice(0, 256)


def test_a_dark_coat_is_no_shadow(bundle):
    assert shadows_on_somebody(bundle, (COAT, WHOLE)) is None
    with_a_hand = shadows_on_somebody(bundle, (COAT, WHOLE), (slice(20, 60), slice(20, 60)))
    assert float(with_a_hand[150:].abs().max()) == 0
    assert float(with_a_hand[40, 40]) == -1


def test_what_shades_face_and_coat_shades_both(bundle):
    found = shadows_on_somebody(bundle, (WHOLE, slice(0, 100)))
    assert float(found[40, 40]) == float(found[200, 40]) == -1
    assert float(found[:, 120:].abs().max()) == 0


def test_of_a_shadow_with_little_skin_in_it_only_that_is_one(bundle):
    found = shadows_on_somebody(bundle, (COAT, WHOLE), (slice(100, 128), slice(0, 100)))
    assert float(found[110, 50]) == -1
    assert float(found[150:].abs().max()) == 0


@pytest.mark.parametrize(("top", "on_coat"), [(94, -1), (108, 0)])
def test_only_of_a_shadow_with_enough_skin_in_it_the_rest_is_one_too(bundle, top, on_coat):
    """A third of the first one is skin, a fifth of the other."""
    found = shadows_on_somebody(bundle, (slice(top, 208), slice(0, 60)))
    assert float(found[115, 30]) == -1
    assert float(found[190, 30]) == on_coat


def test_a_dark_coat_that_reaches_a_little_over_the_neck_is_no_shadow(bundle):
    assert shadows_on_somebody(bundle, (slice(124, 256), WHOLE)) is None


def test_a_shadow_on_a_coat_that_a_speck_of_skin_lies_in_is_none(bundle):
    """A sixteenth of it is skin, and that a fivehundredth of the face's."""
    assert shadows_on_somebody(bundle, (slice(125, 175), slice(100, 120))) is None


def test_features_are_face_as_well(bundle):
    person = dressed()
    person[:, SKIN, 40:60, 40:100], person[:, LEFT_EYE, 40:60, 40:100] = 0, 1
    assert float(shadows_on_somebody(bundle, (slice(40, 60), slice(40, 100)), person=person)[50, 70]) == -1


@pytest.mark.filterwarnings("error")
def test_a_face_that_lies_in_a_shadow_altogether_has_one(bundle):
    assert float(shadows_on_somebody(bundle, (WHOLE, WHOLE))[64, 64]) == -1


def test_what_is_dark_behind_the_person_is_neither_shadow_nor_part_of_one(bundle):
    thin = torch.zeros(1, 14, 256, 256)
    thin[:, SKIN, :, 100:110] = 1
    thin[:, 0] = 1 - thin[:, SKIN]
    found = shadows_on_somebody(bundle, (slice(40, 140), WHOLE), person=thin)
    assert float(found[90, 105]) == -1
    assert float(found[:, :100].abs().max()) == float(found[:, 110:].abs().max()) == 0


def test_what_may_be_a_shadow_is_one_in_part_and_only_beside_one(bundle):
    mask = torch.zeros(256, 256)
    mask[:, :100] = 1
    for column, depth in ((40, 0.1), (60, 0.175), (80, 0.3)):
        mask[:, column : column + 2] = depth
    mask[40:60, 200:240] = 0.2
    found = found_where(bundle, mask)
    assert float(found[64, 40]) == pytest.approx(0, abs=1e-6)
    assert float(found[64, 60]) == pytest.approx(-0.0875, abs=1e-5)
    assert float(found[64, 80]) == pytest.approx(-0.3, abs=1e-6)
    assert float(found[:, 110:].abs().max()) == 0


def test_a_shadow_that_ends_nowhere_fades_a_few_pixels_beyond_what_is_surely_one(bundle):
    mask = torch.full((256, 256), 0.2)
    mask[:, :100] = 1
    across = -found_where(bundle, mask)[64]
    # Two thirds of what may be a shadow of 0.2.
    assert float(across[102]) == pytest.approx(0.1333, abs=1e-3)
    assert float(across[110:].max()) == 0
    fading = across[102:109]
    assert (fading.diff() <= 0).all()
    assert float(fading.diff().abs().max()) < 0.05


def test_a_lit_spot_amid_a_large_shadow_stays_as_it_is(bundle):
    mask = torch.ones(256, 256)
    mask[30:60, 30:60] = 0.2
    found = found_where(bundle, mask)
    assert float(found[45, 45]) == 0
    assert float(found[90, 90]) == -1


@pytest.mark.parametrize(("columns", "on_coat"), [(50, 0), (80, -1)])
def test_an_eleventh_of_a_face_in_shadow_is_little_and_a_seventh_is_much(bundle, columns, on_coat):
    places = (slice(0, 60), slice(0, columns)), (slice(180, 200), slice(180, 200))
    assert float(shadows_on_somebody(bundle, *places)[190, 190]) == on_coat


@pytest.mark.parametrize(("columns", "on_coat"), [(64, -1), (131, 0), (256, 0)])
def test_a_fifth_of_a_coat_may_lie_in_shadow_like_the_face_and_two_fifths_are_dark_cloth(bundle, columns, on_coat):
    places = (slice(0, 60), slice(0, 120)), (slice(140, 240), slice(0, columns))
    assert float(shadows_on_somebody(bundle, *places)[190, 30]) == on_coat


@pytest.mark.parametrize(("rim_px", "is_shadow"), [(6, False), (16, True)])
def test_the_skin_around_a_beard_is_none(bundle, rim_px, is_shadow):
    """What a parsing takes for skin at a beard's edge ends with it."""
    bearded = torch.zeros(1, 14, 256, 256)
    bearded[:, SKIN] = 1
    bearded[:, HAIR, 120:240, 60:200] = 1
    bearded[:, SKIN] -= bearded[:, HAIR]
    found = shadows_on_somebody(bundle, (slice(120 - rim_px, 240), slice(60, 200)), person=bearded)
    assert (found is not None) == is_shadow


def test_where_leaves_shade_much_of_a_face_their_spots_on_the_coat_are_shadows_too(bundle):
    spot = (slice(180, 200), slice(180, 200))
    assert float(shadows_on_somebody(bundle, (slice(0, 60), slice(0, 120)), spot)[190, 190]) == -1
    assert float(shadows_on_somebody(bundle, (slice(0, 30), slice(0, 30)), spot)[190, 190]) == 0


@pytest.mark.parametrize(
    ("colour", "is_shadow"),
    [
        ((0.10, 0.10, 0.11), True),
        ((0.05, 0.10, 0.25), False),
        ((0.11, 0.04, 0.11), False),
        ((0.04, 0.11, 0.04), False),
    ],
)
def test_paint_is_no_shadow(bundle, colour, is_shadow):
    mask = torch.zeros(256, 256)
    mask[20:60, 20:60] = 1
    view = torch.full((1, 3, 256, 256), 0.3)
    view[:, :, 20:60, 20:60] = torch.tensor(colour)[:, None, None]
    bundle.foreign_shadow = Draws(mask)
    assert (find_foreign_shadow(bundle, view, dressed(), "fp32") is not None) == is_shadow


def test_a_coloured_shadow_on_skin_is_no_paint(bundle):
    view = torch.full((1, 3, 256, 256), 0.3)
    logs = torch.tensor([-1.7, -1.0, -0.2])
    view[..., :128] = ((0.3 + 0.005) * logs.exp() - 0.005)[:, None, None]
    bundle.foreign_shadow = Says(-1.7, -1.0, -0.2)
    found = find_foreign_shadow(bundle, view, dressed(), "fp32")
    torch.testing.assert_close(found[0, :, 60, 60], logs)


def test_the_coat_s_colour_says_nothing_of_paint_on_the_face(bundle):
    view = torch.full((1, 3, 256, 256), 0.3)
    view[:, :, 128:] = torch.tensor([0.02, 0.04, 0.2])[:, None, None]
    found = shadows_on_somebody(bundle, (slice(80, 256), slice(0, 100)), view=view)
    assert float(found[100, 50]) == float(found[200, 50]) == -1


def test_a_soft_edge_is_kept(bundle):
    soft = torch.ones(256) * 0
    soft[:96], soft[96:104] = 1, torch.linspace(1, 0, 8)
    bundle.foreign_shadow = Draws(soft.expand(256, 256))
    found = find_foreign_shadow(bundle, torch.full((1, 3, 256, 256), 0.3), dressed(), "fp32")[0, 0, 40]
    torch.testing.assert_close(found[:100], -soft[:100], atol=0.02, rtol=0)


@pytest.mark.parametrize(("wide_px", "is_shadow"), [(4, True), (10, True), (20, False), (60, False)])
def test_what_fades_as_slowly_as_shading_is_none(bundle, wide_px, is_shadow):
    fading = torch.zeros(256)
    fading[:90], fading[90 : 90 + wide_px] = 1, torch.linspace(1, 0, wide_px)
    bundle.foreign_shadow = Draws(fading.expand(256, 256))
    found = find_foreign_shadow(bundle, torch.full((1, 3, 256, 256), 0.3), dressed(), "fp32")
    assert (found is not None) == is_shadow


def test_a_shadow_with_an_edge_may_fade_elsewhere(bundle):
    """As that of a brim does with the way to it."""
    fading = torch.zeros(256, 256)
    fading[60:150, :90], fading[60:150, 90:130] = 1, torch.linspace(1, 0, 40)
    bundle.foreign_shadow = Draws(fading)
    found = find_foreign_shadow(bundle, torch.full((1, 3, 256, 256), 0.3), dressed(), "fp32")
    assert float(found[0, 0, 100, 60]) == pytest.approx(-1)


def test_none_is_deeper_than_a_camera_sees(bundle):
    assert float(found_by(bundle, Says(-9.0, -9.0, -9.0)).min()) == -3


def test_what_is_taken_off_is_what_fell_and_black_stays_black():
    lit = torch.rand(1, 3, 16, 16, generator=torch.Generator().manual_seed(0))
    logs = torch.full((1, 3, 16, 16), -1.5)
    shaded = ((lit + 0.005) * logs.exp() - 0.005).clamp_min(0)
    torch.testing.assert_close(without_shadow(shaded, logs)[lit > 0.02], lit[lit > 0.02])
    assert float(without_shadow(torch.zeros_like(lit), logs).max()) < 0.02
    torch.testing.assert_close(without_shadow(lit, torch.zeros_like(logs)), lit)


@pytest.mark.parametrize("again", [False, True])
def test_a_person_is_taken_apart_as_without_it(bundle, again):
    tier = replace(TIER, looks_twice=again)
    lit = np.random.default_rng(3).uniform(0.3, 0.5, (64, 64, 3)).astype(np.float32)
    expected = take_apart(bundle, lit, tier, "cpu")
    shaded = lit.copy()
    shaded[:, :32] = (lit[:, :32] + 0.005) * np.float32(np.exp(-1)) - 0.005
    bundle.foreign_shadow = Says()
    found = take_apart(bundle, shaded, tier, "cpu")
    for name in ("photo", "albedo", "normal", "source_light"):
        torch.testing.assert_close(getattr(found, name), getattr(expected, name), rtol=1e-3, atol=1e-4)
    assert found.foreign_shadow is not None
    left = take_apart(bundle, shaded, replace(tier, takes_foreign_shadow_off=False), "cpu")
    assert left.foreign_shadow is None
    assert float((left.photo - found.photo).abs().max()) > 0.1


def test_tiers_that_treat_it_differently_share_no_surface():
    assert TIER.surface_key != replace(TIER, takes_foreign_shadow_off=False).surface_key


def test_a_grey_photo_has_a_grey_one(bundle):
    bundle.foreign_shadow = Says(-1.2, -1.0, -0.8)
    found = without_colour(take_apart(bundle, np.full((64, 64, 3), 0.3, np.float32), TIER, "cpu"))
    torch.testing.assert_close(found.foreign_shadow[0, :, 0, 0], torch.full((3,), -1.0))


def lamp(column):
    light = torch.full((1, 16, 32, 3), 0.005)
    light[:, 8, column] = 20.0
    return light


def test_it_is_back_in_the_photos_light_and_gone_in_another():
    zero, one = torch.zeros(1, 3, 4, 4), torch.zeros(1, 1, 4, 4)
    shadow = torch.full_like(zero, -1.0)
    none = Residual(zero, one + 0.2, one, one + 1, one, zero, 2.0, zero, zero, lamp(2), 1.0)
    residual, composed = replace(none, foreign_shadow=shadow), Composed(zero + 0.2, zero + 0.2)
    darker = []
    for column in (2, 3, 18):
        with_it, without = (
            add_residual(each, composed, Effects(one, one), lamp(column))[0] for each in (residual, none)
        )
        darker.append(float(((with_it + 0.005) / (without + 0.005)).log().mean()))
    assert darker[0] == pytest.approx(-1, abs=1e-4)
    # Of a lamp eleven degrees further on a tenth is left.
    assert -0.2 < darker[1] < -0.05
    assert darker[1] <= darker[2]
    assert darker[2] > -0.02


def give(relighter, network):
    relighter._shop.bundle.foreign_shadow = network
    relighter._shop.bundle.rounded().foreign_shadow = network


@pytest.fixture
def shaded(relighter):
    """The relighter with a photo whose left half lies in a shadow that its network sees."""
    give(relighter, Says())
    relighter.set_portrait(some_photo())
    return relighter


def test_the_plan_says_whether_there_is_one_and_it_can_be_left_on(shaded):
    effects = lambda edit: {effect.name: effect for effect in shaded.relight(some_light(), edit).plan}  # noqa: E731
    found = effects(Edit())["foreign_shadow"]
    assert found.state != "skipped"
    assert "taken off" in found.why
    left = effects(Edit(forced_off=frozenset({"foreign_shadow"})))["foreign_shadow"]
    assert (left.state, left.why) == ("skipped", "turned off by you")
    give(shaded, None)
    shaded.set_portrait(some_photo(1))
    none = effects(Edit())["foreign_shadow"]
    assert (none.state, none.bound) == ("skipped", 0)


def test_turned_off_and_on_the_picture_changes_and_comes_back(shaded):
    def picture(edit):
        return shaded.relight(some_light(), edit).image

    first = picture(Edit())
    assert np.abs(picture(Edit(forced_off=frozenset({"foreign_shadow"}))) - first).max() > 0.01
    np.testing.assert_array_equal(picture(Edit()), first)


def test_what_was_taken_off_is_a_channel_of_its_own_where_there_is_something(shaded):
    channels = shaded.relight(some_light(), Edit()).channels
    taken_off = channels["foreign_shadow"]
    assert taken_off.shape == channels["albedo"].shape
    assert taken_off.min() >= 0
    # A shadow of one in logs.
    assert taken_off.max() == pytest.approx(1 - np.exp(-1), abs=0.02)
    left, right = np.split(taken_off, 2, axis=1)
    assert left.mean() > 0.1
    assert right.mean() < 0.1 * left.mean()
    assert "foreign_shadow" not in shaded.relight(some_light(), Edit(channels=("albedo",))).channels
    assert "foreign_shadow" not in shaded.relight(some_light(), Edit(forced_off=frozenset({"foreign_shadow"}))).channels
    give(shaded, None)
    shaded.set_portrait(some_photo(1))
    assert "foreign_shadow" not in shaded.relight(some_light(), Edit()).channels


def test_under_its_own_light_the_photo_is_the_photo_again(shaded):
    own = shaded.estimated_light("live")
    assert isinstance(own, Environment)
    photo: Photo = some_photo()
    shown = shaded.relight(own, Edit(background="keep")).image
    face = np.s_[30:66, 34:62]
    off = np.abs(np.log((shown[face] + 0.005) / (photo.linear[face] + 0.005)))
    assert float(np.median(off)) < 0.05
