"""What is kept of a stage's results, and for how long."""

import pytest

from relight_core.pipeline import cache as cache_module
from relight_core.pipeline.cache import StageCache, computed_ms


def made_by(cache, keys, keep):
    """Which of the keys, asked for one after the other, had to be made."""
    made = []
    for key in keys:
        cache.run("stage", key, lambda key=key: made.append(key), "asked for", keep)
    return made


def test_what_was_used_last_is_kept_and_not_what_was_made_last():
    assert made_by(StageCache(), "abacab", keep=2) == ["a", "b", "c", "b"]


def test_another_stage_of_the_same_key_is_another_result():
    cache = StageCache()
    assert cache.run("one", 0, lambda: "first", "asked for") == "first"
    assert cache.run("other", 0, lambda: "second", "asked for") == "second"
    assert cache.run("one", 0, lambda: "third", "asked for") == "first"


def test_a_forgotten_stage_is_made_again_and_no_other():
    cache = StageCache()
    for name in ("one", "other"):
        cache.run(name, 0, lambda: None, "asked for")
    cache.forget("one")
    cache.forget("never made")
    assert not cache.has("one", 0)
    assert cache.has("other", 0)


def test_whatever_is_not_of_the_photo_is_forgotten_with_its_light():
    cache = StageCache()
    cache.of_photo("delight", 1, lambda: "face")
    cache.run("irradiance", 1, lambda: "light", "new light")
    cache.run("paste", 1, lambda: "picture", "new light, slider or background")
    of_photo = {name for name, stage in cache.record.stages.items() if stage.is_of_photo}
    assert of_photo == {"delight"}
    cache.forget_lights()
    assert [cache.has(name, 1) for name in ("delight", "irradiance", "paste")] == [True, False, False]
    for size in (2, 3):
        cache.of_photo("delight", size, lambda: "face", keep=2)
    assert [cache.has("delight", size) for size in (1, 2, 3)] == [False, True, True]


class Clock:
    """Stands still but where something is made."""

    now_s = 100.0

    def perf_counter(self):
        return self.now_s

    def takes(self, ms):
        self.now_s += ms / 1000


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(cache_module, "time", clock)
    return clock


def test_a_stage_s_time_is_its_own_without_those_that_it_started(clock):
    cache = StageCache()

    def inner():
        clock.takes(5)
        cache.run("innermost", 0, lambda: clock.takes(7), "asked for")

    def outer():
        clock.takes(1)
        cache.run("inner", 0, inner, "asked for")
        cache.run("beside", 0, lambda: clock.takes(3), "asked for")
        cache.run("inner", 0, inner, "asked for")
        clock.takes(2)

    cache.record.begin_update()
    clock.takes(50)
    cache.run("outer", 0, outer, "asked for")
    stages = cache.record.stages
    assert {name: stage.state for name, stage in stages.items()} == dict.fromkeys(stages, "computed")
    times = {name: (round(stage.start_ms), round(stage.ms)) for name, stage in stages.items()}
    assert times == {"innermost": (56, 7), "inner": (51, 5), "beside": (63, 3), "outer": (50, 3)}
    assert computed_ms(stages) == pytest.approx(18)
    assert cache.record.typical_ms["outer"] == pytest.approx(3)
    assert cache.record.last_end({"innermost", "inner"}) == pytest.approx(100.063)
    assert cache.record.last_end({"outer", "inner"}) == pytest.approx(100.068)
    assert cache.record.last_end({"another"}) is None


def test_a_stage_that_runs_for_two_keys_in_an_update_has_taken_the_time_of_both(clock):
    """Of a portrait at final quality the first update takes the face apart at live quality too, for the matte."""
    cache = StageCache()
    cache.record.begin_update()
    clock.takes(2)
    cache.of_photo("delight", "final", lambda: clock.takes(30), keep=2)
    cache.run("matte", 0, lambda: cache.of_photo("delight", "live", lambda: clock.takes(10), keep=2), "new photo")
    cache.of_photo("delight", "final", lambda: clock.takes(30), keep=2)
    told = cache.record.stages["delight"]
    assert (told.state, round(told.start_ms), round(told.ms)) == ("computed", 2, 40)
    assert computed_ms(cache.record.stages) == pytest.approx(40)
    cache.record.begin_update()
    cache.of_photo("delight", "draft", lambda: clock.takes(5))
    assert cache.record.stages["delight"].ms == pytest.approx(5)


def test_an_update_tells_what_it_did_and_not_what_others_did(clock):
    cache = StageCache()
    cache.record.begin_update()
    cache.run("light", 0, lambda: clock.takes(9), "new light")
    before = cache.record.stages
    clock.takes(1000)
    cache.record.begin_update()
    clock.takes(4)
    cache.run("light", 0, lambda: clock.takes(9), "new light")
    cache.skip("edges", "no lamp")
    told = {name: (stage.state, stage.why, stage.ms, round(stage.start_ms)) for name, stage in before.items()}
    assert told == {"light": ("computed", "new light", pytest.approx(9), 0)}
    told = {name: (stage.state, stage.ms, round(stage.start_ms)) for name, stage in cache.record.stages.items()}
    assert told == {"light": ("reused", 0, 4), "edges": ("skipped", 0, 4)}
    assert computed_ms(cache.record.stages) == 0
    assert cache.record.typical_ms["light"] == pytest.approx(9)
