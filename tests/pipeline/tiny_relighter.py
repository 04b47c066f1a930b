"""What the Relighter's tests give to it and ask of its answers."""

import numpy as np

from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit

NETWORK_STAGES = {"delight", "specular_shadow", "compose"}
EDIT = Edit()


def some_photo(seed=0, size=(96, 112)):
    coarse = np.random.default_rng(seed).random((12, 14, 3))
    linear = np.repeat(np.repeat(coarse, size[0] // 12, 0), size[1] // 14, 1)
    return Photo(np.ascontiguousarray(linear * 0.8 + 0.05, np.float32))


def some_light(seed=0, level=1.0):
    radiance = np.random.default_rng(seed).gamma(0.5, 1, (32, 64, 3)).astype(np.float32)
    shape = Environment.from_radiance(radiance).shape
    return Environment(shape, level, "random")


def states(relit):
    return {name: stage.state for name, stage in relit.stages.items()}


def computed(relit):
    return {name for name, state in states(relit).items() if state == "computed"}
