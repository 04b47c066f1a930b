"""What waits for a finished picture gets none that shows the faces as they were before."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from app.engine.snapshot import OpenLight, OpenPhoto, Picture, Snapshot
from app.ui.state import EditorState
from app.window.finished import Finished
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment


def test_a_picture_of_the_faces_as_they_were_is_not_handed_out():
    state, said, given = EditorState(), [], []
    state.open_photo(Path("/photos/us.jpg"))
    photo = Photo(np.zeros((4, 4, 3), np.float32))
    opened = OpenPhoto(state.photo, photo, photo.linear)
    even = Environment.from_radiance(np.ones((4, 8, 3)), "even")
    light = OpenLight(state.light, even, np.zeros((4, 8, 3), np.uint8), np.zeros((4, 4, 4), np.uint8), even)
    picture = Picture(opened, light, state.request_at_rest().edit, None, None, photo.linear, {}, is_stale=True)
    finished = Finished(state, lambda text, is_error: said.append(text))
    finished.then(given.append)
    finished.hand_out(Snapshot(opened=opened, light=light, picture=picture), is_idle=False)
    assert given == []
    relit = replace(picture, is_stale=False)
    finished.hand_out(Snapshot(opened=opened, light=light, picture=relit), is_idle=True)
    assert given == [relit]
    assert said == []
