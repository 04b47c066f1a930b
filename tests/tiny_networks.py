"""The smallest networks with a person in them, as a file of weights."""

import torch

from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle


def write_tiny_weights(folder):
    torch.manual_seed(3)
    path = folder / "tiny.safetensors"
    bundle = NetworkBundle(BundleConfig.tiny())
    bundle.composition.head.weight.data.normal_(0, 0.02)
    # Untrained logits would leave the person transparent; this bias makes everything skin.
    bundle.delight.head.bias.data[8] = 6.0
    save_bundle(path, bundle)
    return path
