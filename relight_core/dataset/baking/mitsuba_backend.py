"""Mitsuba with its LLVM backend, imported when it is first needed, and a head as its mesh."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from relight_core.dataset.baking.scene import Scene
from relight_core.errors import InputError

_LLVM_CANDIDATES = (
    "libLLVM.so.19.1",
    "libLLVM-19.so.1",
    "libLLVM.so.20.1",
    "libLLVM.so.18.1",
    "libLLVM-18.so.1",
    "libLLVM-17.so.1",
    "libLLVM-16.so.1",
    "libLLVM-15.so.1",
    "libLLVM-14.so.1",
)
_VARIANT = "llvm_ad_rgb"


def mitsuba_backend():
    """Import Mitsuba with its LLVM backend; Dr.Jit takes the library's place from the environment."""
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        folders = [Path("/usr/lib/x86_64-linux-gnu"), Path("/usr/lib/aarch64-linux-gnu"), Path("/usr/lib64")]
        found = [f / name for name in _LLVM_CANDIDATES for f in folders if (f / name).exists()]
        if found:
            os.environ["DRJIT_LIBLLVM_PATH"] = str(found[0])
    try:
        import mitsuba
    except ImportError as error:
        raise InputError("mitsuba is missing: install the training extra, pip install 'relight[train]'") from error
    if mitsuba.variant() != _VARIANT:
        mitsuba.set_variant(_VARIANT)
    return mitsuba


def mesh_of(scene: Scene, **settings):
    """The triangles of a scene, as Mitsuba has them; `settings` are those of `mitsuba.Mesh`."""
    mitsuba = mitsuba_backend()
    mesh = mitsuba.Mesh("head", len(scene.vertices), len(scene.triangles), **settings)
    parameters = mitsuba.traverse(mesh)
    parameters["vertex_positions"] = scene.vertices.astype(np.float32).ravel()
    parameters["faces"] = scene.triangles.astype(np.uint32).ravel()
    parameters.update()
    return mesh
