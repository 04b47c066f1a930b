"""What a replayed session asks of two relighters, and what it counts of their answers."""

from types import SimpleNamespace

import numpy as np
import pytest

from relight_core.evaluation.bench_session import Savings, recorded_session, replay, visits
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit


def some_light(level=1.0, name="noon"):
    return Environment.from_radiance(np.full((16, 32, 3), level, np.float32), name)


def stages(**ms):
    """Stages by what they took; None for one whose result was reused."""
    return {
        name: SimpleNamespace(ms=0.0 if took is None else took, state="reused" if took is None else "computed")
        for name, took in ms.items()
    }


class Answering:
    """In place of a relighter: one answer after the other."""

    def __init__(self, *answers):
        self.answers, self.asked, self.photos = iter(answers), [], []

    def set_portrait(self, photo):
        self.photos.append(photo)

    def forget_lights(self):
        self.asked.append("forget")

    def relight(self, light, edit):
        self.asked.append(edit)
        return next(self.answers)


def answer(value=0.0, bounds=(), ran=None):
    """A picture that is black but for one value, and a plan with such bounds."""
    image = np.zeros((2, 2, 3), np.float32)
    image[1, 0, 2] = value
    plan = [SimpleNamespace(name="relief", state="skipped", why="flat", bound=bound, saved_ms=None) for bound in bounds]
    return SimpleNamespace(image=image, plan=plan, stages=stages(compose=1.0) if ran is None else ran)


def test_a_stage_that_has_run_once_counts_in_every_update_by_what_it_last_took():
    reused = {"delight": None, "compose": None}
    # In the last update nobody asked for de-lighting's result.
    ran = [{"delight": 100.0, "compose": 10.0}, reused | {"compose": 20.0}, reused, {"compose": None}]
    relighter, told = Answering(*(answer(ran=stages(**ms)) for ms in ran)), []
    savings, session = Savings(), [(some_light(), Edit())] * 4
    replay(relighter, None, "a photo", session, savings, report=lambda: told.append(savings.updates))
    assert relighter.photos == ["a photo"]
    assert (savings.updates, savings.runs, savings.avoided) == (4, 8, 5)
    assert (savings.ms, savings.ms_of_everything) == (130.0, 110.0 + 3 * 120.0)
    assert told == [1, 2, 3, 4]
    assert savings.compared == 0


def test_a_session_saves_nothing_by_the_lights_of_the_one_before():
    relighter = Answering(answer(), answer())
    for _ in range(2):
        replay(relighter, None, "a photo", [(some_light(), Edit())], Savings())
    assert relighter.asked == ["forget", Edit()] * 2


def test_what_the_plan_gives_a_bound_for_is_always_compared_and_of_the_rest_some():
    bounds = {1: (0.5,), 5: (0.0,)}
    relighter = Answering(*(answer(bounds=bounds.get(number, ())) for number in range(8)))
    thorough, savings = Answering(*[answer()] * 4), Savings()
    replay(relighter, thorough, "a photo", [(some_light(), Edit())] * 8, savings, compare_every=3)
    # The first, fourth and seventh, and the second for its bound.
    assert savings.compared == 4
    assert thorough.photos == ["a photo"]


def test_the_largest_error_is_of_one_displayed_value_and_is_set_against_the_largest_bound_of_its_picture():
    # Below 0.0031308 what is displayed is 12.92 times as much.
    values, bounds = (0.001, 0.003, 0.002), ((0.0125, 0.014), (0.02, 0.03), (0.0, 0.005))
    relighter = Answering(*(answer(*given) for given in zip(values, bounds, strict=True)))
    savings, light = Savings(), some_light(name="dusk")
    replay(relighter, Answering(*[answer()] * 3), "a photo", [(light, Edit(yaw_deg=30))] * 3, savings, compare_every=1)
    assert savings.largest_error == pytest.approx(0.03876, abs=1e-6)
    assert savings.largest_bound == 0.03
    assert savings.broken == [
        "dusk at 30 degrees: 0.03876, not 0.03000",
        "dusk at 30 degrees: 0.02584, not 0.00500",
    ]


def test_pictures_are_compared_with_those_of_the_same_edit_in_which_everything_runs():
    edit = Edit(yaw_deg=40.0, shadow=1.5, quality="live", channels=(), surface_of="final")
    thorough = Answering(answer())
    replay(Answering(answer()), thorough, "a photo", [(some_light(), edit)], Savings())
    forgot, asked = thorough.asked
    assert forgot == "forget"
    assert (asked.yaw_deg, asked.shadow, asked.quality, asked.surface_of) == (40.0, 1.5, "live", "final")
    assert asked.channels is None
    assert {"relief", "shadow", "hard_shadow", "specular", "correction", "sliders", "detail"} <= set(asked.forced_on)
    assert "background" not in asked.forced_on


def test_a_recorded_hand_turns_the_light_all_the_way_and_drags_both_sliders_there_and_back():
    steps = recorded_session([some_light()], turns=3)
    rest, moving = [edit for _, edit in (steps[0], steps[-1])], [edit for _, edit in steps[1:-1]]
    assert rest == [Edit(quality="final")] * 2
    assert {(edit.quality, edit.surface_of, edit.channels) for edit in moving} == {("live", "final", ())}
    assert [edit.yaw_deg for edit in moving[:4]] == [120.0, 240.0, 360.0, 0.0]
    for name, first in (("shadow", 3), ("specular", 23)):
        gains = [getattr(edit, name) for edit in moving[first : first + 20]]
        assert (gains[0], max(gains), gains[-1]) == (1, 2, 1)
        assert gains == pytest.approx(gains[::-1])
        assert all(getattr(edit, name) == 1 for edit in moving[:first] + moving[first + 20 :])


def test_a_visit_moves_both_sliders_and_makes_the_light_brighter_where_it_stands():
    steps = visits([some_light(2.0)], turns=12)
    assert steps[0][1] == Edit(quality="final")
    moving = [edit for _, edit in steps[1:]]
    assert {(edit.quality, edit.surface_of, edit.channels) for edit in moving} == {("live", "final", ())}
    yaws_deg = [edit.yaw_deg for edit in moving]
    assert len(set(yaws_deg[:2])) == 2
    assert yaws_deg[1:5] == yaws_deg[1:2] * 4
    assert [(edit.shadow, edit.specular) for edit in moving[2:4]] == [(1.6, 1.0), (1.0, 0.3)]
    assert [light.level for light, _ in steps] == pytest.approx([2.0] * 5 + [3.4, 0.0])
