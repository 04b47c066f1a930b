"""The stability report: nothing is above its bound, and it would say so if something were."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from relight_core.evaluation import stability
from relight_core.evaluation.stability import BOUNDS, StabilityReport, run_stability
from relight_core.evaluation.stability_plot import plot_stability
from relight_core.imaging.photo import Photo
from relight_core.imaging.read import read_photo
from relight_core.lighting.environment import Environment
from relight_core.networks.precision import has_bf16
from relight_core.pipeline.quality import TIERS


def some_report(error):
    errors = np.zeros((2, len(BOUNDS)))
    errors[1, list(BOUNDS).index("full turn")] = error
    errors[0, 0] = np.nan
    return StabilityReport(("calm, even", "wild, sun"), tuple(BOUNDS), errors)


def test_the_shipped_networks_stay_within_every_bound(portrait):
    done = []
    report = run_stability(portrait, quick=True, report=lambda n, total: done.append((n, total)))
    assert report.failures == []
    assert report.errors.shape == (4, 10)
    made = dict(zip(report.checks, np.isfinite(report.errors).T, strict=True))
    assert made.pop("threads")[0]
    # Where there is no bf16, fp32 beside itself would pass whatever bf16 does.
    halves = [made.pop(f"{tier} in bf16") for tier in ("draft", "live", "final")]
    assert np.all(halves) if has_bf16("cpu") else not np.any(halves)
    assert all(column.all() for column in made.values())
    assert done[-1] == (4, 4)


class BrokenAtFinal:
    """In place of the editor: grey pictures, but for one value that final quality has in one precision."""

    def __init__(self, value, precision):
        self.value, self.precision = value, precision

    def estimated_light(self, tier):
        return Environment.from_radiance(np.ones((16, 32, 3), np.float32))

    def relight(self, light, edit):
        image = np.full((4, 4, 3), 0.5 * light.level, np.float32)
        if edit.quality == replace(TIERS["final"], precision=self.precision):
            image[0, 0, 0] = self.value
        return SimpleNamespace(image=image, channels={"composition": image})


@pytest.mark.parametrize(("precision", "has_bf16"), [("fp32", False), ("fp32", True), ("bf16", True)])
@pytest.mark.parametrize(("value", "check"), [(np.nan, "not finite"), (-1.0, "out of range")])
def test_pictures_of_every_tier_are_looked_at(value, check, precision, has_bf16, monkeypatch):
    """Shown, a pixel that is no number is a black one, and that is lost in the mean."""
    monkeypatch.setattr(stability, "has_bf16", lambda device: has_bf16)
    photo = SimpleNamespace(linear=np.full((4, 4, 3), 0.5, np.float32))
    for found, is_above in ((0.5, False), (value, True)):
        relighter = BrokenAtFinal(found, precision)
        errors = stability._errors(relighter, photo, relighter.estimated_light(None), TIERS["live"])
        assert (dict(zip(BOUNDS, errors, strict=True))[check] > BOUNDS[check]) == is_above


class Attacked(BrokenAtFinal):
    """Grey as bright as its light, but for one attack, under which it shows a pixel that the others have not."""

    def __init__(self, is_hit, value=0.0):
        self.is_hit, self.value, self.tolerances = is_hit, value, set()

    def relight(self, light, edit):
        self.tolerances.add(edit.tolerance)
        image = np.full((4, 4, 3), 0.5 * light.level, np.float32)
        if self.is_hit(edit, light):
            image[0, 0] = self.value
        return SimpleNamespace(image=image, channels={"composition": image})


ATTACKS = [
    (lambda edit, light: edit.yaw_deg == 393.0, 0.0, "full turn"),
    (lambda edit, light: edit.yaw_deg == 33.5, 0.0, "half a degree"),
    (lambda edit, light: light.level == 32.0, 15.9, "level law"),
    (lambda edit, light: (edit.specular, edit.shadow) == (2.0, 2.0), np.nan, "not finite"),
    (lambda edit, light: edit.yaw_deg == 0.0, 0.0, "own light"),
    (lambda edit, light: False, 0.0, None),
]


@pytest.mark.parametrize(("is_hit", "value", "check"), ATTACKS, ids=[str(check) for *_, check in ATTACKS])
def test_every_attack_is_made_and_told_by_its_own_check(is_hit, value, check):
    photo = SimpleNamespace(linear=np.full((4, 4, 3), 0.5, np.float32))
    relighter = Attacked(is_hit, value)
    environment = Environment.from_radiance(np.full((16, 32, 3), 7.0, np.float32))
    errors = dict(zip(BOUNDS, stability._errors(relighter, photo, environment, TIERS["live"]), strict=True))
    assert {name for name, error in errors.items() if error > BOUNDS[name]} == ({check} if check else set())
    assert relighter.tolerances == {0.0}


def test_portraits_are_under_and_over_exposed_grainy_grey_and_red():
    image = np.random.default_rng(0).uniform(0.01, 0.5, (6, 6, 3)).astype(np.float32)
    found = {name: photo.linear for name, photo in stability.hostile_portraits(Photo(image)).items()}
    assert all(linear.dtype == np.float32 for linear in found.values())
    assert np.isfinite(list(found.values())).all()
    assert 0 <= np.min(list(found.values())) <= np.max(list(found.values())) <= 1
    np.testing.assert_array_equal(found["as it is"], image)
    np.testing.assert_allclose(found["2 EV under"], image / 4, rtol=1e-6)
    np.testing.assert_allclose(found["4 EV over"], np.minimum(16 * image, 1), rtol=1e-6)
    assert 0.05 < np.std(found["grainy"] - image) < 0.15
    assert np.ptp(found["monochrome"], axis=2).max() == 0
    np.testing.assert_allclose(found["red only"], image * (1, 0, 0))


class OnThreads(BrokenAtFinal):
    """Grey pictures, of which one pixel tells how many threads there are."""

    def __init__(self, weights=None, device="cpu"):
        self.weights, self.portraits = weights, []

    def set_portrait(self, photo, boxes):
        self.portraits.append((photo, boxes))

    def relight(self, light, edit):
        image = np.full((4, 4, 3), 0.5 * light.level, np.float32)
        image[0, 0] *= 1 + torch.get_num_threads() / 10
        return SimpleNamespace(image=image, channels={"composition": image})


@pytest.mark.parametrize("quick", [False, True])
def test_every_portrait_is_attacked_by_every_light_with_the_weights_that_were_given(quick, monkeypatch):
    made, threads = [], torch.get_num_threads()
    monkeypatch.setattr(stability, "choose_faces", lambda photo: ["a face", "another"])
    monkeypatch.setattr(stability, "Relighter", lambda *given: made.append(OnThreads(*given)) or made[-1])
    report = run_stability(Photo(np.full((4, 4, 3), 0.25, np.float32)), quick=quick, weights="w.safetensors")
    portraits = [name.split(", ")[0] for name in report.cases]
    # Each with three relighters of its own where threads are compared, after the one that makes all else.
    compared = ["as it is"] if quick else list(dict.fromkeys(portraits))
    assert {relighter.weights for relighter in made} == {"w.safetensors"}
    assert len(made) == 1 + 3 * len(compared)
    shown = [photo.linear for photo, _ in made[0].portraits]
    assert len(shown) == len(set(portraits)) == (2 if quick else 6)
    assert all(boxes == ["a face"] for relighter in made for _, boxes in relighter.portraits)
    for number, relighter in enumerate(made[1:]):
        assert relighter.portraits[0][0].linear is shown[number // 3]
    assert len(report.cases) == (4 if quick else 48)
    column = report.errors[:, report.checks.index("threads")]
    told = [name for name, error in zip(report.cases, column, strict=True) if np.isfinite(error)]
    assert told == [f"{name}, noise" for name in compared]
    assert [failure.split(":")[0] for failure in report.failures if ": threads" in failure] == told
    assert torch.get_num_threads() == threads


def test_lights_are_suns_in_bad_places_lamps_of_one_colour_and_none():
    lights = stability.hostile_lights()
    for name, at in (("sun ahead", (28, 2)), ("sun at the seam", (20, 127)), ("sun at the pole", (0, 9))):
        assert lights[name][at].min() >= 1e6
        assert np.count_nonzero(lights[name]) == 3
    assert lights["blue lamp"].max(axis=(0, 1)).tolist() == pytest.approx([2e4, 1e5, 1e6])
    assert lights["black"].max() == 0
    assert np.ptp(lights["even"]) == 0


def test_an_error_above_its_bound_is_named():
    assert some_report(1e-9).failures == []
    (line,) = some_report(0.5).failures
    assert "wild, sun" in line
    assert "full turn" in line


def test_record_table_and_picture(tmp_path):
    report = some_report(0.5)
    record = report.as_record()
    assert record["cases"]["calm, even"]["not finite"] is None
    assert record["cases"]["wild, sun"]["full turn"] == 0.5
    assert report.as_markdown().count("\n") == 5
    nowhere = replace(report, errors=np.full_like(report.errors, np.nan))
    worst = next(line for line in nowhere.as_markdown().splitlines() if "worst" in line)
    assert worst.count("–") == 10
    plot_stability(report, tmp_path / "a.png")
    assert read_photo(tmp_path / "a.png").linear.std() > 0.05


@pytest.fixture
def drawn(monkeypatch):
    """Draws a report, and gives the axes of its heat map and of the scale beside it."""
    pytest.importorskip("matplotlib", reason="plots need the training extra")
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figures = []
    monkeypatch.setattr(FigureCanvasAgg, "print_png", lambda canvas, path: figures.append(canvas.figure))
    return lambda report: plot_stability(report, "a.png") or figures[-1].axes


def test_a_heat_map_is_green_below_a_bound_yellow_at_it_red_above_and_white_where_nothing_was_checked(drawn):
    checks = ("not finite", "full turn", "own light", "threads")
    # Bounds of 0, 0.001, 0.02 and 0.02.
    errors = np.array([[0.0, 1e-3, 2e-4, np.nan], [1e-9, 0.1, 0.02, 0.2]])
    axes, scale = drawn(StabilityReport(("calm", "wild"), checks, errors))
    (image,) = axes.images
    reds, greens, blues, shown = np.moveaxis(image.to_rgba(image.get_array()), -1, 0)
    colours = np.where(greens > reds, "green", np.where(reds - greens > 0.3, "red", "yellow"))
    colours[shown == 0] = "white"
    assert colours.tolist() == [["green", "yellow", "green", "white"], ["red", "red", "yellow", "red"]]
    assert (blues[colours == "yellow"] < 0.8).all()
    assert [label.get_text() for label in axes.get_xticklabels()] == list(checks)
    assert [label.get_text() for label in axes.get_yticklabels()] == ["calm", "wild"]
    texts = {text.get_position(): text.get_text() for text in axes.texts}
    assert (texts[1, 0], texts[3, 0], texts[1, 1], texts[2, 1]) == ("0.001", "–", "0.1", "0.02")
    marks = dict(zip(scale.get_yticks().round(6), (label.get_text() for label in scale.get_yticklabels()), strict=True))
    assert (marks[-1], marks[0], marks[1]) == ("0.1", "1", "10")


def test_a_table_has_the_bounds_the_worst_of_every_check_and_every_case():
    checks = ("full turn", "own light")
    report = StabilityReport(("calm", "wild"), checks, np.array([[np.nan, 0.01], [0.5, 0.005]]))
    assert report.as_markdown().splitlines() == [
        "| | full turn | own light |",
        "|---|---|---|",
        "| bound | 0.001 | 0.02 |",
        "| **worst** | 0.5 | 0.01 |",
        "| calm | – | 0.01 |",
        "| wild | 0.5 | 0.005 |",
    ]
