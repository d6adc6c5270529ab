# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads of an Abaqus or CalculiX input file through its steps, as histories of a case."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from fretfe._typing import Array
from fretfe.mesh.inp_cards import Card, real
from fretfe.mesh.inp_groups import SAME

TomlTable = dict[str, Any]


class Amplitude(NamedTuple):
    """Factors (values, if absolute) over the time of the step, or of all steps (total)."""

    times: list[float]
    values: list[float]
    total: bool
    absolute: bool

    def at(self, time: float) -> float:
        """Factor at a time."""
        return float(np.interp(time, self.times, self.values))


def read_amplitude(card: Card) -> dict[str, Amplitude]:
    """The amplitude of a card, by its name.

    Raises:
        ValueError: it is no table of increasing times.
    """
    if (kind := card.choice("DEFINITION", "TABULAR", "PERIODIC")) != "TABULAR":
        raise ValueError(f"expected a table, found DEFINITION={kind}")
    numbers = [real(value) for row in card.rows for value in row if value]
    times, values = numbers[::2], numbers[1::2]
    if len(times) != len(values) or not times or any(b < a for a, b in pairwise(times)):
        raise ValueError("expected pairs of increasing times and values")
    total = card.choice("TIME", "STEPTIME", "TOTALTIME") == "TOTALTIME"
    absolute = card.choice("VALUE", "RELATIVE", "ABSOLUTE") == "ABSOLUTE"
    return {card.required("NAME"): Amplitude(times, values, total, absolute)}


class Step(NamedTuple):
    """A static step: when it begins and ends, its first increment, whether loads jump."""

    number: int
    begin: float
    end: float
    increment: float
    jumps: bool


@dataclass
class Channel:
    """A scalar load through the steps.

    Attributes:
        word: keyword that it is from.
        place: file and line.
        table: of the case, but for its history.
        since: time from which on it acts.
        points: times, values, and load steps up to there.
        led: value and amplitude over the time of all steps, which later steps follow.
    """

    word: str
    place: str
    table: TomlTable
    since: float
    points: list[tuple[float, float, int]] = field(default_factory=list)
    led: tuple[float, Amplitude] | None = None

    @property
    def value(self) -> float:
        """Value at the end of what was read."""
        return self.points[-1][1] if self.points else 0.0

    def go(self, step: Step, value: float, amplitude: Amplitude | None) -> None:
        """Take the points of a step at whose end, or by whose amplitude, it has a value."""
        if not self.points or self.points[-1][0] < step.begin:
            self.points.append((step.begin, self.value, 1))
        points = [(step.end, value)]
        self.led = (value, amplitude) if amplitude is not None and amplitude.total else None
        if amplitude is not None:
            zero = 0.0 if amplitude.total else step.begin
            scale = 1.0 if amplitude.absolute else value
            first = step.begin
            begin = scale * amplitude.at(step.begin - zero)
            if not math.isclose(begin, self.value, rel_tol=SAME, abs_tol=SAME * abs(scale)):
                first = min(step.begin + step.increment, step.end)
            inside = {zero + time for time in amplitude.times} | {first}
            times = sorted(
                time for time in inside if step.begin < time and first <= time < step.end
            )
            points = [(time, scale * amplitude.at(time - zero)) for time in [*times, step.end]]
        elif step.jumps:
            points.insert(0, (min(step.begin + step.increment, step.end), value))
        for time, level in points:
            before = self.points[-1][0]
            if time > before:
                part = (time - before) / step.increment
                self.points.append((time, level, max(1, math.ceil(part * (1 - 1e-9)))))

    def go_on(self, step: Step) -> None:
        """Take the points of a step that does not name the load."""
        if self.led is not None:
            self.go(step, *self.led)

    def history(self) -> list[TomlTable]:
        """Its segments."""
        return [
            {"hold": True, "until": _short(time), "steps": steps}
            if value == before
            else {"ramp": _short(value), "until": _short(time), "steps": steps}
            for (_, before, _), (time, value, steps) in pairwise([(0.0, 0.0, 1), *self.points])
            if time > 0.0
        ]


def _short(value: float) -> float:
    """A number without what round-off adds."""
    return float(f"{value:.12g}")


def repeated(channels: Sequence[Channel]) -> tuple[float, float] | None:
    """Begin and end of the last time that loads run through all they run through again and again.

    Of all spans between two times at which all loads stand alike, that is the shortest one in which
    they vary as much as in any, and the last of these: a ramp before the first cycle is no part of
    it. None if the loads end without any, as a mission does, or never return.
    """
    times = np.array(sorted({0.0} | {time for each in channels for time, *_ in each.points}))
    values = np.zeros((len(times), len(channels)))
    for place, each in enumerate(channels):
        known, levels, _ = zip((0.0, 0.0, 1), *each.points, strict=True)
        values[:, place] = np.interp(times, known, levels)
    size = np.abs(values).max(axis=0, initial=0.0)
    values = values / np.where(size > 0, size, 1.0)
    if (np.abs(values[-1]) <= SAME).all():
        return None

    def ranges(begin: int, end: int) -> Array:
        return np.asarray(np.ptp(values[begin : end + 1], axis=0))

    stand = np.unique(np.rint(values / SAME), axis=0, return_inverse=True)[1].ravel()
    returns = [np.flatnonzero(stand == load).tolist() for load in np.unique(stand)]
    widest = max((ranges(ends[0], ends[-1]) for ends in returns), key=np.sum)
    if not (widest > SAME).any():
        return None
    spans = []
    for ends in returns:
        for place, end in enumerate(ends):
            wide = (n for n in ends[:place][::-1] if (ranges(n, end) >= widest - SAME).all())
            if (ranges(ends[0], end) >= widest - SAME).all():
                spans.append((next(wide), end))
    begin, end = min(spans, key=lambda span: (_short(times[span[1]] - times[span[0]]), -span[1]))
    return _short(times[begin]), _short(times[end])
