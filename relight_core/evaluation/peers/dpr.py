"""Zhou et al. 2019, Deep single-image portrait relighting (DPR), from a checkpoint that the user supplies.

Their hourglass network takes the photo's lightness and the target light as nine spherical harmonics, white
and of second order; colours stay the photo's. The architecture is stated anew here so that their published
weights (trained_model_03.t7 for 512 pixels) fit; the weights are not part of this project.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

from relight_core.errors import InputError
from relight_core.evaluation.contest import Contender, Task
from relight_core.imaging.colour import REC709_LUMINANCE, srgb_decode, srgb_encode
from relight_core.lighting.sphere import directions, solid_angles

_SIZE = 512
_LIGHT_CHANNELS, _COEFFICIENTS, _HIDDEN = 27, 9, 128
_WIDTHS = (16, 16, 32, 64, 8 * 16 + _LIGHT_CHANNELS)
_LEVEL = 0.76
"""Their example lights' first coefficient, times the 0.7 by which their demonstration scales them."""

_RENAMED = {
    "pre_conv": "stem",
    "pre_bn": "stem_norm",
    "HG3": "hourglass",
    **{f"conv_{n}": f"convolutions.{n - 1}" for n in (1, 2, 3)},
    **{f"bn_{n}": f"norms.{n - 1}" for n in (1, 2, 3)},
    "output": "output",
}
"""Our names of their parts; what else their file holds are second names of the hourglass's insides."""


class _Residual(nn.Module):
    """Two normalised convolutions beside a shortcut."""

    def __init__(self, inputs: int, outputs: int, norm: type[nn.Module]):
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, padding=1, bias=False)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, padding=1, bias=False)
        self.bn1, self.bn2 = norm(outputs), norm(outputs)
        self.shortcuts = nn.Conv2d(inputs, outputs, 1, bias=False)
        self._projects = inputs != outputs

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        y = self.bn2(self.conv2(torch.relu(self.bn1(self.conv1(x)))))
        return torch.relu(y + (self.shortcuts(x) if self._projects else x))


class _LightExchange(nn.Module):
    """The innermost layer: its first channels tell the photo's light and are replaced by the target's."""

    def __init__(self):
        super().__init__()

        def dense(inputs: int, outputs: int) -> nn.Conv2d:
            return nn.Conv2d(inputs, outputs, 1, bias=False)

        self.predict_FC1, self.predict_relu1 = dense(_LIGHT_CHANNELS, _HIDDEN), nn.PReLU()
        self.predict_FC2 = dense(_HIDDEN, _COEFFICIENTS)
        self.post_FC1, self.post_relu1 = dense(_COEFFICIENTS, _HIDDEN), nn.PReLU()
        self.post_FC2 = dense(_HIDDEN, _LIGHT_CHANNELS)

    def forward(self, x: torch.Tensor, light: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        mean = x[:, :_LIGHT_CHANNELS].mean((2, 3), keepdim=True)
        found = self.predict_FC2(self.predict_relu1(self.predict_FC1(mean)))
        told = torch.relu(self.post_FC2(self.post_relu1(self.post_FC1(light))))
        told = told.expand(-1, -1, *x.shape[-2:])
        return torch.cat([told, x[:, _LIGHT_CHANNELS:]], 1), found


class _Hourglass(nn.Module):
    """One resolution: a branch that stays at it and one that goes through the next coarser."""

    def __init__(self, width: int, inner: int, middle: nn.Module):
        super().__init__()
        self.upper = _Residual(width, width, nn.InstanceNorm2d)
        self.low1 = _Residual(width, inner, nn.BatchNorm2d)
        self.middle = middle
        self.low2 = _Residual(inner, width, nn.InstanceNorm2d)

    def forward(self, x: torch.Tensor, light: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        below, found = self.middle(self.low1(F.max_pool2d(x, 2)), light)
        return self.upper(x) + F.interpolate(self.low2(below), scale_factor=2, mode="nearest"), found


class DprNetwork(nn.Module):
    """Lightness (B, 1, H, W) in [0, 1] and light (B, 9, 1, 1) in; relit lightness and the photo's light out."""

    def __init__(self):
        super().__init__()
        middle: nn.Module = _LightExchange()
        for width, inner in reversed(list(zip(_WIDTHS, _WIDTHS[1:], strict=False))):
            middle = _Hourglass(width, inner, middle)
        width = _WIDTHS[0]
        self.stem, self.stem_norm = nn.Conv2d(1, width, 5, padding=2), nn.BatchNorm2d(width)
        self.hourglass = middle
        self.convolutions = nn.ModuleList(nn.Conv2d(width, width, n, padding=n // 2) for n in (3, 1, 1))
        self.norms = nn.ModuleList(nn.BatchNorm2d(width) for _ in range(3))
        self.output = nn.Conv2d(width, 1, 1)

    def forward(self, lightness: torch.Tensor, light: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        x, found = self.hourglass(torch.relu(self.stem_norm(self.stem(lightness))), light)
        for convolution, norm in zip(self.convolutions, self.norms, strict=True):
            x = torch.relu(norm(convolution(x)))
        return torch.sigmoid(self.output(x)), found


def load_dpr(path: Path) -> DprNetwork:
    """Read their checkpoint, tensors only.

    Raises:
        InputError: the file is missing, or not such a checkpoint.
    """
    if not path.is_file():
        raise InputError(
            f"{path}: no such file; DPR's weights are not shipped: get trained_model_03.t7 from its authors' "
            "repository (zhhoper/DPR on GitHub), or leave --dpr out"
        )
    try:
        theirs = torch.load(path, map_location="cpu", weights_only=True)
        network = DprNetwork()
        network.load_state_dict(_in_our_names(theirs))
    except (OSError, RuntimeError, pickle.UnpicklingError, AttributeError, TypeError, KeyError, EOFError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: not DPR's weights for 512 pixels ({reason})") from error
    return network.eval()


def _in_our_names(theirs: Mapping[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    renamed = {}
    for name, value in theirs.items():
        part, _, rest = name.removeprefix("module.").partition(".")
        if part in _RENAMED:
            renamed[f"{_RENAMED[part]}.{rest}"] = value
    return renamed


def harmonics(light: np.ndarray) -> np.ndarray:
    """Nine coefficients of a light (H, 2H, 3) as they order and scale them: grey, 1, y, z, x, yx, yz, 3z2 - 1, ...

    Their axes are x to the right, y away from the camera, z up.
    """
    toward = directions(*light.shape[:2]).astype(np.float64)
    x, y, z = toward[..., 0], -toward[..., 2], toward[..., 1]
    basis = np.stack(
        [
            np.full_like(x, 0.5 / np.sqrt(np.pi)),
            *(np.sqrt(3 / np.pi) / 2 * axis for axis in (y, z, x)),
            *(np.sqrt(15 / np.pi) / 2 * product for product in (y * x, y * z)),
            np.sqrt(5 / np.pi) / 4 * (3 * z**2 - 1),
            np.sqrt(15 / np.pi) / 2 * x * z,
            np.sqrt(15 / np.pi) / 4 * (x**2 - y**2),
        ]
    )
    weighted = (light @ REC709_LUMINANCE) * solid_angles(*light.shape[:2])
    coefficients = (basis * weighted).sum((1, 2))
    return (coefficients * (_LEVEL / max(coefficients[0], 1e-6))).astype(np.float32)


class Dpr(Contender):
    """Their network, as a contender."""

    def __init__(self, network: DprNetwork, size: int = _SIZE):
        """Take a network and the side in pixels at which it sees a portrait, a multiple of 16."""
        self._network, self._size = network, size

    def look(self, photo: np.ndarray) -> np.ndarray:
        return cv2.cvtColor(srgb_encode(photo).astype(np.float32), cv2.COLOR_RGB2Lab)

    @torch.inference_mode()
    def relight(self, seen: np.ndarray, task: Task) -> Mapping[str, np.ndarray]:
        large = cv2.resize(seen[..., 0] / 100, (self._size, self._size), interpolation=cv2.INTER_LINEAR)
        light = torch.from_numpy(harmonics(task.light)).reshape(1, -1, 1, 1)
        made = self._network(torch.from_numpy(large)[None, None], light)[0][0, 0].numpy()
        lab = seen.copy()
        lab[..., 0] = 100 * cv2.resize(made, seen.shape[1::-1], interpolation=cv2.INTER_AREA)
        shown = np.clip(cv2.cvtColor(lab, cv2.COLOR_Lab2RGB), 0, 1)
        return {"composition": srgb_decode(shown) / np.float32(task.gain)}
