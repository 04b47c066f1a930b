"""An editing session and short visits of many lights, replayed: what the plan saves, and what it costs in accuracy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from relight_core.evaluation.counted import counted
from relight_core.evaluation.stride import stride_around
from relight_core.evaluation.tables import figure_text, markdown_table
from relight_core.imaging.photo import Photo
from relight_core.imaging.view_transform import apply_view
from relight_core.lighting.environment import Environment
from relight_core.pipeline.cache import computed_ms
from relight_core.pipeline.edit import EFFECTS, Edit
from relight_core.pipeline.relighter import Relighter
from relight_core.pipeline.results.relit import Relit

_EVERYTHING = frozenset(EFFECTS) - {"background"}
_SLIDER_STOPS = 10
_VISITED_STOPS = 2
_BRIGHTER = 1.7


@dataclass
class RuleRecord:
    """What one reason for not computing an effect did.

    Attributes:
        times: updates in which it held.
        saved_ms: what the effect took when it was last computed, summed over those.
        bound: the largest it stated, of displayed values in [0, 1]; None where the tier decided, not a rule.
        compared: pictures made with it that were compared with those made without any rule.
        largest_error: of those pictures.
    """

    times: int = 0
    saved_ms: float = 0.0
    bound: float | None = None
    compared: int = 0
    largest_error: float = 0.0


@dataclass
class Savings:
    """What a session's updates ran and left out.

    Attributes:
        updates: pictures made.
        runs, avoided: stage runs, and those that were reused or skipped.
        ms, ms_of_everything: what the updates took, and what they would have if every stage had run every
            time, by what each took when it last ran.
        largest_error: of a displayed value in [0, 1], against pictures made with no rule in force.
        largest_bound: that the plan gave for any of them.
        compared: pictures that were compared.
    """

    updates: int = 0
    runs: int = 0
    avoided: int = 0
    ms: float = 0.0
    ms_of_everything: float = 0.0
    largest_error: float = 0.0
    largest_bound: float = 0.0
    compared: int = 0
    broken: list[str] = field(default_factory=list)
    rules: dict[tuple[str, str, str], RuleRecord] = field(default_factory=dict)

    def note_rules(self, relit: Relit, error: float | None) -> None:
        """Count every effect that was not computed; `error` is the picture's where it was compared."""
        for effect in relit.plan:
            if effect.state == "computed":
                continue
            why = effect.why.split(":")[0]
            rule = self.rules.setdefault((effect.name, effect.state, why), RuleRecord())
            rule.times += 1
            rule.saved_ms += effect.saved_ms or 0.0
            if effect.bound is not None:
                rule.bound = max(rule.bound or 0.0, effect.bound)
            if error is not None:
                rule.compared += 1
                rule.largest_error = max(rule.largest_error, error)

    def as_record(self) -> dict:
        """JSON-ready."""
        return {
            "updates": self.updates,
            "stage_runs": self.runs,
            "avoided": self.avoided,
            "share_avoided": round(self.avoided / max(self.runs, 1), 4),
            "ms": round(self.ms, 1),
            "ms_of_everything": round(self.ms_of_everything, 1),
            "share_of_time": round(self.ms / max(self.ms_of_everything, 1e-9), 4),
            "largest_error": round(self.largest_error, 6),
            "largest_bound": round(self.largest_bound, 6),
            "compared": self.compared,
            "broken": self.broken,
            "rules": [
                {"effect": effect, "state": state, "why": why, **_rounded(asdict(rule))}
                for (effect, state, why), rule in sorted(self.rules.items())
            ],
        }


def recorded_session(lights: Sequence[Environment], turns: int) -> list[tuple[Environment, Edit]]:
    """Under each light in turn: look, turn it a full circle, drag both sliders there and back, let go, look.

    While the hand moves, only the picture is looked at, at live quality on the surface of final; at rest every
    channel, at final quality, as the editor asks for them.

    Args:
        turns: stops of the full circle.
    """
    moving, steps = Edit(quality="live", channels=(), surface_of="final"), []
    for light in lights:
        steps.append((light, Edit(quality="final")))
        steps += [(light, replace(moving, yaw_deg=360.0 * stop / turns)) for stop in range(1, turns + 1)]
        for slider in ("shadow", "specular"):
            way = np.concatenate([np.linspace(1, 2, _SLIDER_STOPS), np.linspace(2, 1, _SLIDER_STOPS)])
            steps += [(light, replace(moving, **{slider: float(gain)})) for gain in way]
        steps.append((light, Edit(quality="final")))
    return steps


def visits(lights: Sequence[Environment], turns: int) -> list[tuple[Environment, Edit]]:
    """Each of many lights looked at, turned to two of the circle's stops, both sliders moved, and made brighter.

    The stops differ from light to light, so that together they cover the circle. At the end all light goes out.

    Args:
        turns: stops of the full circle.
    """
    moving, steps = Edit(quality="live", channels=(), surface_of="final"), []
    stride = stride_around(turns)
    for number, light in enumerate(lights):
        steps.append((light, Edit(quality="final")))
        stops = [(_VISITED_STOPS * number + visit) * stride % turns for visit in range(_VISITED_STOPS)]
        steps += [(light, replace(moving, yaw_deg=360.0 * stop / turns)) for stop in stops]
        turned = steps[-1][1]
        steps += [(light, replace(turned, shadow=1.6)), (light, replace(turned, specular=0.3))]
        steps.append((Environment.from_radiance(light.shape * (_BRIGHTER * light.level), light.name), turned))
    return [*steps, (Environment.from_radiance(np.zeros((16, 32, 3), np.float32), "darkness"), moving)]


def replay(
    relighter: Relighter,
    thorough: Relighter | None,
    photo: Photo,
    session: Sequence[tuple[Environment, Edit]],
    savings: Savings,
    *,
    compare_every: int = 10,
    report: Callable[[], None] = lambda: None,
) -> None:
    """Replay a session on a photo and add to the savings.

    Args:
        thorough: a second Relighter that makes the pictures to compare with, each with all effects forced
            on; None compares none.
        compare_every: of pictures for which the plan promises no change at all; those for which it gives
            a bound are always compared.
    """
    for one in filter(None, (relighter, thorough)):
        one.set_portrait(photo)
    # What is kept of the lights of a session before, on the same photo, is not this one's saving.
    relighter.forget_lights()
    seen: dict[str, float] = {}
    for number, (light, edit) in enumerate(session):
        relit = relighter.relight(light, edit)
        seen |= {name: stage.ms for name, stage in relit.stages.items() if stage.state == "computed"}
        savings.updates += 1
        savings.runs += len(seen)
        savings.avoided += len(seen) - sum(stage.state == "computed" for stage in relit.stages.values())
        savings.ms += computed_ms(relit.stages)
        savings.ms_of_everything += sum(seen.values())
        bound = max((effect.bound or 0.0 for effect in relit.plan), default=0.0)
        compared = thorough is not None and (bound > 0 or number % compare_every == 0)
        savings.note_rules(relit, _compare(thorough, relit, bound, light, edit, savings) if compared else None)
        report()


def _compare(
    thorough: Relighter, relit: Relit, bound: float, light: Environment, edit: Edit, savings: Savings
) -> float:
    thorough.forget_lights()
    reference = thorough.relight(light, replace(edit, channels=None, forced_on=_EVERYTHING))
    error = float(np.abs(apply_view(relit.image) - apply_view(reference.image)).max())
    savings.compared += 1
    savings.largest_error = max(savings.largest_error, error)
    savings.largest_bound = max(savings.largest_bound, bound)
    if error > bound + 1e-4:
        savings.broken.append(f"{light.name} at {edit.yaw_deg:g} degrees: {error:.5f}, not {bound:.5f}")
    return error


def as_markdown(savings: Savings) -> str:
    """The figures in words."""
    share, time = savings.avoided / max(savings.runs, 1), savings.ms / max(savings.ms_of_everything, 1e-9)
    lines = [
        f"{counted(savings.updates, 'update')}: {100 * share:.1f} % of {counted(savings.runs, 'stage run')} avoided;",
        f"{savings.ms / 1e3:.1f} s, against {savings.ms_of_everything / 1e3:.1f} s if every stage ran every time "
        f"({100 * time:.1f} %);",
        f"largest error {255 * savings.largest_error:.2f} / 255 over {counted(savings.compared, 'picture')} compared, "
        f"largest bound given {255 * savings.largest_bound:.2f} / 255.",
    ]
    lines += [f"OUT OF BOUNDS: {line}" for line in savings.broken]
    titles = ("effect", "", "because", "times", "saved, s", "bound / 255", "compared", "largest error / 255")
    rows = []
    for key, rule in sorted(savings.rules.items()):
        bound = None if rule.bound is None else 255 * rule.bound
        cells = (f"{rule.times}", f"{rule.saved_ms / 1e3:.2f}", figure_text(bound, ".2f"), f"{rule.compared}")
        rows.append([*key, *cells, f"{255 * rule.largest_error:.2f}"])
    return "\n".join([*lines, "", *markdown_table(titles, rows)])


def _rounded(record: dict) -> dict:
    return {name: round(value, 6) if isinstance(value, float) else value for name, value in record.items()}
