# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions next to a station, over the distance from its front inward, in any dimension."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.evaluate.contacts import Front, Station
from fretfe.evaluate.plane.section import plane_front
from fretfe.evaluate.space.sectors import Frames, coordinates
from fretfe.history.solution import ContactHistory


@dataclass(frozen=True)
class EdgeNodes:
    """Nodes of a contact next to a station, m of them, from its front inward.

    Attributes:
        contact: whose nodes they are.
        nodes: (m,) numbers.
        s: (m,) distances from the front.
        direction: (m, d - 1) of the shear that counts, in the tangents of the nodes.
        row: (m,) number of the row of elements along the front, from 0; in the plane each node is
            one.
    """

    contact: ContactHistory
    nodes: Indices
    s: Array
    direction: Array
    row: Indices

    def tractions(self, state: int) -> tuple[Array, Array]:
        """(m,) pressure and (m,) shear in the direction that counts, means around the nodes.

        Raises:
            OutputError: if those of the state are not kept.
        """
        mean = self.contact.mean_traction[state][self.nodes]
        return mean[:, 0], np.einsum("nt,nt->n", mean[:, 1:], self.direction)

    def by_rows(self, values: Array) -> Array:
        """(k,) means over the rows of values (m,) of the nodes."""
        area = self.contact.surface.weights[self.nodes]
        return np.asarray(np.bincount(self.row, area * values) / np.bincount(self.row, area))


@dataclass(frozen=True)
class EdgeTractions:
    """Tractions next to a station of solids in one state, (m,) each; none where they are not kept.

    Attributes:
        s: distances from the front inward.
        pressure: p; of nodes means around them.
        shear: q along the direction of (K_T, K_S), likewise.
    """

    s: Array
    pressure: Array
    shear: Array


@dataclass(frozen=True)
class HalfCycleEnd:
    """Tractions next to a station of solids where a half cycle begins or ends.

    Attributes:
        time: of the state.
        friction: coefficient.
        slip: length of the slip zone that a half cycle has left there by the plane problem, from
            the front as it is then; NaN where that is not known.
        plane: by the plane problem.
        nodes: by the nodes around the station.
    """

    time: float
    friction: float
    slip: float
    plane: EdgeTractions
    nodes: EdgeTractions


def half_cycle_ends(
    contact: ContactHistory, front: Front, station: Station, times: Array
) -> tuple[HalfCycleEnd, ...]:
    """Both ends of the half cycle of the longest slip zone; none without its plane problem.

    The beginning is left out where nothing has acted before.

    Args:
        contact: of the station.
        front: of the station.
        station: one of its stations.
        times: (T,) of the states.
    """
    zone, tractions = station.longest_zone, station.local.tractions
    if zone is None or not tractions:
        return ()
    # In a cycle that repeats itself a half cycle begins where another one ends a period later.
    period, slips = station.last - station.first, dict[int, float]()
    for each in station.slip_zones:
        slips |= {each.end - period: each.local, each.end: each.local}
    states = (zone.start, zone.end)[-len(tractions) :]
    angle = math.radians(station.k_angle)
    direction = np.array([math.cos(angle), math.sin(angle)])
    return tuple(
        HalfCycleEnd(
            time=float(times[state]),
            friction=station.friction * contact.friction.acts[state],
            slip=slips.get(state, math.nan),
            plane=EdgeTractions(plane.s, plane.pressure, plane.shear @ direction),
            nodes=_node_tractions(contact, front, station, state),
        )
        for state, plane in zip(states, tractions, strict=True)
    )


def _node_tractions(
    contact: ContactHistory, front: Front, station: Station, state: int
) -> EdgeTractions:
    """Those as far as the middle of the contact of the plane problem."""
    reach = (-station.size, station.local.half_width)
    nodes = edge_nodes(contact, front, station, state, reach)
    try:
        return EdgeTractions(nodes.s, *nodes.tractions(state))
    except OutputError:
        return EdgeTractions(*np.empty((3, 0)))


def edge_nodes(
    contact: ContactHistory, front: Front, station: Station, state: int, reach: tuple[float, float]
) -> EdgeNodes:
    """The nodes next to a station.

    In the plane those of the contact. Between solids those nearer to the station than to the next
    ones, an element to either side at least, and the nearest row where elements are longer along
    the front. The shear that counts is that along the direction in which (K_T, K_S) varies most; in
    the plane without motion along z inward.

    Args:
        contact: of the station.
        front: of the station.
        station: one of its stations.
        state: from whose place of the front distances count.
        reach: distances from the front that the nodes are between, the first one left out.
    """
    position = float(station.position[state])
    if contact.surface.facets is None:
        plane = plane_front(station.front)
        s = plane.inward * (contact.surface.arc - position)
        nodes = _from_front(s, reach)
        line = plane.axis(station.direction, contact.slip.shape[2])
        lines, rows = np.tile(line, (len(nodes), 1)), np.arange(len(nodes))
        return EdgeNodes(contact, nodes, s[nodes], lines, rows)
    nodes, s = _around(contact, front, station, position, reach)
    angle = np.radians(station.k_angle)
    line = np.cos(angle) * station.frame.inward + np.sin(angle) * station.frame.along
    rows = np.floor(s / station.size)
    return EdgeNodes(
        contact,
        nodes,
        s,
        contact.surface.frames[nodes, 1:] @ line,
        np.unique(rows, return_inverse=True)[1],
    )


def _around(
    contact: ContactHistory,
    front: Front,
    station: Station,
    position: float,
    reach: tuple[float, float],
) -> tuple[Indices, Array]:
    """(m,) nodes around a station of solids, and their distances from its front."""
    s, along, across = coordinates(contact.surface.points, _frames(front, station), 0)
    s = np.where(np.abs(across) <= station.depth, s - position, np.nan)
    half = max(front.length / len(front.stations) / 2, station.size)
    # Around a bent front sectors become narrower than an element inward.
    beside = np.abs((contact.surface.points - station.point) @ station.frame.along) <= station.size
    beside &= np.abs(along * station.curvature) < np.pi / 2
    nodes = _from_front(np.where((np.abs(along) <= half) | beside, s, np.nan), reach)
    nearest = _from_front(s, reach)
    aside = np.abs(along[nearest])
    nearest = nearest[aside <= aside.min(initial=np.inf) + station.size]
    # A row that is not quite across the front leaves the sector.
    if _rows(s[nodes], station) < _rows(s[nearest], station):
        nodes = nearest
    return nodes, s[nodes]


def _rows(s: Array, station: Station) -> int:
    """Number of rows of elements along the front with nodes at distances (m,) from it."""
    return len(np.unique(np.floor(s / station.size)))


def _from_front(s: Array, reach: tuple[float, float]) -> Indices:
    """(m,) places of distances (N,) within a reach, in their order; NaN is outside."""
    nodes = np.flatnonzero((s > reach[0]) & (s <= reach[1]))
    return nodes[np.argsort(s[nodes], kind="stable")]


def _frames(front: Front, station: Station) -> Frames:
    """The frame of a station as that of a front."""
    frame = station.frame
    return Frames(
        points=station.point[None],
        inward=frame.inward[None],
        along=frame.along[None],
        across=frame.across[None],
        curvature=np.array([station.curvature]),
        arc=np.array([station.arc]),
        length=front.length,
        closed=front.closed,
    )
