"""Sessions of photos whatever they are called: what opens can be saved and comes back, as of just that photo."""

import json
import os

import pytest
from PIL import Image

from app.document.document import Document, LightRef, PhotoRef
from app.document.session_file import free_session_path, read_session, saved_session, session_path, write_session
from relight_core.errors import InputError
from relight_core.imaging.files import file_head
from relight_core.imaging.read import is_picture_head, read_photo

ODD = ["me.jfif", "me.jpe", "me", "~me.jpg", "~", "~root.jpg"]
NOT_ON_WINDOWS = pytest.mark.skipif(os.name == "nt", reason="no such names there")


def picture(path, kind="JPEG"):
    Image.new("RGB", (8, 8), (120, 80, 60)).save(path, kind)
    return path


@pytest.mark.parametrize("name", [*ODD, pytest.param("a:b.jpg", marks=NOT_ON_WINDOWS)])
@pytest.mark.parametrize("relative", [True, False])
def test_a_photo_that_opens_has_sessions_that_open(tmp_path, name, relative):
    photo = picture(tmp_path / name)
    assert read_photo(photo).linear.shape == (8, 8, 3)
    document = Document(PhotoRef(photo), LightRef("portrait", str(photo)))
    path = session_path(photo)
    write_session(path, document, relative=relative)
    assert read_session(path).document == document
    assert saved_session(photo) == path


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "TIFF", "WEBP", "BMP", "GIF", "AVIF"])
def test_a_picture_is_known_by_its_first_bytes(tmp_path, kind):
    assert is_picture_head(file_head(picture(tmp_path / "me", kind)))


@pytest.mark.parametrize("content", [b"root:x:0:0::/root:/bin/sh\n" * 4, b"x", b"\x7fELF" + bytes(60)])
def test_a_session_names_nothing_that_is_no_picture(tmp_path, content):
    path = tmp_path / "me.relight.json"
    write_session(path, Document(PhotoRef(picture(tmp_path / "me.jpg"))))
    (tmp_path / "secret").write_bytes(content)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"photo": "secret"}))
    with pytest.raises(InputError, match="not a kind of picture"):
        read_session(path)


def test_a_session_is_offered_only_for_the_photo_it_names(tmp_path):
    photo, other = picture(tmp_path / "img.jpg"), picture(tmp_path / "img.png", "PNG")
    path = tmp_path / "img.relight.json"
    write_session(path, Document(PhotoRef(photo)))
    assert saved_session(photo) == path
    assert saved_session(other) is None
    (tmp_path / "sub").mkdir()
    assert saved_session(tmp_path / "sub" / ".." / "img.jpg").samefile(path)


def test_both_of_two_photos_of_one_name_have_a_session_that_is_offered(tmp_path):
    photo, other = picture(tmp_path / "img.jpg"), picture(tmp_path / "img.png", "PNG")
    write_session(session_path(photo), Document(PhotoRef(photo)))
    beside = free_session_path(session_path(other), other)
    write_session(beside, Document(PhotoRef(other)))
    assert beside.name == "img-png.relight.json"
    assert saved_session(other) == beside
    assert saved_session(photo) == session_path(photo)


def test_of_several_sessions_of_a_photo_the_newest_is_offered(tmp_path):
    photo = picture(tmp_path / "img.jpg")
    paths = [session_path(photo)]
    write_session(paths[0], Document(PhotoRef(photo)))
    for _ in range(3):
        paths.append(free_session_path(session_path(photo), photo))
        write_session(paths[-1], Document(PhotoRef(photo)))
    for newest in paths:
        for path in paths:
            os.utime(path, (1e9, 1e9))
        os.utime(newest, (2e9, 2e9))
        assert saved_session(photo) == newest


@pytest.mark.parametrize(("name", "free"), [("img", "img-jpg-2"), ("mine", "mine-2"), ("v1.2", "v1.2-2")])
def test_a_name_that_is_taken_gets_a_number_before_the_ending_of_a_session(tmp_path, name, free):
    for taken in (name, "img-jpg"):
        (tmp_path / f"{taken}.relight.json").touch()
    path = free_session_path(tmp_path / f"{name}.relight.json", tmp_path / "img.jpg")
    assert path == tmp_path / f"{free}.relight.json"
