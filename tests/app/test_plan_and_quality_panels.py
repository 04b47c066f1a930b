"""What the plan and the quality panel say."""

import pytest

from app.ui.panels.plan_panel import duration, explanation, forced, summary, title
from app.ui.panels.quality_panel import cost_lines
from app.ui.viewport import progress_card
from relight_core.pipeline.auto_quality import TierCost
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.plan import Effect

SHADOW = Effect("shadow", "reused", "nothing it reads has changed", 0.0, None, 12.4)
LIGHT = Effect("source_light", "skipped", "nobody looks at it", 0.0, None, None)
RELIEF = Effect("relief", "skipped", "hardly to be seen", 0.001, None, 1500.0)
DETAIL = Effect("detail", "computed", "a new light", 0.0, None, 0.0)


def test_names_as_they_stand_in_the_list():
    assert [title(effect) for effect in (SHADOW, LIGHT)] == ["Shadow", "Source light"]


def test_the_sum_in_a_line():
    assert summary([SHADOW, LIGHT, DETAIL]) == "1 of 3 run, 12 ms saved"


def test_reasons_in_words():
    assert explanation(SHADOW) == "reused: nothing it reads has changed; 12 ms saved"
    assert explanation(LIGHT) == "skipped: nobody looks at it; no pixel changes"
    assert explanation(RELIEF) == "skipped: hardly to be seen; 1.5 s saved"
    assert explanation(DETAIL) == "computed: a new light"


@pytest.mark.parametrize(("ms", "text"), [(0.4, "0 ms"), (999.0, "999 ms"), (1250.0, "1.2 s")])
def test_durations(ms, text):
    assert duration(ms) == text


def test_the_user_s_say_goes_round_and_leaves_other_effects_alone():
    edit = Edit(forced_off=frozenset({"detail"}))
    for wish in (True, False, None):
        edit = Edit(**forced(edit, "shadow", wish))
        assert edit.forced("shadow") is wish
        assert edit.forced("detail") is False


def test_costs_below_a_tier():
    costs = {"draft": TierCost(8.4, 0.02), "live": TierCost(20.0, 0.004), "final": TierCost(61.0, 0.0)}
    assert cost_lines("draft", costs) == ("8 ms", "±5.1")
    assert cost_lines("live", costs) == ("20 ms", "±1.0")
    assert cost_lines("final", costs) == ("61 ms", "best")
    assert cost_lines("auto", costs) == ()


@pytest.mark.parametrize(("seconds", "said"), [(0.2, "1 s"), (89.0, "89 s"), (120.0, "2 min")])
def test_what_is_left_of_long_work_is_told_in_seconds_and_then_in_minutes(seconds, said):
    assert progress_card.duration(seconds) == said
