"""The lights used last, where their files come and go between runs."""

from app.engine.sources import LightSource
from app.ui.state import EditorState
from app.window.recent_lights import RecentLights


def test_a_light_whose_disk_is_away_comes_back_with_it(tmp_path):
    disk, away = tmp_path / "disk", tmp_path / "away"
    disk.mkdir()
    paths = [tmp_path / "a.hdr", disk / "b.hdr", tmp_path / "c.hdr"]
    for path in paths:
        path.write_bytes(b"light")
    lights = [LightSource("panorama", str(path)) for path in paths]
    RecentLights(tmp_path / "recent.json").keep(EditorState(extra_lights=lights[:2]))
    disk.rename(away)
    recent, state = RecentLights(tmp_path / "recent.json"), EditorState()
    recent.recall(state)
    assert [light.title for light in state.extra_lights] == ["a"]
    state.extra_lights.insert(0, lights[2])
    recent.keep(state)
    away.rename(disk)
    later = EditorState()
    RecentLights(tmp_path / "recent.json").recall(later)
    assert [light.title for light in later.extra_lights] == ["c", "a", "b"]


def test_a_light_that_was_away_and_is_taken_off_the_list_again_is_gone(tmp_path):
    path = tmp_path / "disk" / "b.hdr"
    light = LightSource("panorama", str(path))
    RecentLights(tmp_path / "recent.json").keep(EditorState(extra_lights=[light]))
    recent, state = RecentLights(tmp_path / "recent.json"), EditorState()
    recent.recall(state)
    path.parent.mkdir()
    path.write_bytes(b"light")
    state.extra_lights = [light]
    recent.keep(state)
    state.extra_lights = []
    recent.keep(state)
    later = EditorState()
    RecentLights(tmp_path / "recent.json").recall(later)
    assert later.extra_lights == []


def test_a_list_that_can_not_be_written_stops_nothing(tmp_path):
    (tmp_path / "recent.json").mkdir()
    (tmp_path / "file").write_bytes(b"no folder")
    lights = [LightSource("panorama", str(tmp_path / "a.hdr"))]
    for path in (tmp_path / "recent.json", tmp_path / "file" / "recent.json"):
        recent, state = RecentLights(path), EditorState()
        recent.recall(state)
        state.extra_lights = lights
        recent.keep(state)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "recent.json"]
