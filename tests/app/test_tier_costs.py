"""What the tiers cost: kept between runs, never trusted when damaged, corrected by what is seen."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from app.engine import calibration_file, tier_meter
from app.engine.calibration_file import read_costs, write_costs
from app.engine.snapshot import Snapshot
from app.engine.tier_meter import TierMeter
from relight_core.lighting.environment import Environment
from relight_core.pipeline.auto_quality import TierCost

COSTS = {"draft": TierCost(8.0, 0.03), "live": TierCost(25.0, 0.01), "final": TierCost(60.0, 0.0)}
LIGHT = Environment.from_radiance(np.ones((16, 32, 3)))


class FakeRelighter:
    def __init__(self):
        self.count = 0

    def relight(self, environment, edit, longest_side_px=None, *, for_shader=False):
        self.count += 1
        return SimpleNamespace(image=np.full((2, 2, 3), 0.5, np.float32))

    def forget_lights(self):
        """It keeps nothing."""


@pytest.fixture(autouse=True)
def _one_machine(monkeypatch):
    monkeypatch.setattr(tier_meter, "machine_key", lambda: "this machine")


def turned(ms):
    return {
        "delight": SimpleNamespace(ms=0.0, state="reused"),
        "irradiance": SimpleNamespace(ms=0.0, state="computed"),
        "specular_shadow": SimpleNamespace(ms=0.0, state="computed"),
        "compose": SimpleNamespace(ms=ms, state="computed"),
    }


def test_costs_come_back_on_the_same_machine_only(tmp_path):
    path = tmp_path / "quite" / "deep" / "tiers.json"
    write_costs(path, "here", COSTS)
    assert read_costs(path, "here") == COSTS
    assert read_costs(path, "elsewhere") is None


@pytest.mark.parametrize(
    "content",
    ["", "[]", "null", "{", '{"version": 1, "key": "here"}', '{"version": 1, "key": "here", "tiers": [1]}']
    + [json.dumps({"version": 1, "key": "here", "tiers": {"live": {"ms": 3, "error": 0}}})]
    + ['{"version": 1, "key": "here", "tiers": {"draft": {"ms": NaN, "error": 0}}}']
    + [json.dumps({"version": 2, "key": "here", "tiers": {name: {"ms": 3, "error": 0} for name in COSTS}})]
    + [json.dumps({"version": 1, "key": "here", "tiers": {name: {"ms": 3, "error": math.inf} for name in COSTS}})]
    + ["[" * 100_000]
    + ['{"version": 1, "key": "here", "tiers": {"draft": {"ms": 1%s, "error": 0}}}' % ("0" * 400)],
)
def test_damaged_files_count_as_none(tmp_path, content):
    path = tmp_path / "tiers.json"
    path.write_text(content)
    assert read_costs(path, "here") is None


def test_a_folder_that_cannot_be_written_to_is_no_fault(tmp_path):
    (tmp_path / "file").write_text("")
    write_costs(tmp_path / "file" / "tiers.json", "here", COSTS)
    assert (tmp_path / "file").read_text() == ""


def test_without_a_path_nothing_is_measured():
    meter = TierMeter(None)
    meter.read()
    assert not meter.is_due
    assert meter.costs() == {}


def test_measured_at_the_first_start_and_known_at_the_second(tmp_path):
    path, relighter = tmp_path / "tiers.json", FakeRelighter()
    first = TierMeter(path)
    first.read()
    while first.is_due:
        first.measure_next(relighter, LIGHT)
    assert set(first.costs()) == {"draft", "live", "final"}
    second = TierMeter(path)
    second.read()
    second.begin_again()
    assert not second.is_due
    assert second.costs() == first.costs()


def test_a_failure_ends_the_measuring(tmp_path):
    meter = TierMeter(tmp_path / "tiers.json")
    meter.read()
    now = Snapshot()
    assert meter.give_up(now) is now
    assert not meter.is_due


def test_pictures_correct_the_figures_until_the_next_photo(tmp_path):
    path = tmp_path / "tiers.json"
    write_costs(path, "this machine", COSTS)
    meter = TierMeter(path)
    meter.read()
    for ms in (40.0, 41.0, 39.0, 40.0):
        meter.observe("live", turned(ms))
    assert meter.costs()["live"].ms == 25.0
    meter.observe("live", turned(500.0))
    assert meter.costs()["live"] == TierCost(40.0, 0.01)
    assert meter.costs()["draft"] == COSTS["draft"]
    meter.forget_photo()
    assert meter.costs() == COSTS


def test_only_updates_after_a_turn_count(tmp_path):
    path = tmp_path / "tiers.json"
    write_costs(path, "this machine", COSTS)
    meter = TierMeter(path)
    meter.read()
    slider = {
        "irradiance": SimpleNamespace(ms=0.0, state="reused"),
        "sliders": SimpleNamespace(ms=1.0, state="computed"),
    }
    opening = turned(3.0) | {"delight": SimpleNamespace(ms=900.0, state="computed")}
    with_one_more_face = turned(3.0) | {"other_faces_delight": SimpleNamespace(ms=900.0, state="computed")}
    for _ in range(9):
        meter.observe("live", slider)
        meter.observe("live", opening)
        meter.observe("live", with_one_more_face)
        meter.observe("live", {})
    assert meter.costs() == COSTS


@pytest.mark.parametrize(("stage", "state"), [("compose", "reused"), ("specular_shadow", "skipped")])
def test_pictures_whose_networks_had_nothing_to_do_do_not_count(tmp_path, stage, state):
    """Of a light that was seen before the networks' results are kept, and a strength of 0 asks for none."""
    path = tmp_path / "tiers.json"
    write_costs(path, "this machine", COSTS)
    meter = TierMeter(path)
    meter.read()
    for _ in range(9):
        meter.observe("final", turned(3.0) | {stage: SimpleNamespace(ms=0.0, state=state)})
    assert meter.costs() == COSTS


def test_of_many_pictures_the_latest_count(tmp_path):
    path = tmp_path / "tiers.json"
    write_costs(path, "this machine", COSTS)
    meter = TierMeter(path)
    meter.read()
    for ms in [10.0] * 20 + [50.0] * 15:
        meter.observe("live", turned(ms))
    assert meter.costs()["live"].ms == 50.0
    write_costs(path, "this machine", {name: TierCost(1.0, 0.0) for name in COSTS})
    meter.read()
    assert meter.costs()["draft"] == COSTS["draft"], "read once"


def test_other_weights_or_another_processor_make_it_another_machine(tmp_path, monkeypatch):
    weights = tmp_path / "weights"
    weights.write_bytes(b"1")
    monkeypatch.setattr("relight_core.resources.resource_path", lambda *parts: weights)
    first = calibration_file.machine_key()
    assert calibration_file.machine_key() == first
    monkeypatch.setattr("os.cpu_count", lambda: 1234)
    second = calibration_file.machine_key()
    weights.write_bytes(b"12")
    assert len({first, second, calibration_file.machine_key()}) == 3
