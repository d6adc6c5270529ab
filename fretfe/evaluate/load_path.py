# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads between the steps of a cycle, and factors there.

The loads are known at any time, edge factors only at the ends of steps. Within a step a factor
leaves the straight line between its ends by as much as the loads leave theirs, times what a unit of
each load changes it by in this cycle (least squares over its steps; exact for factors that are
linear in the loads, as at a constant contact area).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.loads.history import within_steps

# Loads that leave the straight line by less than this part of their range are lines.
STRAIGHT = 1e-9


def straight(values: Array, times: Array) -> Array:
    """Values (T,) of all states at times, which are numbers of states and shares of steps."""
    before, after = np.floor(times).astype(np.int64), np.ceil(times).astype(np.int64)
    within = values[before] + (times - before) * (values[after] - values[before])
    return np.where(after > before, within, values[before])


def filled(values: Array) -> Array:
    """(T,) values of which those that are not known lie between their neighbours."""
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        return values
    return np.asarray(np.interp(np.arange(len(values)), known, values[known]))


@dataclass(frozen=True)
class LoadPath:
    """The loads of n steps, such as those of a cycle, at their ends and at S places within each.

    Attributes:
        first: state in which they begin.
        steps: (n, C) increments of the steps over the range of each load.
        bulges: (n, S, C) deviation from the straight line within each step, over the same.
    """

    first: int
    steps: Array
    bulges: Array

    @property
    def times(self) -> Array:
        """The instants to the last of the steps, as of `straight`."""
        count, inner, _ = self.bulges.shape
        within = np.arange(count * (inner + 1) + 1) / (inner + 1)
        return np.append(np.arange(self.first), self.first + within)

    def at(self, values: Array, times: Array) -> Array:
        """Values (T,) of all states, to the last of the steps, at times as of `straight`."""
        own = slice(self.first, self.first + len(self.bulges))
        steps, inner = np.diff(values), self.bulges.shape[1]
        if not np.isfinite(steps[own]).all():
            return np.full(len(times), np.nan)
        slopes = np.linalg.lstsq(self.steps, steps[own], rcond=None)[0]
        between = values[:-1, None] + steps[:, None] * np.arange(1, inner + 1) / (inner + 1)
        between[own] += self.bulges @ slopes
        ends = np.ceil(times).astype(np.int64)
        return within_steps(values[:, None], between[..., None], ends, 1 - (ends - times))[:, 0]


def excess(factor: Array, path: LoadPath | None) -> float:
    """Excess of a factor (T,) between the steps of a cycle over its range at them; 0 if unknown."""
    if path is None:
        return 0.0
    ends = factor[path.first : path.first + len(path.bulges) + 1]
    fine = path.at(factor[: path.first + len(ends)], path.times[path.first :])
    return float(np.ptp(fine) - np.ptp(ends)) if np.isfinite(fine).all() else 0.0


def load_path(
    loads: Array, between: Array | None, cycle: tuple[int, int] | None
) -> LoadPath | None:
    """The loads of a cycle between its steps; None if they are straight lines there, or not known.

    Args:
        loads: (T, C) at the states.
        between: (T-1, S, C) within all steps, or None.
        cycle: its first and last state, or None.
    """
    if cycle is None or between is None:
        return None
    first, last = cycle
    values, between = loads[first : last + 1], between[first:last]
    shares = np.arange(1, between.shape[1] + 1) / (between.shape[1] + 1)
    steps = np.diff(values, axis=0)
    bulges = between - values[:-1, None] - shares[:, None] * steps[:, None]
    ranges = np.ptp(values, axis=0)
    varying = ranges > 0
    bulges = np.where(varying, bulges, 0.0) / np.where(varying, ranges, 1.0)
    if not np.abs(bulges).max(initial=0.0) > STRAIGHT:
        return None
    return LoadPath(first, steps / np.where(varying, ranges, 1.0), bulges)
