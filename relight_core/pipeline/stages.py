"""The stages on tensors: pure functions from a photo's view and a light to a relit view."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch
import torch.nn.functional as F

from relight_core.face.eyeballs import eye_sockets, with_eyeballs
from relight_core.face.parsing import MIRRORED
from relight_core.face.silhouette import solid_person
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.tensor_colour import grey, srgb_decode, srgb_encode
from relight_core.imaging.tensor_images import as_tensor, enlarge, resized
from relight_core.imaging.tensor_means import with_neighbours
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.lighting.bounce import Bounce, gather_bounce
from relight_core.lighting.reflection import NormalLookup, ReflectionTable
from relight_core.lighting.relief import ReliefTransport, march_reliefs
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.delight import DelightNetwork, DelitSmall
from relight_core.networks.pair import BothNetworks
from relight_core.networks.precision import has_bf16
from relight_core.networks.specular_shadow import Occlusion
from relight_core.pipeline.per_light.bare_skin import bare_skin
from relight_core.pipeline.per_light.hints import (
    Effects,
    doubtful_shadow,
    effects_of,
    estimated_effects,
    explicit_sum,
    gloss_share,
    light_hints,
    smooth_gloss,
    surface_hints,
)
from relight_core.pipeline.per_light.shadow_colour import shadow_colour_odds
from relight_core.pipeline.per_photo.blown import clipped_share, mend_blown
from relight_core.pipeline.per_photo.brims import with_whole_brims
from relight_core.pipeline.per_photo.dull_black import gloss_of_black
from relight_core.pipeline.per_photo.frames import without_frames
from relight_core.pipeline.per_photo.white_collar import with_white_collar
from relight_core.pipeline.quality import Tier

_RELIEF_UNIT_PX = 64.0
_HEIGHT_GAIN = 1.1
"""Estimates shrink toward the mean: against the truth of held-out heads, found faces stand out by 0.88 of what they
should (correlation 0.96). Of 1.0, 1.1 and 1.2 this brings faces and single lamps of sixteen validation heads nearest
to the truth, and shadows as near as any."""
_LENS = 1 / 8
"""Share of a pixel's light that de-lighting sees in each of its neighbours along an axis. All that it learnt from had
gone through a lens (`dataset.camera`); photos that were shrunk are sharper, and their albedo came out worse."""


@dataclass(frozen=True)
class Surface:
    """What de-lighting finds; nothing here depends on the target light. All (1, C, S, S), fp32.

    Attributes:
        photo: the view as the camera recorded it, linear, clipped to [0, 1].
        albedo: linear, [0, 1].
        normal: unit vectors, camera space.
        relief: height toward the camera, in half-widths of the view.
        parsing: probabilities of the parsing classes.
        person: (1, 1, S, S) probability that a pixel is person: the parsing's, made solid.
        source_light: (1, 16, 32, 3) the light the photo was taken under, of a mean luminance over the sphere that is
            about 1.
        foreign_shadow: (1, 3, D, D) logs of what shadows from outside leave of the light, see
            `per_photo.foreign_shadow`; `photo` and all else are as without them. None where there are none.
    """

    photo: torch.Tensor
    albedo: torch.Tensor
    normal: torch.Tensor
    relief: torch.Tensor
    parsing: torch.Tensor
    person: torch.Tensor
    source_light: torch.Tensor
    foreign_shadow: torch.Tensor | None = None

    @cached_property
    def bare_skin(self) -> torch.Tensor:
        """(1, 1, S, S), see `per_light.bare_skin`."""
        return bare_skin(self.parsing)

    @cached_property
    def eye_sockets(self) -> torch.Tensor:
        """(S, S), see `face.eyeballs`."""
        return torch.from_numpy(eye_sockets(self.parsing[0].cpu().numpy())).to(self.parsing.device)


def in_precision(bundle: NetworkBundle, device: str, wish: str = "bf16") -> NetworkBundle:
    """The networks in bf16 where it is wished for and the hardware multiplies it natively, else in fp32.

    Networks that are still being trained stay as they are; training has its own autocast.
    """
    if wish == "fp32" or not has_bf16(device) or not bundle.is_for_inference:
        return bundle
    return bundle.rounded()


def pair_of(bundle: NetworkBundle, tier: Tier, device: str) -> BothNetworks:
    """The SS and composition networks that a tier runs, at its precision."""
    return in_precision(bundle, device, tier.precision).pair(tier.pair)


@torch.inference_mode()
def delight(
    bundle: NetworkBundle,
    photo: np.ndarray,
    size: int,
    device: str = "cpu",
    *,
    mirrored: bool = False,
    precision: str = "bf16",
) -> Surface:
    """Take a view of a photo apart.

    Args:
        photo: (D, D, 3) linear, as the network sees it; clipped to [0, 1] as the camera's own file would be.
        size: side S of the surface, at most D.
        mirrored: also de-light the mirrored view and average both.
    """
    photo = np.clip(np.asarray(photo, np.float32), 0, 1)
    seen, small = as_tensor(photo, device), as_tensor(resize_area(photo, (size, size)), device)
    return delight_views(bundle, seen, small, mirrored=mirrored, precision=precision)[0]


@torch.inference_mode()
def delight_views(
    bundle: NetworkBundle, linear: torch.Tensor, small: torch.Tensor, *, mirrored: bool = False, precision: str = "bf16"
) -> list[Surface]:
    """`delight` of B views at once.

    Args:
        linear: (B, 3, D, D) in [0, 1], as the network sees them.
        small: the same views at the surfaces' size, (B, 3, S, S).
    """
    size = small.shape[-1]
    seen = srgb_encode(with_neighbours(linear, _LENS))
    views = torch.cat([seen, seen.flip(-1)]) if mirrored else seen
    network = in_precision(bundle, linear.device.type, precision).delight
    found = _found_in(network, views, size)
    parsing = torch.softmax(found.parsing_logits.float(), 1)
    parts = [found.albedo.float(), found.normal.float(), found.relief.float(), parsing, found.light.float()]
    if mirrored:
        parts = _mean_of_both(*parts)
    *images, light = parts
    # Averaged with what is beside them, clipped pixels would no longer look clipped.
    clipped = resized(clipped_share(linear), size)
    albedo, normal, relief, parsing = (resized(image, size) for image in images)
    normal, height = _without_rim(normal), height_of(_without_rim(relief), linear.shape[-1])
    whole = (small, clipped, albedo, normal, height, parsing, light)
    return [_mended(*parts) for parts in zip(*(part.split(1) for part in whole), strict=True)]


def _mended(photo, clipped, albedo, normal, relief, parsing, light) -> Surface:
    """A surface as it was found in a photo, with what networks know least about put right."""
    albedo, parsing = with_white_collar(photo, albedo, parsing)
    albedo = mend_blown(clipped, albedo, parsing)
    balls = with_eyeballs(unit_normals(normal)[0].cpu().numpy(), parsing[0].cpu().numpy())
    normal = torch.from_numpy(balls)[None].to(photo.device)
    relief = with_whole_brims(relief, parsing)
    return Surface(photo, albedo, normal, relief, parsing, _solid(parsing), light)


def reparsed(surface: Surface, parsing: torch.Tensor) -> Surface:
    """The same surface with another parsing, (1, classes, S, S) probabilities."""
    return replace(surface, parsing=parsing, person=_solid(parsing))


def without_colour(surface: Surface) -> Surface:
    """The surface of a black-and-white photo, with albedo and light of no colour: the networks guess some."""
    light = grey(surface.source_light.movedim(-1, 1)).movedim(1, -1).expand_as(surface.source_light)
    shadow = surface.foreign_shadow
    shadow = None if shadow is None else shadow.mean(1, keepdim=True).expand_as(shadow)
    return replace(
        surface, albedo=grey(surface.albedo).expand_as(surface.albedo), source_light=light, foreign_shadow=shadow
    )


def _solid(parsing: torch.Tensor) -> torch.Tensor:
    return torch.from_numpy(solid_person(parsing[0].cpu().numpy()))[None, None].to(parsing.device)


def _found_in(network: DelightNetwork, views_srgb: torch.Tensor, size: int) -> DelitSmall:
    """What the network finds, at half the views' size where that is what is wanted, else at the views' own."""
    if network.detail is not None and views_srgb.shape[-1] == 2 * size:
        return network.forward_small(views_srgb)
    found = network(views_srgb.contiguous(memory_format=torch.channels_last))
    albedo = srgb_decode(found.albedo_srgb.float())
    return DelitSmall(albedo, found.normal, found.relief, found.parsing_logits, found.light)


def height_of(relief: torch.Tensor, side_px: int) -> torch.Tensor:
    """Height toward the camera, in half-widths of the view, as in `Surface`.

    Args:
        relief: (B, 1, H, W) as `networks.delight.Delit` has it, of a photo of `side_px` pixels.
    """
    return relief * (2 * _RELIEF_UNIT_PX * _HEIGHT_GAIN / side_px)


def _without_rim(image: torch.Tensor) -> torch.Tensor:
    """The outermost pixels as those beside them: convolutions take the nothing around a view for an edge."""
    return F.pad(image[..., 1:-1, 1:-1], (1, 1, 1, 1), mode="replicate")


def _mean_of_both(albedo, normal, relief, parsing, light) -> list[torch.Tensor]:
    """What was found in views (the first half) and in their mirror images (the second), averaged."""
    sideways = torch.tensor([-1.0, 1.0, 1.0], device=normal.device)[None, :, None, None]
    one, other = normal.chunk(2)
    normal = unit_normals(one + other.flip(-1) * sideways)
    one, other = parsing.chunk(2)
    parsing = (one + other[:, MIRRORED].flip(-1)) / 2
    albedo, relief = ((one + other.flip(-1)) / 2 for one, other in (albedo.chunk(2), relief.chunk(2)))
    one, other = light.chunk(2)
    return [albedo, normal, relief, parsing, (one + other.flip(2)) / 2]


@torch.inference_mode()
def march(surface: Surface, size: int) -> ReliefTransport:
    """March the surface's relief once toward every texel of the light (see `lighting.relief`)."""
    relief = without_frames(surface.relief, surface.parsing)
    return march_views(surface.normal.cpu(), relief.cpu(), surface.person.cpu(), size)[0]


def march_views(normal: torch.Tensor, relief: torch.Tensor, person: torch.Tensor, size: int) -> list[ReliefTransport]:
    """`march` of B surfaces, with their frames, that are known by these parts alone, (B, C, S, S) as in `Surface`.

    It is done where they lie, and that is where the transports are.
    """
    normal, relief, person = (F.interpolate(part, size=size, mode="area") for part in (normal, relief, person))
    return march_reliefs(relief[:, 0], unit_normals(normal), person[:, 0])


@dataclass(frozen=True, eq=False)
class Reflector:
    """What a surface reflects where nothing is hidden from it, made ready for many lights.

    The gloss of hair and cloth is turned down by the parsing's probabilities, and that of what is too dark for skin.

    Attributes:
        light_of: irradiance and gloss at every pixel's normal.
        shares: (1, 6, S, S) of both that the surface gives back: 1 of irradiance, less of gloss.
        sockets: the light that comes back to the eyes from around them.
    """

    light_of: NormalLookup
    shares: torch.Tensor
    sockets: Bounce


@torch.inference_mode()
def reflector(table: ReflectionTable, surface: Surface, *, black_is_dull: bool = True) -> Reflector:
    """Make a surface's normals and parts ready.

    Args:
        black_is_dull: what is darker than any skin has next to no gloss, see `per_photo.dull_black`; False is as heads
            are rendered.
    """
    shares = torch.ones_like(surface.normal).repeat(1, 2, 1, 1)
    shares[:, 3:] *= gloss_share(surface.parsing)
    if black_is_dull:
        shares[:, 3:] *= gloss_of_black(surface.albedo, surface.parsing)
    sockets = gather_bounce(surface.normal, surface.relief, surface.albedo, surface.person, surface.eye_sockets)
    return Reflector(NormalLookup(table, surface.normal), shares, sockets)


@torch.inference_mode()
def reflect(surface: Reflector, light: torch.Tensor) -> torch.Tensor:
    """Irradiance over pi and gloss where nothing is hidden, (1, 6, S, S) >= 0, of a light (1, 16, 32, 3)."""
    reflected = surface.light_of(light) * surface.shares
    return torch.cat([surface.sockets.add_to(reflected[:, :3]), smooth_gloss(reflected[:, 3:])], 1)


@torch.inference_mode()
def begin_effects(networks: BothNetworks, surface: Surface) -> torch.Tensor:
    """The part of the SS network's work that no light changes, (1, C, S, S); for `estimate_effects`."""
    network = networks.specular_shadow
    return network.begin(surface.normal, surface_hints(network.config, surface.relief, surface.parsing))


@torch.inference_mode()
def estimate_effects(
    networks: BothNetworks | None,
    surface: Surface,
    reflected: torch.Tensor,
    transport: ReliefTransport | None,
    light: torch.Tensor,
    begun: torch.Tensor | None = None,
) -> Effects:
    """Specular and shadow of a light (1, 16, 32, 3).

    Args:
        networks: of which SS says what is hidden; None lets the relief alone say it.
        reflected: `reflect` of that light.
        transport: of the surface's relief; None leaves its shadow out, and the shadow without a colour.
        begun: `begin_effects` of the surface by the same networks, where that is kept.
    """
    fraction, odds = torch.zeros_like(surface.relief), None
    if transport is not None:
        odds = shadow_colour_odds(transport, light, reflected)
        fraction = at_surface_size(transport.shadow_fraction(light.cpu()), surface)
    if networks is None:
        of_gloss = fraction if transport is None else at_surface_size(transport.gloss_fraction(light.cpu()), surface)
        hidden = Occlusion(*(torch.logit(part, eps=1e-6) for part in (fraction, of_gloss)))
        return replace(effects_of(hidden, reflected, surface.albedo), colour_odds=odds)
    network, config = networks.specular_shadow, networks.specular_shadow.config
    hints = light_hints(config, reflected, fraction)
    if hints is None:
        occlusion = network(surface.normal, light, surface_hints(config, surface.relief, surface.parsing))
    else:
        if begun is None:
            begun = begin_effects(networks, surface)
        occlusion = network(surface.normal, light, hints, begun)
    effects = estimated_effects(config, occlusion, reflected, surface.albedo)
    return replace(effects, colour_odds=odds, by_relief=fraction)


def at_surface_size(of_relief: torch.Tensor, surface: Surface) -> torch.Tensor:
    """What a relief's transport tells, (1, C, R, R), at the size of the surface, (1, C, S, S), and where that lies."""
    return enlarge(of_relief.to(surface.normal.device), surface.normal.shape[-2:])


def no_effects(surface: Surface) -> Effects:
    """No gloss and no shadow."""
    zero = torch.zeros_like(surface.relief)
    return Effects(zero, zero)


@dataclass(frozen=True)
class Composed:
    """A relit image and the explicit sum it is, or that the network corrected; both (1, 3, S, S), linear."""

    image: torch.Tensor
    plain: torch.Tensor


@torch.inference_mode()
def compose(
    networks: BothNetworks | None,
    surface: Surface,
    reflected: torch.Tensor,
    effects: Effects,
    light: torch.Tensor,
    parts: tuple[bool, bool] = (True, True),
) -> Composed:
    """The relit view at slider positions of 1, in units of the normalised light.

    Args:
        networks: of which composition corrects the explicit sum; None leaves that.
        reflected, effects: of a light (1, 16, 32, 3), as of `reflect` and `estimate_effects`.
        parts: whether specular and shadow are part of it.
    """
    specular, shadow = (float(part) for part in parts)
    plain = explicit_sum(surface.albedo, reflected, effects, specular, shadow)
    if networks is None:
        return Composed(plain, plain)
    # The network has learnt that where much is hidden, more is, and would draw blots beside noses.
    diffuse, gloss = grey(surface.albedo * reflected[:, :3]), grey(reflected[:, 3:])
    doubtful = doubtful_shadow(effects, diffuse, gloss, surface.bare_skin)
    shown = (surface.albedo, surface.normal, effects.specular * specular, doubtful * shadow, plain)
    return Composed(_darkened_evenly(networks.composition(*shown, light), plain), plain)


def _darkened_evenly(image: torch.Tensor, plain: torch.Tensor) -> torch.Tensor:
    """An image (1, 3, S, S) of which no channel has lost a larger share of the explicit sum's than its luminance has.

    Near black the network's encoding is linear, and the same correction of all channels took away all of the blue that
    brown hair has: it turned olive in the shade.
    """
    kept = (grey(image) / grey(plain).clamp_min(1e-6)).clamp_max(1)
    return torch.maximum(image, kept * plain)
