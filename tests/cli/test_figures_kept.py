"""Figures that took long are told although the files that were to hold them can't be written, and the other way."""

import json
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from app.cli import bench, bench_files, comparisons, evaluate
from app.cli.report import reporting
from relight_core.errors import InputError
from relight_core.evaluation import bench_report, contest_report, detail, stability, stability_plot

SCORES = detail.DetailScores({"bilinear": {"face": 1.25}}, {"bilinear": {"face": 1.5}}, 3, 64)


@pytest.fixture
def detail_that(monkeypatch):
    """Makes `relight evaluate --detail` do something instead of measuring for hours."""
    monkeypatch.setattr(evaluate, "check_heads_and_lights", lambda *_: 1)
    monkeypatch.setattr(detail, "REGIONS", ("face",))
    return lambda act: monkeypatch.setattr(detail, "compare_detail", lambda *_: act() or SCORES)


@pytest.mark.parametrize("as_json", [False, True])
def test_an_evaluation_whose_report_lost_its_folder_is_told(command_line, tmp_path, detail_that, as_json):
    folder = tmp_path / "out"
    folder.mkdir()
    detail_that(lambda: shutil.rmtree(folder))
    words = ["--detail", "--heads", tmp_path, "--lights", tmp_path, "-o", folder / "report.md"]
    done = command_line("evaluate", *words, *(["--json"] if as_json else []))
    assert done.code == 2
    assert done.err.splitlines()[-1].startswith(f"relight evaluate: {folder / 'report.md'}: there is no folder")
    if as_json:
        figures = {"errors": {"bilinear": {"face": 1.25}}, "blurred": {"bilinear": {"face": 1.5}}}
        assert json.loads(done.out) == {**figures, "pictures": 3, "size": 64}
    else:
        assert "| bilinear | 1.25 |" in done.out


def test_a_region_that_no_head_has_is_null_to_programs(command_line, tmp_path, detail_that, monkeypatch):
    monkeypatch.setitem(SCORES.errors["bilinear"], "face", float("nan"))
    detail_that(lambda: None)
    done = command_line("evaluate", "--detail", "--heads", tmp_path, "--lights", tmp_path, "--json")
    assert done.code == 0
    told = json.loads(done.out)
    assert told["errors"] == {"bilinear": {"face": None}}
    assert told["blurred"] == {"bilinear": {"face": 1.5}}


def test_a_report_is_written_although_nobody_can_be_told(tmp_path, monkeypatch):
    def refuse(_text):
        raise InputError("the output can't be written")

    monkeypatch.setattr("app.cli.report.say", refuse)
    with pytest.raises(InputError, match="output"), reporting(as_json=False) as report:
        evaluate._tell(report, tmp_path / "report.md", "a table", {})
    assert (tmp_path / "report.md").read_text() == "a table"


def of_the_timing(monkeypatch):
    results = iter(["timing", "never reached"])
    monkeypatch.setattr(bench, "_measured", lambda *_: results)
    monkeypatch.setattr(bench_report, "as_markdown", str)
    monkeypatch.setattr(bench_report, "as_record", lambda result: {"of": result})
    monkeypatch.setattr(bench_report, "as_full_record", lambda result: {"all of": result})
    return "timing"


def of_the_session(monkeypatch):
    monkeypatch.setattr(bench, "_replayed", lambda *_: iter([("one photo", {"photos": 1}), ("two", {"photos": 2})]))
    return "one photo"


def of_files(monkeypatch):
    times = {"whole_s": 5.0, "after_networks_s": 1.5, "peak_mib": 900.0}
    monkeypatch.setattr(bench_files, "time_files", lambda photo, rounds, report: {".png": times | {"file_mb": rounds}})
    return "| PNG | 5.0 | 1.5 | 900 | 7 |"


def of_attacks(monkeypatch):
    check = next(iter(stability.BOUNDS))
    found = stability.StabilityReport(("a face", "a sun"), (check,), np.array([[0.0], [1e9]]))
    monkeypatch.setattr(stability, "run_stability", lambda *_, **__: found)
    return f"a sun: {check} 1e+09 is above"


@pytest.mark.parametrize(
    ("words", "measured"),
    [
        ([], of_the_timing),
        (["--session"], of_the_session),
        (["--files", "--rounds", "7"], of_files),
        (["--stability"], of_attacks),
    ],
    ids=["bench", "session", "files", "stability"],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_a_bench_whose_files_can_t_be_written_is_told(command_line, tmp_path, monkeypatch, words, measured, as_json):
    told = measured(monkeypatch)
    for name in ("bench", "session", "files", "stability"):
        (tmp_path / f"{name}.json").mkdir()
    done = command_line("bench", *words, "-o", tmp_path, *(["--json"] if as_json else []))
    assert done.code == 2
    assert "this is a folder" in done.err.splitlines()[-1]
    if as_json:
        record = json.loads(done.out)
        assert record
        assert "all of" not in record, "that is for the file"
        assert set(record.get("files", ["png"])) == {"png"}
    else:
        assert told in done.out


@pytest.mark.parametrize(("error", "code"), [(0.0, 0), (1e9, 1)])
def test_an_error_above_its_bound_is_told_by_the_exit_code_and_all_is_written(
    command_line, tmp_path, monkeypatch, error, code
):
    found = stability.StabilityReport(("a face", "a sun"), (next(iter(stability.BOUNDS)),), np.array([[0.0], [error]]))
    asked = []
    monkeypatch.setattr(stability, "run_stability", lambda _photo, **given: asked.append(given) or found)
    monkeypatch.setattr(stability_plot, "plot_stability", lambda result, path: path.write_bytes(b"a picture"))
    words = ["--quick", "--weights", "w.safetensors"] if error else []
    assert command_line("bench", "--stability", *words, "-o", tmp_path).code == code
    (given,) = asked
    assert (given["quick"], str(given["weights"])) == ((True, "w.safetensors") if error else (False, "None"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["stability.json", "stability.md", "stability.png"]


def test_a_comparison_whose_files_can_t_be_written_is_told(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(contest_report, "as_record", lambda *_: {})
    outcome = SimpleNamespace(sheet=np.zeros((2, 2, 3), np.float32))
    with pytest.raises(InputError, match="no folder"), reporting(as_json=False) as report:
        comparisons._write(tmp_path / "gone" / "peers", outcome, "a table", "training", report)
    assert capsys.readouterr().out == "a table\n"
