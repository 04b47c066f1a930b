"""At rest the engine gets ready for what the hand will ask for."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
from fake_relighter import answered
from opened_things import grey_photo

from app.engine.engine import Engine
from app.engine.sources import LightSource, PhotoSource, Request
from relight_core.errors import InputError
from relight_core.imaging.write import write_image
from relight_core.pipeline.edit import Edit

SPLIT = LightSource("rig", "split")


@pytest.fixture
def engine(relighter):
    engine = Engine(lambda: relighter)
    yield engine
    engine.close()


def test_at_rest_the_engine_gets_ready_for_the_hand_once_for_a_photo_and_a_tier(engine, relighter):
    source, moving = PhotoSource(grey_photo()), Edit(quality="live", channels=())
    answered(engine, Request(source, SPLIT, Edit(), in_motion=moving))
    answered(engine, Request(source, SPLIT, Edit(shadow=0.5), in_motion=replace(moving, shadow=0.5)))
    assert relighter.readied == [moving]
    answered(engine, Request(source, SPLIT, Edit(), in_motion=replace(moving, quality="draft")))
    answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit(), in_motion=moving))
    assert [edit.quality for edit in relighter.readied] == ["live", "draft", "live"]
    answered(engine, Request(source, SPLIT, Edit(yaw_deg=5.0)))
    assert len(relighter.readied) == 3


def test_the_engine_gets_ready_again_once_a_lender_of_light_has_taken_the_portrait_s_place(engine, relighter, tmp_path):
    lender, source, moving = tmp_path / "lender.png", PhotoSource(grey_photo()), Edit(quality="live", channels=())
    write_image(lender, np.full((24, 32, 3), 0.8, np.float32))
    answered(engine, Request(source, SPLIT, Edit(), in_motion=moving))
    answered(engine, Request(source, LightSource("portrait", str(lender)), Edit(), in_motion=moving))
    assert relighter.portraits[-1][0] is source.place
    assert relighter.readied == [moving, moving]


def test_a_photo_that_is_no_longer_open_is_not_kept_for_having_been_got_ready(engine):
    moving = Edit(quality="live", channels=())
    before = weakref.ref(answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit(), in_motion=moving)).opened)
    answered(engine, Request(PhotoSource(grey_photo()), SPLIT, Edit()))
    gc.collect()
    assert before() is None


def test_getting_ready_in_vain_is_tried_once_and_the_picture_stays(engine, relighter, monkeypatch):
    tried = []
    monkeypatch.setattr(relighter, "get_ready", lambda *asked: tried.append(asked) or 1 / 0)
    source, moving = PhotoSource(grey_photo()), Edit(quality="live", channels=())
    answered(engine, Request(source, SPLIT, Edit(), in_motion=moving))
    after = answered(engine, Request(source, SPLIT, Edit(yaw_deg=9.0), in_motion=moving))
    assert len(tried) == 1
    assert after.picture.edit.yaw_deg == 9.0


def test_where_relighting_fails_nothing_gets_ready_for_the_hand(engine, relighter):
    relighter.fail_with = InputError("no")
    source, moving = PhotoSource(grey_photo()), Edit(quality="live", channels=())
    answered(engine, Request(source, SPLIT, Edit(), in_motion=moving))
    assert relighter.readied == []
    relighter.fail_with = None
    answered(engine, Request(source, SPLIT, Edit(shadow=0.5), in_motion=moving))
    assert relighter.readied == [moving]
