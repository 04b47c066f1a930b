"""What a photo's file says of its making goes into and comes out of TIFF files."""

import numpy as np
import pytest
from PIL import Image

from relight_core.imaging.read import read_photo
from relight_core.imaging.write import FileStyle, cut, write_bands

MODEL, EXPOSURE_TIME, LENS, SENSITIVITY = 272, 33434, 42036, 34855


def block():
    exif = Image.Exif()
    exif[MODEL] = "Some Camera"
    exif[34665] = {EXPOSURE_TIME: 0.005, LENS: "A lens of 85 mm", SENSITIVITY: 400}
    return exif.tobytes()


def said_by(path):
    exif = Image.Exif()
    exif.load(read_photo(path).exif)
    return exif[MODEL], exif.get_ifd(34665)


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("channels", [3, 4])
def test_a_tiff_says_what_the_photo_said(tmp_path, bits, channels):
    image = np.full((9, 7, 3), 0.3, np.float32)
    alpha = np.full((9, 7), 0.5, np.float32) if channels == 4 else None
    path = tmp_path / "out.tif"
    write_bands(path, (9, 7), cut(image, alpha), channels == 4, FileStyle(bits, exif=block()))
    model, inner = said_by(path)
    assert model == "Some Camera"
    assert float(inner[EXPOSURE_TIME]) == pytest.approx(0.005)
    assert (inner[LENS], inner[SENSITIVITY]) == ("A lens of 85 mm", 400)
    np.testing.assert_allclose(read_photo(path).linear, 0.3, atol=0.01)


def test_a_tiff_that_says_nothing_stays_silent(tmp_path):
    path = tmp_path / "out.tif"
    write_bands(path, (4, 4), cut(np.zeros((4, 4, 3), np.float32), None), False, FileStyle(16))
    assert read_photo(path).exif is None
