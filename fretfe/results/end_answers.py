# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers by sub-models at and near the free ends of a run, from their folders."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

from fretfe._typing import Array
from fretfe.errors import OutputError
from fretfe.evaluate.contacts import Station
from fretfe.files import replace_text, writing
from fretfe.report.texts import with_error
from fretfe.results.front_ends import FrontEnd, end_beside
from fretfe.results.model import Result
from fretfe.results.reader import load_result, read_numbers, restored
from fretfe.results.run_folder import KEY, with_digest
from fretfe.results.writer import ANSWER, ENDS, NUMBERS, json_text, plain


@dataclass(frozen=True)
class EndNumber:
    """A number of `Rows` over a length from the end, with error bars.

    Attributes:
        name: in `Rows`.
        largest: of all rows there.
        mean: over the length.
        exponent: m of the power distance^-m by which it grows towards the end; NaN if not known.
        grows: whether it grows like a power, so that the largest value is one of the elements.
    """

    name: str
    largest: float
    largest_spread: float
    mean: float
    mean_spread: float
    exponent: float
    exponent_spread: float
    grows: bool


@dataclass(frozen=True)
class Compared:
    """A number by the run and by a sub-model, each with its error bar; NaN where it has none."""

    run: float
    run_spread: float
    part: float
    part_spread: float

    @property
    def agrees(self) -> bool:
        """False if the two are known and differ by more than both error bars together."""
        missing = abs(self.run - self.part) - math.hypot(self.run_spread, self.part_spread)
        return not missing > 0


@dataclass(frozen=True)
class Meeting:
    """A station of the run where a sub-model has its numbers, too.

    Attributes:
        station: its name.
        distance: from the end.
        k_range: |ΔK|.
        k_n: K_N.
    """

    station: str
    distance: float
    k_range: Compared
    k_n: Compared

    @property
    def agrees(self) -> bool:
        """True if neither number differs."""
        return self.k_range.agrees and self.k_n.agrees


@dataclass(frozen=True)
class EndAnswer:
    """Numbers at and near a free end of a front by two sub-models.

    Attributes:
        name: of the end.
        point: (3,) its place.
        distance: (n,) of the stations of the finer sub-model from the end, increasing.
        k_range, k_range_spread: (n,) |ΔK| there, with its error bar, as far as it means something.
        k_n, k_n_spread: (n,) K_N there; NaN where there is none.
        coarser: (n,) |ΔK| by the coarser sub-model.
        exponent, exponent_spread: m of the power distance^-m by which it grows, as of `EndNumber`.
        length: over which numbers next to the end are taken.
        numbers: of the nodes over that length.
        meetings: with stations of the run, those nearest to the end first.
    """

    name: str
    point: Array
    distance: Array
    k_range: Array
    k_range_spread: Array
    k_n: Array
    k_n_spread: Array
    coarser: Array
    exponent: float
    exponent_spread: float
    length: float
    numbers: tuple[EndNumber, ...]
    meetings: tuple[Meeting, ...]


def read_answers(run: Result) -> list[EndAnswer]:
    """Numbers at free ends of a run, from the folders of their sub-models in its own.

    Raises:
        OutputError: if a file cannot be read.
    """
    found = sorted((run.directory / ENDS).glob(f"*/{ANSWER}")) if run.directory else []
    return [_read(path) for path in found]


def beside_end(run: Result, station: Station) -> str:
    """Place of a station near a free end, and |ΔK| by sub-models there; empty farther away."""
    end = end_beside(run, station)
    if end is None:
        return f"a free end is {station.to_end:.3g} away" if station.end else ""
    return f"the free end {end.name} is {station.to_end:.3g} away{nearest_range(run, end)}"


def nearest_range(run: Result, end: FrontEnd) -> str:
    """|ΔK| nearest to an end by its sub-models, in words; empty if there are none."""
    found = (each for each in read_answers(run) if each.name == end.name and len(each.distance))
    return "".join(
        f" (by its sub-models |ΔK| is {with_error(each.k_range[0], each.k_range_spread[0])} "
        f"{run.unit('k_t')} {each.distance[0]:.3g} {run.case.units.length} from it)"
        for each in found
    )


def meeting_at(run: Result, station: str) -> Meeting | None:
    """Numbers at a station by sub-models; None if there are none."""
    met = (each for answer in read_answers(run) for each in answer.meetings)
    return next((each for each in met if each.station == station), None)


def write_headline(directory: Path) -> None:
    """Write the first lines of a run anew: what sub-models found is in them.

    Raises:
        OutputError: if the folder has no results, or they cannot be written.
    """
    numbers, result = read_numbers(directory), load_result(directory)
    others = {key: value for key, value in numbers.items() if key != KEY}
    headline = plain(result.headline, "headline")
    with writing(directory / NUMBERS, "the first lines"):
        text = json_text(with_digest({**others, "headline": headline}))
        replace_text(directory / NUMBERS, text + "\n")


def _read(path: Path) -> EndAnswer:
    try:
        return restored(EndAnswer, json.loads(path.read_text("utf-8")))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise OutputError(f"{path}: expected what sub-models found at an end: {error}") from error


def both_ways(met: Meeting) -> str:
    """The numbers of a run and of a sub-model at a station, in words."""
    return ", ".join(
        f"{symbol} {with_error(each.run, each.run_spread)} and "
        f"{with_error(each.part, each.part_spread)}"
        for symbol, each in (("|ΔK|", met.k_range), ("K_N", met.k_n))
        if math.isfinite(each.run) and math.isfinite(each.part)
    )
