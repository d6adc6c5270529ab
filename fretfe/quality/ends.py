# SPDX-License-Identifier: LGPL-3.0-or-later
"""The free end of a front, by sub-models with elements of two sizes.

Towards the end factors grow, and next to it they mean nothing: there the slip, the friction work
and the tractions of the nodes are all there is. What the two sub-models differ by makes the error
bars: with errors in proportion to the size h of the elements, or falling faster, those of the finer
one are at most r/(1 - r) of the difference, r the ratio of the sizes. Where values grow like a
power of the distance from the end there is no largest one, but a mean over a length.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array
from fretfe.case.base import positive_number
from fretfe.errors import ModelError
from fretfe.files import json_value, replace_text, writing
from fretfe.quality.end_rows import NUMBERS, Rows, rows_at
from fretfe.results.end_answers import Compared, EndAnswer, EndNumber, Meeting, write_headline
from fretfe.results.front_ends import (
    FrontEnd,
    end_near,
    find_end,
    known_numbers,
    known_stations,
    zone_at,
)
from fretfe.results.model import Result
from fretfe.results.quantities import K_N
from fretfe.results.writer import ANSWER
from fretfe.results.writer import NUMBERS as RESULTS

SCHEMA = {"name": "fretfe-end", "version": 3}
# Distances from an end to which powers are fitted, over the length next to it.
FITTED = 4
# Power of the length of elements by which a stress on an end grows at least.
GROWING = 0.05
# Exponent of a stress whose own is not known: at the end of a quarter-plane on a half-plane of the
# same material it is .46 where they stick, .23 without shear, and by friction of .6 none or .48.
MOST_SINGULAR = 0.5


def write_answer(run: Result, answer: EndAnswer, folder: Path) -> Path:
    """Write the numbers at an end.

    Args:
        run: of the whole.
        answer: of one of its free ends.
        folder: for the file.

    Raises:
        OutputError: if it cannot be written.
    """
    numbers = [
        {
            **asdict(each),
            "unit": run.unit(NUMBERS[each.name].kind),
            "meaning": NUMBERS[each.name].meaning,
        }
        for each in answer.numbers
    ]
    table = {"schema": SCHEMA, **asdict(answer), "numbers": numbers}
    path = folder / ANSWER
    with writing(path, "the answer at the end"):
        replace_text(path, json.dumps(json_value(table), indent=1, allow_nan=False) + "\n")
    if run.directory is not None and (run.directory / RESULTS).exists():
        write_headline(run.directory)
    return path


def end_answer(
    run: Result, name: str, fine: Result, coarse: Result, length: float | None = None
) -> EndAnswer:
    """Numbers at and near a free end.

    Args:
        run: of the whole.
        name: of one of its free ends.
        fine: of the part around it.
        coarse: of the same part, with larger elements.
        length: over which numbers next to the end are taken; None for two slip zones.

    Raises:
        ModelError: if a sub-model has no front there.
    """
    end = find_end(run, name)
    assert end is not None and fine.case.geometry.part is not None
    # The error by the cut falls with the fourth power of the distance from it.
    inner = fine.case.geometry.part.radius / 2
    finer, coarser = (_level(each, end, inner) for each in (fine, coarse))
    length = _two_zones(end) if length is None else positive_number("--length", length)
    exponent, exponent_spread = _power(
        *((each.distance, each.k_range) for each in (finer, coarser)), length=length
    )
    found = finer.with_bars(coarser)
    near = found.distance <= inner
    return EndAnswer(
        name=name,
        point=end.point,
        distance=found.distance[near],
        k_range=found.k_range[near],
        k_range_spread=found.k_range_spread[near],
        k_n=found.k_n[near],
        k_n_spread=found.k_n_spread[near],
        coarser=coarser.at(found.distance[near])[0],
        exponent=exponent,
        exponent_spread=exponent_spread,
        length=length,
        numbers=tuple(number_at(each, finer.rows, coarser.rows, length) for each in NUMBERS),
        meetings=tuple(_meetings(end, found)),
    )


@dataclass(frozen=True)
class Level:
    """Numbers near an end by one sub-model.

    Attributes:
        rows: of its nodes.
        distance, k_range, k_range_spread: (n,) of stations with a |ΔK|, increasing.
        k_n, k_n_spread: (n,) K_N there; NaN where there is none.
    """

    rows: Rows
    distance: Array
    k_range: Array
    k_range_spread: Array
    k_n: Array
    k_n_spread: Array

    def at(self, distance: Array) -> tuple[Array, ...]:
        """|ΔK|, its bar, K_N and its bar at distances (n,); NaN but between stations."""
        values = self.k_range, self.k_range_spread, self.k_n, self.k_n_spread
        if not len(self.distance):
            return tuple(np.full(len(distance), math.nan) for _ in values)
        return tuple(
            np.interp(distance, self.distance, each, math.nan, math.nan) for each in values
        )

    def sizes(self, distance: Array) -> Array:
        """(n,) lengths of the elements along the front."""
        return np.interp(distance, self.rows.distance, np.gradient(self.rows.distance))

    def with_bars(self, coarser: Level) -> Level:
        """The stations that have |ΔK| in a coarser level too, with the difference in their bars.

        K_N errs by the square of the elements across the front, which are twice as long there.
        """
        ratio = self.sizes(self.distance) / coarser.sizes(self.distance)
        k_range, _, k_n, _ = coarser.at(self.distance)
        difference = np.abs(self.k_range - k_range)
        spread = np.hypot(self.k_range_spread, ratio / np.maximum(1 - ratio, 0.1) * difference)
        of_k_n = np.hypot(self.k_n_spread, (self.k_n - k_n) / 3)
        known = np.isfinite(spread)
        return Level(self.rows, *(
            each[known] for each in (self.distance, self.k_range, spread, self.k_n, of_k_n)
        ))  # fmt: skip


def _level(result: Result, end: FrontEnd, inner: float) -> Level:
    own = end_near(result, end.point)
    if own is None:
        raise ModelError(
            f"{result.directory or result.case.source}: expected a front that ends at {end.name}, "
            "found none: take a larger --radius"
        )
    return Level(rows_at(result, own, inner), *known_numbers(own))


def _two_zones(end: FrontEnd) -> float:
    """Two slip zones, as they are known of the station of a run nearest to its end, to a digit."""
    known = zone_at(end)
    return float(f"{2 * (known if known > 0 else end.station.size):.1g}")


def number_at(name: str, fine: Rows, coarse: Rows, length: float) -> EndNumber:
    """A number next to an end, by two levels, one of which is twice as fine.

    Means of a power distance^-m err like h^(1 - m): 1/(2^(1 - m) - 1) of the difference. What lies
    between rows counts too: a third of what every second row changes. Where one body ends before
    the other a stress grows like that of the corner of a quarter-plane on a half-plane, whose m
    rows do not tell: by fits m is .09 where values on the end of two levels make it .27.

    Args:
        name: of it in `Rows`.
        fine: of the finer level.
        coarse: of the coarser level.
        length: from the end.
    """
    largest = [float(each.within(name, length)[1].max()) for each in (fine, coarse)]
    mean = [each.mean(name, length) for each in (fine, coarse)]
    exponent, exponent_spread = _power(
        *((each.distance, getattr(each, name)) for each in (fine, coarse)), length=length
    )
    grows = exponent > exponent_spread
    if NUMBERS[name].kind == "stress" and _grows_on_end(name, fine, coarse):
        exponent, exponent_spread, grows = math.nan, math.nan, True
    power = MOST_SINGULAR if math.isnan(exponent) else min(exponent, 0.9)
    order = 1 - power if grows else 1.0
    return EndNumber(
        name=name,
        largest=largest[0],
        largest_spread=abs(largest[0] - largest[1]),
        mean=mean[0],
        mean_spread=math.hypot(
            (mean[0] - mean[1]) / (2**order - 1), (mean[0] - fine.mean(name, length, 2)) / 3
        ),
        exponent=exponent,
        exponent_spread=exponent_spread,
        grows=grows,
    )


def _power(*levels: tuple[Array, Array], length: float) -> tuple[float, float]:
    """Exponent m of the power distance^-m, by least squares, and its error bar.

    It is that over the distances that are fitted, and may be another one still nearer to the end.
    The bar is twice the error of the fit to the finer level with the differences from the fits to
    the coarser one and, of six places and more, to the nearer ones.

    Args:
        levels: distances and values of the finer and of the coarser level.
        length: `FITTED` times that is fitted. The row on the end has no distance, and is left out.
    """
    found = []
    for distance, values in levels:
        used = (distance > 0) & (distance <= FITTED * length) & (values > 0)
        if np.count_nonzero(used) < 4:
            return math.nan, math.nan
        x, y = np.log(distance[used]), np.log(values[used])
        line, covariance = np.polyfit(x, y, 1, cov="unscaled")
        rest = y - np.polyval(line, x)
        variance = covariance[0, 0] * float(rest @ rest) / (len(x) - 2)
        nearer = max(np.count_nonzero(2 * x <= x[0] + x[-1]), 3)
        bend = np.polyfit(x[:nearer], y[:nearer], 1)[0] - line[0] if len(x) > 5 else 0.0
        found.append((-float(line[0]), math.hypot(2 * math.sqrt(variance), bend)))
    (exponent, error), (other, _) = found
    return exponent, math.hypot(error, exponent - other)


def _grows_on_end(name: str, fine: Rows, coarse: Rows) -> bool:
    """True if a stress on the end itself grows as elements become shorter along the front."""
    (one, *_), (other, *_) = getattr(fine, name), getattr(coarse, name)
    if not min(one, other) > 0:
        return False
    return math.log(one / other) > GROWING * math.log(coarse.distance[1] / fine.distance[1])


def _meetings(end: FrontEnd, part: Level) -> Iterator[Meeting]:
    """Stations of the run that are near its end, and at which both are known."""
    for distance, station in known_stations(end):
        found = [float(each[0]) for each in part.at(np.array([distance]))]
        if math.isfinite(found[1]):
            k_range = Compared(station.k_range, station.k_range_spread, *found[:2])
            k_n = Compared(*K_N.read(station), *found[2:])
            yield Meeting(end.contact.name_of(station), distance, k_range, k_n)
