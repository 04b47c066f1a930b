"""Light looked up by the normal, against sums over the sphere."""

import math

import numpy as np
import pytest
import torch

from relight_core.lighting.reflection import Gloss, NormalLookup, ReflectionTable, specular_lobe

HEIGHT, WIDTH = 16, 32


@pytest.fixture(scope="module")
def table():
    return ReflectionTable()


def texels():
    """Directions (512, 3) and solid angles (512,) of the 16 x 32 light, worked out here."""
    theta = np.pi * (np.arange(HEIGHT) + 0.5) / HEIGHT
    phi = 2 * np.pi * ((np.arange(WIDTH) + 0.5) / WIDTH - 0.5)
    toward = np.stack(
        [
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones(WIDTH)),
            -np.outer(np.sin(theta), np.cos(phi)),
        ],
        -1,
    )
    edges = np.cos(np.pi * np.arange(HEIGHT + 1) / HEIGHT)
    weight = np.repeat((edges[:-1] - edges[1:]) * 2 * np.pi / WIDTH, WIDTH)
    return toward.reshape(-1, 3), weight


def facing_normals(count=60, seed=0):
    """Unit normals toward the camera, not closer than 5 degrees to the silhouette: (1, 3, 1, count)."""
    rng = np.random.default_rng(seed)
    normals = rng.standard_normal((count * 4, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals[normals[:, 2] > 0.09][:count].astype(np.float32)
    return normals, torch.from_numpy(normals.T.copy())[None, :, None]


def random_light(seed, sharpness=1.0):
    return torch.from_numpy(np.random.default_rng(seed).gamma(sharpness, 1, (1, 16, 32, 3)).astype(np.float32))


def test_uniform_light_gives_every_normal_an_irradiance_of_one(table):
    _, normals = facing_normals()
    reflected = table(torch.ones(1, 16, 32, 3), normals)
    assert (reflected[:, :3] - 1).abs().max() < 0.02
    assert (reflected[:, 3:] > 0).all()
    assert (reflected[:, 3:] < 0.5).all()


@pytest.mark.parametrize("seed", [1, 2])
def test_irradiance_is_the_sum_over_the_sphere(table, seed):
    vectors, normals = facing_normals(seed=seed)
    toward, weight = texels()
    radiance = random_light(seed)
    cosine = np.clip(toward @ vectors.T, 0, None)
    expected = np.einsum("jp,j,jc->cp", cosine, weight, radiance.numpy().reshape(-1, 3)) / math.pi
    found = table(radiance, normals)[0, :3, 0].numpy()
    np.testing.assert_allclose(found, expected, rtol=0.03)


def test_gloss_is_the_sum_of_the_lobe_over_the_sphere(table):
    """Away from the silhouette, where the lobe changes within a texel of the table."""
    vectors, normals = facing_normals()
    inner = vectors[:, 2] > 0.4
    toward, weight = texels()
    radiance = random_light(3)
    lobe = specular_lobe(torch.from_numpy(toward).float(), torch.from_numpy(vectors)).numpy()
    expected = np.einsum("jp,j,jc->cp", lobe, weight, radiance.numpy().reshape(-1, 3))[:, inner]
    found = table(radiance, normals)[0, 3:, 0].numpy()[:, inner]
    assert np.abs(found - expected).mean() < 0.05 * expected.mean()


def test_is_linear_in_the_light(table):
    _, normals = facing_normals()
    one, other = random_light(4), random_light(5)
    both = table(2 * one + 3 * other, normals)
    torch.testing.assert_close(both, 2 * table(one, normals) + 3 * table(other, normals), rtol=1e-4, atol=1e-5)


def test_tables_of_a_batch_are_those_of_its_lights(table):
    one, other = random_light(6), random_light(7)
    torch.testing.assert_close(table.tabulate(torch.cat([one, other]))[1:], table.tabulate(other))


def test_turning_normals_and_light_together_changes_no_irradiance(table):
    """About +y by two texels; gloss depends on the camera, so it may change."""
    vectors, normals = facing_normals()
    turn = 2 * math.pi * 2 / WIDTH
    # Content that moves right in the panorama turns from -z toward +x.
    about_y = np.array([[math.cos(turn), 0, -math.sin(turn)], [0, 1, 0], [math.sin(turn), 0, math.cos(turn)]])
    turned = (vectors @ about_y.T).astype(np.float32)
    still_facing = turned[:, 2] > 0.09
    assert still_facing.sum() > 20
    radiance = random_light(8)
    before = table(radiance, normals)[0, :3, 0].T[torch.from_numpy(still_facing)]
    after = table(radiance.roll(2, 2), torch.from_numpy(turned.T.copy())[None, :, None])[0, :3, 0].T
    torch.testing.assert_close(after[torch.from_numpy(still_facing)], before, rtol=0.04, atol=0.01)


def test_a_lamp_on_the_right_of_the_panorama_lights_what_faces_right(table):
    radiance = torch.zeros(1, 16, 32, 3)
    radiance[:, 7:9, 24] = 100
    normals = torch.tensor([[0.8, 0, 0.6], [-0.8, 0, 0.6]]).T[None, :, None]
    right, left = table(radiance, normals)[0, 0, 0].tolist()
    assert right > 1
    assert left < 0.02 * right


def test_highlight_mirrors_the_camera(table):
    """A lamp 60 degrees to the right shines brightest where the normal lies half way to it."""
    radiance = torch.zeros(1, 16, 32, 3)
    toward, _ = texels()
    lamp = np.argmax(toward @ [math.sin(math.pi / 3), 0, math.cos(math.pi / 3)])
    radiance.view(-1, 3)[lamp] = 100
    angles = np.radians(np.arange(-80, 81, 2))
    normals = torch.tensor(np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)]), dtype=torch.float32)
    gloss = table(radiance, normals[None, :, None])[0, 3, 0].numpy()
    assert np.degrees(angles[gloss.argmax()]) == pytest.approx(30, abs=8)


@pytest.mark.parametrize(
    ("toward", "normal", "lobe"),
    [
        ((0, 0, 1), (0, 0, 1), 0.0611155),
        ((0.6, 0, 0.8), (0, 0, 1), 0.0096941),
        ((0.96, 0, -0.28), (0.8, 0, 0.6), 0.1161768),
        ((0, 0.8, 0.6), (0.6, 0, 0.8), 0.0010425),
    ],
)
def test_the_lobe_is_the_principled_bsdfs(toward, normal, lobe):
    """D F G1 G1 / (4 n.v) of a specular of 0.6 and a roughness of 0.5, worked out from the half-vector."""
    one, other = torch.tensor([toward], dtype=torch.float32), torch.tensor([normal], dtype=torch.float32)
    assert float(specular_lobe(one, other)) == pytest.approx(lobe, rel=1e-4)


def test_lobe_is_dark_below_the_horizon_and_finite_where_the_camera_grazes():
    toward, _ = texels()
    normals = torch.tensor([[0, 0, 1.0], [1.0, 0, 0], [0.999, 0, 0.0447], [0, -1, 0]])
    lobe = specular_lobe(torch.from_numpy(toward).float(), normals, Gloss(1.2, 0.05))
    assert torch.isfinite(lobe).all()
    assert (lobe >= 0).all()
    assert lobe[torch.from_numpy(toward[:, 2] < 0), 0].abs().max() == 0


def test_stays_in_whole_precision_under_autocast(table):
    _, normals = facing_normals()
    radiance = random_light(9) * 1000
    with torch.autocast("cpu", torch.bfloat16):
        found = table(radiance, normals)
    assert found.dtype == torch.float32
    torch.testing.assert_close(found, table(radiance, normals))


def test_a_normal_that_is_no_number_leaves_the_gradients_of_the_others(table):
    """Of a network that goes astray the next losses tell, if the process is still there to see them."""
    _, normals = facing_normals()
    astray = normals.clone()
    astray[..., :2] = torch.tensor([float("nan"), float("inf")])
    gradients = []
    for given in (normals, astray):
        given = given.clone().requires_grad_(True)
        table(random_light(9), given)[..., 2:].sum().backward()
        gradients.append(given.grad[..., 2:])
    assert gradients[0].abs().max() > 0.1
    torch.testing.assert_close(*gradients)


class TestNormalsMadeReady:
    """`NormalLookup` reads what the whole table says, of the cells that its normals need."""

    @pytest.mark.parametrize("gloss", [True, False])
    def test_agrees_with_the_whole_table(self, table, gloss):
        _, facing = facing_normals()
        # Also straight ahead, at the silhouette and turned away, where the table ends.
        edge = torch.tensor([[0, 0, 1.0], [1, 0, 0], [0, -1, 0], [0.6, 0, -0.8], [0, 0, -1]]).T[None, :, None]
        for normals in (facing, edge):
            lookup = NormalLookup(table, normals, gloss=gloss)
            for seed in (1, 2):
                radiance = random_light(seed, sharpness=0.05)
                expected = table(radiance, normals)[:, : 6 if gloss else 3]
                torch.testing.assert_close(lookup(radiance), expected, rtol=1e-4, atol=1e-5)

    def test_stays_in_whole_precision_under_autocast(self, table):
        lookup = NormalLookup(table, facing_normals()[1])
        with torch.autocast("cpu", torch.bfloat16):
            found = lookup(random_light(9) * 1000)
        torch.testing.assert_close(found, lookup(random_light(9) * 1000))
        assert found.dtype == torch.float32
