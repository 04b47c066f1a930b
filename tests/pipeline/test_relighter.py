"""The Relighter with tiny random networks: what comes out, what stays linear, what never breaks."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
from tiny_relighter import EDIT, computed, some_light, some_photo, states

from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.light_edit import LightEdit, edit_light
from relight_core.pipeline.edit import check_edit
from relight_core.pipeline.per_photo import choosing_faces
from relight_core.pipeline.relighter import Relighter
from relight_core.pipeline.results import display

pytestmark = pytest.mark.usefixtures("small_and_seeing_faces")


def test_result_has_the_photo_s_size_and_every_channel(relighter):
    relit = relighter.relight(some_light(), EDIT)
    assert relit.image.shape == (96, 112, 3)
    assert relit.image.dtype == np.float32
    assert relit.alpha is None
    assert len(relit.faces) == 2
    shapes = {name: channel.shape for name, channel in relit.channels.items()}
    assert shapes == {
        "photo": (64, 64, 3),
        "albedo": (64, 64, 3),
        "normal": (64, 64, 3),
        "parsing": (64, 64),
        "specular": (64, 64),
        "shadow": (64, 64),
        "composition": (64, 64, 3),
        "source_light": (16, 32, 3),
        "target_light": (16, 32, 3),
    }
    assert all(np.isfinite(channel).all() for channel in relit.channels.values())
    np.testing.assert_allclose(np.linalg.norm(relit.channels["normal"], axis=-1), 1, atol=1e-3)
    assert relit.channels["parsing"].dtype.kind == "i"


def test_level_scales_the_composition_exactly(relighter):
    once = relighter.relight(some_light(level=1.0), EDIT).channels
    eightfold = relighter.relight(some_light(level=8.0), EDIT).channels
    for name in ("composition", "specular", "shadow", "target_light"):
        np.testing.assert_array_equal(eightfold[name], 8 * once[name])
    for name in ("albedo", "normal", "parsing", "source_light", "photo"):
        np.testing.assert_array_equal(eightfold[name], once[name])


@pytest.mark.parametrize("level", [1e-20, 1e-6, 1e6, 1e15])
def test_no_level_leaves_the_networks_range(relighter, level):
    once = relighter.relight(some_light(), EDIT).channels["composition"]
    relit = relighter.relight(some_light(level=level), EDIT)
    np.testing.assert_allclose(relit.channels["composition"], np.float32(level) * once, rtol=1e-5)
    beyond = relighter.relight(some_light(level=1e5 * level), EDIT)
    assert all(np.isfinite(image).all() for image in (relit.image, beyond.image, beyond.channels["composition"]))


@pytest.mark.filterwarnings("error")
def test_a_light_brighter_than_sums_over_pictures_can_hold_counts_as_the_brightest(relighter):
    brightest, beyond = (relighter.relight(some_light(level=level), EDIT) for level in (1e20, 1e38))
    for name in ("composition", "specular", "shadow", "target_light"):
        np.testing.assert_array_equal(beyond.channels[name], brightest.channels[name])
    np.testing.assert_array_equal(beyond.image, brightest.image)


def test_black_light_makes_a_black_person_without_asking_the_network(relighter):
    black = Environment.from_radiance(np.zeros((16, 32, 3), np.float32))
    relit = relighter.relight(black, EDIT)
    assert states(relit)["specular_shadow"] == "skipped"
    assert np.isfinite(relit.image).all()
    assert relit.channels["composition"].max() == 0
    assert relit.image[40:60, 40:60].max() < 1e-3


@pytest.mark.parametrize(("slider", "sign"), [("specular", 1), ("shadow", -1)])
def test_sliders_move_one_way_only(relighter, slider, sign):
    images = [
        relighter.relight(some_light(), replace(EDIT, **{slider: gain})).channels["composition"]
        for gain in (0.0, 0.5, 1.0, 1.5, 2.0)
    ]
    for one, next_one in zip(images, images[1:], strict=False):
        assert (sign * (next_one - one)).min() >= -1e-6
        assert (sign * (next_one - one)).max() > 1e-4


def test_a_second_face_changes_with_the_first(relighter):
    both = relighter.relight(some_light(), EDIT).image
    relighter.set_portrait(some_photo(), 0)
    alone = relighter.relight(some_light(), EDIT).image
    assert np.abs(both - alone)[4:20, 4:20].mean() > 1e-4


def test_a_box_by_hand_needs_no_finder(relighter, monkeypatch):
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: [])
    relighter.set_portrait(some_photo(), boxes=[FaceBox(20, 20, 60, 70, roll_deg=20.0)])
    relit = relighter.relight(some_light(), EDIT)
    assert np.isfinite(relit.image).all()
    assert relit.faces[0].x1 > 20
    for box in (FaceBox(5, 5, 5, 40), FaceBox(500, 10, 600, 90), FaceBox(np.nan, 0, 5, 5), FaceBox(-1e9, 0, 1e9, 9)):
        with pytest.raises(InputError, match="box"):
            relighter.set_portrait(some_photo(), boxes=[box])


def test_a_smaller_picture_for_the_screen_and_the_full_one_for_a_file(relighter):
    relit = relighter.relight(some_light(), EDIT, longest_side_px=56)
    assert relit.image.shape == (48, 56, 3)
    full, alpha = relit.full.render()
    assert full.shape == (96, 112, 3)
    assert alpha is None
    np.testing.assert_array_equal(relighter.relight(some_light(), EDIT).image, full)


def test_a_smaller_picture_is_reused_too(relighter):
    relighter.relight(some_light(), EDIT, longest_side_px=56)
    assert computed(relighter.relight(some_light(), EDIT, longest_side_px=56)) == set()


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("background_fov_deg", (0.0, 200.0)),
        ("background_blur_deg", (-1.0, 21.0)),
        ("specular", (-0.1, 2.1)),
        ("shadow", (-0.1, 5.0)),
        ("shadow_softness", (-1.0, 1.1)),
        ("specular_tint", (-2.0, 2.0)),
        ("strength", (-0.1, 1.1)),
        ("tolerance", (-0.1, 2.0)),
        ("yaw_deg", (np.nan, np.inf, "30", None)),
        ("background", (None, "beach", (0, 0, 0), "#30343", "#30343ab")),
        ("channel", (("albdo",), "albedo")),
    ],
)
def test_settings_out_of_their_ranges_are_refused_by_name(relighter, name, wrong):
    for value in wrong:
        edit = replace(EDIT, **{"channels" if name == "channel" else name: value})
        for ask in (relighter.relight, relighter.plan, relighter.get_ready):
            with pytest.raises(InputError, match=name):
                ask(some_light(), edit)


@pytest.mark.parametrize(
    ("name", "ends"),
    [
        ("background_fov_deg", (0.001, 170.0)),
        ("background_blur_deg", (0.0, 20.0)),
        ("specular", (0.0, 2.0)),
        ("shadow", (0.0, 2.0)),
        ("shadow_softness", (0.0, 1.0)),
        ("specular_tint", (-1.0, 1.0)),
        ("tolerance", (0.0, 1.0)),
    ],
)
def test_both_ends_of_a_range_belong_to_it_and_nothing_beyond(name, ends):
    for end in ends:
        check_edit(replace(EDIT, **{name: end}))
    with pytest.raises(InputError, match=name):
        check_edit(replace(EDIT, **{name: ends[1] * 1.01}))


def test_a_number_that_is_text_is_told_from_the_number(relighter):
    with pytest.raises(InputError, match="yaw_deg is a finite number, not '30'"):
        relighter.plan(some_light(), replace(EDIT, yaw_deg="30"))


@pytest.fixture
def halved(weights, person_on_the_left):
    relighter = Relighter(weights)
    relighter.set_portrait(some_photo())
    return relighter


def test_behind_the_person_is_the_background_that_was_asked_for(halved):
    def relit(background):
        return halved.relight(some_light(), replace(EDIT, background=background))

    alpha, photo = relit("transparent").alpha, some_photo().linear
    assert (alpha.shape, alpha.min(), alpha.max()) == ((96, 112), 0, 1)
    behind = alpha == 0
    # Code 128 of 255, linear.
    np.testing.assert_allclose(relit("#808080").image[behind], 0.2159, atol=1e-3)
    gain = relit("match").image[behind] / photo[behind]
    np.testing.assert_allclose(gain, np.broadcast_to(gain[:1], gain.shape), rtol=1e-3)
    assert np.abs(gain[0] - 1).max() > 0.01


def test_metering_lights_the_person_and_the_light_behind_and_leaves_a_kept_background_alone(halved):
    relighter, photo = halved, some_photo()
    bright = some_light(level=6.0)
    metered = edit_light(bright, LightEdit(metered=True))
    behind = relighter.relight(bright, replace(EDIT, background="transparent")).alpha == 0.0
    assert behind.any()

    def relit(light, background):
        return relighter.relight(light, replace(EDIT, background=background)).image

    kept = relit(metered, "keep")
    np.testing.assert_array_equal(kept[behind], photo.linear[behind])
    np.testing.assert_array_equal(kept[behind], relit(bright, "keep")[behind])
    assert kept[~behind].mean() < 0.8 * relit(bright, "keep")[~behind].mean()
    factor = metered.level / bright.level
    np.testing.assert_allclose(relit(metered, "light"), factor * relit(bright, "light"), rtol=1e-3, atol=1e-6)


def test_unknown_quality_names_the_known_ones(relighter):
    with pytest.raises(InputError, match="draft"):
        relighter.relight(some_light(), replace(EDIT, quality="best"))


def test_no_portrait_yet(weights):
    with pytest.raises(InputError, match="portrait"):
        Relighter(weights).relight(some_light(), EDIT)
    with pytest.raises(InputError, match="portrait"):
        Relighter(weights).estimated_light("live")


@pytest.mark.parametrize("device", ["cuda:99", "gpu"])
def test_a_device_that_pytorch_has_not_is_refused(weights, device):
    with pytest.raises(InputError, match=f"{device}: PyTorch finds no such device"):
        Relighter(weights, device)


def test_estimated_light_is_a_light(relighter):
    borrowed = relighter.estimated_light("live")
    assert borrowed.shape.shape == (16, 32, 3)
    assert np.isfinite(borrowed.shape).all()
    assert borrowed.level > 0
    assert np.isfinite(relighter.relight(borrowed, EDIT).image).all()


@pytest.mark.parametrize("turned_off", ["residual", "flattening", "correction"])
def test_the_source_light_is_the_photos_whatever_light_is_asked_for(weights, relighter, turned_off):
    own = relighter.estimated_light("live")
    for light, off in ((some_light(1), set()), (some_light(2, level=0.0), set()), (some_light(1), {turned_off})):
        another = Relighter(weights)
        another.set_portrait(some_photo())
        channel = another.relight(light, replace(EDIT, channels=("source_light",), forced_off=frozenset(off)))
        np.testing.assert_allclose(channel.channels["source_light"], own.level * own.shape, rtol=1e-4)


def test_a_photo_without_a_face_leaves_the_portrait_as_it_was(relighter, monkeypatch):
    before = relighter.relight(some_light(), EDIT)
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: [])
    with pytest.raises(InputError, match="no face"):
        relighter.set_portrait(some_photo(5))
    after = relighter.relight(some_light(), EDIT)
    assert computed(after) == set()
    np.testing.assert_array_equal(after.image, before.image)


@pytest.mark.parametrize("index", [2, -1])
def test_a_face_that_is_not_there(relighter, index):
    with pytest.raises(InputError, match="face number"):
        relighter.set_portrait(some_photo(), index)


def test_a_face_that_is_chosen_by_its_index_is_relit_alone(relighter):
    relighter.set_portrait(some_photo(), 1)
    (box,) = relighter.relight(some_light(), EDIT).faces
    assert box.x0 < 24
    assert box.x1 <= 48


HOSTILE = {
    "black": np.zeros((96, 112, 3), np.float32),
    "white": np.ones((96, 112, 3), np.float32),
    "brighter than white": np.full((96, 112, 3), 60000, np.float32),
    "noise": np.random.default_rng(0).random((96, 112, 3), np.float32),
    "checks": (np.indices((96, 112)).sum(0) % 2)[..., None].repeat(3, -1).astype(np.float32) * 50,
    "one colour only": np.float32([1, 0, 0]) * np.ones((96, 112, 1), np.float32),
    "odd size": np.random.default_rng(1).random((97, 113, 3), np.float32),
    "tiny": np.random.default_rng(2).random((9, 11, 3), np.float32),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_photos_stay_finite(weights, name, monkeypatch):
    linear = HOSTILE[name]
    height, width = linear.shape[:2]
    box = FaceBox(width * 0.2, height * 0.2, width * 0.7, height * 0.8)
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: [box])
    relighter = Relighter(weights)
    relighter.set_portrait(Photo(np.ascontiguousarray(linear)))
    relit = relighter.relight(some_light(), replace(EDIT, specular=2.0, shadow=2.0))
    assert relit.image.shape == linear.shape
    assert np.isfinite(relit.image).all()
    assert (relit.image >= 0).all()
    assert all(np.isfinite(channel).all() for channel in relit.channels.values())


def test_the_photo_itself_is_never_changed(relighter):
    photo = some_photo()
    before = photo.linear.copy()
    relighter.set_portrait(photo)
    relighter.relight(some_light(), replace(EDIT, background="light"))
    np.testing.assert_array_equal(photo.linear, before)


def test_behind_the_person_there_is_neither_surface_nor_effect(halved):
    relit = halved.relight(some_light(), EDIT)
    for name in ("albedo", "normal", "specular", "shadow"):
        channel = relit.channels[name]
        middle = channel.shape[1] // 2
        assert np.abs(channel[:, middle + 4 :]).max() < 1e-4
        assert np.abs(channel[:, : middle - 4]).max() > 1e-3


@pytest.mark.parametrize("background", ["keep", "match"])
def test_a_photo_that_was_cut_out_stays_so(relighter, background):
    alpha = np.zeros((96, 112), np.float32)
    alpha[10:90, 20:60], alpha[10:90, 60:90] = 1.0, 0.5
    relighter.set_portrait(replace(some_photo(), alpha=alpha))
    edit = replace(EDIT, background=background)
    np.testing.assert_array_equal(relighter.relight(some_light(), edit).alpha, alpha)
    assert relighter.relight(some_light(), replace(edit, background="#203040")).alpha is None


def test_no_picture_is_made_where_none_is_asked_for(relighter):
    relit = relighter.relight(some_light(), EDIT, longest_side_px=0)
    assert relit.image is None
    assert not {"paste", "canvas"} & computed(relit)
    np.testing.assert_array_equal(relit.full.render()[0], relighter.relight(some_light(), EDIT).image)


@pytest.mark.parametrize(("width", "is_recipe"), [(8192, True), (8193, False)])
def test_no_texture_of_a_shader_is_longer_than_drivers_take(relighter, width, is_recipe):
    relighter.set_portrait(Photo(np.full((32, width, 3), 0.4, np.float32)), boxes=[FaceBox(40, 4, 60, 28)])
    relit = relighter.relight(some_light(), EDIT, for_shader=True)
    assert (relit.recipe is not None, relit.image is None) == (is_recipe, is_recipe)


def test_a_shader_draws_a_screens_copy_of_a_large_square_photo(relighter):
    relighter.set_portrait(Photo(np.full((2600, 2600, 3), 0.4, np.float32)), boxes=[FaceBox(800, 700, 1800, 1900)])
    assert relighter.relight(some_light(), EDIT, 2560, for_shader=True).recipe.size == (2560, 2560)


def test_nothing_is_made_ready_for_a_shader_that_has_no_room_for_the_faces(relighter, monkeypatch):
    monkeypatch.setattr(display, "MOST_VIEWS", 0)
    relit = relighter.relight(some_light(), EDIT, for_shader=True)
    assert relit.image is not None
    assert "layers" not in states(relit)


@pytest.mark.parametrize(
    "boxes",
    [
        None,
        [FaceBox(24, 20, 72, 76)],
        [FaceBox(40, 30, 60, 54)],
        [FaceBox(6, 16, 50, 72), FaceBox(60, 20, 104, 76)],
    ],
    ids=["found", "large", "small", "two"],
)
def test_a_photo_that_was_replaced_is_let_go_at_once(weights, boxes):
    relighter, photo = Relighter(weights), some_photo()
    seen = weakref.ref(photo)
    gc.disable()
    try:
        relighter.set_portrait(photo, boxes=boxes)
        relighter.relight(some_light(), EDIT)
        del photo
        relighter.set_portrait(some_photo(1), boxes=boxes)
        assert seen() is None
    finally:
        gc.enable()
