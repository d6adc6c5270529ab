# SPDX-License-Identifier: LGPL-3.0-or-later
"""All loads on one clock, as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, complaint
from fretfe.errors import CaseError
from fretfe.loads.cycle import check_times, find_cycle
from fretfe.loads.segments import SAME_TIME, Piece, read_pieces

# Parts of a step at whose ends the loads are known.
PARTS = 8


@dataclass(frozen=True)
class History:
    """All channels on one clock.

    Attributes:
        channels: names of the loads, in the order of the case file.
        times: (T,) increasing; ``times[0] == 0``.
        values: (T, C), in the units of each load; row 0 is zero: the unloaded state.
        cycle: first and last step index of the cycle that is evaluated, if there is one.
        between: (n, S, C) values at S places within each of the n steps of the cycle, at equal
            distances in time; None without a cycle, or if they are not known.
    """

    channels: tuple[str, ...]
    times: Array
    values: Array
    cycle: tuple[int, int] | None
    between: Array | None = None

    @property
    def evaluated(self) -> tuple[int, int]:
        """First and last state of the evaluated cycle, or of everything without one."""
        return self.cycle or (0, len(self.times) - 1)

    def at(self, time: float) -> Array:
        """Values (C,) at a time, linear between steps and constant after the last one."""
        return np.array([np.interp(time, self.times, column) for column in self.values.T])

    def step(self, time: float) -> int:
        """Index of the step at a time, the nearest one if there is none."""
        return int(np.argmin(np.abs(self.times - time)))


def build_history(case: Case) -> History:
    """Put the histories of all loads on one clock.

    The clock is the sorted union of the step times of all channels. Every channel is evaluated at
    every step, waves exactly, and keeps its value after its last segment.

    Raises:
        CaseError: a segment ends before it starts or does not continue the one before, a table or
            CSV file is not usable, there is no step at all, steps are too close for a history of
            this length, or a time that the case names (friction_from, cycle, output.fields) is not
            the time of a step. Problems of different loads are listed together.
    """
    channels: dict[str, list[Piece]] = {}
    problems: list[str] = []
    for name in case.loads:
        try:
            channels[name] = read_pieces(case, name)
        except CaseError as error:
            problems.append(str(error))
    if problems:
        raise CaseError("\n".join(problems))
    times = _clock([piece for pieces in channels.values() for piece in pieces])
    if len(times) == 1:
        text = "expected a load with at least one step after time 0, found none"
        raise CaseError(complaint(case.source, ("loads",), text))
    _require_apart(case, channels, times[-1])
    values = np.column_stack([_evaluate(pieces, times) for pieces in channels.values()])
    check_times(case, times)
    cycle = find_cycle(case, times, values, channels)
    between = _between(channels, times[cycle[0] : cycle[1] + 1]) if cycle is not None else None
    return History(tuple(channels), times, values, cycle, between)


def _between(channels: Mapping[str, Sequence[Piece]], times: Array) -> Array:
    """(n, S, C) values of all loads within the steps between n + 1 times."""
    shares = np.arange(1, PARTS) / PARTS
    instants = (times[:-1, None] + np.diff(times)[:, None] * shares).ravel()
    values = np.column_stack([_evaluate(pieces, instants) for pieces in channels.values()])
    return values.reshape(len(times) - 1, PARTS - 1, len(channels))


def _clock(pieces: Sequence[Piece]) -> Array:
    """Sorted union of all step times and 0; of times that are the same the earliest is kept."""
    times = np.unique(np.concatenate([np.zeros(1), *(piece.steps for piece in pieces)]))
    tolerance = SAME_TIME * times[-1]
    if len(times) == 1 or np.diff(times).min() > tolerance:
        return times
    kept = [0.0]
    for time in times:
        if time - kept[-1] > tolerance:
            kept.append(float(time))
    return np.array(kept)


def _require_apart(case: Case, channels: Mapping[str, Sequence[Piece]], end: float) -> None:
    """Check that the steps of each segment are not one and the same time on the common clock."""
    for name, pieces in channels.items():
        for index, piece in enumerate(pieces):
            spacing = (piece.end - piece.start) / len(piece.steps)
            if spacing <= SAME_TIME * end:
                text = (
                    f"expected steps more than {SAME_TIME:g} of the whole history apart, found "
                    f"{spacing:.4g} in a history that ends at {end:.4g}: they would be one time"
                )
                raise CaseError(complaint(case.source, ("loads", name, "history", index), text))


def _evaluate(pieces: Sequence[Piece], times: Array) -> Array:
    values = np.zeros_like(times)
    for piece in pieces:
        after = times > piece.start
        values[after] = piece.value(np.minimum(times[after], piece.end))
    return values
