"""Names for exports: never over anything, never into the program's own folders."""

import sys
from pathlib import Path

from app.engine.exporting import default_export_path, free_path


def test_the_first_free_number_is_taken(tmp_path):
    wish = tmp_path / "a.b-relit.png"
    assert free_path(wish) == wish
    wish.touch()
    assert free_path(wish).name == "a.b-relit-2.png"
    (tmp_path / "a.b-relit-2.png").touch()
    assert free_path(wish).name == "a.b-relit-3.png"


def test_a_name_whose_companion_exists_is_not_free(tmp_path):
    (tmp_path / "x-channels.exr").touch()
    assert free_path(tmp_path / "x.exr", "-channels").name == "x-2.exr"


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
