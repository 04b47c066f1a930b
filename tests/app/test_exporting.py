"""Names for exports: never over anything, never into the program's own folders."""

import os
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from app.engine.exporting import ExportJob, ExportSettings, default_export_path, export, free_path
from app.engine.jobs import Cancelled, JobStatus
from app.ui.viewport import progress_card
from relight_core.errors import InputError
from relight_core.imaging.read import read_radiance
from relight_core.imaging.write import cut
from relight_core.pipeline.edit import Edit


def test_the_first_free_number_is_taken(tmp_path):
    wish = tmp_path / "a.b-relit.png"
    assert free_path(wish) == wish
    wish.touch()
    assert free_path(wish).name == "a.b-relit-2.png"
    (tmp_path / "a.b-relit-2.png").touch()
    assert free_path(wish).name == "a.b-relit-3.png"
    (tmp_path / "a.jpg").touch()
    assert free_path(tmp_path / "a.jpg").name == "a-2.jpg"


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


@pytest.fixture
def picture(tmp_path):
    """One that was made small for the screen; the whole of it is 200 rows high."""
    large, small = np.full((200, 60, 3), 0.5, np.float32), np.full((20, 6, 3), 0.5, np.float32)
    full = SimpleNamespace(in_bands=lambda wide: cut(large, None), has_alpha=False, size=(200, 60))
    relit = SimpleNamespace(image=small, alpha=None, channels={}, full=full)
    opened = SimpleNamespace(photo=SimpleNamespace(linear=large, exif=None, path=tmp_path / "photo.png"))
    light = SimpleNamespace(source=SimpleNamespace(title="Ring"))
    return SimpleNamespace(relit=relit, opened=opened, light=light, edit=Edit())


@pytest.mark.parametrize("has_links", [True, False], ids=["links", "no links"])
def test_what_another_window_has_exported_meanwhile_stays(picture, tmp_path, monkeypatch, has_links):
    def no_links(*_):
        raise OSError(1, "Operation not permitted")

    if not has_links:
        monkeypatch.setattr(os, "link", no_links)
    job = ExportJob(picture, 0.0, tmp_path / "out.png")
    written = export(job, lambda _done, _total: job.path.write_text("theirs"))
    assert written == tmp_path / "out-2.png"
    assert Image.open(written).size == (60, 200)
    assert job.path.read_text() == "theirs"
    assert {path.name for path in tmp_path.iterdir()} == {"out.png", "out-2.png"}


def test_an_export_takes_no_name_that_is_taken_as_it_is_given(picture, tmp_path, monkeypatch):
    wish, link = tmp_path / "out.png", os.link

    def link_after_them(beside, path):
        if not wish.exists():
            wish.write_text("theirs")
        link(beside, path)

    monkeypatch.setattr(os, "link", link_after_them)
    assert export(ExportJob(picture, 0.0, wish)) == tmp_path / "out-2.png"
    assert wish.read_text() == "theirs"


def test_an_export_that_fails_is_told_by_its_own_name(picture, tmp_path):
    with pytest.raises(InputError, match=r"gone/out\.png: there is no folder"):
        export(ExportJob(picture, 0.0, tmp_path / "gone" / "out.png"))


def test_a_name_that_is_too_long_for_the_disk_is_told_in_a_line_and_leaves_nothing(picture, tmp_path):
    with pytest.raises(InputError, match=r"x\.png: can't be written"):
        export(ExportJob(picture, 0.0, tmp_path / f"{300 * 'x'}.png"))
    assert list(tmp_path.iterdir()) == []


def test_a_tilde_is_the_user_s_folder_where_the_photo_may_lie(picture, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "photo.png").write_bytes(b"the photo")
    assert export(ExportJob(picture, 0.0, Path("~/photo.png"))) == tmp_path / "photo-2.png"
    assert export(ExportJob(picture, 0.0, Path("~/other.png"), replaces=True)) == tmp_path / "other.png"
    with pytest.raises(InputError, match="that is the photo itself"):
        export(ExportJob(picture, 0.0, Path("~/photo.png"), replaces=True))
    assert (tmp_path / "photo.png").read_bytes() == b"the photo"


def test_an_export_has_the_photo_s_size_though_a_preview_is_in_force(picture, tmp_path):
    written = export(ExportJob(picture, 0.0, tmp_path / "out.png"))
    assert Image.open(written).size == (60, 200)


def test_exposure_is_seen_in_a_png_and_only_noted_in_an_exr(picture, tmp_path):
    shown = Image.open(export(ExportJob(picture, -1.0, tmp_path / "dim.png")))
    assert shown.getpixel((5, 5)) == (137, 137, 137)
    assert shown.text["relightExposureEv"] == "-1.0"
    radiance = export(ExportJob(picture, -1.0, tmp_path / "dim.exr", ExportSettings(form=".exr", layers=())))
    np.testing.assert_allclose(read_radiance(radiance), 0.5)
    with OpenEXR.File(str(radiance), header_only=True) as file:
        noted = dict(file.header())
    assert noted["relightExposureEv"] == -1.0
    assert noted["relightLight"] == "Ring"


@pytest.mark.parametrize("name", ["photo.png", "link.png"])
def test_an_export_never_replaces_the_photo(picture, tmp_path, name):
    (tmp_path / "photo.png").write_bytes(b"pixels")
    (tmp_path / "link.png").symlink_to(tmp_path / "photo.png")
    with pytest.raises(InputError, match="the photo itself"):
        export(ExportJob(picture, 0.0, tmp_path / name, replaces=True))
    assert (tmp_path / "photo.png").read_bytes() == b"pixels"


@pytest.mark.parametrize("form", [".png", ".jpg", ".tif"])
def test_an_export_says_how_far_it_is_and_one_that_is_cancelled_leaves_nothing(picture, tmp_path, form):
    def step(done, total):
        told.append((done, total))
        if (done, total) == cancel_at:
            raise Cancelled

    told, cancel_at = [], None
    job = ExportJob(picture, 0.0, tmp_path / f"out{form}", ExportSettings(form))
    export(job, step)
    assert told == [(0, 200), (64, 200), (128, 200), (192, 200)]
    cancel_at = (128, 200)
    with pytest.raises(Cancelled):
        export(job, step)
    assert [path.name for path in tmp_path.iterdir()] == [f"out{form}"]


def test_an_export_of_layers_says_how_far_it_is_after_each_and_one_that_is_cancelled_leaves_nothing(picture, tmp_path):
    def step(done, total):
        told.append(done / total)
        if done / total == cancel_at:
            raise Cancelled

    told, cancel_at = [], None
    picture.relit.full, picture.relit.window, picture.relit.channels_together = None, None, list
    picture.relit.image = np.full((128, 6, 3), 0.5, np.float32)
    job = ExportJob(picture, 0.0, tmp_path / "out.exr", ExportSettings(".exr", layers=("albedo", "matte", "shadow")))
    export(job, step)
    assert told == [0.0, 0.125, 0.25, 0.375, 0.5, 0.5, 0.75]
    for share in (0.25, 0.75):
        cancel_at = share
        with pytest.raises(Cancelled):
            export(job, step)
    assert [path.name for path in tmp_path.iterdir()] == ["out.exr"]


def test_a_card_is_shown_for_an_export_only_where_it_takes_its_time():
    quick, long = JobStatus("Export", 150, 200, 0.1), JobStatus("Export", 50, 200, 4.0)
    assert not progress_card._takes_time(quick)
    assert progress_card._takes_time(long)
    assert progress_card.words(long) == "Export   25 %, about 4 s left"
    assert progress_card._takes_time(JobStatus("Turntable"))
    assert progress_card._takes_time(replace(quick, cancelling=True))
    assert progress_card.words(JobStatus("Film", 1, 3, 200.0)) == "Film   1 of 3, about 3 min left"
