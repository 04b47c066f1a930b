"""Files whose names are no text: bytes that no encoding knows."""

import os
import sys

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.imaging.formats.exr import exr_size
from relight_core.imaging.read import read_photo
from relight_core.imaging.write import write_exr_layers, write_image

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="names are text in Unicode there")

GREY = np.full((4, 8, 3), 0.5, np.float32)


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / os.fsdecode(b"sh\xffoot")
    folder.mkdir()
    return folder


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
def test_pictures_are_written_and_read(folder, suffix):
    path = folder / f"me{suffix}"
    write_image(path, GREY)
    assert read_photo(path).linear.shape == GREY.shape


def test_exr_files_are_refused_in_a_line(folder, tmp_path):
    with pytest.raises(InputError, match="no text"):
        write_image(folder / "me.exr", GREY)
    with pytest.raises(InputError, match="no text"):
        write_exr_layers(folder / "me.exr", {"RGB": GREY}, half=True, header={})
    assert list(folder.iterdir()) == []
    write_image(tmp_path / "sky.exr", GREY)
    (tmp_path / "sky.exr").rename(folder / "sky.exr")
    with pytest.raises(InputError, match="rename"):
        exr_size(folder / "sky.exr")
