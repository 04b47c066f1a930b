"""Feed every reader damaged files: nothing but InputError may come out, quickly and in bounded memory.

    python tests/fuzz/fuzz.py                          # 10,000 files a reader
    python tests/fuzz/fuzz.py --readers photo exr --count 500 --seed 1

Each reader works in a process of its own with a limit on its memory. A file that raises anything else than
InputError, takes more than 5 s of processor time, takes more than 1 GiB of memory or kills the process is kept
under --keep, and the next one follows. Exit code 1 if there was one.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import multiprocessing
import os
import resource
import sys
import tempfile
import time
import traceback
import warnings
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import OpenEXR

_HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(_HERE.parents[1]), str(_HERE.parent), str(_HERE)]

from fuzz_corpus import Reader, readers  # noqa: E402
from fuzz_mutations import damaged  # noqa: E402

from app.engine.freed_memory import give_back_freed_memory  # noqa: E402
from relight_core.errors import InputError  # noqa: E402

# A fork has none of its parent's threads, for which OpenEXR would wait.
OpenEXR.set_global_thread_count(0)

ADDRESSES_GIB = 6
"""What a process may reserve beyond what it begins with; libraries, and tests that ran before, reserved that."""

LARGEST_MIB = 1024
SLOWEST_S = 5.0
_HUNG_S = 60.0
"""Of processor time, so that a busy machine hangs nothing; of the clock ten times as much."""


@dataclass
class Findings:
    """What became of one reader's files.

    Attributes:
        faults: by the number of the file.
        refused: how many files were refused, as they should be.
        slowest_s: processor time of the slowest file.
        most_mib: memory that reading them took at the most.
    """

    faults: dict[int, str] = field(default_factory=dict)
    refused: int = 0
    slowest_s: float = 0.0
    most_mib: float = 0.0


def mutant(seeds: list[bytes], seed: int, number: int) -> bytes:
    """The damaged file of a number; the same whenever it is asked for."""
    rng = np.random.default_rng([seed, number])
    return damaged(seeds[rng.integers(len(seeds))], rng)


def attack(reader: Reader, seed: int, first: int, count: int, folder: Path, report: Connection) -> None:
    """The child's work: say each file's number before it is read, and after it how that went."""
    warnings.simplefilter("ignore")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    most_addresses = _reserved_bytes() + (ADDRESSES_GIB << 30)
    resource.setrlimit(resource.RLIMIT_AS, (most_addresses, most_addresses))
    path = folder / f"mutant{reader.suffix}"
    _forget_what_was_inherited()
    started_mib = _peak_mib()
    for number in range(first, first + count):
        path.write_bytes(mutant(reader.seeds, seed, number))
        report.send((number, None))
        before, fault, refused = time.process_time(), "", False
        try:
            reader.read(path)
        except InputError:
            refused = True
        except BaseException:
            fault = traceback.format_exc(limit=-3)
        report.send((number, (refused, time.process_time() - before, _peak_mib() - started_mib, fault)))
    report.send((first + count, None))


def fuzz_reader(reader: Reader, count: int, seed: int) -> Findings:
    """Read `count` damaged files in a child process, in further ones where that dies or hangs."""
    findings, number = Findings(), 0
    while number < count:
        ours, theirs = multiprocessing.Pipe(duplex=False)
        with tempfile.TemporaryDirectory(prefix="relight-fuzz-") as folder:
            arguments = (reader, seed, number, count - number, Path(folder), theirs)
            child = multiprocessing.get_context("fork").Process(target=attack, args=arguments)
            child.start()
            theirs.close()
            number = _follow(ours, child, number, findings)
            child.kill()
            child.join()
        if number < count:
            number += 1
    return findings


def _follow(report: Connection, child: multiprocessing.Process, number: int, findings: Findings) -> int:
    """Read the child's report to its end; the number of the file at which it ended or hung."""
    while True:
        if not _answers(report, child.pid):
            findings.faults[number] = f"no answer within {_HUNG_S:g} s"
            return number
        try:
            number, outcome = report.recv()
        except EOFError:
            child.join()
            if child.exitcode != 0:
                findings.faults[number] = f"the process died ({child.exitcode})"
            return number
        if outcome is not None:
            _note(findings, number, *outcome)


def _answers(report: Connection, process: int) -> bool:
    """Whether the child reports before it has worked, or waited, too long."""
    began, spent_s = time.monotonic(), _processor_s(process)
    while not report.poll(1.0):
        if _processor_s(process) - spent_s > _HUNG_S or time.monotonic() - began > 10 * _HUNG_S:
            return False
    return True


def _processor_s(process: int) -> float:
    """What a child has used so far; 0 once it has ended."""
    try:
        user, system = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13]
    except (OSError, ValueError):
        return 0.0
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def _note(findings: Findings, number: int, refused: bool, spent_s: float, grown_mib: float, fault: str) -> None:
    if spent_s > SLOWEST_S:
        fault = f"{spent_s:.1f} s of processor time\n{fault}"
    # The peak never falls again, so only the file that raised it above the limit is at fault.
    if grown_mib > LARGEST_MIB >= findings.most_mib:
        fault = f"{grown_mib:.0f} MiB of memory\n{fault}"
    if fault:
        findings.faults[number] = fault
    findings.refused += refused
    findings.slowest_s = max(findings.slowest_s, spent_s)
    findings.most_mib = max(findings.most_mib, grown_mib)


def _reserved_bytes() -> int:
    """The addresses that this process has (Linux); 0 where nothing tells."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    except OSError:
        return 0


def _peak_mib() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _forget_what_was_inherited() -> None:
    """Keep what a fork left to the collector, and let the peak be what is held now (Linux).

    What the parent's threads and garbage held is in the peak with which a child begins; freed, it would hide as much
    growth, and so would freed memory that the C library kept. To collect the garbage here would take so long as to
    pass for a reader that hangs.
    """
    gc.freeze()
    give_back_freed_memory()
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


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
        found = fuzz_reader(corpus[name], arguments.count, arguments.seed)
        bad += len(found.faults)
        line = f"{name}: {arguments.count} files, {len(found.faults)} faults, {found.refused} refused"
        print(f"{line}, {1e3 * found.slowest_s:.0f} ms and {found.most_mib:.0f} MiB at the most", flush=True)
        for number, fault in sorted(found.faults.items()):
            print(f"--- {name} {number}\n{fault}", flush=True)
            if arguments.keep:
                arguments.keep.mkdir(parents=True, exist_ok=True)
                place = arguments.keep / f"{name}-{number}{corpus[name].suffix}"
                place.write_bytes(mutant(corpus[name].seeds, arguments.seed, number))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
