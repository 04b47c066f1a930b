"""What kinds of file hold: bits, size, layers, wide colours, what a camera noted, and what was set."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import OpenEXR
import pytest
from fake_relighter import FakeRelighter
from PIL import Image

from app.engine.exporting import ExportJob, ExportSettings, channel_layers, export, export_note
from relight_core.imaging.formats.icc_making import DISPLAY_P3, primaries_profile
from relight_core.imaging.photo import Photo
from relight_core.imaging.write import cut
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit

ARTIST = 315


@dataclass
class Wide:
    """A picture with colours that Rec.709 does not hold."""

    canvas: object
    image: np.ndarray
    wide: bool = False
    size: tuple = (96, 128)
    has_alpha: bool = False

    def render(self):
        return self.image if self.wide else self.image.clip(0, 1), None


def picture_of(relit, photo):
    light = SimpleNamespace(source=SimpleNamespace(title="Ring"))
    return SimpleNamespace(relit=relit, opened=SimpleNamespace(photo=photo), light=light, edit=Edit())


@pytest.fixture
def seen_wide():
    return []


@pytest.fixture
def picture(tmp_path, seen_wide):
    """A grey one of 40 by 60 pixels, of a camera's photo."""
    pixels, exif = np.full((40, 60, 3), 0.5, np.float32), Image.Exif()
    exif[ARTIST] = "me"
    bands = lambda wide: seen_wide.append(wide) or cut(pixels, None)  # noqa: E731
    full = SimpleNamespace(in_bands=bands, has_alpha=False, size=(40, 60), canvas=SimpleNamespace(beyond=None))
    photo = SimpleNamespace(linear=pixels, exif=exif.tobytes(), path=tmp_path / "photo.png")
    return picture_of(SimpleNamespace(image=pixels, alpha=None, channels={}, full=full), photo)


@pytest.fixture
def lit():
    """One with channels, 96 by 128 pixels."""
    photo, relighter = Photo(np.full((96, 128, 3), 0.5, np.float32)), FakeRelighter()
    relighter.set_portrait(photo)
    return picture_of(relighter.relight(Environment.from_radiance(np.ones((16, 32, 3), np.float32)), Edit()), photo)


@pytest.mark.parametrize(
    ("form", "usual", "deep"), [(".png", 8, 16), (".tif", 8, 16), (".jpg", 8, 8), (".exr", 16, 32)]
)
def test_each_kind_of_file_has_its_bits(form, usual, deep):
    assert ExportSettings(form).bits == usual
    assert ExportSettings(form, deep=True).bits == deep


@pytest.mark.parametrize("form", [".png", ".jpg", ".tif"])
def test_what_a_camera_noted_goes_along(picture, tmp_path, form):
    with Image.open(export(ExportJob(picture, 0.0, tmp_path / f"out{form}", ExportSettings(form)))) as written:
        assert written.getexif()[ARTIST] == "me"


def test_only_an_exr_has_colours_beyond_a_screen_s(picture, tmp_path, seen_wide):
    for form in (".png", ".exr"):
        export(ExportJob(picture, 0.0, tmp_path / f"out{form}", ExportSettings(form, layers=())))
    assert seen_wide == [False, True]


@pytest.mark.parametrize("form", [".png", ".jpg", ".tif"])
@pytest.mark.parametrize("profile", ["srgb", "photo"])
def test_a_file_is_in_the_photo_s_own_profile_where_that_is_asked_for(picture, tmp_path, seen_wide, form, profile):
    picture.opened.photo.icc = p3 = primaries_profile(DISPLAY_P3)
    settings = ExportSettings(form, profile=profile)
    with Image.open(export(ExportJob(picture, 0.0, tmp_path / f"out{form}", settings))) as written:
        assert (written.info.get("icc_profile") == p3) == (profile == "photo")
    assert seen_wide == [profile == "photo"]


def test_colours_beyond_srgb_stay_in_a_smaller_picture_in_the_photo_s_profile(lit, tmp_path):
    lit.opened.photo = replace(lit.opened.photo, icc=primaries_profile(DISPLAY_P3))
    canvas, green = SimpleNamespace(beyond=True), np.full((96, 128, 3), (-0.3, 1.0, -0.1), np.float32)
    lit.relit = replace(lit.relit, full=Wide(canvas, green), image=green.clip(0, 1))
    pixels = []
    for profile in ("srgb", "photo"):
        settings = ExportSettings(longest_side=64, profile=profile)
        with Image.open(export(ExportJob(lit, 0.0, tmp_path / "out.png", settings))) as written:
            pixels.append(written.getpixel((9, 9)))
    # In Display P3's primaries it is (-0.07, 0.957, -0.02); sRGB's own green would have a red of 0.18 there.
    assert pixels == [(0, 255, 0), (0, 250, 0)]


def test_a_jpeg_of_less_quality_is_smaller(picture, tmp_path):
    noise = np.random.default_rng(0).random((40, 60, 3)).astype(np.float32)
    picture.relit.full.in_bands = lambda wide: cut(noise, None)
    sizes = []
    for quality in (95, 30):
        wish = tmp_path / f"{quality}.jpg"
        sizes.append(export(ExportJob(picture, 0.0, wish, ExportSettings(".jpg", quality=quality))).stat().st_size)
    assert sizes[1] < 0.6 * sizes[0]


def test_under_the_name_of_the_photo_itself_another_is_taken(picture, tmp_path):
    (tmp_path / "photo.png").write_bytes(b"pixels")
    assert export(ExportJob(picture, 0.0, tmp_path / "photo.png")) == tmp_path / "photo-2.png"
    assert (tmp_path / "photo.png").read_bytes() == b"pixels"


@pytest.mark.parametrize("form", [".png", ".exr"])
@pytest.mark.parametrize(("kept", "side", "size"), [("lit", 64, (64, 48)), ("picture", 30, (30, 20))])
def test_a_picture_can_be_made_smaller(request, tmp_path, form, kept, side, size):
    job, settings = request.getfixturevalue(kept), ExportSettings(form, longest_side=side, layers=())
    written = export(ExportJob(job, 0.0, tmp_path / f"out{form}", settings))
    if form == ".png":
        assert Image.open(written).size == size
    else:
        with OpenEXR.File(str(written)) as file:
            assert file.channels()["RGB"].pixels.shape == (*size[::-1], 3)


@pytest.mark.parametrize("side", [None, 30])
def test_what_was_taken_away_is_transparent_in_the_file(picture, tmp_path, side):
    alpha = np.ones((40, 60), np.float32)
    alpha[:20] = 0.0
    relit = picture.relit
    relit.alpha, relit.full.has_alpha = alpha, True
    relit.full.in_bands = lambda wide: cut(relit.image, alpha)
    written = Image.open(export(ExportJob(picture, 0.0, tmp_path / "out.png", ExportSettings(longest_side=side))))
    assert written.mode == "RGBA"
    assert [written.getpixel((9, row))[3] for row in (4, written.height - 4)] == [0, 255]


@pytest.mark.parametrize(("deep", "kind"), [(False, np.float16), (True, np.float32)])
def test_layers_have_the_picture_s_size_and_depth(lit, tmp_path, deep, kind):
    settings = ExportSettings(".exr", deep, longest_side=64, layers=("albedo", "shadow"))
    with OpenEXR.File(str(export(ExportJob(lit, 0.0, tmp_path / "out.exr", settings)))) as file:
        assert file.header()["relightLight"] == "Ring"
        layers = {name: channel.pixels for name, channel in file.channels().items()}
    assert {name.split(".")[0] for name in layers} >= {"albedo", "shadow"}
    assert {layer.shape[:2] for layer in layers.values()} == {(48, 64)}
    assert {layer.dtype for layer in layers.values()} == {np.dtype(kind)}


def test_a_file_says_all_that_was_set():
    edit = Edit(-35.0, 0.5, 1.5, 0.25, "light", specular_tint=-0.5, shadow_softness=0.75, strength=0.5)
    said = export_note("Ring", edit)
    assert said.pop("software").startswith("relight ")
    assert said == {
        "relightLight": "Ring",
        "relightYawDeg": -35.0,
        "relightExposureEv": 0.5,
        "relightSpecular": 1.5,
        "relightShadow": 0.25,
        "relightSpecularTint": -0.5,
        "relightShadowSoftness": 0.75,
        "relightStrength": 0.5,
        "relightBackground": "light",
    }


def test_channels_that_share_the_face_s_size_are_layers_of_one_file():
    channels = {"albedo": 1, "composition": 2, "source_light": 3, "target_light": 4}
    assert channel_layers(channels) == {"albedo": 1, "RGB": 2}
