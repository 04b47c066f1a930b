"""Which tier a hand and a budget get, and how tiers are measured."""

from types import SimpleNamespace

import numpy as np
import pytest

from relight_core.lighting.environment import Environment
from relight_core.pipeline.auto_quality import Calibration, QualityChoice, TierCost

COSTS = {"draft": TierCost(8.0, 0.03), "live": TierCost(25.0, 0.01), "final": TierCost(60.0, 0.0)}


@pytest.mark.parametrize(
    ("budget_ms", "tier"), [(5, "draft"), (8, "draft"), (33, "live"), (59.9, "live"), (60, "final")]
)
def test_the_most_accurate_tier_within_the_budget(budget_ms, tier):
    assert QualityChoice("auto", budget_ms).moving(COSTS) == tier


def test_at_rest_the_picture_is_final():
    assert QualityChoice("auto", 1.0).at_rest() == "final"


def test_a_tier_that_is_wished_for_is_used_throughout():
    choice = QualityChoice("draft", 1000.0)
    assert (choice.at_rest(), choice.moving(COSTS)) == ("draft", "draft")


def test_unmeasured_machines_get_the_middle():
    assert QualityChoice("auto", 1.0).moving({}) == "live"


def test_a_quick_tier_that_is_also_the_better_one_wins():
    costs = COSTS | {"live": TierCost(5.0, 0.05)}
    assert QualityChoice("auto", 33.0).moving(costs) == "draft"


class FakeRelighter:
    """Errs by the tier's own offset."""

    OFFSET = {"draft": 0.2, "live": 0.1, "final": 0.0}

    def __init__(self):
        self.edits = []

    def relight(self, environment, edit, longest_side_px=None, *, for_shader=False):
        self.edits.append(edit)
        picture = np.full((4, 4, 3), 0.4 + self.OFFSET[edit.quality], np.float32)
        return SimpleNamespace(image=None if for_shader else picture)


def test_every_tier_is_measured_once_against_the_final_one():
    relighter, calibration = FakeRelighter(), Calibration()
    light = Environment.from_radiance(np.ones((16, 32, 3)))
    steps = 0
    while calibration.costs is None:
        calibration.measure_next(relighter, light)
        steps += 1
    assert steps == 3
    costs = calibration.costs
    assert costs["final"].error == 0
    assert costs["draft"].error > costs["live"].error > 0
    assert all(edit.channels == () for edit in relighter.edits)
    assert all(edit.surface_of == "final" for edit in relighter.edits), "as they are used"
    assert len({edit.yaw_deg for edit in relighter.edits}) > 4
