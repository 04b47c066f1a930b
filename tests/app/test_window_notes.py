"""What is written over the picture in the real window lies apart."""

import itertools
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import glfw
import pytest
from imgui_bundle import imgui
from window_hand import EFFECTS_PANEL, LIGHT_PANEL, PANORAMA_WIDTH, PANORAMA_X, STRIPS, TOOLBAR

from app.engine.snapshot import Snapshot
from app.engine.sources import LightSource, PhotoSource
from app.ui import theme
from app.ui.asking import Question
from app.ui.panels import panorama
from app.ui.viewport import placing, probe_card, viewport_notes


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


@pytest.mark.parametrize("size", [(1440, 900), (560, 420)])
def test_words_below_the_colours_lie_beside_one_another_and_above_the_zoom(opened, monkeypatch, size):
    ends, tops = [], []

    class Noted:
        """Dear ImGui, its draw list telling what is written."""

        def __getattr__(self, name):
            return getattr(imgui, name) if name != "get_window_draw_list" else lambda: self

        def add_rect_filled(self, *_shape):
            pass

        def add_text(self, at, _colour, words):
            ends.append((at.x, at.x + imgui.calc_text_size(words).x))
            tops.append(at.y)

    legend = viewport_notes.legend

    def noted_legend(*of):
        ends.clear()
        with monkeypatch.context() as patch:
            patch.setattr(viewport_notes, "imgui", Noted())
            legend(*of)

    zoom = {}
    monkeypatch.setattr(viewport_notes, "legend", noted_legend)
    monkeypatch.setattr(viewport_notes, "note", lambda words, x, y, *colour: zoom.update({words: (x, y)}))
    opened.resize(size)
    opened.key(glfw.KEY_D)
    opened.frames(3)
    assert len(ends) == 3
    assert all(before[1] < after[0] for before, after in itertools.pairwise(ends))
    ((x, y),) = [place for words, place in zoom.items() if words.endswith("%")]
    assert ends[-1][1] < x or tops[-1] + theme.FONT_PX < y


@pytest.mark.parametrize("name", ["me.jpg", f"{'x' * 200}.jpg"])
def test_what_runs_stays_within_the_viewport_and_off_the_zoom(opened, monkeypatch, name):
    busy, places, note = Snapshot(activity=f"Reading the face in {name}"), [], viewport_notes.note
    corner_note = viewport_notes.corner_note

    def note_places(words, x, y, *colour):
        places.append((x, y, x + viewport_notes.note_width(words), y + 1.5 * theme.FONT_PX))
        note(words, x, y, *colour)

    def corner_note_with_progress(state, arranged, rect):
        places[:] = [(rect.x, rect.y, rect.x + rect.width, rect.y + rect.height)]
        corner_note(state, arranged, rect)
        viewport_notes.progress(SimpleNamespace(snapshot=busy), rect)

    monkeypatch.setattr(viewport_notes, "note", note_places)
    monkeypatch.setattr(viewport_notes, "corner_note", corner_note_with_progress)
    opened.frames(2)
    viewport, zoom, progress = places
    assert viewport[0] < progress[0]
    assert progress[2] < viewport[2]
    assert progress[2] < zoom[0] or progress[3] < zoom[1]


def test_what_runs_for_a_light_ends_within_the_panorama(opened, monkeypatch):
    state, ends, note = opened.window.state, [], panorama.note

    def note_end(words, x, y):
        ends.append((words, x + viewport_notes.note_width(words)))
        note(words, x, y)

    monkeypatch.setattr(panorama, "note", note_end)
    state.light = LightSource("rig", "rim")
    state.snapshot = replace(state.snapshot, activity=f"Reading the face in {'x' * 60}.jpg")
    monkeypatch.setattr(opened.window.engine, "snapshot", lambda: state.snapshot)
    opened.frames(1)
    assert ends
    assert all(words.endswith("…") and end <= PANORAMA_X + PANORAMA_WIDTH for words, end in ends)


def test_the_name_of_a_first_photo_that_is_being_read_ends_within_the_viewport(hand, monkeypatch):
    state, widths, centred = hand.window.state, [], viewport_notes._centred

    def noted(words, x, *rest):
        widths.append((words[-6:], imgui.calc_text_size(words).x))
        centred(words, x, *rest)

    monkeypatch.setattr(viewport_notes, "_centred", noted)
    state.photo = PhotoSource(Path("x.jpg"))
    state.snapshot = replace(state.snapshot, activity=f"Opening {'x' * 240}.jpg")
    monkeypatch.setattr(hand.window.engine, "snapshot", lambda: state.snapshot)
    hand.frames(1)
    ((end, width),) = widths
    assert end == "xxxxx…"
    assert width < hand.width - LIGHT_PANEL - EFFECTS_PANEL


@pytest.mark.parametrize("key", [glfw.KEY_I, glfw.KEY_T])
@pytest.mark.parametrize("also", [glfw.KEY_L, glfw.KEY_D, glfw.KEY_W])
def test_no_card_lies_over_what_the_next_click_does(opened, monkeypatch, key, also):
    cards, hints, shade, note = [], [], probe_card.widgets.shade, placing.note

    def shaded(draw, rect, opacity):
        # Cards are darker than the pills of notes and what colours mean.
        cards.extend([rect] * (opacity > 0.9))
        shade(draw, rect, opacity)

    def noted(words, x, y):
        hints.append((x, y, x + viewport_notes.note_width(words), y + 1.5 * theme.FONT_PX))
        note(words, x, y)

    for pressed in (key, also, glfw.KEY_K):
        opened.key(pressed)
    monkeypatch.setattr(probe_card.widgets, "shade", shaded)
    monkeypatch.setattr(placing, "note", noted)
    opened.frames(1)
    (card,), (hint,) = cards, hints
    assert hint[1] > card.y + card.height or hint[0] > card.x + card.width or hint[2] < card.x
    assert hint[3] < opened.height - STRIPS


def test_what_the_next_click_does_lies_below_what_is_asked(opened, monkeypatch):
    tops = []
    opened.key(glfw.KEY_K)
    opened.window.state.asking.ask(Question("x", "Is it?", (("Yes", lambda: None),)))
    opened.frames(3)
    monkeypatch.setattr(placing, "note", lambda words, x, y: tops.append(y))
    opened.frames(1)
    assert tops[0] > TOOLBAR + opened.window.state.look.covered
    assert opened.window.state.look.covered > 0
