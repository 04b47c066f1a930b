"""Frames follow each other no faster than a display shows them."""

import pytest

from app.window import frame_limit
from app.window.frame_limit import FrameLimit


@pytest.fixture
def clock(monkeypatch):
    """A clock that only sleeping moves; holds the time and what was slept."""

    class Clock:
        now_s, slept = 100.0, []

        def monotonic(self):
            return self.now_s

        def sleep(self, seconds):
            assert seconds > 0
            self.slept.append(seconds)
            self.now_s += seconds

    clock = Clock()
    clock.slept = []
    monkeypatch.setattr(frame_limit, "time", clock)
    return clock


def test_quick_frames_are_spread_over_the_second(clock):
    limit = FrameLimit(50)
    waits = [limit.wait() for _ in range(51)]
    assert waits == [False] + [True] * 50
    assert clock.now_s - 100.0 == pytest.approx(1.0)


def test_slow_frames_wait_for_nothing(clock):
    limit = FrameLimit(50)
    for _ in range(20):
        assert not limit.wait()
        clock.now_s += 0.03
    assert clock.slept == []


def test_after_a_pause_frames_do_not_catch_up(clock):
    limit = FrameLimit(50)
    limit.wait()
    clock.now_s += 10.0
    assert [limit.wait() for _ in range(3)] == [False, True, True]


@pytest.mark.parametrize(("rates", "hz"), [((), 60), ((0,), 60), ((60, 144), 144), ((None, 75), 75)])
def test_the_limit_is_the_quickest_displays(monkeypatch, rates, hz):
    class Mode:
        def __init__(self, rate):
            self.refresh_rate = rate

    monkeypatch.setattr(frame_limit.glfw, "get_monitors", lambda: list(rates))
    monkeypatch.setattr(frame_limit.glfw, "get_video_mode", lambda rate: None if rate is None else Mode(rate))
    assert frame_limit.display_hz() == hz
