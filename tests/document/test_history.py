"""Undo: one step per movement of the hand, names a person reads, any step in reach."""

from dataclasses import replace
from pathlib import Path

import pytest

from app.document.document import Document, LightRef, PhotoRef
from app.document.history import History
from app.document.naming import change_between
from relight_core.face.find import FaceBox
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke

START = Document(PhotoRef(Path("/p/me.jpg")))


def edited(**fields):
    return replace(START, edit=replace(START.edit, **fields))


def lit(**fields):
    return replace(START, light_edit=LightEdit(**fields))


@pytest.fixture
def history():
    history = History()
    history.observe(START, True, 0.0)
    return history


def names(history):
    return [step.name for step in history.steps]


def test_a_drag_is_one_step_however_many_frames_it_takes(history):
    for index in range(50):
        history.observe(edited(yaw_deg=index * 0.7), False, index * 0.1)
    history.observe(edited(yaw_deg=35.0), True, 6.0)
    history.observe(edited(yaw_deg=35.0), True, 6.1)
    assert names(history) == ["Open me.jpg", "Turn light to 35°"]
    assert history.undo() == START
    assert history.redo() == edited(yaw_deg=35.0)


def test_what_changes_in_every_step_alike_is_no_step_and_leaves_nothing_to_undo(history):
    history.observe(edited(shadow=0.5), True, 1.0)
    history.go(0)
    resized = replace(START, photo=replace(START.photo, boxes=(FaceBox(0.0, 0.0, 9.0, 9.0),)))
    history.refit(lambda document: replace(document, photo=resized.photo))
    assert not history.can_undo
    history.observe(resized, True, 2.0)
    assert names(history) == ["Open me.jpg", "Shadow 0.50"]
    assert history.redo() == replace(resized, edit=edited(shadow=0.5).edit)


def test_a_drag_that_another_photo_ends_is_a_step_but_what_was_only_awaited_is_none(history):
    other = replace(START, photo=PhotoRef(Path("you.jpg")))
    history.observe(edited(yaw_deg=35.0), False, 1.0)
    history.observe(other, False, 1.1)
    history.observe(replace(START, photo=PhotoRef(Path("refused.jpg"))), False, 1.2)
    history.observe(other, True, 2.0)
    assert names(history)[:2] == ["Open me.jpg", "Turn light to 35°"]
    assert len(names(history)) == 3
    assert history.undo() == edited(yaw_deg=35.0)
    assert history.undo() == START


AWAITED = [replace(START, photo=PhotoRef(Path("you.jpg"))), replace(START, light=LightRef("rig", "ring"))]


@pytest.mark.parametrize("wish", AWAITED, ids=["photo", "light"])
def test_what_was_wished_for_and_never_came_is_no_step(history, wish):
    history.observe(wish, False, 1.0)
    history.observe(replace(START, photo=PhotoRef(Path("they.jpg"))), False, 1.1)
    history.observe(START, True, 9.0)
    assert names(history) == ["Open me.jpg"]


@pytest.mark.parametrize("wish", AWAITED, ids=["photo", "light"])
def test_what_has_not_come_yet_is_taken_back_before_any_step(history, wish):
    history.observe(edited(shadow=0.6), True, 1.0)
    history.observe(replace(wish, edit=edited(shadow=0.6).edit), False, 3.0)
    assert history.undo() == edited(shadow=0.6)
    assert history.undo() == START
    assert not history.can_undo
    history.observe(wish, False, 4.0)
    assert history.can_undo
    assert history.undo() == START


def test_wheel_steps_in_a_row_are_one_step_and_later_ones_another(history):
    for index, now_s in enumerate((1.0, 1.5, 2.0), 1):
        history.observe(edited(yaw_deg=5.0 * index), True, now_s)
    history.observe(edited(yaw_deg=20.0), True, 3.0)
    assert names(history) == ["Open me.jpg", "Turn light to 15°", "Turn light to 20°"]


def test_there_and_back_at_once_leaves_no_step(history):
    history.observe(edited(yaw_deg=5.0), True, 1.0)
    history.observe(START, True, 1.3)
    assert names(history) == ["Open me.jpg"]
    assert not history.can_undo


def test_other_things_changed_in_quick_succession_stay_apart(history):
    history.observe(edited(shadow=0.6), True, 1.0)
    history.observe(edited(shadow=0.6, specular=2.0), True, 1.1)
    assert names(history) == ["Open me.jpg", "Shadow 0.60", "Specular 2.00"]


def test_a_change_after_undo_drops_what_was_undone(history):
    history.observe(edited(shadow=0.6), True, 1.0)
    history.observe(edited(shadow=0.6, specular=2.0), True, 3.0)
    history.undo()
    history.undo()
    history.observe(edited(exposure_ev=-1.0), True, 9.0)
    assert names(history) == ["Open me.jpg", "Exposure \N{MINUS SIGN}1.00 EV"]
    assert not history.can_redo


def test_observing_what_undo_brought_back_adds_nothing(history):
    history.observe(edited(shadow=0.6), True, 1.0)
    history.observe(history.undo(), True, 1.1)
    assert history.can_redo
    assert len(history.steps) == 2


def test_any_step_can_be_gone_to(history):
    for index in range(1, 5):
        history.observe(edited(shadow=index / 4), True, 10.0 * index)
    assert history.go(2) == edited(shadow=0.5)
    with pytest.raises(IndexError):
        history.go(5)
    with pytest.raises(IndexError):
        history.go(-1)


def test_before_the_first_photo_there_is_nothing_to_go_back_to():
    history = History()
    history.observe(Document(), True, 0.0)
    history.observe(replace(Document(), edit=Edit(yaw_deg=9.0, quality="final")), True, 1.0)
    history.observe(START, True, 2.0)
    assert names(history) == ["Open me.jpg"]
    assert not history.can_undo


def test_a_first_photo_that_is_still_being_read_is_nothing_to_take_back():
    history = History()
    history.observe(Document(), True, 0.0)
    history.observe(START, False, 1.0)
    assert not history.can_undo


def test_a_light_that_turns_by_itself_as_the_first_photo_opens_is_no_step():
    history = History()
    for now_s, yaw_deg in enumerate((0.0, 5.0, 10.0)):
        history.observe(edited(yaw_deg=yaw_deg), True, now_s, turning=True)
    assert names(history) == ["Open me.jpg"]


def test_the_list_does_not_grow_for_ever(history):
    for index in range(1000):
        history.observe(edited(yaw_deg=index % 7 + 1.0), True, 10.0 * (index + 1))
    assert len(history.steps) == 300
    assert history.at == 299


BOX, ROUND, KEY = SoftBox(), SoftBox(form="disc"), SoftBox(name="key light")
ONE, TWO, BESIDE = FaceBox(0, 0, 9, 9), FaceBox(10, 0, 15, 5), FaceBox(20, 0, 30, 10)


def with_faces(boxes, face_index=None, found=(ONE, TWO)):
    return replace(START, photo=PhotoRef(START.photo.path, face_index, boxes, found))


SKY = replace(START, light=LightRef("panorama", "/h/sky.hdr"), light_edit=LightEdit(metered=True))


def painted(*adds):
    """A photo with a stroke of the brush for each, which adds or takes away."""
    strokes = tuple(BrushStroke(((1.0, float(index)),), 2.0, one) for index, one in enumerate(adds))
    return replace(START, photo=PhotoRef(Path("/p/me.jpg"), strokes=strokes))


NAMES = [
    (with_faces(None), with_faces((ONE, replace(TWO, x0=12, x1=17))), "Move face 2"),
    (with_faces((ONE,)), with_faces((replace(ONE, x1=12, y1=12),)), "Resize face 1"),
    (with_faces(None), with_faces((ONE, TWO, BESIDE)), "Add face 3"),
    (with_faces(None, found=()), with_faces((ONE,)), "Add face 1"),
    (with_faces(None, 0), with_faces((TWO,)), "Remove face 1"),
    (with_faces((ONE,)), with_faces(()), "Remove face 1"),
    (with_faces((ONE,)), with_faces(None, 1), "Faces as they are found"),
    (with_faces((ONE, TWO)), with_faces((BESIDE, BESIDE)), "Change the faces"),
    (with_faces((ONE,)), with_faces((BESIDE, TWO)), "Change the faces"),
    (with_faces((ONE, TWO)), with_faces((BESIDE,)), "Change the faces"),
    (with_faces((ONE,)), with_faces((replace(ONE, x1=12),)), "Resize face 1"),
    (with_faces((ONE, TWO)), with_faces((ONE, TWO), 1), "Face 2"),
    (painted(), painted(True), "Add to the person"),
    (painted(True), painted(True, False, False), "Take from the person"),
    (painted(True), painted(True, False, True), "Change the outline"),
    (painted(True, False), painted(), "Outline as found"),
    (painted(True, False), painted(True), "Change the outline"),
    (painted(True), painted(False, False), "Change the outline"),
    (START, replace(START, photo=PhotoRef(Path("/q/you.png"))), "Open you.png"),
    (START, replace(START, photo=PhotoRef(Path("/q/a\nb.png"))), "Open a\N{REPLACEMENT CHARACTER}b.png"),
    (START, replace(START, photo=PhotoRef(Path("/p/me.jpg"), 1)), "Face 2"),
    (replace(START, photo=PhotoRef(Path("/p/me.jpg"), 1)), START, "All faces"),
    (START, replace(START, light=LightRef("rig", "soft-window")), "Light: Soft window"),
    (START, replace(START, light=LightRef("panorama", "/h/studio.hdr")), "Light: studio"),
    (START, replace(START, quality="draft"), "Quality: draft"),
    (START, edited(background="transparent"), "Background: none"),
    (START, edited(background="#30343a"), "Background: #30343a"),
    (START, edited(background="match"), "Background: matched"),
    (edited(background="light"), START, "Background: photo"),
    (START, edited(background_fov_deg=40.0), "Background width 40°"),
    (START, edited(background_blur_deg=2.5), "Background blur 2.5°"),
    (START, edited(yaw_deg=-0.3), "Turn light to 0°"),
    (START, edited(specular_tint=0.3), "Specular tint +0.30"),
    (START, edited(strength=0.5), "Strength 0.50"),
    (START, edited(exposure_ev=0.5), "Exposure +0.50 EV"),
    (START, edited(forced_on=frozenset({"shadow", "detail"})), "Always computed: detail, shadow"),
    (edited(forced_on=frozenset({"shadow"})), START, "Always computed: nothing"),
    (START, edited(forced_off=frozenset({"hard_shadow", "detail"})), "Left out: detail, hard shadow"),
    (edited(shadow=0.2, yaw_deg=3.0), START, "Reset all"),
    (START, edited(shadow=0.2, yaw_deg=3.0), "Change several settings"),
    (START, lit(boxes=(BOX,)), "Add soft box"),
    (lit(boxes=(BOX,)), START, "Delete soft box"),
    (lit(boxes=(BOX,), base=0.5), START, "Delete soft box"),
    (lit(boxes=(BOX, BOX)), lit(boxes=(BOX,)), "Delete soft box"),
    (replace(edited(shadow=0.2), light_edit=LightEdit(boxes=(BOX,))), START, "Reset all"),
    (replace(edited(shadow=0.2), light_edit=LightEdit(boxes=(KEY,), apart=True)), START, "Reset all"),
    (lit(boxes=(KEY, BOX), apart=True), lit(boxes=(BOX,), apart=True), "Delete key light"),
    (lit(boxes=(KEY, BOX), apart=True), lit(boxes=(KEY,), apart=True), "Delete soft box"),
    (lit(boxes=(KEY,), apart=True), lit(apart=True), "Delete key light"),
    (lit(boxes=(BOX,)), lit(boxes=(replace(BOX, azimuth_deg=3.0),)), "Move soft box 1"),
    (lit(boxes=(BOX, BOX)), lit(boxes=(BOX, replace(BOX, width_deg=9.0, height_deg=4.0))), "Resize soft box 2"),
    (lit(boxes=(BOX,)), lit(boxes=(replace(BOX, kelvin=3000.0),)), "Colour of soft box 1"),
    (lit(boxes=(BOX,)), lit(boxes=(replace(BOX, colour=(1.0, 0.2, 0.1)),)), "Colour of soft box 1"),
    (lit(boxes=(BOX,)), lit(boxes=(replace(BOX, intensity=2.0),)), "Brightness of soft box 1"),
    (lit(boxes=(BOX,)), lit(boxes=(SoftBox(1, 2, 3, 4, 0.5, 6000, None, 7),)), "Change soft box 1"),
    (lit(boxes=(BOX,)), lit(boxes=(replace(BOX, form="disc", width_deg=9.0, height_deg=9.0),)), "Shape of soft box 1"),
    (lit(boxes=(ROUND,)), lit(boxes=(replace(ROUND, hole=0.5),)), "Shape of soft box 1"),
    (lit(boxes=(KEY,)), lit(boxes=(replace(KEY, off=True),)), "Switch off key light"),
    (lit(boxes=(replace(BOX, off=True),)), lit(boxes=(BOX,)), "Switch on soft box 1"),
    (lit(boxes=(KEY,)), lit(boxes=(replace(KEY, off=True, intensity=2.0),)), "Change key light"),
    (lit(boxes=(BOX, BOX)), lit(boxes=(ROUND, ROUND)), "Change soft boxes"),
    (START, lit(boxes=(KEY,), apart=True), "Take the light's lamps apart"),
    (lit(boxes=(KEY, BOX), apart=True), lit(boxes=(BOX,)), "Put the light's lamps back"),
    (lit(boxes=(KEY, BOX), apart=True), START, "Remove all soft boxes"),
    (lit(boxes=(KEY,), apart=True), lit(boxes=(replace(KEY, elevation_deg=5.0),), apart=True), "Move key light"),
    (lit(boxes=(KEY, BOX)), lit(boxes=(KEY, replace(BOX, softness=0.1))), "Soften soft box 1"),
    (START, lit(warmth=-0.5), "Light warmth \N{MINUS SIGN}0.50"),
    (START, lit(blur_deg=12.0), "Light blur 12°"),
    (START, lit(level_ev=1.5), "Light level +1.50 EV"),
    (START, lit(base=0.25), "Room light 0.25"),
    (START, lit(saturation=0.5), "Light saturation 0.50"),
    (START, lit(tint=0.5), "Light tint +0.50"),
    (START, lit(metered=True), "Meter the light"),
    (lit(metered=True), START, "Light as its file says"),
    (SKY, replace(SKY, light_edit=LightEdit(level_ev=2.0, blur_deg=9.0)), "Change several settings"),
    (replace(SKY, light_edit=LightEdit(level_ev=2.0)), SKY, "Reset all"),
]


@pytest.mark.parametrize(("before", "after", "name"), NAMES)
def test_changes_have_names_that_a_person_reads(before, after, name):
    assert change_between(before, after).name == name


def test_no_change_has_no_name():
    assert change_between(START, edited()) is None


def test_every_correction_of_the_faces_is_a_step_however_quick(history):
    for at, boxes in enumerate(((ONE,), (TWO,), (BESIDE,)), 1):
        history.observe(with_faces(boxes), True, 0.01 * at)
    assert len(history.steps) == 4
    assert history.undo().photo.boxes == (TWO,)


def test_what_the_finder_saw_makes_no_other_document():
    assert with_faces(None, found=(ONE,)) == with_faces(None, found=())


def test_soft_boxes_added_and_deleted_quickly_are_a_step_each(history):
    one, two = SoftBox(azimuth_deg=10.0), SoftBox(azimuth_deg=90.0)
    for index, boxes in enumerate(((one,), (one, two), (two,), ()), 1):
        history.observe(lit(boxes=boxes), True, 1.0 + 0.2 * index)
    assert names(history)[1:] == ["Add soft box", "Add soft box", "Delete soft box", "Delete soft box"]
    assert history.undo() == lit(boxes=(two,))


def test_what_is_done_to_one_soft_box_and_then_to_another_or_in_another_way_stays_apart(history):
    one, two = SoftBox(azimuth_deg=10.0), SoftBox(azimuth_deg=90.0)
    moved, wide = replace(one, azimuth_deg=20.0), replace(one, azimuth_deg=20.0, width_deg=9.0)
    for now_s, boxes in enumerate(((one, two), (moved, two), (wide, two), (wide, replace(two, width_deg=9.0)))):
        history.observe(lit(boxes=boxes), True, 1.0 + 0.2 * now_s)
    told = ["Move soft box 1", "Resize soft box 1", "Resize soft box 2"]
    assert names(history)[-3:] == told


def test_soft_boxes_that_are_deleted_one_by_one_come_back_one_by_one(history):
    boxes = tuple(SoftBox(azimuth_deg=azimuth_deg) for azimuth_deg in (0.0, 10.0, 20.0))
    for first in range(3):
        history.observe(lit(boxes=boxes[first:]), True, 1.0 + 0.2 * first)
    assert history.undo() == lit(boxes=boxes[1:])
    assert history.undo() == lit(boxes=boxes)


def test_every_stroke_of_the_brush_is_a_step_however_quick(history):
    for count in (1, 2, 3):
        history.observe(painted(*[True] * count), True, 0.1 * count)
    assert history.undo() == painted(True, True)
    assert history.undo() == painted(True)


def test_lamps_that_are_taken_apart_and_put_back_at_once_are_two_steps(history):
    history.observe(lit(boxes=(KEY,), apart=True), True, 1.0)
    history.observe(START, True, 1.3)
    assert history.undo() == lit(boxes=(KEY,), apart=True)
