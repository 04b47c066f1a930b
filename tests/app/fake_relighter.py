"""A Relighter of a few numpy lines, so that the window and the engine can be tested without networks."""

from __future__ import annotations

import gc
import threading
import weakref
from dataclasses import dataclass, field

import numpy as np

from relight_core.errors import InputError, NoFaceError
from relight_core.face.find import FaceBox
from relight_core.lighting.environment import Environment, network_light

SIZE = 64
LONG_S = 60
"""Whatever a test waits for comes far sooner, and has failed to come where it hasn't by then."""


def photos_read(monkeypatch, make):
    """A function that says of each photo that an engine has read since whether it is still in memory.

    Args:
        make: gives what is read, in place of any file.
    """
    read = []

    def read_it(path):
        photo = make()
        read.append(weakref.ref(photo))
        return photo

    def still_there():
        gc.collect()
        return [photo() is not None for photo in read]

    monkeypatch.setattr("app.engine.desk.read_photo", read_it)
    return still_there


def answered(engine, request):
    """The engine's snapshot once it has done what was asked for."""
    engine.submit(request)
    assert engine.wait_until_idle(LONG_S)
    return engine.snapshot()


@dataclass(frozen=True)
class FakeStage:
    ms: float
    state: str = "computed"
    why: str = ""
    start_ms: float = 0.0


@dataclass(frozen=True, eq=False)
class FakeRelit:
    image: np.ndarray
    alpha: np.ndarray | None
    channels: dict
    faces: list
    stages: dict = field(default_factory=lambda: {"compose": FakeStage(1.0)})
    window: tuple | None = None
    roll_deg: float = 0.0
    full: object = None
    recipe: object = None
    level_as_in_photo_ev: object = lambda most_stops=4.0: 1.25
    outline: object = list
    channels_together: object = list


class FakeRelighter:
    """Lights the photo's left and right halves by what comes from the left and the right.

    Counts its calls. `gate`, while cleared, holds every relight; `entered` tells that one has begun.
    In a photo that is black all over no face is found, while it is `blind` in none; else there is one in the middle.
    """

    def __init__(self) -> None:
        self.photo, self.people, self.strokes = None, (), ()
        self.blind = False
        self.portraits: list = []
        self.relights: list = []
        self.sides_px: list = []
        self.readied: list = []
        self.environments: list = []
        self.estimated_at: list = []
        self.gate = threading.Event()
        self.gate.set()
        self.entered = threading.Semaphore(0)
        self.fail_with: Exception | None = None
        self.outline: list = []
        self.in_foreign_shadow = False

    def set_portrait(self, photo, face_index=None, boxes=None, strokes=()):
        if boxes is None:
            boxes = [] if self.blind or photo.linear.max() == 0.0 else [FaceBox(32, 16, 96, 80)]
        if not boxes:
            raise NoFaceError(f"{photo.path}: no face found; use another photo")
        if any(box.x1 <= 0 for box in boxes):
            raise InputError(f"{photo.path}: the box of a face is outside")
        self.photo, self.people, self.strokes = photo, tuple(boxes), strokes
        self.portraits.append((photo, face_index, tuple(boxes)))

    def estimated_light(self, quality):
        self.estimated_at.append(quality)
        height, width = 16, 32
        radiance = np.ones((height, width, 3), np.float32) * self.photo.linear.mean(axis=(0, 1))
        return Environment.from_radiance(radiance, "estimated")

    def get_ready(self, environment, edit):
        self.readied.append(edit)

    def forget_lights(self):
        """It keeps nothing."""

    def relight(self, environment, edit, longest_side_px=None, *, for_shader=False):
        self.entered.release()
        assert self.gate.wait(30)
        if self.fail_with is not None:
            raise self.fail_with
        self.relights.append(edit)
        self.sides_px.append(longest_side_px)
        self.environments.append(environment)
        light = network_light(environment, edit.yaw_deg)
        left, right = light[:, 2:14].mean(), light[:, 18:30].mean()
        height, width = self.photo.linear.shape[:2]
        ramp = np.linspace(0.0, 1.0, width, dtype=np.float32)[None, :, None]
        shading = left * (1 - ramp) + right * ramp
        image = np.ascontiguousarray(self.photo.linear * shading / max(left, right, 1e-12))
        alpha = None
        if edit.background == "transparent":
            alpha = np.ones((height, width), np.float32)
            alpha[: height // 4] = 0.0
        half = SIZE // 2
        window = (width / 2 - half, height / 2 - half, width / 2 + half, height / 2 + half)
        return FakeRelit(image, alpha, self._channels(edit, light), [], window=window, outline=self.draw_outline)

    def draw_outline(self):
        return self.outline

    def _channels(self, edit, light):
        rows, columns = np.mgrid[0:SIZE, 0:SIZE].astype(np.float32) / (SIZE - 1)
        normal = np.dstack([columns * 2 - 1, 1 - rows * 2, np.ones_like(rows)])
        grey = np.repeat(columns[..., None], 3, axis=2)
        red = np.zeros((SIZE, SIZE, 3), np.float32)
        red[..., 0] = 1.0
        taken_off = {"foreign_shadow": red} if self.in_foreign_shadow and edit.forced("foreign_shadow") is None else {}
        return taken_off | {
            "photo": grey,
            "albedo": red,
            "normal": normal / np.linalg.norm(normal, axis=2, keepdims=True),
            "parsing": (rows * 7).astype(np.int64),
            "specular": columns * edit.specular * 0.2,
            "shadow": rows * edit.shadow * 0.3,
            "composition": grey,
            "source_light": light,
            "target_light": light,
        }
