"""People cut out and put before other things: what the person network is shown, and what it is told."""

import numpy as np
import pytest

from relight_core.dataset.cutouts import outlines
from relight_core.dataset.cutouts.cutouts import cut_out, place
from relight_core.dataset.cutouts.outlines import OutlineStream, outline_sample
from relight_core.dataset.cutouts.scenery.pool import SceneryPool
from tests.synthetic_heads import write_balls, write_lights

SIZE = 96
SKIN, HAIR, CLOTH = 1, 10, 13


def bust(bottom=SIZE):
    """A red face, hair on it, a blue bust down to a row; the face's box is 32 pixels, its middle (48, 40)."""
    y, x = np.mgrid[:SIZE, :SIZE] + 0.5
    label = np.zeros((SIZE, SIZE), np.uint8)
    label[(np.abs(x - 48) < 40) & (y > 64) & (y < bottom)] = CLOTH
    label[(np.abs(x - 48) < 18) & (y > 14) & (y < 40)] = HAIR
    label[(np.abs(x - 48) < 16) & (np.abs(y - 40) < 16)] = SKIN
    label[(np.abs(x - 48) < 8) & (y > 50) & (y < 66)] = 9
    colours = np.zeros((14, 3), np.float32)
    colours[[SKIN, 9, HAIR, CLOTH]] = [[0.8, 0.1, 0.1], [0.8, 0.1, 0.1], [0.1, 0.1, 0.1], [0.1, 0.1, 0.8]]
    return colours[label], label > 0, label


def cutout(seed=0, bottom=SIZE):
    return cut_out(*bust(bottom), np.random.default_rng(seed))


def test_a_cutout_knows_its_face():
    person = cutout()
    assert person.face_px == 32
    assert person.centre == (48, 40)
    assert person.known == (np.inf,) * 4


def test_no_face_is_no_cutout():
    radiance, covered, label = bust()
    assert cut_out(radiance, covered, np.where(label == SKIN, HAIR, label), np.random.default_rng(0)) is None


def test_a_person_whom_the_border_cuts_is_known_up_to_there():
    radiance, covered, label = (np.roll(part, -44, 1) for part in bust())
    label[:, 60:], covered[:, 60:] = 0, False
    person = cut_out(radiance, covered, label, np.random.default_rng(0))
    left, top, right, _ = person.known
    assert left == pytest.approx(person.centre[0] / person.face_px)
    assert (top, right) == (np.inf, np.inf)
    assert person.mirrored().known[2] == left


def test_a_mirrored_cutout_is_the_mirror_image():
    person = cutout()
    mirrored = person.mirrored()
    np.testing.assert_array_equal(mirrored.premultiplied, person.premultiplied[:, ::-1])
    assert mirrored.mirrored().centre == person.centre


@pytest.mark.parametrize("face_px", [20.0, 40.0])
def test_a_face_goes_where_it_is_put(pool, face_px):
    placed = place(cutout(), 128, np.array([60.0, 30.0]), face_px, pool, np.random.default_rng(1))
    red = placed[..., 0] > 0.6
    rows, columns = np.nonzero(red[: int(30 + face_px / 2)])
    assert columns.mean() + 0.5 == pytest.approx(60, abs=1)
    assert np.ptp(columns) + 1 == pytest.approx(face_px, abs=3)
    assert (placed[..., :3].max(-1) <= 1.2 * placed[..., 3] + 1e-3)[: int(30 + face_px / 2)].all()


@pytest.mark.parametrize("bottom", [SIZE, 88])
def test_a_bust_gets_a_body_down_to_the_border(pool, bottom):
    placed = place(cutout(bottom=bottom), 160, np.array([80.0, 40.0]), 32.0, pool, np.random.default_rng(2))
    shares = placed[..., 3]
    assert (shares[-1] > 0.5).sum() > 32
    assert (shares[90:].max(1) == 1).all()
    assert shares.max() <= 1


@pytest.mark.parametrize("seed", range(6))
def test_samples_tell_of_the_person_that_is_marked(pool, seed):
    rng = np.random.default_rng(seed)
    people = [cutout(0), cutout(1)]
    sample = outline_sample(people, people[1], 64, SceneryPool(pool, rng, 3), pool, rng)
    photo, inside, face, person = (sample[n].numpy() for n in ("photo_srgb", "inside", "face", "person"))
    assert photo.shape == (3, 64, 64)
    assert person.shape == inside.shape == face.shape == (1, 64, 64)
    assert (person <= inside + 1e-6).all()
    assert (photo[:, inside[0] == 0] == 0).all()
    assert person[face * inside > 0.99].mean() > 0.75
    assert 0.02 < person.mean() < 0.98


def test_what_a_camera_adds_is_never_turned(pool, monkeypatch):
    """Whatever is developed arrives as it was, pixel by pixel, wherever the photo reaches."""
    grain = np.where(np.indices((64, 64)).sum(0) % 2, 0.9, 0.1).astype(np.float32)[..., None].repeat(3, -1)
    monkeypatch.setattr(outlines, "through_camera", lambda exposed, rng: grain)
    person, scenery = cutout(), SceneryPool(pool, np.random.default_rng(1), 3)
    for seed in range(8):
        sample = outline_sample([person], person, 64, scenery, pool, np.random.default_rng(seed))
        photo, whole = sample["photo_srgb"].permute(1, 2, 0).numpy(), sample["inside"][0].numpy() == 1
        assert whole.sum() > 500
        np.testing.assert_allclose(photo[whole], grain[whole], atol=1e-6)


def test_the_stream_goes_on_where_it_is_told_to(tmp_path):
    write_balls(tmp_path / "heads", 0, 2, size=32)
    write_lights(tmp_path / "lights.npz", 6)
    where = (tmp_path / "heads", tmp_path / "lights.npz", "train", 32, 7)
    whole = iter(OutlineStream(*where, pairs=2, heads_at_once=3))
    from_third = iter(OutlineStream(*where, pairs=2, heads_at_once=3, first_batch=30))
    ahead = [next(whole) for _ in range(61)][60]
    again = next(from_third)
    assert ahead.keys() == {"photo_srgb", "inside", "face", "person"}
    for name, value in ahead.items():
        np.testing.assert_array_equal(value.numpy(), again[name].numpy())
