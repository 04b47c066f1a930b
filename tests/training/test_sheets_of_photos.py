"""Sheets of samples of the networks that learn from single photos: what they found beside what is true."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch
from small_runs import some_batch

from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.results.channel_view import channel_to_srgb
from relight_core.training import sheet

SIZE, PHOTOS, ROWS = 8, 9, 6


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """Draws a sheet, and gives its columns by their names, (rows, S, S, 3) each."""

    def draw(bundle, batch):
        laid_out = []

        def noted(pictures, columns, cell_px):
            laid_out.extend([pictures, columns])
            return np.zeros((cell_px, cell_px, 3), np.float32)

        monkeypatch.setattr(sheet, "contact_sheet", noted)
        sheet.draw_samples(bundle, ReflectionTable(), batch, tmp_path / "w.samples.png")
        pictures, columns = laid_out
        assert len(pictures) == ROWS * columns
        return {pictures[at][0]: np.stack([image for _, image in pictures[at::columns]]) for at in range(columns)}

    return draw


def image(channels):
    return torch.rand(PHOTOS, channels, SIZE, SIZE)


def shown(values):
    return values[:ROWS].permute(0, 2, 3, 1).numpy()


def test_of_outlines_how_likely_a_person_is_stands_before_the_true_one(drawn):
    batch = {"photo_srgb": image(3), "inside": image(1), "face": image(1), "person": image(1).round()}
    columns = drawn(SimpleNamespace(person=lambda photo, inside, face: 0 * inside + 1.0986123), batch)
    assert list(columns) == ["photo", "person", "true person"]
    np.testing.assert_allclose(columns["photo"], shown(batch["photo_srgb"]))
    np.testing.assert_allclose(columns["person"], 0.75, atol=1e-6)
    np.testing.assert_allclose(columns["true person"], shown(batch["person"].expand(-1, 3, -1, -1)))


def test_of_foreign_shadows_the_light_that_arrives_stands_before_the_true_one_and_is_whole_beside_a_person(drawn):
    person = torch.zeros(PHOTOS, 1, SIZE, SIZE)
    person[..., : SIZE // 2] = 1
    batch = {"photo_srgb": image(3), "kinds": image(4), "person": person, "foreign_shadow": -image(3)}
    columns = drawn(SimpleNamespace(foreign_shadow=lambda photo, kinds: 0 * photo - 0.6931472), batch)
    assert list(columns) == ["photo", "light that arrives", "truth"]
    np.testing.assert_allclose(columns["light that arrives"][:, :, : SIZE // 2], 0.5, atol=1e-6)
    np.testing.assert_allclose(columns["light that arrives"][:, :, SIZE // 2 :], 1, atol=1e-6)
    np.testing.assert_allclose(columns["truth"], np.exp(shown(batch["foreign_shadow"])), rtol=1e-6)


def answering(monkeypatch, width="wide"):
    """Networks that find the same of whatever they are shown."""
    found = SimpleNamespace(
        albedo_srgb=torch.full((ROWS, 3, 16, 16), 0.6),
        normal=torch.tensor([0.6, 0, 0.8])[None, :, None, None].expand(ROWS, 3, 16, 16),
        parsing_logits=torch.nn.functional.one_hot(torch.full((ROWS, 16, 16), 9), 14).permute(0, 3, 1, 2).float(),
    )
    one = torch.ones(ROWS, 1, 16, 16)
    effects = {f"{width} shadows": SimpleNamespace(specular=0.02 * one, shadow=0.1 * one)}
    images = {f"{width} pictures": (0.25 * one).expand(-1, 3, -1, -1)}
    monkeypatch.setattr(sheet, "specular_shadow_losses", lambda network, *_: (effects[network], {}))
    monkeypatch.setattr(sheet, "composition_losses", lambda network, *_: (images[network], {}))
    return SimpleNamespace(
        delight=lambda photo: found,
        config=SimpleNamespace(delight=SimpleNamespace(classes=14)),
        pair=lambda width: SimpleNamespace(specular_shadow=f"{width} shadows", composition=f"{width} pictures"),
    )


def test_of_pairs_every_channel_that_is_found_stands_before_the_true_one(drawn, monkeypatch):
    torch.manual_seed(0)
    batch = some_batch(pairs=4)
    batch["specular"][:], batch["shadow"][:] = 0.04, 0.3
    columns = drawn(answering(monkeypatch), batch)
    photos, albedo = batch["photo_srgb"].flatten(0, 1), batch["albedo"].repeat_interleave(2, 0)
    np.testing.assert_allclose(columns["photo"], shown(photos))
    np.testing.assert_allclose(columns["albedo"], 0.6, atol=1e-6)
    np.testing.assert_allclose(columns["true albedo"], encoded(shown(albedo)), atol=1e-3)
    np.testing.assert_allclose(columns["normals"][..., 0, 0, :], np.tile([0.8, 0.5, 0.9], (ROWS, 1)), atol=1e-3)
    normal = shown(batch["normal"].repeat_interleave(2, 0))
    np.testing.assert_allclose(columns["true normals"], (normal + 1) / 2, atol=1e-3)
    parsing = channel_to_srgb("parsing", np.full((16, 16), 9))
    np.testing.assert_allclose(columns["parsing"], np.broadcast_to(parsing, columns["parsing"].shape))
    label = batch["label"].repeat_interleave(2, 0)[3].numpy()
    np.testing.assert_allclose(columns["true parsing"][3], channel_to_srgb("parsing", label))
    # What is found beside the head, in the first three columns of pixels, is not shown.
    for name, value, true in (("specular", 0.02, 0.04), ("shadow", 0.1, 0.3)):
        expected = np.full((16, 16), value, np.float32)
        expected[:, :3] = 0
        np.testing.assert_allclose(columns[name][0], channel_to_srgb(name, expected), atol=1e-6)
        whole = channel_to_srgb(name, np.full((16, 16), true, np.float32))
        np.testing.assert_allclose(columns[f"true {name}"][0], whole, atol=1e-6)
    np.testing.assert_allclose(columns["image"][:, :, 3:], 0.5371, atol=1e-3)
    true_images = encoded(shown(batch["image"].flatten(0, 1)))
    np.testing.assert_allclose(columns["true image"], true_images, atol=2e-3)


def test_of_examples_the_narrow_pair_s_answers_stand_before_the_wide_one_s(drawn, monkeypatch):
    flat = {name: torch.full((ROWS, 1, 16, 16), value) for name, value in (("specular", 0.04), ("shadow", 0.3))}
    flat |= {"covered": torch.ones(ROWS, 1, 16, 16), "image": torch.rand(ROWS, 3, 16, 16)}
    monkeypatch.setattr(sheet, "under_some_lights", lambda batch: flat)
    columns = drawn(answering(monkeypatch, "narrow"), {"reflected": torch.zeros(1)})
    assert list(columns) == ["specular", "wide specular", "shadow", "wide shadow", "image", "wide image"]
    np.testing.assert_allclose(columns["image"], 0.5371, atol=1e-3)
    np.testing.assert_allclose(columns["wide image"], encoded(shown(flat["image"])), atol=2e-3)


def encoded(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
