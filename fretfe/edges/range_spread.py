# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error bars of ranges of K_T: extraction, discretisation, and extremes between the steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.edges.between import LoadPath, excess
from fretfe.edges.front import RangeSpread
from fretfe.edges.pressure import EdgeFit
from fretfe.results.solution import Factor

# The edge of a discrete contact area may lie anywhere in an element: half of it, and some more for
# what its node does.
WITHIN_ELEMENT = 0.6


@dataclass(frozen=True)
class FactorHistories:
    """Singular factors of all stations in every state.

    Attributes:
        ways: (R, stations, T, d) in R ways.
        fitted: (stations, T, d) by fits to tractions; None without them.
        exact: True for closed forms.
        one_sided: (stations,) what steps of the cycle may be wrong by in K_T of which one end only
            is known.
    """

    ways: Array
    fitted: Array | None
    exact: bool
    one_sided: Array


def range_spreads(
    histories: FactorHistories,
    fits: Sequence[EdgeFit],
    arc: Array,
    cycle: Indices,
    path: LoadPath | None,
) -> tuple[RangeSpread, ...]:
    """Error bar of the range of K_T over a cycle at each station.

    The discretisation is what integral and fits differ by, what steps add of which one end only is
    known, and what it means that a discrete contact area ends somewhere within an element: K_T goes
    with the root of its half-width, so that an error of the edge counts half, and by the largest
    range of all stations, since K_T of one may be a small difference.

    Args:
        histories: the factors.
        fits: position of each station, and its error bar.
        arc: (N,) nodes of the contact.
        cycle: states of the evaluated cycle.
        path: loads of the cycle between its steps, unless they are straight lines.
    """
    k_t = histories.ways.mean(axis=0)[..., Factor.K_T]
    largest = max((cycle_range(each, cycle) for each in k_t), default=np.nan)
    misplaced = _misplaced(fits, arc, cycle, 0.0 if histories.exact else WITHIN_ELEMENT)
    spreads = []
    for station, history in enumerate(k_t):
        ranges = [cycle_range(way[station, :, Factor.K_T], cycle) for way in histories.ways]
        # One way alone has no spread unless it is exact.
        alone = 0.0 if histories.exact else np.nan
        parts = [histories.one_sided[station], misplaced[station] * largest]
        if histories.fitted is not None:
            fitted = cycle_range(histories.fitted[station, :, Factor.K_T], cycle)
            # Where there are too few nodes for fits, integrals stand alone.
            parts.append(fitted - cycle_range(history, cycle) if np.isfinite(fitted) else 0.0)
        spreads.append(
            RangeSpread(
                extraction=float(np.ptp(ranges)) / 2 if len(ranges) > 1 else alone,
                discretisation=float(np.linalg.norm(parts)),
                steps=excess(history, cycle, path),
            )
        )
    return tuple(spreads)


def _misplaced(fits: Sequence[EdgeFit], arc: Array, cycle: Indices, elements: float) -> list[float]:
    """Half the error of each edge over the half-width, where that is largest in the cycle."""
    positions = np.array([fit.position[cycle] for fit in fits])
    half_width = np.ptp(positions, axis=0) / 2
    sizes = np.diff(arc)
    shares = []
    for position, fit in zip(positions, fits, strict=True):
        size = sizes[np.clip(np.searchsorted(arc, position) - 1, 0, len(sizes) - 1)]
        # The two errors have nothing to do with each other, but the larger one counts.
        error = np.hypot(elements * size, fit.spread_position[cycle])
        shares.append(float(np.max(error / (2 * half_width), initial=0.0)))
    return shares


def cycle_range(history: Array, cycle: Indices) -> float:
    """Largest less smallest of a history (T,) over the states of a cycle; NaN without one."""
    return float(np.ptp(history[cycle])) if len(cycle) else np.nan
