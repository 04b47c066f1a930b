"""What waits for a finished picture gets none that shows the faces as they were before."""

from dataclasses import replace
from pathlib import Path

from opened_things import open_light, opened_for

from app.engine.snapshot import Picture, Snapshot
from app.ui.state import EditorState
from app.window.finished import Finished


def test_a_picture_of_the_faces_as_they_were_is_not_handed_out():
    state, said, given = EditorState(), [], []
    state.open_photo(Path("/photos/us.jpg"))
    opened, light = opened_for(state.photo), open_light(state.light)
    picture = Picture(opened, light, state.request_at_rest().edit, None, None, opened.screen, {}, is_stale=True)
    finished = Finished(state, lambda text, is_error: said.append(text))
    finished.then(given.append)
    finished.hand_out(Snapshot(opened=opened, light=light, picture=picture), is_idle=False)
    assert given == []
    relit = replace(picture, is_stale=False)
    finished.hand_out(Snapshot(opened=opened, light=light, picture=relit), is_idle=True)
    assert given == [relit]
    assert said == []
