# SPDX-License-Identifier: LGPL-3.0-or-later
"""Means along the fronts of solids, by which a mesh that refines itself is judged.

Numbers of single stations scatter with the ragged border of a discrete contact area; means do not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretfe.edges.area import AreaSummary
from fretfe.edges.refinement import StationValues
from fretfe.edges.solid_fronts import SolidFront, SolidStation
from fretfe.results.solution import Solution

# Share of the stations of a front that must have a number for its mean.
KNOWN = 0.5


def front_means(areas: Sequence[AreaSummary], solution: Solution) -> tuple[StationValues, ...]:
    """Means of K_N, of the range of (K_T, K_S) and of the last two slip zones along each front."""
    friction = {each.name: float(each.friction.max()) for each in solution.contacts}
    return tuple(
        _values(area, front, friction[area.name], solution.cycle is not None)
        for area in areas
        for front in area.fronts
        if front.judged
    )


def _values(area: AreaSummary, front: SolidFront, friction: float, cyclic: bool) -> StationValues:
    stations = front.judged
    slides = friction > 0 and cyclic
    return StationValues(
        contact=area.name,
        front=front.name,
        k_n=_mean([station.told_k_n for station in stations]),
        k_t=_mean([station.told_range for station in stations]) if slides else 0.0,
        slip=tuple(_slip(stations, half) for half in (-2, -1)) if slides else (),
        rise=_mean([min(station.depth, station.length) for station in stations]),
        friction=friction,
    )


def _slip(stations: Sequence[SolidStation], half: int) -> float:
    """Mean length of one of the last two slip zones where they are resolved."""
    zones = [each.slip_zones[half] for each in stations if len(each.slip_zones) > 1]
    lengths = [zone.length if zone.resolved and not zone.gross else np.nan for zone in zones]
    return _mean(lengths + [np.nan] * (len(stations) - len(zones)))


def _mean(values: Sequence[float]) -> float:
    """Mean of what is known; NaN if that is less than half."""
    known = np.isfinite(values)
    return float(np.mean(np.asarray(values)[known])) if known.mean() >= KNOWN else np.nan
