"""The light that explains a photo: found where the surface tells it, the guess where it does not."""

import pytest
import torch

from relight_core.lighting.inverse import explain_photo


def facing_transport() -> torch.Tensor:
    """Two pixels that see one texel each, and a third texel that nobody sees."""
    return torch.tensor([[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]])


def test_light_that_pixels_see_is_found():
    true = torch.tensor([[2.0, 1.0, 0.5], [0.4, 0.8, 1.2], [9.0, 9.0, 9.0]])
    guess = torch.ones(3, 3)
    found = explain_photo(guess, facing_transport(), facing_transport() @ true, torch.ones(2))
    assert torch.allclose(found[:2], true[:2], rtol=0.2)


def test_a_texel_nobody_sees_keeps_the_guess():
    found = explain_photo(torch.full((3, 3), 0.7), facing_transport(), torch.rand(2, 3), torch.ones(2))
    assert torch.allclose(found[2], torch.full((3,), 0.7))


def test_light_is_never_negative():
    found = explain_photo(torch.ones(3, 3), facing_transport(), torch.full((2, 3), -5.0), torch.ones(2))
    assert float(found.min()) >= 0


def test_untrusted_pixels_change_nothing():
    guess = torch.rand(3, 3)
    shading = torch.full((2, 3), 100.0)
    assert torch.equal(explain_photo(guess, facing_transport(), shading, torch.zeros(2)), guess)


def test_pixels_that_no_light_reaches_leave_the_guess():
    guess = torch.rand(3, 3)
    assert torch.equal(explain_photo(guess, torch.zeros(2, 3), torch.ones(2, 3), torch.ones(2)), guess)


def test_light_of_any_level_stays_finite():
    for level in (1e-8, 1e8):
        shading = torch.full((2, 3), level)
        found = explain_photo(torch.full((3, 3), level), facing_transport(), shading, torch.ones(2))
        assert torch.isfinite(found).all()
        assert torch.allclose(found[:2], torch.full((2, 3), 2 * level), rtol=0.2)


def test_a_hue_of_the_photo_is_followed_in_part():
    """A photo that is redder than the guess by a factor of four may have red light or a red albedo."""
    shading = torch.tensor([[0.8, 0.2, 0.2], [0.8, 0.2, 0.2]])
    red, green, _ = explain_photo(torch.full((3, 3), 0.7), facing_transport(), shading, torch.ones(2))[0]
    assert 1.2 < red / green < 4


@pytest.mark.parametrize(("weight", "level"), [((1.0, 1.0), 1.909), ((9.0, 1.0), 1.182), ((1.0, 9.0), 2.636)])
def test_pixels_that_disagree_count_as_far_as_they_are_trusted(weight, level):
    """One sees a light of 1 and the other of 3, both in the same texel; the guess is 1 and counts for a tenth."""
    transport = torch.tensor([[0.5, 0.0], [0.5, 0.0]])
    shading = torch.tensor([0.5, 1.5])[:, None].expand(2, 3)
    found = explain_photo(torch.ones(2, 3), transport, shading, torch.tensor(weight))
    assert found[0].tolist() == pytest.approx([level] * 3, rel=1e-2)


def test_light_is_found_where_the_guess_has_none():
    guess = torch.tensor([0.0, 1.0, 1.0])[:, None].expand(3, 3)
    found = explain_photo(guess, facing_transport(), torch.full((2, 3), 0.5), torch.ones(2))
    assert float(found[0].min()) > 0.7
