"""relight render: which colours a file has, in which profile, and what of the photo's notes goes along."""

import pytest
from PIL import Image

from relight_core.imaging.formats.icc_making import DISPLAY_P3, primaries_profile

MAKE, MAKER = 0x010F, "Maker"


@pytest.fixture
def phone_photo(photo):
    """The photo in Display P3, with a note of who made the camera."""
    notes = Image.Exif()
    notes[MAKE] = MAKER
    with Image.open(photo) as plain:
        plain.save(photo, icc_profile=primaries_profile(DISPLAY_P3), exif=notes)
    return photo


@pytest.mark.parametrize(
    ("name", "words", "is_wide", "is_in_p3"),
    [
        ("relit.png", "", False, False),
        ("relit.png", "--profile photo", True, True),
        ("relit.jpg", "--profile photo", True, True),
        ("relit.exr", "", True, None),
    ],
)
def test_colours_beyond_srgb_are_in_files_that_hold_them(
    relight, relighter, phone_photo, tmp_path, name, words, is_wide, is_in_p3
):
    output = tmp_path / name
    assert relight("render", phone_photo, "--light", "ring", *words.split(), "-o", output).code == 0
    assert relighter.asked_wide == [is_wide]
    if is_in_p3 is not None:
        with Image.open(output) as picture:
            assert (picture.info.get("icc_profile") == primaries_profile(DISPLAY_P3)) == is_in_p3
            assert picture.getexif()[MAKE] == MAKER
