"""Lights and files as people name them: by rig, by file, from home."""

import os
from pathlib import Path

import pytest

from app.engine.places import from_home
from app.engine.sources import LightSource, PhotoSource
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox


@pytest.mark.parametrize(
    ("text", "kind"),
    [("sky.hdr", "panorama"), ("sky.EXR", "panorama"), ("me.jpg", "portrait"), ("ring.png", "portrait")],
)
def test_a_light_in_a_file_is_known_by_its_name_and_named_in_full(tmp_path, monkeypatch, text, kind):
    monkeypatch.chdir(tmp_path)
    assert LightSource.named(text).same_as(LightSource(kind, str(tmp_path / text)))
    assert LightSource.named(f"./{text}").same_as(LightSource.named(str(tmp_path / text)))


def test_a_bundled_light_goes_by_its_name():
    assert LightSource.named("ring").same_as(LightSource("rig", "ring"))
    assert not LightSource("rig", "ring").same_as(LightSource("portrait", "ring"))
    assert not LightSource("rig", "ring").same_as(None)


@pytest.mark.parametrize(
    ("light", "title"),
    [
        (LightSource("own"), "Original"),
        (LightSource("rig", "golden-hour"), "Golden hour"),
        (LightSource("panorama", "/lights/a\nb.c.hdr"), "a\N{REPLACEMENT CHARACTER}b.c"),
    ],
)
def test_a_light_s_title_is_a_line(light, title):
    assert light.title == title


def test_only_panoramas_are_metered_and_soft_boxes_stay_with_the_room_they_are_in():
    box, lamp = SoftBox(), SoftBox(name="key")
    before = LightEdit(level_ev=2.0, base=0.5, warmth=0.3, boxes=(lamp, box), apart=True)
    for kind, metered in (("panorama", True), ("portrait", False), ("rig", False), ("own", False)):
        opened = LightSource(kind, "x").opened_around(before)
        assert opened == LightEdit(base=0.5, boxes=(box,), metered=metered)
    assert LightSource("rig", "x").opened_around(LightEdit(base=0.5)) == LightEdit()


def test_a_photo_s_name_is_a_line():
    assert PhotoSource(Path("/shoot/a\x1bb.jpg")).name == "a\N{REPLACEMENT CHARACTER}b.jpg"


def test_only_a_tilde_alone_is_home(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert from_home(Path("~/out/a.png")) == tmp_path / "out" / "a.png"
    for name in ("~me.png", "out/~/a.png", f"~{os.environ.get('USER', 'root')}/a.png", "/x/~"):
        assert from_home(Path(name)) == Path(name)
