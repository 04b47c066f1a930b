"""The measurement of the window's speed runs through and measures what it says."""

from fake_relighter import FakeRelighter

from app.window.measure import Spread, measure_window


def test_a_spread_is_median_and_95th_percentile_in_milliseconds():
    spread = Spread.of([index / 1000 for index in range(101)])
    assert (round(spread.median_ms, 6), round(spread.p95_ms, 6)) == (50.0, 95.0)


def test_every_movement_is_answered_and_counted(display, photo_path, monkeypatch):
    monkeypatch.setattr("app.window.measure.time.sleep", lambda _seconds: None)
    relighter = FakeRelighter()
    speed = measure_window(
        lambda: relighter, [photo_path], size=(1024, 700), drag_s=0.05, repeats=3, idle_s=0.0, openings=2
    )
    assert speed.frames > 0
    for spread in (speed.frame, speed.rotation, speed.shadow, speed.exposure):
        assert 0 < spread.median_ms <= spread.p95_ms
    shadows = [edit.shadow for edit in relighter.relights if edit.quality == "live"]
    assert {0.2, 0.57, 0.94} <= {round(shadow, 2) for shadow in shadows}
    assert len(speed.memory_mb) == 2
    assert min(speed.memory_mb) > 10
    assert len(relighter.portraits) == 3
