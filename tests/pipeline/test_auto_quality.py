"""Which tier a hand and a budget get, and how tiers are measured."""

from types import SimpleNamespace

import numpy as np
import pytest

from relight_core.lighting.environment import Environment
from relight_core.pipeline import auto_quality
from relight_core.pipeline.auto_quality import Calibration, QualityChoice, TierCost

COSTS = {"draft": TierCost(8.0, 0.03), "live": TierCost(25.0, 0.01), "final": TierCost(60.0, 0.0)}


@pytest.mark.parametrize(
    ("budget_ms", "tier"), [(5, "draft"), (8, "draft"), (33, "live"), (59.9, "live"), (60, "final")]
)
def test_the_most_accurate_tier_within_the_budget(budget_ms, tier):
    assert QualityChoice("auto", budget_ms).moving(COSTS) == tier


def test_at_rest_the_picture_is_final():
    assert QualityChoice("auto", 1.0).at_rest() == "final"
    assert QualityChoice("auto", 1.0).surface_of() == "final"


def test_a_tier_that_is_wished_for_is_used_throughout():
    choice = QualityChoice("draft", 1000.0)
    assert (choice.at_rest(), choice.moving(COSTS)) == ("draft", "draft")
    assert choice.surface_of() is None


def test_unmeasured_machines_get_the_middle():
    assert QualityChoice("auto", 1.0).moving({}) == "live"


def test_a_quick_tier_that_is_also_the_better_one_wins():
    costs = COSTS | {"live": TierCost(5.0, 0.05)}
    assert QualityChoice("auto", 33.0).moving(costs) == "draft"


class FakeRelighter:
    """Errs by the tier's own offset, and takes its own time for every angle but the first, on a clock of its own.

    Its light is even: however that is turned, the picture before is found again, in no time, until it is forgotten.
    """

    OFFSET = {"draft": 0.2, "live": 0.1, "final": 0.0}
    MS = {"draft": 1.0, "live": 2.0, "final": 4.0}

    def __init__(self):
        self.edits, self.timed, self.now_s, self.kept = [], [], 0.0, None

    def forget_lights(self):
        self.kept = None

    def perf_counter(self):
        return self.now_s

    def relight(self, environment, edit, longest_side_px=None, *, for_shader=False):
        self.edits.append(edit)
        if for_shader:
            self.timed.append(edit)
            if self.kept != edit.quality:
                self.now_s += 1e-3 * self.MS[edit.quality] * (5000, 3, 9, 2, 8, 5)[(len(self.timed) - 1) % 6]
            self.kept = edit.quality
            return SimpleNamespace(image=None)
        first_angle = edit.yaw_deg == self.timed[1].yaw_deg
        error = self.OFFSET[edit.quality] * first_angle
        picture = np.full((4, 4, 3), 0.4, np.float32)
        picture[:2] += np.float32(error)
        return SimpleNamespace(image=picture)


def test_every_tier_is_measured_once_against_the_final_one(monkeypatch):
    relighter, calibration = FakeRelighter(), Calibration()
    monkeypatch.setattr(auto_quality, "time", relighter)
    light = Environment.from_radiance(np.ones((16, 32, 3)))
    steps = 0
    while calibration.costs is None:
        calibration.measure_next(relighter, light)
        steps += 1
    assert steps == 3
    costs = calibration.costs
    assert costs["final"].error == 0
    # Of displayed values, over two angles, the second of which has no error: sqrt((0.7977 - 0.6652) ** 2 / 4).
    assert costs["draft"].error == pytest.approx(0.0663, abs=1e-4)
    assert costs["draft"].error > costs["live"].error > 0
    assert [costs[name].ms for name in ("draft", "live", "final")] == pytest.approx([5.0, 10.0, 20.0])
    assert {edit.tolerance for edit in relighter.timed} - {relighter.timed[0].tolerance} == {0.0}
    assert [edit.tolerance for edit in relighter.timed].count(0.0) == 3 * 5
    assert all(edit.channels == () for edit in relighter.edits)
    assert all(edit.surface_of == "final" for edit in relighter.edits), "as they are used"
    assert len({edit.yaw_deg for edit in relighter.edits}) > 4


def test_under_another_light_all_tiers_are_measured_anew(monkeypatch):
    """Else a tier's error would be that of another light."""
    relighter, calibration = FakeRelighter(), Calibration()
    monkeypatch.setattr(auto_quality, "time", relighter)
    before, after = (Environment.from_radiance(np.full((16, 32, 3), level)) for level in (1.0, 2.0))
    for light in (before, before, after, after):
        calibration.measure_next(relighter, light)
        assert calibration.costs is None
    calibration.measure_next(relighter, after)
    assert set(calibration.costs) == {"draft", "live", "final"}
    assert calibration.costs["final"].error == 0
