"""Faces that cascades find in a photo, and what they guess where they find none."""

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
import skimage.data

from relight_core.face import cascades, find
from relight_core.face.cascades import Candidate
from relight_core.face.find import (
    FaceBox,
    find_faces,
    find_faces_beyond_doubt,
    find_small_faces,
    guess_companions,
    guess_faces,
    remember_faces,
)
from relight_core.imaging.photo import Photo

ASTRONAUT = skimage.data.astronaut()
# Brow to chin, cheek to cheek, measured by eye in the 512 x 512 picture.
FACE = (186.0, 92.0, 262.0, 170.0)


def share_in_common(box, truth):
    width = min(box.x1, truth[2]) - max(box.x0, truth[0])
    height = min(box.y1, truth[3]) - max(box.y0, truth[1])
    if width <= 0 or height <= 0:
        return 0.0
    areas = box.width * box.height + (truth[2] - truth[0]) * (truth[3] - truth[1])
    return width * height / (areas - width * height)


def found_in(srgb):
    return find_faces(Photo.from_srgb(np.ascontiguousarray(srgb)))


def test_the_sample_portrait_has_one_face():
    boxes = found_in(ASTRONAUT)
    assert len(boxes) == 1
    assert share_in_common(boxes[0], FACE) > 0.8


@pytest.mark.parametrize("exposure", [0.02, 8.0])
def test_dark_and_overbright_photos(exposure):
    linear = Photo.from_srgb(ASTRONAUT).linear * np.float32(exposure)
    assert share_in_common(find_faces(Photo(linear))[0], FACE) > 0.7


@pytest.mark.parametrize("around", [0, 150])
def test_a_face_against_the_light_is_found(around):
    rows, columns = np.mgrid[: 260 + 2 * around, : 240 + 2 * around] - around
    person = np.hypot((columns - 120) / 80, (rows - 130) / 110) < 1
    person |= (rows > 220) & (abs(columns - 120) < 100 + around)
    dark = 0.002 * Photo.from_srgb(np.pad(ASTRONAUT[:260, 100:340], ((around,) * 2,) * 2 + ((0, 0),), "edge")).linear
    boxes = find_faces(Photo(np.where(person[..., None], dark, 1.0).astype(np.float32)))
    assert len(boxes) == 1
    assert share_in_common(boxes[0], tuple(np.array(FACE) + (around - 100, around, around - 100, around))) > 0.7


def test_the_box_follows_the_face():
    moved = np.pad(ASTRONAUT, ((100, 0), (60, 200), (0, 0)), mode="edge")
    box = found_in(moved)[0]
    assert share_in_common(box, (FACE[0] + 60, FACE[1] + 100, FACE[2] + 60, FACE[3] + 100)) > 0.7


def test_small_photos_are_enlarged_to_look_at():
    box = found_in(ASTRONAUT[40:220:2, 120:320:2])[0]
    assert share_in_common(box, tuple((np.array(FACE) - (120, 40, 120, 40)) / 2)) > 0.7


def test_two_faces_come_largest_first():
    face = ASTRONAUT[20:240, 120:340]
    pair = np.full((260, 500, 3), 128, np.uint8)
    pair[20:130, 40:150] = face[::2, ::2]
    pair[20:240, 220:440] = face
    boxes = found_in(pair)
    assert len(boxes) == 2
    assert boxes[0].width > 1.5 * boxes[1].width
    assert boxes[0].x0 > 220 > boxes[1].x1


@pytest.mark.parametrize(
    ("width", "votes", "is_searched_finely"), [(240.0, 40, False), (180.0, 40, True), (240.0, 39, True)]
)
def test_beside_a_large_face_that_is_sure_nobody_looks_for_tiny_heads(monkeypatch, width, votes, is_searched_finely):
    looked = []
    face = Candidate(np.array([200.0, 200.0, 200.0 + width, 400.0]), votes, 3)
    monkeypatch.setattr(find, "frontal_candidates", lambda grey, smallest_px=28: looked.append(smallest_px) or [face])
    monkeypatch.setattr(find, "_turned_away", lambda grey: [])
    assert [box.width for box in find_faces(Photo(np.full((800, 600, 3), 0.2, np.float32)))] == [width]
    assert looked == ([80, 28] if is_searched_finely else [80])


def test_a_tilted_head_is_found():
    from skimage.transform import rotate

    tilted = rotate(ASTRONAUT[:300, 70:370], 33, mode="edge", preserve_range=True).astype(np.uint8)
    boxes = found_in(tilted)
    assert boxes
    centre = np.array([boxes[0].x0 + boxes[0].x1, boxes[0].y0 + boxes[0].y1]) / 2
    angle = np.radians(33)
    offset = np.array([(FACE[0] + FACE[2]) / 2 - 70 - 150, (FACE[1] + FACE[3]) / 2 - 150])
    assert boxes[0].roll_deg == 30
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    assert np.hypot(*(centre - 150 - turn @ offset)) < 20


@pytest.mark.parametrize("name", ["coffee", "chelsea", "rocket"])
def test_pictures_without_people_have_no_face(name):
    assert found_in(getattr(skimage.data, name)()) == []


@pytest.mark.parametrize("size", [(1, 1), (5, 5), (2, 900), (300, 7), (40, 40), (200, 300)])
def test_noise_of_any_size_has_no_face(size):
    noise = np.random.default_rng(0).integers(0, 256, (*size, 3)).astype(np.uint8)
    assert found_in(noise) == []


@pytest.mark.parametrize("level", [0.0, 0.5, 1e6])
def test_flat_pictures_have_no_face(level):
    assert find_faces(Photo(np.full((60, 80, 3), level, np.float32))) == []


@pytest.mark.parametrize("look", [find_faces, find_small_faces])
def test_a_face_of_40_pixels_in_a_large_photo(look):
    small = ASTRONAUT[::2, ::2]
    photo = np.full((900, 1300, 3), 120, np.uint8)
    photo[300:556, 600:856] = small
    boxes = look(Photo.from_srgb(photo))
    assert len(boxes) == 1
    assert share_in_common(boxes[0], (693, 346, 731, 385)) > 0.5


def test_a_photo_is_searched_once_and_answers_are_copies(monkeypatch):
    searched = []
    monkeypatch.setattr(find, "_search", lambda photo, is_face: searched.append(photo) or [FaceBox(1, 2, 3, 4)])
    one, other = (Photo(np.zeros((8, 8, 3), np.float32)) for _ in range(2))
    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(find_faces, [one, one, other, one]))
    assert searched.count(one) == searched.count(other) == 1
    answers[0].clear()
    assert find_faces(one) == [FaceBox(1, 2, 3, 4)]


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_face_that_lies_is_among_the_guesses(quarters):
    lying = Photo.from_srgb(np.ascontiguousarray(np.rot90(ASTRONAUT[20:260, 100:340], quarters)))
    middle = np.array([(FACE[0] + FACE[2]) / 2 - 100 - 120, (FACE[1] + FACE[3]) / 2 - 20 - 120])
    for _ in range(quarters):
        middle = np.array([middle[1], -middle[0]])
    expected = {1: 90, 2: 180, 3: -90}[quarters]
    near = [
        guess
        for guess in guess_faces(lying)
        if np.hypot((guess.x0 + guess.x1) / 2 - 120 - middle[0], (guess.y0 + guess.y1) / 2 - 120 - middle[1]) < 25
    ]
    assert any(abs((guess.roll_deg - expected + 180) % 360 - 180) <= 30 for guess in near)
    assert all(guess.doubtful for guess in near)


def test_what_is_known_better_is_remembered():
    photo = Photo(np.zeros((8, 8, 3), np.float32))
    faces = [FaceBox(1, 2, 3, 4)]
    remember_faces(photo, faces)
    faces.clear()
    assert find_faces(photo) == [FaceBox(1, 2, 3, 4)]


def test_a_face_that_fills_the_photo_is_the_last_guess():
    last = guess_faces(Photo.from_srgb(ASTRONAUT[100:172, 186:262]))[-1]
    assert last.doubtful
    assert share_in_common(last, (0, 0, 76, 72)) > 0.7


def test_faces_from_the_side_are_guessed_though_others_get_more_votes(monkeypatch):
    side = Candidate(np.array([100.0, 200.0, 160.0, 280.0]), 3, 1)
    loud = [Candidate(np.array([left, 0.0, left + 10.0, 10.0]), 50, 2) for left in range(0, 380, 12)]
    monkeypatch.setattr(find, "every_profile_hit", lambda grey: [side])
    monkeypatch.setattr(find, "every_hit", lambda grey: list(loud))
    guesses = guess_faces(Photo(np.zeros((400, 400, 3), np.float32)))
    assert guesses[0] == FaceBox(100.0, 200.0, 160.0, 280.0, doubtful=True)
    assert len(guesses) == 17


def beside_itself(roll_deg):
    """The sample portrait, and to its right the same, leaning; and where the leaning face's middle is."""
    matrix = cv2.getRotationMatrix2D((224.0, 131.0), roll_deg, 1.0)
    leaning = cv2.warpAffine(ASTRONAUT, matrix, (512, 512), borderMode=cv2.BORDER_REPLICATE)
    return Photo.from_srgb(np.concatenate([ASTRONAUT, leaning], 1)), (512 + 224.0, 131.0)


@pytest.mark.parametrize("roll_deg", [-30, 0, 30])
def test_a_companion_who_leans_is_guessed_and_who_is_known_is_not(roll_deg):
    photo, (x, y) = beside_itself(roll_deg)
    known = FaceBox(*FACE)
    guesses = guess_companions(photo, [known])
    assert any(np.hypot((g.x0 + g.x1) / 2 - x, (g.y0 + g.y1) / 2 - y) < 25 for g in guesses)
    assert not any(share_in_common(guess, FACE) > 0.3 for guess in guesses)
    assert all(0.5 < guess.width / known.width < 1.6 for guess in guesses)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_companion_lies_as_the_known_face_does(quarters):
    near = ASTRONAUT[20:260, 100:340]
    pair = np.ascontiguousarray(np.rot90(np.concatenate([near, near], 1), quarters))
    middles = np.array([[124.0, 111.0], [364.0, 111.0]]) - [240, 120]
    for _ in range(quarters):
        middles = np.stack([middles[:, 1], -middles[:, 0]], 1)
    (x, y), (other_x, other_y) = middles + np.array(pair.shape[1::-1]) / 2
    roll_deg = {1: 90.0, 2: 180.0, 3: -90.0}[quarters]
    guesses = guess_companions(Photo.from_srgb(pair), [FaceBox(x - 38, y - 38, x + 38, y + 38, roll_deg)])
    other = [g for g in guesses if np.hypot((g.x0 + g.x1) / 2 - other_x, (g.y0 + g.y1) / 2 - other_y) < 25]
    assert any(abs((guess.roll_deg - roll_deg + 180) % 360 - 180) < 45 for guess in other)


def test_a_face_that_leaves_no_room_has_no_companions():
    assert guess_companions(Photo.from_srgb(ASTRONAUT), [FaceBox(*FACE)]) == []
    assert guess_companions(beside_itself(0)[0], []) == []


class TestDoubtfulUprightFaces:
    """A face that few cascades see: who can tell that it is one spares the search for others."""

    @pytest.fixture
    def turned(self, monkeypatch):
        """What was looked at in turned copies, of a photo whose one upright face is doubted."""
        seen = Candidate(np.array([100.0, 120.0, 160.0, 200.0]), 20, 3)
        looked = []
        monkeypatch.setattr(find, "frontal_candidates", lambda *_: [seen])
        monkeypatch.setattr(find, "profile_candidates", lambda grey: [])
        monkeypatch.setattr(find, "_when_turned", lambda look, grey, tilts: looked.append(tilts) or [])
        return looked

    @pytest.mark.parametrize(("is_one", "searches"), [(True, 0), (False, 1)])
    def test_are_shown_to_the_judge_before_the_long_search(self, turned, is_one, searches):
        shown = []
        photo = Photo(np.full((800, 800, 3), 0.2, np.float32))
        faces = find_faces(photo, lambda box: shown.append(box) or is_one)
        assert shown == faces == [FaceBox(100.0, 120.0, 160.0, 200.0, doubtful=True)]
        assert len(turned) == searches

    def test_are_left_to_the_judge_by_whoever_looks_before_there_is_one(self, turned):
        photo = Photo(np.full((800, 800, 3), 0.2, np.float32))
        find_faces_beyond_doubt(photo)
        assert turned == []
        assert len(find_faces(photo, lambda box: True)) == 1
        assert turned == []


def test_faces_beyond_doubt_are_found_ahead_and_remembered(monkeypatch):
    sure, looked = Candidate(np.array([100.0, 120.0, 160.0, 200.0]), 40, 3), []
    monkeypatch.setattr(find, "frontal_candidates", lambda grey, *_: looked.append(grey.shape) or [sure])
    photo = Photo(np.full((800, 800, 3), 0.2, np.float32))
    find_faces_beyond_doubt(photo)
    count = len(looked)
    assert find_faces(photo, lambda box: False) == [FaceBox(100.0, 120.0, 160.0, 200.0, doubtful=True)]
    assert len(looked) == count > 0


@pytest.mark.parametrize(
    ("size", "upright", "turned"),
    [
        ((3000, 4500), (1867, 2800), (933, 1400)),
        ((2000, 3000), (1400, 2100), (933, 1400)),
        ((1200, 900), (840, 630), (840, 630)),
    ],
)
def test_small_faces_are_looked_for_as_finely_as_they_are_worth_it(monkeypatch, size, upright, turned):
    looked = []
    monkeypatch.setattr(find, "frontal_candidates", lambda grey: looked.append(("upright", grey.shape)) or [])
    monkeypatch.setattr(find, "_turned_away", lambda grey: looked.append(("turned", grey.shape)) or [])
    assert find_small_faces(Photo(np.full((*size, 3), 0.2, np.float32))) == []
    assert looked == [("upright", upright), ("turned", turned)]


def test_small_faces_that_were_found_are_known_from_then_on(monkeypatch):
    small = Candidate(np.array([700.0, 350.0, 735.0, 390.0]), 20, 3)
    monkeypatch.setattr(find, "frontal_candidates", lambda grey, *_: [small] if grey.shape[1] > 800 else [])
    monkeypatch.setattr(find, "_turned_away", lambda grey: [])
    photo = Photo(np.full((900, 1300, 3), 0.2, np.float32))
    assert find_faces(photo) == []
    faces = find_small_faces(photo)
    assert len(faces) == 1
    assert find_faces(photo) == faces


@pytest.mark.parametrize("size", [(700, 1140), (3000, 20)])
def test_photos_without_room_for_small_faces_are_not_searched_for_them(monkeypatch, size):
    monkeypatch.setattr(find, "frontal_candidates", lambda grey: pytest.fail("looked"))
    monkeypatch.setattr(find, "_turned_away", lambda grey: pytest.fail("looked"))
    assert find_small_faces(Photo(np.full((*size, 3), 0.2, np.float32))) == []


class SeesIfBrightAbove:
    """A cascade that hits a large square in a picture that is brighter above than below; keeps what it looked at."""

    def __init__(self, votes):
        self.votes, self.looked_at = votes, []

    def detectMultiScale2(self, grey, *_):
        self.looked_at.append(grey.shape)
        middle = len(grey) // 2
        sees = grey[:middle].mean() > grey[middle:].mean() + 20
        return (((200, 200, 300, 300),), (self.votes,)) if sees else ((), ())

    def detectMultiScale(self, *_):
        return np.zeros((0, 4))


@pytest.mark.parametrize("bright", [np.s_[:, :60], np.s_[:, 60:], np.s_[75:]], ids=["left", "right", "below"])
@pytest.mark.parametrize("votes", [14, 13])
def test_where_a_large_face_lies_beyond_doubt_nobody_is_looked_for_who_leans(monkeypatch, bright, votes):
    cascade = SeesIfBrightAbove(votes)
    monkeypatch.setattr(cascades, "_cascade", lambda name: cascade)
    picture = np.full((150, 120, 3), 0.1, np.float32)
    picture[bright] = 0.8
    faces = find_faces(Photo(picture))
    # Each of three cascades has its votes; 40 of all together are beyond doubt.
    is_sure = votes == 14
    leaning = [shape for shape in cascade.looked_at if sorted(shape) != [360, 450]]
    assert bool(leaning) != is_sure
    assert faces == [] or not is_sure
