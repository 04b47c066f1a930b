"""The engine's thread outlives whatever goes wrong in a step."""

import numpy as np
import pytest
from fake_relighter import FakeRelighter, answered

from app.engine.desk import Desk, Step
from app.engine.engine import Engine
from app.engine.sources import LightSource, PhotoSource, Request
from relight_core.imaging.photo import Photo
from relight_core.imaging.write import write_image
from relight_core.pipeline.edit import Edit

SPLIT = LightSource("rig", "split")


def grey_source(value=0.5):
    return PhotoSource(Photo(np.full((24, 32, 3), value, np.float32)))


class Forgetful(FakeRelighter):
    """Can take the first portrait only once."""

    def set_portrait(self, photo, face_index=None, boxes=None, strokes=()):
        if self.portraits and photo is self.portraits[0][0]:
            raise MemoryError("not enough memory")
        super().set_portrait(photo, face_index, boxes, strokes)


@pytest.fixture
def engine():
    engine = Engine(Forgetful)
    yield engine
    engine.close()


# What a thread dies of is what these tests are about, not a warning beside them.
pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")


def test_a_portrait_that_does_not_come_back_after_a_borrowed_light_is_no_end(engine, tmp_path):
    lender = tmp_path / "lender.png"
    write_image(lender, np.full((24, 32, 3), 0.8, np.float32))
    answered(engine, Request(first := grey_source(0.2), SPLIT, Edit()))
    lost = answered(engine, Request(first, LightSource("portrait", str(lender)), Edit()))
    assert (lost.opened, lost.picture, lost.own_light, lost.faces) == (None, None, None, ())
    assert first in lost.refused
    assert "not enough memory" in lost.message.text
    second = grey_source(0.7)
    assert answered(engine, Request(second, SPLIT, Edit())).picture.opened.source is second


def test_a_photo_that_memory_runs_out_for_is_not_relit_in_the_place_of_the_one_that_stays(engine, monkeypatch):
    first, second = grey_source(0.25), grey_source(0.75)
    answered(engine, Request(first, SPLIT, Edit()))

    def fail(*_):
        raise MemoryError("not enough memory")

    with monkeypatch.context() as patch:
        patch.setattr("app.engine.desk.radiance_for_screen", fail)
        assert answered(engine, Request(second, SPLIT, Edit())).opened.source is first
    picture = answered(engine, Request(second, SPLIT, Edit(yaw_deg=9.0))).picture
    assert picture.opened.source is first
    assert picture.relit.image.max() == 0.25


def test_a_step_that_can_not_even_be_given_up_is_told_and_the_next_request_answered(engine, monkeypatch):
    def fail(now):
        raise RuntimeError("neither way")

    with monkeypatch.context() as patch:
        patch.setattr(Desk, "next_step", lambda self, request, now: Step("Failing", fail, fail))
        said = answered(engine, Request(grey_source(), SPLIT, Edit()))
    assert "neither way" in said.message.text
    assert said.activity is None
    second = grey_source(0.7)
    assert answered(engine, Request(second, SPLIT, Edit())).picture.opened.source is second
