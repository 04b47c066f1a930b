"""An evaluation as an object for programs and as a page of Markdown for people."""

from __future__ import annotations

import math
from collections.abc import Mapping

from relight_core.evaluation.counted import counted
from relight_core.evaluation.evaluate import Evaluation
from relight_core.evaluation.metrics import Interval
from relight_core.evaluation.tables import markdown_table
from relight_core.pipeline.quality import quality_of

PAPER_FULL = {
    "relit.rmse": 0.0281,
    "relit.psnr": 31.8,
    "relit.ssim": 0.914,
    "albedo.rmse": 0.0271,
    "normal.rmse": 0.132,
    "specular.rmse": 0.00575,
    "shadow.rmse": 0.00416,
    "light.wlog_l2": 0.0274,
}
"""Table 2 of the paper, row "Full"."""

_TITLES = {
    "relit.rmse": "relit RMSE (sRGB)",
    "relit.psnr": "relit PSNR (dB)",
    "relit.ssim": "relit SSIM",
    "relit.rmse_aligned": "relit RMSE, one exposure per picture",
    "relit.psnr_aligned": "relit PSNR (dB), one exposure per picture",
    "relit.ssim_aligned": "relit SSIM, one exposure per picture",
    "relit.rmse_as_lit": "relit RMSE, not metered",
    "relit.rmse_of_unchanged_photo": "RMSE of the photo left as it is",
    "albedo.rmse": "albedo RMSE (sRGB)",
    "albedo.rmse_aligned": "albedo RMSE, one exposure per picture",
    "normal.rmse": "normal RMSE ([-1, 1])",
    "normal.angle_deg": "normal angle (degrees)",
    "specular.rmse": "specular RMSE (linear)",
    "specular.relative": "specular RMSE over its own RMS",
    "shadow.rmse": "shadow RMSE (linear)",
    "shadow.relative": "shadow RMSE over its own RMS",
    "light.wlog_l2": "light wlog-L2",
    "light.wlog_l2_fitted": "light wlog-L2, fitted to the photo",
}
_KEYS = {
    "panoramas": None,
    "face": "face",
    "lamps": "lamps",
    "true surface, panoramas": "true_surface",
    "true surface, lamps": "true_surface_lamps",
}


def as_record(evaluation: Evaluation, weights: str) -> dict:
    """One JSON-ready object: means by channel and measure, their 95 % intervals, and what was measured.

    The top level holds the whole way over all of the head under panoramas; "face", "lamps", "true_surface"
    and "true_surface_lamps" hold the other groups alike (see `Evaluation.figures`).
    """
    record: dict = {}
    for group, key in _KEYS.items():
        if group not in evaluation.figures:
            continue
        place = record if key is None else record.setdefault(key, {"samples": evaluation.samples[group]})
        place.update(figures_record(evaluation.figures[group]))
    settings = evaluation.settings
    return record | {
        "samples": evaluation.samples["panoramas"],
        "weights": weights,
        "split": settings.split,
        "heads": evaluation.heads,
        "lights": evaluation.lights,
        "photos": settings.photos,
        "quality": quality_of(settings.tier),
        "size": evaluation.size,
        "network_size": settings.tier.network_size,
        "seconds": round(evaluation.seconds, 1),
    }


def as_markdown(evaluation: Evaluation, weights: str) -> str:
    """Tables: ours beside the paper's "Full", then every group of pictures."""
    settings = evaluation.settings
    lines = [
        "# Evaluation",
        "",
        f"{weights}; {settings.split} split: {counted(evaluation.heads, 'head')}, "
        f"{counted(evaluation.lights, 'panorama')}, {counted(evaluation.samples['panoramas'], 'relighting')} "
        f"at {evaluation.size} x {evaluation.size} pixels "
        f"({quality_of(settings.tier)}, networks at {settings.tier.network_size}), {settings.photos} photos, "
        f"over all of the head. {intervals_in_words(evaluation.heads)}",
        "",
    ]
    whole = evaluation.figures["panoramas"]
    beside = [(_TITLES[name], interval_text(whole[name]), f"{value:g}") for name, value in PAPER_FULL.items()]
    lines += [*markdown_table(("", "ours", "paper, Table 2, Full"), beside), "", _NOTE, "", "## In detail", ""]
    groups = [group for group in _KEYS if group in evaluation.figures]
    cells = {
        title: [interval_text(evaluation.figures[group].get(name)) for group in groups]
        for name, title in _TITLES.items()
    }
    titles = ["", *(f"{group} ({evaluation.samples[group]})" for group in groups)]
    lines += markdown_table(titles, [[title, *figures] for title, figures in cells.items() if any(figures)])
    return "\n".join(lines) + "\n"


_NOTE = """The paper's heads, skins and lights are others, so its figures tell the order of size, not a rank.
Relit pictures are compared as a metered camera would show the true one; "not metered" leaves pictures dark
where the light is dim. Specular and shadow are linear, for a light of mean luminance 1. "face" counts the
paper's eight regions only; "lamps" are single small lamps at 50 to 70 degrees from the camera's axis; "true
surface" starts from true albedo, normals and relief, and so shows the relighting networks alone."""


def intervals_in_words(heads: int) -> str:
    """A sentence about what a page's figures have in brackets."""
    return "One head alone gives no intervals." if heads == 1 else "In brackets: 95 % intervals over heads."


def figures_record(figures: Mapping[str, Interval]) -> dict:
    """Means by channel and measure, and their "intervals" alike."""
    intervals = {name: [known(interval.low), known(interval.high)] for name, interval in figures.items()}
    means = {name: interval.mean for name, interval in figures.items()}
    return _nested(means) | {"intervals": _nested(intervals)}


def _nested(flat: dict) -> dict:
    """{"a.b": 1} as {"a": {"b": 1}}."""
    nested: dict = {}
    for name, value in flat.items():
        channel, measure = name.split(".")
        nested.setdefault(channel, {})[measure] = value
    return nested


def known(value: float) -> float | None:
    """The value, None for NaN: JSON has none."""
    return None if math.isnan(value) else value


def interval_text(interval: Interval | None) -> str:
    """A mean with its interval in brackets; nothing for None."""
    if interval is None:
        return ""
    digits = 3 if abs(interval.mean) >= 1 else 4 if abs(interval.mean) >= 0.05 else 5
    text = f"{interval.mean:.{digits}f}"
    return text if math.isnan(interval.low) else f"{text} ({interval.low:.{digits}f} to {interval.high:.{digits}f})"
