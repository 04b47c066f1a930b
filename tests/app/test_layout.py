"""Where the panels lie: they tile the window, and the picture always keeps room."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.ui.layout import Panels, arrange

EM = 15.0
panels = st.builds(
    Panels,
    st.floats(13, 34),
    st.floats(13, 34),
    st.floats(5, 20),
    st.booleans(),
    st.booleans(),
    st.booleans(),
    st.sampled_from(["left", "right"]),
    st.sampled_from(["left", "right"]),
    st.sampled_from(["top", "bottom"]),
)


def rects(layout):
    sides = (layout.light, layout.effects, layout.scope)
    every = (*sides, layout.filmstrip, layout.toolbar, layout.viewport, layout.status)
    return [rect for rect in every if rect]


@given(panels, st.integers(800, 3840), st.integers(560, 2160), st.sampled_from([1.0, 1.25, 1.5]), st.booleans())
def test_panels_tile_the_window_without_gap_or_overlap(arranged, width, height, scale, scope):
    parts = rects(arrange(width, height, EM * scale, arranged, scope))
    assert sum(rect.width * rect.height for rect in parts) == pytest.approx(width * height)
    for one, other in itertools.combinations(parts, 2):
        (ax0, ay0, ax1, ay1), (bx0, by0, bx1, by1) = one.corners, other.corners
        assert min(ax1, bx1) <= max(ax0, bx0) or min(ay1, by1) <= max(ay0, by0)


@given(panels, st.integers(800, 3840), st.integers(560, 2160))
def test_the_viewport_never_gets_smaller_than_a_usable_picture(arranged, width, height):
    viewport = arrange(width, height, EM, arranged).viewport
    assert viewport.width >= 200
    assert viewport.height >= 117


def test_a_hidden_panel_gives_its_room_to_the_picture():
    layout = arrange(1440, 900, EM, Panels().all_shown(False), scope=True)
    assert layout.viewport.corners == (0, 0, 1440, 870)
    assert layout.dividers == ()
    assert layout.scope is None
    assert layout.toolbar is None


def test_the_scope_gives_way_to_the_effects_in_a_low_window():
    high, low = (arrange(1440, height, EM, scope=True) for height in (900, 360))
    assert high.scope.height + high.effects.height == low.effects.height + 540
    assert low.scope is None


def test_dragging_an_edge_resizes_its_panel_between_limits():
    start = Panels()
    assert start.dragged("light", 20.0).light_em == 20.0
    assert start.dragged("light", 500.0).light_em == 34.0
    assert start.dragged("effects", 0.0).effects_em == 13.0
    assert start.dragged("filmstrip", 0.0).filmstrip_em == 5.0
    assert start.dragged("effects", 20.0).reset("effects") == start
    layout = arrange(1440, 900, EM, start.dragged("effects", 20.0))
    assert layout.effects.width == 300
    assert [divider.panel for divider in layout.dividers] == ["light", "effects", "filmstrip"]
    assert [divider.sign for divider in layout.dividers] == [1.0, -1.0, -1.0]


def test_a_wide_window_gives_the_panorama_more_room_until_the_user_says_how_much():
    assert arrange(1024, 700, EM).light.width == 255
    assert arrange(1440, 900, EM).light.width == 288
    assert arrange(3840, 2160, EM).light.width == 390
    assert arrange(3840, 2160, EM, Panels(light_em=20.0)).light.width == 300


def test_a_panel_can_be_at_either_edge_and_its_line_looks_toward_the_picture():
    moved = Panels().across("light").across("effects").across("filmstrip")
    layout = arrange(1440, 900, EM, moved, scope=True)
    assert layout.filmstrip.y == 0
    assert (layout.effects.x, layout.scope.y) == (0, layout.filmstrip.height)
    assert layout.light.corners[2] == 1440
    assert layout.status.corners[3] == 900
    lines = {divider.panel: (divider.line.x, divider.line.y, divider.sign) for divider in layout.dividers}
    assert lines["light"] == (layout.light.x, layout.light.y, -1.0)
    assert lines["effects"] == (layout.effects.width, layout.light.y, 1.0)
    assert lines["filmstrip"] == (0, layout.filmstrip.height, 1.0)
    assert moved.across("light").across("effects").across("filmstrip") == Panels()


def test_panels_at_the_same_side_stand_beside_each_other():
    layout = arrange(1440, 900, EM, Panels().moved("effects", "left"))
    assert (layout.light.x, layout.effects.x) == (0, layout.light.width)
    assert layout.viewport.x == layout.light.width + layout.effects.width
    assert layout.viewport.corners[2] == 1440
    layout = arrange(1440, 900, EM, Panels().moved("light", "right"))
    assert layout.viewport.x == 0
    assert layout.light.x == layout.viewport.width
    assert layout.effects.corners[2] == 1440
