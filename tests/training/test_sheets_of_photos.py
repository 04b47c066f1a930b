"""Sheets of samples of the networks that learn from single photos: what they found beside what is true."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from relight_core.lighting.reflection import ReflectionTable
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
