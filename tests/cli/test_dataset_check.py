"""`relight dataset check`: the lights that it hands over are of the size that heads are baked for."""

from synthetic_heads import write_lights

from app.cli.main import main
from relight_core.dataset import recipe
from relight_core.dataset.baking import check


def test_heads_are_compared_under_lights_of_the_networks_size(tmp_path, monkeypatch, capfd):
    write_lights(tmp_path / "lights.npz", 8)
    (tmp_path / "model.npz").touch()
    asked = {}

    def checked(casting, seeds, lights):
        asked.update(seeds=seeds, lights=lights)
        yield check.Difference(seeds[0], 0, 0.01, 0.03, 0.02)
        yield check.Difference(seeds[1], 2, 0.03, 0.05, 0.0)

    monkeypatch.setattr(recipe, "load_casting", lambda *words: None)
    monkeypatch.setattr(check, "check_heads", checked)
    words = ["--heads", tmp_path / "model.npz", "--lights", tmp_path / "lights.npz", "--lights-per-head", 3]
    assert main(["dataset", "check", *(str(word) for word in words), "--count", "2"]) == 0
    assert asked["seeds"] == range(1_000_000, 1_000_002)
    assert asked["lights"].shape == (3, 16, 32, 3)
    rows = capfd.readouterr().out.splitlines()[2:]
    assert rows == [
        "| 1000000 | 0 | 0.0100 | 0.0300 | 0.0200 |",
        "| 1000001 | 2 | 0.0300 | 0.0500 | 0.0000 |",
        "| all | | 0.0224 | 0.0412 | 0.0141 |",
    ]
