"""The status line's words."""

import pytest

from app.ui.panels.status_line import brief


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        ("/home/me/photos/a.jpg: not an image; use a JPEG", "a.jpg: not an image; use a JPEG"),
        ("Saved /home/me/a.png", "Saved /home/me/a.png"),
        ("/home/me/relit: 1 photo is missing\n/home/me/a.jpg: not an image", "relit: 1 photo is missing"),
        ("a.jpg: no face found", "a.jpg: no face found"),
        ("/: no photos in this folder", "/: no photos in this folder"),
        ("The graphics driver failed: it was started again", "The graphics driver failed: it was started again"),
    ],
)
def test_a_file_is_told_by_its_name(message, shown):
    assert brief(message) == shown
