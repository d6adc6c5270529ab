# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs that are cut off and continued, and their comparison with runs that were not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from harness.told import Told

from fretfe.case import Case
from fretfe.errors import StoppedError
from fretfe.results.model import Result
from fretfe.runner import Runner

# What a run is not to be judged by: when, where and how fast it was.
OTHER = ("seconds", "ranks", "versions", "notes", "digest")
# Differences of numbers that are nearly the same: they magnify round-off.
ERROR_BARS = ("spread", "parts", "change")
# Zero but for round-off, by symmetry.
NOTHING = ("moment", "coordinates", "k_i_range")
# What is smaller counts as that large, in the units of the case: centres and moments that are zero
# but for the round-off of lengths and forces.
LEAST = 1e-3
# Reactions of guides that carry nothing have the round-off of those that carry all.
LEAST_FORCE = 1.0


def cut_and_continued(case: Case, backend: str, folder: Path, steps: int) -> Result:
    """A run that is stopped after some steps, and goes on from there."""
    runner = Runner.find(backend)
    first = runner.run(case, folder, Told(steps))
    assert isinstance(first.failure, StoppedError)
    assert not json.loads((folder / "run.json").read_text())["complete"]
    told = Told()
    result = runner.run(case, folder, told, resume=True)
    assert told.steps[0][0] == steps + 1
    return result


def largest_difference(one: Path, other: Path) -> float:
    """Largest difference of any number of two results folders, relative to the largest beside it.

    Raises:
        AssertionError: if the two are not of the same kind.
    """
    numbers = [json.loads((each / "results.json").read_text()) for each in (one, other)]
    for each in numbers:
        assert each["complete"] is True
        for name in OTHER:
            del each[name]
        if each["steps"] is not None:
            del each["steps"]["certificate"]
    found = [_difference(*numbers)]
    if (one / "results.h5").exists():
        with h5py.File(one / "results.h5") as mine, h5py.File(other / "results.h5") as theirs:
            names: list[str] = []
            mine.visit(names.append)
            for name in names:
                # A certificate measures round-off.
                if isinstance(mine[name], h5py.Dataset) and "/certificate/" not in name:
                    least = LEAST_FORCE if name.endswith("/force") else LEAST
                    found.append(_difference(mine[name][:], theirs[name][:], least))
    return max(found)


def _difference(one: Any, other: Any, least: float = LEAST) -> float:
    if isinstance(one, dict):
        assert list(one) == list(other)
        names = [name for name in one if not name.endswith(ERROR_BARS + NOTHING)]
        return max((_difference(one[name], other[name]) for name in names), default=0.0)
    if isinstance(one, list) and (not one or isinstance(one[0], dict | str | list)):
        assert len(one) == len(other)
        return max(map(_difference, one, other), default=0.0)
    if isinstance(one, list | np.ndarray | float):
        first, second = (np.array(each, dtype=float) for each in (one, other))
        assert np.array_equal(np.isnan(first), np.isnan(second))
        if not first.size or np.isnan(first).all():
            return 0.0
        return float(np.nanmax(np.abs(first - second)) / max(np.nanmax(np.abs(first)), least))
    assert one == other
    return 0.0
