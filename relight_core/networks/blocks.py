"""Building blocks shared by the encoder-decoders."""

from __future__ import annotations

from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import nn

_LEAK = 0.1
"""Slope of every leaky ReLU below 0."""


class ConvBlock(nn.Module):
    """3 x 3 convolution, batch normalisation and, unless it is not `rectified`, leaky ReLU.

    Folded into one convolution for inference.
    """

    def __init__(self, inputs: int, outputs: int, stride: int = 1, *, rectified: bool = True):
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False, padding_mode="zeros")
        self.norm: nn.Module = nn.BatchNorm2d(outputs, momentum=0.05)
        self.rectified = rectified

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        x = self.norm(self.conv(x))
        return F.leaky_relu(x, _LEAK, inplace=True) if self.rectified else x

    def fold(self) -> None:
        """Merge the normalisation into the convolution's weights (evaluation mode only)."""
        if isinstance(self.norm, nn.BatchNorm2d):
            self.conv = nn.utils.fusion.fuse_conv_bn_eval(self.conv, self.norm)
            self.norm = nn.Identity()


class ResidualBlock(nn.Module):
    """Two convolutions whose result is added to what they read (He et al. 2016); nothing, until they are taught."""

    def __init__(self, width: int):
        super().__init__()
        self.first = ConvBlock(width, width)
        self.second = ConvBlock(width, width, rectified=False)
        nn.init.zeros_(self.second.norm.weight)

    @property
    def is_untaught(self) -> bool:
        """Whether it is as it was made, and so adds nothing."""
        return not self.second.norm.weight.any()

    def begin_settled(self) -> None:
        """Get an untaught block ready for a stage that normalises by running statistics; it still adds nothing.

        Those statistics know nothing of new convolutions and leave their results at the size they come in: so the
        first has weights of the usual size (He et al. 2015). And the second is nothing itself, instead of what
        scales it: convolutions are what the optimiser moves fast.
        """
        nn.init.kaiming_normal_(self.first.conv.weight, _LEAK)
        nn.init.zeros_(self.second.conv.weight)
        nn.init.ones_(self.second.norm.weight)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return x + self.second(self.first(x))


class Encoder(nn.Module):
    """Levels of halving resolution, from one convolution at full resolution, where time is spent fastest.

    Args:
        widths: of the levels, finest first.
        residual: how many residual blocks each level ends with, finest first; the finest never has any. Empty for none.
    """

    def __init__(self, inputs: int, widths: list[int], residual: Sequence[int] = ()):
        super().__init__()
        self.stem = ConvBlock(inputs, widths[0])
        counts = list(residual) or [0] * len(widths)
        self.levels = nn.ModuleList(
            nn.Sequential(
                ConvBlock(above, below, stride=2),
                ConvBlock(below, below),
                *(ResidualBlock(below) for _ in range(count)),
            )
            for above, below, count in zip(widths, widths[1:], counts[1:], strict=False)
        )

    def begin(self, first: torch.Tensor) -> torch.Tensor:
        """What the first of the input channels add to the first convolution, before its activation.

        A convolution is a sum over its input channels: where only the last of them change, as the light's do, this part
        is computed once and given to `forward` as `begun`.

        Args:
            first: (B, c, H, W), c less than all inputs.

        Returns:
            (B, widths[0], H, W), with the folded bias in it.

        Raises:
            ValueError: the normalisation is not folded (see `fold_normalisation`).
        """
        if not isinstance(self.stem.norm, nn.Identity):
            raise ValueError("fold the normalisation first: it follows all channels together")
        conv = self.stem.conv
        weight = conv.weight[:, : first.shape[1]].contiguous(memory_format=torch.channels_last)
        return F.conv2d(first.to(weight.dtype), weight, conv.bias, padding=1)

    def forward(self, x: torch.Tensor, begun: torch.Tensor | None = None) -> list[torch.Tensor]:
        """Features of every level, finest first, in the weights' precision.

        Args:
            x: (B, inputs, H, W), or only the last of those channels with `begun`.
            begun: `begin` of the other channels.
        """
        features = [self._stem(x.to(self.stem.conv.weight.dtype), begun)]
        for level in self.levels:
            features.append(level(features[-1]))
        return features

    def _stem(self, x: torch.Tensor, begun: torch.Tensor | None) -> torch.Tensor:
        if begun is None:
            return self.stem(x)
        weight = self.stem.conv.weight[:, -x.shape[1] :].contiguous(memory_format=torch.channels_last)
        return F.leaky_relu(F.conv2d(x, weight, padding=1) + begun, _LEAK, inplace=True)


class UpLevel(nn.Module):
    """Upsample, join the encoder's features (the skip connection of Ronneberger et al. 2015), convolve."""

    def __init__(self, below: int, skip: int, outputs: int, *, refined: bool = True, residual: int = 0):
        super().__init__()
        self.reduce = nn.Conv2d(below, outputs, 1)
        self.blend = ConvBlock(outputs + skip, outputs)
        self.refine = ConvBlock(outputs, outputs) if refined else nn.Identity()
        self.residual = nn.Sequential(*(ResidualBlock(outputs) for _ in range(residual)))

    def join(self, x: torch.Tensor, skip: torch.Tensor) -> torch.Tensor:
        """The upsampled features beside the skip, convolved: what a modulation acts on."""
        x = F.interpolate(self.reduce(x), size=skip.shape[-2:], mode="bilinear", align_corners=False)
        return self.blend(torch.cat([x, skip], 1))

    def forward(self, x: torch.Tensor, skip: torch.Tensor) -> torch.Tensor:
        return self.residual(self.refine(self.join(x, skip)))


class Head(nn.Conv2d):
    """The last convolution, always in fp32: bf16 has 8 bits, which would band normals and smooth skin."""

    def __init__(self, inputs: int, outputs: int):
        super().__init__(inputs, outputs, 3, padding=1)

    def forward(self, x: torch.Tensor, exact: int | None = None) -> torch.Tensor:
        """All outputs in fp32, or only the first so many of them, and the others in the features' own precision."""
        with torch.autocast(x.device.type, enabled=False):
            if exact is None or x.dtype == torch.float32:
                return super().forward(x.float())
            first = F.conv2d(x.float(), self.weight[:exact], self.bias[:exact], padding=1)
            weight = self.weight[exact:].to(x.dtype)
            return torch.cat([first, F.conv2d(x, weight, self.bias[exact:].to(x.dtype), padding=1).float()], 1)


def decoder_levels(widths: list[int], least: int = 0, residual: Sequence[int] = ()) -> nn.ModuleList:
    """Levels back up, coarsest first.

    Args:
        widths: of the encoder's levels, finest first; the decoder's are as wide.
        least: channels that no level has fewer of. Where it is 0 the finest level has one convolution only.
        residual: how many residual blocks each level ends with, finest first. Empty for none.
    """
    outputs = [max(width, least) for width in widths[:-1]]
    below = [*outputs[1:], widths[-1]]
    counts = list(residual) or [0] * len(outputs)
    return nn.ModuleList(
        UpLevel(below[at], widths[at], outputs[at], refined=at > 0 or least > 0, residual=counts[at])
        for at in reversed(range(len(outputs)))
    )


def level_widths(width: int, levels: int, widest: int = 256) -> list[int]:
    """Channels per level: doubling from `width`, capped."""
    return [min(width * 2**level, widest) for level in range(levels)]


def round_convolutions(network: nn.Module) -> nn.Module:
    """Every convolution but the heads in bf16, in place: what autocast does, without doing it at every run."""
    for module in network.modules():
        if isinstance(module, nn.Conv2d) and not isinstance(module, Head):
            module.to(torch.bfloat16)
    return network


def fold_normalisation(network: nn.Module) -> nn.Module:
    """Fold every batch normalisation of a network in evaluation mode, in place."""
    for module in network.modules():
        if isinstance(module, ConvBlock):
            module.fold()
    return network
