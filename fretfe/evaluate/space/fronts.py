# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts of solid contacts: found in one state, and followed through the history.

The nodes that stick end in a ragged line, and increments of full stick follow it: factors of single
stations scatter by some per cent. Their mean over nested areas, which grow by an element
altogether, has a front where the curve through the fitted places runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.loaded import pressed_state
from fretfe.evaluate.space.contact_area import FEWEST_CROSSED, WANTED_ACROSS, contact_areas
from fretfe.evaluate.space.front_fits import fit_states
from fretfe.evaluate.space.pressure_fit import FrontFit, FrontFitter
from fretfe.evaluate.space.sectors import (
    Frames,
    FrontCurve,
    Mirror,
    Normals,
    Outline,
    Sector,
    Sectors,
    outlines,
)
from fretfe.evaluate.withheld import lost_front
from fretfe.history.solution import ContactHistory, Solution
from fretfe.reason import Reason

# Passes: each measures distances from the curve through the points that the one before found.
PASSES = 3
# Length of a piece of the curve, in half-widths of the sectors.
PIECE = {True: 1.2, False: 1.5}
FEWEST_PIECES = {True: 8, False: 2}
# Points that the curve of a closed front follows at least, whatever the number of stations. Those
# of an open one come too near to its ends.
POINTS = {True: 40, False: 0}
# Share of the points that must be known for a curve through them.
KNOWN_POINTS = 0.5
# Fits look no farther than this part of the way to the middle of the contact, and of the radius of
# curvature.
FARTHEST = 1.5
NO_FARTHER = 0.9
# Steps of the search for the other side of the contact, along `inward`.
STEPS = 200
# Distance of a front from the stations' reference, in elements, up to which the same sectors serve.
NEAR = 0.75
# Share of the stations that must be known.
KNOWN_STATIONS = 0.5
# Elements along an open front from its ends, nearer to which there is no integral: its weight falls
# to zero at the end, and within half of an element quadrature points hardly see it (up to four
# times the factor of a straight slice); .2 % of it there.
ROOM = 1.0
# Planes of symmetry at both ends of a front; none of them.
Mirrors = tuple[Mirror | None, Mirror | None]
NO_MIRRORS: Mirrors = None, None
# Stations (n) along the nodes in contact, the place (2, n) of the front there and its error bar.
Border = tuple[Frames, Array]
# Points of a curve between which it is straight, for each of its stations.
FINER = 8
# Known stations that a curve through them takes.
FEWEST = 4
# Attributes of a fit that there is none of.
UNKNOWN = np.array([np.nan, np.inf, np.nan, np.inf, np.nan, 0.5])
# Curves found anew, at most, for a front that moves far.
MOST_CURVES = 12
AREAS = 6
# How far outside its nodes the front of an area lies, in elements across it: where it is in bonded
# circles by their factors under a force along, a force across and a moment, by .25, .22 and .2.
OUTSIDE = 0.21
# Where the pressure has no fit, a curve along the outline tells the place to so many elements: that
# far outside of it, fronts of spheres with radii of 6 to 10 elements are within .34.
BY_OUTLINE = 0.35
# Nodes within this distance of a front, in elements across it, are in an area or not by it, unless
# the nearest station is not known; others are as they were. Beyond its last station a front goes on
# straight, as far as that many times the spacing of stations.
BAND = 2.0
BEYOND = 3.0


class SpaceFront:
    """The stations of a front in one state, and its fits in that and other states.

    Attributes:
        frames: n stations on the front.
        sectors: nodes around the stations.
        depth: (n,) half of the width of the contact, along `inward`.
        node: one of those in contact next to the front.
    """

    def __init__(
        self, frames: Frames, sectors: tuple[Sector, ...], depth: Array, weights: Array, node: int
    ) -> None:
        self.frames, self.sectors, self.depth, self.node = frames, sectors, depth, node
        radius = 1 / np.maximum(frames.curvature, 1e-300)
        deepest = np.minimum(FARTHEST * depth, NO_FARTHER * radius)
        self.fits = FrontFitter(sectors, weights, deepest, depth)

    @property
    def sizes(self) -> Array:
        """(n,) lengths of the elements across the front."""
        return np.array([sector.size for sector in self.sectors])

    def chord(self, points: Array, station: int) -> Indices:
        """Those of points (N, 3) between a station and the other side of the contact."""
        frames, depth = self.frames, float(self.depth[station])
        place = points - frames.points[station]
        along, inward, across = (
            place @ each[station] for each in (frames.along, frames.inward, frames.across)
        )
        near = (np.abs(along) <= self.sectors[station].half_width) & (np.abs(across) <= depth)
        return np.flatnonzero(near & (inward > 0) & (inward < 2 * depth))

    @property
    def aside(self) -> Array:
        """(n,) distances along the front to where factors are integrated; 0 but next to an end."""
        frames = self.frames
        if frames.closed:
            return np.zeros(len(frames.arc))
        room = np.minimum(self._room, frames.length / 2)
        return np.clip(frames.arc, room, frames.length - room) - frames.arc

    @property
    def copied(self) -> Bools:
        """(n,) stations next to a free end, where factors are those of a place further inside.

        Towards the corner of a free end factors grow, and a place an element away says nothing of
        it; at a plane of symmetry they have no slope.
        """
        return np.asarray((self.aside != 0) & (self.frames.to_free_end < self._room))

    @property
    def _room(self) -> Array:
        """(n,) distances along the front to an end that integrals need."""
        return ROOM * np.array([sector.along_size for sector in self.sectors])


@dataclass(frozen=True)
class LostFront:
    """A border of the contact area along which the pressure has no fits.

    Attributes:
        frames: n stations along it.
        sizes: (n,) lengths of the elements across it.
        node: one of those in contact next to it.
        lack: why it is no front.
    """

    frames: Frames
    sizes: Array
    node: int
    lack: Reason


class FrontFinder:
    """Finds the fronts of a contact surface.

    Args:
        contact: its nodes and facets.
        count: number of stations of each front.
    """

    def __init__(self, contact: ContactHistory, count: int) -> None:
        assert contact.surface.facets is not None
        self._points, self._facets = contact.surface.points, contact.surface.facets
        self._weights, self._continued = contact.surface.weights, contact.surface.continued
        self._normals = Normals(contact.surface.points, contact.surface.frames)
        self._sectors = Sectors(contact.surface.points, contact.surface.facets)
        self._tree = contact.surface.tree
        self._count = count

    def fronts(self, areas: Sequence[Bools], pressure: Array) -> tuple[SpaceFront, ...]:
        """Fronts in one state, longest first; none where they cannot be told.

        Args:
            areas: (N,) nodes in contact, as of `contact_areas`: those of which fewer borders are
                fronts are left aside. Flickering pressures leave holes in the first one.
            pressure: (N,) means around the nodes.
        """
        best: tuple[SpaceFront, ...] = ()
        for area in areas:
            lines = self._lines(area)
            every = (self._front(line, areas[-1], pressure) for line in lines)
            best = max(best, tuple(front for front in every if front is not None), key=len)
            if len(best) >= len(lines):
                break
        return best

    def borders(self, contact: Bools) -> tuple[Border, ...]:
        """Fronts in one state by the nodes in contact (N,) alone, longest first."""
        found = (self._border(line) for line in self._lines(contact))
        return tuple(
            (frames, np.array([-OUTSIDE, BY_OUTLINE])[:, None] * sizes)
            for frames, sizes in filter(None, found)
        )

    def lost(
        self, contact: Bools, pressure: Array, fronts: Sequence[SpaceFront]
    ) -> Iterator[LostFront]:
        """Borders of the nodes in contact along most of which there is no front, longest first.

        Args:
            contact: (N,) nodes in contact.
            pressure: (N,) means around the nodes.
            fronts: those that were found.
        """
        curves = [
            finer(each.frames, np.zeros_like(each.depth), each.sizes[:, None])[0] for each in fronts
        ]
        known = cKDTree(np.vstack(curves))
        for line in self._lines(contact):
            border = self._border(line)
            if border is not None:
                frames, sizes = border
                if np.mean(known.query(frames.points)[0] > BAND * sizes) > 1 - KNOWN_STATIONS:
                    rise = float(np.median(self._rises(frames, contact, pressure) / sizes))
                    middle = frames.points[len(sizes) // 2]
                    lack = lost_front(middle, max(round(rise), 1), WANTED_ACROSS[line.closed] // 2)
                    yield LostFront(frames, sizes, int(line.inside[0]), lack)

    def _lines(self, contact: Bools) -> list[Outline]:
        """Outlines that are long enough for fronts, longest first."""
        lines = outlines(self._facets, contact)
        return [line for line in lines if len(line.inside) >= FEWEST_CROSSED[line.closed]]

    def _border(self, line: Outline) -> tuple[Frames, Array] | None:
        """Stations along an outline, and sizes (n,) of the elements across it."""
        middles, pieces = line.middles(self._points), FEWEST_PIECES[line.closed]
        curve = _curve(middles, line.closed, pieces, self._ends(line, middles)[1])
        if curve is None:
            return None
        frames = curve.at(self._count, self._normals)
        stations = range(len(frames.arc))
        return frames, np.array([self._sectors.sizes(frames, each)[0] for each in stations])

    def _front(self, line: Outline, contact: Bools, pressure: Array) -> SpaceFront | None:
        closed, pieces = line.closed, FEWEST_PIECES[line.closed]
        middles, node = line.middles(self._points), int(line.inside[0])
        free, mirrors = self._ends(line, middles)
        curve = _curve(middles, closed, pieces, mirrors)
        for _ in range(PASSES):
            if curve is None:
                return None
            frames = curve.at(max(self._count, POINTS[closed]), self._normals)
            front = self._at(frames, contact, node)
            place = front.fits.fit(pressure[None]).place[0]
            known = np.isfinite(place)
            if np.count_nonzero(known) < max(KNOWN_POINTS * len(known), 4):
                return None
            points = (frames.points + place[:, None] * frames.inward)[known]
            if not closed:
                points = _with_ends(points, middles[[0, -1]], mirrors)
            reach = np.median([sector.half_width for sector in front.sectors])
            pieces = max(FEWEST_PIECES[closed], round(frames.length / (PIECE[closed] * reach)))
            curve = _curve(points, closed, pieces, mirrors)
        if curve is None:
            return None
        frames = replace(curve.at(self._count, self._normals), free=free)
        return self._at(frames, contact, node)

    def _ends(self, line: Outline, middles: Array) -> tuple[tuple[bool, bool], Mirrors]:
        """Flags of the ends of an open line at which the bodies end, and planes of symmetry."""
        if line.closed or self._continued is None:
            return (True, True), NO_MIRRORS
        first, last = (
            self._continued[[line.inside[end], line.outside[end]]].mean(axis=0) for end in (0, -1)
        )
        free = bool(np.isnan(first).any()), bool(np.isnan(last).any())
        return free, (_mirror(middles[0], first), _mirror(middles[-1], last))

    def _at(self, frames: Frames, contact: Bools, node: int) -> SpaceFront:
        s, _, last = self._ways(frames, contact)
        depth = s[last] / 2  # to where the contact ends
        sectors = tuple(
            self._sectors.around(frames, station, FARTHEST * float(depth[station]))
            for station in range(len(frames.arc))
        )
        return SpaceFront(frames, sectors, depth, self._weights, node)

    def _rises(self, frames: Frames, contact: Bools, pressure: Array) -> Array:
        """(n,) distances along `inward` to the largest pressure before the contact ends."""
        s, nodes, last = self._ways(frames, contact)
        before = np.arange(STEPS) <= last[:, None]
        return np.asarray(s[np.where(before, pressure[nodes], -np.inf).argmax(axis=1)])

    def _ways(self, frames: Frames, contact: Bools) -> tuple[Array, Indices, Indices]:
        """Distances (STEPS,) along `inward`, nodes there (n, STEPS), number (n,) of the last."""
        extent = float(np.linalg.norm(np.ptp(self._points[contact], axis=0)))
        s = np.linspace(0.0, 1.1 * extent, STEPS)
        places = frames.points[:, None] + s[:, None] * frames.inward[:, None]
        distance, nodes = self._tree.query(places.reshape(-1, 3))
        # Behind the border of the surface the nearest node stays behind.
        inside = contact[nodes] & (distance < np.sqrt(2 * self._weights.max()) + 0.1 * extent)
        inside = inside.reshape(len(places), STEPS)
        begun = np.maximum.accumulate(inside, axis=1)
        ended = begun & ~inside
        last = np.where(ended.any(axis=1), ended.argmax(axis=1), STEPS - 1)
        return s, nodes.reshape(inside.shape), last


def _mirror(point: Array, normal: Array) -> Mirror | None:
    """The plane with a normal, as of `ContactHistory.continued`; None if it is none."""
    return Mirror(point, normal) if np.isfinite(normal).all() and normal.any() else None


def _curve(points: Array, closed: bool, pieces: int, mirrors: Mirrors) -> FrontCurve | None:
    """A curve through points, of fewer pieces where points are missing; None if none of them do."""
    for fewer in range(pieces, FEWEST_PIECES[closed] - 1, -1):
        try:
            curve = FrontCurve(points, closed, fewer, mirrors)
        except (np.linalg.LinAlgError, ValueError):
            continue
        if curve.known:
            return curve
    return None


def _with_ends(points: Array, ends: Array, mirrors: Mirrors) -> Array:
    """Points of an open front, with its ends (2, 3) moved like the points next to them.

    Where a plane of symmetry is, images follow the points.
    """
    rows = []
    for end, (near, next_one) in zip(ends, (points[:2], points[-1:-3:-1]), strict=True):
        along = (near - next_one) / np.linalg.norm(near - next_one)
        rows.append(near + ((end - near) @ along) * along)
    first, last = (row[None][plane is not None :] for row, plane in zip(rows, mirrors, strict=True))
    return np.vstack([first, points, last])


@dataclass(frozen=True)
class FrontTrack:
    """One front in T states, at the n stations that it has in the reference state.

    Attributes:
        front: in the reference state.
        fit: (T, n) places are distances inward from there along each station's `inward`.
        state: number of the reference state.
    """

    front: SpaceFront
    fit: FrontFit
    state: int


def follow_fronts(
    solution: Solution, contact: ContactHistory, count: int
) -> tuple[FrontTrack, ...]:
    """The fronts of the last state of the cycle, or of all, followed through the history.

    Longest first. They are searched for again where they have moved in the cycle, or anywhere
    without one; in states outside of it they are known as far as they stay where they are in it.
    Where the last state carries next to nothing they are those of the largest load, and where the
    contact is too small for its pressures to tell them those of the largest contact.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        count: number of stations of each front.
    """
    finder, found, source = FrontFinder(contact, count), {}, solution.source
    first, last = solution.cycle or (0, len(source) - 1)

    def fronts(state: int) -> tuple[SpaceFront, ...]:
        if state not in found:
            areas = tuple(contact_areas(contact, state))
            found[state] = finder.fronts(areas, contact.mean_traction[state][:, 0])
        return found[state]

    def borders(state: int) -> tuple[Border, ...]:
        either = (finder.borders(area) for area in contact_areas(contact, state))
        return next((each for each in either if each), ())

    states = np.unique(source)
    states = states[contact.nodes_pressed_in(states) > 0]
    wanted = np.isin(states, source[first : last + 1])
    reference = pressed_state(solution, contact)
    if np.isin(source[reference], states) and not fronts(int(source[reference])):
        nodes = contact.nodes_pressed_in(source[first : last + 1])
        reference = first + int(np.flatnonzero(nodes == nodes.max())[-1])
    tracks = []
    for front in fronts(int(source[reference])):
        fit = _follow(contact, front, states, wanted, fronts, borders)
        rows = np.full(len(source), -1)
        inside = np.isin(source, states)
        rows[inside] = np.searchsorted(states, source[inside])
        known = FrontFit(*(each[rows] for each in vars(fit).values()))
        tracks.append(FrontTrack(front, known, reference))
    return tuple(tracks)


def lost_fronts(
    solution: Solution, contact: ContactHistory, tracks: Sequence[FrontTrack]
) -> tuple[LostFront, ...]:
    """Borders of the contact area that have no front in the state of those that were followed.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        tracks: its fronts.
    """
    if not tracks:
        return ()
    state, fronts = int(solution.source[tracks[0].state]), [each.front for each in tracks]
    *_, area = contact_areas(contact, state)
    finder = FrontFinder(contact, len(fronts[0].sectors))
    return tuple(finder.lost(area, contact.mean_traction[state][:, 0], fronts))


def _follow(
    contact: ContactHistory,
    front: SpaceFront,
    states: Indices,
    wanted: Bools,
    fronts: Callable[[int], tuple[SpaceFront, ...]],
    borders: Callable[[int], tuple[Border, ...]],
) -> FrontFit:
    """Fits in some states (n,), and a last row of unknown ones.

    In wanted states whose pressure has no fit the place alone is known, by the nodes in contact.
    """
    shape = len(states) + 1, len(front.sectors)
    values = np.tile(UNKNOWN[:, None, None], shape)
    todo, own, curve = np.arange(len(states)), -1, front
    for _ in range(MOST_CURVES):
        fits = fit_states(contact, curve, states[todo])
        off = np.abs(fits[0]) / curve.sizes
        known = np.isfinite(off)
        near = np.where(known, off, 0.0).max(axis=1) <= NEAR
        near &= known.mean(axis=1) >= KNOWN_STATIONS
        for row, fit in zip(todo[near], fits[:, near].swapaxes(0, 1), strict=True):
            values[:, row] = fit if curve is front else at_stations(curve.frames, fit, front.frames)
        # A state whose own curve does not fit it stays unknown, like one without such a front.
        todo = todo[~near & (todo != own)]
        last_first = todo[wanted[todo]][::-1]
        curves = ((row, _same(front, fronts(int(states[row])))) for row in last_first)
        own, other = next((each for each in curves if each[1] is not None), (-1, None))
        if other is None:
            break
        curve = other
    for row in todo[wanted[todo]]:
        found = borders(int(states[row]))
        nearest = _nearest(front, [frames for frames, _ in found])
        if nearest is not None:
            frames, known = found[nearest]  # places of a `Border`, and error bars
            fit = np.zeros((len(UNKNOWN), len(frames.arc)))
            fit[:2] = known
            values[:2, row] = at_stations(frames, fit, front.frames)[:2]
    return FrontFit(*values)


def _same(front: SpaceFront, others: tuple[SpaceFront, ...]) -> SpaceFront | None:
    """The front among others that crosses the stations' lines of a front, the nearest to them."""
    nearest = _nearest(front, [other.frames for other in others])
    return None if nearest is None else others[nearest]


def _nearest(front: SpaceFront, others: Sequence[Frames]) -> int | None:
    """Number of the frames that cross most of the stations' lines of a front, nearest to them."""
    best, distance = None, np.inf
    for number, other in enumerate(others):
        flat = np.zeros((len(UNKNOWN), len(other.points)))
        place = at_stations(other, flat, front.frames)[0]
        crossed = np.isfinite(place)
        if crossed.mean() >= KNOWN_STATIONS and np.mean(np.abs(place[crossed])) < distance:
            best, distance = number, float(np.mean(np.abs(place[crossed])))
    return best


def at_stations(frames: Frames, fit: Array, stations: Frames) -> Array:
    """(k, n) attributes of a fit (k, m) of one front at the n stations of another one.

    NaN, with infinite bars, where the front does not cross the line along a station's `inward`.
    """
    if np.count_nonzero(np.isfinite(fit[0])) < FEWEST:
        return np.tile(UNKNOWN[:, None], len(stations.arc))
    points, values = finer(frames, fit[0], fit.T)
    if not frames.closed:  # as far as its ends, half of the spacing of stations away
        ahead = points[[0, -1]] - points[[1, -2]]
        ahead *= (frames.length / len(frames.arc) / 2 / np.linalg.norm(ahead, axis=1))[:, None]
        points = np.vstack([points[0] + ahead[0], points, points[-1] + ahead[1]])
        values = values[[0, *range(len(values)), -1]]
    result = np.tile(UNKNOWN, (len(stations.arc), 1))
    for station in range(len(stations.arc)):
        place = points - stations.points[station]
        x, y = place @ stations.along[station], place @ stations.inward[station]
        # The contact lies on the right of both: they run the same way.
        crossed = np.flatnonzero((x[:-1] <= 0) & (x[1:] > 0))
        if not len(crossed):
            continue
        share = -x[crossed] / (x[crossed + 1] - x[crossed])
        at = (1 - share) * y[crossed] + share * y[crossed + 1]
        best = int(np.argmin(np.abs(at)))
        row, part = crossed[best], share[best]
        result[station] = (1 - part) * values[row] + part * values[row + 1]
        result[station, 0] = at[best]
    return result.T


def finer(frames: Frames, place: Array, values: Array) -> tuple[Array, Array]:
    """Many points of a front, in order.

    Args:
        frames: n stations of a reference front.
        place: (n,) distances of the front inward from there, NaN where it is not known.
        values: (n, k) of the stations.

    Returns:
        (m, 3) points, and (m, k) values between those of the stations.
    """
    known = np.isfinite(place)
    points = (frames.points + place[:, None] * frames.inward)[known]
    values = values[known]
    if frames.closed:
        points, values = np.vstack([points, points[:1]]), np.vstack([values, values[:1]])
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    curve = CubicSpline(arc, points, bc_type="periodic" if frames.closed else "not-a-knot")
    fine = np.unique(np.concatenate([arc, np.linspace(0.0, arc[-1], FINER * len(arc))]))
    columns = [np.interp(fine, arc, column) for column in values.T]
    return np.asarray(curve(fine)), np.array(columns).T


def nested_areas(
    points: Array, area: Bools, tracks: Sequence[FrontTrack], places: Sequence[Array]
) -> list[Bools]:
    """Contact areas around the fronts of one, smallest first; each N nodes.

    Args:
        points: (N, 3) nodes of the contact.
        area: (N,) nodes in contact.
        tracks: its fronts.
        places: for each front the places (n,) of its stations, inward from the reference; NaN where
            they are not known.
    """
    inside = np.full(len(points), np.nan)
    nearest = np.full(len(points), np.inf)
    for track, place in zip(tracks, places, strict=True):
        if np.count_nonzero(np.isfinite(place)) < FEWEST:
            continue
        distance, depth = _elements_inside(points, track, place)
        closer = distance < nearest
        inside[closer], nearest[closer] = depth[closer], distance[closer]
    near = np.abs(inside) < BAND
    borders = OUTSIDE + 0.5 - (np.arange(AREAS) + 0.5) / AREAS
    return [np.where(near, inside > border, area) for border in borders]


def _elements_inside(points: Array, track: FrontTrack, place: Array) -> tuple[Array, Array]:
    """(N,) distances from a front, and (N,) how many elements inward; NaN where it is unknown."""
    front, known = track.front, np.isfinite(place)
    stations = front.frames.moved(np.where(known, place, 0.0)).points
    unknown = ~known[cKDTree(stations).query(points)[1]]
    values = np.column_stack([front.frames.inward, front.sizes])
    line, values = finer(front.frames, place, values)
    distance, row = cKDTree(line).query(points)
    inward = values[row, :3] / np.linalg.norm(values[row, :3], axis=1)[:, None]
    offset = points - line[row]
    depth = np.einsum("nd,nd->n", offset, inward)
    spacing = front.frames.length / len(place)
    beyond = np.linalg.norm(offset - depth[:, None] * inward, axis=1) > BEYOND * spacing
    return distance, np.where(beyond | unknown, np.nan, depth / values[row, 3])
