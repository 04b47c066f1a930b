"""What is kept of a stage's results, and for how long."""

from relight_core.pipeline.cache import StageCache


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
    assert not cache.has("one", 0)
    assert cache.has("other", 0)


def test_whatever_is_not_of_the_photo_is_forgotten_with_its_light():
    cache = StageCache()
    cache.of_photo("delight", 1, lambda: "face")
    cache.run("irradiance", 1, lambda: "light", "new light")
    cache.run("paste", 1, lambda: "picture", "new light, slider or background")
    cache.forget_lights()
    assert [cache.has(name, 1) for name in ("delight", "irradiance", "paste")] == [True, False, False]
