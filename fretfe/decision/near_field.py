# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of a half-plane under the tractions of a contact, whose pressure has roots at edges."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.analytic.partial_slip import linear_stress
from fretfe.contact.march import LARGEST_MOVE
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.loaded import loaded

# Parts of each element next to an edge: the pressure has a root.
PARTS = 12
# Change of P, over the largest, by which a cylinder's edges move as far as parts of steps allow.
LITTLE = 2 * LARGEST_MOVE


@dataclass(frozen=True)
class NearField:
    """A half-plane under the tractions of a contact, through n states.

    Attributes:
        nodes: (K,) x of places between which the tractions are straight.
        pressure, shear: (n, K) there, on this body, shear positive along x.
        across: stress along z over xx + yy.
        along: (n, K) shear along z; None of plane bodies.
    """

    nodes: Array
    pressure: Array
    shear: Array
    across: float
    along: Array | None = None

    def through(self, some: Indices) -> NearField:
        """The same through some of the states, by their places among these."""
        along = None if self.along is None else self.along[some]
        return replace(self, pressure=self.pressure[some], shear=self.shear[some], along=along)

    def at(self, points: Array) -> Array:
        """(n, M, c) stress at points (M, 2)."""
        x, depth = points[:, 0], np.maximum(-points[:, 1], 0.0)
        plane = linear_stress(x, depth, self.nodes, self.pressure, self.shear, self.along)
        across = self.across * (plane[..., :1] + plane[..., 1:2])
        return np.concatenate([plane[..., :2], across, plane[..., 2:]], axis=-1)


@dataclass(frozen=True)
class Side:
    """A body at an edge: its number, the direction inward along the arc, and x = 0 in that."""

    body: int
    inward: int
    mouth: float

    @property
    def place(self) -> float:
        """The mouth along the arc."""
        return self.inward * self.mouth

    def x(self, arc: Array) -> Array:
        """Distances from the mouth inward of places along the arc."""
        return self.inward * arc - self.mouth


def edge_places(contact: Contact, station: Station, states: Indices) -> Array:
    """(n,) positions in states, one and the same if they differ by no more than their bar.

    It is the outermost one. At a place that the edge has left behind by s the tension has fallen by
    2 f K_N √s, which counts even of what errors of the position make. Without contact there are no
    tractions, and that place will do; NaN where the contact carries and the place is not known.
    """
    found, spread = station.position[states].copy(), station.position_spread[states]
    carries = loaded(contact.normal_force)[states]
    if not carries.any():
        return np.full_like(found, math.nan)
    outermost = station.inward * np.min(station.inward * found[carries])
    if np.ptp(found[carries]) <= np.max(spread[carries]):
        found[carries] = outermost
    found[~carries] = outermost
    return found


def every_other(loads: Array, force: Array) -> Indices | None:
    """Places of every other state between turns of the loads, and of these, first and last.

    Criteria differ between these and all states by about as much as with twice as many states.

    Args:
        loads: (n, C) in the states.
        force: (n,) P, which moves edges: extremes of stress then lie within steps.

    Returns:
        The places; None where P changes in a single step between turns, so that nothing tells.
    """
    ways = np.sign(np.diff(loads, axis=0))
    turns = np.flatnonzero(np.any(ways[1:] != ways[:-1], axis=1)) + 1
    ends = np.unique([0, *turns, len(loads) - 1])
    single = ends[:-1][np.diff(ends) == 1]
    if np.any(np.abs(force[single + 1] - force[single]) > LITTLE * force.max()):
        return None
    runs = pairwise(ends)
    return np.unique(np.concatenate([[ends[-1]], *(np.arange(*run, 2) for run in runs)]))


def element_size(arc: Array, place: float) -> float:
    """Length of the element at a place."""
    at = int(np.clip(np.searchsorted(arc, place), 1, len(arc) - 1))
    return float(arc[at] - arc[at - 1])


@dataclass(frozen=True)
class ContactTractions:
    """Of all patches of a contact, through n states.

    Attributes:
        side: the body on which they act.
        arc: (N,) nodes.
        values: (n, N, 2) p and q.
        ends: (e, n) places of the edges of all patches, left and right in turn.
        across: as of `NearField`.
    """

    side: Side
    arc: Array
    values: Array
    ends: Array
    across: float

    def at(self, state: int) -> ContactTractions:
        """Those of one state."""
        return replace(self, values=self.values[[state]], ends=self.ends[:, [state]])

    def near(self, looked: Array) -> NearField:
        """The half-plane under them.

        Args:
            looked: (k,) x of places at which the stress of the surface itself is looked at.
        """
        side = self.side
        nodes = divided(self.arc, self.ends, side.inward * (looked + side.mouth))
        pressure, shear = on_nodes(nodes, self.arc, self.values, self.ends)
        # The shear is that on body 2, along the arc.
        way = side.inward * (1 if side.body else -1)
        x, forward = side.x(nodes), slice(None, None, side.inward)
        return NearField(x[forward], pressure[:, forward], way * shear[:, forward], self.across)


def divided(arc: Array, ends: Array, looked: Array) -> Array:
    """Nodes of a contact, and places between those next to an edge in some state.

    Args:
        arc: (N,) nodes.
        ends: (e, n) places of edges; NaN where there is none.
        looked: (k,) places at which the stress of the surface itself is looked at.
    """
    lengths = np.diff(arc)
    places = np.sort(ends[np.isfinite(ends)])
    around = 4 * lengths
    first = np.searchsorted(places, arc[:-1] - around)
    inside = first < np.searchsorted(places, arc[1:] + around)
    more = arc[:-1][inside, None] + lengths[inside, None] * np.arange(1, PARTS) / PARTS
    return np.unique(np.concatenate([arc, more.ravel(), beside_edges(looked, arc, PARTS)]))


def beside_edges(looked: Array, arc: Array, parts: int = 1) -> Array:
    """Places next to some (k,) on both sides, nearer and nearer: within a part of an element."""
    steps = np.geomspace(1e-3, 1, PARTS) / parts
    steps = np.concatenate([-steps, [0.0], steps])
    return np.ravel([each + element_size(arc, each) * steps for each in map(float, looked)])


def on_nodes(nodes: Array, arc: Array, traction: Array, ends: Array) -> tuple[Array, Array]:
    """(n, K) pressure and shear at places from means around nodes.

    The square of the pressure is straight between nodes, and from them to the edges, where the
    pressure itself has a root. The shear over the pressure is straight too: it is f where it slips,
    of means next to the edge as well.

    Args:
        nodes: (K,) places.
        arc: (N,) nodes of the contact.
        traction: (n, N, 2) p and q.
        ends: (e, n) places of the edges of all patches, left and right in turn.
    """
    found, beside = np.zeros((2, len(traction), len(nodes))), np.gradient(arc)
    for state, (p, q) in enumerate(traction.swapaxes(1, 2)):
        edges = ends[:, state].reshape(-1, 2)
        edges = edges[np.isfinite(edges).all(axis=1)]
        # The mean around a node less than an element from an edge has a part of the root.
        inside = (arc > edges[:, :1] + beside) & (arc < edges[:, 1:] - beside)
        inside = inside.any(axis=0) & (p > 0)
        places = np.concatenate([arc[inside], edges.ravel()])
        squares = np.concatenate([p[inside] ** 2, np.zeros(edges.size)])
        order = np.argsort(places, kind="stable")
        square = np.interp(nodes, places[order], squares[order], left=0.0, right=0.0)
        found[0, state] = np.sqrt(square)
        pressed = p > 0
        if not pressed.any():
            continue
        ratio = np.interp(nodes, arc[pressed], q[pressed] / p[pressed])
        found[1, state] = found[0, state] * ratio
    return found[0], found[1]
