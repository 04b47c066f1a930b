"""What `relight dataset effect` and `speed` print: each figure of its own data set under its own heading."""

from types import SimpleNamespace

import numpy as np
import pytest

from app.cli import dataset_studies
from relight_core.evaluation import dataset_effect, loader_speed
from relight_core.evaluation.dataset_effect import Comparison, DatasetFigures, TrainingSettings


def test_an_effect_is_of_plain_samples_of_bare_heads_beside_varied_ones_of_dressed_heads(tmp_path, monkeypatch, capsys):
    asked, sheets = {}, []

    def trained(heads, lights, settings, checkpoint, report, *, plain):
        asked[checkpoint.stem] = heads, lights, settings, plain
        return checkpoint.stem

    def compared(networks, paths, size):
        assert (networks, paths, size) == ({"plain": "plain", "varied": "varied"}, ["a.jpg"], 32)
        figures = {"plain": DatasetFigures(0.5, 0.25, 0.75), "varied": DatasetFigures(0.6, np.nan, 0.1)}
        return Comparison(figures, [("a picture", np.zeros((32, 32, 3), np.float32))] * 5, 3)

    monkeypatch.setattr(dataset_effect, "trained", trained)
    monkeypatch.setattr(dataset_effect, "compare_photos", compared)
    monkeypatch.setattr(dataset_studies, "_write_sheet", lambda path, sheet: sheets.append((path, sheet.shape)))
    given = SimpleNamespace(bare="bare", shards="dressed", lights="lights", output="sheet.png")
    settings = TrainingSettings(9, 32, 2, 4)
    assert dataset_studies._compare(given, ["a.jpg"], settings, tmp_path) == 0
    assert asked == {"plain": ("bare", "lights", settings, True), "varied": ("dressed", "lights", settings, False)}
    assert capsys.readouterr().out.splitlines() == [
        "| trained on | detail kept | spread of people, stops | light left | photos |",
        "|---|---|---|---|---|",
        "| plain | 0.500 | 0.250 | 0.75 | 3 |",
        "| varied | 0.600 | – | 0.10 | 3 |",
    ]
    # One photo, its albedos and its normals by both networks, in one row.
    ((path, (height, width, _)),) = sheets
    assert path == "sheet.png"
    assert width > 4 * height


@pytest.mark.parametrize("steps", [0, 7])
def test_speed_tells_of_every_size_its_samples_by_the_clock_and_by_its_own_time(monkeypatch, capsys, steps):
    def timed(heads, lights, size, rounds):
        return loader_speed.LoaderSpeed(size, size * rounds, 10.0, 20.0)

    monkeypatch.setattr(loader_speed, "loader_speed", timed)
    monkeypatch.setattr(loader_speed, "waiting_share", lambda heads, lights, size, steps: steps / 100)
    monkeypatch.setattr(dataset_studies, "check_heads_and_lights", lambda *_: 1)
    monkeypatch.setattr(dataset_studies, "check_head_sizes", lambda *_: None)
    monkeypatch.setattr(dataset_studies, "let_idle_threads_sleep", lambda: None)
    given = SimpleNamespace(shards="heads", lights="lights", size=None, rounds=3, steps=steps)
    assert dataset_studies._speed(given) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    share = " 7%" if steps else " "
    assert told == [
        "| size | samples | per second, one core | per second of its own time | steps wait for the loader |",
        "|---|---|---|---|---|",
        f"| 128 | 384 | 10.0 | 20.0 |{share} |",
        f"| 256 | 768 | 10.0 | 20.0 |{share} |",
    ]
