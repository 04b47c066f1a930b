"""How far a command is that takes long, where it is told to a file."""

import re

import pytest
from synthetic_heads import write_balls, write_lights

from app.cli.maker_inputs import progress
from relight_core.training.state import Progress


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


def test_a_log_ends_with_a_whole_line_of_where_it_ended(capsys):
    losses = "distil-relight: step 600  specular 0.0380  shadow 0.0427  shadow_fraction 0.1562  gloss_fraction 0.1911"
    with progress("training", 2.0, line_every_s=3600.0) as show:
        show(1.0, "step 300")
        show(2.0, losses)
    line = rf"training 100 % 0:00:\d\d left 0:00:00 {re.escape(losses)}\n"
    assert re.fullmatch(line, capsys.readouterr().err)


def test_a_log_that_has_told_where_it_ended_tells_it_once(capsys):
    with progress("training", 1.0, line_every_s=0.0) as show:
        show(1.0, "step 50")
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_what_is_refused_before_it_begins_leaves_no_bar_in_a_log(capsys):
    with pytest.raises(ValueError, match="another plan"), progress("training", 1.0):
        raise ValueError("another plan")
    assert capsys.readouterr().err == ""


def test_reports_minutes_apart_give_an_estimate(capsys, monkeypatch):
    clock_s = {"now": 0.0}
    monkeypatch.setattr("rich.console.monotonic", lambda: clock_s["now"])
    with progress("training", 1.0, line_every_s=0.0) as show:
        for clock_s["now"], done in ((100.0, 0.25), (220.0, 0.5)):
            show(done)
        assert capsys.readouterr().err.splitlines()[-1] == "training 50 % 0:03:40 left 0:04:00"


def test_a_recipe_s_stages_count_by_their_length(run, tmp_path, monkeypatch):
    def follow(recipe, heads, lights, folder, report, *_, **__):
        report(1, 0.5, Progress(step=50))

    monkeypatch.setattr("relight_core.training.recipe.follow", follow)
    write_balls(tmp_path / "heads", 0, 1, size=32)
    write_lights(tmp_path / "lights.npz", 32)
    (tmp_path / "r.toml").write_text(
        "[[stage]]\nname = 'warm-delight'\nminutes = 30\nsize = 32\n"
        "[[stage]]\nname = 'tune-delight'\nminutes = 10\nsize = 32\n"
        "[[stage]]\nname = 'tune-relight'\nminutes = 60\nsize = 32\n"
    )
    words = [
        "train",
        "--recipe",
        tmp_path / "r.toml",
        "--heads",
        tmp_path / "heads",
        "--lights",
        tmp_path / "lights.npz",
    ]
    code, _, err = run(*words, "-o", tmp_path / "run")
    assert code == 0, err
    assert err.startswith("training 35 % ")
    assert "tune-delight: step 50" in err
