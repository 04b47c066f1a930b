"""The edges that small lamps give to shadows."""

import numpy as np
import pytest
import torch

from relight_core.lighting.horizon import Horizon
from relight_core.lighting.lamps import Lamp, footprint
from relight_core.lighting.relief import march_relief
from relight_core.lighting.sphere import directions, solid_angles
from relight_core.pipeline.per_light.hard_shadow import harden_shadow, ready_for_lamps
from relight_core.pipeline.per_light.hints import Effects, hidden_share
from relight_core.pipeline.stages import Surface

SIZE = 64
SIDE = (0.7660, 0.0, 0.6428)
SKIN, INNER_MOUTH, LIPS, HAIR = 1, 7, 8, 10


def surface(label):
    """A grey wall that faces the camera, with an upright bar on it."""
    relief = torch.zeros(1, 1, SIZE, SIZE)
    relief[..., 31:33] = 0.25
    normal = torch.zeros(1, 3, SIZE, SIZE)
    normal[:, 2] = 1
    grey, parsing = torch.full_like(normal, 0.5), torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, label] = 1
    return Surface(grey, grey, normal, relief, parsing, torch.ones_like(relief), torch.ones(1, 16, 32, 3))


def flanked():
    """The same wall and bar of skin, the bar with a flank that looks at the lamp and at the wall before it."""
    found = surface(SKIN)
    found.normal[..., 32:36] = torch.tensor((SIDE[0], 0.0, SIDE[2]))[:, None, None]
    return found


def reflected(irradiance=2.0, gloss=0.1):
    return torch.cat([torch.full((1, 3, SIZE, SIZE), irradiance), torch.full((1, 3, SIZE, SIZE), gloss)], 1)


def side_light():
    """A lamp at SIDE in texels, with a little light from everywhere."""
    light = torch.full((1, 16, 32, 3), 0.05)
    light[:, 7:9, 27] = 60
    return light


def hardened(effects, lamps, irradiance=None, light=None, label=SKIN, given=None, roll_deg=0.0, found=None):
    found = surface(label) if found is None else found
    coarse = found.relief[0, 0, ::2, ::2], found.normal[0, :, ::2, ::2], torch.ones(SIZE // 2, SIZE // 2)
    reflection = reflected() if irradiance is None else irradiance
    light = side_light() if light is None else light
    given = torch.cat([torch.full((1, 3, 1, 1), part) for part in given or given_by(lamps)], 1)
    of_lamps = lambda lit: torch.minimum(given, reflection)  # noqa: E731
    view = ready_for_lamps(found, march_relief(*coarse), of_lamps, roll_deg)
    return harden_shadow(effects, found, reflection, light, view, lamps)


def given_by(lamps):
    """Irradiance and gloss that a wall which faces the camera has of lamps at the side."""
    irradiance = sum(lamp.irradiance * max(lamp.toward[2], 0.0) for lamp in lamps)
    return irradiance, 0.036 / 3.0 * sum(lamp.irradiance for lamp in lamps)


def half_shadow():
    """Half the diffuse light hidden everywhere, and half the gloss."""
    one = torch.ones(1, 1, SIZE, SIZE)
    return Effects(0.05 * one, (0.5 * 0.5 * 2.0 + 0.05) * one)


def share(effects):
    return hidden_share(effects, torch.full((1, 1, SIZE, SIZE), 1.0), torch.full((1, 1, SIZE, SIZE), 0.1))[0, 0].numpy()


def lamp(irradiance=3.0, hardness=1.0, radius_deg=1.0, toward=SIDE):
    return Lamp(toward, radius_deg, irradiance, hardness)


def test_without_lamps_nothing_changes():
    before = half_shadow()
    assert hardened(before, []) is before


def test_the_edge_becomes_steeper_and_lies_where_the_geometry_says():
    after = share(hardened(half_shadow(), [lamp()]))[SIZE // 2]
    edge = 31 - 0.25 * (SIDE[0] / SIDE[2]) * SIZE / 2
    steepest = int(np.abs(np.diff(after[10:30])).argmax()) + 10
    assert steepest == pytest.approx(edge, abs=2)
    assert np.abs(np.diff(after[10:30])).max() > 0.15
    assert after[40:60].std() < 0.02


def test_in_a_view_that_is_turned_a_lamp_above_the_photo_is_one_at_the_side():
    upright = share(hardened(half_shadow(), [lamp()]))
    turned = share(hardened(half_shadow(), [lamp(toward=(0.0, SIDE[0], SIDE[2]))], roll_deg=90.0))
    np.testing.assert_allclose(turned, upright, atol=0.02)


def test_a_shadow_that_the_relief_knows_nothing_of_stays():
    """Far from the bar, toward the lamp, nothing on the relief could hide it."""
    after = share(hardened(half_shadow(), [lamp()]))
    assert np.abs(after[:, 48:] - 0.5).max() < 0.1


def test_an_edge_counts_as_much_as_what_a_lamp_out_of_sight_hides(monkeypatch):
    """Also where the relief hardly knows of the network's shadow and would leave most of it: else fringes glow."""
    edges = []
    for seen in (0.0, 1.0):
        monkeypatch.setattr(Horizon, "visibility", lambda *_, seen=seen: np.full((SIZE, SIZE), seen, np.float32))
        edges.append(hardened(half_shadow(), [lamp()], given=(2.0, 0.1)).edges)
    none_seen, all_seen = edges
    differs = none_seen.hidden - all_seen.hidden
    np.testing.assert_allclose(all_seen.of_lamps[0].counts, differs, atol=1e-5)
    assert differs.max() > differs.min() + 0.3


def test_less_hardness_and_less_light_change_less():
    change = [
        np.abs(share(hardened(half_shadow(), [lamp(**how)])) - 0.5).max()
        for how in ({}, {"hardness": 0.4}, {"irradiance": 0.2}, {"hardness": 0.0})
    ]
    assert change[0] > change[1] > change[3] == pytest.approx(0, abs=1e-6)
    assert change[0] > change[2]


@pytest.mark.parametrize("toward", [SIDE, (-0.6, 0.6, 0.529), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)])
@pytest.mark.parametrize("light", [reflected(), reflected(1e-6, 0.0), reflected(1e4, 1e3), reflected(0.0, 0.0)])
def test_effects_stay_physical(toward, light):
    zero = torch.zeros(1, 1, SIZE, SIZE)
    for effects in (half_shadow(), Effects(zero, zero)):
        after = hardened(effects, [lamp(toward=toward), lamp(radius_deg=3.0)], light, found=flanked())
        for channel in (after.specular, after.shadow, after.interreflection):
            assert torch.isfinite(channel).all()
            assert channel.min() >= 0
        assert (after.interreflection <= 0.5 * 0.5 * light[:, :1] + 1e-6).all()
        assert (after.shadow <= 0.5 * light[:, :1] + light[:, 3:4] + 1e-3).all()


def test_a_lit_flank_of_skin_lights_the_wall_beside_it():
    lit, soft = (hardened(half_shadow(), [lamp(hardness=hard)], found=flanked()).interreflection for hard in (1.0, 0.0))
    assert lit[..., 8:56, 37:42].min() > 1e-3
    assert soft.max() == 0


def test_the_more_the_network_takes_for_hidden_the_less_is_thrown_back():
    one = torch.ones(1, 1, SIZE, SIZE)
    nearly_all = Effects(0 * one, (0.95 * 0.5 * 2.0 + 0.1) * one)
    less, more = (
        hardened(effects, [lamp()], found=flanked()).interreflection for effects in (nearly_all, half_shadow())
    )
    assert 0 < less.max() < 0.7 * more.max()


def test_where_the_network_sees_no_shadow_there_is_none():
    """The relief may be wrong; it says where an edge lies, not whether there is one."""
    zero = torch.zeros(1, 1, SIZE, SIZE)
    after = hardened(Effects(zero + 0.1, zero), [lamp()])
    assert share(after).max() < 1e-5


@pytest.mark.parametrize("label", [HAIR, INNER_MOUTH, LIPS])
def test_hair_and_mouth_keep_their_soft_shadows(label):
    after = hardened(half_shadow(), [lamp()], label=label)
    assert np.abs(share(after) - 0.5).max() < 1e-5


def test_shadow_of_other_lights_stays():
    """The lamp gives a tenth of the light; what else is hidden is none of its business."""
    after = share(hardened(half_shadow(), [lamp(irradiance=0.3)]))
    assert np.abs(after - 0.5).max() < 0.1


def effects_with(hidden, gloss, dull=0.5):
    """`hidden` of a diffuse light of 1, and `dull` of the gloss."""
    one = torch.ones(1, 1, SIZE, SIZE)
    return Effects((1 - dull) * gloss * one, (hidden + dull * gloss) * one)


def in_and_out_of_the_shadow(channel):
    """Of a row across the bar: beside it in its shadow, and on the other side."""
    row = channel[0, 0, SIZE // 2].numpy()
    return row[25:29].mean(), row[44:60].mean()


def test_gloss_goes_where_the_lamp_is_hidden():
    """A highlight can't lie in the shadow of the lamp that makes it; of 0.036 the lamp makes nearly all."""
    after = hardened(effects_with(0.5, 0.036), [lamp()], reflected(gloss=0.036))
    shaded, lit = in_and_out_of_the_shadow(after.specular)
    assert shaded < 0.003
    assert lit > 0.015
    assert after.specular.max() <= 0.036 + 1e-6


def test_gloss_goes_where_a_lamp_that_gives_little_else_is_hidden():
    """A tenth of the diffuse light, and nearly all of the gloss, as where light grazes a nose from behind."""
    after = hardened(effects_with(0.5, 0.0036), [lamp(irradiance=0.3)], reflected(gloss=0.0036))
    shaded, lit = in_and_out_of_the_shadow(after.specular)
    assert shaded < 0.0003
    assert lit > 0.0015


def test_gloss_of_other_lights_stays():
    after = hardened(effects_with(0.5, 0.36), [lamp()], reflected(gloss=0.36))
    shaded, lit = in_and_out_of_the_shadow(after.specular)
    assert shaded == pytest.approx(0.18, abs=0.02)
    assert lit == pytest.approx(0.18, abs=0.02)


@pytest.mark.parametrize("hidden", [0.93, 1.0])
def test_what_is_left_beside_a_hidden_lamp_is_what_reaches_there_of_the_rest(hidden):
    """The lamp gives 0.964 of the light; of the others the bar hides little. What is left was all or nothing."""
    after = share(hardened(effects_with(hidden, 0.1), [lamp()]))[SIZE // 2, 25:29].mean()
    assert 0.964 < after < 0.985


def test_what_the_relief_alone_hides_has_the_lamp_s_edges():
    """Whatever the network says: of a light of which the lamp gives 0.964."""
    after = hardened(effects_with(0.0, 0.1), [lamp()])
    shaded, lit = in_and_out_of_the_shadow(after.by_relief)
    assert shaded == pytest.approx(0.964, abs=0.02)
    assert lit < 0.02


def test_a_hidden_lamp_takes_no_more_than_the_light_has_of_it():
    """By its cosine the lamp would give 1.93 of the 2; in the light's texels, which it grazes, it gives 0.8."""
    after = hardened(effects_with(0.4, 0.1), [lamp()], given=(0.8, 0.036))
    assert 0.38 < share(after)[SIZE // 2, 25:29].mean() < 0.58


def test_where_a_lamp_is_hidden_the_gloss_of_the_rest_of_the_light_stays():
    """Of a gloss of 0.5 the lamp gives 0.49: a hole in the sheen of the room would be a dark blot."""
    after = hardened(effects_with(0.5, 0.5, dull=0.98), [lamp()], reflected(gloss=0.5), given=(1.93, 0.49))
    shaded, _ = in_and_out_of_the_shadow(after.specular)
    assert shaded == pytest.approx(0.01 * 0.85, abs=0.001)


def test_the_relief_hides_of_the_gloss_what_a_lamp_gives_of_it():
    """A lamp that grazes gives a tenth of the light and nearly all of the gloss."""
    after = hardened(effects_with(0.5, 0.5), [lamp()], reflected(gloss=0.5), given=(0.2, 0.49))
    shaded, lit = in_and_out_of_the_shadow(after.gloss_by_relief)
    assert shaded == pytest.approx(0.98, abs=0.02)
    assert lit < 0.02
    assert in_and_out_of_the_shadow(after.by_relief)[0] == pytest.approx(0.1 + 0.9 * 0.15, abs=0.03)


def in_shadow(after):
    return after[SIZE // 2, 25:29].mean()


@pytest.mark.parametrize(("hidden", "least", "most"), [(0.1, 0.2, 0.4), (0.25, 0.5, 0.75), (0.5, 0.95, 1.0)])
def test_the_less_a_network_sees_of_a_shadow_the_less_geometry_makes_of_it(hidden, least, most):
    """From half of the lamp's light on, geometry alone decides: all of it, 0.964, is hidden beside the bar."""
    assert least < in_shadow(share(hardened(effects_with(hidden, 0.1), [lamp()]))) < most


def test_what_is_hidden_where_one_lamp_is_is_hardly_taken_from_another():
    from_left = lamp(irradiance=1.5, toward=(-SIDE[0], 0.0, SIDE[2]))
    left, right = hardened(effects_with(0.5, 0.1), [from_left, lamp(irradiance=1.5)]).edges.of_lamps
    assert in_shadow(right.counts) > 0.45
    assert in_shadow(left.counts) < 0.1


def test_a_lamp_behind_what_it_would_light_has_no_part_in_it():
    behind, before = lamp(toward=(0.6, 0.0, -0.8)), lamp()
    edges = hardened(effects_with(0.9, 0.1), [behind, before], given=(1.9, 0.09)).edges
    assert in_shadow(edges.of_lamps[0].counts) < 0.01
    assert in_shadow(edges.of_lamps[1].counts) > 0.9


def test_where_much_of_the_light_is_no_lamps_the_network_keeps_its_word_about_that():
    """Half of it is the lamp's; of the rest the relief hides a quarter, and the network four fifths."""
    after = in_shadow(share(hardened(effects_with(0.9, 0.1), [lamp()], given=(1.0, 0.05))))
    assert 0.84 < after < 0.9


def test_the_surface_is_asked_for_the_light_of_lamps_alone():
    """And for no more of it than the light has there."""
    found, asked = surface(SKIN), []
    coarse = march_relief(found.relief[0, 0, ::2, ::2], found.normal[0, :, ::2, ::2], torch.ones(SIZE // 2, SIZE // 2))
    view = ready_for_lamps(found, coarse, lambda lit: asked.append(lit) or reflected(), 0.0)
    areas = torch.from_numpy(solid_angles(16, 32).copy())[None, ..., None]
    light = 0.05 + torch.from_numpy(footprint(lamp()))[None, ..., None] * np.pi * 3.0 / areas.expand(1, 16, 32, 3)
    for irradiance in (3.0, 300.0):
        harden_shadow(half_shadow(), found, reflected(), light, view, [lamp(irradiance=irradiance)])
    some, all_there_is = asked
    assert float((some * areas).sum((0, 1, 2)).mean()) == pytest.approx(np.pi * 3.0, rel=0.02)
    around = directions(16, 32) @ np.float32(SIDE) < np.cos(np.radians(25.0))
    assert float(some[0][torch.from_numpy(around)].max()) < 1e-3
    assert (all_there_is <= light + 1e-4).all()
    assert float((all_there_is * areas).sum()) > float((some * areas).sum())


def test_light_is_thrown_back_by_skin_twice():
    """By the flank that the lamp lights and by the wall beside it: of half the albedo it is a quarter."""
    bright, dark = flanked(), flanked()
    dark.albedo.mul_(0.5)
    one = torch.ones(1, 1, SIZE, SIZE)
    effects = Effects(0.05 * one, (0.5 * 0.25 * 2.0 + 0.05) * one)
    more, less = (
        hardened(given, [lamp()], found=found).interreflection
        for given, found in ((half_shadow(), bright), (effects, dark))
    )
    assert more.max() > 1e-3
    torch.testing.assert_close(less, 0.25 * more, rtol=1e-3, atol=1e-6)


def test_of_two_lamps_that_stand_together_each_counts_by_what_it_gives():
    edges = hardened(effects_with(0.9, 0.1), [lamp(irradiance=1.0), lamp(irradiance=3.0)], given=(1.9, 0.09)).edges
    weak, strong = (in_shadow(of_lamp.counts) for of_lamp in edges.of_lamps)
    assert strong == pytest.approx(3 * weak, rel=0.02)
    assert weak > 0.2


def test_of_two_lamps_the_weak_one_keeps_its_small_part_of_the_gloss_where_the_strong_one_is_hidden():
    lamps = [lamp(irradiance=3.0), lamp(irradiance=0.3, toward=(-SIDE[0], 0.0, SIDE[2]))]
    after = hardened(effects_with(0.5, 0.0396), lamps, reflected(gloss=0.0396))
    shaded, lit = in_and_out_of_the_shadow(after.specular)
    assert shaded < 0.25 * lit
