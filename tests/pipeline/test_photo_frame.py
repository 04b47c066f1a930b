"""The frame a photo comes in: found where there is one, and nobody goes on into it."""

import cv2
import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.pipeline.per_photo.matte import draft_matte
from relight_core.pipeline.per_photo.photo_frame import inside_frame, shrunk_inside


def half_figure(behind):
    """Somebody before a wall of one grey, cut off by the photo's lower border, and the mask."""
    y, x = np.mgrid[0:200, 0:160] + 0.5
    person = (np.hypot((x - 80) / 30, (y - 70) / 40) < 1) | ((y > 120) & (np.abs(x - 80) < 60))
    person |= (y > 70) & (np.abs(x - 80) < 10)
    picture = np.where(person[..., None], (0.5, 0.3, 0.2), behind).astype(np.float32)
    return picture + np.float32(0.1) * np.sin(x * y)[..., None].astype(np.float32) * person[..., None], person


def framed(picture, width, colour):
    return cv2.copyMakeBorder(picture, *(width,) * 4, cv2.BORDER_CONSTANT, value=(colour,) * 3)


@pytest.mark.parametrize("behind", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("colour", [0.0, 1.0])
def test_a_frame_is_found_and_a_wall_of_its_colour_is_part_of_it_up_to_the_person(behind, colour):
    picture, _ = half_figure(behind)
    rows, columns = inside_frame(framed(picture, 12, colour))
    edges = [rows.start, rows.stop, columns.start, columns.stop]
    assert edges == pytest.approx([42, 212, 32, 152] if behind == colour else [12, 212, 12, 172], abs=2)


@pytest.mark.parametrize("behind", [0.0, 0.4, 1.0])
def test_a_plain_wall_is_no_frame(behind):
    picture, person = half_figure(behind)
    assert inside_frame(picture) is None
    round_head = np.where(person[..., None] & (np.mgrid[0:200, 0:160][0] < 110)[..., None], picture, behind)
    assert inside_frame(round_head.astype(np.float32)) is None


@pytest.mark.parametrize("quality", [95, 80, 60])
@pytest.mark.parametrize("width", [10, 43])
@pytest.mark.parametrize("colour", [0.0, 1.0])
def test_a_frame_that_the_picture_rings_in_is_found(quality, width, colour):
    picture, person = half_figure(0.4)
    picture = cv2.resize(picture + np.float32(0.1) * ~person[..., None], None, fx=3, fy=3)
    codes = (255 * framed(np.clip(picture, 0, 1), width, colour)).round().astype(np.uint8)
    shown = cv2.imdecode(cv2.imencode(".jpg", codes, (cv2.IMWRITE_JPEG_QUALITY, quality))[1], cv2.IMREAD_COLOR)
    rows, columns = inside_frame(shown.astype(np.float32) / 255)
    assert (rows.start, rows.stop) == pytest.approx((width, width + 600), abs=3)
    assert (columns.start, columns.stop) == pytest.approx((width, width + 480), abs=3)


def test_nobody_goes_on_into_the_frame():
    picture, person = half_figure(0.4)
    whole, mask = framed(picture, 12, 1.0), framed(np.repeat(person[..., None], 3, 2).astype(np.float32), 12, 0)
    mask[212:, 32:150] = 1.0
    crop = Crop(92.0, 112.0, 224.0)
    draft = draft_matte(whole, [[(crop.extract(mask[..., 0].copy(), 64), crop)]])
    assert draft.share[213:].max() == 0
    assert draft.share[180:205, 60:120].min() > 0.9


def test_what_sticks_up_into_a_wall_of_the_frames_colour_is_not_cut_off():
    picture, person = half_figure(1.0)
    feather = (np.abs(np.mgrid[0:200, 0:160][1] - 80) < 2) & (np.mgrid[0:200, 0:160][0] < 40)
    picture[feather], person = (0.5, 0.3, 0.2), person | feather
    whole, mask = framed(picture, 36, 1.0), framed(np.repeat(person[..., None], 3, 2).astype(np.float32), 36, 0)
    rows, columns = inside_frame(whole)
    assert (rows.start, rows.stop) == (0, 236)
    crop = Crop(116.0, 136.0, 272.0)
    draft = draft_matte(whole, [[(crop.extract(mask[..., 0].copy(), 64), crop)]])
    assert draft.share[238:].max() == 0


def written_on(page, ink):
    """A page (h, w, 3) with lines of dashes on it."""
    page[8:-8:8, 10:-20:3] = page[9:-8:8, 10:-20:3] = ink
    return page


@pytest.mark.parametrize(("above", "below"), [(0, 90), (30, 30), (110, 0)])
@pytest.mark.parametrize(("colour", "ink"), [(0.0, 0.8), (1.0, 0.0)])
def test_bars_and_pages_beside_a_photo_are_found(above, below, colour, ink):
    picture, person = half_figure(0.4)
    page = lambda height: written_on(np.full((height, 160, 3), colour, np.float32), ink)  # noqa: E731
    whole = np.concatenate([page(above), picture, page(below)])
    assert inside_frame(whole) == (slice(above, above + 200), slice(0, 160))
    assert inside_frame(whole.swapaxes(0, 1)) == (slice(0, 160), slice(above, above + 200))


def test_a_photo_within_a_page_that_is_written_on_is_found():
    picture, _ = half_figure(0.4)
    page = written_on(np.ones((400, 200, 3), np.float32), 0.0)
    page[80:320] = 1.0
    page[100:300, 20:180] = picture
    assert inside_frame(page) == (slice(100, 300), slice(20, 180))


def test_two_colours_of_a_wall_with_somebody_before_them_are_no_bar():
    picture, person = half_figure(0.4)
    picture[:70][~person[:70]] = 1.0
    assert inside_frame(picture) is None


def test_bars_that_meet_are_stripes_of_the_picture():
    """Each looks like what is written on the other, and together they would leave nothing of anybody."""
    picture = np.zeros((400, 300, 3), np.float32)
    picture[188:200] = picture[228:] = 1.0
    picture[300:340, 100:140] = 0.5
    assert inside_frame(picture) is None


def test_another_photo_is_no_bar():
    picture, _ = half_figure(0.4)
    between = np.ones((8, 160, 3), np.float32)
    busy = np.random.default_rng(0).random((120, 160, 3)).astype(np.float32)
    assert inside_frame(np.concatenate([picture, between, busy])) is None


def test_cells_of_a_smaller_copy_lie_wholly_within_a_frame():
    inside = slice(30, 500), slice(0, 800)
    assert shrunk_inside(inside, (1000, 800), (100, 80)) == (slice(3, 50), slice(0, 80))
    assert shrunk_inside(inside, (1000, 800), (64, 51)) == (slice(2, 32), slice(0, 51))
