"""relight rigs and relight info."""

import hashlib
import json
import re
import subprocess
import tomllib
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from app.cli import info
from relight_core.resources import resource_path


def test_rigs_are_listed_for_people_and_programs(relight):
    lines = relight("rigs").out.splitlines()
    record = json.loads(relight("rigs", "--json").out)
    names = [rig["name"] for rig in record["rigs"]]
    assert {"soft-window", "rembrandt", "butterfly", "split", "ring", "golden-hour"} <= set(names)
    assert all(rig["title"] and rig["description"] for rig in record["rigs"])
    for name in names:
        assert any(line.startswith(name) for line in lines)
    more = [line for line in lines if line.split()[0] not in names]
    assert more
    assert all(line.startswith(" " * (max(map(len, names)) + 2)) for line in more)
    assert max(map(len, lines)) <= 100


def test_info_tells_versions_devices_and_graphics(relight):
    record = json.loads(relight("info", "--json").out)
    assert record["packages"]["torch"].startswith("2.")
    assert record["devices"][0] == "cpu"
    assert record["threads"]["torch"] >= 1
    assert record["graphics"]
    (weights,) = record["weights"]
    data = resource_path("weights", "relight.safetensors").read_bytes()
    known = {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    assert weights == {"file": "relight.safetensors"} | known
    text = relight("info").out
    assert "torch" in text
    assert "threads" in text


def probed(code, out="", err=""):
    return lambda *_, **__: subprocess.CompletedProcess([], code, out, err)


def too_slow(*_, **__):
    raise subprocess.TimeoutExpired("python", 30)


@pytest.mark.parametrize(
    ("probe", "told"),
    [
        (probed(0, "Mesa\nllvmpipe\n4.5\n"), "Mesa, llvmpipe, 4.5"),
        (probed(1, "", "Traceback:\nException: no display"), "no OpenGL context (Exception: no display)"),
        (probed(-11), "no OpenGL context (exit code -11)"),
        (probed(0, "Mesa\n"), "no OpenGL context (exit code 0)"),
        (too_slow, "no OpenGL context (TimeoutExpired)"),
    ],
)
def test_info_tells_who_draws_or_why_nobody_does(relight, monkeypatch, probe, told):
    monkeypatch.setattr(info.subprocess, "run", probe)
    assert f"graphics  {told}\n" in relight("info").out


def test_info_tells_the_version_of_whatever_reads_files_and_of_all_else_that_is_needed(relight, monkeypatch):
    monkeypatch.setattr(info, "version", lambda name: f"{name} is here")
    monkeypatch.setattr(info.subprocess, "run", too_slow)
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = [*project["dependencies"], *project["optional-dependencies"]["raw"], "mitsuba"]
    names = {re.match("[A-Za-z-]+", line)[0] for line in needed}
    assert {"pillow", "pi-heif", "rawpy"} <= names
    assert json.loads(relight("info", "--json").out)["packages"] == {name: f"{name} is here" for name in names}


def test_info_tells_what_is_not_there(relight, monkeypatch):
    def version(name):
        if name == "mitsuba":
            raise PackageNotFoundError(name)
        return "1.2"

    monkeypatch.setattr(info, "version", version)
    monkeypatch.setattr(info, "_weights", list)
    monkeypatch.setattr(info.subprocess, "run", too_slow)
    assert json.loads(relight("info", "--json").out)["packages"]["mitsuba"] is None
    lines = relight("info").out.splitlines()
    assert [line.split()[1:] for line in lines if line.strip().startswith("mitsuba")] == [["not", "installed"]]
    assert lines[-1] == "weights   none"
