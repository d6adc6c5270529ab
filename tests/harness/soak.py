# SPDX-License-Identifier: LGPL-3.0-or-later
"""`cd tests; python -m harness.soak [COUNT]`: many small runs in one process, and what is left.

Finite elements in most of them, half-planes and files in every tenth, a report in every hundredth.
Memory, open files and communicators are those after the first hundred runs, by which caches are
full, and at the end.
"""

from __future__ import annotations

import gc
import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpi4py import MPI

import matplotlib.pyplot as plt
from cases.pad_cases import press
from faults.originals import PAD

import fretfe
from fretfe.case import Case, parse_case
from fretfe.runner import draw_report

COUNT, WARM = 2000, 100
HALFPLANE, FILES, REPORT = 10, 10, 100
# One step of pressing: the smallest run that there is.
SMALLEST: dict[str, Any] = {**PAD, "loads": {"press": press(steps=1)}, "contacts": {
    "main": {**PAD["contacts"]["main"], "friction_from": 0.0}
}}  # fmt: skip


@dataclass(frozen=True)
class Held:
    """What the process holds: memory in MB, open files, free communicators, figures."""

    memory: float
    files: int
    communicators: int
    figures: int


def held() -> Held:
    """What the process holds now."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    memory = pages * os.sysconf("SC_PAGE_SIZE") / 1e6
    files = len(list(Path("/proc/self/fd").iterdir()))
    return Held(memory, files, free_communicators(), len(plt.get_fignums()))


def free_communicators(most: int = 3000) -> int:
    """How many communicators can still be made, up to a number."""
    handler = MPI.COMM_WORLD.Get_errhandler()
    MPI.COMM_WORLD.Set_errhandler(MPI.ERRORS_RETURN)
    made: list[MPI.Comm] = []
    try:
        while len(made) < most:
            made.append(MPI.COMM_WORLD.Dup())
    except MPI.Exception:
        pass
    finally:
        for each in made:
            each.Free()
        MPI.COMM_WORLD.Set_errhandler(handler)
    return len(made)


def one_run(number: int, case: Case, folder: Path) -> None:
    """One of the runs."""
    backend = "halfplane" if number % HALFPLANE == 5 else "fem"
    output = folder / backend if number % FILES == 0 else None
    fretfe.run(case, backend, output)
    if number % REPORT == 0:
        assert not draw_report(folder / backend).problems


def soak(count: int) -> tuple[Held, Held]:
    """What is held after the first runs, and after all."""
    case = parse_case(SMALLEST)
    with tempfile.TemporaryDirectory() as name:
        for number in range(WARM):
            one_run(number, case, Path(name))
        first = held()
        for number in range(WARM, count):
            one_run(number, case, Path(name))
            if (number + 1) % 50 == 0:
                print(number + 1, held(), flush=True)
    return first, held()


if __name__ == "__main__":
    before, after = soak(int(sys.argv[1]) if len(sys.argv) > 1 else COUNT)
    print(f"after {WARM} runs: {before}\nat the end: {after}")
