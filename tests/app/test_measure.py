"""The measurement of the window's speed runs through and measures what it says."""

import argparse
import json
import threading

import numpy as np
import pytest
from fake_relighter import FakeRelighter

from app.cli import measure
from app.window.measure import Spread, WindowSpeed, measure_window
from app.window.window import EditorWindow
from relight_core.errors import InputError
from relight_core.imaging.write import write_image


def test_a_spread_is_median_and_95th_percentile_in_milliseconds():
    spread = Spread.of([index / 1000 for index in range(101)])
    assert (round(spread.median_ms, 6), round(spread.p95_ms, 6)) == (50.0, 95.0)


def test_every_movement_is_answered_and_counted(display, photo_path, monkeypatch):
    monkeypatch.setattr("app.window.measure._UNCOUNTED_S", 0.0)
    relighter = FakeRelighter()
    parts = list(
        measure_window(
            lambda: relighter, [photo_path], size=(1024, 700), drag_s=0.05, repeats=3, idle_s=0.0, openings=2
        )
    )
    assert [(part.rotation is None, part.idle_cpu is None, len(part.memory_mb)) for part in parts] == [
        (True, True, 0),
        *[(False, True, 0)] * 3,
        *[(False, False, opened) for opened in (0, 1, 2)],
    ]
    speed = parts[-1]
    assert speed.frames > 0
    for spread in (speed.frame, speed.rotation, speed.shadow, speed.exposure):
        assert 0 < spread.median_ms <= spread.p95_ms
    shadows = [edit.shadow for edit in relighter.relights if edit.quality == "live"]
    assert {0.2, 0.57, 0.94} <= {round(shadow, 2) for shadow in shadows}
    assert len(speed.memory_mb) == len(speed.opening_s) == 2
    assert min(speed.memory_mb) > 10
    assert min(speed.opening_s) > 0
    assert len(relighter.portraits) == 3


def test_a_drag_never_comes_back_to_a_light_whose_picture_may_be_kept(display, photo_path, monkeypatch):
    places, frame, move = [], EditorWindow.frame, EditorWindow.on_mouse_move

    def noted(window, handle, x, y):
        places.append(x)
        move(window, handle, x, y)

    monkeypatch.setattr("app.window.measure._DISPLAY_HZ", 1e6)
    monkeypatch.setattr(EditorWindow, "on_mouse_move", noted)
    # Once the mouse has begun to move, nothing needs to be drawn.
    monkeypatch.setattr(EditorWindow, "frame", lambda window: frame(window) if len(places) < 2 else None)
    parts = measure_window(FakeRelighter, [photo_path], size=(1024, 700), drag_s=0.1)
    next(parts)
    parts.close()
    _pressed, *dragged, _back = places
    assert len(dragged) > 80
    assert len(set(dragged[:80])) == 80


@pytest.mark.parametrize("in_turn", [False, True])
def test_a_photo_that_can_not_be_measured_is_told_at_once(display, photo_path, tmp_path, monkeypatch, in_turn):
    monkeypatch.setattr("app.window.measure._UNCOUNTED_S", 0.0)
    missing = tmp_path / "missing.jpg"
    photos, parts = ([photo_path, missing] if in_turn else [missing]), []
    with pytest.raises(InputError, match=r"missing\.jpg: no such file"):
        parts.extend(measure_window(FakeRelighter, photos, drag_s=1e-9, repeats=1, idle_s=0.0, openings=2))
    assert len(parts) == (6 if in_turn else 0)


def test_an_interruption_at_rest_ends_the_measurement_at_once(display, photo_path, monkeypatch):
    def interrupted(_window):
        raise KeyboardInterrupt

    relighter = FakeRelighter()
    parts = measure_window(lambda: relighter, [photo_path], size=(1024, 700), drag_s=1e-9, repeats=1, idle_s=5.0)
    for _ in range(4):
        next(parts)
    threads = set(threading.enumerate())
    monkeypatch.setattr("app.window.measure.EditorWindow.run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        next(parts)
    assert set(threading.enumerate()) <= threads


def test_a_photo_without_a_face_is_told_at_once(display, tmp_path):
    write_image(tmp_path / "black.png", np.zeros((32, 32, 3), np.float32))
    with pytest.raises(InputError, match="face"):
        next(measure_window(FakeRelighter, [tmp_path / "black.png"]))


PARTS = (
    WindowSpeed(frame=Spread(8.0, 12.0), frames=90, updates=20),
    WindowSpeed(frame=Spread(8.0, 12.0), frames=90, updates=20, rotation=Spread(50.0, 70.0)),
    WindowSpeed(
        Spread(8.0, 12.0),
        Spread(50.0, 70.0),
        frames=90,
        updates=20,
        idle_cpu=0.0325,
        memory_mb=(300.0, 310.0),
        opening_s=(1.0, 1.5),
    ),
)


def run_measure(monkeypatch, parts, *words):
    monkeypatch.setattr("app.window.measure.measure_window", lambda *_, **__: iter(parts()))
    parser = argparse.ArgumentParser()
    measure.add_arguments(parser)
    return measure.run(parser.parse_args(["a.jpg", *words]))


def test_each_part_is_told_once_it_is_there_and_told_once(monkeypatch, capsys):
    assert run_measure(monkeypatch, lambda: PARTS, "--openings", "2") == 0
    told = capsys.readouterr()
    lines = [" ".join(line.split()) for line in told.out.splitlines()]
    assert lines.count("a frame while the networks run 8.0 ms 12.0 ms") == 1
    assert lines.count("rotation, hand to picture 50.0 ms 70.0 ms") == 1
    assert lines[0] == "median p95"
    assert "at rest 3.25% of a core" in lines
    assert "90 frames and 20 pictures" in told.out
    assert "after opening number 1: 300, 2: 310; 310 at the most" in told.out
    assert told.err == "opened 2 of 2, 310 MiB, 1.2 s each, 0.0 min left\n"


@pytest.mark.parametrize("words", [(), ("--json",)])
def test_a_window_that_can_not_be_measured_leaves_no_empty_table(monkeypatch, capsys, words):
    def refuse():
        raise InputError("a.jpg: no such file; check the path")
        yield

    with pytest.raises(InputError):
        run_measure(monkeypatch, refuse, *words)
    assert capsys.readouterr() == ("", "")


def test_what_is_measured_is_what_was_asked_for(monkeypatch, capsys):
    asked = {}
    monkeypatch.setattr("app.window.measure.measure_window", lambda *_, **given: asked.update(given) or iter(()))
    parser = argparse.ArgumentParser()
    measure.add_arguments(parser)
    words = ["--openings", "3", "--seconds", "2.5", "--repeats", "7", "--quality", "draft", "--json"]
    assert measure.run(parser.parse_args(["a.jpg", *words])) == 0
    assert asked == {"drag_s": 2.5, "repeats": 7, "openings": 3, "quality": "draft"}
    assert capsys.readouterr().out == "", "nothing was measured"


@pytest.mark.parametrize(
    ("count", "places"),
    [(1, "1: 300"), (2, "1: 300, 2: 301"), (40, "1: 300, 10: 309, 20: 319, 30: 329, 40: 339")],
)
def test_of_many_openings_the_first_the_last_and_some_between_are_told(count, places):
    memory_mb = tuple(300.0 + number for number in range(count))
    most = f"{299 + count} at the most"
    assert measure.memory_line(memory_mb) == f"MiB of memory after opening number {places}; {most}"
    assert measure.memory_line((400.0, *memory_mb)).endswith("; 400 at the most")


def test_what_was_measured_before_an_interruption_is_told_and_kept(monkeypatch, capsys, tmp_path):
    def interrupted():
        yield PARTS[0]
        yield PARTS[2]
        raise KeyboardInterrupt

    path = tmp_path / "speed.json"
    with pytest.raises(KeyboardInterrupt):
        run_measure(monkeypatch, interrupted, "--openings", "200", "--json", "-o", str(path))
    told = json.loads(capsys.readouterr().out)
    assert told == json.loads(path.read_text())
    assert told["memory_mb"] == [300.0, 310.0]
    assert told["shadow"] is None


def test_how_long_is_left_is_told_from_what_an_opening_has_taken(monkeypatch, capsys):
    opened = WindowSpeed(frame=Spread(8.0, 12.0), memory_mb=(300.0,), opening_s=(30.0,))
    assert run_measure(monkeypatch, lambda: (opened,), "--openings", "8") == 0
    assert capsys.readouterr().err == "opened 1 of 8, 300 MiB, 30.0 s each, 3.5 min left\n"


def test_where_the_system_tells_no_memory_the_rest_is_told(monkeypatch, capsys):
    opened = WindowSpeed(frame=Spread(8.0, 12.0), memory_mb=(None, None), opening_s=(1.0, 1.5))
    assert run_measure(monkeypatch, lambda: (opened,), "--openings", "2") == 0
    told = capsys.readouterr()
    assert "MiB" not in told.out
    assert told.err == "opened 2 of 2, 1.2 s each, 0.0 min left\n"
