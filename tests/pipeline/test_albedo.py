"""Shading left in the albedo, on planes and balls whose true albedo is known."""

import numpy as np
import pytest
import torch

from relight_core.lighting.relief import ReliefTransport
from relight_core.lighting.sphere import directions, solid_angles
from relight_core.pipeline.per_photo.albedo import flatten_albedo
from relight_core.pipeline.stages import Surface

SIZE = 32
SKIN, LEFT_EYE, NECK, HAIR, HAT = 1, 4, 9, 10, 11


def ball_surface(albedo, photo=None, label=SKIN):
    axis = (torch.arange(SIZE) + 0.5) / SIZE * 1.6 - 0.8
    y, x = torch.meshgrid(-axis, axis, indexing="ij")
    normal = torch.stack([x, y, (1 - x**2 - y**2).clamp_min(0.01).sqrt()])[None]
    normal = torch.nn.functional.normalize(normal, dim=1)
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, label] = 1
    one = torch.ones(1, 1, SIZE, SIZE)
    photo = torch.full((1, 3, SIZE, SIZE), 0.4) if photo is None else photo
    return Surface(photo, albedo, normal, 0 * one, parsing, one, torch.ones(1, 16, 32, 3))


def open_transport(surface):
    toward = torch.from_numpy(directions(16, 32).reshape(-1, 3))
    weight = torch.from_numpy(solid_angles(16, 32).reshape(-1))
    opened = (surface.normal[0].flatten(1).T @ toward.T).clamp_min(0) * weight / np.pi
    return ReliefTransport(opened, opened, SIZE)


def side_light():
    light = torch.full((1, 16, 32, 3), 0.2)
    light[:, 5:9, 22:28] = 8.0
    return light


def flattened(surface, relief, light):
    reflected = torch.cat([irradiance_of(relief, light), torch.zeros(1, 3, SIZE, SIZE)], 1)
    return flatten_albedo(surface, relief, light, reflected).albedo


def irradiance_of(relief, light):
    return (relief.unshadowed @ light[0].flatten(0, 1)).T.reshape(1, 3, SIZE, SIZE)


def shading_of(surface):
    return (open_transport(surface).shadowed @ side_light()[0].flatten(0, 1)).T.reshape(1, 3, SIZE, SIZE)


@pytest.mark.parametrize("power", [0.2, 0.5, 0.9])
def test_shading_that_was_left_in_is_taken_out(power):
    true = torch.full((1, 3, SIZE, SIZE), 0.3)
    clean = ball_surface(true)
    shaded = true * (shading_of(clean) + 0.02) ** power
    flat = flattened(ball_surface(shaded), open_transport(clean), side_light())
    spread = [float(a.log().std()) for a in (shaded, flat)]
    assert spread[1] < 0.02 < 0.1 < spread[0]
    assert float(flat.log().mean()) == pytest.approx(float(shaded.log().mean()), abs=0.02)


def test_in_a_soft_light_too():
    clean, light = ball_surface(torch.full((1, 3, SIZE, SIZE), 0.3)), torch.ones(1, 16, 32, 3)
    light[:, 5:9, 22:28] = 4.0
    relief = open_transport(clean)
    left = clean.albedo * (irradiance_of(relief, light) + 0.02) ** 0.5
    flat = flattened(ball_surface(left), relief, light)
    assert float(flat.log().std()) < 0.1 * float(left.log().std())


def below_its_eyes(label):
    """A ball of skin with shading in its albedo, a row of eyes across it and another part below."""
    clean = ball_surface(torch.full((1, 3, SIZE, SIZE), 0.3))
    surface = ball_surface(clean.albedo * (shading_of(clean) + 0.02) ** 0.5)
    surface.parsing[:, SKIN, 12:14], surface.parsing[:, LEFT_EYE, 12:14] = 0, 1
    surface.parsing[:, SKIN, 20:], surface.parsing[:, label, 20:] = 0, 1
    return surface, flattened(surface, open_transport(clean), side_light())


def test_a_neck_is_skin_and_hair_keeps_what_is_in_its_albedo():
    surface, flat = below_its_eyes(NECK)
    assert float(flat[:, :, 22:].log().std()) < 0.03 < 0.1 < float(surface.albedo[:, :, 22:].log().std())
    surface, flat = below_its_eyes(HAIR)
    torch.testing.assert_close(flat[:, :, 20:], surface.albedo[:, :, 20:], rtol=0.02, atol=0)


def half_hidden(surface):
    """Transport of a surface's own relief, to whose left half a half of all light gets."""
    opened = open_transport(surface).unshadowed
    reaches = torch.where(torch.arange(SIZE * SIZE) % SIZE < SIZE // 2, 0.5, 1.0)
    return ReliefTransport(opened, opened * reaches[:, None], SIZE)


def test_shading_of_the_reliefs_own_shadows_is_taken_out_too():
    clean = ball_surface(torch.full((1, 3, SIZE, SIZE), 0.3))
    relief = half_hidden(clean)
    behind = (relief.shadowed @ side_light()[0].flatten(0, 1)).T.reshape(1, 3, SIZE, SIZE)
    left = clean.albedo * (behind + 0.02) ** 0.5
    assert float(flattened(ball_surface(left), relief, side_light()).log().std()) < 0.1 * float(left.log().std())


def test_a_hat_in_its_own_shadow_is_not_taken_for_a_darker_one():
    albedo = torch.full((1, 3, SIZE, SIZE), 0.3)
    relief, light = half_hidden(ball_surface(albedo)), side_light()
    seen = albedo * (relief.shadowed @ light[0].flatten(0, 1)).T.reshape(1, 3, SIZE, SIZE)
    hat = ball_surface(albedo, seen * (0.6 / float(seen.max())), HAT)
    torch.testing.assert_close(flattened(hat, relief, light), albedo, rtol=0.1, atol=0)


def test_texture_that_does_not_follow_the_light_stays():
    texture = torch.rand(1, 1, SIZE, SIZE, generator=torch.Generator().manual_seed(0)) * 0.4 + 0.2
    surface = ball_surface(texture.expand(1, 3, SIZE, SIZE))
    flat = flattened(surface, open_transport(surface), side_light())
    torch.testing.assert_close(flat, surface.albedo, rtol=0.08, atol=0)


def test_darker_toward_the_light_is_left_alone():
    true = torch.full((1, 3, SIZE, SIZE), 0.3)
    clean = ball_surface(true)
    odd = ball_surface(true * (shading_of(clean) + 0.02) ** -0.4)
    assert torch.equal(flattened(odd, open_transport(clean), side_light()), odd.albedo)


def test_white_hair_on_a_scalp_is_not_taken_for_skin():
    """Cropped hair is parsed as neck, as a bald scalp is; the shading is taken out of the face alone."""
    face = ball_surface(torch.tensor([0.4, 0.2, 0.15])[None, :, None, None].expand(1, 3, SIZE, SIZE).clone())
    face.albedo[:, :, :8] = 0.6
    face.parsing[:, SKIN, :8], face.parsing[:, NECK, :8] = 0, 1
    face.parsing[:, SKIN, 12:14], face.parsing[:, LEFT_EYE, 12:14] = 0, 1
    flat = flattened(face, open_transport(face), side_light())
    assert torch.equal(flat[:, :, :8], face.albedo[:, :, :8])
    torch.testing.assert_close(flat[:, :, 16:], face.albedo[:, :, 16:], rtol=0.02, atol=0)


@pytest.mark.parametrize("case", ["hair only", "clipped", "even light", "black light"])
def test_where_nothing_can_be_said_nothing_changes(case):
    albedo = torch.full((1, 3, SIZE, SIZE), 0.3) * torch.linspace(0.5, 1.5, SIZE)
    light = {"even light": torch.ones(1, 16, 32, 3), "black light": torch.zeros(1, 16, 32, 3)}.get(case, side_light())
    photo = torch.ones(1, 3, SIZE, SIZE) if case == "clipped" else None
    surface = ball_surface(albedo, photo, HAIR if case == "hair only" else SKIN)
    flat = flattened(surface, open_transport(surface), light)
    torch.testing.assert_close(flat, albedo, rtol=0.02, atol=0)


def coloured(patch_colour, size):
    """Skin of one colour with a square patch of another at its middle."""
    albedo = torch.tensor([0.5, 0.3, 0.2])[None, :, None, None].expand(1, 3, SIZE, SIZE).clone()
    low = (SIZE - size) // 2
    albedo[..., low : low + size, low : low + size] = torch.tensor(patch_colour)[None, :, None, None]
    return albedo


def patch_of(albedo, label):
    surface = ball_surface(albedo, albedo, label)
    return flattened(surface, open_transport(surface), torch.ones(1, 16, 32, 3))[0, :, 16, 16]


def test_a_cheek_in_purple_light_becomes_skin_again_but_purple_hair_stays():
    purple = coloured((0.35, 0.25, 0.4), 10)
    # Light fades into its surroundings; what ends at an edge is paint.
    purple = torch.nn.functional.avg_pool2d(purple, 9, 1, 4, count_include_pad=False)
    red, green, blue = patch_of(purple, SKIN).tolist()
    assert red > green > blue
    torch.testing.assert_close(patch_of(purple, HAIR), purple[0, :, 16, 16])


def test_a_mole_and_a_flush_keep_their_colours():
    mole, flush = coloured((0.1, 0.05, 0.05), 1), coloured((0.52, 0.28, 0.19), 10)
    for albedo in (mole, flush):
        torch.testing.assert_close(patch_of(albedo, SKIN), albedo[0, :, 16, 16], rtol=0.05, atol=0.005)
