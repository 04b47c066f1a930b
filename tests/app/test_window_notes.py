"""What is written over the picture in the real window lies apart."""

import glfw
from window_hand import STRIPS

from app.ui import theme
from app.ui.viewport import viewport_notes


def test_the_names_at_the_line_lie_above_what_the_colours_mean(opened, monkeypatch):
    feet, tops, note, draw_image = {}, [], viewport_notes.note, viewport_notes.widgets.draw_image

    def note_foot(words, x, y, *colour):
        note(words, x, y, *colour)
        feet[words] = y + 1.5 * theme.FONT_PX

    def note_top(shown, x, y, *size):
        draw_image(shown, x, y, *size)
        tops.append(y)

    monkeypatch.setattr(viewport_notes, "note", note_foot)
    monkeypatch.setattr(viewport_notes.widgets, "draw_image", note_top)
    for key in (glfw.KEY_I, glfw.KEY_W, glfw.KEY_D):
        opened.key(key)
    tops.clear()
    opened.frames(1)
    legend = max(top for top in tops if top < opened.height - STRIPS)
    assert max(feet["Photo"], feet["Result"]) < legend - 0.6 * theme.FONT_PX
