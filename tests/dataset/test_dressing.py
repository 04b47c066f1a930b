"""Hair, beards and MakeHuman's clothes on a head as round as a ball."""

import json

import numpy as np
import pytest
from ball_heads import CENTRE, RADIUS, assert_well_formed, ball_head, sphere, surface
from makehuman_files import quad_proxy
from PIL import Image

from relight_core.dataset.garments.beard_shell import BeardPatch
from relight_core.dataset.garments.garment_binding import HeadSurface, bind, fit_affine
from relight_core.dataset.garments.garment_mesh import clip, compact, fractal, subdivide, vertex_normals, waves
from relight_core.dataset.garments.hair_shell import ScalpGrid, grow_hair, sample_style
from relight_core.dataset.garments.makehuman import cut_by_opacity, find_root, read_base, read_item
from relight_core.dataset.garments.makehuman_fit import HeadWarp
from relight_core.dataset.heads import HeadModel
from relight_core.errors import InputError


@pytest.fixture(scope="module", name="ball_head")
def a_ball_head() -> HeadModel:
    return ball_head()


@pytest.fixture(scope="module")
def grid(ball_head) -> ScalpGrid:
    return ScalpGrid(ball_head)


def area(vertices, faces) -> float:
    corners = vertices[faces]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(doubled, axis=1).sum() / 2


def test_subdividing_keeps_the_surface_and_quarters_the_triangles():
    points, faces = sphere(60)
    edges, finer = subdivide(faces, len(points))
    refined = np.concatenate([points, points[edges].mean(1)])
    assert len(finer) == 4 * len(faces)
    assert area(refined, finer) == pytest.approx(area(points, faces))
    np.testing.assert_allclose(vertex_normals(refined, finer)[:60], vertex_normals(points, faces), atol=0.35)


def test_clipping_cuts_exactly_on_the_zero_line():
    points, faces = sphere(500)
    kept_faces, kept = clip(faces, points[:, 1] - 0.2, points)
    lost_faces, lost = clip(faces, 0.2 - points[:, 1], points)
    assert kept[:, 1].min() == pytest.approx(0.2, abs=1e-6)
    assert lost[:, 1].max() == pytest.approx(0.2, abs=1e-6)
    assert area(kept, kept_faces) + area(lost, lost_faces) == pytest.approx(area(points, faces))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_clipping_everything_or_nothing(sign):
    points, faces = sphere(60)
    kept_faces, kept = clip(faces, np.full(60, sign), points)
    assert len(kept_faces) == (len(faces) if sign > 0 else 0)
    assert kept.shape == ((60 if sign > 0 else 0), 3)


def test_compact_renumbers_values_with_their_faces():
    faces, values = compact(np.array([[7, 3, 5]]), np.arange(9) * 10)
    assert values[faces].tolist() == [[70, 30, 50]]


def test_bound_vertices_move_with_the_head_and_smoothly_between():
    head, _ = sphere(400)
    worn = head[:50] * 1.1
    binding = bind(worn, head, np.arange(400), 12)
    shifted = binding.follow(worn, np.broadcast_to([1.0, -2.0, 3.0], head.shape))
    np.testing.assert_allclose(shifted - worn, np.broadcast_to([1.0, -2.0, 3.0], worn.shape), atol=1e-4)
    stretched = binding.follow(worn, head * 0.2)
    assert (np.linalg.norm(stretched, axis=1) > np.linalg.norm(worn, axis=1) + 0.1).all()


def test_affine_fit_recovers_scale_and_shift():
    rng = np.random.default_rng(0)
    source = rng.normal(size=(30, 3)) + 5
    scale, shift = fit_affine(source, source * [1.2, 0.9, 1.1] + [1, 2, 3], 1e-9)
    np.testing.assert_allclose(scale, [1.2, 0.9, 1.1], atol=1e-6)
    np.testing.assert_allclose(shift, [1, 2, 3], atol=1e-5)


def test_pushing_out_lifts_what_is_inside_and_leaves_the_rest(ball_head):
    skin = surface(ball_head, ball_head.mean)
    outward = (ball_head.mean[::10] - CENTRE) / RADIUS
    sunk, clear = CENTRE + outward * (RADIUS - 1), CENTRE + outward * (RADIUS + 1)
    lifted = skin.push_out(sunk, 0.2)
    assert np.linalg.norm(lifted - CENTRE, axis=1).min() > RADIUS + 0.1
    np.testing.assert_allclose(skin.push_out(clear, 0.2), clear, atol=1e-5)
    pressed = skin.press_down(clear, np.full(len(clear), 0.3))
    np.testing.assert_allclose(np.linalg.norm(pressed - CENTRE, axis=1), RADIUS + 0.3, atol=0.1)


def test_what_is_worn_does_not_tear_where_its_nearest_anchors_change():
    head, _ = sphere(400)
    line = np.linspace([-0.5, 0.3, 1.0], [0.5, 0.2, 1.0], 2000)
    moved = np.random.default_rng(0).normal(0, 1, head.shape)
    steps = np.diff(bind(line, head, np.arange(400), 12).follow(0 * line, moved), axis=0)
    assert np.abs(steps).max() < 8 * np.abs(steps).mean()


def test_folds_and_tufts_are_as_long_and_strong_as_was_asked_for():
    """Plane waves of wavelength L: points L / 8 apart are alike, those many L apart are not."""
    points = np.random.default_rng(0).uniform(-60, 60, (4000, 3))
    for noise in (waves, lambda at, rng, length: fractal(at, rng, length, 3)):
        fields, near, far = [], [], []
        for seed in range(6):
            drawn = [noise(points + [shift, 0, 0], np.random.default_rng(seed), 8.0) for shift in (0, 1, 2, 50)]
            fields.append(drawn[0])
            near.append(np.corrcoef(drawn[0], drawn[1])[0, 1])
            far.append(np.corrcoef(drawn[0], drawn[3])[0, 1])
        assert np.std(fields) == pytest.approx(1, abs=0.12)
        assert 0.7 < np.mean(near) < 0.97
        assert abs(np.mean(far)) < 0.3
    layers = [fractal(points, np.random.default_rng(1), 8.0, octaves) for octaves in (1, 4)]
    assert np.corrcoef(*layers)[0, 1] > 0.8
    combed = [
        waves(points + shift, np.random.default_rng(2), 4.0, (1, 6, 1)) for shift in ([0] * 3, [2, 0, 0], [0, 2, 0])
    ]
    assert np.corrcoef(combed[0], combed[2])[0, 1] > 0.8 > 0.4 > np.corrcoef(combed[0], combed[1])[0, 1]


@pytest.mark.parametrize("seed", range(3))
def test_hair_lies_on_the_scalp_and_spares_the_face(ball_head, grid, seed):
    rng = np.random.default_rng(seed)
    hair = grow_hair(grid, ball_head.mean, surface(ball_head, ball_head.mean), sample_style(rng), rng)
    assert_well_formed(hair)
    assert hair.label == "hair"
    assert len(hair.faces) > 5000
    # The middle of the ball's face, at the height of eyes and mouth.
    front = hair.vertices[(np.abs(hair.vertices[:, 0]) < 3) & (hair.vertices[:, 2] > 4)]
    assert (front[:, 1] > 4).all()
    assert np.linalg.norm(hair.vertices - CENTRE, axis=1).min() > RADIUS - 0.3


def test_hair_follows_a_wider_head(ball_head, grid):
    style = sample_style(np.random.default_rng(3))
    widths = []
    for scale in (1.0, 1.2):
        head = ball_head.mean * np.array([scale, 1, 1], np.float32)
        worn = grow_hair(grid, head, surface(ball_head, head), style, np.random.default_rng(4))
        widths.append(np.ptp(worn.vertices[:, 0]))
    assert widths[1] > widths[0] + 2


def test_beards_are_hair_on_the_lower_face(ball_head):
    normals = vertex_normals(ball_head.mean, ball_head.triangles)
    patch = BeardPatch(ball_head)
    for seed in range(4):
        beard = patch.grow(ball_head.mean, normals, np.random.default_rng(seed))
        assert beard.label == "hair"
        assert len(beard.faces) > 100
        assert_well_formed(beard)
        assert beard.vertices[:, 1].max() < 4


def test_the_same_seed_gives_the_same_hair(ball_head, grid):
    def grow(seed):
        rng = np.random.default_rng(seed)
        style = sample_style(rng)
        return grow_hair(grid, ball_head.mean, surface(ball_head, ball_head.mean), style, rng)

    np.testing.assert_array_equal(grow(5).vertices, grow(5).vertices)
    assert grow(5).vertices.shape != grow(6).vertices.shape or (grow(5).vertices != grow(6).vertices).any()


def write_makehuman(root, opacity_right: int):
    """A base of one quad, and a proxy of one quad on it whose texture's right half has the given opacity."""
    (root / "3dobjs").mkdir()
    (root / "3dobjs" / "base.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\ng body\nf 1/1 2/2 3/3 4/4\ng helper-hair\nf 1 2 5\n"
    )
    folder = root / "proxies" / "hair" / "wig"
    (folder / "textures").mkdir(parents=True)
    texture = np.full((8, 8, 4), 255, np.uint8)
    texture[:, 4:, 3] = opacity_right
    Image.fromarray(texture).save(folder / "textures" / "wig.png")
    proxy = quad_proxy(0.1, {"mapDiffuse": "textures/wig.png"})
    (folder / "wig.json").write_text(json.dumps(proxy))
    return folder / "wig.json"


def test_a_proxy_is_placed_by_its_references(tmp_path):
    path = write_makehuman(tmp_path, 255)
    base, body = read_base(find_root(tmp_path))
    assert base.shape == (5, 3)
    assert len(body) == 2
    item = read_item(path, base)
    assert area(item.vertices, item.faces) == pytest.approx(100.0)
    np.testing.assert_allclose(item.vertices[:, 2], 1.0)
    assert item.opacity is None


def test_transparent_parts_are_cut_away(tmp_path):
    path = write_makehuman(tmp_path, 0)
    item = read_item(path, read_base(tmp_path)[0])
    cut = cut_by_opacity(item, 10_000, deepest=4)
    assert area(cut.vertices, cut.faces) == pytest.approx(50, abs=8)
    assert cut.vertices[cut.faces].mean(1)[:, 0].max() < 6
    assert len(cut_by_opacity(item, 1, deepest=4).faces) < len(cut.faces)


def test_of_a_texture_whose_lower_half_is_clear_the_upper_half_stays(tmp_path):
    path = write_makehuman(tmp_path, 255)
    texture = np.full((8, 8, 4), 255, np.uint8)
    texture[4:, :, 3] = 0
    Image.fromarray(texture).save(path.parent / "textures" / "wig.png")
    cut = cut_by_opacity(read_item(path, read_base(tmp_path)[0]), 10_000, deepest=4)
    assert cut.vertices[cut.faces].mean(1)[:, 1].min() > 4
    assert len(cut_by_opacity(read_item(path, read_base(tmp_path)[0]), 0).faces) > 0


def test_the_texture_that_a_proxy_names_is_taken_and_never_a_map_of_its_relief(tmp_path):
    path = write_makehuman(tmp_path, 240)
    for name, level in (("a_normal", 1), ("a_other", 2)):
        Image.fromarray(np.full((4, 4, 3), level, np.uint8)).save(path.parent / "textures" / f"{name}.png")
    base = read_base(tmp_path)[0]
    named = read_item(path, base)
    assert named.colour_srgb.max() == 255
    assert named.opacity.min() == 240
    (path.parent / "textures" / "wig.png").unlink()
    assert read_item(path, base).colour_srgb.max() == 2


def test_a_missing_archive_is_named(tmp_path):
    with pytest.raises(InputError, match="base.obj"):
        find_root(tmp_path)


def test_a_base_that_was_cut_short_is_named(ball_head):
    with pytest.raises(InputError, match=r"base\.obj: ends before its last vertex"):
        HeadWarp(np.zeros((14_741, 3)), np.zeros((1, 3), np.int32), ball_head)


def test_the_warp_carries_one_head_onto_another():
    body, faces = sphere(2000)
    base = np.zeros((14742, 3))
    base[:13380] = sphere(13380)[0]
    base[:2000] = body
    base = base * [8.0, 11.0, 9.0] + [0, 73, 4]
    base[14598:14742] = base[14598:14742] * 0 + [3, 73, 12]
    base[14670:14742, 0] = -3

    def to_model(points):
        wider = points * [1.15, 1.0, 1.05] - [0, 73, 0]
        return wider + 0.5 * np.sin(points[:, [1]] / 5) * [0, 0, 1]

    eyes = [base[14598:14670], base[14670:14742]]
    mean = to_model(np.concatenate([base[:13380], *eyes])).astype(np.float32)
    landmarks = np.zeros(68, np.int64)
    landmarks[[27, 30, 33, 51, 57, 8]] = [132, 5054, 343, 455, 496, 5171]
    region = np.repeat([0, 2, 3], [13380, 72, 72]).astype(np.uint8)
    model = HeadModel(
        mean=mean,
        identity=np.zeros(0),
        expression=np.zeros(0),
        expression_names=(),
        triangles=faces.astype(np.int64),
        triangles_uv=faces.astype(np.int64),
        triangle_region=np.zeros(len(faces), np.uint8),
        vertex_region=region,
        region_names=("face", "head_neck", "sclera_L", "sclera_R"),
        uv=np.zeros((1, 2)),
        landmarks=landmarks,
    )
    model_skin = HeadSurface(mean[:2000], vertex_normals(mean, faces)[:2000])
    height, _, _ = model_skin.height(HeadWarp(base, faces.astype(np.int32), model)(base[:2000]))
    assert np.sqrt((height**2).mean()) < 0.15
