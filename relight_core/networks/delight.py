"""The de-lighting network (paper, section 4.1): one photo in; albedo, normal, parsing and light out."""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import nn

from relight_core.imaging.tensor_colour import srgb_decode
from relight_core.imaging.tensor_means import with_neighbours
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.lighting.sphere import even_rows
from relight_core.networks.blocks import ConvBlock, Encoder, Head, decoder_levels, level_widths
from relight_core.networks.lfm import LIGHT_SHAPE

_TEXELS = LIGHT_SHAPE[0] * LIGHT_SHAPE[1]

_SHARP = 3 + 3
"""Channels of albedo change and normal, the outputs that want every pixel."""

# Adam moves every weight by the same step, and 2,048 outputs fed by hundreds of features would jitter by
# more than the light tells them; a small gain behind the weights slows these outputs alone.
_OUTPUT_GAIN = 0.3


@dataclass(frozen=True)
class DelightConfig:
    """Size and variant.

    Attributes:
        width: channels at full resolution.
        levels: resolutions of the encoder-decoder.
        classes: parsing classes; 0 leaves parsing out (paper, Table 2, all rows but "Full").
        anchored: albedo = sigmoid(logit(photo) + change) when true; the paper's plain sigmoid when false.
        detail_width: channels of a pass that sharpens albedo and normal at full resolution, while the
            encoder-decoder works at half of it; 0 runs the latter at full resolution, as the paper does.
        relief: height is found too; the paper's network does not.
        decoder_least: channels that no level of the decoder has fewer of. The outputs are more than the encoder's
            channels at full resolution, and what they share there is blurred in all of them.
        residual: residual blocks that the encoder's levels end with, finest level first, which has none; empty for
            none at all. Coarse levels, where a face is understood, are small: what is added there costs little time.
        decoder_residual: the same of the decoder's levels, which are one fewer; the finest may have some.

    Raises:
        ValueError: `residual` or `decoder_residual` has not one number for each level, or the former one for the
            finest.
    """

    width: int = 16
    levels: int = 6
    classes: int = 14
    anchored: bool = True
    detail_width: int = 0
    relief: bool = True
    decoder_least: int = 0
    residual: tuple[int, ...] = ()
    decoder_residual: tuple[int, ...] = ()

    def __post_init__(self):
        # Lists, where they are read from a file.
        object.__setattr__(self, "residual", tuple(self.residual))
        object.__setattr__(self, "decoder_residual", tuple(self.decoder_residual))
        if self.residual and (len(self.residual) != self.levels or self.residual[0]):
            raise ValueError(f"residual blocks {self.residual}: give {self.levels} numbers, of which the first is 0")
        if self.decoder_residual and len(self.decoder_residual) != self.levels - 1:
            raise ValueError(f"residual blocks {self.decoder_residual} of the decoder: give {self.levels - 1} numbers")


@dataclass
class Delit:
    """What de-lighting finds, for B photos of H x W.

    Attributes:
        albedo_srgb: (B, 3, H, W) in [0, 1], sRGB-encoded.
        normal: (B, 3, H, W) unit vectors, camera space, fp32.
        relief: (B, 1, H, W) height toward the camera in units of 64 pixels, about 0 on the face; 0
            everywhere where the network finds none.
        coarse_logits: of the parsing, (B, classes, H / 2, W / 2) from networks with a sharpening pass, else (.., H, W).
        light: (B, 16, 32, 3) radiance >= 0 of mean about 1, fp32.
    """

    albedo_srgb: torch.Tensor
    normal: torch.Tensor
    relief: torch.Tensor
    coarse_logits: torch.Tensor
    light: torch.Tensor

    @property
    def parsing_logits(self) -> torch.Tensor:
        """(B, classes, H, W). Enlarged only here: fourteen planes of full size cost training a twentieth of a step."""
        as_fine = self.coarse_logits.shape[2:] == self.albedo_srgb.shape[2:]
        return self.coarse_logits if as_fine else _doubled(self.coarse_logits)


@dataclass
class DelitSmall:
    """The same at half the size: means over 2 x 2 pixels, each (B, C, H / 2, W / 2).

    Attributes:
        albedo: linear, [0, 1].
        normal: shorter than 1 where those of the four pixels differ.
        relief, parsing_logits, light: as `Delit` has them; relief still counts pixels of the photo.
    """

    albedo: torch.Tensor
    normal: torch.Tensor
    relief: torch.Tensor
    parsing_logits: torch.Tensor
    light: torch.Tensor


class ConfidenceWeightedLight(nn.Module):
    """Every place of the bottleneck proposes a light with a confidence per texel; their weighted mean wins.

    Sun et al. 2019, Single image portrait relighting, section 3.2. Proposals are log(1 + radiance). Rows are
    averaged to texels of even width (see `lighting.sphere.even_rows`): a sliver at a pole weighs next to
    nothing in any loss, and alone it would drift to any brightness.
    """

    def __init__(self, channels: int):
        super().__init__()
        self.hidden = ConvBlock(channels, channels)
        self.propose = nn.Conv2d(channels, _TEXELS * 3, 1)
        self.confide = nn.Conv2d(channels, _TEXELS, 1)
        self.register_buffer("even_rows", torch.from_numpy(even_rows(*LIGHT_SHAPE[:2])), persistent=False)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        features = self.hidden(features)
        proposal = _OUTPUT_GAIN * self.propose(features).float().flatten(2).unflatten(1, (_TEXELS, 3))
        weight = torch.softmax(_OUTPUT_GAIN * self.confide(features).float().flatten(2), dim=-1)
        mean = (proposal * weight[:, :, None]).sum(-1).unflatten(1, LIGHT_SHAPE[:2])
        log_light = F.softplus((self.even_rows[..., None] * mean[:, :, None]).sum(3))
        return torch.expm1(log_light.clamp_max(9.0))


class DetailPass(nn.Module):
    """What the photo's full resolution adds to albedo and normal that were found at half of it.

    A face is understood from afar; where a lid or a cast shadow ends is seen from near. The four pixels
    under each coarse one are worked on as channels, since full-size feature maps would cost more than
    the whole encoder-decoder.
    """

    def __init__(self, coarse: int, width: int, outputs: int):
        super().__init__()
        self.blend = ConvBlock(coarse + 4 * 3, width)
        # Not a `Head`: rounding a correction rounds what it is added to by far less.
        self.head = nn.Conv2d(width, 4 * outputs, 3, padding=1)
        nn.init.zeros_(self.head.weight)
        nn.init.zeros_(self.head.bias)

    def forward(self, fours: torch.Tensor, features: torch.Tensor) -> torch.Tensor:
        """Corrections (B, outputs * 4, H / 2, W / 2), by output and pixel of the four.

        Args:
            fours: (B, 3 * 4, H / 2, W / 2) photo, by colour and pixel of the four (`F.pixel_unshuffle`).
            features: (B, coarse, H / 2, W / 2).
        """
        return self.head(self.blend(torch.cat([features, fours.to(features.dtype)], 1))).float()


class DelightNetwork(nn.Module):
    """Encoder-decoder with skip connections; the light is read at the bottleneck."""

    def __init__(self, config: DelightConfig | None = None):
        super().__init__()
        self.config = config or DelightConfig()
        widths = level_widths(self.config.width, self.config.levels)
        self.encoder = Encoder(3, widths, self.config.residual)
        self.light = ConfidenceWeightedLight(widths[-1])
        self.decoder = decoder_levels(widths, self.config.decoder_least, self.config.decoder_residual)
        finest = max(widths[0], self.config.decoder_least)
        self.head = Head(finest, _SHARP + self.config.relief + self.config.classes)
        self.detail = None
        if self.config.detail_width:
            self.detail = DetailPass(finest, self.config.detail_width, _SHARP)

    def forward(self, photo_srgb: torch.Tensor) -> Delit:
        """Take a photo apart.

        Args:
            photo_srgb: (B, 3, H, W) in [0, 1], sRGB-encoded; H and W multiples of
                2 ** levels, or of half that without a detail pass.
        """
        photo = photo_srgb * 2 - 1
        light, x = self._encode(photo if self.detail is None else F.avg_pool2d(photo, 2))
        sharp, relief, parsing = self._read(x)
        if self.detail is not None:
            sharp = _doubled(sharp) + F.pixel_shuffle(self.detail(F.pixel_unshuffle(photo, 2), x), 2)
            relief = 2 * _doubled(relief)  # relief counts pixels
        change, normal = sharp.split(3, 1)
        return Delit(self._albedo(photo_srgb, change), _unit(normal), relief, parsing, light)

    def forward_small(self, photo_srgb: torch.Tensor) -> DelitSmall:
        """What `forward` finds, at half the size and in less time; for networks with a sharpening pass.

        The four pixels under each coarse one stay channels all the way, and what is smooth is never enlarged.
        The logits are averaged instead of the probabilities, which differ by less than bf16's rounding.
        """
        fours = F.pixel_unshuffle(photo_srgb.contiguous(), 2).unflatten(1, (3, 4))
        light, x = self._encode((fours.mean(2) * 2 - 1).contiguous(memory_format=torch.channels_last))
        sharp, relief, parsing = self._read(x)
        photo = (fours * 2 - 1).flatten(1, 2).contiguous(memory_format=torch.channels_last)
        sharp = _doubled_as_fours(sharp) + self.detail(photo, x).contiguous().unflatten(1, (_SHARP, 4))
        change, normal = sharp.split(3, 1)
        albedo = srgb_decode(self._albedo(fours, change)).mean(2)
        # What is left of them where `forward` doubles them and the four pixels are averaged.
        smooth = with_neighbours(torch.cat([2 * relief, parsing], 1), 1 / 8)
        relief, parsing = smooth.split([1, smooth.shape[1] - 1], 1)
        return DelitSmall(albedo, _unit(normal).mean(2), relief, parsing, light)

    def _encode(self, photo: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """The light, and the decoder's last features, of a photo in [-1, 1] at the encoder's size."""
        features = self.encoder(photo)
        light = self.light(features[-1])
        x = features[-1]
        for level, skip in zip(self.decoder, features[-2::-1], strict=True):
            x = level(x, skip)
        return light, x

    def _read(self, x: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """What is sharp, relief and parsing logits; the last as exact as the features, which is enough for them."""
        all_exact = self.training or not self.config.classes
        found = self.head(x, None if all_exact else _SHARP + self.config.relief)
        sharp, relief, parsing = found.split([_SHARP, int(self.config.relief), self.config.classes], 1)
        return sharp, relief if self.config.relief else torch.zeros_like(sharp[:, :1]), parsing

    def _albedo(self, photo_srgb: torch.Tensor, change: torch.Tensor) -> torch.Tensor:
        if not self.config.anchored:
            return torch.sigmoid(change)
        return torch.sigmoid(torch.logit(photo_srgb.float().clamp(0.02, 0.98)) + change)


def _doubled(image: torch.Tensor) -> torch.Tensor:
    return F.interpolate(image, scale_factor=2, mode="bilinear", align_corners=False)


def _doubled_as_fours(image: torch.Tensor) -> torch.Tensor:
    """`_doubled` (B, C, H, W) as (B, C, 4, H, W), by pixel of the four: above left, above right, below left, ..."""
    padded = F.pad(image, (1, 1, 1, 1), mode="replicate").contiguous()
    rows = [0.75 * padded[..., 1:-1, :] + 0.25 * beside for beside in (padded[..., :-2, :], padded[..., 2:, :])]
    fours = [0.75 * row[..., 1:-1] + 0.25 * beside for row in rows for beside in (row[..., :-2], row[..., 2:])]
    return torch.stack(fours, 2)


def _unit(normal: torch.Tensor) -> torch.Tensor:
    """The paper's sigmoid output (section 4.1), decoded to [-1, 1] and brought to unit length."""
    return unit_normals(torch.sigmoid(normal) * 2 - 1)
