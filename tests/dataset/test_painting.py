"""What a head is painted with: every material in its own colours, and which of them training makes wild."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from synthetic_heads import ball

from relight_core.dataset.baking.scene import Material
from relight_core.dataset.painting.fabric import fabric, frame
from relight_core.dataset.painting.skin import hair_colour, paint, paint_smooth, skin_tone
from relight_core.dataset.painting.texture import TexturePool, fractal_noise, look_up
from relight_core.face.parsing import INDEX

SIZE = 24
SEEDS = range(40)

plainly = partial(paint, wild=False)


def random(seed):
    return np.random.default_rng(seed)


@pytest.fixture(scope="module")
def head():
    """A ball in bands of every material, the upper third of it face."""
    made = ball(SIZE)
    row = np.nonzero(made.covered)[0]
    material = np.where(row < 8, 0, 1 + (np.arange(len(row)) % 11)).astype(np.uint8)
    label = np.where(made.normal[:, 0] > 0.3, INDEX["lips"], INDEX["skin"]).astype(np.uint8)
    return replace(made, material=material, label=np.where(material == 0, label, INDEX["neck"]).astype(np.uint8))


@pytest.fixture(scope="module")
def worn(head, pool):
    """The albedos of many heads as people are, (seeds, P, 3)."""
    return np.stack([paint(head, pool, random(seed), wild=False) for seed in SEEDS])


def luminance(colours):
    return colours @ np.array([0.2126, 0.7152, 0.0722])


def test_more_of_a_pigment_takes_more_light_melanin_most_of_blue_and_blood_most_of_green():
    pale, tanned, flushed = skin_tone(0.0, 0.0), skin_tone(0.5, 0.0), skin_tone(0.0, 0.5)
    np.testing.assert_allclose(pale, [0.70, 0.49, 0.39], atol=1e-6)
    assert (np.diff(tanned / pale) < 0).all()
    assert (flushed < pale).all()
    assert (flushed / pale).argmin() == 1
    assert skin_tone(np.zeros((4, 5)), 0.2).shape == (4, 5, 3)


@pytest.mark.parametrize(
    ("material", "low", "high"),
    [(Material.TEETH, 0.35, 0.85), (Material.MOUTH, 0.015, 0.3)],
)
def test_teeth_are_bright_and_mouths_are_dark_and_red(head, worn, material, low, high):
    part = worn[:, head.material == material]
    assert low <= luminance(part).min() <= luminance(part).max() <= high
    assert (part[..., 0] >= part[..., 2]).all()


def test_brows_are_of_the_hairs_colour_and_hair_of_every_lightness(head, worn):
    hair, brows = (worn[:, head.material == of].mean(1) for of in (Material.HAIR, Material.BROW))
    streaks = np.log(luminance(worn[:, head.material == Material.HAIR])).std(1)
    assert np.median(streaks) > 0.1
    np.testing.assert_allclose(hair / hair.sum(1, keepdims=True), brows / brows.sum(1, keepdims=True), atol=0.12)
    colours = np.array([hair_colour(random(seed)) for seed in range(400)])
    assert luminance(colours).min() < 0.05
    # White hair is frequent, for a network that has hardly seen any takes it for a scalp.
    assert 0.04 < (luminance(colours) > 0.5).mean() < 0.25
    assert (np.ptp(colours, axis=1) < 0.05 * colours.max(1) + 1e-3).mean() == pytest.approx(0.25, abs=0.07)


@pytest.mark.parametrize("painted", [paint_smooth, plainly])
def test_an_eye_has_a_black_pupil_in_a_coloured_iris_in_white(pool, painted):
    made = ball(64)
    eye = replace(made, material=np.full_like(made.material, Material.SCLERA), uv=(made.normal[:, :2] + 1) / 2)
    radius = np.hypot(*(eye.uv - 0.5).T)
    for seed in range(8):
        albedo = painted(eye, pool, random(seed))
        pupil, iris, white = (luminance(albedo[where]) for where in (radius < 0.03, radius < 0.11, radius > 0.15))
        assert pupil.max() < 0.02
        assert 0.02 < np.median(iris) < 0.3
        assert white.min() > 0.3


def test_hair_darkens_brows_and_at_times_the_lower_face_and_nothing_between(pool):
    made = ball(64)
    u, v = ((made.normal[:, :2] + 1) / 2).T
    label = np.where((v > 0.78) & (v < 0.84), INDEX["left_brow"], INDEX["skin"])
    label[(np.abs(u - 0.5) < 0.1) & (np.abs(v - 0.3) < 0.04)] = INDEX["lips"]
    face = replace(made, uv=np.stack([u, v], 1).astype(np.float32), label=label.astype(np.uint8))
    painted = np.stack([np.log(luminance(paint(face, pool, random(seed), wild=False))) for seed in range(60)])
    parts = {
        "brow": label == INDEX["left_brow"],
        "chin": (v < 0.4) & (v > 0.22) & (label != INDEX["lips"]),
        "cheek": (v > 0.6) & (v < 0.66),
        "forehead": (v > 0.86) & (v < 0.9),
        "throat": v < 0.12,
    }
    tones = {name: painted[:, where].mean(1) for name, where in parts.items()}
    darker = {name: tones[name] - tones["cheek"] for name in parts}
    assert np.median(darker["brow"]) < -0.3
    assert abs(np.median(darker["forehead"])) < 0.1
    assert 0.15 < (darker["chin"] < -0.25).mean() < 0.45
    bearded = darker["chin"] < -0.25
    assert np.median(darker["throat"][bearded]) > -0.1
    lips = painted[:, label == INDEX["lips"]].mean(1) - tones["chin"]
    assert np.median(lips[bearded]) > np.median(lips[~bearded])


def test_some_scalps_are_shaved_and_no_chest_is_which_shares_their_tile(pool):
    made = ball(64)
    u, v = ((made.normal[:, :2] + 1) / 2).T
    back = replace(made, uv=np.stack([u, v], 1).astype(np.float32), material=np.full_like(made.material, Material.HEAD))
    skull, chest, neck = (v > 0.5) & (np.abs(u - 0.5) < 0.2), (v > 0.4) & (np.abs(u - 0.5) > 0.38), v < 0.28
    painted = np.stack([np.log(luminance(paint(back, pool, random(seed), wild=False))) for seed in range(60)])
    of_skull, of_chest = (np.median(painted[:, where], 1) - np.median(painted[:, neck], 1) for where in (skull, chest))
    assert 0.2 < (np.abs(of_skull) > 0.15).mean() < 0.6
    assert (np.abs(of_chest) > 0.15).mean() < 0.1


@pytest.mark.parametrize(("painted", "least"), [(paint_smooth, 0.75), (plainly, 0.6)])
def test_lips_have_their_own_colour_where_no_lipstick_is_on_them(head, pool, painted, least):
    lips = head.label == INDEX["lips"]
    skin = (head.material == Material.FACE) & ~lips
    redder = []
    for seed in SEEDS:
        albedo = painted(head, pool, random(seed))
        colour, around = albedo[lips].mean(0), albedo[skin].mean(0)
        redder.append((colour[0] / colour[1]) / (around[0] / around[1]))
    assert np.mean(np.array(redder) > 1.05) > least


def test_nothing_is_darker_or_brighter_than_stuffs_are_however_it_is_painted(head, pool):
    for seed in range(12):
        for albedo in (paint(head, pool, random(seed)), paint_smooth(head, pool, random(seed))):
            assert albedo.shape == (len(head.uv), 3)
            assert 0.015 - 1e-6 <= albedo.min() <= albedo.max() <= 0.95 + 1e-6


def test_pictures_lie_over_three_heads_in_ten_and_leave_most_skin_alone(head, pool, worn):
    is_skin = np.isin(head.material, (Material.FACE, Material.HEAD))
    changed = []
    for seed, plain in zip(SEEDS, worn, strict=True):
        other = np.abs(paint(head, pool, random(seed)) - plain).max(1) > 1e-6
        changed.append((bool(other[~is_skin].any()), bool(other[is_skin].any())))
    pictures, skins = np.mean(changed, axis=0)
    assert pictures == pytest.approx(0.3, abs=0.15)
    assert 0 < skins < 0.75 * pictures


def test_a_scan_keeps_its_albedo_or_takes_another_tone_and_is_not_painted_over(head, pool):
    own = random(0).uniform(0.1, 0.25, (len(head.uv), 3)).astype(np.float32)
    scan, same = replace(head, albedo=own.copy()), 0
    for seed in range(30):
        paint(scan, pool, random(seed))
        np.testing.assert_array_equal(scan.albedo, own)
        tone = paint(scan, pool, random(seed), wild=False) / own
        np.testing.assert_allclose(tone, np.broadcast_to(tone[0], tone.shape), rtol=1e-4)
        same += bool(np.allclose(tone, 1, atol=1e-6))
    assert 8 < same < 22


def grid(count):
    at = (np.arange(count) + 0.5) / count
    return np.stack(np.meshgrid(at, at), -1).reshape(-1, 2)


def test_stuffs_are_reflectances_from_black_to_white_plain_and_patterned(pool):
    uv, plain, levels = grid(40), 0, []
    for seed in range(60):
        stuff = fabric(uv, pool, random(seed))
        assert stuff.dtype == np.float32
        assert stuff.min() >= 0
        assert np.isfinite(stuff).all()
        levels.append(float(np.median(luminance(stuff))))
        plain += bool(np.ptp(np.log(stuff + 1e-3), axis=0).max() < 1.4)
    assert np.percentile(levels, 10) < 0.1
    assert np.percentile(levels, 95) > 0.5
    assert 0.3 < plain / 60 < 0.75
    dark = [float(luminance(frame(uv, pool, random(seed)).mean(0))) < 0.08 for seed in range(100)]
    assert 0.55 < np.mean(dark) < 0.85


def test_a_texture_is_looked_up_with_v_upward_between_its_texels_and_around_its_edges():
    texture = np.arange(16, dtype=np.float32).reshape(4, 4)
    centres = (np.array([[0, 3], [3, 3], [1, 0]]) + 0.5) / 4
    np.testing.assert_allclose(look_up(texture, centres), [0, 3, 13], atol=1e-4)
    np.testing.assert_allclose(look_up(texture, centres + [2, -3]), [0, 3, 13], atol=1e-4)
    np.testing.assert_allclose(look_up(texture, centres[:1] + [0.125, 0]), [0.5], atol=0.02)
    np.testing.assert_allclose(look_up(texture, np.array([[0.0, 0.875]])), [1.5], atol=0.05)
    np.testing.assert_allclose(look_up(texture, centres / 3, 3), [0, 3, 13], atol=0.02)
    assert look_up(np.zeros((4, 4, 3), np.float32), np.zeros((0, 2))).shape == (0, 3)
    assert look_up(np.full((4, 4, 3), 2, np.float32), np.zeros((40_000, 2))).min() == 2


@pytest.mark.parametrize("falloff", [0.5, 1.5])
def test_noise_is_even_about_nothing_and_joins_at_its_edges(falloff):
    noise = fractal_noise(random(0), 64, falloff)
    assert abs(noise.mean()) < 1e-3
    assert noise.std() == pytest.approx(1, abs=1e-3)
    inside, across = np.abs(np.diff(noise, axis=0)).mean(), np.abs(noise[0] - noise[-1]).mean()
    assert across < 1.6 * inside


def test_pictures_drawn_are_reflectances_even_of_black_panoramas():
    panoramas = np.stack([np.zeros((8, 16, 3), np.float32), np.full((8, 16, 3), 900, np.float32)])
    drawn = TexturePool(random(0), panoramas, count=1)
    for seed in range(12):
        picture = drawn.picture(random(seed))
        assert picture.shape == (256, 256, 3)
        assert 0 <= picture.min() <= picture.max() <= 1
