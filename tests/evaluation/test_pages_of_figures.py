"""What stands in which row and column of the pages on held-out pictures, figure by figure."""

import numpy as np
import pytest

from relight_core.evaluation.ablation.table import as_markdown as ablation_page
from relight_core.evaluation.contest import Contest, Outcome
from relight_core.evaluation.contest_report import as_record as contest_record
from relight_core.evaluation.evaluate import Evaluation, Settings
from relight_core.evaluation.metrics import Interval
from relight_core.evaluation.peers.table import as_markdown as peers_page
from relight_core.evaluation.report import as_markdown, as_record
from relight_core.pipeline.quality import TIERS

ROWS = {
    "relit RMSE (sRGB)": "relit.rmse",
    "relit PSNR (dB)": "relit.psnr",
    "relit SSIM": "relit.ssim",
    "relit RMSE, one exposure per picture": "relit.rmse_aligned",
    "relit PSNR (dB), one exposure per picture": "relit.psnr_aligned",
    "relit SSIM, one exposure per picture": "relit.ssim_aligned",
    "relit RMSE, not metered": "relit.rmse_as_lit",
    "RMSE of the photo left as it is": "relit.rmse_of_unchanged_photo",
    "albedo RMSE (sRGB)": "albedo.rmse",
    "albedo RMSE, one exposure per picture": "albedo.rmse_aligned",
    "normal RMSE ([-1, 1])": "normal.rmse",
    "normal angle (degrees)": "normal.angle_deg",
    "specular RMSE (linear)": "specular.rmse",
    "specular RMSE over its own RMS": "specular.relative",
    "shadow RMSE (linear)": "shadow.rmse",
    "shadow RMSE over its own RMS": "shadow.relative",
    "light wlog-L2": "light.wlog_l2",
    "light wlog-L2, fitted to the photo": "light.wlog_l2_fitted",
}
GROUPS = ("panoramas", "face", "lamps", "true surface, panoramas", "true surface, lamps")
OF_DELIGHTING = ("albedo", "normal", "light")


def some_evaluation(groups=GROUPS):
    """Figures of which no two are alike: of the second row in the third group 2.03."""
    figures = {
        group: {
            name: Interval(row + column / 100, row, row + 0.5)
            for row, name in enumerate(ROWS.values(), 1)
            if not (group.startswith("true") and name.startswith(OF_DELIGHTING))
        }
        for column, group in enumerate(GROUPS, 1)
        if group in groups
    }
    samples = {group: 10 * column for column, group in enumerate(GROUPS, 1) if group in groups}
    settings = Settings("heads", "lights", "validation", photos="camera", tier=TIERS["live"])
    return Evaluation(figures, samples, 2, 7, 256, 1.5, settings)


def row_of(page, name):
    return [cell.strip() for cell in next(line for line in page if line.startswith(f"| {name} |")).split("|")[2:-1]]


def test_every_figure_of_an_evaluation_stands_in_its_own_row_and_column():
    page = as_markdown(some_evaluation(), "w").splitlines()
    assert page[2].startswith("w; validation split: 2 heads, 7 panoramas, 10 relightings at 256 x 256 pixels (live, ")
    assert ", camera photos, " in page[2]
    detail = page[page.index("## In detail") :]
    titles = ["panoramas (10)", "face (20)", "lamps (30)", "true surface, panoramas (40)", "true surface, lamps (50)"]
    assert detail[2] == "".join(f"| {title} " if title else "| " for title in ["", *titles]) + "|"
    for row, (title, name) in enumerate(ROWS.items(), 1):
        told = [f"{row}.0{column}0 ({row}.000 to {row}.500)" for column in (1, 2, 3, 4, 5)]
        if name.startswith(OF_DELIGHTING):
            told[3:] = ["", ""]
        assert row_of(detail, title) == told, title


def test_ours_stands_beside_the_paper_s_over_all_of_the_head_under_panoramas():
    page = as_markdown(some_evaluation(), "w").splitlines()
    assert "| | ours | paper, Table 2, Full |" in page
    paper = {
        "relit RMSE (sRGB)": ("1.010 (1.000 to 1.500)", "0.0281"),
        "relit PSNR (dB)": ("2.010 (2.000 to 2.500)", "31.8"),
        "relit SSIM": ("3.010 (3.000 to 3.500)", "0.914"),
        "albedo RMSE (sRGB)": ("9.010 (9.000 to 9.500)", "0.0271"),
        "normal RMSE ([-1, 1])": ("11.010 (11.000 to 11.500)", "0.132"),
        "specular RMSE (linear)": ("13.010 (13.000 to 13.500)", "0.00575"),
        "shadow RMSE (linear)": ("15.010 (15.000 to 15.500)", "0.00416"),
        "light wlog-L2": ("17.010 (17.000 to 17.500)", "0.0274"),
    }
    for title, cells in paper.items():
        assert tuple(row_of(page, title)) == cells, title


@pytest.mark.parametrize("groups", [GROUPS, ("panoramas", "lamps", "true surface, lamps")])
def test_a_record_has_every_group_under_its_own_key(groups):
    record = as_record(some_evaluation(groups), "w.safetensors")
    keys = ("face", "lamps", "true_surface", "true_surface_lamps")
    places = {
        group: record if key is None else record.get(key) for group, key in zip(GROUPS, (None, *keys), strict=True)
    }
    for column, (group, place) in enumerate(places.items(), 1):
        assert (place is not None) == (group in groups), group
        if place is not None:
            assert place["samples"] == 10 * column
            assert place["relit"]["psnr"] == pytest.approx(2 + column / 100)
            assert place["intervals"]["shadow"]["relative"] == [16, 16.5]
    told = {name: record[name] for name in ("weights", "split", "heads", "lights", "photos", "quality", "size")}
    assert told == {
        "weights": "w.safetensors",
        "split": "validation",
        "heads": 2,
        "lights": 7,
        "photos": "camera",
        "quality": "live",
        "size": 256,
    }
    assert (record["network_size"], record["seconds"]) == (128, 1.5)


def some_outcome(**changed):
    """A contender with every figure, of which no two are alike, and what is given beside it."""
    names = [*ROWS.values(), "borrowed.wlog_l2", "borrowed.rmse", "relit.psnr_gain"]
    whole = {name: Interval(float(number), np.nan, np.nan) for number, name in enumerate(names, 1)}
    return Outcome(
        {"whole": whole, **changed}, 12, 3, np.zeros((1, 1, 3)), Contest("heads", "lights", 64, "validation")
    )


BARE = {"Shu et al. 2017": {"relit.rmse": Interval(0.25, np.nan, np.nan)}}


def test_an_ablation_has_relit_pictures_above_channels_and_the_paper_s_own_below():
    page = ablation_page(some_outcome(**BARE), "Trained for no time.").splitlines()
    assert page[2].startswith("validation split: 3 heads, 12 relightings under panoramas at 64 x 64 pixels")
    assert "Trained for no time." in page[2]
    relit = "| | relit RMSE | PSNR | SSIM | RMSE, one exposure | PSNR, one exposure | PSNR over the row above |"
    at = page.index(relit)
    assert page[at + 2] == "| whole | 1.000 | 2.000 | 3.000 | 4.000 | 5.000 | 21.000 |"
    assert page[at + 3] == "| Shu et al. 2017 | 0.2500 | – | – | – | – | – |"
    channels = (
        "| albedo RMSE | albedo, one exposure | normal RMSE | specular RMSE | shadow RMSE | shadow over its RMS |"
    )
    at = page.index(f"| {channels} light wlog-L2 |")
    assert page[at + 2] == "| whole | 9.000 | 10.000 | 11.000 | 13.000 | 15.000 | 16.000 | 17.000 |"
    assert page[at + 3] == "", "who has none of these has no row"
    at = page.index("| | relit RMSE | PSNR | SSIM | albedo | normal | specular | shadow | light wlog-L2 |")
    assert page[at + 2] == "| DL-RL | 0.0511 | 26.4 | 0.87 | 0.0342 | 0.132 | – | – | 0.0364 |"
    assert page[at + 5] == "| Full | 0.0281 | 31.8 | 0.914 | 0.0271 | 0.132 | 0.00575 | 0.00416 | 0.0274 |"


def test_a_comparison_says_who_was_given_the_truth_and_what_a_borrowed_light_brings():
    page = peers_page(some_outcome(**BARE), "Trained for no time.").splitlines()
    at = page.index("| | relit RMSE | PSNR | SSIM | RMSE, one exposure | PSNR, one exposure |")
    assert page[at + 2] == "| whole | 1.000 | 2.000 | 3.000 | 4.000 | 5.000 |"
    assert page[at + 3] == "| Shu et al. 2017 (given the truth) | 0.2500 | – | – | – | – |"
    at = page.index("| | estimated light, wlog-L2 | relit RMSE with it | with the true light |")
    assert page[at + 2] == "| whole | 19.000 | 20.000 | 1.000 |"
    at = page.index("| | RMSE | PSNR | SSIM |")
    assert page[at + 2] == "| Shih et al. 2014 | 0.0389 | 29.4 | 0.877 |"
    assert page[at + 6] == "| Full | 0.0281 | 31.8 | 0.914 |"
    record = contest_record(some_outcome(**BARE), "Trained for no time.")
    assert (record["split"], record["size"], record["samples"], record["heads"]) == ("validation", 64, 12, 3)
    assert record["rows"]["whole"]["relit"]["psnr_gain"] == 21
