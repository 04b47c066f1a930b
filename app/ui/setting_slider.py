"""Sliders whose ends and resting value are those of the setting itself."""

from __future__ import annotations

from collections.abc import Mapping

from app.ui.widgets import Slider


def setting_slider(
    ranges: Mapping[str, tuple[float, float]], at_rest: object, field: str, label: str, form: str, words: str
) -> Slider:
    """A slider over all that a field may be, which a double click brings back to the field's default.

    Args:
        ranges: the least and the largest value of each field.
        at_rest: the record with all fields at their defaults.
        label, form, words: as `Slider` has them.
    """
    return Slider(label, *ranges[field], getattr(at_rest, field), form, words)
