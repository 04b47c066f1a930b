"""Posteriors from focal probabilities: the inverse of what the loss does."""

import numpy as np
import pytest
import torch

from relight_core.face.posterior import posterior
from relight_core.training.losses import focal_parsing


def said_of(likely):
    """What a network comes to say of pixels that are each class so often: the focal loss's own minimum."""
    logits = torch.zeros(len(likely), dtype=torch.float64, requires_grad=True)
    truth, optimiser = torch.tensor(likely, dtype=torch.float64), torch.optim.LBFGS([logits], max_iter=200)

    def loss():
        optimiser.zero_grad()
        each = [focal_parsing(logits[None, :, None, None], torch.full((1, 1, 1), k)) for k in range(len(likely))]
        total = (truth * torch.stack(each)).sum()
        total.backward()
        return total

    optimiser.step(loss)
    return torch.softmax(logits.detach(), 0).numpy()


@pytest.mark.parametrize("likely", [(0.9, 0.1), (0.6, 0.3, 0.1), (0.25, 0.25, 0.25, 0.25), (0.05, 0.05, 0.8, 0.1)])
def test_what_the_loss_hides_comes_back(likely):
    said = said_of(likely)
    np.testing.assert_allclose(posterior(said[:, None])[:, 0], likely, atol=0.01)
    assert said.max() <= max(likely) + 1e-3


def test_a_sure_network_stays_sure():
    sure = np.eye(14, dtype=np.float32)[:, :, None]
    np.testing.assert_allclose(posterior(sure), sure, atol=1e-4)
    assert np.isfinite(posterior(sure)).all()


def test_order_and_sum_stay():
    said = np.random.default_rng(0).dirichlet(np.full(14, 0.3), 500).T.astype(np.float32)
    likely = posterior(said)
    np.testing.assert_allclose(likely.sum(0), 1, atol=1e-5)
    np.testing.assert_array_equal(likely.argmax(0), said.argmax(0))
    assert likely.min() >= 0
