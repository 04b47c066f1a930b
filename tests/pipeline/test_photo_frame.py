"""The frame a photo comes in: found where there is one, and nobody goes on into it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.imaging.photo_frame import going_on, inside_frame, shrunk_inside, whole_inside
from relight_core.imaging.resampling import shrunk_size
from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.per_photo.brush import BrushStroke
from relight_core.pipeline.per_photo.first_matte import SeenPeople
from relight_core.pipeline.per_photo.matte import Matte, draft_matte, finish_matte
from relight_core.pipeline.per_photo.network_view import network_view
from relight_core.pipeline.per_photo.person import canvas_of, whole_person
from relight_core.pipeline.per_photo.portrait import frame
from relight_core.pipeline.results.finish import PhotoProperties, place_views, weights_on_views


def half_figure(behind):
    """Somebody before a wall of one grey, cut off by the photo's lower border, and the mask."""
    y, x = np.mgrid[0:200, 0:160] + 0.5
    person = (np.hypot((x - 80) / 30, (y - 70) / 40) < 1) | ((y > 120) & (np.abs(x - 80) < 60))
    person |= (y > 70) & (np.abs(x - 80) < 10)
    picture = np.where(person[..., None], (0.5, 0.3, 0.2), behind).astype(np.float32)
    return picture + np.float32(0.1) * np.sin(x * y)[..., None].astype(np.float32) * person[..., None], person


def framed(picture, width, colour):
    return cv2.copyMakeBorder(picture, *(width,) * 4, cv2.BORDER_CONSTANT, value=(colour,) * 3)


@pytest.mark.parametrize("behind", [0.0, 0.1, 0.4, 0.9, 1.0])
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


@pytest.mark.parametrize(("grain", "is_frame"), [(4 / 255, True), (10 / 255, False)])
def test_a_grainy_wall_around_a_picture_is_no_frame_but_paper_may_be_a_little_uneven(grain, is_frame):
    whole = framed(half_figure(0.4)[0], 30, 0.8)
    uneven = np.random.default_rng(0).uniform(-grain, grain, whole.shape).astype(np.float32)
    inner = uneven[30:-30, 30:-30]
    inner[:] = 0
    assert (inside_frame(whole + uneven) is not None) == is_frame


@pytest.mark.parametrize(("width", "is_frame"), [(40, False), (80, True)])
def test_around_a_wall_of_its_colour_a_frame_is_known_by_the_line_that_cuts_somebody_off(width, is_frame):
    y, x = np.mgrid[0:200, 0:160] + 0.5
    person = (np.hypot((x - 80) / 70, (y - 100) / 90) < 1) | ((y > 100) & (np.abs(x - 80) < width / 2))
    picture = np.where(person[..., None], (0.5, 0.3, 0.2), 1.0).astype(np.float32)
    assert (inside_frame(framed(picture, 12, 1.0)) is not None) == is_frame


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
    draft = draft_matte(Photo(whole), lambda: SeenPeople([[(crop.extract(mask[..., 0].copy(), 64), crop)]]))
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
    draft = draft_matte(Photo(whole), lambda: SeenPeople([[(crop.extract(mask[..., 0].copy(), 64), crop)]]))
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
    assert shrunk_inside((slice(30, 505), slice(90, 780)), (1000, 800), (64, 51)) == (slice(2, 32), slice(6, 49))


@pytest.mark.parametrize("length", [1122, 1138, 1151, 1195])
def test_a_side_without_a_frame_ends_with_the_copy(length):
    whole = slice(0, length), slice(100, length)
    assert shrunk_inside(whole, (length, length), (1024, 1024))[0] == slice(0, 1024)


@pytest.mark.parametrize("size", [(1012, 1385), (1012, 1459), (1383, 2051)])
def test_a_side_without_a_frame_ends_with_the_photo_though_its_last_rows_are_plain(size):
    """Nothing beyond the photo is asked for either."""
    small = shrunk_size(size, 1024)

    def shown(part):
        assert all(span.stop <= most for span, most in zip(part, size, strict=True))
        rows, columns = (np.arange(most)[span] for most, span in zip(size, part, strict=True))
        plain = (rows[:, None] >= size[0] - 4) | (columns < 100)
        return np.where(plain, 0.5, (rows[:, None] * 7 + columns) % 9 / 9)[..., None].repeat(3, 2).astype(np.float32)

    known = slice(0, small[0]), slice(round(100 * small[1] / size[1]), small[1])
    assert whole_inside(known, small, size, shown) == (slice(0, size[0]), slice(100, size[1]))


def test_what_lies_within_a_frame_goes_on_over_it_as_its_edge():
    part = np.arange(6, dtype=np.float32).reshape(2, 3)
    for image in (part, part[..., None].repeat(3, 2)):
        over = np.pad(image, ((1, 2), (2, 1), (0, 0))[: image.ndim], "edge")
        np.testing.assert_array_equal(going_on(image, (slice(1, 3), slice(2, 5)), (5, 6)), over)


def street():
    """A picture (200, 160, 3), linear, that is nowhere plain."""
    y, x = np.mgrid[0:200, 0:160] / 30
    colours = 0.4 + 0.2 * np.sin(x + y), 0.4 + 0.2 * np.cos(x - y), 0.3 + 0.1 * np.sin(2 * x)
    return np.dstack(colours).astype(np.float32)


@pytest.mark.parametrize("exposure", [1.0, 0.05, 30.0])
@pytest.mark.parametrize("colour", [0.0, 1.0])
def test_the_picture_of_a_photo_is_what_lies_well_within_its_frame(colour, exposure):
    assert Photo(street()).picture == (0, 0, 160, 200)
    found = Photo(framed(street(), 12, colour) * np.float32(exposure)).picture
    assert found == pytest.approx((13, 13, 171, 211), abs=1)


@pytest.mark.parametrize("colour", [0.0, 1.0])
def test_nothing_of_a_frames_soft_edge_is_part_of_the_picture(colour):
    picture = street()
    inner = picture[1:-1, 1:-1].copy()
    picture = (picture + np.float32(colour)) / 2
    picture[1:-1, 1:-1] = inner
    x0, y0, x1, y1 = Photo(framed(picture, 12, colour)).picture
    assert 13 <= min(x0, y0) <= max(x0, y0) <= 14
    assert (170 <= x1 <= 171, 210 <= y1 <= 211) == (True, True)


def test_the_picture_of_a_large_photo_ends_within_its_frame():
    large = framed(cv2.resize(street(), (1600, 2000)), 100, 1.0)
    assert Photo(large).picture == pytest.approx((105, 105, 1695, 2095), abs=5)


def test_a_wall_of_the_frames_colour_stays_in_the_picture():
    picture, _ = half_figure(1.0)
    x0, y0, x1, y1 = Photo(framed(picture, 12, 1.0)).picture
    assert (x0, y0, x1) == (0, 0, 184)
    assert y1 == pytest.approx(212, abs=2)


def test_a_white_cap_at_the_border_does_not_hide_a_white_frame():
    picture = street()
    picture[:20, 24:-24] = 1.0
    assert Photo(framed(picture, 12, 1.0)).picture == pytest.approx((12, 12, 172, 212), abs=2)


def test_a_cut_out_has_no_frame():
    alpha = np.ones((224, 184), np.float32)
    alpha[0] = 0
    assert Photo(framed(street(), 12, 1.0), alpha).picture == (0, 0, 184, 224)


@pytest.mark.parametrize("roll_deg", [0.0, 20.0])
def test_networks_see_a_framed_photo_as_if_it_had_no_frame(roll_deg):
    bare, in_frame = Photo(street()), Photo(framed(street(), 24, 1.0))
    view = Crop(30.0, 180.0, 120.0, roll_deg)
    seen, seen_bare = network_view(in_frame, view.moved(24, 24), 64, 1.0), network_view(bare, view, 64, 1.0)
    # What goes on begins a pixel or two farther in.
    assert np.abs(seen - seen_bare).max() < 0.05


@pytest.mark.parametrize(("down", "across"), [(24, 60), (60, 24)])
def test_nor_does_a_frame_that_is_wider_on_two_sides_move_what_they_see(down, across):
    whole = cv2.copyMakeBorder(street(), down, down, across, across, cv2.BORDER_CONSTANT, value=(1.0,) * 3)
    view = Crop(80.0, 100.0, 80.0)
    seen = network_view(Photo(whole), view.moved(across, down), 64, 1.0)
    np.testing.assert_allclose(seen, network_view(Photo(street()), view, 64, 1.0), atol=0.01)
    box = FaceBox(15.0 + across, 60.0 + down, 85.0 + across, 140.0 + down)
    x0, y0, x1, y1 = frame(Photo(whole), box).view.window
    assert across <= x0 < x1 <= across + 160
    assert down <= y0 < y1 <= down + 200


def test_a_view_keeps_within_the_frame_as_within_the_photo():
    box = FaceBox(15.0, 60.0, 85.0, 140.0)
    moved = replace(box, x0=39.0, y0=84.0, x1=109.0, y1=164.0)
    bare, in_frame = frame(Photo(street()), box), frame(Photo(framed(street(), 24, 1.0)), moved)
    assert bare.view.window[0] == 0
    assert in_frame.view.window == pytest.approx(bare.view.moved(24, 24).window, abs=4)
    assert in_frame.exposure == pytest.approx(bare.exposure, rel=0.05)


def test_the_matte_of_a_framed_photo_is_that_of_the_photo():
    picture, person = street(), half_figure(0.4)[1]
    white_shirt = person & (np.mgrid[0:200, 0:160][0] > 120)
    picture[person], picture[white_shirt] = (0.5, 0.3, 0.2), 0.97
    # Networks that see somebody cut off by a frame are in doubt.
    mask, view = np.where(white_shirt, 0.5, person).astype(np.float32), Crop(80.0, 70.0, 140.0)
    looks, whole = [(view.extract(mask, 64), view)], framed(picture, 24, 1.0)
    in_frame = [(mask, view.moved(24, 24)) for mask, view in looks]
    share = draft_matte(Photo(whole), lambda: SeenPeople([in_frame])).share
    assert np.abs(share[24:-24, 24:-24] - draft_matte(Photo(picture), lambda: SeenPeople([looks])).share).mean() < 0.02
    assert share[:22].max() == share[-22:].max() == share[:, :22].max() == share[:, -22:].max() == 0


IN_FRAME = PhotoProperties(picture=(24, 24, 184, 224))


def weights_in_frame(view: Crop) -> np.ndarray:
    """(50, 50) how much a view of a framed photo counts, whose picture is from 24, 24 to 184, 224."""
    photo, everywhere = Photo(framed(street(), 24, 1.0)), np.ones((248, 208), np.float32)
    matte = Matte(np.zeros_like(everywhere), everywhere, np.zeros((2, 2, 3)), np.zeros((2, 2, 3)), everywhere)
    placement = place_views(canvas_of(photo), [view], matte, ReflectionTable(), photo=IN_FRAME)
    return weights_on_views(placement, 50)[0].of_views[0][..., 0]


@pytest.mark.parametrize(
    ("view", "unfaded"),
    [
        (Crop(74.0, 124.0, 100.0), ["left"]),
        (Crop(134.0, 124.0, 100.0), ["right"]),
        (Crop(104.0, 74.0, 100.0), ["top"]),
        (Crop(104.0, 174.0, 100.0), ["bottom"]),
        (Crop(64.0, 124.0, 100.0), ["left"]),
        (Crop(104.0, 124.0, 100.0), []),
        (Crop(74.0, 124.0, 100.0, 10.0), []),
    ],
)
def test_a_view_fades_toward_the_sides_beyond_which_the_picture_goes_on(view, unfaded):
    weights = weights_in_frame(view)
    sides = {"left": weights[25, 0], "right": weights[25, -1], "top": weights[0, 25], "bottom": weights[-1, 25]}
    assert [side for side, weight in sides.items() if weight == 1] == unfaded
    assert max(weight for side, weight in sides.items() if side not in unfaded) < 0.1


def test_a_view_hardly_fades_near_a_frame_and_not_at_it():
    assert weights_in_frame(Crop(104.0, 124.0, 100.0))[25, :5].max() < 0.9
    assert weights_in_frame(Crop(74.0, 124.0, 100.0))[25, :25].min() == 1
    a_pixel_off = weights_in_frame(Crop(75.0, 124.0, 100.0))[25, :25]
    assert a_pixel_off[0] < 0.5
    assert a_pixel_off[2:].min() == 1


@pytest.mark.parametrize("roll_deg", [0.0, 45.0])
@pytest.mark.parametrize("centre", [(700.0, 900.0), (130.0, 110.0), (-900.0, 500.0), (3000.0, 3000.0)])
def test_a_view_of_a_framed_photo_reads_what_is_about_it_alone(centre, roll_deg, monkeypatch):
    photo = Photo(framed(cv2.resize(street(), (1600, 2000)), 100, 1.0))
    x0, y0, x1, y1 = photo.picture
    view = Crop(*centre, 200.0, roll_deg)
    whole = view.moved(-x0, -y0).extract(np.ascontiguousarray(photo.linear[y0:y1, x0:x1]), 64)
    read, extract = [], Crop.extract

    def reading(crop, image, size):
        read.append(image.size)
        return extract(crop, image, size)

    monkeypatch.setattr(Crop, "extract", reading)
    assert np.abs(network_view(photo, view, 64, 1.0) - whole).max() < 1e-5
    assert max(read) < 3 * 320**2


@pytest.mark.parametrize("quality", [None, 90])
def test_where_a_frame_ends_in_a_copy_it_ends_to_a_pixel_in_the_photo(quality):
    picture, _ = half_figure(0.4)
    picture = cv2.resize(picture, (1280, 1600), interpolation=cv2.INTER_CUBIC)
    whole = cv2.copyMakeBorder(picture, 101, 130, 67, 103, cv2.BORDER_CONSTANT, value=(1.0,) * 3)
    if quality:
        codes = (255 * np.clip(whole, 0, 1)).round().astype(np.uint8)
        jpeg = cv2.imencode(".jpg", codes, (cv2.IMWRITE_JPEG_QUALITY, quality))[1]
        whole = cv2.imdecode(jpeg, cv2.IMREAD_COLOR).astype(np.float32) / 255
    known = slice(51, 851), slice(34, 674)
    assert whole_inside(known, (916, 725), whole.shape[:2], whole.__getitem__) == (slice(101, 1701), slice(67, 1347))


@pytest.mark.parametrize("painted_above", [False, True])
def test_a_white_shirt_ends_with_the_photo_where_its_white_frame_begins(painted_above):
    picture, person = street(), half_figure(0.4)[1]
    picture[person] = 0.97
    picture, person = (np.repeat(np.repeat(image, 8, 0), 8, 1) for image in (picture, person))
    view = Crop(640.0, 800.0, 1600.0)
    looks = [(view.extract(person.astype(np.float32), 64), view.moved(151, 151))]
    photo = Photo(framed(picture, 151, 1.0))
    strokes = [BrushStroke(((200.0, 80.0), (1300.0, 80.0)), 40.0, True)] if painted_above else []
    matte = finish_matte(draft_matte(photo, lambda: SeenPeople([looks])), strokes)
    share = whole_person(canvas_of(photo), matte).share
    assert max(matte.level.shape) <= 1024
    assert share[1750, 500:1100].min() > 0.95
    assert share[1751:].max() == 0


def test_what_is_painted_into_a_frame_stays():
    photo = Photo(framed(np.repeat(np.repeat(street(), 8, 0), 8, 1), 224, 1.0))
    looks = [(np.zeros((64, 64), np.float32), Crop(640.0, 560.0, 1120.0))]
    strokes = [BrushStroke(((300.0, 80.0), (1400.0, 80.0)), 40.0, True)]
    strokes += [BrushStroke(((700.0, 60.0), (700.0, 450.0)), 80.0, True)]
    matte = finish_matte(draft_matte(photo, lambda: SeenPeople([looks])), strokes)
    share = whole_person(canvas_of(photo), matte).share
    assert share[80, 400:1300].min() > 0.9
    assert share[80:430, 660:740].min() > 0.9
    assert share[130:300, 950:].max() < 0.05
