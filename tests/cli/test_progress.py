"""How far a command is that takes long, where it is told to a file."""

import re

from app.cli.maker_inputs import progress


def test_a_log_gets_a_line_now_and_then(capsys):
    with progress("training", 2.0, line_every_s=0.0) as show:
        show(0.5, "step 50")
        show(1.0, "step 100")
        lines = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"training 25 % 0:00:\d\d left -:--:-- step 50", lines[0])
    assert re.fullmatch(r"training 50 % 0:00:\d\d left 0:00:\d\d step 100", lines[1])


def test_a_short_command_writes_no_such_lines(capsys):
    with progress("training", 2.0, line_every_s=3600.0) as show:
        show(0.5, "step 50")
        assert capsys.readouterr().err == ""


def test_reports_minutes_apart_give_an_estimate(capsys, monkeypatch):
    clock_s = {"now": 0.0}
    monkeypatch.setattr("rich.console.monotonic", lambda: clock_s["now"])
    with progress("training", 1.0, line_every_s=0.0) as show:
        for clock_s["now"], done in ((100.0, 0.25), (220.0, 0.5)):
            show(done)
        assert capsys.readouterr().err.splitlines()[-1] == "training 50 % 0:03:40 left 0:04:00"
