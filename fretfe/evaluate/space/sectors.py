# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of solid contacts: the nodes around a station of a front, and the curves that fronts are.

A sector has the nodes by their distance from the front and along it. The outline of a contact area
runs between its nodes and those around it; the front is a smooth curve along it. Lengths are in the
units of the case.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.surface.surface import edges_once

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

CUBIC = 3
# Nodes whose normals are averaged at a station.
NORMALS = 6
# Half of a sector's width along the front: in elements across it, and in elements along it, which
# may be much longer. Two rows to either side sample a smooth weight.
HALF_WIDTH = 8.0
ROWS = 2.0
# No wider than that part of the radius of curvature of the front.
WIDEST = 0.7
# Edges of elements around a station that are looked at, and the nearest of them, of each of the two
# directions, whose median is the size of an element.
AROUND = 200
NEAREST = 8
# So many times more of them where one of the directions is not among them.
FARTHER = 4
# Elements are long along the front from this length over that across it on. So many edges in rows
# across it are those at the front, in the rows before and behind a station; passes to find them.
LONG = 3.0
IN_ROWS = 4
PASSES = 3


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
        free: True where the bodies end, at its beginning and at its end.
    """

    points: Array
    inward: Array
    along: Array
    across: Array
    curvature: Array
    arc: Array
    length: float
    closed: bool
    free: tuple[bool, bool] = (True, True)

    @property
    def to_end(self) -> Array:
        """(n,) distance to the nearer end of an open front; infinite on a closed one."""
        if self.closed:
            return np.full(len(self.arc), np.inf)
        return np.minimum(self.arc, self.length - self.arc)

    @property
    def to_free_end(self) -> Array:
        """(n,) likewise, to the nearer one of the ends at which the bodies end."""
        if self.closed:
            return self.to_end
        first, last = (0.0 if each else np.inf for each in self.free)
        return np.minimum(self.arc + first, self.length - self.arc + last)

    def moved(self, inward: Array) -> Frames:
        """Stations of a front that runs at distances inward (n,) from this one."""
        return replace(
            self,
            points=self.points + inward[:, None] * self.inward,
            curvature=self.curvature / (1 - self.curvature * inward),
        )

    def slid(self, along: Array) -> Frames:
        """Stations at distances along the front (n,) from these, on their circles of curvature."""
        angle = self.curvature * along
        chord, turned = along * np.sinc(angle / (2 * np.pi)), _turned(angle / 2, self)[1]
        inward, tangent = _turned(angle, self)
        return replace(
            self,
            points=self.points + chord[:, None] * turned,
            inward=inward,
            along=tangent,
            arc=self.arc + along,
        )


def _turned(angle: Array, frames: Frames) -> tuple[Array, Array]:
    """(n, 3) `inward` and `along` of n frames, turned about `across` as where a front bends."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    inward, along = frames.inward, frames.along
    return cosine * inward - sine * along, cosine * along + sine * inward


@dataclass(frozen=True)
class Mirror:
    """A plane of symmetry, by a point (3,) and its unit normal (3,)."""

    point: Array
    normal: Array


class FrontCurve:
    """A smooth curve through points of a front, by least squares.

    Args:
        points: (m, 3) in order, the contact on the right when seen from outside body 2.
        closed: whether the last point is followed by the first one.
        pieces: number of polynomial pieces.
        mirrors: planes of symmetry at its beginning and at its end, as far as there are.
    """

    def __init__(
        self,
        points: Array,
        closed: bool,
        pieces: int,
        mirrors: tuple[Mirror | None, Mirror | None] = (None, None),
    ) -> None:
        self.closed = closed
        rows = np.vstack([points, points[:1]]) if closed else points
        first, last = (
            abs(float((end - mirror.point) @ mirror.normal)) if mirror else 0.0
            for end, mirror in zip(rows[[0, -1]], mirrors, strict=True)
        )
        steps = np.linalg.norm(np.diff(rows, axis=0), axis=1)
        place = np.cumsum([first, *steps])
        self._period = float(place[-1]) + last
        # A cubic goes through four points; fewer pieces than that follow from fewer points.
        knots = np.linspace(0.0, self._period, max(1, min(pieces, len(points) - CUBIC)) + 1)
        whole = place, rows, knots
        if closed:  # three rounds: the middle one knows of no seam
            turns = self._period * np.array([-1.0, 0.0, 1.0])[:, None]
            rounds = (place[:-1] + turns).ravel(), np.concatenate([rows[:-1]] * 3)
            whole = (*rounds, (knots[:-1] + turns).ravel())
        for end, mirror in zip((0.0, self._period), mirrors, strict=True):
            if mirror:
                whole = _with_image(*whole, end, mirror)
        self._spline = _spline(*whole)

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
        # Imported where it is needed: it takes a fifth of a second, and plane contacts do without.
        from scipy.spatial import cKDTree

        self._tree = cKDTree(points)
        self._normals = frames[:, 0]

    def at(self, places: Array) -> Array:
        """(n, 3) unit normals at places (n, 3)."""
        distance, nodes = self._tree.query(places, k=NORMALS)
        weights = 1 - (distance / (1.001 * distance[:, -1:])) ** 2
        normals = np.einsum("nk,nkd->nd", weights, self._normals[nodes])
        return np.asarray(normals / np.linalg.norm(normals, axis=1)[:, None])


def _with_image(
    place: Array, rows: Array, knots: Array, end: float, mirror: Mirror
) -> tuple[Array, Array, Array]:
    """Places (m,), rows (m, 3) and knots with their images behind an end of the curve."""
    image = rows - 2 * ((rows - mirror.point) @ mirror.normal)[:, None] * mirror.normal
    place, rows = np.append(place, 2 * end - place), np.vstack([rows, image])
    order = np.argsort(place, kind="stable")
    return place[order], rows[order], np.unique(np.append(knots, 2 * end - knots))


def _spline(place: Array, rows: Array, knots: Array) -> BSpline:
    """Cubic spline with some knots through rows (m, 3) at places (m,), by least squares."""
    # Imported where it is needed: plane contacts have no curve, and it takes a quarter of a second.
    from scipy.interpolate import make_lsq_spline

    # The ends of the knots are those of the points, and counted four times.
    inner = knots[(knots > place[0]) & (knots < place[-1])]
    first, last = ([end] * (CUBIC + 1) for end in (place[0], place[-1]))
    return make_lsq_spline(place, rows, np.concatenate([first, inner, last]), CUBIC)


@dataclass(frozen=True)
class Outline:
    """A line half-way between nodes in contact and nodes outside, one point for each edge crossed.

    Attributes:
        inside, outside: (n,) nodes at both ends of the edges, in order along the line, the contact
            on its right when seen from outside body 2.
        closed: whether the line runs into itself; an open one ends at the border of the surface.
    """

    inside: Indices
    outside: Indices
    closed: bool

    def middles(self, points: Array) -> Array:
        """(n, 3) middles of the edges, of nodes at points (N, 3)."""
        return np.asarray((points[self.inside] + points[self.outside]) / 2)


def outlines(facets: Indices, contact: Bools) -> tuple[Outline, ...]:
    """Outlines of the nodes in contact (N,), longest first.

    Args:
        facets: (F, 3 or 4) nodes, counter-clockwise seen from outside body 2.
        contact: (N,) nodes in contact.
    """
    following = _segments(triangles(facets), contact)
    lines = []
    for first in sorted(set(following) - set(following.values())):
        lines.append(_walk(following, first, closed=False))
    while following:
        lines.append(_walk(following, min(following), closed=True))
    return tuple(sorted(lines, key=lambda line: -len(line.inside)))


def triangles(facets: Indices) -> Indices:
    """(m, 3) facets, quadrilaterals cut in two."""
    if facets.shape[1] == 3:
        return facets
    return np.concatenate([facets[:, [0, 1, 2]], facets[:, [0, 2, 3]]])


# An edge from a node in contact to one outside.
Edge = tuple[int, int]


def _segments(triangles: Indices, contact: Bools) -> dict[Edge, Edge]:
    """The crossed edge that follows each crossed edge, the contact on the right."""
    following = {}
    mixed = triangles[np.isin(contact[triangles].sum(axis=1), (1, 2))]
    for triangle in mixed.tolist():
        inside = [bool(contact[node]) for node in triangle]
        odd = inside.index(inside.count(True) == 1)
        alone, after, before = (triangle[(odd + turn) % 3] for turn in range(3))
        if inside[odd]:  # round a node in contact, which stays on the right
            following[alone, before] = (alone, after)
        else:
            following[after, alone] = (before, alone)
    return following


def _walk(following: dict[Edge, Edge], first: Edge, closed: bool) -> Outline:
    """The line that begins at an edge; takes it out of `following`."""
    edges, edge = [first], first
    while edge in following:
        edge = following.pop(edge)
        edges.append(edge)
    nodes = np.array(edges[:-1] if closed else edges, dtype=np.int64)
    return Outline(nodes[:, 0], nodes[:, 1], closed)


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
        from scipy.spatial import cKDTree

        self._points = points
        self._tree = cKDTree(points)
        self._edges = edges_once(facets)
        self._middles = cKDTree(points[self._edges].mean(axis=1))

    def sizes(self, frames: Frames, station: int) -> tuple[float, ...]:
        """Length of the elements at a station across the front and along it.

        Each is the median of the nearest edges that run more in this direction. Of elements that
        are long along the front, the nearest to it count, with distances along it in their lengths:
        rows across it need not be near the station, nor normal to the front, and sizes in them may
        grow from one element to the next.
        """
        count, across, along = 0, np.empty(0), np.empty(0)
        # Where elements are long, all edges nearby may run the same way.
        while min(len(across), len(along)) < NEAREST and count < len(self._edges):
            count = min(max(FARTHER * count, AROUND), len(self._edges))
            _, found = self._middles.query(frames.points[station], k=count)
            across, along = self._running(frames, station, found)
        size, along_size = _median(across), _median(along)
        if along_size > LONG * size:
            near = self._middles.query_ball_point(frames.points[station], along_size)
            found = np.array(near, dtype=np.int64)
            s, x, _ = coordinates(self._middles.data[found], frames, station)
            for _ in range(PASSES):
                order = np.argsort(np.hypot(s, x * size / along_size), kind="stable")
                across, _ = self._running(frames, station, found[order])
                size = float(np.median(across[:IN_ROWS]))
        sizes = np.array([size, along_size])
        return tuple(np.where(np.isfinite(sizes), sizes, np.nanmax(sizes)).tolist())

    def _running(self, frames: Frames, station: int, edges: Indices) -> tuple[Array, Array]:
        """Lengths of those edges that run more across the front, and of those along it."""
        vectors = np.diff(self._points[self._edges[edges]], axis=1)[:, 0]
        across, along = (np.abs(vectors @ each[station]) for each in (frames.inward, frames.along))
        return across[across >= along], along[along > across]

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
        found = sorted(self._tree.query_ball_point(frames.points[station], 1.2 * radius))
        near = np.array(found, dtype=np.int64)
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
