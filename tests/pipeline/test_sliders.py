"""Softer shadows and tinted shine: what they change, and what they leave alone."""

from functools import partial
from types import SimpleNamespace

import pytest
import torch

from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_colour import grey
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_light.hints import Effects, explicit_sum
from relight_core.pipeline.per_light.sliders import move_sliders, soften_shadow, specular_gain
from relight_core.pipeline.stages import Composed

SIZE = 64


def scene(relief=None, person=None):
    """A card of even albedo, its right half in shadow, without gloss."""
    shape = (1, 1, SIZE, SIZE)
    surface = SimpleNamespace(
        albedo=torch.full((1, 3, SIZE, SIZE), 0.5),
        relief=torch.zeros(shape) if relief is None else relief,
        person=torch.ones(shape) if person is None else person,
    )
    reflected = torch.cat([torch.ones(1, 3, SIZE, SIZE), torch.zeros(1, 3, SIZE, SIZE)], 1)
    shadow = torch.zeros(shape)
    shadow[..., SIZE // 2 :] = 0.5
    return surface, reflected, Effects(torch.zeros(shape), shadow)


def step(relief_height):
    relief = torch.zeros(1, 1, SIZE, SIZE)
    relief[..., SIZE // 2 :] = relief_height
    return relief


def test_at_rest_nothing_is_touched():
    surface, reflected, effects = scene()
    assert soften_shadow(effects, surface, reflected, 0.0) is effects
    assert specular_gain(1.3, 0.0) == 1.3
    assert Edit().sliders == (1.0, 1.0, 0.0, 0.0)


def test_a_tinted_gain_lies_where_the_channel_does():
    assert specular_gain(1.0, 0.5, "meta").device.type == "meta"


def test_a_shadows_edge_gets_wider_and_wider():
    surface, reflected, effects = scene()
    steepest = []
    for softness in (0.0, 0.25, 0.5, 1.0):
        shadow = soften_shadow(effects, surface, reflected, softness).shadow
        assert shadow.min() >= 0
        assert shadow.max() <= 0.5 + 1e-5
        steepest.append(float(shadow.diff(dim=-1).abs().max()))
    assert all(later < 0.8 * earlier for earlier, later in zip(steepest, steepest[1:], strict=False))
    assert shadow[0, 0, SIZE // 2, 0] < 0.01
    assert shadow[0, 0, SIZE // 2, -1] > 0.49


def test_no_step_of_the_slider_jumps_or_does_nothing():
    surface, reflected, effects = scene()
    surface.person[..., :5] = 0
    before = effects.shadow
    for hundredths in range(1, 60):
        after = soften_shadow(effects, surface, reflected, hundredths / 100).shadow
        assert 0 < float((after - before).abs().max()) < 0.02
        before = after


def test_the_amount_of_shadow_stays():
    surface, reflected, effects = scene()
    softened = soften_shadow(effects, surface, reflected, 0.7).shadow
    assert float(softened.sum()) == pytest.approx(float(effects.shadow.sum()), rel=0.02)


def test_no_shadow_creeps_over_a_step_in_the_surface():
    for surface, reflected, effects in (scene(relief=step(0.5)), scene(person=1 - step(1.0))):
        softened = soften_shadow(effects, surface, reflected, 1.0).shadow
        assert (softened - effects.shadow).abs().max() < 0.03


def test_skin_keeps_its_pattern_under_a_softened_shadow():
    surface, reflected, effects = scene()
    surface.albedo = surface.albedo * (0.5 + torch.rand(1, 1, SIZE, SIZE))
    effects.shadow = 0.6 * grey(surface.albedo)
    softened = soften_shadow(effects, surface, reflected, 1.0)
    torch.testing.assert_close(softened.shadow, effects.shadow, rtol=1e-3, atol=1e-4)


def test_gloss_that_was_hidden_stays_hidden():
    surface, reflected, effects = scene()
    reflected[:, 3:] = 0.3
    effects = Effects(torch.full_like(effects.shadow, 0.1), effects.shadow + 0.2)
    before, after = (
        explicit_sum(surface.albedo, reflected, found, 1.0, 1.0)
        for found in (effects, soften_shadow(effects, surface, reflected, 0.5))
    )
    assert float(after.mean()) == pytest.approx(float(before.mean()), rel=0.02)
    assert (after >= 0).all()


@pytest.mark.parametrize("tint", [-1.0, -0.4, 0.4, 1.0])
def test_a_tint_keeps_the_brightness_and_warms_or_cools(tint):
    gain = specular_gain(1.5, tint).flatten()
    red, green, blue = (float(part) for part in gain)
    assert 0.2126 * red + 0.7152 * green + 0.0722 * blue == pytest.approx(1.5, rel=1e-3)
    assert (red > blue) == (tint > 0)
    assert (gain > 0).all()


def test_numbers_that_are_none_stay_out_of_the_picture():
    surface, reflected, effects = scene()
    effects.shadow[0, 0, 3, 3] = float("nan")
    assert torch.isfinite(soften_shadow(effects, surface, reflected, 0.5).shadow).all()


@pytest.mark.parametrize("label", ["nose", "skin"])
def test_no_nostril_shines_where_its_shadow_is_lifted(label):
    """One whose normals face the lamp, in a nose that doesn't: other small shadows are lifted as they are."""
    surface, reflected, effects = scene()
    surface.parsing, surface.eye_sockets = torch.zeros(1, len(INDEX), SIZE, SIZE), torch.zeros(SIZE, SIZE)
    surface.parsing[:, INDEX[label]] = 1
    reflected[:, :3, 30:32, 16:18] = 6
    effects.shadow[..., 30:32, 16:18] = 2.9
    plain = explicit_sum(surface.albedo, reflected, effects)
    change = move_sliders(Composed(plain, plain), surface, reflected, effects, 1.0, 0.0)
    lifted = change.lifted[..., 30:32, 16:18]
    assert float(lifted.max()) < 1e-3 if label == "nose" else float(lifted.min()) > 2.8
    assert float(change.lifted[..., SIZE // 2 :].min()) == pytest.approx(0.5)
    assert float(change.added.max()) < 1e-6


BLUE = 0.0722
"""Its share of luminance."""


def given_back_to_an_eye(light, hidden, odds, socket=1.0):
    """What no shadow gives back to a small eye under a light (3,), `hidden` of it by luminance; skin gets red alone."""
    surface, reflected, effects = scene()
    eye = (..., slice(30, 33), slice(14, 19))
    surface.parsing, surface.eye_sockets = torch.zeros(1, len(INDEX), SIZE, SIZE), torch.full((SIZE, SIZE), socket)
    reflected[:, 1:3] = 0
    reflected[:, :3, 30:33, 14:19] = torch.tensor(light)[:, None, None]
    effects.shadow.zero_()
    effects.shadow[eye] = 0.5 * hidden
    effects.colour_odds = torch.tensor(odds).reshape(1, 3, 1, 1).expand_as(surface.albedo)
    plain = explicit_sum(surface.albedo, reflected, effects)
    return move_sliders(Composed(plain, plain), surface, reflected, effects, 1.0, 0.0).lifted[eye]


@pytest.mark.parametrize(("socket", "blue"), [(1.0, 0.0), (0.0, 0.5)])
def test_no_eye_turns_blue_in_a_red_cheek_where_its_shadow_is_lifted(socket, blue):
    lifted = given_back_to_an_eye([1.0, 0.0, 1.0], BLUE, [1e-3, 1.0, 1e3], socket)
    assert lifted[0, 2].numpy() == pytest.approx(blue, abs=0.01)
    assert float(lifted[0, :2].max()) < 0.01


def test_an_eye_in_a_shadow_of_no_colour_gets_all_of_its_light_back():
    lifted = given_back_to_an_eye([2.0, 2.0, 2.0], 1.0, [1.0, 1.0, 1.0])
    assert lifted.numpy() == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(("lips_row", "glows"), [(50, False), (10, True)])
def test_no_ear_glows_where_its_shadow_is_lifted(lips_row, glows):
    """A hollow that faces a lamp behind the head, above the lips; below them are throats, lifted as they are."""
    surface, reflected, effects = scene()
    surface.parsing, surface.eye_sockets = torch.zeros(1, len(INDEX), SIZE, SIZE), torch.zeros(SIZE, SIZE)
    surface.parsing[:, INDEX["neck"]] = 1
    surface.parsing[:, INDEX["lips"], lips_row : lips_row + 2, 40:50] = 1
    reflected[:, :3, 30:33, 14:17] = 6
    effects.shadow[..., 30:33, 14:17] = 2.9
    plain = explicit_sum(surface.albedo, reflected, effects)
    lifted = move_sliders(Composed(plain, plain), surface, reflected, effects, 1.0, 0.0).lifted[..., 30:33, 14:17]
    # Around it there is 0.5, of which 0.1 is there already.
    assert lifted.numpy() == pytest.approx(2.9 if glows else 0.4, abs=0.01)


def test_less_shadow_darkens_no_eye_and_no_ear():
    torch.manual_seed(0)
    surface, reflected, effects = scene()
    surface.parsing, surface.eye_sockets = torch.zeros(1, len(INDEX), SIZE, SIZE), torch.rand(SIZE, SIZE)
    surface.parsing[:, INDEX["neck"]] = torch.rand(SIZE, SIZE)
    surface.parsing[:, INDEX["lips"], 60] = 1
    reflected = torch.rand(1, 6, 8, 8).repeat_interleave(SIZE // 8, 2).repeat_interleave(SIZE // 8, 3)
    odds = torch.exp(torch.randn(1, 3, SIZE, SIZE))
    effects = Effects(effects.specular, 0.5 * grey(surface.albedo * reflected[:, :3]), odds)
    plain = explicit_sum(surface.albedo, reflected, effects)
    of_gain = partial(move_sliders, Composed(plain, plain), surface, reflected, effects, 1.0)
    lifted = [of_gain(gain).lifted for gain in (0.0, 0.3, 0.7, 1.0)]
    assert all(float((less - more).min()) > -1e-5 for less, more in zip(lifted, lifted[1:], strict=False))


def parsed(surface, *parts):
    """The surface with a parsing of (name, rows, columns), without eyes."""
    surface.parsing, surface.eye_sockets = torch.zeros(1, len(INDEX), SIZE, SIZE), torch.zeros(SIZE, SIZE)
    for name, rows, columns in parts:
        surface.parsing[:, INDEX[name], rows, columns] = 1
    return surface


@pytest.mark.parametrize("gains", [(0.0, 0.0), (2.0, 0.0), (1.0, 0.4), (0.3, 1.7), (2.0, 2.0), (1.0, 1.7), (1.0, 1.0)])
def test_a_picture_that_is_the_explicit_sum_becomes_the_sum_at_the_sliders_gains(gains):
    """On a smooth surface, where nothing is too narrow to be lifted."""
    surface, reflected, effects = scene()
    parsed(surface, ("skin", slice(None), slice(None)))
    ramp = torch.linspace(0.2, 1.0, SIZE)
    reflected = torch.cat([ramp.expand(1, 3, SIZE, SIZE), 0.3 * ramp.expand(1, 3, SIZE, SIZE).mT], 1)
    shadow = 0.5 * ramp * torch.linspace(0, 0.9, SIZE)[:, None] + 0.1 * ramp[:, None]
    effects = Effects(0.2 * ramp[:, None].expand(1, 1, SIZE, SIZE), shadow[None, None])
    plain = explicit_sum(surface.albedo, reflected, effects)
    change = move_sliders(Composed(plain, plain), surface, reflected, effects, *gains)
    assert change.kept.max() <= 1
    assert change.is_none == (gains == (1.0, 1.0))
    moved = plain * change.kept + change.added + change.lifted
    torch.testing.assert_close(moved, explicit_sum(surface.albedo, reflected, effects, *gains), rtol=0, atol=1.1e-3)


def test_bare_skin_of_a_face_whose_lips_are_not_seen_is_lifted_as_it_is():
    surface, reflected, effects = scene()
    parsed(surface, ("neck", slice(None), slice(None)))
    reflected[:, :3, 30:33, 14:17] = 6
    effects.shadow[..., 30:33, 14:17] = 2.9
    plain = explicit_sum(surface.albedo, reflected, effects)
    lifted = move_sliders(Composed(plain, plain), surface, reflected, effects, 1.0, 0.0).lifted[..., 30:33, 14:17]
    assert lifted.numpy() == pytest.approx(2.9, abs=0.01)


def test_moving_sliders_changes_neither_surface_nor_effects():
    surface, reflected, effects = scene()
    parsed(surface, ("neck", slice(None), slice(None)), ("lips", slice(20, 22), slice(None)))
    effects.specular += 0.1
    given = [surface.parsing, surface.albedo, reflected, effects.shadow, effects.specular]
    before = [part.clone() for part in given]
    plain = explicit_sum(surface.albedo, reflected, effects)
    move_sliders(Composed(plain, plain), surface, reflected, effects, 1.5, 0.0)
    soften_shadow(effects, surface, reflected, 0.5)
    for part, as_it_was in zip(given, before, strict=True):
        torch.testing.assert_close(part, as_it_was, rtol=0, atol=0)
