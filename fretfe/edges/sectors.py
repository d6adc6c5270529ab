# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors: the nodes around a station of a front, by distance from the front and along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.edges.curve import Frames

# Half of a sector's width along the front: in elements across it, and in elements along it, which
# may be much longer. Two rows to either side sample a smooth weight.
HALF_WIDTH = 8.0
ROWS = 2.0
# No wider than that part of the radius of curvature of the front.
WIDEST = 0.7
# Edges of elements around a station that are looked at, and the nearest of them, of each of the two
# directions, whose median is the size of an element.
AROUND, NEAREST = 200, 8


@dataclass(frozen=True)
class Sector:
    """Nodes around one station.

    Attributes:
        nodes: (m,) numbers of the nodes.
        s: (m,) distances from the reference front inward, negative outside.
        along: (m,) distances along it from the station, along its `along`.
        fade: (m,) weights that fall from 1 at the station to 0 at both ends of the sector.
        size: length of an element across the front.
        along_size: length of an element along the front.
        curvature: of the reference front.
        half_width: of the sector, along the front.
    """

    nodes: Indices
    s: Array
    along: Array
    fade: Array
    size: float
    along_size: float
    curvature: float
    half_width: float


def coordinates(points: Array, frames: Frames, station: int) -> tuple[Array, Array, Array]:
    """(m,) distances of points (m, 3) inward from a front, along it, and across it.

    The front is taken as its circle of curvature, the surface as its tangent plane.
    """
    place = points - frames.points[station]
    x, y = place @ frames.along[station], place @ frames.inward[station]
    bend = frames.curvature[station]
    # Distance from the circle, in a form that holds for a straight front too.
    radius = np.hypot(bend * x, 1 - bend * y)
    s = (2 * y - bend * (x**2 + y**2)) / (1 + radius)
    angle = np.arctan2(bend * x, 1 - bend * y)
    along = angle / bend if abs(bend) > 1e-12 else x
    return s, along, place @ frames.across[station]


class Sectors:
    """Makes sectors of a contact surface.

    Args:
        points: (N, 3) nodes.
        facets: (F, 3 or 4) of the surface.
    """

    def __init__(self, points: Array, facets: Indices) -> None:
        self._points = points
        self._tree = cKDTree(points)
        edges = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2)
        self._edges = np.unique(np.sort(edges, axis=1), axis=0)
        self._middles = cKDTree(points[self._edges].mean(axis=1))

    def sizes(self, frames: Frames, station: int) -> tuple[float, ...]:
        """Length of the elements at a station across the front and along it.

        Each is the median of the nearest edges that run more in this direction.
        """
        _, found = self._middles.query(frames.points[station], k=min(AROUND, len(self._edges)))
        vectors = np.diff(self._points[self._edges[found]], axis=1)[:, 0]
        across, along = (np.abs(vectors @ each[station]) for each in (frames.inward, frames.along))
        # Of very long elements all edges around may run the same way.
        sizes = _median(across[across >= along]), _median(along[along > across])
        return tuple(np.where(np.isfinite(sizes), sizes, np.nanmax(sizes)).tolist())

    def around(self, frames: Frames, station: int, depth: float) -> Sector:
        """The sector of a station.

        Args:
            frames: stations of a reference front.
            station: number of it.
            depth: distance inward as far as which nodes count, and a bump more.
        """
        size, along_size = self.sizes(frames, station)
        widest = WIDEST / max(abs(float(frames.curvature[station])), 1e-300)
        wanted = max(HALF_WIDTH * size, ROWS * along_size)
        half_width = max(min(wanted, widest), ROWS * along_size)
        depth += 2 * size
        radius = float(np.hypot(depth, half_width))
        near = np.array(sorted(self._tree.query_ball_point(frames.points[station], 1.2 * radius)))
        s, along, across = coordinates(self._points[near], frames, station)
        inside: Bools = (np.abs(along) <= half_width) & (np.abs(s) <= depth)
        inside &= np.abs(across) <= depth
        fade = np.cos(np.pi / 2 * along[inside] / half_width) ** 2
        return Sector(
            nodes=near[inside],
            s=s[inside],
            along=along[inside],
            fade=fade,
            size=size,
            along_size=along_size,
            curvature=float(frames.curvature[station]),
            half_width=half_width,
        )


def _median(lengths: Array) -> float:
    """Median of the first few lengths; NaN without any."""
    return float(np.median(lengths[:NEAREST])) if len(lengths) else np.nan
