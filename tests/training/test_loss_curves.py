"""What is drawn of a log of losses."""

import json

import numpy as np
import pytest

from relight_core.training.curves import draw_curves


def test_every_loss_has_a_panel_of_its_own_over_the_steps(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib", reason="curves need the training extra")
    from matplotlib.figure import Figure

    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, path, **_: figures.append(figure) or path.touch())
    log = [
        {"step": 50, "elapsed": 0.25, "relit": 0.5, "shadow_fraction": 0.04},
        {"step": 100, "elapsed": 0.5, "relit": 0.25},
        {"step": 150, "elapsed": 0.75, "relit": 0.125, "shadow_fraction": 0.01},
    ]
    (tmp_path / "w.log.json").write_text(json.dumps(log))
    draw_curves(tmp_path / "w.log.json", tmp_path / "curves.png")
    drawn = {axes.get_title(loc="left"): axes for axes in figures[0].axes}
    assert list(drawn) == ["relit", "shadow fraction"]
    for title, values in (("relit", [0.5, 0.25, 0.125]), ("shadow fraction", [0.04, np.nan, 0.01])):
        (line,) = drawn[title].lines
        np.testing.assert_array_equal(line.get_xdata(), [50, 100, 150])
        np.testing.assert_array_equal(line.get_ydata(), values)
        assert drawn[title].get_yscale() == "log"
    assert figures[0].axes[-1].get_xlabel() == "step"
