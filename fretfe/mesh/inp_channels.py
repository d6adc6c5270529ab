# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads of an Abaqus or CalculiX input file through its steps, as histories of a case."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from fretfe.mesh.inp_cards import Card, real
from fretfe.mesh.inp_groups import SAME

TomlTable = dict[str, Any]
# Parameters of an amplitude, their values that are understood, and the others.
KINDS = (
    ("DEFINITION", "TABULAR", "PERIODIC"), ("TIME", "STEPTIME", "TOTALTIME"),
    ("VALUE", "RELATIVE", "ABSOLUTE"),
)  # fmt: skip


class Amplitude(NamedTuple):
    """Factors over the time of the step."""

    times: list[float]
    values: list[float]

    def at(self, time: float) -> float:
        """Factor at a time."""
        return float(np.interp(time, self.times, self.values))


def read_amplitude(card: Card) -> dict[str, Amplitude]:
    """The amplitude of a card, by its name.

    Raises:
        ValueError: it is no table of increasing times, or not of factors over the time of a step.
    """
    for parameter, expected, other in KINDS:
        if (kind := card.choice(parameter, expected, other)) != expected:
            raise ValueError(f"expected {parameter}={expected}, found {parameter}={kind}")
    numbers = [real(value) for row in card.rows for value in row if value]
    times, values = numbers[::2], numbers[1::2]
    if len(times) != len(values) or not times or any(b < a for a, b in pairwise(times)):
        raise ValueError("expected pairs of increasing times and values")
    return {card.required("NAME"): Amplitude(times, values)}


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
    """

    word: str
    place: str
    table: TomlTable
    since: float
    points: list[tuple[float, float, int]] = field(default_factory=list)

    @property
    def value(self) -> float:
        """Value at the end of what was read."""
        return self.points[-1][1] if self.points else 0.0

    def go(self, step: Step, value: float, amplitude: Amplitude | None) -> None:
        """Take the points of a step at whose end, or by whose amplitude, it has a value."""
        if not self.points or self.points[-1][0] < step.begin:
            self.points.append((step.begin, self.value, 1))
        points = [(step.end, value)]
        if amplitude is not None:
            first, begin = step.begin, value * amplitude.at(0.0)
            if not math.isclose(begin, self.value, rel_tol=SAME, abs_tol=SAME * abs(value)):
                first = min(step.begin + step.increment, step.end)
            inside = {step.begin + time for time in amplitude.times} | {first}
            times = sorted(
                time for time in inside if step.begin < time and first <= time < step.end
            )
            points = [
                (time, value * amplitude.at(time - step.begin)) for time in [*times, step.end]
            ]
        elif step.jumps:
            points.insert(0, (min(step.begin + step.increment, step.end), value))
        for time, level in points:
            before = self.points[-1][0]
            if time > before:
                part = (time - before) / step.increment
                self.points.append((time, level, max(1, math.ceil(part * (1 - 1e-9)))))

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
