"""Painted skins: carried from one head to another, kept beside the heads, drawn in a share of samples."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from PIL import Image
from synthetic_heads import ball, write_balls, write_head_model, write_lights

from relight_core.dataset import stream
from relight_core.dataset.baking.scene import Material
from relight_core.dataset.heads import load_head_model
from relight_core.dataset.painting import skin_transfer
from relight_core.dataset.painting.skin import paint
from relight_core.dataset.painting.skin_textures import SkinTextures, load_skins, write_skins
from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.stream import SampleStream
from relight_core.errors import InputError


def two_skins(size=16):
    """A bright and a dark skin, each with a red face tile and a green back."""
    fine = np.zeros((2, 2, size, size, 3), np.uint8)
    fine[0], fine[1] = 200, 60
    fine[:, 0, ..., 0] += 40
    fine[:, 1, ..., 1] += 40
    return SkinTextures(("bright", "dark"), fine, fine[:, :, ::4, ::4].copy())


def test_skins_come_back_and_a_folder_may_have_none(tmp_path):
    assert load_skins(tmp_path) is None
    write_skins(tmp_path, two_skins())
    back = load_skins(tmp_path)
    assert back.names == ("bright", "dark")
    np.testing.assert_array_equal(back.fine, two_skins().fine)
    np.testing.assert_array_equal(back.smooth, two_skins().smooth)


def test_skins_that_were_cut_are_an_input_error(tmp_path):
    path = write_skins(tmp_path, two_skins())
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(InputError, match=r"skins\.npz"):
        load_skins(tmp_path)


@pytest.mark.parametrize(
    "changed",
    [
        {"version": 99},
        {"version": [1, 1]},
        {"names": "bright"},
        {"names": np.array([], str)},
        {"fine": np.zeros((2, 1, 16, 16, 3), np.uint8)},
        {"fine": np.zeros((2, 2, 16, 16, 4), np.uint8)},
        {"fine": np.zeros((2, 2, 16, 12, 3), np.uint8)},
        {"smooth": np.zeros((2, 2, 0, 0, 3), np.uint8)},
        {"smooth": np.zeros((2, 2, 4, 4, 3), np.float32)},
        {"smooth": np.zeros((1, 2, 4, 4, 3), np.uint8)},
    ],
)
def test_skins_of_another_version_or_shape_are_an_input_error(tmp_path, changed):
    path = write_skins(tmp_path, two_skins())
    with np.load(path) as data:
        arrays = dict(data)
    np.savez(path, **arrays | changed)
    with pytest.raises(InputError, match=r"skins\.npz: skins of another version or shape"):
        load_skins(tmp_path)


def test_neither_tile_bleeds_into_the_other():
    skins = two_skins()
    corners = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [0.5, 0.0], [0.5, 1.0]], np.float32)
    face = skins.colour(0, corners, np.zeros(6, bool))
    back = skins.colour(0, corners, np.ones(6, bool))
    np.testing.assert_allclose(face - face[0], 0, atol=1e-6)
    np.testing.assert_allclose(back - back[0], 0, atol=1e-6)
    assert face[0, 0] > face[0, 1]
    assert back[0, 1] > back[0, 0]
    assert skins.tone(0)[0] == pytest.approx(face[0, 0], rel=1e-3)
    assert skins.colour(1, corners[:0], np.zeros(0, bool)).shape == (0, 3)


def test_a_skin_stands_upright_and_its_tone_is_that_of_the_middle_of_the_face():
    fine = np.full((1, 2, 16, 16, 3), 60, np.uint8)
    fine[:, :, :8] = 200
    smooth = fine[:, :, ::4, ::4].copy()
    smooth[0, 0, :, [0, 3]] = smooth[0, 0, [0, 3]] = 255
    skins = SkinTextures(("one",), fine, smooth)
    corners = np.array([[0.5, 0.9], [0.5, 0.1]], np.float32)
    bright, dark = (0.5776, 0.0452)
    for on_back in (False, True):
        np.testing.assert_allclose(skins.colour(0, corners, np.full(2, on_back))[:, 0], [bright, dark], atol=1e-3)
    np.testing.assert_allclose(skins.tone(0), (bright + dark) / 2, atol=1e-3)


def test_painted_skins_are_drawn_for_a_share_of_heads_alone():
    head = ball(16)
    pool = TexturePool(np.random.default_rng(0), count=2, skins=two_skins())
    albedos = [paint(head, pool, np.random.default_rng(seed), wild=False) for seed in range(24)]
    assert all(((a >= 0.015) & (a <= 0.95)).all() for a in albedos)
    np.testing.assert_array_equal(albedos[3], paint(head, pool, np.random.default_rng(3), wild=False))
    pool.skins = None
    plain = [paint(head, pool, np.random.default_rng(seed), wild=False) for seed in range(24)]
    assert len({float(a.mean()) for a in albedos + plain}) == 48


def test_three_heads_in_ten_have_a_painted_skins_colours_on_the_face_and_others_on_the_back():
    """Half have a painted skin, two in five of these its detail alone; both skins here are green at the back."""
    head = ball(16)
    back = head.normal[:, 1] < 0
    head = replace(head, material=np.where(back, Material.HEAD, Material.FACE).astype(np.uint8))
    pool = TexturePool(np.random.default_rng(0), count=2, skins=two_skins())
    greener = []
    for seed in range(100):
        albedo = np.log(paint(head, pool, np.random.default_rng(seed), wild=False))
        on_back, on_face = (np.median(albedo[where, 1] - albedo[where, 0]) for where in (back, ~back))
        greener.append(on_back - on_face)
    assert np.mean(np.array(greener) > 0.2) == pytest.approx(0.3, abs=0.08)
    assert np.mean(np.array(greener) < -0.2) < 0.05


def test_the_stream_is_a_function_of_its_place_with_skins_too(tmp_path, monkeypatch):
    monkeypatch.setattr(stream, "TexturePool", partial(TexturePool, count=2))
    write_balls(tmp_path / "heads", 0, 3)
    write_lights(tmp_path / "lights.npz", 40)

    def photos(first_batch):
        samples = SampleStream(
            tmp_path / "heads",
            tmp_path / "lights.npz",
            "train",
            16,
            7,
            lights_per_head=2,
            paints_per_head=4,
            heads_at_once=3,
            first_batch=first_batch,
            pairs=2,
        )
        items = iter(samples)
        return [next(items)["albedo"].numpy() for _ in range(4)]

    without = photos(0)
    write_skins(tmp_path / "heads", two_skins())
    whole = photos(0)
    np.testing.assert_array_equal(whole[2], photos(1)[0])
    assert any(not np.array_equal(a, b) for a, b in zip(without, whole, strict=True))


def test_colours_arrive_at_the_same_place_of_the_other_head(tmp_path, monkeypatch):
    """The MakeHuman head is the model's own face, with texture coordinates mirrored and turned."""
    write_head_model(tmp_path / "model.npz")
    model = load_head_model(tmp_path / "model.npz")
    face = model.triangles[model.triangle_region == 0]
    uv = model.uv[: face.max() + 1]
    lines = ["v {} {} {}".format(*(place / 10)) for place in model.mean]
    lines += [f"vt {v} {1 - u}" for u, v in uv] + ["g body"]
    lines += ["f " + " ".join(f"{v + 1}/{v + 1}" for v in triangle) for triangle in face]
    (tmp_path / "3dobjs").mkdir()
    (tmp_path / "3dobjs" / "base.obj").write_text("\n".join(lines))
    across, up = np.meshgrid((np.arange(64) + 0.5) / 64, 1 - (np.arange(64) + 0.5) / 64)
    stripes = 0.5 + 0.4 * np.sign(np.sin(2 * np.pi * 8 * across))  # 2 cm wide, or a little more
    picture = np.stack([1 - up, across, stripes], -1)
    folder = tmp_path / "skins" / "someone" / "textures"
    folder.mkdir(parents=True)
    Image.fromarray(np.round(picture * 255).astype(np.uint8)).save(folder / "someone_diffuse.png")

    monkeypatch.setattr(skin_transfer, "HeadWarp", lambda base, faces, model: lambda points: points)
    skins = skin_transfer.transfer_skins(tmp_path, model, 32)
    assert skins.names == ("someone",)
    u, v = np.meshgrid((np.arange(32) + 0.5) / 32, 1 - (np.arange(32) + 0.5) / 32)
    found = skins.fine[0, 0] / 255
    np.testing.assert_allclose(found[3:-3, 3:-3, 0], u[3:-3, 3:-3], atol=0.03)
    np.testing.assert_allclose(found[3:-3, 3:-3, 1], v[3:-3, 3:-3], atol=0.03)
    assert np.abs(np.diff(skins.smooth[0, 0].astype(float), axis=0)).max() < 80
    assert found[3:-3, 3:-3, 2].std() > 0.32
    assert (skins.smooth[0, 0, 1:-1, 1:-1, 2] / 255).std() < 0.1
    (folder / "torn_diffuse.png").write_bytes((folder / "someone_diffuse.png").read_bytes()[:60])
    with pytest.raises(InputError, match=r"torn_diffuse\.png: can't be read"):
        skin_transfer.transfer_skins(tmp_path, model, 32)
