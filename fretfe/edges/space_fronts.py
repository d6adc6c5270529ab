# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts of a contact between solids: found in one state, and followed from state to state."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools
from fretfe.edges.curve import Frames, FrontCurve, Normals
from fretfe.edges.outline import Outline, outlines
from fretfe.edges.sector_fits import FrontFitter
from fretfe.edges.sectors import Sector, Sectors
from fretfe.results.solution import ContactHistory

# Edges between nodes in contact and nodes outside that an outline has at least: a closed one might
# go round a node that happens to be open.
FEWEST_CROSSED = {True: 12, False: 4}
# Passes: each measures distances from the curve through the points that the one before found.
PASSES = 3
# Length of a piece of the curve, in half-widths of the sectors.
PIECE = {True: 1.2, False: 1.5}
FEWEST_PIECES = {True: 8, False: 2}
# Points that the curve of a closed front follows at least, whatever the number of stations. Those
# of an open one come too near to its ends.
POINTS = {True: 40, False: 0}
# Share of the points that must be known for a curve through them.
KNOWN = 0.5
# Fits look no farther than this part of the way to the middle of the contact, and of the radius of
# curvature.
FARTHEST, NO_FARTHER = 1.5, 0.9
# Steps of the search for the other side of the contact, along `inward`.
STEPS = 200


class SpaceFront:
    """The stations of a front in one state, and its fits in that and other states.

    Attributes:
        frames: n stations on the front.
        sectors: nodes around the stations.
        depth: (n,) half of the width of the contact, along `inward`.
    """

    def __init__(
        self, frames: Frames, sectors: tuple[Sector, ...], depth: Array, weights: Array
    ) -> None:
        self.frames, self.sectors, self.depth = frames, sectors, depth
        radius = 1 / np.maximum(frames.curvature, 1e-300)
        deepest = np.minimum(FARTHEST * depth, NO_FARTHER * radius)
        self.fits = FrontFitter(sectors, weights, deepest, depth)

    @property
    def sizes(self) -> Array:
        """(n,) lengths of the elements across the front."""
        return np.array([sector.size for sector in self.sectors])


class FrontFinder:
    """Finds the fronts of a contact surface.

    Args:
        contact: its nodes and facets.
        count: number of stations of each front.
    """

    def __init__(self, contact: ContactHistory, count: int) -> None:
        assert contact.facets is not None
        self._points, self._facets = contact.points, contact.facets
        self._weights = contact.weights
        self._normals = Normals(contact.points, contact.frames)
        self._sectors = Sectors(contact.points, contact.facets)
        self._tree = cKDTree(contact.points)
        self._count = count

    def fronts(self, contact: Bools, pressure: Array) -> tuple[SpaceFront, ...]:
        """Fronts in one state, longest first; none where they cannot be told.

        Args:
            contact: (N,) nodes under pressure.
            pressure: (N,) means around the nodes.
        """
        found = (
            self._front(line, contact, pressure)
            for line in outlines(self._facets, contact)
            if len(line.inside) >= FEWEST_CROSSED[line.closed]
        )
        return tuple(front for front in found if front is not None)

    def _front(self, line: Outline, contact: Bools, pressure: Array) -> SpaceFront | None:
        closed, pieces = line.closed, FEWEST_PIECES[line.closed]
        middles = line.middles(self._points)
        curve = _curve(middles, closed, pieces)
        for _ in range(PASSES):
            if curve is None:
                return None
            front = self._at(curve.at(max(self._count, POINTS[closed]), self._normals), contact)
            place = front.fits.fit(pressure[None]).place[0]
            known = np.isfinite(place)
            if np.count_nonzero(known) < max(KNOWN * len(known), 4):
                return None
            frames = front.frames
            points = (frames.points + place[:, None] * frames.inward)[known]
            if not closed:
                points = _with_ends(points, middles[[0, -1]])
            reach = np.median([sector.half_width for sector in front.sectors])
            pieces = max(FEWEST_PIECES[closed], round(frames.length / (PIECE[closed] * reach)))
            curve = _curve(points, closed, pieces)
        return None if curve is None else self._at(curve.at(self._count, self._normals), contact)

    def _at(self, frames: Frames, contact: Bools) -> SpaceFront:
        depth = self._depths(frames, contact)
        sectors = tuple(
            self._sectors.around(frames, station, FARTHEST * float(depth[station]))
            for station in range(len(frames.arc))
        )
        return SpaceFront(frames, sectors, depth, self._weights)

    def _depths(self, frames: Frames, contact: Bools) -> Array:
        """(n,) half of the distances along `inward` to where the contact ends."""
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
        return np.asarray(s[last] / 2)


def _curve(points: Array, closed: bool, pieces: int) -> FrontCurve | None:
    """A curve through points, of fewer pieces where points are missing; None if none of them do."""
    for fewer in range(pieces, FEWEST_PIECES[closed] - 1, -1):
        try:
            curve = FrontCurve(points, closed, fewer)
        except (np.linalg.LinAlgError, ValueError):
            continue
        if curve.known:
            return curve
    return None


def _with_ends(points: Array, ends: Array) -> Array:
    """Points of an open front, with its ends (2, 3) moved like the points next to them."""
    rows = []
    for end, (near, next_one) in zip(ends, (points[:2], points[-1:-3:-1]), strict=True):
        along = (near - next_one) / np.linalg.norm(near - next_one)
        rows.append(near + ((end - near) @ along) * along)
    return np.vstack([rows[0], points, rows[1]])
