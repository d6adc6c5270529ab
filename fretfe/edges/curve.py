# SPDX-License-Identifier: LGPL-3.0-or-later
"""Smooth curves through points of a contact front, and the frames of their stations.

Lengths are in the units of the case.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline, make_lsq_spline
from scipy.spatial import cKDTree

from fretfe._typing import Array

CUBIC = 3
# Nodes whose normals are averaged at a station.
NORMALS = 6


@dataclass(frozen=True)
class Frames:
    """Stations of a front in one state, n of them; vectors of unit length.

    Attributes:
        points: (n, 3) on the front.
        inward: (n, 3) normal of the front in the tangent plane of the contact, into the contact.
        along: (n, 3) tangent of the front, `across` x `inward`.
        across: (n, 3) outward normal of body 2.
        curvature: (n,) of the front in the tangent plane, positive where the contact is convex.
        arc: (n,) distance along the front.
        length: of the front.
        closed: whether the front runs into itself.
    """

    points: Array
    inward: Array
    along: Array
    across: Array
    curvature: Array
    arc: Array
    length: float
    closed: bool

    @property
    def to_end(self) -> Array:
        """(n,) distance to the nearer end of an open front; infinite on a closed one."""
        if self.closed:
            return np.full(len(self.arc), np.inf)
        return np.minimum(self.arc, self.length - self.arc)

    def moved(self, inward: Array) -> Frames:
        """Stations of a front that runs at distances inward (n,) from this one."""
        return replace(
            self,
            points=self.points + inward[:, None] * self.inward,
            curvature=self.curvature / (1 - self.curvature * inward),
        )


class FrontCurve:
    """A smooth curve through points of a front, by least squares.

    Args:
        points: (m, 3) in order, the contact on the right when seen from outside body 2.
        closed: whether the last point is followed by the first one.
        pieces: number of polynomial pieces.
    """

    def __init__(self, points: Array, closed: bool, pieces: int) -> None:
        self.closed = closed
        rows = np.vstack([points, points[:1]]) if closed else points
        place = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1)))
        self._period = float(place[-1])
        # A cubic goes through four points; fewer pieces than that follow from fewer points.
        pieces = max(1, min(pieces, len(points) - CUBIC))
        self._spline = _spline(place, rows, pieces, closed)

    @property
    def known(self) -> bool:
        """True if there were enough points everywhere."""
        return bool(np.isfinite(self._spline.c).all())

    def at(self, count: int, normals: Normals) -> Frames:
        """Frames at stations at an even spacing, those of an open front half of it from its ends.

        Args:
            count: number of stations.
            normals: of the contact.
        """
        fine = np.linspace(0.0, self._period, 64 * count + 1)
        steps = np.linalg.norm(np.diff(self._spline(fine), axis=0), axis=1)
        arc = np.append(0.0, np.cumsum(steps))
        wanted = (np.arange(count) + (0.0 if self.closed else 0.5)) / count * arc[-1]
        place = np.interp(wanted, arc, fine)
        points, first = self._spline(place), self._spline(place, 1)
        second = self._spline(place, 2)
        across = normals.at(points)
        along = first - np.einsum("nd,nd->n", first, across)[:, None] * across
        along /= np.linalg.norm(along, axis=1)[:, None]
        inward = np.cross(along, across)
        bend = np.einsum("nd,nd->n", second, inward) / np.einsum("nd,nd->n", first, first)
        return Frames(points, inward, along, across, bend, wanted, float(arc[-1]), self.closed)


class Normals:
    """Outward normals of body 2, averaged over a few nodes.

    Args:
        points: (N, 3) nodes.
        frames: (N, 3, 3) rows: outward normal of body 2, tangents.
    """

    def __init__(self, points: Array, frames: Array) -> None:
        self._tree = cKDTree(points)
        self._normals = frames[:, 0]

    def at(self, places: Array) -> Array:
        """(n, 3) unit normals at places (n, 3)."""
        distance, nodes = self._tree.query(places, k=NORMALS)
        weights = 1 - (distance / (1.001 * distance[:, -1:])) ** 2
        normals = np.einsum("nk,nkd->nd", weights, self._normals[nodes])
        return np.asarray(normals / np.linalg.norm(normals, axis=1)[:, None])


def _spline(place: Array, rows: Array, pieces: int, closed: bool) -> BSpline:
    """Cubic spline with even pieces through rows (m, 3) at places (m,), by least squares."""
    period = place[-1]
    inner = np.linspace(0.0, period, pieces + 1)
    if closed:  # three rounds: the middle one knows of no seam
        turns = np.array([-period, 0.0, period])[:, None]
        place, rows = (place[:-1] + turns).ravel(), np.concatenate([rows[:-1]] * 3)
        inner = np.append((inner[:-1] + turns).ravel(), 2 * period)
    # The ends of the knots are those of the points, and counted four times.
    inner = inner[(inner > place[0]) & (inner < place[-1])]
    first, last = ([end] * (CUBIC + 1) for end in (place[0], place[-1]))
    return make_lsq_spline(place, rows, np.concatenate([first, inner, last]), CUBIC)
