"""The networks as one file of weights: safetensors, with their configuration in its header.

De-lighting; SS and composition in one width or two, a wide pair and a narrow one that was taught by it; and the
person network, where there is one.
"""

from __future__ import annotations

import copy
import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from torch import nn

from relight_core.errors import InputError
from relight_core.imaging.files import check_regular, whole_file
from relight_core.networks.blocks import ResidualBlock, fold_normalisation, round_convolutions
from relight_core.networks.composition import CompositionConfig, CompositionNetwork
from relight_core.networks.delight import DelightConfig, DelightNetwork
from relight_core.networks.foreign_shadow import ForeignShadowConfig, ForeignShadowNetwork
from relight_core.networks.pair import BothNetworks, PairConfig, PairName, RelightingPair
from relight_core.networks.person import PersonConfig, PersonNetwork
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork
from relight_core.networks.tensor_file import checksum, tensor_file

FORMAT = "relight-networks-1"

_CHECKSUM = "sha256"
_COUNTS = ("levels", "residual", "decoder_residual")
"""Fields of the networks' configurations that count parts, of which each has a tensor at least."""

_MEND = "give others, or install relight again if they are its own"
_DAMAGE = (OSError, SafetensorError, RuntimeError, TypeError, ValueError, IndexError, MemoryError, OverflowError)


@dataclass(frozen=True)
class BundleConfig:
    """Configurations of the networks.

    Attributes:
        narrow: of the narrow pair; None where there is none.
        person, foreign_shadow: of these networks; None where there is none.
    """

    delight: DelightConfig = field(default_factory=DelightConfig)
    specular_shadow: SpecularShadowConfig = field(default_factory=SpecularShadowConfig)
    composition: CompositionConfig = field(default_factory=CompositionConfig)
    narrow: PairConfig | None = None
    person: PersonConfig | None = None
    foreign_shadow: ForeignShadowConfig | None = None

    @classmethod
    def tiny(cls) -> BundleConfig:
        """The smallest networks that still have every part: for tests."""
        return cls(DelightConfig(width=4, levels=3), SpecularShadowConfig(width=4, levels=3), CompositionConfig(4, 2))

    @classmethod
    def from_json(cls, text: str) -> BundleConfig:
        """Inverse of `to_json`; raises KeyError or TypeError for anything else."""
        parts = json.loads(text)
        wide, narrow = PairConfig.from_parts(parts), parts.get("narrow")
        person, foreign_shadow = parts.get("person"), parts.get("foreign_shadow")
        return cls(
            DelightConfig(**parts["delight"]),
            wide.specular_shadow,
            wide.composition,
            PairConfig.from_parts(narrow) if narrow is not None else None,
            PersonConfig(**person) if person is not None else None,
            ForeignShadowConfig(**foreign_shadow) if foreign_shadow is not None else None,
        )

    @property
    def wide(self) -> PairConfig:
        """Of the wide pair."""
        return PairConfig(self.specular_shadow, self.composition)

    def to_json(self) -> str:
        """One line of JSON."""
        return json.dumps(dataclasses.asdict(self))


class NetworkBundle(nn.Module):
    """All networks together.

    Attributes:
        narrow: a second pair of SS and composition, quicker than the first; None where there is none.
        person, foreign_shadow: None where there is none.
        card: free text entries saved beside the weights (data, steps, scores).
    """

    def __init__(self, config: BundleConfig | None = None):
        super().__init__()
        self.config = config or BundleConfig()
        self.delight = DelightNetwork(self.config.delight)
        self.specular_shadow = SpecularShadowNetwork(self.config.specular_shadow)
        self.composition = CompositionNetwork(self.config.composition)
        self.narrow = RelightingPair(self.config.narrow) if self.config.narrow else None
        self.person = PersonNetwork(self.config.person) if self.config.person else None
        foreign_shadow = self.config.foreign_shadow
        self.foreign_shadow = ForeignShadowNetwork(foreign_shadow) if foreign_shadow else None
        self.card: dict[str, str] = {}
        self._rounded: list[NetworkBundle] = []

    def pair(self, name: PairName) -> BothNetworks:
        """SS and composition of a width; the wide ones where there is no other."""
        return self.narrow if name == "narrow" and self.narrow is not None else self

    def for_inference(self) -> NetworkBundle:
        """Evaluation mode, normalisation folded, channels last, no gradients; in place."""
        self.eval().requires_grad_(False)
        fold_normalisation(self)
        return self.to(memory_format=torch.channels_last)

    @property
    def is_for_inference(self) -> bool:
        """Whether `for_inference` has made these networks ready, after which no weight changes."""
        return isinstance(self.delight.encoder.stem.norm, nn.Identity)

    def rounded(self) -> NetworkBundle:
        """A copy that computes in bf16, made once; what `for_inference` made ready."""
        if not self._rounded:
            self._rounded.append(round_convolutions(copy.deepcopy(self)))
        return self._rounded[0]


def with_detail_pass(bundle: NetworkBundle, width: int) -> NetworkBundle:
    """The same networks with a sharpening pass in de-lighting, which changes nothing until it is trained.

    The encoder-decoder goes on at the resolution it knows, on photos of twice that.
    """
    return _with_delight(bundle, detail_width=width)


def with_residual_blocks(
    bundle: NetworkBundle, encoder: tuple[int, ...] = (), decoder: tuple[int, ...] = (), *, settled: bool = False
) -> NetworkBundle:
    """The same networks with residual blocks in de-lighting, which change nothing until they are trained.

    Args:
        encoder, decoder: how many each level has, as `DelightConfig.residual` and `decoder_residual` count them;
            empty leaves those that there are.
        settled: they are trained with running statistics that hold (`training.stages.Stage.settled`).

    Raises:
        InputError: they do not fit the levels that de-lighting has.
    """
    try:
        counts = {name: count for name, count in (("residual", encoder), ("decoder_residual", decoder)) if count}
        for name, count in counts.items():
            _check_grows(getattr(bundle.config.delight, name), count)
        grown = _with_delight(bundle, **counts)
    except ValueError as error:
        raise InputError(str(error)) from error
    if settled:
        for part in grown.delight.modules():
            if isinstance(part, ResidualBlock) and part.is_untaught:
                part.begin_settled()
    return grown


def _check_grows(before: tuple[int, ...], after: tuple[int, ...]) -> None:
    """Raise ValueError where trained residual blocks would be lost."""
    levels = max(len(before), len(after))
    padded = [(*counts, *[0] * (levels - len(counts))) for counts in (before, after)]
    if any(new < old for old, new in zip(*padded, strict=True)):
        has = ",".join(map(str, before))
        raise ValueError(f"the weights have residual blocks already ({has}), which none may be taken from")


def _with_delight(bundle: NetworkBundle, **changes: int | tuple[int, ...]) -> NetworkBundle:
    """The same weights in a de-lighting network that has more parts."""
    delight = dataclasses.replace(bundle.config.delight, **changes)
    if delight == bundle.config.delight:
        return bundle
    grown = NetworkBundle(dataclasses.replace(bundle.config, delight=delight))
    grown.load_state_dict(bundle.state_dict(), strict=False)
    grown.card = dict(bundle.card)
    return grown


def with_narrow_pair(bundle: NetworkBundle, narrow: RelightingPair) -> NetworkBundle:
    """The same networks with another narrow pair, or their first."""
    joined = _with_part(bundle, "narrow", narrow)
    joined.card |= {"widths": f"wide: {bundle.config.wide}; narrow: {narrow.config}"}
    return joined


def with_person_network(bundle: NetworkBundle, person: PersonNetwork) -> NetworkBundle:
    """The same networks with another person network, or their first."""
    return _with_part(bundle, "person", person)


def with_foreign_shadow_network(bundle: NetworkBundle, foreign_shadow: ForeignShadowNetwork) -> NetworkBundle:
    """The same networks with another foreign-shadow network, or their first."""
    return _with_part(bundle, "foreign_shadow", foreign_shadow)


MORE_NETWORKS = {
    "narrow": with_narrow_pair,
    "person": with_person_network,
    "foreign_shadow": with_foreign_shadow_network,
}
"""What a file may have beside the first three networks, by attribute of a bundle, and what puts it into another."""


def _with_part(
    bundle: NetworkBundle, name: str, part: RelightingPair | PersonNetwork | ForeignShadowNetwork
) -> NetworkBundle:
    joined = NetworkBundle(dataclasses.replace(bundle.config, **{name: part.config}))
    kept = {key: value for key, value in bundle.state_dict().items() if not key.startswith(f"{name}.")}
    joined.load_state_dict(kept | {f"{name}.{key}": value for key, value in part.state_dict().items()})
    joined.card = dict(bundle.card)
    return joined


def with_narrow_width(bundle: NetworkBundle, width: int) -> NetworkBundle:
    """The same networks with an untrained narrow pair of so many channels, unless they have one of that size."""
    config = bundle.config.wide.narrowed(width)
    if bundle.config.narrow == config:
        return bundle
    return with_narrow_pair(bundle, RelightingPair(config).told_of_light_like(bundle))


def save_bundle(path: Path, bundle: NetworkBundle, *, half: bool = True) -> None:
    """Write weights whole or not at all, with their own checksum; floats as fp16 unless `half` is False.

    Raises:
        ValueError: when a weight is not finite.
        InputError: the place can't be written.
    """
    tensors = {}
    for name, value in bundle.state_dict().items():
        if value.is_floating_point():
            # A running variance may exceed what fp16 holds, and underflow would divide by 0.
            keep = not half or name.endswith(("running_var", "running_mean"))
            value = value.float() if keep else value.half()
            if not torch.isfinite(value).all():
                raise ValueError(f"{name} is not finite: not saved")
        tensors[name] = value.contiguous()
    header = {"format": FORMAT, "config": bundle.config.to_json(), _CHECKSUM: checksum(tensors), **bundle.card}
    with whole_file(path) as beside:
        # Not its own writing to files, which reports a full disk as damage.
        beside.write_bytes(tensor_file(tensors, header))


def load_bundle(path: Path) -> NetworkBundle:
    """Read weights; raises InputError when the file is missing, damaged or of another format."""
    try:
        check_regular(path)
        if path.is_dir():
            raise InputError(f"{path}: this is a folder; name a file of weights in it")
        with safe_open(path, framework="pt") as file:
            header = dict(file.metadata() or {})
            if header.pop("format", None) != FORMAT:
                raise InputError(f"{path}: not a file of relight weights; use one written by 'relight train'")
            config = BundleConfig.from_json(header.pop("config"))
            _check_held(config, [file.get_slice(name).get_shape() for name in file.keys()])  # noqa: SIM118
            bundle = NetworkBundle(config)
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
            if header.pop(_CHECKSUM, None) not in (None, checksum(tensors)):
                raise InputError(f"{path}: these weights are damaged (their checksum differs); {_MEND}")
            bundle.load_state_dict({name: value.float() for name, value in tensors.items()}, strict=True)
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(
            f"{path}: no such file; check the path, or install relight again if these are its own weights"
        ) from None
    except KeyError as error:
        what = f"not the weights of relight's networks (their header has no {error.args[0]!r})"
        raise InputError(f"{path}: {what}; use those that 'relight train' wrote") from error
    except _DAMAGE as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: these weights can't be read ({reason}); {_MEND}") from error
    bundle.card = header
    return bundle


def _check_held(config: BundleConfig, shapes: Sequence[Sequence[int]]) -> None:
    """Raise ValueError for networks that tensors of these shapes can't be, before anything of their size is made."""
    numbers = list(_numbers(dataclasses.asdict(config)))
    parts = sum(abs(number) for name, number in numbers if name in _COUNTS)
    if parts > len(shapes):
        raise ValueError(f"the header tells of {parts} levels and blocks, which {len(shapes)} tensors can't be")
    most = max((number for name, number in numbers if name not in _COUNTS), default=0)
    if most > (longest := max((side for shape in shapes for side in shape), default=0)):
        raise ValueError(f"the header tells of {most} channels, and no tensor has more than {longest}")


def _numbers(part: Mapping[str, Any]) -> Iterator[tuple[str, int]]:
    """The whole numbers of a configuration, each by the name of its field.

    `widest` limits the channels of levels that have twice as many each; if none comes near it, it is the last one's.
    """
    if "widest" in part:
        last = part["width"] * 2 ** min(max(part["levels"] - 1, 0), 32)
        part = {**part, "widest": min(part["widest"], last)}
    for name, value in part.items():
        if isinstance(value, Mapping):
            yield from _numbers(value)
        else:
            several = value if isinstance(value, tuple) else (value,)
            yield from ((name, one) for one in several if isinstance(one, int))
