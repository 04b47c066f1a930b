"""Muon's step, beside the singular values that it is about."""

import pytest
import torch

from relight_core.training.muon import Muon, evened


def random_matrix(rows, columns, seed=0):
    return torch.randn(rows, columns, generator=torch.Generator().manual_seed(seed))


@pytest.mark.parametrize("shape", [(6, 40), (40, 6), (8, 8), (1, 5)])
def test_the_polynomial_acts_on_every_singular_value_by_itself(shape):
    matrix = random_matrix(*shape).double()
    left, values, right = torch.linalg.svd(matrix / matrix.norm(), full_matrices=False)
    for _ in range(5):
        values = 3.4445 * values - 4.7750 * values**3 + 2.0315 * values**5
    torch.testing.assert_close(evened(matrix), left @ torch.diag(values) @ right, rtol=1e-6, atol=1e-8)


def test_directions_a_hundredth_as_strong_move_as_far():
    left, _, right = torch.linalg.svd(random_matrix(16, 200), full_matrices=False)
    values = torch.logspace(0, -2, 16)
    lengths = torch.linalg.svdvals(evened(left @ torch.diag(values) @ right))
    assert 0.6 < lengths.min() <= lengths.max() < 1.3


def test_nothing_moves_nothing_and_one_rank_stays_finite():
    assert torch.equal(evened(torch.zeros(4, 9)), torch.zeros(4, 9))
    assert torch.isfinite(evened(torch.ones(64, 500) * 1e-30)).all()
    assert torch.isfinite(evened(torch.ones(64, 500) * 1e18)).all()


def test_how_long_a_gradient_is_does_not_matter():
    matrix = random_matrix(6, 40)
    torch.testing.assert_close(evened(matrix * 1e-6), evened(matrix))


def test_matrices_of_one_shape_move_as_each_would_alone():
    shapes = [(6, 20), (20, 6), (6, 20), (4, 4)]
    together = [torch.nn.Parameter(random_matrix(*shape, seed)) for seed, shape in enumerate(shapes)]
    alone = [torch.nn.Parameter(matrix.detach().clone()) for matrix in together]
    one, each = Muon(together, lr=0.02, weight_decay=0.01), [Muon([m], lr=0.02, weight_decay=0.01) for m in alone]
    for step in range(3):
        for number, (first, second) in enumerate(zip(together, alone, strict=True)):
            # The last has no gradient at first.
            first.grad = random_matrix(*shapes[number], 10 * step + number) if number < 3 or step else None
            second.grad = None if first.grad is None else first.grad.clone()
        one.step()
        for optimiser in each:
            optimiser.step()
    for first, second in zip(together, alone, strict=True):
        torch.testing.assert_close(first, second, atol=1e-5, rtol=1e-4)


@pytest.mark.parametrize("shape", [(24, 90), (90, 24)])
def test_it_steps_as_pytorchs_own_does(shape):
    theirs, ours = (torch.nn.Parameter(random_matrix(*shape)) for _ in range(2))
    start = ours.detach().clone()
    steps = torch.optim.Muon([theirs], lr=0.02, weight_decay=0.01), Muon([ours], lr=0.02, weight_decay=0.01)
    for seed in range(1, 4):
        for weight, optimiser in zip((theirs, ours), steps, strict=True):
            weight.grad = random_matrix(*shape, seed)
            optimiser.step()
    assert (ours - theirs).norm() < 0.03 * (theirs - start).norm()
