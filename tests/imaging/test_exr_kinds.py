"""EXR files of other kinds than lines of red, green and blue floats."""

import numpy as np
import OpenEXR
import pytest

from relight_core.errors import InputError
from relight_core.imaging.read import read_photo


def test_a_deep_exr_is_refused_for_what_it_is(tmp_path):
    samples = np.empty((3, 4), object)
    for place in np.ndindex(3, 4):
        samples[place] = np.ones(2, np.float32)
    header = {"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.deepscanline}
    with OpenEXR.File(header, dict.fromkeys("RGB", samples)) as file:
        file.write(str(tmp_path / "a.exr"))
    with pytest.raises(InputError, match="a deep EXR.*export it flat"):
        read_photo(tmp_path / "a.exr")
