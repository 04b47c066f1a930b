"""OpenCV's decoders: quiet, and with colours in our order."""

from __future__ import annotations

import threading

import cv2
import numpy as np

_level = threading.Lock()
"""Of OpenCV's log, which is the whole process's: two at a time would put back what the other had put in its place."""


def decoded_by_opencv(data: bytes) -> np.ndarray | None:
    """A file's pixels as stored, blue first; None where it can't be read."""
    with _level:
        level = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        try:
            return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        except cv2.error:
            return None
        finally:
            cv2.utils.logging.setLogLevel(level)


def in_rgb_order(values: np.ndarray) -> np.ndarray:
    """Its grey, BGR or BGRA to (H, W, 1, 3 or 4) in RGB order."""
    if values.ndim == 2:
        return values[..., None]
    order = [2, 1, 0, 3] if values.shape[2] == 4 else slice(None, None, -1)
    return np.ascontiguousarray(values[..., order])
