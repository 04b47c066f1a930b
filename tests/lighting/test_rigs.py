"""Light rigs: their files, where their lamps stand, how strong they are."""

import tomllib

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.lighting.colour_temperature import kelvin_to_rgb
from relight_core.lighting.panorama import mean_luminance, rotate, shrink
from relight_core.lighting.rig_description import parse_rig, read_rig
from relight_core.lighting.rigs import load_rig, read_bundled_rig, render_rig, rig_names
from relight_core.lighting.sphere import directions, solid_angles
from relight_core.lighting.summary import average_direction

PHOTOGRAPHERS_SIX = {"soft-window", "rembrandt", "butterfly", "split", "ring", "golden-hour"}


def one_lamp(**changes):
    lamp = {
        "azimuth_deg": 0,
        "elevation_deg": 0,
        "width_deg": 20,
        "height_deg": 20,
        "colour": [1, 1, 1],
        "intensity": 1,
    } | changes
    dark = {"colour": [1, 1, 1], "intensity": 0}
    return parse_rig({"room": dark, "area_light": [{k: v for k, v in lamp.items() if v is not None}]})


def irradiance(panorama, normal):
    toward = directions(*panorama.shape[:2])
    power = panorama * solid_angles(*panorama.shape[:2])[..., None]
    return np.einsum("hw,hwc->c", np.maximum(toward @ np.array(normal, np.float32), 0), power)


def luminance(colour):
    return colour @ np.array([0.2126, 0.7152, 0.0722])


# Where lamps stand


@pytest.mark.parametrize(
    ("azimuth_deg", "elevation_deg", "direction"),
    [
        (0, 0, (0, 0, 1)),
        (90, 0, (1, 0, 0)),
        (-90, 0, (-1, 0, 0)),
        (180, 0, (0, 0, -1)),
        (0, 90, (0, 1, 0)),
        (0, -90, (0, -1, 0)),
        (45, 30, (0.6124, 0.5, 0.6124)),
    ],
)
@pytest.mark.parametrize("form", ["rectangle", "disc"])
def test_a_lamp_shines_from_its_azimuth_and_elevation(azimuth_deg, elevation_deg, direction, form):
    height_deg = 6 if form == "rectangle" else None
    rig = one_lamp(azimuth_deg=azimuth_deg, elevation_deg=elevation_deg, width_deg=6, height_deg=height_deg, form=form)
    panorama = render_rig(rig, 32)
    toward, areas = directions(32, 64), solid_angles(32, 64)
    mean = np.einsum("hwc,hw->c", toward, panorama[..., 1] * areas)
    np.testing.assert_allclose(mean / np.linalg.norm(mean), direction, atol=0.01)


def test_a_lamp_at_three_quarters_of_the_panorama_lights_from_the_images_right():
    panorama = render_rig(one_lamp(azimuth_deg=90, width_deg=4, height_deg=4), 32)
    assert panorama[16].argmax() // 3 in (47, 48)
    assert irradiance(panorama, (1, 0, 0))[0] > 3
    assert irradiance(panorama, (-1, 0, 0))[0] == 0


def test_a_lamp_at_the_edges_of_the_panorama_lights_the_face_from_the_front():
    panorama = render_rig(one_lamp(azimuth_deg=0, width_deg=12, height_deg=12), 32)
    assert panorama[16, 0, 0] > 0
    assert panorama[16, 63, 0] > 0
    assert not panorama[:, 8:56].any()
    assert irradiance(panorama, (0, 0, 1))[0] > 3


def test_turning_a_rig_is_adding_to_its_azimuth_the_other_way():
    """Content moves to the panorama's right: a lamp in front, at its left edge, goes to image left."""
    front = render_rig(one_lamp(azimuth_deg=0), 32)
    left = render_rig(one_lamp(azimuth_deg=-90), 32)
    np.testing.assert_allclose(rotate(front, 90), left, atol=0.02 * left.max())


def test_lamps_are_as_wide_and_as_high_as_described():
    panorama = render_rig(one_lamp(width_deg=60, height_deg=30, azimuth_deg=180, softness=0), 180)
    lit = panorama[..., 0] > panorama.max() / 2
    assert lit[90].sum() == pytest.approx(60, abs=2)
    assert lit[:, 180].sum() == pytest.approx(30, abs=2)


def test_a_ring_is_dark_in_the_middle():
    rig = one_lamp(form="disc", width_deg=40, height_deg=None, hole_deg=20, azimuth_deg=180, softness=0)
    panorama = render_rig(rig, 180)[..., 0]
    assert panorama[90, 180] == 0
    assert panorama[90, 195] > 0
    assert panorama[75, 180] > 0
    assert panorama[90, 205] == 0


# How strong lamps are


@pytest.mark.parametrize("width_deg", [0.5, 3, 25, 120])
@pytest.mark.parametrize("height", [16, 64])
def test_a_white_card_facing_a_lamp_reflects_its_intensity_whatever_its_size(width_deg, height):
    rig = one_lamp(width_deg=width_deg, height_deg=width_deg, intensity=0.8, azimuth_deg=30, elevation_deg=20)
    facing = (0.9397 * 0.5, 0.3420, 0.9397 * 0.8660)
    card = irradiance(render_rig(rig, height), facing) / np.pi
    np.testing.assert_allclose(card, 0.8, rtol=0.02)


def test_a_white_card_in_a_room_reflects_its_intensity():
    room = parse_rig({"room": {"colour": [1, 0.5, 0.25], "intensity": 0.4, "gradient": 0.6}})
    panorama = render_rig(room, 32)
    np.testing.assert_allclose(irradiance(panorama, (0, 0, 1)) / np.pi, [0.4, 0.2, 0.1], rtol=0.01)
    assert panorama[0, 0, 0] == pytest.approx(0.4 * 1.6, rel=0.01)
    assert panorama[-1, 0, 0] == pytest.approx(0.4 * 0.4, rel=0.02)


def test_lamps_add_up():
    settings = {"width_deg": 20, "height_deg": 20, "colour": [1, 1, 1], "intensity": 1, "elevation_deg": 10}
    room = {"colour": [1, 1, 1], "intensity": 0}
    lamps = [settings | {"azimuth_deg": a} for a in (0, 20)]
    both = render_rig(parse_rig({"room": room, "area_light": lamps}), 32)
    apart = sum(render_rig(parse_rig({"room": room, "area_light": [lamp]}), 32) for lamp in lamps)
    np.testing.assert_allclose(both, apart, rtol=1e-4, atol=1e-5)


def test_edges_are_smooth():
    """A lamp that moves by a hundredth of a texel changes the panorama by little."""
    lamp = {"azimuth_deg": 50, "elevation_deg": 30, "softness": 0, "width_deg": 30, "height_deg": 30}
    first = render_rig(one_lamp(**lamp), 64)
    second = render_rig(one_lamp(**lamp | {"azimuth_deg": 50.03}), 64)
    assert 0 < np.abs(first - second).max() < 0.05 * first.max()


def test_sizes_agree():
    rig = read_bundled_rig("rembrandt")
    small, large = render_rig(rig, 16), shrink(render_rig(rig, 128), 16)
    np.testing.assert_allclose(small, large, rtol=0.05, atol=0.05)


def test_a_sky_is_brightest_at_its_glow_and_ends_at_the_horizon():
    sky = {
        "zenith": [0.1, 0.2, 0.4],
        "horizon": [0.4, 0.4, 0.4],
        "ground": [0.2, 0.1, 0.0],
        "intensity": 2,
        "glow": {
            "azimuth_deg": 90,
            "elevation_deg": 20,
            "width_deg": 30,
            "colour": [1, 1, 1],
            "intensity": 1,
        },
    }
    panorama = render_rig(parse_rig({"sky": sky}), 64)
    np.testing.assert_allclose(panorama[0, 0], [0.2, 0.4, 0.8], rtol=0.05)
    np.testing.assert_allclose(panorama[40:, 20], np.broadcast_to([0.4, 0.2, 0.0], (24, 3)), atol=1e-6)
    row, column = np.unravel_index(panorama.sum(-1).argmax(), (64, 128))
    assert abs(row - 24) <= 2
    assert abs(column - 95.5) <= 2


# The bundled rigs


def test_the_photographers_six_are_there():
    assert set(rig_names()) >= PHOTOGRAPHERS_SIX
    assert rig_names() == sorted(rig_names())


@pytest.mark.parametrize("name", rig_names())
def test_bundled_rigs_are_lights_fit_to_use(name):
    environment = load_rig(name)
    assert environment is load_rig(name)
    assert environment.name == name
    assert environment.shape.shape == (256, 512, 3)
    assert np.isfinite(environment.shape).all()
    assert (environment.shape >= 0).all()
    assert mean_luminance(environment.shape) == pytest.approx(1.0, rel=1e-4)
    rig = read_bundled_rig(name)
    assert rig.title
    assert rig.description


def test_a_soft_box_is_spelt_in_descriptions_as_in_the_window():
    words = " ".join(read_bundled_rig(name).description for name in rig_names()).lower()
    assert "soft box" in words
    assert "softbox" not in words


@pytest.mark.parametrize("name", rig_names())
def test_bundled_rigs_expose_a_white_card_rightly(name):
    """The best-lit way a card that the camera sees may face reflects about 1: the level is a proper exposure."""
    environment = load_rig(name)
    panorama = shrink(environment.shape * environment.level, 32)
    normals = [normal for normal in directions(16, 32).reshape(-1, 3) if normal[2] >= 0]
    cards = [irradiance(panorama, normal).max() / np.pi for normal in normals]
    assert 0.4 < max(cards) < 2.0


def sides(name):
    """Irradiance on surfaces that face image left, image right, above, below, front, back."""
    environment = load_rig(name)
    panorama = shrink(environment.shape, 64)
    normals = [(-1, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    return [luminance(irradiance(panorama, normal)) for normal in normals]


def test_rembrandt_is_high_and_to_one_side_with_little_fill():
    left, right, above, below, front, _ = sides("rembrandt")
    assert right > 4 * left
    assert above > 4 * below
    assert front > 4 * left


def test_split_lights_one_half_only():
    left, right, *_, front, back = sides("split")
    assert right > 20 * left
    assert abs(front - back) < 0.1 * right


@pytest.mark.parametrize("name", ["butterfly", "ring", "clamshell", "rim"])
def test_frontal_and_symmetric_rigs_have_even_sides(name):
    left, right, *_ = sides(name)
    assert left == pytest.approx(right, rel=0.01)


def test_heights_and_fronts():
    _, _, above, below, front, back = sides("butterfly")
    assert above > 2 * below
    assert front > 3 * back
    _, _, above, below, front, back = sides("ring")
    assert above == pytest.approx(below, rel=0.01)
    assert front > 4 * back
    _, _, above, below, *_ = sides("clamshell")
    assert above > below > 0.3 * above
    _, _, _, _, front, back = sides("rim")
    assert back > 2 * front
    assert min(sides("rim")[:2]) > 8 * front
    _, _, above, below, *_ = sides("overcast")
    assert above > 2.5 * below


def test_the_window_is_left_and_the_sun_and_the_bare_lamp_right():
    assert average_direction(load_rig("soft-window"))[0] < -0.2
    assert average_direction(load_rig("golden-hour"))[0] > 0.3
    assert average_direction(load_rig("hard-side"))[0] > 0.3


def test_colours_of_golden_hour_and_neon():
    panorama = shrink(load_rig("golden-hour").shape, 32)
    sunny, blue = irradiance(panorama, (1, 0, 0)), irradiance(panorama, (-0.8, 0.6, 0))
    assert sunny[0] > 1.8 * sunny[2]
    assert blue[2] / blue[0] > 2 * sunny[2] / sunny[0]
    panorama = shrink(load_rig("neon").shape, 32)
    pink, blue = irradiance(panorama, (-1, 0, 0)), irradiance(panorama, (1, 0, 0))
    assert pink[0] > 2 * pink[2]
    assert blue[2] > 5 * blue[0]


def test_an_unknown_rig_names_those_there_are():
    with pytest.raises(InputError, match="no light rig called rembrant; there are .*rembrandt"):
        load_rig("rembrant")
    with pytest.raises(InputError):
        load_rig("../rigs/rembrandt")


# Descriptions that are wrong

GOOD = """
[room]
kelvin = 5600
intensity = 0.1
[[area_light]]
azimuth_deg = 10
elevation_deg = 20
width_deg = 30
height_deg = 30
kelvin = 5600
intensity = 1
"""


def test_a_good_description_parses():
    lamp = parse_rig(tomllib.loads(GOOD)).area_lights[0]
    assert (lamp.azimuth_deg, lamp.elevation_deg, lamp.form) == (10, 20, "rectangle")
    np.testing.assert_allclose(lamp.colour, 1, rtol=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("azimuth_deg = 10\n", "", "area_light 1: azimuth_deg is missing"),
        ("azimuth_deg = 10", "azimut_deg = 10", "unknown setting azimut_deg"),
        ("azimuth_deg = 10", "azimuth_deg = nan", "azimuth_deg must be a number"),
        ("azimuth_deg = 10", "azimuth_deg = true", "azimuth_deg must be a number"),
        ("elevation_deg = 20", "elevation_deg = 91", "elevation_deg must be a number from -90 to 90"),
        ("width_deg = 30", "width_deg = 0", "width_deg must be a number from 0.5"),
        ("intensity = 1\n", "intensity = -1\n", "intensity must be"),
        ("intensity = 1\n", 'intensity = 1\nform = "heart"\n', 'not "heart"'),
        ("intensity = 1\n", 'intensity = 1\nform = "disc"\n', "no height_deg"),
        ("intensity = 1\n", "intensity = 1\nhole_deg = 5\n", "hole_deg belongs to a disc"),
        ("intensity = 1\n", "intensity = 1\ncolour = [1, 1, 1]\n", "either colour or kelvin"),
        ("intensity = 1\n", "intensity = 1\nname = 3\n", "name must be text"),
        ("kelvin = 5600\nintensity = 1\n", "colour = [1, 1]\nintensity = 1\n", "three linear values"),
        ("kelvin = 5600\nintensity = 1\n", "colour = [1, -1, 0]\nintensity = 1\n", "three linear values"),
        ("kelvin = 5600\nintensity = 1\n", f"colour = [1, 1, {10**400}]\nintensity = 1\n", "three linear values"),
        ("height_deg = 30\n", "form = 'disc'\nhole_deg = 29.99\n", "at most 0.9 of its width_deg"),
        ("kelvin = 5600\nintensity = 1\n", "kelvin = 900\nintensity = 1\n", "number from 1667"),
        ("[[area_light]]", "[area_light]", "two brackets"),
        ("[room]", "[rooms]", "unknown setting rooms"),
        ("[room]\nkelvin = 5600\nintensity = 0.1\n", "", "either \\[room\\] or \\[sky\\]"),
        ("[room]\n", "room = 3\n[x]\n", "unknown setting x"),
        ("kelvin = 5600", "kelvin = ", "not a readable light rig"),
        ("kelvin = 5600", "kelvin = 1" + 5000 * "0", "not a readable light rig"),
    ],
)
def test_wrong_descriptions_name_the_file_and_the_setting(tmp_path, old, new, words):
    path = tmp_path / "mine.toml"
    assert old in GOOD
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(InputError, match=words) as caught:
        read_rig(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unreadable_descriptions(tmp_path):
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    for name in ("bytes.toml", "missing.toml"):
        with pytest.raises(InputError, match=name):
            read_rig(tmp_path / name)


# Colour temperature


def test_the_white_balance_comes_out_grey():
    for kelvin in (2000, 3200, 5600, 10000):
        np.testing.assert_allclose(kelvin_to_rgb(kelvin, kelvin), 1.0, rtol=1e-9)


def test_cool_bodies_are_red_and_hot_ones_blue():
    redness = [kelvin_to_rgb(k)[0] / kelvin_to_rgb(k)[2] for k in (1700, 2500, 3999, 4001, 5600, 8000, 20000)]
    assert redness == sorted(redness, reverse=True)
    assert redness[0] > 8
    assert redness[-1] < 0.6
    assert luminance(kelvin_to_rgb(3000)) == pytest.approx(1.0)


def test_daylight_is_near_the_white_of_rec709():
    """A black body of 6500 K lies close beside D65, a little to the pink."""
    warm = kelvin_to_rgb(6500, 6500) / kelvin_to_rgb(5600, 6500)
    assert warm[0] < 1 < warm[2]


@pytest.mark.parametrize("kelvin", [0, 1600, 30000, float("nan")])
def test_impossible_temperatures_are_refused(kelvin):
    with pytest.raises(ValueError, match="K is not between"):
        kelvin_to_rgb(kelvin)
