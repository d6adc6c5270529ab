# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders of several kinds beside an input, and outputs that cannot be written."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

from faults.fault import Prepare, damaged

# Folders with results; `originals` writes them.
RUNS = (
    "run", "solid", "incomplete", "no_cycle", "metres", "slippery", "other_load",
)  # fmt: skip
Work = Callable[[Path], object]


def with_runs(*works: Work) -> Prepare:
    """Copies of all results, then what changes them or writes further files."""

    def write(good: Path, here: Path) -> None:
        for name in RUNS:
            shutil.copytree(good / name, here / name)
        for work in works:
            work(here)

    return write


def blocked(name: str) -> Work:
    """A folder in place of a file of the output folder."""

    def make(here: Path) -> None:
        (here / "out" / name).mkdir(parents=True)
        (here / "out" / name / "keep").write_text("mine")

    return make


def damage(name: str, seed: int) -> Work:
    """Mistakes in one of the files of a folder with results."""

    def change(here: Path) -> None:
        path = here / name / ("results.json", "results.h5")[seed % 2]
        path.write_bytes(damaged(path.read_bytes(), seed))

    return change


def _nothing(here: Path) -> None:
    """The output needs no preparation."""


# Name, output as given, and what is there before.
OUTPUTS: tuple[tuple[str, str, Work], ...] = (
    ("a file", "out", lambda here: (here / "out").write_text("mine")),
    ("a pipe", "out", lambda here: os.mkfifo(here / "out")),
    ("a link to nothing", "out", lambda here: (here / "out").symlink_to("/proc/nothing/here")),
    ("a folder below a file", "out/deeper", lambda here: (here / "out").write_text("mine")),
    ("a device", "/dev/null", _nothing),
    ("a folder of the kernel", "/proc/fretfe", _nothing),
    ("the folder of the results", "run", _nothing),
    ("other results", "other_load", _nothing),
    ("a name of 5000", "x" * 5000, _nothing),
)
