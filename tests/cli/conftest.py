"""A Relighter without networks: the command line's own behaviour does not depend on theirs."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from PIL import Image

from app.cli import session
from app.cli.main import main
from relight_core.errors import NoFaceError
from relight_core.face.find import FaceBox
from relight_core.lighting.environment import Environment
from relight_core.pipeline.cache import Stage
from relight_core.pipeline.per_photo.person import Canvas
from relight_core.pipeline.results.relit import Relit


@dataclass(frozen=True)
class FakePicture:
    """A photo times a gain, with or without an alpha of one value."""

    canvas: Canvas
    gain: float
    share: float | None
    asked_wide: list[bool]

    @property
    def size(self):
        return self.canvas.size

    @property
    def has_alpha(self):
        return self.share is not None

    def part(self, window):
        x0, y0, x1, y1 = window
        image = self.canvas.linear[y0:y1, x0:x1] * np.float32(self.gain)
        return image, None if self.share is None else np.full(image.shape[:2], self.share, np.float32)

    def in_bands(self, wide):
        self.asked_wide.append(wide)
        return [(slice(None), *self.part((0, 0, self.size[1], self.size[0])))]


class Done(NamedTuple):
    """What a command left: its exit code, stdout and stderr."""

    code: int
    out: str
    err: str


class FakeRelighter:
    """Multiplies the photo by the shadow's gain and finds a face wherever a photo isn't one flat colour."""

    def __init__(self) -> None:
        self.edits, self.lights, self.estimates = [], [], []
        self.level_ev = -1.5
        self.people = (FaceBox(20.0, 20.0, 40.0, 40.0),)
        self.share = 0.5
        self.face_count = 1
        self.longest_sides_px, self.asked_wide = [], []
        self.taken_apart = None
        self.networks_ended_s = None

    def set_portrait(self, photo, face_index=None, boxes=None, strokes=()):
        self.boxes, self.strokes, self.face_index = boxes, strokes, face_index
        if photo.linear.std() < 1e-3 or (boxes is None and not self.people):
            raise NoFaceError(f"{photo.path}: no face found; choose a photo that shows a face")
        self.photo = photo

    def estimated_light(self, quality):
        self.estimates.append(quality)
        return Environment.from_radiance(np.full((16, 32, 3), 0.25, np.float32), "borrowed")

    def relight(self, environment, edit, longest_side_px=None, *, for_shader=False):
        self.edits.append(edit)
        self.lights.append(environment)
        self.longest_sides_px.append(longest_side_px)
        height, width = self.photo.linear.shape[:2]
        canvas = Canvas(self.photo.linear, self.photo.alpha, (height, width))
        share = self.share if edit.background == "transparent" else None
        full = FakePicture(canvas, edit.shadow, share, self.asked_wide)
        image, alpha = full.part((0, 0, width, height)) if longest_side_px != 0 else (None, None)
        crop = np.full((8, 8, 3), 0.25, np.float32)
        grey = crop[..., 0]
        return Relit(
            image=image,
            alpha=alpha,
            networks_ended_s=self.networks_ended_s,
            level_as_in_photo_ev=lambda most_stops=4.0: max(self.level_ev, -most_stops),
            full=full,
            channels={
                "photo": crop,
                "albedo": crop,
                "normal": np.broadcast_to(np.float32([0, 0, 1]), (8, 8, 3)),
                "parsing": np.ones((8, 8), np.int64),
                "specular": grey,
                "shadow": grey,
                "composition": crop,
                "source_light": np.ones((16, 32, 3), np.float32),
                "target_light": np.ones((16, 32, 3), np.float32),
            },
            window=(0.0, 0.0, 16.0, 16.0),
            faces=[SimpleNamespace(x0=1.0, y0=2.0, x1=11.0, y1=14.0)] * self.face_count,
            stages=self._stages(),
            plan=[
                SimpleNamespace(name="relief", state="skipped", why="no need", bound=0.001, forced=None, saved_ms=2.5)
            ],
        )

    def _stages(self):
        """De-lighting runs for a photo's first light, the sliders for every light."""
        taken_apart = self.taken_apart is self.photo
        self.taken_apart = self.photo
        return {
            "delight": Stage(0.0, "reused", "kept") if taken_apart else Stage(1.25, "computed", "new photo"),
            "sliders": Stage(2.0, "computed", "new light"),
            "compose": Stage(0.5, "skipped", "nothing to do"),
        }


@pytest.fixture
def relighter(monkeypatch):
    """The one fake that every command of a test uses."""
    fake = FakeRelighter()
    monkeypatch.setattr(session, "make_relighter", lambda: fake)
    return fake


@pytest.fixture
def photo(tmp_path):
    """A 24 x 16 photo with something in it, /…/photo.png."""
    return save_photo(tmp_path / "photo.png")


def save_photo(path, seed=0):
    pixels = np.random.default_rng(seed).integers(40, 200, (16, 24, 3), dtype=np.uint8)
    Image.fromarray(pixels).save(path)
    return path


@pytest.fixture
def another_photo(tmp_path):
    """A second photo, /…/another.png."""
    return save_photo(tmp_path / "another.png", seed=1)


@pytest.fixture
def relight(relighter, command_line):
    """Runs the command line with the fake; gives exit code, stdout and stderr."""
    return command_line


@pytest.fixture
def command_line(capfd):
    """Runs the command line as it is; gives exit code, stdout and stderr."""

    def run(*words):
        code = main([str(word) for word in words])
        streams = capfd.readouterr()
        return Done(code, streams.out, streams.err)

    return run


@pytest.fixture
def run(command_line):
    """The same for makers' commands, in short."""
    return command_line
