"""Photos with a shadow from outside on them: what the foreign-shadow network is shown, and what it is told."""

import numpy as np
import pytest
import torch

from relight_core.dataset import gobo_photos
from relight_core.dataset.gobo_photos import GoboStream, PaintedHead
from tests.synthetic_heads import write_balls, write_lights

SIZE = 32


@pytest.fixture
def stream(tmp_path):
    write_balls(tmp_path / "heads", 0, 2, size=SIZE)
    write_lights(tmp_path / "lights.npz", 6)
    where = (tmp_path / "heads", tmp_path / "lights.npz", "train", SIZE, 7)
    return lambda **how: iter(GoboStream(*where, pairs=2, heads_at_once=2, **how))


def some(samples, count):
    return [next(samples) for _ in range(count)]


def test_a_sample_is_a_photo_its_parts_and_what_the_shadow_leaves(stream):
    for sample in some(stream(), 12):
        shapes = {name: tuple(value.shape) for name, value in sample.items()}
        assert shapes == {
            "photo_srgb": (3, SIZE, SIZE),
            "kinds": (4, SIZE, SIZE),
            "foreign_shadow": (3, SIZE, SIZE),
            "person": (1, SIZE, SIZE),
        }
        off = sample["person"].expand(3, -1, -1) == 0
        assert off.any()
        assert (sample["foreign_shadow"][off] == 0).all()
        assert float(sample["foreign_shadow"].max()) <= 0
        assert 0 <= float(sample["photo_srgb"].min()) <= float(sample["photo_srgb"].max()) <= 1
        # A ball is all skin.
        middle = sample["kinds"][:, SIZE // 2 - 2 : SIZE // 2 + 2, SIZE // 2 - 2 : SIZE // 2 + 2]
        assert float(middle[0].min()) > 0.9
        assert float(middle[1:].max()) < 0.1
        # Edges are soft by a pixel.
        near = torch.nn.functional.max_pool2d(sample["person"], 7, 1, 3)[0] > 0
        assert float(sample["kinds"][:, ~near].max()) < 0.01


def test_a_third_has_no_shadow_and_some_are_deep(stream):
    samples = some(stream(), 90)
    deepest = np.array([float(sample["foreign_shadow"].mean(0).min()) for sample in samples])
    assert 0.2 < np.mean(deepest > -1e-3) < 0.6
    assert np.mean(deepest < -0.7) > 0.2


def test_the_photo_is_as_dark_as_is_told(stream, monkeypatch):
    """Seen by a camera that does nothing, the photo over what is told is the photo without the shadow."""
    half = np.ones((SIZE, SIZE), np.float32)
    half[:, SIZE // 2 :] = 0
    monkeypatch.setattr(gobo_photos, "through_camera", lambda exposed, rng: np.clip(exposed, 0, 1).astype(np.float32))
    monkeypatch.setattr(gobo_photos, "camera_gain", lambda *exposing: np.float32(0.3))
    monkeypatch.setattr(gobo_photos, "_SHADOWED_SHARE", 1.0)
    plain = some(stream_with(stream, monkeypatch, np.ones_like(half)), 20)
    shaded = some(stream_with(stream, monkeypatch, half), 20)
    for before, after in zip(plain, shaded, strict=True):
        # At the outline what lies behind is dark as well.
        person = -torch.nn.functional.max_pool2d(-before["person"][None], 5, 1, 2)[0, 0] > 0.5
        told = after["foreign_shadow"][:, person]
        ratio = ((after["photo_srgb"] + 0.005) / (before["photo_srgb"] + 0.005)).log()[:, person]
        dark = told.mean(0) < -0.05
        assert dark.any()
        # Where most is lit counts as lit.
        lit = (ratio - told)[:, dark]
        off = (lit - lit.median(1, keepdim=True).values).abs()
        assert float(off.quantile(0.9)) < 2e-3
        assert float(lit.median().abs()) < 0.2
        assert (before["foreign_shadow"].abs() < 1e-5).all()


def stream_with(stream, monkeypatch, passes):
    monkeypatch.setattr(gobo_photos, "sample_gobo", lambda relief, pool, rng: passes)
    return stream()


def test_the_stream_goes_on_where_it_is_told_to(stream):
    ahead, again = some(stream(), 61)[60], next(stream(first_batch=30))
    for name, value in ahead.items():
        np.testing.assert_array_equal(value.numpy(), again[name].numpy())


class Studio:
    """Samples of one head before an even wall, seen by a camera that multiplies by `gain` and does nothing else.

    Attributes:
        passes: how much of the lamp gets past, everywhere or (S, S).
        exposed: what the camera was exposed for: the head's radiance, where it is, and the lamp.
    """

    def __init__(self, stream, pool, monkeypatch, head, gain=1.0, behind=1.0):
        self.stream, self.pool, self.head, self.passes, self.exposed = stream, pool, head, 1.0, []
        monkeypatch.setattr(
            gobo_photos, "through_camera", lambda exposed, rng: np.clip(exposed, 0, 1).astype(np.float32)
        )
        monkeypatch.setattr(gobo_photos, "_SHADOWED_SHARE", 1.0)
        monkeypatch.setattr(
            gobo_photos, "sample_background", lambda size, *how: np.full((size, size, 3), behind, np.float32)
        )
        monkeypatch.setattr(gobo_photos, "sample_gobo", lambda *how: np.full((SIZE, SIZE), self.passes, np.float32))
        monkeypatch.setattr(
            gobo_photos, "camera_gain", lambda *seen: self.exposed.append(seen[:3]) or np.full(3, gain, np.float32)
        )

    def samples(self, count, passes):
        self.passes = passes
        self.exposed.clear()
        return [self.stream._sample({0: self.head}, 0, self.pool, np.random.default_rng(seed)) for seed in range(count)]


@pytest.fixture
def studio(tmp_path, pool, monkeypatch):
    write_balls(tmp_path / "heads", 0, 1, size=SIZE)
    write_lights(tmp_path / "lights.npz", 6)
    stream = GoboStream(tmp_path / "heads", tmp_path / "lights.npz", "train", SIZE, 7)
    return lambda head, **how: Studio(stream, pool, monkeypatch, head, **how)


LIGHTS = 5
LEFT = np.zeros((SIZE, SIZE), np.float32)
LEFT[4:28, 3:17] = 1
"""A head left of the middle."""


def head_of(radiance=lambda paint, light: 1.0, covered=LEFT):
    seen = np.zeros((3, LIGHTS, SIZE, SIZE, 3), np.float16)
    for paint in range(3):
        for light in range(LIGHTS):
            seen[paint, light] = radiance(paint, light) * covered[..., None]
    lights = np.arange(LIGHTS, dtype=np.float32)[:, None, None, None] * np.ones((16, 32, 3), np.float32)
    normal = np.dstack([0 * covered, 0 * covered, covered])
    channels = {"normal": normal, "relief": 0.1 * covered, "label": covered.astype(np.int64), "covered": covered}
    return PaintedHead(seen, lights, channels)


def middle(sample):
    """The photo's colour in the middle of the person, (3,)."""
    inside = -torch.nn.functional.max_pool2d(-sample["person"][None], 5, 1, 2)[0, 0] > 0.5
    return sample["photo_srgb"][:, inside].median(1).values.numpy()


def test_a_shadow_leaves_between_a_twentieth_and_three_fifths_of_the_light_and_the_more_of_the_sky_s_blue(studio):
    scene = studio(head_of(), gain=0.3)
    dark, lit = (np.array([middle(sample) for sample in scene.samples(60, passes)]) for passes in (0.0, 1.0))
    # Of one light all over, what is left of the lamp and what always arrives make up nearly all.
    left = dark[:, 1] / lit[:, 1]
    assert 0.03 < left.min() < 0.12
    assert 0.45 < left.max() < 0.7
    assert 0.05 < np.log(dark[:, 2] / dark[:, 0]).mean() < 0.3


def test_the_lamp_s_own_light_and_another_are_what_is_left_in_a_shadow(studio):
    powers = 10.0 ** (2 * np.arange(LIGHTS) - 4)
    scene = studio(head_of(lambda paint, light: powers[light] * np.eye(3)[paint]), gain=1e-5)
    lit = [middle(sample) for sample in scene.samples(100, 1.0)]
    dark = [middle(sample) for sample in scene.samples(100, 0.0)]
    lamps = [int(light.mean().round()) for _, _, light in scene.exposed]
    assert set(lamps) == {0, 1, 2, 3, 4}
    assert {int(photo.argmax()) for photo in lit} == {0, 1, 2}
    weakest, strongest = (
        [
            (one.max() / 1e-5 / powers[which], other.max() / 1e-5 / powers[which])
            for one, other, lamp in zip(lit, dark, lamps, strict=True)
            if lamp == which
        ]
        for which in (0, 4)
    )
    # Where another light is the stronger one, it is there; where the lamp is, its stray light.
    assert max(left for _, left in weakest) > 5
    assert max(left for _, left in strongest) > 0.1
    for without, left in strongest:
        assert 0.35 < without - left < 1


def test_a_camera_exposes_for_the_person_as_it_is_in_the_shadow(studio):
    scene = studio(head_of())
    scene.samples(10, 1.0)
    lit = [radiance.max() for radiance, _, _ in scene.exposed]
    people = [sample["person"][0].numpy() > 0 for sample in scene.samples(10, 0.0)]
    for before, (radiance, person, _), covered in zip(lit, scene.exposed, people, strict=True):
        assert radiance.max() < 0.8 * before
        assert 0.1 < person.mean() < 0.5
        assert not person[~covered].any()


def test_heads_are_mirrored_and_warped(studio):
    people = [sample["person"][0].numpy() for sample in studio(head_of()).samples(30, 1.0)]
    on_the_left = np.mean([person[:, :16].sum() > person[:, 16:].sum() for person in people])
    assert 0.2 < on_the_left < 0.8
    assert len({person.tobytes() for person in people}) > 10


def test_half_the_shadows_fall_on_what_lies_behind_too(studio):
    behind = [float(sample["photo_srgb"][:, -1, -1].mean()) for sample in studio(head_of()).samples(60, 0.0)]
    shaded = [level for level in behind if level < 1]
    assert 0.25 < len(shaded) / 60 < 0.75
    assert 0.05 <= min(shaded) < max(shaded) <= 0.6


def test_a_head_that_lies_in_shadow_altogether_is_told_to_have_none(studio):
    for sample in studio(head_of(), gain=0.3, behind=0.0).samples(10, 0.0):
        assert float(sample["foreign_shadow"].abs().max()) < 0.3


def test_what_a_shadow_does_to_what_is_blown_out_either_way_no_camera_records(studio):
    bars = np.ones((SIZE, SIZE))
    bars[::4] = 0
    deep, blown = (
        min(float(sample["foreign_shadow"].min()) for sample in studio(head_of(), gain=gain).samples(10, bars))
        for gain in (0.3, 1000.0)
    )
    assert deep < -0.5
    assert blown > -1e-4


def test_a_head_out_of_the_picture_has_no_shadow(studio):
    for sample in studio(head_of(covered=0 * LEFT)).samples(3, 0.0):
        assert not sample["foreign_shadow"].any()
        assert not sample["person"].any()


def test_how_bright_a_light_is_in_its_library_changes_no_photo(stream, monkeypatch):
    monkeypatch.setattr(gobo_photos, "camera_gain", lambda *seen: np.full(3, 0.3, np.float32))
    sample_lights, samples = gobo_photos.sample_network_lights, []
    for power in (1.0, 10.0):

        def lights(library, rng, count, power=power):
            powers = np.float32(power) ** (np.arange(count, dtype=np.float32) % 3)
            return sample_lights(library, rng, count) * powers[:, None, None, None]

        monkeypatch.setattr(gobo_photos, "sample_network_lights", lights)
        samples.append(some(stream(), 2))
    for one, other in zip(*samples, strict=True):
        torch.testing.assert_close(one["foreign_shadow"], other["foreign_shadow"], atol=0.02, rtol=0)
        assert float((one["photo_srgb"] - other["photo_srgb"]).abs().mean()) < 0.01
