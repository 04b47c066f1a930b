"""A light's file that was changed elsewhere is read again when it is dropped or opened again."""

from dataclasses import replace

import numpy as np
import pytest
from fake_relighter import FakeRelighter, answered

from app.engine.engine import Engine
from app.ui.state import EditorState
from app.window.dropped import take_files
from relight_core.imaging.write import write_image


@pytest.fixture
def engine():
    engine = Engine(FakeRelighter)
    yield engine
    engine.close()


def panorama(path, colour):
    write_image(path, np.broadcast_to(np.float32(colour), (8, 16, 3)))
    return path


def answer(engine, state):
    state.accept(answered(engine, state.request()))
    return state.snapshot.light


def redness(light):
    red, _, blue = light.base.shape.mean(axis=(0, 1))
    return red / blue


@pytest.mark.parametrize("where", [(500.0, 300.0), (10.0, 10.0)], ids=["picture", "light panel"])
def test_dropped_again_it_is_as_its_file_is_now_with_what_was_changed_about_it(engine, tmp_path, where):
    state = EditorState(light_panel=(0.0, 0.0, 255.0, 560.0))
    sky = panorama(tmp_path / "sky.exr", (4.0, 1.0, 1.0))
    take_files(state, [sky], *where)
    before = answer(engine, state)
    state.light_edit = replace(state.light_edit, level_ev=1.5)
    answer(engine, state)
    panorama(sky, (1.0, 1.0, 4.0))
    state.choose_light(replace(state.light))
    assert redness(answer(engine, state)) == redness(before), "a click in the list reads nothing"
    take_files(state, [sky], *where)
    after = answer(engine, state)
    assert redness(after) < 1.0 < redness(before)
    assert (after.edit, state.light_edit.level_ev) == (state.light_edit, 1.5)
    assert state.extra_lights == [state.light]


def test_where_the_file_is_gone_by_then_the_light_stays_as_it_was(engine, tmp_path):
    state = EditorState()
    sky = panorama(tmp_path / "sky.exr", (4.0, 1.0, 1.0))
    take_files(state, [sky], 500.0, 300.0, as_light=True)
    before = answer(engine, state)
    sky.unlink()
    take_files(state, [sky], 500.0, 300.0, as_light=True)
    wish = state.light
    assert answer(engine, state) is before
    assert wish in state.snapshot.refused
    assert state.light is before.source
    panorama(sky, (1.0, 1.0, 4.0))
    take_files(state, [sky], 500.0, 300.0, as_light=True)
    assert redness(answer(engine, state)) < 1.0
