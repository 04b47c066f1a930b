"""The three networks as one file of weights: safetensors, with their configuration in its header."""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass, field
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import nn

from relight_core.errors import InputError
from relight_core.networks.blocks import fold_normalisation
from relight_core.networks.composition import CompositionConfig, CompositionNetwork
from relight_core.networks.delight import DelightConfig, DelightNetwork
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork

FORMAT = "relight-networks-1"


@dataclass(frozen=True)
class BundleConfig:
    """Configurations of the three networks; the defaults are the shipped model's."""

    delight: DelightConfig = field(default_factory=DelightConfig)
    specular_shadow: SpecularShadowConfig = field(default_factory=SpecularShadowConfig)
    composition: CompositionConfig = field(default_factory=CompositionConfig)

    @classmethod
    def tiny(cls) -> BundleConfig:
        """The smallest networks that still have every part: for tests."""
        return cls(DelightConfig(width=4, levels=3), SpecularShadowConfig(width=4, levels=3), CompositionConfig(4, 2))

    @classmethod
    def from_json(cls, text: str) -> BundleConfig:
        """Inverse of `to_json`; raises KeyError or TypeError for anything else."""
        parts = json.loads(text)
        return cls(
            DelightConfig(**parts["delight"]),
            SpecularShadowConfig(**parts["specular_shadow"]),
            CompositionConfig(**parts["composition"]),
        )

    def to_json(self) -> str:
        """One line of JSON."""
        return json.dumps(dataclasses.asdict(self))


class NetworkBundle(nn.Module):
    """De-lighting, SS and composition networks together.

    Attributes:
        card: free text entries saved beside the weights (data, steps, scores).
    """

    def __init__(self, config: BundleConfig | None = None):
        super().__init__()
        self.config = config or BundleConfig()
        self.delight = DelightNetwork(self.config.delight)
        self.specular_shadow = SpecularShadowNetwork(self.config.specular_shadow)
        self.composition = CompositionNetwork(self.config.composition)
        self.card: dict[str, str] = {}

    def for_inference(self) -> NetworkBundle:
        """Evaluation mode, normalisation folded, channels last, no gradients; in place."""
        self.eval().requires_grad_(False)
        fold_normalisation(self)
        return self.to(memory_format=torch.channels_last)


def with_detail_pass(bundle: NetworkBundle, width: int) -> NetworkBundle:
    """The same networks with a sharpening pass in de-lighting, which changes nothing until it is trained.

    The encoder-decoder goes on at the resolution it knows, on photos of twice that.
    """
    if bundle.config.delight.detail_width == width:
        return bundle
    delight = dataclasses.replace(bundle.config.delight, detail_width=width)
    grown = NetworkBundle(dataclasses.replace(bundle.config, delight=delight))
    grown.load_state_dict(bundle.state_dict(), strict=False)
    grown.card = dict(bundle.card)
    return grown


def save_bundle(path: Path, bundle: NetworkBundle, *, half: bool = True) -> None:
    """Write weights whole or not at all; floats as fp16 unless `half` is False.

    Raises:
        ValueError: when a weight is not finite.
    """
    tensors = {}
    for name, value in bundle.state_dict().items():
        if value.is_floating_point():
            if not torch.isfinite(value).all():
                raise ValueError(f"{name} is not finite: not saved")
            # A running variance may exceed what fp16 holds, and underflow would divide by 0.
            keep = not half or name.endswith(("running_var", "running_mean"))
            value = value.float() if keep else value.half()
        tensors[name] = value.contiguous()
    header = {"format": FORMAT, "config": bundle.config.to_json(), **bundle.card}
    beside = path.with_name(path.name + ".partial")
    save_file(tensors, beside, metadata=header)
    os.replace(beside, path)


def load_bundle(path: Path) -> NetworkBundle:
    """Read weights; raises InputError when the file is missing, damaged or of another format."""
    try:
        with safe_open(path, framework="pt") as file:
            header = dict(file.metadata() or {})
            if header.pop("format", None) != FORMAT:
                raise InputError(f"{path}: not a file of relight weights; use one written by 'relight train'")
            bundle = NetworkBundle(BundleConfig.from_json(header.pop("config")))
            bundle.load_state_dict({name: file.get_tensor(name).float() for name in file.keys()}, strict=True)  # noqa: SIM118
    except (OSError, SafetensorError, RuntimeError, KeyError, TypeError, json.JSONDecodeError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: these weights can't be read ({reason}); install them again") from error
    bundle.card = header
    return bundle
