"""The pixel probe, the panes and the words of the compass: no window needed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from fake_relighter import FakeRelighter

from app.engine.screen import channels_for_screen, radiance_for_screen
from app.engine.snapshot import OpenLight, OpenPhoto, Picture, Snapshot
from app.engine.sources import LightSource, PhotoSource
from app.ui.state import EditorState
from app.ui.viewport.light_ball import words
from app.ui.viewport.panes import arrange_panes, can_compare
from app.ui.viewport.probe import Reading, reading, readings
from app.ui.viewport.probe_card import hint
from app.ui.viewport.view import View, photo_point
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.summary import average_direction
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.results.layers import photo_layers

HEIGHT, WIDTH = 96, 128


@pytest.fixture(scope="module")
def snapshot():
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
    photo = Photo(np.dstack([columns / 200, rows / 200, np.full_like(rows, 0.25)]))
    relighter = FakeRelighter()
    relighter.set_portrait(photo)
    environment = Environment.from_radiance(np.ones((16, 32, 3), np.float32))
    relit = relighter.relight(environment, Edit())
    opened = OpenPhoto(PhotoSource(photo), photo, radiance_for_screen(photo.linear))
    light = OpenLight(LightSource("rig", "even"), environment, None, None, environment)
    channels = channels_for_screen(relit.channels)
    picture = Picture(opened, light, Edit(), None, relit, radiance_for_screen(relit.image), channels)
    return Snapshot(opened=opened, light=light, picture=picture)


def state_of(snapshot, **look):
    state = EditorState()
    state.accept(snapshot)
    for name, value in look.items():
        setattr(state.look, name, value)
    return state


def test_the_probe_reads_every_channel_at_its_place(snapshot):
    rows = {row.name: row for row in readings(snapshot, 1.0, 40.7, 30.2)}
    assert list(rows) == ["photo", "albedo", "normal", "parsing", "specular", "shadow", "composition", "result"]
    assert rows["photo"].linear == pytest.approx((0.2, 0.15, 0.25))
    assert rows["albedo"].linear == pytest.approx((1.0, 0.0, 0.0))
    assert rows["albedo"].codes == (255, 0, 0)
    # The channels show the square from 32, 16: column 8 and row 14 of 64.
    assert rows["specular"].linear == pytest.approx((8 / 63 * 0.2,))
    assert rows["shadow"].linear == pytest.approx((14 / 63 * 0.3,))
    assert rows["parsing"].word == "skin"
    assert rows["parsing"].linear == ()
    assert rows["result"].linear == pytest.approx(tuple(snapshot.picture.relit.image[30, 40]))


def test_exposure_changes_only_what_the_screen_shows_of_the_result(snapshot):
    plain, brighter = (reading(snapshot, "result", stops, 5.0, 5.0) for stops in (0.0, 1.0))
    assert plain.linear == brighter.linear
    assert brighter.codes[2] > plain.codes[2]
    assert reading(snapshot, "photo", 0.0, 5.0, 5.0) == reading(snapshot, "photo", 1.0, 5.0, 5.0)


def test_the_result_is_read_from_the_photo_s_own_pixels_whatever_size_is_on_the_screen(snapshot):
    def pixel(row, column):
        if row >= HEIGHT:
            raise IndexError
        return np.float32([row / 100, column / 100, 0.5]), 1.0

    relit = replace(snapshot.picture.relit, image=None, full=SimpleNamespace(pixel=pixel))
    large = replace(snapshot, picture=replace(snapshot.picture, relit=relit))
    assert reading(large, "result", 0.0, 40.7, 30.2).linear == pytest.approx((0.3, 0.4, 0.5))
    assert reading(large, "result", 0.0, 40.7, HEIGHT) == Reading("result")
    assert reading(large, "result", 1.0, 40.7, 30.2).codes > reading(large, "result", 0.0, 40.7, 30.2).codes


@pytest.mark.parametrize(("x", "y"), [(10.0, 50.0), (64.0, 2.0), (-1.0, 5.0), (127.99, 95.99), (128.0, 96.0)])
def test_outside_there_is_no_value(snapshot, x, y):
    inside = 0 <= x < WIDTH and 0 <= y < HEIGHT
    rows = {row.name: row for row in readings(snapshot, 0.0, x, y)}
    assert bool(rows["photo"].linear) == inside
    assert rows["albedo"].linear == ()
    assert rows["albedo"].codes == ()


def test_without_a_photo_there_is_nothing_to_read():
    assert readings(Snapshot(), 0.0, 1.0, 1.0) == []


def test_of_the_photo_before_nothing_is_read(snapshot):
    another = replace(snapshot, opened=replace(snapshot.opened))
    assert [row.name for row in readings(another, 0.0, 40.0, 30.0)] == ["photo"]


def test_a_channel_leans_as_its_head_does_and_a_light_is_always_seen_whole(snapshot):
    turned = replace(snapshot.picture, relit=replace(snapshot.picture.relit, roll_deg=30.0))
    state = state_of(replace(snapshot, picture=turned))
    state.view, state.shown = View(False, 30.0, 64.0, 48.0), "albedo"
    assert arrange_panes(state, (800, 500)).main.placement.roll_deg == 30.0
    state.shown = "source_light"
    place = arrange_panes(state, (800, 500)).main.placement
    assert (place.x, place.x + place.width) == (16, 784)


@pytest.mark.parametrize("compare", ["off", "wipe", "side"])
@pytest.mark.parametrize("shown", ["result", "albedo", "photo", "source_light"])
def test_panes_cover_the_viewport_and_show_the_photo_first(snapshot, compare, shown):
    state = state_of(snapshot, compare=compare)
    state.shown = shown
    arranged = arrange_panes(state, (801, 500))
    edges = [(pane.left, pane.right) for pane in arranged.panes]
    assert edges[0][0] == 0
    assert edges[-1][1] == 801
    alone = compare == "off" or shown == "source_light"
    assert len(edges) == (1 if alone else 2)
    if not alone:
        assert arranged.panes[0].name == "photo"
        assert arranged.main.name == ("result" if shown == "photo" else shown)
        assert 0 <= edges[1][0] - edges[0][1] <= 4
    assert (arranged.wipe_x is not None) == (compare == "wipe" and not alone)


@pytest.mark.parametrize("shown", ["result", "photo", "source_light"])
@pytest.mark.parametrize("is_there", [True, False])
def test_the_photo_can_be_compared_where_it_is_seen_beside_what_is_shown(snapshot, shown, is_there):
    channels = snapshot.picture.channels if is_there else {}
    state = state_of(replace(snapshot, picture=replace(snapshot.picture, channels=channels)), compare="wipe")
    state.shown = shown
    assert can_compare(state) is (len(arrange_panes(state, (800, 500)).panes) == 2)


@pytest.mark.parametrize("shown", ["result", "albedo"])
@pytest.mark.parametrize("view", [View(), View(False, 7.3, 60.0, 40.0)])
def test_both_sides_of_a_wipe_show_the_same_spot_of_the_photo(snapshot, shown, view):
    state = state_of(snapshot, compare="wipe")
    state.shown, state.view = shown, view
    before, after = arrange_panes(state, (800, 500)).panes
    at = (333.0, 222.0)
    one = photo_point(before.placement, before.frame, at)
    other = photo_point(after.placement, after.frame, at)
    assert one == pytest.approx(other, abs=1.0 / after.placement.zoom)


def test_side_by_side_shows_the_same_spot_at_the_same_place_of_each_half(snapshot):
    state = state_of(snapshot, compare="side")
    state.view = View(False, 3.0, 64.0, 48.0)
    before, after = arrange_panes(state, (800, 500)).panes
    one = photo_point(before.placement, before.frame, (100.0, 222.0))
    other = photo_point(after.placement, after.frame, (100.0 + after.left, 222.0))
    assert one == pytest.approx(other, abs=1e-6)


def test_the_wipes_line_stays_at_its_spot_when_zooming_and_within_reach(snapshot):
    state = state_of(snapshot, compare="wipe", wipe_at=0.25)
    state.view = View(False, 4.0, 32.0, 48.0)
    assert arrange_panes(state, (800, 500)).wipe_x == 400.0
    state.view = View(False, 8.0, 32.0, 48.0)
    assert arrange_panes(state, (800, 500)).wipe_x == 400.0
    state.view = View(False, 30.0, 120.0, 48.0)
    assert 0 < arrange_panes(state, (800, 500)).wipe_x < 40


def test_holding_before_hides_every_comparison(snapshot):
    state = state_of(snapshot, compare="wipe")
    state.before = True
    arranged = arrange_panes(state, (800, 500))
    assert [pane.name for pane in arranged.panes] == ["photo"]


@pytest.mark.parametrize(
    ("shown", "before", "words"),
    [
        ("result", False, "Point at the picture to read its values"),
        ("source_light", False, "A panorama; show another picture to read values"),
        ("source_light", True, "Point at the picture to read its values"),
    ],
)
def test_nobody_is_told_to_point_at_a_picture_that_has_no_values(snapshot, shown, before, words):
    state = state_of(snapshot)
    state.shown, state.before = shown, before
    assert hint(arrange_panes(state, (800, 500))) == words


def lamp(u, v):
    radiance = np.zeros((16, 32, 3), np.float32)
    radiance[int(v * 16), int(u * 32)] = 1.0
    return average_direction(Environment.from_radiance(radiance))


@pytest.mark.parametrize(
    ("u", "v", "expected"),
    [
        (0.75, 0.5, "From the right"),
        (0.25, 0.5, "From the left"),
        (0.0, 0.5, "From the front"),
        (0.875, 0.25, "From front right, 39° up"),
        (0.5, 0.7, "From behind, 39° down"),
        (0.3, 0.01, "From above"),
        (0.75, 0.2, "From the right, 51° up"),
    ],
)
def test_the_compass_says_where_a_lamp_is(u, v, expected):
    assert words(lamp(u, v)) == expected


def test_light_from_everywhere_has_no_side():
    assert words(np.zeros(3, np.float32)) == "From all sides"
    assert words(np.array([0.2, 0.0, 0.0], np.float32)) == "From the right"


def test_a_preview_that_is_smaller_than_the_photo_is_read_at_the_same_spot(snapshot):
    picture = snapshot.picture
    half = replace(picture.relit, image=picture.relit.image[::2, ::2].copy())
    preview = replace(snapshot, picture=replace(picture, relit=half))
    x, y = 90.0, 60.0
    assert reading(preview, "result", 0.0, x, y).linear == reading(snapshot, "result", 0.0, x, y).linear


@pytest.mark.parametrize("roll_deg", [30.0, -90.0])
def test_in_a_turned_crop_the_probe_finds_the_turned_place(snapshot, roll_deg):
    turned = replace(snapshot.picture, relit=replace(snapshot.picture.relit, roll_deg=roll_deg))
    now = replace(snapshot, picture=turned)
    middle = reading(now, "specular", 0.0, 64.0, 48.0)
    assert middle.linear == pytest.approx(reading(snapshot, "specular", 0.0, 64.0, 48.0).linear, abs=0.2 / 63)
    # 20 pixels above the middle of the crop, turned back counterclockwise with it.
    angle = np.radians(roll_deg)
    x, y = 64.5 - 20 * np.sin(angle), 48.5 - 20 * np.cos(angle)
    found = reading(now, "shadow", 0.0, x, y).linear
    assert found == pytest.approx(reading(snapshot, "shadow", 0.0, 64.5, 28.5).linear, abs=0.3 / 63)


@pytest.mark.parametrize("roll_deg", [0.0, 25.0])
@pytest.mark.parametrize("spot", [(40, 30), (57, 71), (90, 18)])
def test_the_probe_reads_what_an_exported_file_holds(snapshot, roll_deg, spot):
    relit = replace(snapshot.picture.relit, roll_deg=roll_deg, window=(20.3, 1.1, 110.8, 91.6))
    now = replace(snapshot, picture=replace(snapshot.picture, relit=relit))
    layers = photo_layers(relit, ["albedo", "normal", "specular", "shadow", "composition"])
    x, y = spot
    for name, layer in layers.items():
        channel = "result" if name == "RGB" else name
        assert reading(now, channel, 0.0, x + 0.3, y + 0.8).linear == pytest.approx(
            tuple(np.atleast_1d(layer[y, x])), abs=2e-4
        )
