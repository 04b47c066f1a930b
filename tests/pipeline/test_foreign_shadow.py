"""Shadows from outside, found by a network: which of those that it sees are some."""

import pytest
import torch
from drawn_shadows import Draws, Says

from relight_core.pipeline.per_photo.foreign_shadow import find_foreign_shadow

SKIN, LEFT_EYE, HAIR, CLOTH = 1, 4, 10, 13


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
