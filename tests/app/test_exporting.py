"""Names for exports: never over anything, never into the program's own folders."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from PIL import Image

from app.engine.exporting import ExportJob, default_export_path, export, free_path
from relight_core.imaging.write import cut
from relight_core.pipeline.edit import Edit


def test_the_first_free_number_is_taken(tmp_path):
    wish = tmp_path / "a.b-relit.png"
    assert free_path(wish) == wish
    wish.touch()
    assert free_path(wish).name == "a.b-relit-2.png"
    (tmp_path / "a.b-relit-2.png").touch()
    assert free_path(wish).name == "a.b-relit-3.png"


def test_a_dangling_link_is_not_free(tmp_path):
    (tmp_path / "x.png").symlink_to(tmp_path / "nowhere")
    assert free_path(tmp_path / "x.png").name == "x-2.png"


def test_exports_lie_beside_the_photo(tmp_path):
    assert default_export_path(tmp_path / "me.jpeg") == tmp_path / "me-relit.png"


def test_exports_of_an_installed_photo_lie_in_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    installed = Path(sys.prefix) / "lib" / "sample.png"
    assert default_export_path(installed) == tmp_path / "sample-relit.png"
    assert default_export_path(tmp_path / "gone" / "me.png") == tmp_path / "me-relit.png"


def test_an_export_has_the_photo_s_size_though_a_preview_is_in_force(tmp_path):
    large, small = np.full((40, 60, 3), 0.5, np.float32), np.full((20, 30, 3), 0.5, np.float32)
    full = SimpleNamespace(in_bands=lambda wide: cut(large, None), has_alpha=False, size=(40, 60))
    relit = SimpleNamespace(image=small, alpha=None, channels={}, full=full)
    opened = SimpleNamespace(photo=SimpleNamespace(linear=large, exif=None))
    light = SimpleNamespace(source=SimpleNamespace(title="Ring"))
    picture = SimpleNamespace(relit=relit, opened=opened, light=light, edit=Edit())
    written = export(ExportJob(picture, 0.0, tmp_path / "out.png"))
    assert Image.open(written).size == (60, 40)
