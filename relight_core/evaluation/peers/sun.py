"""Sun et al. 2019, Single image portrait relighting: one U-Net, the light exchanged at its bottleneck.

The encoder's bottleneck tells the photo's light by confidence-weighted averaging; the target light takes its
place beside the bottleneck's features, and the decoder gives the relit image. Trained on the same pairs as
our networks, by their three losses: the relit image, the photo's light, and the image that comes back when
the light found in it is the target.

Departures: the blocks, widths and the invertible encoding of radiance are ours, so that what differs is the
method, not its size; and a photo here has an unknown exposure, so what comes back is the scene under the
photo's light, not the photo.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from safetensors import SafetensorError, safe_open
from torch import nn

from relight_core.errors import InputError
from relight_core.evaluation.contest import Task
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.tensor_colour import srgb_encode
from relight_core.imaging.tensor_images import as_image, as_tensor
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.blocks import Encoder, Head, decoder_levels, level_widths
from relight_core.networks.composition import decode_radiance, encode_radiance
from relight_core.networks.delight import ConfidenceWeightedLight
from relight_core.networks.lfm import BottleneckLight, decode_lit, encode_light
from relight_core.training.loop import Budget, train_stage
from relight_core.training.losses import irradiance_l1, masked_l1, wlog_l2
from relight_core.training.run import Run, denormals_flushed, drawn_by, shared_batches, training_device
from relight_core.training.stages import Stage

LEARNING_RATE = 2e-3
_TRAINED_AT = "size_px"


@dataclass(frozen=True)
class SunConfig:
    """Size, as `networks.delight.DelightConfig` has it."""

    width: int = 16
    levels: int = 6

    def to_json(self) -> str:
        """One line of JSON."""
        return json.dumps({"sun": asdict(self)})


class SunNetwork(nn.Module):
    """The U-Net."""

    def __init__(self, config: SunConfig):
        super().__init__()
        widths = level_widths(config.width, config.levels)
        self.encoder = Encoder(3, widths)
        self.light = ConfidenceWeightedLight(widths[-1])
        self.bottleneck = BottleneckLight(widths[-1])
        self.decoder = decoder_levels(widths)
        self.modulations = nn.ModuleList()
        self.head = Head(widths[0], 3)

    def encode(self, photo_srgb: torch.Tensor) -> tuple[list[torch.Tensor], torch.Tensor]:
        """Features of every level and the light (B, 16, 32, 3) of photos (B, 3, H, W), sRGB-encoded, [0, 1]."""
        features = self.encoder((photo_srgb * 2 - 1).contiguous(memory_format=torch.channels_last))
        return features, self.light(features[-1])

    def decode(self, features: list[torch.Tensor], light: torch.Tensor) -> torch.Tensor:
        """The image (B, 3, H, W), linear, in units of the normalised light (B, 16, 32, 3)."""
        x = decode_lit(self.decoder, features, encode_light(light), self.modulations, self.bottleneck)
        return decode_radiance(torch.relu(self.head(x)))


class SunModel(nn.Module):
    """The network as the training loop wants it: a module with a configuration and a card."""

    def __init__(self, config: SunConfig | None = None):
        super().__init__()
        self.config = config or SunConfig()
        self.network = SunNetwork(self.config)
        self.card: dict[str, str] = {}


def sun_losses(model: SunModel, table: ReflectionTable, batch: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """Their three terms for both photos of every pair, each relit with the other's light."""
    image, covered = batch["image"], batch["covered"].repeat_interleave(2, 0)
    light = batch["light"].flatten(0, 1)
    features, found = model.network.encode(batch["photo_srgb"].flatten(0, 1))
    relit = model.network.decode(features, batch["light"].flip(1).flatten(0, 1))
    same = model.network.decode(features, found)
    return {
        "relit": _image_loss(relit, image.flip(1).flatten(0, 1), covered),
        "same": _image_loss(same, image.flatten(0, 1), covered),
        "light": wlog_l2(found, light),
        "irradiance": irradiance_l1(found, light, table),
    }


def _image_loss(estimate: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor) -> torch.Tensor:
    encoded = masked_l1(encode_radiance(estimate), encode_radiance(truth), covered)
    return encoded + masked_l1(srgb_encode(estimate.clamp(0, 1)), srgb_encode(truth.clamp(0, 1)), covered)


SUN_STAGE = Stage("sun", ("network",), sun_losses, True, False, LEARNING_RATE)


def train_sun(
    run: Run,
    steps: int,
    distinct: int,
    config: SunConfig | None = None,
    report: Callable[[float, str], None] = lambda done, note: None,
) -> SunModel:
    """Train on the batches that `run` shares with others; a run that was stopped goes on where it was.

    Args:
        run: whose heads, lights, batches, seed and checkpoint count.
        distinct: go round in the first so many batches.
    """
    torch.manual_seed(run.seed)
    run.checkpoint.parent.mkdir(parents=True, exist_ok=True)
    budget = Budget(LEARNING_RATE, steps=steps, warm_up_steps=max(min(200, steps // 10), 1))
    model = SunModel(config)
    model.card[_TRAINED_AT] = str(run.size)
    with denormals_flushed():
        return train_stage(
            SUN_STAGE,
            model,
            lambda first: _round_and_round(run, first % distinct, distinct),
            budget,
            run.checkpoint,
            lambda done, state: report(done, f"Sun et al. 2019, step {state.step}"),
            training_device(),
            drawn_by(run) | {"batches": distinct},
        )


def _round_and_round(run: Run, first: int, distinct: int) -> Iterator[dict[str, torch.Tensor]]:
    while True:
        yield from islice(shared_batches(run, first), distinct - first)
        first = 0


def load_sun(path: Path) -> SunModel:
    """Read what `train_sun` wrote; raises InputError for anything else."""
    try:
        with safe_open(path, framework="pt") as file:
            header = file.metadata() or {}
            model = SunModel(SunConfig(**json.loads(header["config"])["sun"]))
            model.card = {_TRAINED_AT: str(int(header[_TRAINED_AT]))} if _TRAINED_AT in header else {}
            model.load_state_dict({name: file.get_tensor(name).float() for name in file.keys()})  # noqa: SIM118
    except (OSError, SafetensorError, KeyError, TypeError, ValueError, RuntimeError) as error:
        reason = f"their header has no {error}" if isinstance(error, KeyError) else error
        raise InputError(f"{path}: not the weights of Sun et al.'s network ({reason}); train it again") from error
    return model.eval()


class Sun:
    """The trained network, as a contender; larger pictures it relights at the size at which it was trained."""

    def __init__(self, model: SunModel):
        self._network = model.network
        self.size_px = int(model.card.get(_TRAINED_AT, 0))

    def in_words(self) -> str:
        """How large the pictures were that a network of another comparison learnt from, in a sentence."""
        known = f"{self.size_px} pixels, and relights larger pictures at that"
        own = known if self.size_px else "a size that its file does not tell"
        return f"Sun et al.'s network is another comparison's, trained at {own}."

    @torch.inference_mode()
    def look(self, photo: np.ndarray) -> tuple[list[torch.Tensor], torch.Tensor]:
        if 0 < self.size_px < photo.shape[0]:
            photo = resize_area(photo, (self.size_px, self.size_px))
        return self._network.encode(srgb_encode(as_tensor(photo).float()))

    @torch.inference_mode()
    def relight(self, seen: tuple[list[torch.Tensor], torch.Tensor], task: Task) -> Mapping[str, np.ndarray]:
        light = torch.from_numpy(np.ascontiguousarray(task.light))[None].float()
        image, size = self._network.decode(seen[0], light), task.reference.shape[:2]
        if image.shape[-2:] != size:
            image = F.interpolate(image, size, mode="bicubic").clamp_min(0)
        return {"composition": as_image(image)}

    def channels(self, seen: tuple[list[torch.Tensor], torch.Tensor]) -> Mapping[str, np.ndarray]:
        return {"guess": seen[1][0].numpy()}
