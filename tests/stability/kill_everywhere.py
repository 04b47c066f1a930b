"""Kill writers at every step they take on disk: what was there before is there still, or the new is, whole.

    python tests/stability/kill_everywhere.py

For each kind of file a child process is forked, which writes over an old one and is killed with SIGKILL just
before its first open, rename, flush or removal below the folder; another is killed before its second, and so on
until one ends by itself. Further children meet a full disk and a folder they may not write to. Prints one JSON
object, the number of places each kind was killed at; the first file that is neither old nor new ends it with 1.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenEXR
import torch

_ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(_ROOT), str(_ROOT / "tests"), str(_ROOT / "tests/fuzz")]

from app.document.autosave import Autosave, KeptFile, RunLock, leftovers  # noqa: E402
from app.document.document import Document, PhotoRef  # noqa: E402
from app.document.session_file import read_session, write_session  # noqa: E402
from app.engine.batch import is_done, relight_each  # noqa: E402
from app.engine.turntable import write_pictures  # noqa: E402
from app.settings import Settings, read_settings, write_settings  # noqa: E402
from relight_core.errors import InputError  # noqa: E402
from relight_core.imaging.read import read_photo  # noqa: E402
from relight_core.imaging.write import write_image  # noqa: E402
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle  # noqa: E402
from relight_core.pipeline.edit import Edit  # noqa: E402

# A fork has none of its parent's threads, for which OpenEXR and PyTorch would wait.
OpenEXR.set_global_thread_count(0)
torch.set_num_threads(1)

_WRITES = {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link", "os.truncate", "os.chmod"}
_REFUSED, _BROKEN = 3, 4
_FULL_BYTES = 60
_NOBODY = 65534


@dataclass(frozen=True)
class Kind:
    """Something that is written.

    Attributes:
        write: the old one (False) or the new one (True), into a folder.
        holds: which of the two the folder holds now; raises, or is None, where it is neither.
    """

    write: Callable[[Path, bool], object]
    holds: Callable[[Path], bool | None]


def _value(new: bool) -> float:
    return 0.75 if new else 0.25


def _picture(suffix: str) -> Kind:
    noise = np.random.default_rng(0).random((40, 60, 3)).astype(np.float32) * 0.01

    def holds(folder: Path) -> bool:
        return bool(read_photo(folder / f"picture{suffix}").linear.mean() > 0.5)

    return Kind(lambda folder, new: write_image(folder / f"picture{suffix}", noise + _value(new)), holds)


def _document(folder: Path, new: bool) -> Document:
    photo = folder.parent / "photo.png"
    if not photo.exists():
        write_image(photo, np.full((4, 4, 3), 0.5, np.float32))
    return Document(PhotoRef(photo), edit=Edit(quality="final", yaw_deg=100 * _value(new)))


def _session() -> Kind:
    def holds(folder: Path) -> bool:
        return read_session(folder / "a.relight.json").document.edit.yaw_deg == 75

    return Kind(lambda folder, new: write_session(folder / "a.relight.json", _document(folder, new)), holds)


def _autosave() -> Kind:
    def write(folder: Path, new: bool) -> None:
        autosave = Autosave(folder, lambda act: act())
        document, file = _document(folder, new), KeptFile(RunLock(folder))
        file.path = folder / "kept.json"
        autosave._files[document.photo.path.absolute()] = file
        autosave.update(document, True, 0.0)
        autosave.flush()
        if autosave.problem:
            raise InputError(autosave.problem)

    def holds(folder: Path) -> bool:
        (left,) = leftovers(folder)
        return left.document.edit.yaw_deg == 75

    return Kind(write, holds)


def _settings() -> Kind:
    def write(folder: Path, new: bool) -> None:
        if not write_settings(folder / "settings.json", Settings(window_size=(800, int(1000 * _value(new))))):
            raise InputError("told in the log")

    def holds(folder: Path) -> bool:
        return {(800, 750): True, (800, 250): False}[read_settings(folder / "settings.json").window_size]

    return Kind(write, holds)


def _weights() -> Kind:
    def write(folder: Path, new: bool) -> None:
        bundle = NetworkBundle(BundleConfig.tiny())
        bundle.card = {"which": "new" if new else "old"}
        save_bundle(folder / "w.safetensors", bundle)

    return Kind(write, lambda folder: load_bundle(folder / "w.safetensors").card["which"] == "new")


def _training_state() -> Kind:
    from fuzz_corpus import training

    from relight_core.training.state import Progress, load_state, make_state

    def write(folder: Path, new: bool) -> None:
        state = make_state({"stage": "outline", "size": 64}, Progress(step=int(100 * _value(new))), *training())
        state.write(folder / "run.safetensors")

    def holds(folder: Path) -> bool:
        return load_state(folder / "run.safetensors", {"stage": "outline", "size": 64}, *training()).step == 75

    return Kind(write, holds)


def _batch() -> Kind:
    """Three photos, old results of which are replaced; then the batch is taken up again and ends."""
    names = ("a.png", "b.png", "c.png")

    def one(new: bool) -> Callable[[Path, Path], None]:
        return lambda _photo, output: write_image(output, np.full((8, 8, 3), _value(new), np.float32))

    def write(folder: Path, new: bool) -> None:
        photos = [folder.parent / name for name in names]
        for photo in photos:
            if not photo.exists():
                photo.touch()
        for outcome in relight_each([(photo, folder / photo.name) for photo in photos], one(new)):
            if outcome.state == "failed":
                raise InputError(outcome.error)

    def holds(folder: Path) -> bool:
        values = [read_photo(folder / name).linear.mean() > 0.5 for name in names]
        assert values == sorted(values, reverse=True), "a later result is new and an earlier one old"
        (folder / "b.png").unlink()
        tasks = [(folder.parent / name, folder / name) for name in names]
        states = [outcome.state for outcome in relight_each(tasks, one(True), kept_if=is_done)]
        assert states == ["kept", "written", "kept"], states
        return all(values)

    return Kind(write, holds)


def _write_frame(path: Path, frame: np.ndarray) -> None:
    write_image(path, frame / np.float32(255))


def _numbered_pictures() -> Kind:
    def write(folder: Path, new: bool) -> None:
        if new:
            frames = (np.full((4, 4, 3), index, np.uint8) for index in range(3))
            write_pictures(folder / "turn", frames, 3, lambda done, count: None, _write_frame)

    def holds(folder: Path) -> bool:
        if not (folder / "turn").exists():
            return False
        return sorted(os.listdir(folder / "turn")) == ["0001.png", "0002.png", "0003.png"] or None

    return Kind(write, holds)


def kinds() -> dict[str, Kind]:
    """Everything the program writes, by name."""
    return {
        **{suffix[1:]: _picture(suffix) for suffix in (".png", ".jpg", ".tif", ".exr")},
        "session": _session(),
        "autosave": _autosave(),
        "settings": _settings(),
        "weights": _weights(),
        "training state": _training_state(),
        "batch": _batch(),
        "numbered pictures": _numbered_pictures(),
    }


def _die_before(step: int, folder: Path) -> None:
    """From now on count what this process does below the folder, and end it before the given one."""
    left = [step]

    def count() -> None:
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        left[0] -= 1

    def hook(event: str, arguments: tuple) -> None:
        if event in _WRITES and str(arguments[0]).startswith(str(folder)):
            count()

    flush = os.fsync
    os.fsync = lambda descriptor: (count(), flush(descriptor))[1]
    sys.addaudithook(hook)


def _in_child(act: Callable[[], object]) -> int:
    """Exit status of a fork: 0 done, _REFUSED an InputError, _BROKEN anything else, or minus the signal."""
    child = os.fork()
    if child == 0:
        code = _BROKEN
        try:
            act()
            code = 0
        except InputError as error:
            code = _REFUSED if "\n" not in str(error) else _BROKEN
        except BaseException as error:
            print(repr(error), file=sys.stderr)
        finally:
            os._exit(code)
    status = os.waitpid(child, 0)[1]
    return -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)


def _fresh(kind: Kind, scratch: Path) -> Path:
    folder = scratch / "folder"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    kind.write(folder, False)
    return folder


def kill_everywhere(kind: Kind, scratch: Path) -> int:
    """At how many places the writer was killed."""
    step = 0
    while True:
        folder = _fresh(kind, scratch)
        code = _in_child(lambda: (_die_before(step, folder), kind.write(folder, True)))  # noqa: B023
        odd = [path.name for path in folder.iterdir() if path.name.startswith(".") and not path.name.endswith(".part")]
        assert not odd, odd
        holds = kind.holds(folder)
        assert holds is not None, f"neither old nor new after step {step}"
        if code != -signal.SIGKILL:
            assert code == 0, f"ended with {code}"
            assert holds, "not new although nothing went wrong"
            return step
        step += 1


def fill_the_disk(kind: Kind, scratch: Path) -> None:
    """No file may grow beyond some hundred bytes: the writer says so, and the old file is there."""

    def write() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (_FULL_BYTES, _FULL_BYTES))
        kind.write(folder, True)

    folder = _fresh(kind, scratch)
    code = _in_child(write)
    assert code == _REFUSED, f"a full disk: ended with {code}"
    assert kind.holds(folder) is False, "the old file is gone"


def lock_the_folder(kind: Kind, scratch: Path) -> None:
    """The folder is read-only, and its files are: the same."""

    def write() -> None:
        if os.getuid() == 0:
            os.setuid(_NOBODY)
        kind.write(folder, True)

    folder = _fresh(kind, scratch)
    folder.chmod(0o555)
    code = _in_child(write)
    folder.chmod(0o755)
    assert code == _REFUSED, f"a read-only folder: ended with {code}"
    assert kind.holds(folder) is False, "the old file is gone"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    there = kinds()
    parser.add_argument("names", nargs="*", help=f"kinds to attack, of {', '.join(there)}; all by default")
    wanted = parser.parse_args().names
    if unknown := [name for name in wanted if name not in there]:
        parser.error(f"{unknown[0]!r} is none of {', '.join(there)}")  # Else nothing would be attacked, and all well.
    counts = {}
    with tempfile.TemporaryDirectory() as place:
        os.chmod(place, 0o755)
        for name, kind in there.items():
            if wanted and name not in wanted:
                continue
            scratch = Path(place) / name
            scratch.mkdir()
            try:
                counts[name] = kill_everywhere(kind, scratch)
                fill_the_disk(kind, scratch)
                lock_the_folder(kind, scratch)
            except Exception as error:
                print(f"{name}: {error!r}", file=sys.stderr)
                return 1
    print(json.dumps(counts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
