"""Portraits that try to break the pipeline, on the shipped networks; framed where the sample's face is."""

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.photo import Photo
from relight_core.imaging.read import read_photo
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.view_transform import apply_view
from relight_core.imaging.write import write_image
from relight_core.lighting.environment import Environment
from relight_core.lighting.rigs import load_rig
from relight_core.pipeline import stages
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo import choosing_faces
from relight_core.pipeline.quality import tier_of
from relight_core.pipeline.relighter import Relighter

DRAFT = Edit(quality="draft")
FACE = (0.44, 0.25, 0.66, 0.6)
"""Of the sample portrait, as fractions of its width and height."""


def flash(image):
    rows, columns = np.mgrid[-1 : 1 : image.shape[0] * 1j, -1 : 1 : image.shape[1] * 1j]
    return image + 4 * np.exp(-4 * (rows**2 + columns**2))[..., None]


def glare(image):
    """A blown-out bar where glasses would be, hundreds of times as bright as skin."""
    result = image.copy()
    height, width = image.shape[:2]
    result[int(0.38 * height) : int(0.44 * height), int(0.46 * width) : int(0.64 * width)] = [300, 290, 280]
    return result


def heavy_jpeg(image):
    buffer = BytesIO()
    Image.fromarray((srgb_encode(np.clip(image, 0, 1)) * 255).astype(np.uint8)).save(buffer, "JPEG", quality=3)
    return Photo.from_srgb(np.array(Image.open(buffer))).linear


def noise(image):
    return np.random.default_rng(0).random(image.shape)


ATTACKS = {
    "as it is": lambda image: image,
    "black": np.zeros_like,
    "white": np.ones_like,
    "one colour": lambda image: np.ones_like(image) * [0.5, 0.2, 0.1],
    "noise": noise,
    "flash": flash,
    "2 EV under": lambda image: image / 4,
    "4 EV over": lambda image: np.minimum(image * 16, 1),
    "monochrome": lambda image: image.mean(-1, keepdims=True).repeat(3, -1),
    "neon": lambda image: np.clip(image - image.min(-1, keepdims=True), 0, 1) * [4, 0, 1],
    "40 pixels of face": lambda image: resize_area(image, (110, 122)),
    "1 to 10": lambda image: np.tile(image[:, 80:160], (4, 1, 1)),
    "upside down": lambda image: image[::-1],
    "heavy JPEG": heavy_jpeg,
    "glare on glasses": glare,
    "radiance up to 60,000": lambda image: image * 60000,
    "subnormal": lambda image: image * 1e-40,
}


@pytest.fixture(scope="module")
def attacked():
    """One Relighter for all: nothing of one portrait may show in the next."""
    return Relighter()


def framed(relighter, image, monkeypatch, alpha=None, face=FACE):
    """The portrait with a face at a given place, found or not."""
    height, width = image.shape[:2]
    box = FaceBox(face[0] * width, face[1] * height, face[2] * width, face[3] * height)
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: [box])
    photo = Photo(np.ascontiguousarray(image, np.float32), alpha)
    relighter.set_portrait(photo)
    return photo


def assert_lawful(relit, photo):
    assert relit.image.shape == photo.linear.shape
    assert np.isfinite(relit.image).all()
    assert relit.image.min() >= 0
    for name, channel in relit.channels.items():
        assert np.isfinite(channel).all(), name
    shown = apply_view(relit.image)
    assert 0 <= shown.min() <= shown.max() <= 1


@pytest.mark.parametrize("name", ATTACKS)
def test_everything_stays_finite_and_the_own_light_gives_the_photo_back(attacked, portrait, name, monkeypatch):
    photo = framed(attacked, ATTACKS[name](portrait.linear), monkeypatch)
    assert_lawful(attacked.relight(load_rig("hard-side"), replace(DRAFT, specular=2.0, shadow=2.0)), photo)
    own = attacked.relight(attacked.estimated_light("draft"), DRAFT)
    assert_lawful(own, photo)
    difference = np.abs(apply_view(own.image) - apply_view(photo.linear))
    assert difference.mean() < 0.015


@pytest.mark.parametrize("face", [(-0.1, -0.2, 0.2, 0.3), (0.8, 0.7, 1.2, 1.3), (0, 0, 1, 1), (0.5, 0.5, 0.51, 0.51)])
def test_faces_at_and_beyond_the_border(attacked, portrait, face, monkeypatch):
    photo = framed(attacked, portrait.linear, monkeypatch, face=face)
    assert_lawful(attacked.relight(load_rig("split"), DRAFT), photo)


@pytest.mark.parametrize("apart", [0.0, 0.05, 0.12])
def test_faces_that_overlap_are_each_relit(attacked, portrait, apart, monkeypatch):
    """Two faces, one in front of the other or the same one found twice."""
    height, width = portrait.linear.shape[:2]
    left, top, right, bottom = FACE
    boxes = [
        FaceBox((left + shift) * width, top * height, (right + shift) * width, bottom * height)
        for shift in (0.0, apart)
    ]
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: boxes)
    attacked.set_portrait(portrait)
    relit = attacked.relight(load_rig("split"), DRAFT)
    assert len(relit.faces) == 2
    assert_lawful(relit, portrait)
    # The same face twice is not lit twice.
    if apart == 0.0:
        framed(attacked, portrait.linear, monkeypatch)
        alone = attacked.relight(load_rig("split"), DRAFT).image
        assert np.abs(apply_view(relit.image) - apply_view(alone)).mean() < 0.01


def test_sixteen_bits_are_the_same_person_as_eight(attacked, portrait, tmp_path, monkeypatch):
    results = []
    for bits in (8, 16):
        write_image(tmp_path / f"{bits}.png", portrait.linear, bits=bits)
        framed(attacked, read_photo(tmp_path / f"{bits}.png").linear, monkeypatch)
        results.append(apply_view(attacked.relight(load_rig("split"), DRAFT).image))
    assert np.abs(results[0] - results[1]).mean() < 0.005


def test_alpha_with_holes_is_the_matte(attacked, portrait, monkeypatch):
    alpha = np.random.default_rng(1).integers(0, 2, portrait.linear.shape[:2]).astype(np.float32)
    photo = framed(attacked, portrait.linear, monkeypatch, alpha)
    relit = attacked.relight(load_rig("split"), replace(DRAFT, background="transparent"))
    assert_lawful(relit, photo)
    np.testing.assert_array_equal(relit.alpha, alpha)


def test_sliders_at_their_ends_and_angles_far_beyond_a_turn(attacked, portrait, monkeypatch):
    photo = framed(attacked, portrait.linear, monkeypatch)
    for value in (0.0, 1e-30, 2.0):
        assert_lawful(attacked.relight(load_rig("split"), replace(DRAFT, specular=value, shadow=value)), photo)
    for yaw_deg in (1e9, -1e-9):
        assert_lawful(attacked.relight(load_rig("split"), replace(DRAFT, yaw_deg=yaw_deg)), photo)


@pytest.mark.parametrize(
    "wrong",
    [{"yaw_deg": np.nan}, {"yaw_deg": np.inf}, {"shadow": np.nan}, {"specular": -np.inf}, {"shadow_softness": np.nan}]
    + [
        {"exposure_ev": np.nan},
        {"tolerance": np.nan},
        {"strength": np.nan},
        {"specular_tint": np.nan},
        {"specular_tint": 4.0},
    ]
    + [{name: value} for name in ("specular", "shadow") for value in (-5.0, 2.5, 1e30)],
    ids=str,
)
def test_settings_that_are_no_numbers_or_out_of_their_range_are_refused(attacked, portrait, wrong, monkeypatch):
    framed(attacked, portrait.linear, monkeypatch)
    with pytest.raises(InputError, match=next(iter(wrong))):
        attacked.relight(load_rig("split"), replace(DRAFT, **wrong))


@pytest.mark.parametrize("background", ["keep", "match"])
def test_the_brightest_photo_in_the_brightest_light_stays_a_number(attacked, portrait, background, monkeypatch):
    photo = framed(attacked, portrait.linear * np.float32(1e16), monkeypatch)
    light = load_rig("split").at_level(1e20)
    assert_lawful(attacked.relight(light, replace(DRAFT, background=background)), photo)


@pytest.mark.parametrize("quality", ["live", "final"])
def test_the_better_tiers_are_lawful_on_the_hardest_portraits(attacked, portrait, quality, monkeypatch):
    edit = Edit(quality=quality, specular=2.0, shadow=2.0)
    for name in ("4 EV over", "noise"):
        photo = framed(attacked, ATTACKS[name](portrait.linear), monkeypatch)
        assert_lawful(attacked.relight(load_rig("hard-side"), edit), photo)


def test_the_same_input_gives_the_same_bytes(portrait, monkeypatch):
    images = []
    for _ in range(2):
        relighter = Relighter()
        framed(relighter, portrait.linear, monkeypatch)
        images.append(relighter.relight(load_rig("rembrandt"), DRAFT).image)
    np.testing.assert_array_equal(images[0], images[1])


def test_half_precision_stays_near_single(portrait, monkeypatch):
    """In sRGB values; a sun is the hardest light for few bits."""
    sun = np.full((16, 32, 3), 0.01, np.float32)
    sun[5, 3] = 1e4
    environment = Environment(Environment.from_radiance(sun).shape, 0.5)
    tier = tier_of("draft")
    # A processor that has no bf16 emulates it: slowly, and to the same numbers.
    monkeypatch.setattr(stages, "has_bf16", lambda device: True)
    results = []
    for precision in ("bf16", "fp32"):
        relighter = Relighter()
        framed(relighter, portrait.linear, monkeypatch)
        relit = relighter.relight(environment, Edit(quality=replace(tier, precision=precision)))
        results.append(apply_view(relit.image))
    difference = np.abs(results[0] - results[1])
    assert 0 < difference.mean() < 0.005
    assert np.percentile(difference, 99.9) < 0.06
