"""The smallest networks: a file of weights with a person in them, and a bundle with a person network."""

import torch

from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle, with_person_network
from relight_core.networks.person import PersonConfig, PersonNetwork


def write_tiny_weights(folder):
    torch.manual_seed(3)
    path = folder / "tiny.safetensors"
    bundle = NetworkBundle(BundleConfig.tiny())
    bundle.composition.head.weight.data.normal_(0, 0.02)
    # Untrained logits would leave the person transparent; this bias makes everything skin.
    bundle.delight.head.bias.data[8] = 6.0
    save_bundle(path, bundle)
    return path


def tiny_bundle_with_person():
    torch.manual_seed(0)
    return with_person_network(NetworkBundle(BundleConfig.tiny()), PersonNetwork(PersonConfig(4, 3, 8)))
