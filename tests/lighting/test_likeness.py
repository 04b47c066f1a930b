"""How alike two lights are."""

import pytest
import torch

from relight_core.lighting.likeness import likeness
from relight_core.lighting.sphere import solid_angles


def lamp(row, column, colour=(1.0, 1.0, 1.0)):
    light = torch.zeros(1, 16, 32, 3)
    light[0, row, column] = torch.tensor(colour)
    return light


def test_a_light_is_like_itself_at_any_level():
    light = torch.rand(1, 16, 32, 3, generator=torch.Generator().manual_seed(0))
    assert likeness(light, 1000 * light) == pytest.approx(1, abs=1e-5)


def test_lamps_from_opposite_sides_share_nothing():
    assert likeness(lamp(8, 4), lamp(7, 20)) < 1e-3


def test_the_further_a_lamp_is_turned_the_less_it_is_like_itself():
    found = [likeness(lamp(8, 16), lamp(8, 16 + turned)) for turned in (0, 1, 2, 4, 8)]
    assert found == sorted(found, reverse=True)
    assert found[1] > 0.7
    assert found[3] < 0.4


def test_it_does_not_matter_which_light_comes_first():
    first, second = lamp(5, 10) + 0.01, lamp(5, 12, (1.0, 0.5, 0.1)) + 0.02
    assert likeness(first, second) == pytest.approx(likeness(second, first), abs=1e-6)


def test_lamps_of_other_colours_share_less():
    assert likeness(lamp(8, 8), lamp(8, 8, (1.0, 0.05, 0.0))) < 0.6


def test_darkness_is_like_no_light():
    dark = torch.zeros(1, 16, 32, 3)
    assert likeness(dark, lamp(8, 8)) == 0
    assert likeness(dark, dark) == 0


def test_what_comes_from_a_pole_counts_by_its_power_and_not_by_its_many_texels():
    """Of two lamps that give as much, each is a third of what they and one of them send together."""
    areas = torch.from_numpy(solid_angles(16, 32).copy())
    aside, above = torch.zeros(2, 16, 32)
    aside[7:9, 8], above[0] = 1.0, 1.0
    aside, above = ((light / (light * areas).sum())[None, ..., None].expand(1, 16, 32, 3) for light in (aside, above))
    assert likeness(aside + above, aside) == pytest.approx(1 / 3, abs=0.06)
    assert likeness(aside + above, above) == pytest.approx(1 / 3, abs=0.06)
