"""Square crops of a photo, turned ones too, and the box of a face in a parsing."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relight_core.face.crop import Crop, box_from_parsing, crop_for_face, crop_with_padding
from relight_core.face.find import FaceBox
from relight_core.face.parsing import CLASSES

SKIN, HAIR, NOSE = 1, 10, 6
RNG = np.random.default_rng(4)


def test_points_go_to_the_photo_and_back():
    crop = Crop(310.5, 200.0, 400.0)
    points = RNG.uniform(0, 256, (10, 2))
    np.testing.assert_allclose(crop.from_photo(crop.to_photo(points, 256), 256), points)
    np.testing.assert_allclose(crop.to_photo(np.array([0, 0]), 256), [110.5, 0.0])
    np.testing.assert_allclose(crop.to_photo(np.array([256, 256]), 256), [510.5, 400.0])


def test_extract_takes_what_lies_at_those_points():
    y, x = np.mgrid[0:300, 0:400] + 0.5
    image = np.dstack([x, y]).astype(np.float32)
    for crop, size in ((Crop(200.0, 150.0, 100.0), 32), (Crop(180.3, 120.7, 20.0), 64)):
        centres = np.stack(np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5), axis=-1)
        np.testing.assert_allclose(crop.extract(image, size), crop.to_photo(centres, size), atol=0.1)


def test_shrinking_averages_everything():
    checks = (np.indices((256, 256)).sum(axis=0) % 2).astype(np.float32)
    np.testing.assert_allclose(Crop(128.0, 128.0, 256.0).extract(checks, 32), 0.5, atol=1e-6)
    spark = np.zeros((256, 256), np.float32)
    spark[101, 77] = 64.0
    assert Crop(128.0, 128.0, 256.0).extract(spark, 32).sum() == pytest.approx(1.0)


def test_beyond_the_border_the_edge_goes_on():
    image = np.zeros((50, 50, 3), np.float32)
    image[:, :25] = 1.0
    crop = Crop(25.0, 25.0, 150.0).extract(image, 30)
    np.testing.assert_allclose(crop[:, :14], 1.0)
    np.testing.assert_allclose(crop[:, 16:], 0.0)
    assert Crop(-500.0, 900.0, 20.0).extract(image, 8).min() == 1.0


def test_a_padded_crop_copies_whole_pixels():
    image = RNG.random((300, 300, 3)).astype(np.float32)
    crop = crop_with_padding(FaceBox(100.3, 90.2, 190.8, 185.9))
    x0, y0, x1, y1 = crop.window
    assert all(edge == int(edge) for edge in crop.window)
    np.testing.assert_array_equal(crop.extract(image, int(crop.side)), image[int(y0) : int(y1), int(x0) : int(x1)])


POSITION, LENGTH = st.floats(-100, 2000), st.floats(40, 900)


@given(POSITION, POSITION, LENGTH, LENGTH)
def test_the_padding_is_kept_at_256(x0, y0, width, height):
    crop = crop_with_padding(FaceBox(x0, y0, x0 + width, y0 + height))
    (left, top), (right, bottom) = crop.from_photo(np.array([[x0, y0], [x0 + width, y0 + height]]), 256)
    pixel = 256 / crop.side
    horizontal, vertical = min(left, 256 - right), min(top, 256 - bottom)
    assert min(horizontal, vertical) == pytest.approx(30, abs=2 * pixel)
    assert abs((left + right) / 2 - 128) <= pixel
    assert abs((top + bottom) / 2 - 128) <= pixel


def test_the_first_crop_has_room_for_the_forehead():
    box = FaceBox(100.0, 100.0, 200.0, 200.0)
    crop = crop_for_face(box)
    (left, brow), (right, chin) = crop.from_photo(np.array([[100, 100], [200, 200]]), 256)
    assert chin == pytest.approx(256 - 30, abs=3)
    assert 30 + 30 < brow < 30 + 60
    assert left > 30
    assert right < 226


def test_no_side_and_no_box():
    for side in (0.0, -3.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="crop"):
            Crop(0.0, 0.0, side)
    assert crop_with_padding(FaceBox(5.0, 5.0, 5.0, 5.0)).side == 1.0


def certain(labels):
    return np.moveaxis(np.eye(len(CLASSES), dtype=np.float32)[labels], -1, 0)


def labels_of(face=(60, 50, 180, 200), size=256):
    labels = np.zeros((size, size), np.int64)
    labels[:40] = HAIR
    x0, y0, x1, y1 = face
    labels[y0:y1, x0:x1] = SKIN
    labels[y0 + 60 : y0 + 80, x0 + 50 : x0 + 70] = NOSE
    return labels


def parsing(face=(60, 50, 180, 200)):
    return certain(labels_of(face))


def test_the_parsing_box_is_the_face_in_the_photo():
    crop = Crop(512.0, 300.0, 512.0)
    box = box_from_parsing(parsing(), crop)
    left, top = 512 - 256, 300 - 256
    assert (box.x0, box.y0, box.x1, box.y1) == (left + 120, top + 100, left + 360, top + 400)


def test_specks_and_hair_do_not_count():
    labels = labels_of()
    labels[250, 3] = SKIN
    labels[5:9, 240:246] = NOSE
    labels[120:122, 180:240] = SKIN
    assert box_from_parsing(certain(labels), Crop(0, 0, 256)) == box_from_parsing(parsing(), Crop(0, 0, 256))


def test_the_box_moves_by_as_much_as_the_face_does():
    soft = cv2.GaussianBlur((labels_of() == SKIN).astype(np.float32), (0, 0), 1.5)
    boxes = []
    for shift_px in np.linspace(0, 1, 6):
        share = cv2.warpAffine(soft, np.array([[1, 0, shift_px], [0, 1, 0]]), (256, 256))
        probabilities = np.zeros((len(CLASSES), 256, 256), np.float32)
        probabilities[SKIN], probabilities[HAIR] = share, 1 - share
        boxes.append(box_from_parsing(probabilities, Crop(128, 128, 256)))
    np.testing.assert_allclose(np.diff([(box.x0, box.x1) for box in boxes], axis=0), 0.2, atol=0.06)


def test_a_face_that_the_view_cuts_off_ends_with_it():
    box = box_from_parsing(parsing(face=(0, 50, 180, 256)), Crop(128, 128, 256))
    np.testing.assert_allclose([box.x0, box.y0, box.x1, box.y1], (0, 50, 180, 256), atol=1e-3)


def test_what_is_some_part_of_a_face_or_another_is_face():
    undecided = 0.35 * (certain(labels_of()) + np.roll(certain(labels_of()), NOSE - SKIN, 0))
    undecided[HAIR] = 1 - undecided[[SKIN, NOSE]].sum(0)
    box = box_from_parsing(undecided, Crop(128, 128, 256))
    np.testing.assert_allclose([box.x0, box.y0, box.x1, box.y1], (60, 50, 180, 200), atol=0.3)


def test_without_a_face_there_is_no_box():
    crop = Crop(128, 128, 256)
    assert box_from_parsing(certain(np.zeros((256, 256), int)), crop) is None
    assert box_from_parsing(certain(np.full((256, 256), HAIR)), crop) is None
    assert box_from_parsing(certain(np.where(np.arange(256) == 3, SKIN, np.zeros((256, 1), int))), crop) is None


def test_refining_a_crop_settles_at_once():
    rng_box = FaceBox(200.0, 180.0, 320.0, 330.0)
    crop = crop_for_face(rng_box)
    x0, y0 = np.rint(crop.from_photo(np.array([205, 150]), 256)).astype(int)
    x1, y1 = np.rint(crop.from_photo(np.array([315, 330]), 256)).astype(int)
    box = box_from_parsing(parsing(face=(x0, y0, x1, y1)), crop)
    assert (box.x0, box.y0, box.x1, box.y1) == pytest.approx((205, 150, 315, 330), abs=1.0)


def test_the_box_of_a_leaning_head_leans_and_is_as_large_as_that_of_an_upright_one():
    upright, turned = Crop(512.0, 300.0, 512.0), Crop(512.0, 300.0, 512.0, 25.0)
    straight, leaning = (box_from_parsing(parsing(face=(60, 50, 180, 200)), crop) for crop in (upright, turned))
    assert leaning.roll_deg == 25.0
    assert (leaning.width, leaning.height) == pytest.approx((straight.width, straight.height))
    middle = ((leaning.x0 + leaning.x1) / 2, (leaning.y0 + leaning.y1) / 2)
    np.testing.assert_allclose(turned.from_photo(np.array(middle), 256), [120, 125])
    assert crop_with_padding(leaning).roll_deg == 25.0


def test_a_turned_crop_stands_a_leaning_head_upright():
    """A bar that leans to the left by 30 degrees is vertical in a crop of roll 30."""
    y, x = np.mgrid[0:200, 0:200] + 0.5 - 100
    angle = np.radians(30)
    along, across = -(x * np.sin(angle)) - y * np.cos(angle), x * np.cos(angle) - y * np.sin(angle)
    bar = ((np.abs(across) < 4) & (along > 0) & (along < 60)).astype(np.float32)
    upright = Crop(100.0, 100.0, 140.0, 30.0).extract(bar, 70)
    assert upright[10:30, 33:37].min() > 0.6
    assert upright[40:].max() < 0.1


def test_points_of_a_turned_crop_go_to_the_photo_and_back():
    crop = Crop(50.0, 60.0, 40.0, 25.0)
    points = np.random.default_rng(0).uniform(0, 64, (10, 2))
    np.testing.assert_allclose(crop.from_photo(crop.to_photo(points, 64), 64), points, atol=1e-9)
    np.testing.assert_allclose(crop.to_photo(np.array([32, 32]), 64), (50, 60))


def test_a_turned_crop_keeps_the_mean_of_an_even_picture():
    even = np.full((80, 90, 3), 0.4, np.float32)
    np.testing.assert_allclose(Crop(40.0, 40.0, 60.0, -45.0).extract(even, 32), 0.4, atol=1e-6)


@pytest.mark.parametrize("roll_deg", [0.0, 30.0, -45.0, 90.0, 180.0])
def test_the_forehead_lies_above_the_brows_of_a_leaning_face_too(roll_deg):
    crop = crop_for_face(FaceBox(400.0, 300.0, 800.0, 800.0, roll_deg))
    x, y = crop.from_photo(np.array([600.0, 550.0]), 256)
    assert (x, y) == pytest.approx((128.0, 128.0 + 0.125 * 500 * 256 / crop.side), abs=0.5)
    assert crop.side == crop_for_face(FaceBox(400.0, 300.0, 800.0, 800.0)).side


@pytest.mark.parametrize("crop", [Crop(150.0, 140.0, 90.0, 30.0), Crop(160.3, 150.7, 50.0, -45.0)])
def test_a_turned_crop_takes_what_lies_at_its_points_up_to_its_corners(crop):
    y, x = np.mgrid[0:300, 0:300] + 0.5
    centres = np.stack(np.meshgrid(np.arange(40) + 0.5, np.arange(40) + 0.5), axis=-1)
    seen = crop.extract(np.dstack([x, y]).astype(np.float32), 40)
    np.testing.assert_allclose(seen, crop.to_photo(centres, 40), atol=0.1)


def test_no_points_go_nowhere():
    for mapped in (Crop(9.0, 9.0, 4.0, 20.0).to_photo, Crop(9.0, 9.0, 4.0).from_photo):
        assert mapped(np.zeros((0, 2)), 16).shape == (0, 2)


def test_a_small_face_has_a_box_and_one_that_the_view_cuts_ends_with_it():
    parsing = np.zeros((len(CLASSES), 64, 64), np.float32)
    parsing[SKIN, 20:30, 30:40] = 1
    box = box_from_parsing(parsing, Crop(64.0, 64.0, 128.0))
    assert (box.x0, box.y0, box.x1, box.y1) == pytest.approx((60, 40, 80, 60))
    parsing[SKIN, 10:50, :20] = 0.8
    box = box_from_parsing(parsing, Crop(64.0, 64.0, 128.0))
    assert box.x0 == 0
