"""What of the interface is drawn again: never less than what differs, and little more."""

import numpy as np
import pytest

from app.window.damage import DrawCommand, DrawList, damage, seen_in

SIZE = (400, 300)
ALL = (0, 0, 400, 300)
LETTERS, PICTURE = 1, 2


def rectangle(x0, y0, x1, y1, colour=7, part=(0.0, 0.0, 1.0, 1.0)):
    """Four corners as Dear ImGui lists them for a picture."""
    corners = np.zeros((4, 5), np.uint32)
    u0, v0, u1, v1 = part
    places = [(x0, y0, u0, v0), (x1, y0, u1, v0), (x1, y1, u1, v1), (x0, y1, u0, v1)]
    corners[:, :4] = np.array(places, np.float32).view(np.uint32)
    corners[:, 4] = colour
    return corners


def draw_list(*corners, owner="panel", texture=LETTERS, clip=ALL):
    indices = np.concatenate([np.array([0, 1, 2, 0, 2, 3]) + 4 * place for place in range(len(corners))])
    command = DrawCommand(clip, texture, 0, len(indices))
    return DrawList(owner, np.concatenate(corners), indices.astype(np.uint32), (command,))


def test_the_same_again_needs_nothing():
    frame = (draw_list(rectangle(10, 10, 20, 20)),)
    assert damage(frame, (draw_list(rectangle(10, 10, 20, 20)),), {}, SIZE) == []


def test_what_moved_is_drawn_where_it_was_and_where_it_is():
    before = (draw_list(rectangle(5, 5, 300, 9), rectangle(10, 10, 20, 20)),)
    now = (draw_list(rectangle(5, 5, 300, 9), rectangle(50, 10, 60, 20)),)
    assert sorted(damage(before, now, {}, SIZE)) == [(10, 10, 20, 20), (50, 10, 60, 20)]


def test_half_pixels_are_drawn_whole():
    before = (draw_list(rectangle(10.5, 10.5, 20.5, 20.5)),)
    now = (draw_list(rectangle(10.5, 10.5, 20.5, 20.5, colour=8)),)
    assert damage(before, now, {}, SIZE) == [(10, 10, 21, 21)]


def test_more_letters_leave_those_before_and_after_them_alone():
    first, last = rectangle(0, 0, 10, 10), rectangle(200, 200, 210, 210)
    before = (draw_list(first, rectangle(20, 0, 30, 10), last),)
    now = (draw_list(first, rectangle(20, 0, 30, 10, colour=9), rectangle(40, 0, 50, 10), last),)
    found = damage(before, now, {}, SIZE)
    assert (min(rect[0] for rect in found), min(rect[1] for rect in found)) == (20, 0)
    assert (max(rect[2] for rect in found), max(rect[3] for rect in found)) == (50, 10)


def test_nothing_is_drawn_beyond_the_clip():
    clip = (0, 0, 15, 300)
    before = (draw_list(rectangle(10, 10, 20, 20), clip=clip),)
    assert damage(before, (draw_list(rectangle(10, 10, 20, 20, colour=8), clip=clip),), {}, SIZE) == [(10, 10, 15, 20)]


def test_a_window_that_comes_or_goes_is_drawn_where_it_lies():
    panel, tip = draw_list(rectangle(0, 0, 400, 300)), draw_list(rectangle(30, 30, 60, 40), owner="tip")
    assert damage((panel,), (panel, tip), {}, SIZE) == [(30, 30, 60, 40)]
    assert damage((panel, tip), (panel,), {}, SIZE) == [(30, 30, 60, 40)]


def test_windows_that_change_their_order_are_drawn_whole():
    one, two = draw_list(rectangle(0, 0, 9, 9), owner="one"), draw_list(rectangle(5, 5, 20, 20), owner="two")
    assert damage((one, two), (two, one), {}, SIZE) == [ALL]


def test_windows_of_one_name_are_drawn_whole():
    first, second = draw_list(rectangle(10, 10, 20, 20)), draw_list(rectangle(50, 10, 60, 20))
    other = draw_list(rectangle(10, 10, 20, 20, colour=8))
    assert damage((first, second), (other, second), {}, SIZE) == [ALL]


def test_another_texture_or_clip_is_drawn_though_the_corners_are_the_same():
    before = (draw_list(rectangle(10, 10, 20, 20)),)
    assert damage(before, (draw_list(rectangle(10, 10, 20, 20), texture=PICTURE),), {}, SIZE) == [(10, 10, 20, 20)]
    found = damage(before, (draw_list(rectangle(10, 10, 20, 20), clip=(0, 0, 12, 300)),), {}, SIZE)
    assert min(rect[0] for rect in found) == 10
    assert max(rect[2] for rect in found) == 20


def test_a_picture_with_other_contents_is_drawn_though_something_else_of_its_window_has_changed_too():
    def frame(colour):
        letters, picture = rectangle(5, 5, 9, 9, colour=colour), rectangle(100, 100, 200, 200)
        commands = DrawCommand(ALL, LETTERS, 0, 6), DrawCommand(ALL, PICTURE, 6, 6)
        return (DrawList("panel", np.concatenate([letters, picture]), draw_list(letters, picture).indices, commands),)

    assert sorted(damage(frame(7), frame(8), {PICTURE: (0.0, 0.0, 1.0, 1.0)}, SIZE)) == [
        (5, 5, 9, 9),
        (100, 100, 200, 200),
    ]


def test_a_texture_with_other_contents_is_drawn_where_it_is_seen():
    frame = (draw_list(rectangle(100, 100, 200, 200), texture=PICTURE),)
    assert damage(frame, frame, {PICTURE: (0.0, 0.0, 1.0, 1.0)}, SIZE) == [(100, 100, 200, 200)]
    assert damage(frame, frame, {LETTERS: (0.0, 0.0, 1.0, 1.0)}, SIZE) == []


@pytest.mark.parametrize(
    ("seen", "left", "right"),
    [((0.0, 0.0, 1.0, 1.0), 124, 151), ((0.5, 0.0, 1.0, 1.0), 100, 101), ((1.0, 0.0, 0.0, 1.0), 100, 200)],
)
def test_only_the_part_of_a_texture_that_changed_is_drawn_unless_it_is_mirrored(seen, left, right):
    frame = (draw_list(rectangle(100, 100, 200, 200, part=seen), texture=PICTURE),)
    (rect,) = damage(frame, frame, {PICTURE: (0.25, 0.0, 0.5, 1.0)}, SIZE)
    assert (rect[0], rect[2]) == (left, right)


def test_many_small_places_become_few_that_hold_them_all():
    spots = [rectangle(20 * place, 7 * place, 20 * place + 3, 7 * place + 3) for place in range(20)]
    lit = [rectangle(20 * place, 7 * place, 20 * place + 3, 7 * place + 3, colour=8) for place in range(20)]
    before = tuple(draw_list(spot, owner=str(place)) for place, spot in enumerate(spots))
    now = tuple(draw_list(spot, owner=str(place)) for place, spot in enumerate(lit))
    found = damage(before, now, {}, SIZE)
    assert len(found) <= 8
    for place in range(20):
        x, y = 20 * place, 7 * place
        assert any(x0 <= x and y0 <= y and x1 >= x + 3 and y1 >= y + 3 for x0, y0, x1, y1 in found)


def test_random_frames_never_miss_a_pixel_that_differs():
    """Painted by brute force, every pixel that differs lies in a rectangle."""
    random = np.random.default_rng(3)

    def some():
        spots = [tuple(random.integers(0, 40, 2)) for _ in range(random.integers(1, 5))]
        return [(int(x), int(y), int(x) + 6, int(y) + 4, int(random.integers(1, 4))) for x, y in spots]

    def painted(frame):
        pixels = np.zeros((50, 50), int)
        for x0, y0, x1, y1, colour in (spot for spots in frame for spot in spots):
            pixels[y0:y1, x0:x1] = pixels[y0:y1, x0:x1] * 5 % 97 + colour
        return pixels

    def draw_lists(frame):
        return tuple(
            draw_list(*(rectangle(*spot[:4], colour=spot[4]) for spot in spots), owner=str(place), clip=(0, 0, 50, 50))
            for place, spots in enumerate(frame)
        )

    for _ in range(200):
        before, now = [[some() for _ in range(random.integers(1, 4))] for _ in range(2)]
        now = [old if random.random() < 0.5 else new for old, new in zip(before, now, strict=False)]
        differs = painted(before) != painted(now)
        for x0, y0, x1, y1 in damage(draw_lists(before), draw_lists(now), {}, (50, 50)):
            differs[y0:y1, x0:x1] = False
        assert not differs.any()


def test_what_lies_under_an_opaque_picture_is_not_drawn():
    under = draw_list(rectangle(0, 0, 400, 300), owner="under")
    picture = draw_list(rectangle(50, 50, 250, 250), owner="picture", texture=PICTURE)
    over = draw_list(rectangle(60, 60, 70, 70), owner="over")
    draw_lists = (under, picture, over)
    commands, hides = seen_in((60, 60, 100, 100), draw_lists, {PICTURE})
    assert ([index for index, _, _ in commands], hides) == ([1, 2], True)
    commands, hides = seen_in((40, 60, 100, 100), draw_lists, {PICTURE})
    assert ([index for index, _, _ in commands], hides) == ([0, 1, 2], False)
    commands, hides = seen_in((60, 60, 100, 100), draw_lists, set())
    assert ([index for index, _, _ in commands], hides) == ([0, 1, 2], False)
    corner = DrawCommand(ALL, PICTURE, 0, 3)
    half = DrawList("picture", picture.vertices, picture.indices, (corner,))
    commands, hides = seen_in((60, 60, 100, 100), (under, half), {PICTURE})
    assert ([index for index, _, _ in commands], hides) == ([0, 1], False)
