"""Our own file dialog in the real window, whatever is typed into it."""

import glfw
import pytest

from app.ui.asking import FileRequest
from app.ui.file_dialogs import candidates


@pytest.mark.parametrize("kind", ["open", "save", "folder"])
@pytest.mark.parametrize("ending", ["", "/", "/a.png"])
def test_a_name_too_long_for_any_file_is_only_not_there(opened, tmp_path, kind, ending):
    state, chosen = opened.window.state, []
    state.picking = FileRequest(kind, "A file", tmp_path / "x", chosen.append, text=f"{tmp_path}/{'x' * 300}{ending}")
    opened.frames(3)
    opened.key(glfw.KEY_ENTER)
    assert kind == "save" or (state.picking is not None and chosen == [])
    assert candidates(f"{tmp_path}/{'x' * 300}{ending}", ()) == []
