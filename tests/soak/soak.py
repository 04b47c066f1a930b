"""Hours of random editing in the real window: memory and frame times must stay flat, the log empty.

    python tests/soak/soak.py --minutes 120 -o soak.json

Photos are opened (some of them broken), the light is turned and changed, sliders are dragged, steps undone,
pictures looked at and exported, with the mouse and the keys and the shipped networks, while unsaved work and
settings are kept in a folder of their own. Where DISPLAY is not set, an Xvfb is started. Every light and photo
is visited once before the clock starts, and the first quarter counts as warm-up. `--core 0.3` makes the user
think between two actions until the process has used no more than that share of one core; the time a frame takes
then depends on what else the machine does, its processor time does not.

Exit code 1 if memory changed by more than 5 % from the second quarter to the last, the 95th percentile of the
frames' times or processor times by more than half, anything was logged as an error, or the engine stopped
answering.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import glfw
import numpy as np

_SIZE = (1100, 760)
_PANORAMA = ((20, 235), 90)
_SLOWEST_ANSWER_S = 120.0
_THINKING_STEP_S, _SITTING_STILL_S = 0.05, 0.2
_MEMORY_EVERY_S, _REPORT_EVERY_S = 10.0, 120.0
_OUR_FAULT = "A fault of ours"


class Soak:
    """A random user and a notebook.

    Args:
        folder: for photos, lights, exports and settings.
        seed: of the user.
        core: the share of one processor core the process may use on average; None never thinks.
    """

    def __init__(self, folder: Path, seed: int, core: float | None = None):
        from app.window.window import EditorWindow
        from relight_core.lighting.rigs import rig_names
        from relight_core.pipeline.relighter import Relighter

        self.rng, self.core = np.random.default_rng(seed), core
        self.folder, self.rigs = folder, rig_names()
        self.photos, self.lights = _material(folder)
        settings = folder / "config" / "settings.json"
        self.window = EditorWindow(Relighter, self.photos[0], size=_SIZE, settings_path=settings)
        self.frame_ms: list[tuple[float, float]] = []
        self.frame_cpu_ms: list[tuple[float, float]] = []
        self.memory_mb: list[tuple[float, float]] = []
        self.faults: list[str] = []
        self.warnings: dict[str, int] = {}
        self.counts: dict[str, int] = {}
        self._message = 0
        self._started, self._cpu_started = time.monotonic(), time.process_time()

    def run(self, seconds: float, report=lambda: None) -> None:
        """Work for so long; `report` is called every few minutes."""
        self._visit_everything()
        self._started, self._cpu_started = time.monotonic(), time.process_time()
        noted_s = reported_s = 0.0
        self.frame_ms.clear()
        self.frame_cpu_ms.clear()
        actions = [self.turn, self.drag, self.keys, self.change_light, self.undo, self.export, self.open, self.look]
        chances = np.array([6, 6, 4, 3, 3, 1, 1, 3], float)
        while time.monotonic() - self._started < seconds:
            action = actions[self.rng.choice(len(actions), p=chances / chances.sum())]
            action()
            self.counts[action.__name__] = self.counts.get(action.__name__, 0) + 1
            self.frames(int(self.rng.integers(1, 12)))
            self._think(seconds)
            if self._now() - noted_s > _MEMORY_EVERY_S:
                if not self._engine_answers():
                    self.faults.append("the engine did not answer")
                    break
                self._note_memory()
                noted_s = self._now()
            if self._now() - reported_s > _REPORT_EVERY_S:
                report()
                reported_s = self._now()
        self.window.close()

    def _engine_answers(self) -> bool:
        """Wait for the engine; False if it works without an end, or sits still without an answer.

        Counted in processor time, since a machine that does much else answers late and is not at fault.
        """
        began = before = time.process_time()
        while not self.window.engine.wait_until_idle(_SLOWEST_ANSWER_S):
            now = time.process_time()
            if now - before < _SITTING_STILL_S or now - began > _SLOWEST_ANSWER_S:
                return False
            before = now
        return True

    def cpu_share(self) -> float:
        """Of one core, since the clock started."""
        return (time.process_time() - self._cpu_started) / max(self._now(), 1e-3)

    def _think(self, seconds: float) -> None:
        """Sit still until the process has used no more than its share; what the engine publishes is drawn."""
        snapshot = self.window.engine.snapshot()
        while self.core is not None and self.cpu_share() > self.core and self._now() < seconds:
            time.sleep(_THINKING_STEP_S)
            if self.window.engine.snapshot() is not snapshot:
                snapshot = self.window.engine.snapshot()
                self.frames(1)

    def _visit_everything(self) -> None:
        """What is made once and kept, so that it does not look like a leak."""
        from app.engine.sources import LightSource

        for photo in self.photos:
            self.window.on_drop(None, [str(photo)], self._picture_point())
            self.window.settle(_SLOWEST_ANSWER_S)
        for rig in self.rigs:
            self.window.state.choose_light(LightSource("rig", rig))
            self.window.settle(_SLOWEST_ANSWER_S)

    def frames(self, count: int) -> None:
        for _ in range(count):
            glfw.poll_events()
            before, cpu_before = time.perf_counter(), time.thread_time()
            self.window.frame()
            self.frame_ms.append((self._now(), (time.perf_counter() - before) * 1e3))
            self.frame_cpu_ms.append((self._now(), (time.thread_time() - cpu_before) * 1e3))
        message = self.window.state.snapshot.message
        if message is not None and message.number != self._message:
            self._message = message.number
            if message.text.startswith(_OUR_FAULT):
                self.faults.append(message.text)

    def turn(self) -> None:
        self._move(self._picture_point())
        self.window.on_wheel(None, 0.0, float(self.rng.integers(-3, 4)))

    def drag(self) -> None:
        """Along the panorama, or anywhere over the effects panel's upper half, where the sliders are."""
        width, height = _SIZE
        if self.rng.random() < 0.4:
            (low, high), y = _PANORAMA
            start, end = (self.rng.uniform(low, high), y), (self.rng.uniform(low, high), y)
        else:
            y = self.rng.uniform(40, height * 0.35)
            start, end = ((width - self.rng.uniform(15, 225), y) for _ in range(2))
        self._move(start)
        self.window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, 0)
        for share in np.linspace(0, 1, int(self.rng.integers(2, 8))):
            self._move(tuple(a + (b - a) * share for a, b in zip(start, end, strict=True)))
        self.window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE, 0)
        self._key(glfw.KEY_ESCAPE)

    def keys(self) -> None:
        self._key(int(self.rng.choice([glfw.KEY_LEFT, glfw.KEY_RIGHT, glfw.KEY_F, glfw.KEY_EQUAL, glfw.KEY_MINUS])))

    def look(self) -> None:
        self._key(glfw.KEY_1 + int(self.rng.integers(0, 9)))

    def undo(self) -> None:
        self._key(glfw.KEY_Z, ctrl=True, shift=self.rng.random() < 0.4)

    def change_light(self) -> None:
        from app.engine.sources import LightSource

        if self.rng.random() < 0.2:
            self.window.on_drop(None, [str(self.rng.choice(self.lights))], self._picture_point())
            return
        self.window.state.choose_light(LightSource("rig", str(self.rng.choice(self.rigs))))

    def open(self) -> None:
        self.window.on_drop(None, [str(self.rng.choice(self.photos))], self._picture_point())

    def export(self) -> None:
        self._key(glfw.KEY_E, shift=self.rng.random() < 0.3)
        made = sorted(self.folder.glob("*relit*"), key=os.path.getmtime)
        for path in made[:-4]:
            path.unlink(missing_ok=True)

    def _picture_point(self) -> tuple[float, float]:
        return self.rng.uniform(300, _SIZE[0] - 280), self.rng.uniform(80, _SIZE[1] - 200)

    def _move(self, at: tuple[float, float]) -> None:
        self.window.on_mouse_move(None, *at)
        self.frames(1)

    def _key(self, key: int, *, ctrl: bool = False, shift: bool = False) -> None:
        mods = glfw.MOD_CONTROL * ctrl | glfw.MOD_SHIFT * bool(shift)
        self.window.on_key(None, key, 0, glfw.PRESS, mods)
        self.frames(1)
        self.window.on_key(None, key, 0, glfw.RELEASE, 0)
        self.frames(1)

    def seconds(self) -> float:
        """Since the clock started, up to the last frame."""
        return self.frame_ms[-1][0] if self.frame_ms else 0.0

    def _now(self) -> float:
        return time.monotonic() - self._started

    def _note_memory(self) -> None:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                self.memory_mb.append((self._now(), int(line.split()[1]) / 1024))


def _material(folder: Path) -> tuple[list[Path], list[Path]]:
    """Photos of several sizes, one broken and one without a face; panoramas, one of the wrong shape."""
    from skimage.data import astronaut

    from relight_core.imaging.photo import Photo
    from relight_core.imaging.resampling import resize_area
    from relight_core.imaging.write import write_image

    whole = Photo.from_srgb(astronaut()).linear
    photos = []
    for index, height in enumerate((512, 300, 800)):
        photos.append(folder / f"portrait{index}.png")
        write_image(photos[-1], resize_area(whole, (height, height)))
    (folder / "broken.jpg").write_bytes(b"\xff\xd8\xff\xe0" + bytes(range(256)) * 20)
    write_image(folder / "wall.png", np.full((200, 200, 3), 0.3, np.float32))
    rng = np.random.default_rng(0)
    lights = []
    for index, size in enumerate(((64, 128), (256, 512), (50, 60))):
        lights.append(folder / f"light{index}.exr")
        write_image(lights[-1], rng.gamma(0.5, 1, (*size, 3)).astype(np.float32))
    return [*photos, folder / "broken.jpg", folder / "wall.png"], lights


class _Log(logging.Handler):
    """Errors are faults; warnings are counted."""

    def __init__(self, soak: Soak):
        super().__init__(logging.WARNING)
        self._soak = soak

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno >= logging.ERROR:
            self._soak.faults.append(self.format(record))
        else:
            kind = f"{record.name}: {record.msg}"
            self._soak.warnings[kind] = self._soak.warnings.get(kind, 0) + 1


def summary(soak: Soak, seconds: float) -> dict:
    """Figures by quarter, and what was wrong."""

    def quarters(samples: list[tuple[float, float]], measure) -> list[float]:
        values = [[v for t, v in samples if int(4 * t / seconds) == quarter] for quarter in range(4)]
        return [round(float(measure(v)), 2) if v else float("nan") for v in values]

    memory = quarters(soak.memory_mb, np.mean)
    p95, cpu_p95 = (quarters(samples, lambda v: np.percentile(v, 95)) for samples in (soak.frame_ms, soak.frame_cpu_ms))
    verdicts = {
        "memory flat": 0.95 * memory[1] <= memory[3] <= 1.05 * memory[1],
        "frame times flat": p95[3] <= 1.5 * p95[1] or cpu_p95[3] <= 1.5 * cpu_p95[1],
        "no errors": not soak.faults,
    }
    return {
        "minutes": round(soak.seconds() / 60, 1),
        "cpu_share": round(soak.cpu_share(), 3),
        "frames": len(soak.frame_ms),
        "actions": soak.counts,
        "memory_mb": memory,
        "memory_each_mb": [[round(t), round(mb)] for t, mb in soak.memory_mb],
        "frame_median_ms": quarters(soak.frame_ms, np.median),
        "frame_p95_ms": p95,
        "frame_cpu_median_ms": quarters(soak.frame_cpu_ms, np.median),
        "frame_cpu_p95_ms": cpu_p95,
        "verdicts": verdicts,
        "warnings": soak.warnings,
        "faults": soak.faults[:20],
    }


def _write(path: Path | None, figures: dict) -> None:
    if path is not None:
        path.write_text(json.dumps(figures) + "\n")


def _with_display() -> subprocess.Popen | None:
    if os.environ.get("DISPLAY"):
        return None
    program = shutil.which("Xvfb")
    if program is None:
        sys.exit("soak: no DISPLAY and no Xvfb")
    read_end, write_end = os.pipe()
    command = [program, "-displayfd", str(write_end), "-screen", "0", "1600x1000x24", "-nolisten", "tcp"]
    server = subprocess.Popen(command, pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        os.environ.update(DISPLAY=f":{answer.readline().strip()}", LIBGL_ALWAYS_SOFTWARE="1")
    os.environ.pop("WAYLAND_DISPLAY", None)
    return server


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=120.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--core", type=float, help="use at most this share of one processor core, by thinking")
    parser.add_argument("-o", "--output", type=Path, help="also write the figures, a .json file")
    arguments = parser.parse_args()
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    server = _with_display()
    try:
        with tempfile.TemporaryDirectory(prefix="relight-soak-") as folder:
            seconds = 60 * arguments.minutes
            soak = Soak(Path(folder), arguments.seed, arguments.core)
            logging.getLogger().addHandler(_Log(soak))
            soak.run(seconds, lambda: _write(arguments.output, summary(soak, seconds)))
            figures = summary(soak, seconds)
    finally:
        if server is not None:
            server.terminate()
            server.wait()
    _write(arguments.output, figures)
    del figures["memory_each_mb"]
    print(json.dumps(figures, indent=2))
    return 0 if all(figures["verdicts"].values()) else 1


if __name__ == "__main__":
    sys.exit(main())
