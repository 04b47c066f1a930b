"""The paper's losses against numbers worked out by hand."""

import math

import pytest
import torch

from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork
from relight_core.training import losses
from relight_core.training.losses import (
    edges_l1,
    focal_parsing,
    fraction_loss,
    horizon_l1,
    irradiance_l1,
    level_of,
    levelled_l1,
    masked_l1,
    masked_l2,
    relief_l1,
    slope_l1,
    wlog_l2,
)
from relight_core.training.relight_steps import specular_shadow_losses


def row(*values):
    return torch.tensor(values, dtype=torch.float32).reshape(1, 1, 1, -1)


class TestMaskedL1:
    def test_is_the_mean_over_covered_pixels(self):
        assert float(masked_l1(row(1, 5, 2), row(0, 0, 0), row(1, 0, 1))) == pytest.approx(1.5)

    def test_counts_every_channel(self):
        estimate = torch.tensor([3.0, 0, 0]).reshape(1, 3, 1, 1).expand(1, 3, 2, 2)
        assert float(masked_l1(estimate, torch.zeros(1, 3, 2, 2), torch.ones(1, 1, 2, 2))) == pytest.approx(1)

    def test_an_empty_mask_gives_zero_and_finite_gradients(self):
        estimate = torch.rand(1, 3, 4, 4, requires_grad=True)
        loss = masked_l1(estimate, torch.zeros(1, 3, 4, 4), torch.zeros(1, 1, 4, 4))
        loss.backward()
        assert float(loss.detach()) == 0
        assert estimate.grad.abs().max() == 0


class TestLevelledL1:
    def test_no_error_in_what_is_only_brighter_and_of_another_colour(self):
        truth = torch.rand(2, 3, 4, 4)
        tinted = truth * torch.tensor([0.5, 1.5, 2.0])[None, :, None, None]
        assert float(levelled_l1(tinted, truth, torch.ones(2, 1, 4, 4))) == pytest.approx(0, abs=1e-6)

    def test_shading_left_in_a_part_counts(self):
        """2 and 1 for 1 and 1: the best factor is 3 / 5, which leaves errors of 0.2 and 0.4."""
        assert float(levelled_l1(row(2, 1, 9), row(1, 1, 0), row(1, 1, 0))) == pytest.approx(0.3)

    def test_black_and_empty_estimates_have_finite_gradients(self):
        estimate = torch.zeros(1, 3, 4, 4, requires_grad=True)
        loss = levelled_l1(estimate, torch.rand(1, 3, 4, 4), torch.ones(1, 1, 4, 4))
        loss = loss + levelled_l1(estimate, torch.rand(1, 3, 4, 4), torch.zeros(1, 1, 4, 4))
        loss.backward()
        assert estimate.grad.isfinite().all()


class TestMaskedL2:
    def test_is_the_mean_square_over_covered_pixels(self):
        assert float(masked_l2(row(1, 5, 2), row(0, 0, 0), row(1, 0, 1))) == pytest.approx(2.5)

    def test_an_empty_mask_gives_zero(self):
        assert float(masked_l2(row(1, 5), row(0, 0), row(0, 0))) == 0


class TestFocalParsing:
    def test_even_guess_between_two_classes(self):
        """-(1 - 1/2)^2 ln(1/2)."""
        loss = focal_parsing(torch.zeros(1, 2, 2, 2), torch.zeros(1, 2, 2, dtype=torch.int64))
        assert float(loss) == pytest.approx(0.25 * math.log(2))

    def test_focus_zero_is_cross_entropy(self):
        logits, label = torch.randn(2, 5, 3, 3), torch.randint(5, (2, 3, 3))
        expected = torch.nn.functional.cross_entropy(logits, label)
        assert float(focal_parsing(logits, label, focus=0.0)) == pytest.approx(float(expected), rel=1e-5)

    def test_classes_that_no_pixel_has_do_no_harm(self):
        logits = torch.zeros(1, 14, 2, 2, requires_grad=True)
        loss = focal_parsing(logits, torch.full((1, 2, 2), 3))
        loss.backward()
        assert math.isfinite(float(loss.detach()))
        assert torch.isfinite(logits.grad).all()

    @pytest.mark.parametrize("size", [200.0, -200.0])
    def test_certain_right_and_certain_wrong_stay_finite(self, size):
        logits = torch.zeros(1, 3, 1, 1)
        logits[:, 0] = size
        logits.requires_grad_(True)
        loss = focal_parsing(logits, torch.zeros(1, 1, 1, dtype=torch.int64))
        loss.backward()
        assert math.isfinite(float(loss.detach()))
        assert torch.isfinite(logits.grad).all()


class TestWlogL2:
    def test_one_and_nothing(self):
        """Every difference is ln 2; the weights w have mean 1, so their mean square remains."""
        edges = torch.cos(math.pi * torch.arange(17) / 16)
        weight = (edges[:-1] - edges[1:]) / (edges[:-1] - edges[1:]).mean()
        expected = float(weight.square().mean()) * math.log(2) ** 2
        loss = wlog_l2(torch.ones(2, 16, 32, 3), torch.zeros(2, 16, 32, 3))
        assert float(loss) == pytest.approx(expected, rel=1e-4)

    def test_the_equator_weighs_more_than_the_pole(self):
        truth = torch.zeros(1, 16, 32, 3)
        pole, equator = truth.clone(), truth.clone()
        pole[:, 0, 5], equator[:, 8, 5] = 1, 1
        assert float(wlog_l2(equator, truth)) > 50 * float(wlog_l2(pole, truth))

    def test_of_equal_lights_is_zero_however_bright(self):
        light = torch.rand(1, 16, 32, 3) * 1e4
        assert float(wlog_l2(light, light)) == 0


def test_lights_differ_by_what_they_do_to_a_white_ball():
    """An even light of 1 lights all of it by 1, whatever it mirrors: a difference of ln 2 from none."""
    even = torch.ones(2, 16, 32, 3)
    assert float(irradiance_l1(even, 0 * even, ReflectionTable())) == pytest.approx(math.log(2), rel=1e-2)
    assert float(irradiance_l1(0 * even, 3 * even, ReflectionTable())) == pytest.approx(math.log(4), rel=1e-2)


class TestSlopeL1:
    def test_a_shift_costs_nothing(self):
        truth = torch.rand(1, 1, 5, 5)
        assert float(slope_l1(truth + 7, truth, torch.ones(1, 1, 5, 5))) == pytest.approx(0, abs=1e-5)

    def test_counts_steps_between_covered_neighbours(self):
        """Along the row steps are 1 and 2, the second of them into the uncovered pixel."""
        assert float(slope_l1(row(0, 1, 3), row(0, 0, 0), row(1, 1, 0))) == pytest.approx(1)

    def test_counts_steps_between_pixels_farther_apart(self):
        """Two apart, the row steps by 3 from its first pixel and by 2 from its second."""
        rows = row(0, 1, 3, 3).expand(1, 1, 4, 4)
        assert float(slope_l1(rows, 0 * rows, torch.ones(1, 1, 4, 4), 2)) == pytest.approx((3 + 2) / 2)

    def test_steps_downward_count_as_those_to_the_right(self):
        rows = row(0, 1, 3, 3).expand(1, 1, 4, 4)
        assert float(slope_l1(rows.mT, 0 * rows, torch.ones(1, 1, 4, 4))) == pytest.approx((1 + 2 + 0) / 3)


class TestEdgesL1:
    def test_a_wide_edge_costs_more_than_as_much_noise(self):
        """Checks of plus and minus a half against one step of 1 in the middle."""
        covered, flat = torch.ones(1, 1, 16, 16), torch.zeros(1, 1, 16, 16)
        noise = (torch.arange(16)[:, None] + torch.arange(16)) % 2 - 0.5
        step = flat.clone()
        step[..., 8:] = 1
        fine = [float(slope_l1(image, flat, covered)) for image in (noise[None, None], step)]
        both = [float(edges_l1(image, flat, covered)) for image in (noise[None, None], step)]
        assert both[0] == pytest.approx(fine[0])
        assert both[1] > 3 * fine[1]

    def test_what_is_half_covered_does_not_count(self):
        covered = torch.ones(1, 1, 16, 16)
        covered[..., 9:] = 0
        outside = torch.zeros(1, 1, 16, 16)
        outside[..., 9:] = 100
        assert float(edges_l1(outside, 0 * outside, covered)) == 0


class TestReliefL1:
    def test_a_step_costs_more_than_the_same_height_everywhere(self):
        """Half of a surface raised by 1 against all of it."""
        flat, covered = torch.zeros(1, 1, 32, 32), torch.ones(1, 1, 32, 32)
        step = flat.clone()
        step[..., 16:] = 1
        assert float(relief_l1(step, flat, covered)) > 2 * float(relief_l1(flat + 1, flat, covered)) > 0

    def test_a_step_counts_by_its_height_and_from_near_and_far(self):
        """Of 31 differences of neighbours one has the step in it, of 28 that are 4 apart four, of 16 at 16 all."""
        step = torch.zeros(1, 1, 32, 32)
        step[..., 16:] = 1
        expected = 0.3 * 1 / 2 + 8.0 * 1 / 31 + 2.0 * 4 / 28 + 0.5 * 16 / 16
        assert float(relief_l1(step, 0 * step, torch.ones(1, 1, 32, 32))) == pytest.approx(expected, rel=1e-5)

    def test_is_finite_where_nothing_is_covered(self):
        flat = torch.zeros(1, 1, 32, 32, requires_grad=True)
        loss = relief_l1(flat, flat.detach() + 1, torch.zeros(1, 1, 32, 32))
        loss.backward()
        assert float(loss.detach()) == 0
        assert torch.isfinite(flat.grad).all()


class TestFractionLoss:
    def test_is_cross_entropy_weighted_by_light(self):
        """ln 2 at logit 0, whatever the fraction; weights 1 and 3 and a dark pixel."""
        loss = fraction_loss(row(0, 0, 9), row(0.2, 1, 0), row(1, 3, 0))
        assert float(loss) == pytest.approx(math.log(2), rel=1e-5)

    def test_a_glint_weighs_no_more_than_four_times_a_light_of_level_one(self):
        assert float(fraction_loss(row(0, 99), row(1, 1), row(400, 1))) == pytest.approx(math.log(2) * 4 / 5, rel=1e-5)

    def test_favours_the_true_fraction(self):
        def at(logit):
            return float(fraction_loss(row(logit), row(0.25), row(2.0)))

        true_logit = math.log(0.25 / 0.75)
        assert at(true_logit) < min(at(true_logit - 0.5), at(true_logit + 0.5))

    def test_without_light_gives_zero_and_finite_gradients(self):
        logit = torch.randn(1, 1, 3, 3, requires_grad=True)
        loss = fraction_loss(logit, torch.rand(1, 1, 3, 3), torch.zeros(1, 1, 3, 3))
        loss.backward()
        assert float(loss.detach()) == 0
        assert torch.isfinite(logit.grad).all()


class TestHorizonL1:
    AROUND = torch.tensor([0.1, 1.6, 3.2, 4.7])

    def terrace(self, height=0.5):
        """A plane whose right half stands nearer."""
        relief = torch.zeros(1, 1, 64, 64)
        relief[..., 32:] = height
        return relief

    def error(self, estimate, truth, covered=None):
        return horizon_l1(estimate, truth, torch.ones_like(truth) if covered is None else covered, self.AROUND)

    def test_how_far_away_all_of_a_surface_is_hides_nothing(self):
        assert float(self.error(self.terrace() + 0.7, self.terrace())) == pytest.approx(0, abs=1e-5)

    def test_a_flatter_one_is_worse_the_flatter_it_is(self):
        flat, half, most = (float(self.error(self.terrace(height), self.terrace())) for height in (0.0, 0.25, 0.4))
        assert flat > 1.5 * half > 3 * most

    def test_no_wall_hides_more_than_all_of_a_level_light(self):
        assert 0.1 < float(self.error(self.terrace(0.0), self.terrace(100.0))) < 1

    def test_it_raises_what_is_too_low(self):
        estimate = self.terrace(0.25).requires_grad_()
        self.error(estimate, self.terrace()).backward()
        assert estimate.grad[..., 32:].sum() < 0 < estimate.grad[..., :32].sum()

    def test_counts_only_what_is_covered(self):
        covered = torch.ones(1, 1, 64, 64)
        covered[..., 32:] = 0
        assert float(self.error(self.terrace(0.1), self.terrace(), covered)) == 0

    def test_an_empty_mask_gives_zero_and_finite_gradients(self):
        estimate = torch.rand(1, 1, 64, 64, requires_grad=True)
        loss = self.error(estimate, self.terrace(), torch.zeros(1, 1, 64, 64))
        loss.backward()
        assert float(loss.detach()) == 0
        assert torch.isfinite(estimate.grad).all()

    def test_larger_pictures_of_the_same_surface_have_the_same_error(self):
        small = self.terrace(0.2), self.terrace()
        large = [relief.repeat_interleave(4, 2).repeat_interleave(4, 3) for relief in small]
        expected = float(self.error(*small))
        assert float(self.error(*large)) == pytest.approx(expected, rel=1e-4)


class TestAdditiveShadow:
    def test_sparse_shadow_wakes_a_network_that_sees_none(self):
        """A fifth of the pixels is in shadow: the absolute error is least at no shadow, the sum of both isn't."""
        network = SpecularShadowNetwork(SpecularShadowConfig(2, 2, False, False, additive=True)).train()
        with torch.no_grad():
            network.head.weight.zero_()
        size = 20
        shadow = torch.zeros(1, 1, size, size)
        shadow[..., :4, :] = 0.5
        surface = {
            "normal": torch.tensor([0.0, 0, 1])[None, :, None, None].expand(1, 3, size, size),
            "albedo": torch.full((1, 3, size, size), 0.5),
            "covered": torch.ones(1, 1, size, size),
            "reflected": torch.ones(1, 6, size, size),
        }
        flat = surface | {"light": torch.ones(1, 16, 32, 3), "shadow": shadow, "specular": torch.zeros_like(shadow)}
        losses = specular_shadow_losses(network, ReflectionTable(), flat)[1]

        def slope(*names: str) -> float:
            total = sum(losses[name] for name in names)
            return float(torch.autograd.grad(total, network.head.bias, retain_graph=True)[0].sum())

        assert slope("shadow") > 0
        assert slope("shadow", "shadow_squared") < 0


def test_edges_count_a_face_as_often_as_pixels_do():
    """An error at an edge between two pixels of weight 2, beside a like one between two of weight 1."""
    truth = torch.zeros(1, 1, 1, 4)
    estimate = torch.tensor([0.0, 3.0, 0.0, 0.0]).reshape(1, 1, 1, 4)
    weight = torch.tensor([2.0, 2.0, 1.0, 1.0]).reshape(1, 1, 1, 4)
    # Steps of 3, 3 and 0 with weights of 2, 1 and 1.
    assert float(slope_l1(estimate, truth, weight)) == pytest.approx((2 * 3 + 1 * 3) / 4)


def test_horizons_do_not_depend_on_what_lies_outside_the_head():
    torch.manual_seed(2)
    y, x = torch.meshgrid(torch.linspace(-1, 1, 128), torch.linspace(-1, 1, 128), indexing="ij")
    covered = (x**2 + (1.3 * y) ** 2 < 0.5).float()[None, None]
    relief = (0.4 * (1 - x**2 - y**2))[None, None]
    estimate = relief + 0.05 * torch.randn_like(relief)
    azimuth_rad = torch.tensor([0.3, 2.0])
    expected = horizon_l1(estimate, relief, covered, azimuth_rad)
    walled = [torch.where(covered > 0, image, wall) for image, wall in ((estimate, 3.0), (relief, -2.0))]
    assert float(expected) > 0
    torch.testing.assert_close(horizon_l1(*walled, covered, azimuth_rad), expected)


def test_a_level_is_grey_of_covered_pixels_and_has_no_gradient():
    truth = torch.rand(2, 3, 4, 4) + 0.1
    estimate = (truth * torch.tensor([0.5, 2.0]).reshape(2, 1, 1, 1)).requires_grad_()
    covered = torch.ones(2, 1, 4, 4)
    covered[..., 0] = 0
    spoiled = torch.where(covered > 0, estimate, 50.0)
    level = level_of(spoiled, truth, covered)
    assert level.flatten().tolist() == pytest.approx([2.0, 0.5], rel=1e-5)
    assert not level.requires_grad


def test_the_level_of_nothing_is_finite():
    nothing = torch.zeros(1, 3, 4, 4)
    assert torch.isfinite(level_of(nothing, nothing, torch.zeros(1, 1, 4, 4))).all()


def test_what_was_measured_can_be_learnt_from_afterwards():
    losses._relative_solid_angles.cache_clear()
    truth = torch.rand(1, 16, 32, 3)
    with torch.inference_mode():
        wlog_l2(truth, truth)
    estimate = torch.rand(1, 16, 32, 3, requires_grad=True)
    wlog_l2(estimate, truth).backward()
    assert estimate.grad.abs().max() > 0
