"""Images to paint with: fractal noise, patterns, photographs; pooled, so that a sample costs little."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.painting.skin_textures import SkinTextures

SIZE = 256
_REMAP_WIDTH = 1024  # cv2.remap takes at most 32,766 rows or columns


def fractal_noise(rng: np.random.Generator, size: int = SIZE, falloff: float = 1.0) -> np.ndarray:
    """Periodic noise with amplitude 1 / frequency ** falloff, zero mean, unit deviation. (size, size) float32."""
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None]) * size
    spectrum = np.fft.rfft2(rng.standard_normal((size, size))) / np.maximum(frequency, 1) ** falloff
    spectrum[0, 0] = 0
    noise = np.fft.irfft2(spectrum, (size, size))
    return (noise / noise.std()).astype(np.float32)


def pattern(rng: np.random.Generator) -> np.ndarray:
    """A random picture of cells, stripes, shapes or clouds. (SIZE, SIZE, 3) float32 in [0, 1], linear."""
    kind = rng.integers(4)
    colours = rng.beta(0.8, 0.8, (8, 3)).astype(np.float32)
    if kind == 0:
        index = np.digitize(fractal_noise(rng, SIZE, rng.uniform(0.8, 2)), np.linspace(-1.5, 1.5, 7))
        return colours[index]
    if kind == 1:
        y, x = np.mgrid[:SIZE, :SIZE] / SIZE
        phase = rng.uniform(3, 40) * (x * rng.uniform(-1, 1) + y * rng.uniform(-1, 1))
        phase += 0.6 * fractal_noise(rng, SIZE, 1.5)
        blend = (0.5 + 0.5 * np.sin(2 * np.pi * phase))[..., None]
        return (colours[0] * blend + colours[1] * (1 - blend)).astype(np.float32)
    if kind == 2:
        image = np.full((SIZE, SIZE, 3), colours[0])
        for _ in range(rng.integers(10, 60)):
            centre, axes = rng.integers(0, SIZE, 2).tolist(), rng.integers(2, 40, 2).tolist()
            colour = rng.beta(0.8, 0.8, 3).tolist()
            cv2.ellipse(image, centre, axes, float(rng.uniform(0, 180)), 0, 360, colour, -1, cv2.LINE_AA)
        return image
    blend = np.clip(0.5 + 0.3 * np.stack([fractal_noise(rng, SIZE, rng.uniform(0.6, 1.6)) for _ in range(3)], -1), 0, 1)
    return (colours[0] * blend + colours[1] * (1 - blend)).astype(np.float32)


def look_up(texture: np.ndarray, uv: np.ndarray, repeat: float = 1.0) -> np.ndarray:
    """Bilinear values (P[, C]) of a texture (T, T[, C]) at (P, 2) coordinates, v up, wrapping around."""
    size, count = len(texture), len(uv)
    rows = -(-count // _REMAP_WIDTH)
    padded = np.zeros((rows * _REMAP_WIDTH, 2), np.float32)
    padded[:count] = uv * repeat % 1
    x, y = (padded.T * size - 0.5).reshape(2, rows, _REMAP_WIDTH).astype(np.float32)
    if count == 0:
        return np.empty((0, *texture.shape[2:]), np.float32)
    values = cv2.remap(texture, x, size - 1 - y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    return values.reshape(-1, *texture.shape[2:])[:count].astype(np.float32)


def photographs() -> list[np.ndarray]:
    """Pictures that scikit-image ships, float32 linear in [0, 1]; the sample portrait is not among them."""
    from skimage import data

    names = (
        "chelsea",
        "coffee",
        "cat",
        "rocket",
        "brick",
        "grass",
        "gravel",
        "camera",
        "coins",
        "moon",
        "page",
        "text",
    )
    pictures = []
    for name in names:
        try:
            picture = getattr(data, name)()
        except Exception:  # not every picture is in every installation, and some want a download
            continue
        if picture.ndim == 2:
            picture = np.repeat(picture[..., None], 3, 2)
        pictures.append((picture[..., :3].astype(np.float32) / 255) ** 2.2)
    return pictures


class TexturePool:
    """Noise and pictures made once per process and drawn from at random, flipped, cropped, recoloured.

    `skins` are painted skins to draw from beside the procedural one; None where there are none.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        panoramas: np.ndarray | None = None,
        count: int = 64,
        skins: SkinTextures | None = None,
    ):
        self.skins = skins
        self._noises = [fractal_noise(rng, SIZE, rng.uniform(0.3, 1.8)) for _ in range(count)]
        pictures = photographs() + ([] if panoramas is None else [_tone_mapped(p) for p in panoramas])
        self._pictures = [cv2.resize(p, (SIZE * 2, SIZE * 2), interpolation=cv2.INTER_AREA) for p in pictures]
        self._pictures += [cv2.resize(pattern(rng), (SIZE * 2, SIZE * 2)) for _ in range(count)]

    def noise(self, rng: np.random.Generator) -> np.ndarray:
        """(256, 256) float32 of zero mean and unit deviation."""
        noise = self._noises[rng.integers(len(self._noises))]
        return np.roll(_turned(noise, rng), rng.integers(0, SIZE, 2), (0, 1))

    def picture(self, rng: np.random.Generator) -> np.ndarray:
        """(256, 256, 3) float32, linear, in [0, 1]: a random cut, its channels shuffled at times."""
        source = self._pictures[rng.integers(len(self._pictures))]
        side = int(rng.integers(96, 2 * SIZE + 1))
        y, x = rng.integers(0, 2 * SIZE - side + 1, 2)
        cut = cv2.resize(source[y : y + side, x : x + side], (SIZE, SIZE), interpolation=cv2.INTER_AREA)
        cut = _turned(cut, rng)
        if rng.random() < 0.3:
            cut = cut[..., rng.permutation(3)]
        return np.ascontiguousarray(np.clip(cut, 0, 1) ** rng.uniform(0.5, 1.6))


def _turned(image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    image = np.rot90(image, rng.integers(4))
    return image[:, ::-1] if rng.random() < 0.5 else image


def _tone_mapped(panorama: np.ndarray) -> np.ndarray:
    exposed = panorama * (0.35 / max(float(np.median(panorama)), 1e-4))
    return (exposed / (1 + exposed)).astype(np.float32)
