"""Albedo of a dressed head in linear reflectance: skin from its pigments, and everything else from paint.

Skin is Beer-Lambert absorption by melanin and haemoglobin over a pale base, which covers the range of
human skin evenly when melanin is drawn uniformly; where there are painted skins, half of the samples take
their detail or their colouring instead. In some samples arbitrary pictures are laid over it or
instead of it: a network that has seen wild albedo learns what light does, not what skin looks like. One that
has seen little else keeps the light's own gradients for paint.
"""

from __future__ import annotations

import numpy as np

from relight_core.dataset.baking.bake import FABRIC, SKIN, BakedHead
from relight_core.dataset.baking.scene import Material
from relight_core.dataset.painting.fabric import fabric, frame
from relight_core.dataset.painting.skin_marks import mark_skin
from relight_core.dataset.painting.skin_textures import SkinTextures
from relight_core.dataset.painting.texture import TexturePool, look_up
from relight_core.face.parsing import INDEX

_PALE = np.array([0.70, 0.49, 0.39], np.float32)
_MELANIN = np.array([1.75, 2.1, 2.45], np.float32)
_HAEMOGLOBIN = np.array([0.10, 0.55, 0.45], np.float32)
_PAINTED_SHARE = 0.5
_TINTED_SHARE, _COVERED_SHARE, _PATCHED_SHARE = 0.1, 0.1, 0.1
_BARE_SKINNED_SHARE = 0.6
_WHITEST_HAIR = 0.85
_DARKEST, _BRIGHTEST = 0.015, 0.95

# Centres and radii in the face tile of what blood colours: cheeks, nose tip, chin.
_FLUSHED = ((0.30, 0.50, 0.10), (0.70, 0.50, 0.10), (0.50, 0.60, 0.05), (0.50, 0.30, 0.06))


def paint(head: BakedHead, pool: TexturePool, rng: np.random.Generator, *, wild: bool = True) -> np.ndarray:
    """A random albedo for every pixel of a head. (P, 3) float32, linear, in [0.015, 0.95].

    Args:
        wild: lay arbitrary pictures over three heads in ten, as training wants; False keeps to what people wear.
    """
    albedo = _worn(head, pool, rng) if head.albedo is None else _scanned(head.albedo, rng)
    if wild:
        _lay_pictures(albedo, head, pool, rng)
    return np.clip(albedo, _DARKEST, _BRIGHTEST)


def _scanned(albedo: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A scan's own albedo; half the time in another tone, for scans are few and people are many."""
    if rng.random() < 0.5:
        return albedo.copy()
    return albedo * np.exp(rng.normal(0, 0.25) + rng.normal(0, 0.06, 3)).astype(np.float32)


def _worn(head: BakedHead, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    albedo = np.empty((len(head.uv), 3), np.float32)
    skin = _skin(head, pool, rng)
    is_skin = np.isin(head.material, SKIN)
    albedo[is_skin] = skin[is_skin]
    _paint_mouth(albedo, head, rng)
    _paint_eyes(albedo, head, rng)
    hair = hair_colour(rng)
    for material in (Material.HAIR, Material.BROW):
        where = head.material == material
        albedo[where] = _strands(head.uv[where], hair, pool, rng)
    for material in FABRIC:
        where = head.material == material
        albedo[where] = fabric(head.uv[where], pool, rng)
    glasses = head.material == Material.GLASSES
    albedo[glasses] = frame(head.uv[glasses], pool, rng)
    return albedo


def paint_smooth(head: BakedHead, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """The simplest albedo, to measure against: smooth skin with lips, mouth and eyes. (P, 3) as `paint`."""
    albedo = skin_tone(rng.random() ** 1.3 + 0.04 * look_up(pool.noise(rng), head.uv), rng.uniform(0, 0.5))
    _paint_lips(albedo, head, rng, has_colour=False)
    _paint_mouth(albedo, head, rng)
    _paint_eyes(albedo, head, rng)
    return np.clip(albedo, _DARKEST, _BRIGHTEST)


def skin_tone(melanin, haemoglobin) -> np.ndarray:
    """Linear reflectance (..., 3) for pigment amounts in [0, 1]."""
    melanin, haemoglobin = np.asarray(melanin)[..., None], np.asarray(haemoglobin)[..., None]
    return (_PALE * np.exp(-_MELANIN * melanin - _HAEMOGLOBIN * haemoglobin)).astype(np.float32)


def _skin(head: BakedHead, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    uv = head.uv
    melanin = rng.random() ** 1.3 + 0.04 * look_up(pool.noise(rng), uv) + 0.02 * look_up(pool.noise(rng), uv, 3)
    haemoglobin = rng.uniform(0, 0.5) + 0.06 * look_up(pool.noise(rng), uv)
    haemoglobin = haemoglobin + rng.uniform(0, 0.5) * _flush(uv) * (head.material == Material.FACE)
    if rng.random() < 0.3:
        spots = look_up(pool.noise(rng), uv, rng.uniform(2, 5)) + look_up(pool.noise(rng), uv, 6)
        melanin = melanin + 0.25 * np.clip(spots - rng.uniform(1.5, 2.8), 0, 1)
    skin = skin_tone(np.clip(melanin, -0.1, 1.2), np.clip(haemoglobin, 0, 1.3))
    painted = pool.skins is not None and rng.random() < _PAINTED_SHARE
    if painted:
        _lay_painted_skin(skin, head, pool.skins, rng)
    _paint_lips(skin, head, rng, has_colour=painted)
    mark_skin(skin, head, pool, rng)
    _paint_hair_on_skin(skin, head, pool, rng)
    return skin * rng.uniform(0.9, 1.1)


def _lay_painted_skin(skin: np.ndarray, head: BakedHead, skins: SkinTextures, rng: np.random.Generator) -> None:
    """A painted skin in place of the procedural one: its detail alone, all its variation, or its own tone too."""
    number = int(rng.integers(len(skins.names)))
    on_back = head.material != Material.FACE
    fine = np.log(skins.colour(number, head.uv, on_back) + 1e-3)
    chance = rng.random()
    if chance < 0.4:
        smooth = np.log(skins.smooth_colour(number, head.uv, on_back) + 1e-3)
        skin *= np.exp((fine - smooth) * rng.uniform(0.6, 1.6))
    elif chance < 0.7:
        skin *= np.exp((fine - np.log(skins.tone(number) + 1e-3)) * rng.uniform(0.6, 1.1))
    else:
        jitter = rng.normal(0, 0.15) + rng.normal(0, 0.05, 3)
        skin[:] = np.exp(fine + jitter)


def _flush(uv: np.ndarray) -> np.ndarray:
    total = np.zeros(len(uv), np.float32)
    for u, v, radius in _FLUSHED:
        total += np.exp(-((uv[:, 0] - u) ** 2 + (uv[:, 1] - v) ** 2) / (2 * radius**2))
    return total


def _paint_lips(skin: np.ndarray, head: BakedHead, rng: np.random.Generator, has_colour: bool) -> None:
    """Lipstick at times, else the lips' own colour where the skin has none for them yet."""
    lips = head.label == INDEX["lips"]
    if rng.random() < 0.3:
        lipstick = rng.beta(1, 2, 3).astype(np.float32) * [1, 0.5, 0.6]
        skin[lips] = skin[lips] * 0.3 + lipstick * 0.7
    elif not has_colour:
        skin[lips] *= np.array([0.85, 0.6, 0.65], np.float32) ** rng.uniform(0.3, 1.5)


def _paint_hair_on_skin(skin: np.ndarray, head: BakedHead, pool: TexturePool, rng: np.random.Generator) -> None:
    """Brows, stubble and beard, eye shadow and a shaved scalp: all darken the skin through a noisy mask."""
    hair = hair_colour(rng)
    fine = look_up(pool.noise(rng), head.uv, 4)
    on_face = head.material == Material.FACE
    u, v = head.uv.T
    brows = np.isin(head.label, (INDEX["left_brow"], INDEX["right_brow"]))
    _blend(skin, hair, brows * np.clip(rng.uniform(0.3, 1.1) + 0.3 * fine, 0, 1))
    if rng.random() < 0.35:
        low = 1 / (1 + np.exp((v - rng.uniform(0.42, 0.56)) * 40))
        outside_lips = (head.label != INDEX["lips"]) & (head.label != INDEX["inner_mouth"])
        middle = 1 / (1 + np.exp((0.18 - v) * 40))
        _blend(
            skin,
            hair,
            on_face * outside_lips * low * middle * np.clip(rng.uniform(0.1, 0.9) + 0.35 * fine, 0, 1),
        )
    if rng.random() < 0.25:
        lids = np.exp(-((np.abs(u - 0.5) - 0.145) ** 2 / 0.003 + (v - 0.74) ** 2 / 0.001))
        _blend(skin, rng.beta(1, 3, 3).astype(np.float32), on_face * lids * rng.uniform(0.2, 0.8))
    if rng.random() < 0.4:
        # The outer parts of the second tile are the front of the chest.
        skull = (head.material == Material.HEAD) & (v > 0.33) & (np.abs(u - 0.5) < 0.36)
        scalp = skull | (on_face & (v > 0.93))
        _blend(skin, hair, scalp * np.clip(rng.uniform(0.2, 1.0) + 0.25 * fine, 0, 1))


def _blend(skin: np.ndarray, colour: np.ndarray, weight: np.ndarray) -> None:
    weight = weight.astype(np.float32)[:, None]
    skin *= 1 - weight
    skin += weight * colour


def hair_colour(rng: np.random.Generator) -> np.ndarray:
    """Black through brown and red to blond, grey to white, and now and then a dyed colour.

    White hair is frequent here: a network that has hardly seen any takes it for a brightly lit scalp.
    """
    chance = rng.random()
    if chance < 0.1:
        return rng.beta(1, 2, 3).astype(np.float32)
    if chance < 0.35:
        return np.full(3, rng.uniform(0.08, _WHITEST_HAIR), np.float32) * np.array([1, 0.98, 0.95], np.float32)
    pigment = rng.uniform(0, 1) ** 0.6
    return (np.array([0.5, 0.34, 0.18]) * np.exp(-pigment * np.array([3.2, 3.3, 2.9]))).astype(np.float32)


def _strands(uv: np.ndarray, colour: np.ndarray, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    along = np.stack([uv[:, 0] * rng.uniform(2, 8), uv[:, 1] * rng.uniform(0.2, 1)], 1)
    streaks = 0.35 * look_up(pool.noise(rng), along) + 0.25 * look_up(pool.noise(rng), uv, 2)
    return colour * np.exp(np.clip(streaks, -1.2, 1.2))[:, None]


def _paint_mouth(albedo: np.ndarray, head: BakedHead, rng: np.random.Generator) -> None:
    albedo[head.material == Material.MOUTH] = np.array([0.35, 0.1, 0.1]) * rng.uniform(0.3, 1.2)
    teeth = np.array([0.75, 0.7, 0.6]) * rng.uniform(0.6, 1.1)
    albedo[head.material == Material.TEETH] = teeth


def _paint_eyes(albedo: np.ndarray, head: BakedHead, rng: np.random.Generator) -> None:
    """The ball's texture is centred on the pupil: pupil, iris with radial fibres, limbal ring, white."""
    ball = np.isin(head.material, (Material.SCLERA, Material.IRIS))
    if not ball.any():
        return
    offset = head.uv[ball] - 0.5
    radius, angle = np.hypot(*offset.T), np.arctan2(*offset.T)
    iris_radius = rng.uniform(0.12, 0.135)
    iris = rng.choice([[0.05, 0.025, 0.012], [0.12, 0.07, 0.03], [0.10, 0.16, 0.22], [0.10, 0.13, 0.07]])
    iris = np.asarray(iris) * rng.uniform(0.6, 1.6) * (1 + 0.25 * np.sin(angle * 23 + rng.uniform(0, 6)))[:, None]
    white = np.array([0.72, 0.66, 0.62]) * rng.uniform(0.75, 1.1) * np.exp(-radius[:, None] * [0.0, 0.5, 0.5])
    eye = np.where(
        (radius < iris_radius)[:, None], iris * np.clip((iris_radius - radius) * 60, 0.35, 1)[:, None], white
    )
    albedo[ball] = np.where((radius < iris_radius * rng.uniform(0.3, 0.5))[:, None], 0.012, eye)


def _lay_pictures(albedo: np.ndarray, head: BakedHead, pool: TexturePool, rng: np.random.Generator) -> None:
    """Domain randomisation: pictures multiplied over the albedo, instead of it, or on a part of the head.

    Most of them leave the skin alone: it has one colour, and a network that has seen otherwise takes shade for paint.
    """
    chance = rng.random()
    if chance > _TINTED_SHARE + _COVERED_SHARE + _PATCHED_SHARE:
        return
    bare = np.isin(head.material, SKIN) & (rng.random() < _BARE_SKINNED_SHARE)
    skin = albedo[bare]
    picture = look_up(pool.picture(rng), head.uv, rng.choice([1, 1, 2, 3]))
    if chance < _TINTED_SHARE:
        mean = picture.mean(0, keepdims=True)
        albedo *= ((picture + 0.05) / (mean + 0.05)) ** rng.uniform(0.3, 1)
    elif chance < _TINTED_SHARE + _COVERED_SHARE:
        blend = rng.uniform(0.5, 1)
        albedo[:] = albedo * (1 - blend) + picture * blend
    else:
        noise = look_up(pool.noise(rng), head.uv, rng.choice([1, 2]))
        weight = np.clip((noise - rng.uniform(-0.5, 1.2)) * rng.uniform(1, 12), 0, 1)[:, None]
        albedo[:] = albedo * (1 - weight) + picture * weight
    albedo[bare] = skin
