"""Every reader of the program, each with small good files: what the fuzzer starts from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fuzz_images import coded_exrs, exrs, hdrs, photos, pictures_by_kind

from relight_core.resources import resource_path


@dataclass(frozen=True)
class Reader:
    """One of the program's readers.

    Attributes:
        read: opens a file; may raise InputError and nothing else.
        seeds: good files, as bytes.
        suffix: of the files.
    """

    read: Callable[[Path], object]
    seeds: list[bytes]
    suffix: str


def readers(folder: Path) -> dict[str, Reader]:
    """Every reader by name; `folder` is scratch space."""
    return {**_of_pictures(folder), **_of_work(folder), **_of_makers(folder)}


def _of_pictures(folder: Path) -> dict[str, Reader]:
    """What reads photos and lights."""
    from relight_core.imaging.read import read_photo
    from relight_core.lighting.environment import read_environment
    from relight_core.lighting.rig_description import read_rig

    exr = exrs(folder)
    rigs = [path.read_bytes() for path in sorted(resource_path("rigs").glob("*.toml"))]
    return {
        "photo": Reader(read_photo, [*photos(), *exr], ".image"),
        **{name: Reader(read_photo, files, f".{name}") for name, files in pictures_by_kind().items()},
        "hdr": Reader(read_environment, hdrs(), ".hdr"),
        "exr": Reader(read_environment, exr, ".exr"),
        "exr-codecs": Reader(read_environment, coded_exrs(folder), ".exr"),
        "rig": Reader(read_rig, rigs, ".toml"),
    }


def _of_work(folder: Path) -> dict[str, Reader]:
    """What reads a user's work, and what the editor remembers."""
    from app.document.document import Document, LightRef, PhotoRef
    from app.document.light_file import SavedLight, read_light, write_light
    from app.document.session_file import read_lent_light, read_session, write_session
    from app.engine.calibration_file import read_costs
    from app.settings import Settings, read_settings, write_settings
    from app.window.last_export import read_last_export
    from app.window.recent_lights import read_recent
    from relight_core.face.find import FaceBox
    from relight_core.pipeline.per_photo.brush import BrushStroke

    session, light, settings = (folder / name for name in ("seed.relight.json", "seed.light.json", "settings.json"))
    # A photo that is there, so that an unharmed session would be accepted.
    stroke = BrushStroke(((12.5, -3.0), (40.0, 9.5)), 20.5, True)
    photo = PhotoRef(resource_path("icon", "icon.png"), None, (FaceBox(3, 4, 50, 60, 12.5),), strokes=(stroke,))
    write_session(session, Document(photo=photo), relative=False)
    write_light(light, SavedLight(LightRef("rig", "rembrandt"), yaw_deg=20.0))
    write_settings(settings, Settings(window_size=(800, 600)))
    return {
        "session": Reader(read_session, [session.read_bytes()], ".relight.json"),
        "lent": Reader(read_lent_light, [session.read_bytes()], ".relight.json"),
        "light": Reader(read_light, [light.read_bytes()], ".json"),
        "recent": Reader(read_recent, [b'[["panorama", "/tmp/a.exr"], ["portrait", "/tmp/b.png"]]'], ".json"),
        "export": Reader(read_last_export, [_EXPORT], ".json"),
        "costs": Reader(lambda path: read_costs(path, "key"), [_COSTS], ".json"),
        "settings": Reader(read_settings, [settings.read_bytes()], ".json"),
    }


def _of_makers(folder: Path) -> dict[str, Reader]:
    """What reads networks, and the data and runs they are made of."""
    from relight_core.dataset.baking.shard import read_shard
    from relight_core.dataset.heads import load_head_model
    from relight_core.dataset.lighting.lights import load_lights
    from relight_core.networks.bundle import load_bundle
    from relight_core.training import recipe

    recipes = [path.read_bytes() for path in (Path(recipe.__file__).parent / "recipes").glob("*.toml")]
    return {
        "recipe": Reader(lambda path: recipe.load_recipe(str(path)), recipes, ".toml"),
        "weights": Reader(load_bundle, [_weights(folder)], ".safetensors"),
        "shard": Reader(read_shard, [_shard(folder)], ".npz"),
        "lights": Reader(lambda path: load_lights(path, "train"), [_light_library(folder)], ".npz"),
        "heads": Reader(load_head_model, [_head_model(folder)], ".npz"),
        "run": Reader(_load_run, [_run(folder)], ".safetensors"),
    }


_EXPORT = (
    b'{"form": ".exr", "deep": true, "quality": 92, "longest_side": 2048, "profile": "srgb", "layers": ["albedo"]}'
)
_COSTS = (
    b'{"version": 1, "key": "key", "tiers": {"draft": {"ms": 1.5, "error": 0.02}, '
    b'"live": {"ms": 2, "error": 0.01}, "final": {"ms": 3, "error": 0}}}'
)


def _weights(folder: Path) -> bytes:
    from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle

    path = folder / "seed.safetensors"
    save_bundle(path, NetworkBundle(BundleConfig.tiny()))
    return path.read_bytes()


def _shard(folder: Path) -> bytes:
    from synthetic_heads import ball

    from relight_core.dataset.baking.shard import write_shard

    write_shard(folder / "seed.npz", ball())
    return (folder / "seed.npz").read_bytes()


def _light_library(folder: Path) -> bytes:
    from synthetic_heads import write_lights

    write_lights(folder / "lights.npz", 40)
    return (folder / "lights.npz").read_bytes()


def _head_model(folder: Path) -> bytes:
    from synthetic_heads import write_head_model

    write_head_model(folder / "model.npz")
    return (folder / "model.npz").read_bytes()


def training() -> tuple:
    """Something small to train: weights, their running average and an optimiser that has stepped."""
    import torch

    from relight_core.training.optimiser import Optimiser

    weights = torch.nn.Linear(3, 2)
    optimiser = Optimiser(weights, 1e-3)
    weights(torch.ones(1, 3)).sum().backward()
    optimiser.step()
    return weights, {name: value.clone() for name, value in weights.state_dict().items()}, optimiser


def _run(folder: Path) -> bytes:
    from relight_core.training.state import Progress, make_state

    state = make_state({"stage": "outline", "size": 64}, Progress(step=3, smoothed={"l1": 0.5}), *training())
    state.write(folder / "run.safetensors")
    return (folder / "run.safetensors").read_bytes()


def _load_run(path: Path) -> object:
    from relight_core.training.state import load_state

    return load_state(path, {"stage": "outline", "size": 64}, *training())
