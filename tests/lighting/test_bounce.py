"""The light that a surface throws onto itself."""

import pytest
import torch

from relight_core.lighting.bounce import form_factors, gather_bounce

SIZE = 64


def step(height=0.25, albedo=0.6):
    """A floor that faces the camera, left, below a wall in the middle that leans toward the left."""
    normal = torch.zeros(1, 3, SIZE, SIZE)
    normal[:, 2] = 1
    x = (torch.arange(SIZE) + 0.5) / SIZE * 2 - 1
    relief = (x.clamp(0, height))[None, None, None].expand(1, 1, SIZE, SIZE)
    wall = (x > 0) & (x < height)
    normal[:, :, :, wall] = torch.tensor([-1.0, 0.0, 1.0])[None, :, None, None] / 2**0.5
    return normal, relief, torch.full((1, 3, SIZE, SIZE), albedo), torch.ones(1, 1, SIZE, SIZE), wall


def test_a_lit_wall_lights_the_floor_beside_it_and_less_farther_off():
    normal, relief, albedo, person, wall = step()
    bounce = gather_bounce(normal, relief, albedo, person, torch.ones(SIZE, SIZE))
    irradiance = torch.zeros(1, 3, SIZE, SIZE)
    irradiance[..., wall] = 1.0
    lit = bounce.add_to(irradiance)
    row = lit[0, 0, SIZE // 2]
    near, middle, far = row[30], row[22], row[4]
    assert 0.02 < near < 0.5
    assert near > 2 * middle > 4 * far > 0
    assert (lit >= irradiance).all()
    assert torch.equal(irradiance[..., wall], torch.ones_like(irradiance[..., wall]))


def test_it_is_linear_in_the_light_and_gives_back_no_more_than_falls_in():
    normal, relief, albedo, person, _ = step(albedo=1.0)
    bounce = gather_bounce(normal, relief, albedo, person, torch.ones(SIZE, SIZE))
    light = torch.rand(1, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(0))
    once, twice = (bounce.add_to(scale * light) for scale in (1, 2))
    torch.testing.assert_close(twice, 2 * once)
    white = torch.ones(1, 3, SIZE, SIZE)
    assert bounce.add_to(white).max() <= 2.0


def test_what_receives_nothing_stays_as_it_is():
    normal, relief, albedo, person, _ = step()
    receives = torch.zeros(SIZE, SIZE)
    light = torch.ones(1, 3, SIZE, SIZE)
    assert gather_bounce(normal, relief, albedo, person, receives).add_to(light) is light
    receives[:, :8] = 1
    lit = gather_bounce(normal, relief, albedo, person, receives).add_to(light)
    assert torch.equal(lit[..., 8:], light[..., 8:])


def test_what_receives_a_quarter_gets_a_quarter():
    normal, relief, albedo, person, _ = step()
    light = torch.ones(1, 3, SIZE, SIZE)
    all_of_it, quarter = (
        gather_bounce(normal, relief, albedo, person, torch.full((SIZE, SIZE), share)) for share in (1.0, 0.25)
    )
    torch.testing.assert_close(quarter.of(light), 0.25 * all_of_it.of(light))


def test_behind_the_person_nothing_is_sent():
    normal, relief, albedo, person, wall = step()
    bounce = gather_bounce(normal, relief, albedo, person * 0, torch.ones(SIZE, SIZE))
    light = torch.ones(1, 3, SIZE, SIZE)
    torch.testing.assert_close(bounce.add_to(light), light)


def test_a_wall_above_lights_what_is_above_it_as_one_at_the_side_does():
    normal, relief, albedo, person, wall = step()
    light = torch.ones(1, 3, SIZE, SIZE) * wall
    everywhere = torch.ones(SIZE, SIZE)
    beside = gather_bounce(normal, relief, albedo, person, everywhere).add_to(light)
    # Transposed, the wall that leaned to the left leans up, which is +y.
    turned = torch.stack([normal[:, 1], -normal[:, 0], normal[:, 2]], 1).mT
    above = gather_bounce(turned, relief.mT, albedo, person, everywhere).add_to(light.mT)
    torch.testing.assert_close(above, beside.mT)


def test_a_surface_that_is_half_there_sends_half():
    normal, relief, albedo, person, _ = step()
    whole, half = (gather_bounce(normal, relief, albedo, person * share, torch.ones(SIZE, SIZE)) for share in (1, 0.5))
    light = torch.ones(1, 3, SIZE, SIZE)
    torch.testing.assert_close(half.of(light), whole.of(light) / 2)


@pytest.mark.parametrize(
    ("apart", "leaning", "share"),
    [
        (1.0, (-1.0, 0.0, 0.0), 0.012732),  # seen from its side, of which no more than four times its width is known
        (1.0, (-0.6, 0.0, 0.8), 0.0023873),
        (0.001, (-0.6, 0.0, 0.8), 0.42441),  # no nearer than three quarters of its width
    ],
)
def test_how_much_a_cell_is_of_what_a_point_sees(apart, leaning, share):
    points = torch.tensor([[0.0, 0.0, 0.0]]), torch.tensor([[1.0, 0.0, 0.0]])
    cells = torch.tensor([[apart, 0.0, 0.0]]), torch.tensor([leaning])
    assert float(form_factors(*points, *cells, 0.1)) == pytest.approx(share, rel=1e-3)


@pytest.mark.parametrize(
    ("facing", "there", "away"),
    [
        ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.8, 0.0, 0.6)),  # the cell turns its back
        ((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (-0.8, 0.0, 0.6)),  # the point turns its back
        ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (-0.8, 0.0, 0.6)),  # it is itself
    ],
)
def test_what_looks_away_is_not_seen(facing, there, away):
    here = torch.zeros(1, 3)
    assert float(form_factors(here, torch.tensor([facing]), torch.tensor([there]), torch.tensor([away]), 0.1)) == 0


def test_where_a_surface_sees_more_of_itself_than_there_is_to_see_it_gets_no_more_than_all():
    """Noise in normals and relief can have every cell look straight at a point."""
    normal, relief, albedo, person, _ = step(albedo=1.0)
    normal = torch.zeros_like(normal)
    normal[:, 0, :, : SIZE // 2], normal[:, 0, :, SIZE // 2 :] = 1.0, -1.0
    bounce = gather_bounce(normal, torch.zeros_like(relief), albedo, person, torch.ones(SIZE, SIZE))
    got = bounce.of(torch.ones(1, 3, SIZE, SIZE))
    assert 0.9 < got.max() <= 1.0 + 1e-5
