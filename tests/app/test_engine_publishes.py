"""What the engine publishes and when, however requests and the words of other threads fall."""

import numpy as np
from fake_relighter import LONG_S, answered

from app.engine.desk import Desk
from app.engine.engine import Engine
from app.engine.sources import LightSource, PhotoSource, Request
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.pipeline.edit import Edit

SPLIT = LightSource("rig", "split")


def grey_source(boxes=None):
    return PhotoSource(Photo(np.full((24, 32, 3), 0.5, np.float32)), None, boxes)


def test_a_request_that_comes_just_as_the_engine_comes_to_rest_is_answered(engine, monkeypatch):
    source = grey_source()
    answered(engine, Request(source, SPLIT, Edit()))
    next_step, late = Desk.next_step, [Request(source, SPLIT, Edit(yaw_deg=9.0))]

    def another_wish_at_rest(desk, request, now):
        step = next_step(desk, request, now)
        if step is None and late:
            engine.submit(late.pop())
        return step

    monkeypatch.setattr(Desk, "next_step", another_wish_at_rest)
    assert answered(engine, Request(source, SPLIT, Edit(yaw_deg=5.0))).picture.edit.yaw_deg == 9.0


def test_a_slider_moves_the_picture_though_the_photo_that_is_wished_for_was_refused(engine):
    answered(engine, Request(grey_source(), SPLIT, Edit()))
    bad = grey_source((FaceBox(-40, 0, -8, 30),))
    assert bad in answered(engine, Request(bad, SPLIT, Edit())).refused
    engine.submit(Request(bad, SPLIT, Edit(shadow=0.25)))
    assert engine.wait_until_idle(LONG_S)
    assert engine.snapshot().picture.edit.shadow == 0.25


def test_the_window_is_woken_for_what_runs_for_its_result_and_for_rest(engine, published):
    final = answered(engine, Request(grey_source(), SPLIT, Edit()))
    at_work = [snapshot.picture for snapshot in published if snapshot.activity == "Relighting"]
    assert (at_work[0], at_work[-1]) == (None, final.picture), "nor does the picture wait for what comes after it"
    assert published[-1].activity is None


def test_what_another_thread_says_wakes_the_window_and_can_be_shown_in_lines(engine, published):
    engine.say("Saved a\x1b[2J\u2028b.png\nand more", is_error=True)
    told = published[-1].message
    assert told.text == "Saved a\N{REPLACEMENT CHARACTER}[2J\N{REPLACEMENT CHARACTER}b.png\nand more"
    assert told.is_error
    engine.say("Saved it")
    assert (published[-1].message.number, published[-1].message.is_error) == (told.number + 1, False)


def test_an_error_that_is_told_while_the_engine_works_is_still_known_when_it_is_done(engine, relighter):
    relighter.gate.clear()
    engine.submit(Request(grey_source(), SPLIT, Edit()))
    assert relighter.entered.acquire(timeout=LONG_S)
    engine.say("no such folder", is_error=True)
    engine.say("Saved it")
    relighter.gate.set()
    assert engine.wait_until_idle(LONG_S)
    snapshot = engine.snapshot()
    assert [error.text for error in snapshot.errors] == ["no such folder"]
    assert snapshot.message.text == "Saved it"


def test_an_engine_that_was_closed_keeps_nobody_waiting(engine):
    engine.close()
    engine.submit(Request(grey_source(), SPLIT, Edit()))
    assert engine.wait_until_idle(LONG_S)


def test_a_thread_that_could_not_be_set_up_works_all_the_same(relighter):
    def fail():
        raise OSError("no priority")

    engine = Engine(lambda: relighter, on_start=fail)
    snapshot = answered(engine, Request(grey_source(), SPLIT, Edit()))
    engine.close()
    assert "no priority" in snapshot.message.text
    assert snapshot.picture is not None
