"""Training steps of tiny networks on a random batch that stays the same."""

import itertools
from dataclasses import replace

import torch

from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.training.loop import Budget, train_stage

SIZE = 16


def some_batch(pairs=1):
    """Random pairs of photos of tilted planes under random lights, with all that is known of them."""
    image = (pairs, 2, 3, SIZE, SIZE)
    albedo = torch.rand(pairs, 3, SIZE, SIZE) * 0.8 + 0.1
    toward_camera = torch.tensor([0, 0, 1.0])[:, None, None]
    normal = torch.nn.functional.normalize(torch.rand(pairs, 3, SIZE, SIZE) + toward_camera, dim=1)
    covered = torch.ones(pairs, 1, SIZE, SIZE)
    covered[..., :3] = 0
    one = (pairs, 2, 1, SIZE, SIZE)
    return {
        "photo_srgb": torch.rand(image),
        "image": torch.rand(image),
        "specular": torch.rand(one) * 0.1,
        "shadow": torch.rand(one) * 0.2,
        "shadow_fraction": torch.rand(one),
        "gloss_fraction": torch.rand(one),
        "relief_shadow": torch.rand(one),
        "light": torch.rand(pairs, 2, 16, 32, 3) * 2,
        "albedo": albedo,
        "normal": normal,
        "relief": torch.rand(pairs, 1, SIZE, SIZE),
        "label": torch.randint(14, (pairs, SIZE, SIZE)),
        "covered": covered,
    }


def budget(steps, **settings):
    return Budget(5e-3, steps=steps, warm_up_steps=1, **settings)


def recorded(stage, totals):
    def losses(bundle, table, batch):
        terms = stage.losses(bundle, table, batch)
        totals.append(float(sum(term.detach().float() for term in terms.values())))
        return terms

    return replace(stage, losses=losses)


def run(stage, batches, plan, path, bundle=None, drawn_by=None):
    bundle = bundle or NetworkBundle(BundleConfig.tiny())

    def batches_from(first):
        return itertools.islice(batches, first, None)

    return train_stage(stage, bundle, batches_from, plan, path, quiet, drawn_by=drawn_by)


def quiet(elapsed, progress):
    pass
