"""Ways to carry a relit view to the photo's size, to compare. Each sees what the networks would give it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.face.parsing import SURELY
from relight_core.imaging.guided_detail import carry_detail
from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.light_change import LARGEST_GAIN
from relight_core.imaging.resampling import resize_area, resize_smooth
from relight_core.imaging.view_of_photo import Materials, ViewOfPhoto

_DARK = 1e-3
_LATTICE = 512
_SMOOTHNESS, _COLOUR_CODES = 60.0, 12.0


@dataclass(frozen=True, eq=False)
class DetailTask:
    """A photo at its own size, and a relit view at the networks'; all linear.

    Attributes:
        photo: (S, S, 3).
        photo_small, relit_small, gloss_small: (s, s, 3).
        materials_small: of (s, s).
    """

    photo: np.ndarray
    photo_small: np.ndarray
    relit_small: np.ndarray
    gloss_small: np.ndarray
    materials_small: Materials

    def enlarged(self, small: np.ndarray) -> np.ndarray:
        """Bilinearly to the photo's size."""
        return resize_smooth(small, self.photo.shape[:2])


def plain(task: DetailTask) -> np.ndarray:
    """The relit view enlarged: no detail."""
    return task.enlarged(task.relit_small)


def guided_filter(task: DetailTask) -> np.ndarray:
    """Gain and offset fitted in small windows (He, Sun and Tang 2013)."""
    return carry_detail(task.photo, task.photo_small, task.relit_small)


def ratio_image(task: DetailTask) -> np.ndarray:
    """The quotient of relit and photo, enlarged (Shashua and Riklin-Raviv 2001)."""
    ratio = (task.relit_small + _DARK) / (task.photo_small + _DARK)
    return _multiplied(task, task.enlarged(np.clip(ratio, 0, LARGEST_GAIN)))


def global_smoother(task: DetailTask) -> np.ndarray:
    """The ratio image without gloss, smoothed along the photo's edges (Min et al. 2014), gloss added."""
    gloss = np.minimum(task.gloss_small, task.relit_small)
    ratio = (task.relit_small - gloss + _DARK) / (task.photo_small + _DARK)
    enlarged = task.enlarged(np.clip(ratio, 0, LARGEST_GAIN))
    guide = np.rint(np.sqrt(np.clip(task.photo, 0, 1)) * 255).astype(np.uint8)
    smooth = [
        cv2.ximgproc.fastGlobalSmootherFilter(guide, np.ascontiguousarray(layer), _SMOOTHNESS, _COLOUR_CODES)
        for layer in np.moveaxis(enlarged, -1, 0)
    ]
    return _multiplied(task, np.stack(smooth, -1)) + task.enlarged(gloss)


def joint_bilateral(task: DetailTask) -> np.ndarray:
    """The ratio image, enlarged along the photo's edges (Kopf et al. 2007)."""
    ratio = np.clip((task.relit_small + _DARK) / (task.photo_small + _DARK), 0, LARGEST_GAIN)
    return _multiplied(task, task.enlarged(_upsampler(task)(ratio)))


def gain_and_gloss(task: DetailTask) -> np.ndarray:
    """Gain and gloss apart, both enlarged along the photo's edges, patterns kept: what the editor does."""
    view = ViewOfPhoto(task.photo_small, task.materials_small, SURELY)
    change = view.change_to(task.relit_small, task.gloss_small)
    gain, offset = _upsampler(task).change(change.gain, change.offset)
    return task.enlarged(gain) * task.photo + task.enlarged(offset)


METHODS: dict[str, Callable[[DetailTask], np.ndarray]] = {
    "enlarged only": plain,
    "guided filter": guided_filter,
    "ratio image": ratio_image,
    "fast global smoother": global_smoother,
    "joint bilateral, ratio": joint_bilateral,
    "joint bilateral, gain and gloss": gain_and_gloss,
}


def _multiplied(task: DetailTask, gain: np.ndarray) -> np.ndarray:
    return np.maximum(gain * (task.photo + _DARK) - _DARK, 0)


def _upsampler(task: DetailTask) -> JointUpsampler:
    size, small = task.photo.shape[0], task.photo_small.shape[0]
    lattice = max(min(_LATTICE, size) // small, 1) * small
    return JointUpsampler(task.photo_small, resize_area(task.photo, (lattice, lattice)), task.materials_small.skin)
