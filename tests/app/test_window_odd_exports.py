"""Pictures of a photo whose name is no text: they lie beside it, under its own name."""

import os
import sys

import glfw
import pytest
from PIL import Image

from app.engine.sources import LightSource
from app.ui.export_name import choose_form

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="names are text in Unicode there")

ODD, SHOWN = os.fsdecode(b"f\xe9te"), "f\N{REPLACEMENT CHARACTER}te"


def test_exports_of_every_kind_lie_beside_the_photo_and_the_title_names_it(hand, photo_path, monkeypatch):
    window, titles = hand.window, []
    monkeypatch.setattr(glfw, "set_window_title", lambda _handle, title: titles.append(title))
    odd_photo = photo_path.rename(photo_path.with_name(f"{ODD}.png"))
    window.state.open_photo(odd_photo)
    window.state.choose_light(LightSource("portrait", str(odd_photo)))
    hand.settle()
    for form in (".png", ".exr"):
        choose_form(window.state, form)
        hand.key(glfw.KEY_E)
    window.exporter.close()
    assert titles[-1] == f"{SHOWN}.png \N{EN DASH} relight"
    with Image.open(odd_photo.with_name(f"{ODD}-relit.png")) as picture:
        assert picture.text["relightLight"] == SHOWN
    assert odd_photo.with_name(f"{ODD}-relit.exr").stat().st_size > 0
