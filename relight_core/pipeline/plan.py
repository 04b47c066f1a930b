"""The plan: what this light, this portrait and this edit call for, decided before anything runs.

A rule leaves something out only where it can say by how much the displayed picture could change. Most say
"not at all": light that is black, or at a strength of 0, needs no shadow, sliders at rest move nothing, what
nobody looks at is not made.

One rule allows a change: a light that is nearly one that was computed before gives that one's picture.
All that a surface sends to the camera is a sum over the light's texels with weights that no light changes
and that are not negative, whatever hides whatever. So if every texel of two lights agrees within a factor
exp(e), so does every pixel under them, and a displayed value, whose steepest slope over the logarithm of
radiance is 0.44 (the sRGB curve, at white), differs by no more than 0.44 e. The networks learned that
physics and don't obey it to the letter: they answer up to ten times as much (`AMPLIFICATION` keeps a margin),
and because they round to 8 bits, any difference at all may move a pixel by up to `ROUNDING`. That is more
than the default tolerance: by default only the very same light serves, as when a sky without a sun is turned.
With a tolerance of 2/255 a panorama at another exposure does, which is the same but for rounding.

Two rules that look natural are missing, because they would not hold. An even light needs shadow too:
shadow is what the surface hides from the light (paper, section 3.2), and an even light is hidden in every
fold. And the networks don't give the same shadow at half the resolution under soft light.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass

import numpy as np

from relight_core.lighting.lamps import Lamp
from relight_core.pipeline.cache import State
from relight_core.pipeline.edit import EFFECTS, LIGHT_CHANNELS, Edit, check_effects
from relight_core.pipeline.quality import Tier

STEEPEST_DISPLAY_SLOPE = 0.44
"""Largest derivative of the sRGB curve by the natural logarithm of radiance: 1.055 / 2.4, at white."""

AMPLIFICATION = 12.0
"""By how much more than physics the networks may answer a small change of the light. Measured: up to 10."""

ROUNDING = 1.6 / 255
"""How much the networks' own rounding may change a displayed value. Measured: up to 1.22 / 255."""

_DARKEST_TEXEL = 1e-5


@dataclass(frozen=True)
class Effect:
    """What the plan says about one effect.

    Attributes:
        state: computed now, reused from an earlier update, or skipped.
        why: the reason in words.
        bound: the largest change of a displayed value in [0, 1] against computing it for exactly this light; None
            where the user or the quality tier has decided, which no rule answers for.
        forced: the user's decision about it: on, off or none.
        saved_ms: what computing it took when it last ran on this machine; 0 where it or what else finds it is
            computed now, None where it never ran or what it takes is not known apart from what runs without it.
    """

    name: str
    state: State
    why: str
    bound: float | None = 0.0
    forced: bool | None = None
    saved_ms: float | None = None


@dataclass(frozen=True)
class Scene:
    """What the plan reads besides the edit.

    Attributes:
        tier: of the edit's quality.
        light: names the light whose results serve; see `KeptLights`.
        light_bound: how much displaying the results of that light instead of the true one may change.
        backdrop: names the panorama behind the person: a light and its turn.
        level: of the light.
        lamps: the light's small ones, turned as it is.
        mirrored: names the panorama that eyes mirror: a light and its turn.
        irises: how many are seen well enough to mirror it.
        in_foreign_shadow: on how many faces a shadow from outside falls.
    """

    tier: Tier
    light: Hashable
    light_bound: float
    backdrop: Hashable
    level: float
    lamps: tuple[Lamp, ...] = ()
    mirrored: Hashable = None
    irises: int = 0
    in_foreign_shadow: int = 0


@dataclass(frozen=True)
class Plan:
    """Decisions about every effect.

    Attributes:
        keys: by stage, under which key it keeps its result.
        shadow_network: the SS network says what is hidden from the light, not the relief alone.
    """

    effects: tuple[Effect, ...]
    keys: Mapping[str, Hashable]
    shadow_network: bool

    def effect(self, name: str) -> Effect:
        """What is said about one effect."""
        return next(effect for effect in self.effects if effect.name == name)

    def runs(self, name: str) -> bool:
        """Whether an effect is part of the picture."""
        return self.effect(name).state != "skipped"

    def gains(self, edit: Edit) -> Edit:
        """An edit with the sliders that act: those at rest where they are left out."""
        return edit if self.runs("sliders") else Edit()


@dataclass(frozen=True)
class _Verdict:
    needed: bool
    why: str
    bound: float | None = 0.0


_STAGE_OF = {
    "foreign_shadow": "delight",
    "flattening": "albedo",
    "source_light": "source_light",
    "relief": "relief",
    "shadow": "specular_shadow",
    "hard_shadow": "hard_shadow",
    "specular": "specular_shadow",
    "correction": "compose",
    "residual": "residual",
    "sliders": "sliders",
    "detail": "detail",
    "catchlights": "catchlights",
    "background": "background",
    "channels": "channels",
}
_PARTS_OF_STAGES = ("foreign_shadow", "sliders", "detail")  # which run without them too, and have no time of their own
_ANSWERS_THE_LIGHT = ("shadow", "hard_shadow", "specular", "correction", "sliders", "detail", "catchlights", "channels")


def make_plan(
    scene: Scene,
    edit: Edit,
    kept: Callable[[str, Hashable], bool] = lambda stage, key: False,
    typical_ms: Mapping[str, float] | None = None,
) -> Plan:
    """Decide about every effect.

    Args:
        kept: whether a stage's result for a key is still there.
        typical_ms: what each stage took when it last ran.

    Raises:
        InputError: the edit forces something that is no effect.
    """
    check_effects(edit.forced_on | edit.forced_off)
    verdicts = _verdicts(scene, edit)
    network = _asks_the_network(scene, edit)
    keys = _keys(scene, edit, {name for name, verdict in verdicts.items() if verdict.needed}, network)
    times = typical_ms or {}
    effects = tuple(_effect(name, verdicts, scene, edit, keys, kept, times) for name in EFFECTS)
    return Plan(effects, keys, network)


def plan_of_own_light(tier: Tier) -> Plan:
    """How a tier models the photo under the light it was taken under, whatever light and edit are asked for."""
    return make_plan(Scene(tier, light="own", light_bound=0.0, backdrop=None, level=1.0), Edit())


def light_change(before: np.ndarray, after: np.ndarray) -> float:
    """The largest |log| of the ratio of two lights' texels, each (16, 32, 3); radiance below 1e-5 counts as that."""
    floor = np.float32(_DARKEST_TEXEL)
    return float(np.abs(np.log(np.maximum(after, floor) / np.maximum(before, floor))).max())


def displayed_change(log_ratio: float) -> float:
    """By how much a displayed value may change where no texel of the light changed by more than exp(log_ratio)."""
    return ROUNDING + AMPLIFICATION * STEEPEST_DISPLAY_SLOPE * log_ratio if log_ratio > 0 else 0.0


def _verdicts(scene: Scene, edit: Edit) -> dict[str, _Verdict]:
    verdicts = {name: _forced(edit, name) or rule(scene, edit) for name, rule in _RULES.items()}
    verdicts["source_light"] = _forced(edit, "source_light") or _source_light(verdicts, edit)
    verdicts["relief"] = _forced(edit, "relief") or _relief(verdicts)
    readers = [name for name in ("flattening", "residual", "catchlights") if verdicts[name].needed]
    for name in ("source_light", "relief"):
        if edit.forced(name) is False and readers:
            why = f"turned off by you; {' and '.join(readers)} still use{'s' * (len(readers) == 1)} it"
            verdicts[name] = _Verdict(False, why, None)
    for name in ("flattening", "residual"):
        if edit.forced(name) is False and verdicts["source_light"].needed and edit.looks_at("source_light"):
            verdicts[name] = _Verdict(False, "turned off by you; the source light's level still uses it", None)
    verdicts["hard_shadow"] = _forced(edit, "hard_shadow") or _hard_shadow(verdicts, scene)
    return verdicts


def _forced(edit: Edit, name: str) -> _Verdict | None:
    wish = edit.forced(name)
    if wish is None:
        return None
    return _Verdict(True, "turned on by you") if wish else _Verdict(False, "turned off by you", None)


def _without_light(scene: Scene, edit: Edit) -> _Verdict | None:
    """Why nothing of the light is seen, in the picture or in a channel; None where something is."""
    if scene.level == 0:
        return _Verdict(False, "the light is black")
    if edit.strength == 0 and not any(map(edit.looks_at, LIGHT_CHANNELS)):
        return _Verdict(False, "at a strength of 0 all light is the photo's own")
    return None


def _foreign_shadow(scene: Scene, edit: Edit) -> _Verdict:
    if scene.in_foreign_shadow == 0:
        return _Verdict(False, "no shadow from outside falls on a face")
    return _Verdict(True, "a shadow from outside is taken off before the face is taken apart, once for a photo")


def _flattening(scene: Scene, edit: Edit) -> _Verdict:
    dark = _without_light(scene, edit)
    if dark and not (edit.looks_at("albedo") or edit.looks_at("source_light")):
        return dark
    return _Verdict(True, "skin that follows the photo's own light is cleared of it, once for a photo")


def _source_light(verdicts: Mapping[str, _Verdict], edit: Edit) -> _Verdict:
    if edit.looks_at("source_light"):
        return _Verdict(True, "it is looked at")
    if verdicts["residual"].needed:
        return _Verdict(True, "what the model misses of the photo is measured under it")
    if verdicts["flattening"].needed:
        return _Verdict(True, "flattening divides by its shading")
    if verdicts["catchlights"].needed:
        return _Verdict(True, "the eyes' own catchlights stay under it")
    return _Verdict(False, "nobody looks at it, and the picture does not depend on it")


def _occlusion(scene: Scene, edit: Edit) -> _Verdict:
    if dark := _without_light(scene, edit):
        return dark
    if _asks_the_network(scene, edit):
        return _Verdict(True, "what the surface hides from the light, seen by the network")
    return _Verdict(True, "what the relief hides from the light: no network at this quality", None)


def _asks_the_network(scene: Scene, edit: Edit) -> bool:
    return scene.tier.shadow_network or bool(edit.forced_on & {"shadow", "specular"})


def _correction(scene: Scene, edit: Edit) -> _Verdict:
    if dark := _without_light(scene, edit):
        return dark
    if not scene.tier.correction:
        return _Verdict(False, "not at this quality", None)
    return _Verdict(True, "the network corrects the sum of the channels")


def _residual(scene: Scene, edit: Edit) -> _Verdict:
    dark = _without_light(scene, edit)
    if dark and not edit.looks_at("source_light"):
        return dark
    return _Verdict(True, "what the model misses of the photo, measured once for a photo")


def _sliders(scene: Scene, edit: Edit) -> _Verdict:
    if edit.sliders == Edit().sliders:
        return _Verdict(False, "all sliders are where they change nothing")
    return _Verdict(True, "a slider is moved")


def _detail(scene: Scene, edit: Edit) -> _Verdict:
    return _Verdict(True, "the photo has more pixels than the networks see")


def _catchlights(scene: Scene, edit: Edit) -> _Verdict:
    if dark := _without_light(scene, edit):
        return dark
    if scene.irises == 0:
        return _Verdict(False, "no iris is seen in enough pixels to mirror anything")
    return _Verdict(True, "the eyes mirror this light, and no longer the photo's")


def _background(scene: Scene, edit: Edit) -> _Verdict:
    if edit.background == "keep":
        return _Verdict(False, "the photo's own background stays")
    return _Verdict(True, "another background is asked for")


def _channels(scene: Scene, edit: Edit) -> _Verdict:
    if edit.channels is not None and not edit.channels:
        return _Verdict(False, "nobody looks at them")
    return _Verdict(True, "they are looked at")


def _relief(verdicts: Mapping[str, _Verdict]) -> _Verdict:
    reading = ("flattening", "source_light", "residual", "shadow", "specular")
    readers = [name for name in reading if verdicts[name].needed]
    if not readers:
        return _Verdict(False, "nothing that is computed reads it")
    return _Verdict(True, "horizons of the face, once for a photo")


def _hard_shadow(verdicts: Mapping[str, _Verdict], scene: Scene) -> _Verdict:
    if not scene.lamps:
        return _Verdict(False, "no lamp of this light is small enough to cast an edge")
    if not (verdicts["shadow"].needed or verdicts["specular"].needed):
        return _Verdict(False, "there is neither shadow nor gloss to give an edge")
    if not verdicts["relief"].needed:
        return _Verdict(False, "the relief that would cast it is left out", None)
    count = len(scene.lamps)
    return _Verdict(True, f"{count} lamp{'s' * (count > 1)} so small that shadows have edges")


_RULES: dict[str, Callable[[Scene, Edit], _Verdict]] = {
    "foreign_shadow": _foreign_shadow,
    "flattening": _flattening,
    "shadow": _occlusion,
    "specular": _occlusion,
    "correction": _correction,
    "residual": _residual,
    "sliders": _sliders,
    "detail": _detail,
    "catchlights": _catchlights,
    "background": _background,
    "channels": _channels,
}


def _keys(scene: Scene, edit: Edit, needed: set[str], network: bool) -> dict[str, Hashable]:
    """What every stage reads, and nothing else, so that nothing else makes it run again."""
    shown = tuple(sorted(needed & {"shadow", "specular"}))
    surface = (scene.tier, "flattening" in needed)
    light = (surface, scene.light)
    occlusion = (light, bool(shown), network, "relief" in needed)
    edges = (occlusion, scene.lamps if "hard_shadow" in needed else None)
    compose = (edges, shown, "correction" in needed)
    gains = edit.sliders if "sliders" in needed else Edit().sliders
    image = (compose, "residual" in needed)
    change = (image, gains, "detail" in needed, scene.level)
    # Where no shadow is wanted, nothing is hidden from an eye either.
    mirrored = (scene.mirrored, scene.irises, "shadow" in needed) if "catchlights" in needed else None
    catchlights = (edges, mirrored)
    strength = (change, catchlights, edit.strength)
    backdrop = scene.backdrop if edit.background == "light" else None
    behind = (edit.background, backdrop) if "background" in needed else None
    return {
        "delight": scene.tier.surface_key,
        "surface": surface,
        "albedo": scene.tier.relief_key,
        "source_light": scene.tier.relief_key,
        "relief": scene.tier.relief_key,
        "irradiance": light,
        "specular_shadow": occlusion,
        "hard_shadow": edges,
        "compose": compose,
        "residual": (surface, network, "relief" in needed, "correction" in needed),
        "detail_fit": (image, "detail" in needed),
        "sliders": change,
        "detail": change,
        "catchlights": catchlights,
        "strength": strength,
        "panorama": backdrop,
        "background": (strength, behind),
        "channels": (change, edit.channels),
    }


def _effect(
    name: str,
    verdicts: Mapping[str, _Verdict],
    scene: Scene,
    edit: Edit,
    keys: Mapping[str, Hashable],
    kept: Callable[[str, Hashable], bool],
    times: Mapping[str, float],
) -> Effect:
    stage, forced, verdict = _STAGE_OF[name], edit.forced(name), verdicts[name]
    # One network finds both, so the time is told once, and saved only where neither is needed.
    is_told = name == "specular" or (name == "shadow" and verdicts["specular"].needed and not verdict.needed)
    saved_ms = 0.0 if is_told else times.get(stage)
    if not verdict.needed:
        known_ms = None if name in _PARTS_OF_STAGES else saved_ms
        return Effect(name, "skipped", verdict.why, verdict.bound, forced, known_ms)
    # Also what is computed now is computed for the light that serves.
    answers = name in _ANSWERS_THE_LIGHT or (name == "background" and edit.background == "match")
    of_light = scene.light_bound if answers else 0.0
    bound = None if verdict.bound is None else of_light
    if not kept(stage, keys[stage]):
        return Effect(name, "computed", verdict.why, bound, forced, 0.0)
    why = "nothing it reads has changed"
    if of_light > 0:
        why = f"the light is nearly one seen before: it could change no pixel by more than {100 * of_light:.2g} %"
    return Effect(name, "reused", why, bound, forced, saved_ms)
