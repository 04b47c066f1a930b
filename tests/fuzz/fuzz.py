"""Feed every reader damaged files: nothing but InputError may come out, quickly and in bounded memory.

    python tests/fuzz/fuzz.py                          # 10,000 files a reader
    python tests/fuzz/fuzz.py --readers photo exr --count 500 --seed 1

Each reader works in a process of its own with a limit on its memory. A file that raises anything else than
InputError, takes more than 5 s of processor time, exhausts the memory or kills the process is kept under
--keep, and the next one follows. Exit code 1 if there was one.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import sys
import tempfile
import time
import traceback
import warnings
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

_HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(_HERE.parents[1]), str(_HERE.parent), str(_HERE)]

from fuzz_corpus import Reader, readers  # noqa: E402
from fuzz_mutations import damaged  # noqa: E402

from relight_core.errors import InputError  # noqa: E402

MEMORY_GIB = 8
SLOWEST_S = 5.0
_HUNG_S = 60.0


def mutant(seeds: list[bytes], seed: int, number: int) -> bytes:
    """The damaged file of a number; the same whenever it is asked for."""
    rng = np.random.default_rng([seed, number])
    return damaged(seeds[rng.integers(len(seeds))], rng)


def attack(reader: Reader, seed: int, first: int, count: int, folder: Path, report: Connection) -> None:
    """The child's work: say each file's number before it is read, and after it what went wrong."""
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_GIB << 30, MEMORY_GIB << 30))
    path = folder / f"mutant{reader.suffix}"
    for number in range(first, first + count):
        path.write_bytes(mutant(reader.seeds, seed, number))
        report.send((number, None))
        before, fault = time.process_time(), None
        try:
            reader.read(path)
        except InputError:
            pass
        except BaseException:
            fault = traceback.format_exc(limit=-3)
        spent = time.process_time() - before
        if spent > SLOWEST_S:
            fault = f"{spent:.1f} s of processor time\n{fault or ''}"
        if fault:
            report.send((number, fault))
    report.send((first + count, None))


def fuzz_reader(reader: Reader, count: int, seed: int) -> dict[int, str]:
    """All faults of one reader, by number of the file."""
    faults: dict[int, str] = {}
    number = 0
    while number < count:
        ours, theirs = multiprocessing.Pipe(duplex=False)
        with tempfile.TemporaryDirectory(prefix="relight-fuzz-") as folder:
            arguments = (reader, seed, number, count - number, Path(folder), theirs)
            child = multiprocessing.get_context("fork").Process(target=attack, args=arguments)
            child.start()
            theirs.close()
            number = _follow(ours, child, number, faults)
            child.kill()
            child.join()
        if number < count:
            number += 1
    return faults


def _follow(report: Connection, child: multiprocessing.Process, number: int, faults: dict[int, str]) -> int:
    """Read the child's report to its end; the number of the file at which it ended or hung."""
    while True:
        if not report.poll(_HUNG_S):
            faults[number] = f"no answer within {_HUNG_S:g} s"
            return number
        try:
            number, fault = report.recv()
        except EOFError:
            child.join()
            if child.exitcode != 0:
                faults[number] = f"the process died ({child.exitcode})"
            return number
        if fault:
            faults[number] = fault


def main() -> int:
    with tempfile.TemporaryDirectory() as scratch:
        corpus = readers(Path(scratch))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--readers", nargs="+", choices=list(corpus), default=list(corpus))
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for the files that did harm")
    arguments = parser.parse_args()
    bad = 0
    for name in arguments.readers:
        faults = fuzz_reader(corpus[name], arguments.count, arguments.seed)
        bad += len(faults)
        print(f"{name}: {arguments.count} files, {len(faults)} faults", flush=True)
        for number, fault in sorted(faults.items()):
            print(f"--- {name} {number}\n{fault}", flush=True)
            if arguments.keep:
                arguments.keep.mkdir(parents=True, exist_ok=True)
                place = arguments.keep / f"{name}-{number}{corpus[name].suffix}"
                place.write_bytes(mutant(corpus[name].seeds, arguments.seed, number))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
