"""A batch over the queue in the real window that relights each photo as it was left."""

from dataclasses import replace

import glfw
import numpy as np
import pytest
from PIL import Image

from app.document.document import Document, LightRef, PhotoRef
from app.document.session_file import session_path, write_session
from app.engine.sources import LightSource
from relight_core.imaging.write import write_image
from relight_core.pipeline.edit import Edit


def noted(folder):
    """What the pictures in a folder say of how they were made: light, shadow, background."""
    notes = {}
    for path in folder.iterdir():
        with Image.open(path) as picture:
            text = picture.text
        notes[path.name] = text["relightLight"], float(text["relightShadow"]), text["relightBackground"]
    return notes


@pytest.fixture
def shoot(tmp_path):
    """Three photos in a folder of their own, each darker than the one before."""
    folder = tmp_path / "shoot"
    folder.mkdir()
    paths = [folder / name for name in ("a.png", "b.png", "c.png")]
    for path, value in zip(paths, (0.4, 0.3, 0.2), strict=True):
        write_image(path, np.full((96, 128, 3), value, np.float32))
    return paths


@pytest.fixture
def queue(hand, shoot):
    """The second photo of the queue is open, in neon light; the first was left with a deep shadow and no background."""
    hand.window.on_drop(None, [str(path) for path in shoot], hand.centre())
    hand.settle()
    hand.window.state.change(shadow=1.5, background="transparent")
    hand.settle()
    hand.window.state.step_photo(1)
    hand.settle()
    hand.window.state.change(shadow=0.5, background="keep")
    hand.light("neon")
    return hand


def batch(hand, answer=None):
    hand.key(glfw.KEY_B, ctrl=True, shift=True)
    if answer is not None:
        (question,) = hand.window.state.asking.questions
        answers = [label for label, _ in question.choices]
        hand.window.state.asking.answer(question, answers.index(answer))
        hand.settle()
    hand.window.exporter._pool.submit(lambda: None).result(60)
    hand.settle()


def test_each_photo_is_relit_as_it_was_left_and_one_that_was_not_opened_like_the_one_that_is(queue, shoot):
    batch(queue, "Relight all 3")
    left, now = ("Rembrandt", 1.5, "transparent"), ("Neon", 0.5, "keep")
    assert noted(shoot[0].parent / "relit") == {"a.png": left, "b.png": now, "c.png": now}
    assert queue.window.state.message().text.startswith("3 photos relit.")


def test_photos_that_were_not_opened_can_be_left_out(queue, shoot):
    batch(queue, "Cancel")
    assert not (shoot[0].parent / "relit").exists()
    batch(queue, "Only the other 2")
    assert sorted(noted(shoot[0].parent / "relit")) == ["a.png", "b.png"]


def test_once_all_were_opened_nothing_is_asked_until_their_pictures_are_there(queue, shoot):
    queue.key(glfw.KEY_PAGE_DOWN)
    queue.window.state.change(shadow=0.8)
    queue.settle()
    batch(queue)
    shadows = {name: shadow for name, (_, shadow, _) in noted(shoot[0].parent / "relit").items()}
    assert shadows == {"a.png": 1.5, "b.png": 0.5, "c.png": 0.8}
    queue.window.state.change(shadow=0.9)
    queue.settle()
    batch(queue, "Replace")
    shadows = {name: shadow for name, (_, shadow, _) in noted(shoot[0].parent / "relit").items()}
    assert shadows == {"a.png": 1.5, "b.png": 0.5, "c.png": 0.9}


def test_a_borrowed_light_is_borrowed_again_for_the_photo_that_was_left_in_it(queue, relighter, photo_path, shoot):
    queue.key(glfw.KEY_PAGE_DOWN)
    queue.window.state.open_light(LightSource("portrait", str(photo_path)))
    queue.settle()
    queue.key(glfw.KEY_PAGE_UP)
    queue.light("rim")
    relighter.portraits.clear()
    relighter.environments.clear()
    batch(queue)
    portraits = [photo.path for photo, *_ in relighter.portraits]
    assert portraits == [*shoot[:2], photo_path, shoot[2]]
    assert [light.name for light in relighter.environments] == ["rembrandt", "rim", "estimated"]


def test_a_photo_whose_light_is_gone_fails_alone(queue, photo_path, shoot):
    queue.key(glfw.KEY_PAGE_DOWN)
    queue.window.state.open_light(LightSource("portrait", str(photo_path)))
    queue.settle()
    queue.key(glfw.KEY_PAGE_UP)
    queue.light("rim")
    photo_path.unlink()
    batch(queue)
    assert sorted(noted(shoot[0].parent / "relit")) == ["a.png", "b.png"]
    message = queue.window.state.message()
    assert message.is_error
    assert "1 could not be relit: c.png" in message.text
    assert photo_path.name in message.text


def saved(photo, light, shadow):
    """The session that an earlier run has saved of a photo."""
    document = Document(PhotoRef(photo), LightRef("rig", light), edit=replace(Edit(), shadow=shadow))
    write_session(session_path(photo), document)


@pytest.fixture
def saved_queue(hand, shoot):
    """Each photo but the first has a session; the first is open under the light and the sliders of a new document."""
    saved(shoot[1], "neon", 1.5)
    saved(shoot[2], "rim", 0.5)
    hand.window.on_drop(None, [str(path) for path in shoot], hand.centre())
    hand.settle()
    return hand


_SAVED = {
    "a.png": ("Rembrandt", 1.0, "keep"),
    "b.png": ("Neon", 1.5, "keep"),
    "c.png": ("Rim", 0.5, "keep"),
}


@pytest.mark.parametrize("looks_at", [0, 1, 2])
def test_photos_not_opened_or_only_looked_at_are_relit_as_their_sessions_say(saved_queue, shoot, looks_at):
    for _ in range(looks_at):
        saved_queue.window.state.step_photo(1)
        saved_queue.settle()
    batch(saved_queue)
    assert noted(shoot[0].parent / "relit") == _SAVED


def test_a_session_that_was_put_aside_and_one_that_was_changed_do_not_count(saved_queue, shoot):
    asking, state = saved_queue.window.state.asking, saved_queue.window.state
    state.step_photo(1)
    saved_queue.settle()
    asking.answer(asking.questions[-1], 1)
    state.step_photo(1)
    saved_queue.settle()
    state.change(shadow=0.8)
    saved_queue.settle()
    batch(saved_queue)
    now = "Rembrandt", 1.0, "keep"
    assert noted(shoot[0].parent / "relit") == {"a.png": now, "b.png": now, "c.png": ("Rembrandt", 0.8, "keep")}


def test_a_session_whose_light_is_gone_fails_alone(saved_queue, shoot, tmp_path):
    lost = tmp_path / "lost.png"
    lost.write_bytes(shoot[0].read_bytes())
    write_session(session_path(shoot[1]), Document(PhotoRef(shoot[1]), LightRef("portrait", str(lost))))
    lost.unlink()
    batch(saved_queue)
    assert sorted(noted(shoot[0].parent / "relit")) == ["a.png", "c.png"]
    message = saved_queue.window.state.message().text
    assert "1 could not be relit: b.png" in message
    assert "lost.png" in message
