"""The panels' triangles on the screen: colours, clipping, textures, and more of them than there was room for."""

import gc

import moderngl
import numpy as np
import pytest
from imgui_bundle import imgui

from app.window.gl_textures import Canvas

RED, BLUE = 0xFF0000FF, 0xFFFF0000
SIZE = (200, 100)


@pytest.fixture
def painted(hand):
    """Draws what a function lists, over black, 200 pixels wide and 100 high; gives the pixels, row 0 on top."""
    window = hand.window

    def paint(list_it):
        window._graphics.binding.begin()
        list_it(imgui.get_foreground_draw_list())
        window._graphics.binding.end()
        canvas = Canvas(window.context)
        canvas.fit((hand.width, hand.height))
        canvas.framebuffer.clear()
        window._graphics.painter.paint(window._graphics.binding.listed(), canvas.framebuffer)
        pixels = canvas.pixels()[::-1][: SIZE[1], : SIZE[0]].copy()
        canvas.close()
        return pixels

    return paint


def test_a_rectangle_is_where_it_was_listed_and_nowhere_else(painted):
    pixels = painted(lambda draw: draw.add_rect_filled((10, 20), (30, 60), RED))
    assert (pixels[20:60, 10:30] == (255, 0, 0)).all()
    pixels[20:60, 10:30] = 0
    assert pixels.max() == 0


def test_opacity_mixes_with_what_is_there(painted):
    def both(draw):
        draw.add_rect_filled((0, 0), (50, 50), RED)
        draw.add_rect_filled((0, 0), (50, 50), 0x80FF0000)

    red, green, blue = (int(part) for part in painted(both)[25, 25])
    assert (abs(red - 127) <= 1, green, abs(blue - 128) <= 1) == (True, 0, True)


def test_clipping_cuts_and_a_clip_beyond_the_window_does_no_harm(painted):
    def clipped(draw):
        draw.push_clip_rect((40, -50), (60, 30))
        draw.add_rect_filled((0, 0), (200, 100), BLUE)
        draw.pop_clip_rect()

    pixels = painted(clipped)
    assert (pixels[:30, 40:60] == (0, 0, 255)).all()
    assert pixels[30:].max() == 0
    assert pixels[:, :40].max() == 0


def test_a_texture_of_ours_is_drawn_the_right_way_up(hand, painted):
    codes = np.zeros((2, 2, 4), np.uint8)
    codes[0, 0], codes[1, 1] = (255, 0, 0, 255), (0, 255, 0, 255)
    texture = hand.window.context.texture((2, 2), 4, codes.tobytes())
    texture.filter = moderngl.NEAREST, moderngl.NEAREST
    pixels = painted(lambda draw: draw.add_image(imgui.ImTextureRef(texture.glo), (0, 0), (20, 20)))
    texture.release()
    assert (pixels[5, 5] == (255, 0, 0)).all()
    assert (pixels[15, 15] == (0, 255, 0)).all()
    assert pixels[5, 15].max() == 0


def test_far_more_triangles_than_usual_find_room(painted):
    def many(draw):
        for index in range(8000):
            draw.add_rect_filled((index % 200, 0), (index % 200 + 1, 100), RED)

    assert (painted(many) == (255, 0, 0)).all()
    assert (painted(lambda draw: draw.add_rect_filled((0, 0), (200, 100), BLUE)) == (0, 0, 255)).all()


def test_letters_of_a_new_size_are_drawn(painted):
    def write(draw):
        imgui.push_font(None, 41.0)
        draw.add_text((5, 5), 0xFFFFFFFF, "Ägypten")
        imgui.pop_font()

    assert painted(write).max() == 255


def test_text_goes_to_the_clipboard_and_back(hand):
    imgui.set_clipboard_text("größer")
    assert imgui.get_clipboard_text() == "größer"


def test_textures_that_are_no_longer_shown_leave_nothing_behind(opened):
    context, counts = opened.window.context, []
    for side in range(5, 45):
        texture = context.texture((side, side), 4)
        opened.window._graphics.binding.begin()
        number = imgui.ImTextureRef(texture.glo)
        imgui.get_foreground_draw_list().add_image(number, (0.0, 0.0), (50.0, 50.0))
        opened.window._graphics.binding.end()
        opened.window._graphics.show()
        counts.append(sum(type(thing) is moderngl.Texture for thing in gc.get_objects()))
        texture.release()
    assert counts[-1] - counts[1] < 5
