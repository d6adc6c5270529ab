# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodes of solid contacts near the free end of a front, row by row along it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.evaluate.contacts import Quantity, quantities
from fretfe.results.front_ends import FrontEnd
from fretfe.results.model import Result


@dataclass(frozen=True)
class Rows:
    """The nodes along a front in m rows across it; over the evaluated cycle, the largest of each.

    Of extruded bodies the nodes of a layer are a row.
    """

    distance: Annotated[Array, Quantity("length", "from the free end, along the front")]
    work: Annotated[Array, Quantity("work per length", "friction work per length of the front")]
    slip_range: Annotated[Array, Quantity("length", "largest range of slip, at the edge too")]
    density: Annotated[Array, Quantity("density", "largest friction work per area")]
    pressure: Annotated[Array, Quantity("stress", "largest pressure")]
    shear: Annotated[Array, Quantity("stress", "largest shear")]
    ratio: Annotated[Array, Quantity("", "largest ratio of shear to pressure")]

    def within(self, name: str, length: float, step: int = 1) -> tuple[Array, Array]:
        """Distances up to a length, which is the last one, and a number of the rows there.

        Args:
            name: of the number.
            length: from the end.
            step: 2 for every second row alone.
        """
        distance, values = self.distance[::step], getattr(self, name)[::step]
        ends = np.append(distance[distance < length], length)
        return ends, np.interp(ends, distance, values)

    def mean(self, name: str, length: float, step: int = 1) -> float:
        """Mean of a number over a length from the end; arguments are those of `within`."""
        ends, values = self.within(name, length, step)
        return float(np.trapezoid(values, ends) / length)


NUMBERS = {name: each for name, each in quantities(Rows).items() if name != "distance"}


def rows_at(result: Result, end: FrontEnd, inner: float) -> Rows:
    """The rows of nodes of extruded bodies near a free end of a front.

    Args:
        result: of these bodies.
        end: of one of its fronts.
        inner: distance along the front from it; into the contact 1.4 times as far.

    Raises:
        OutputError: if not all tractions of the cycle are kept.
    """
    name = end.contact.name
    history, found = result.contact_history(name), result.local_parameters(name)
    away = history.surface.points - end.point
    height = np.abs(away[:, 2] / end.into[2])
    across = away - height[:, None] * end.into
    # Beyond `inner` too, for the length of front that belongs to the last row; beyond the middle
    # of contacts whose pressure is largest there.
    near = (height <= 2 * inner) & (np.linalg.norm(across, axis=1) <= 1.4 * inner)
    digits = 6 - math.floor(math.log10(inner))
    distance, row = np.unique(np.round(height[near], digits), return_inverse=True)
    first, last = result.solution.loads.evaluated
    traction = np.asarray(history.mean_traction[first : last + 1])[:, near]
    pressure, shear = traction[..., 0], np.linalg.norm(traction[..., 1:], axis=2)
    ratio = np.where(pressure > 0, shear / np.where(pressure > 0, pressure, 1.0), 0.0)

    def largest(values: Array) -> Array:
        found = np.zeros(len(distance))
        np.maximum.at(found, row, values)
        return found

    between = np.diff(distance) / 2
    thickness = np.append(between, 0.0) + np.append(0.0, between)
    work = np.bincount(row, found.work[near] * history.surface.weights[near]) / thickness
    place = (away @ end.station.frame.inward)[near] - _edge_at(end, height[near])
    values = [
        work,
        slip_at_edge(place, row, found.slip_range[near], len(distance)),
        largest(found.work[near]),
        largest(pressure.max(axis=0)),
        largest(shear.max(axis=0)),
        largest(ratio.max(axis=0)),
    ]
    kept = distance <= inner
    # The first row lies on the free end.
    return Rows(distance[kept] - distance[0], *(each[kept] for each in values))


def _edge_at(end: FrontEnd, distance: Array) -> Array:
    """(n,) places of a front across it, inward from its end, at distances (n,) along it."""
    places = [each.point - end.point for each in end.front.stations]
    across = np.array(places) @ end.station.frame.inward
    order = np.argsort(end.distance)
    known = np.append(0.0, end.distance[order]), np.append(0.0, across[order])
    return np.interp(distance, *known)


def slip_at_edge(place: Array, row: Indices, slip: Array, rows: int) -> Array:
    """(rows,) largest range of slip of the nodes of each row, and at its edge.

    Slip grows like the power 3/2 of the distance from where nodes stick, and fastest at the edge,
    which lies up to an element outside of the last node: a straight line of its power 2/3 through
    the last two nodes goes there.

    Args:
        place: (n,) of nodes, inward from the edge.
        row: (n,) of them.
        slip: (n,) ranges; 0 at nodes that never touch.
        rows: their number.
    """
    found = np.zeros(rows)
    np.maximum.at(found, row, slip)
    for number in range(rows):
        own = np.flatnonzero((row == number) & (slip > 0))
        last = own[np.argsort(place[own])][:2]
        if len(last) == 2 and place[last[1]] > place[last[0]] > 0:
            (x, inner), (s, less) = place[last], slip[last] ** (2 / 3)
            at_edge = s + (s - less) * x / (inner - x)
            found[number] = max(found[number], max(at_edge, 0.0) ** 1.5)
    return found
