# SPDX-License-Identifier: LGPL-3.0-or-later
"""The edges along a front of solids, as its stations are made of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.evaluate.contacts import NO_NUMBER, Frame, SlipZone, Station
from fretfe.evaluate.edge_loads import k_n_by_hold
from fretfe.evaluate.friction_behind import FrictionBehind, straight_inward
from fretfe.evaluate.growth import FindGrowth
from fretfe.evaluate.numerics import last_known
from fretfe.evaluate.seen_slip import seen_slip
from fretfe.evaluate.slip import FindBorder
from fretfe.evaluate.space.fronts import NEAR, FrontTrack, SpaceFront
from fretfe.evaluate.space.gap_shape import fit_similar
from fretfe.evaluate.space.pressure_fit import load_growth
from fretfe.evaluate.space.range_spread import unresolved
from fretfe.evaluate.space.sectors import Frames
from fretfe.evaluate.space.slip import FIRM, SlipBetween, shear_share
from fretfe.evaluate.stations import EdgeData, MovedEdge
from fretfe.faults import Fault
from fretfe.history.solution import OPEN, ContactHistory
from fretfe.reason import Kind, Reason

# The front of a discrete contact area may lie anywhere in an element: half of it, and some more for
# what its nodes do.
RAGGED = 0.6

NO_LOADS = "there are no two neighbouring loads, or K_I is not defined between these bodies"
NO_FRONT = "the front or K_I is not known at a neighbouring load"
AWAY = "the front of the neighbouring loads is too far from the station"
STANDS = "the front does not move outward with the loads"
POOR = "the front moves too little for elements of this size"


@dataclass(frozen=True, kw_only=True)
class FrontEdges(EdgeData):
    """The edges at the n stations of a front, with what only fronts of solids have.

    Attributes:
        contact: the contact.
        name: of the front.
        track: the front through the history.
        slip: of the nodes of the contact.
        moves: (n,) K_N by the movement of the front.
    """

    contact: ContactHistory
    name: str
    track: FrontTrack
    slip: SlipBetween
    moves: Sequence[MovedEdge]

    def front(self, number: int) -> tuple[str, int]:
        """The front, and the number along it."""
        return self.name, number

    def label(self, number: int) -> str:
        """An edge in words, for messages."""
        return f"contact {self.contact.name}, {self.name}, station {number}"

    def place(self, number: int, state: int) -> tuple[Array, Frame]:
        """Point (3,) and frame on the reference front, whatever the state."""
        frames = self.track.front.frames
        frame = Frame(frames.inward[number], frames.along[number], frames.across[number])
        return frames.points[number], frame

    def size(self, number: int) -> float:
        """Length of an element across the front."""
        return self.track.front.sectors[number].size

    def friction_behind(self, number: int) -> FrictionBehind:
        """Coefficient along `inward`, as of `EdgeData.friction_behind`."""
        sector = self.track.front.sectors[number]
        friction = self.contact.friction.at(self.last, sector.nodes)
        places, found = straight_inward(sector.s, sector.along, friction, sector.size)
        return FrictionBehind.of(places, found, float(self.frictions[number][self.last]))

    def closed(self, number: int) -> bool:
        """True if the front closes around the contact."""
        return self.track.front.frames.closed

    def moved(self, number: int) -> MovedEdge:
        """K_N by the movement of the front."""
        frames, depth = self.track.front.frames, float(self.track.front.depth[number])
        stiffening = _stiffening(frames, number, self._length(number), depth)
        return replace(self.moves[number], stiffening=stiffening)

    def unresolved(self, number: int, direction: Array) -> list[float]:
        """Errors of the range along a direction (2,) by the elements."""
        track = self.track
        return unresolved(self.factors, track.front, track.fit, number, direction, self.cycle)

    def border(self, number: int, position: Array, outer: Bools, growth: FindGrowth) -> FindBorder:
        """Slip zones by the slip of the nodes, as of `EdgeData.border`."""
        front = self.track.front
        sector, depth = front.sectors[number], float(front.depth[number])
        chord = front.chord(self.contact.surface.points, number)
        return self.slip.border_of(sector, chord, position, depth, outer, growth)

    def seen(self, number: int, direction: Array) -> tuple[Array, Array]:
        """Slip of nodes, as of `EdgeData.seen`."""
        front, contact, place = self.track.front, self.contact, self.fits[number].position
        sector, depth = front.sectors[number], float(front.depth[number])
        steps, _ = self.slip.steps(0, len(place) - 1)
        along = steps[:, sector.nodes] @ self._axis(number, direction)
        s = sector.s - place[1:, None]
        closed = np.asarray(contact.status[1:])[:, sector.nodes] != OPEN
        return seen_slip(along, s, closed, np.full(len(s), depth), FIRM)

    @cached_property
    def _sliding(self) -> Array:
        """(T, n, 3) shear around the stations in states to which all slips, else zero."""
        surface, sectors = self.contact.surface, self.track.front.sectors
        found = np.zeros((len(self.steps.slides), len(sectors), 3))
        for state in np.flatnonzero(self.steps.slides):
            shear = np.einsum(
                "nt,ntd->nd", self.contact.traction[state, :, 1:], surface.frames[:, 1:]
            )
            forces = shear * surface.weights[:, None]
            found[state] = [sector.fade @ forces[sector.nodes] for sector in sectors]
        return found

    def slid(self, number: int, direction: Array) -> Array:
        """(T,) way in which all slips, as of `EdgeData.slid`."""
        return np.sign(self._sliding[:, number] @ self._axis(number, direction))

    def _axis(self, number: int, line: Array) -> Array:
        """(3,) of a line at a station."""
        frames = self.track.front.frames
        return np.asarray(line[0] * frames.inward[number] + line[1] * frames.along[number])

    def shear_share(
        self, number: int, state: int, zone: SlipZone, line: Array, begin: float
    ) -> float:
        """Mean shear along a line over that of f p, as of `EdgeData.shear_share`."""
        front = self.track.front
        friction = float(self.frictions[number][zone.end])
        position, depth = self.fits[number].position[state], float(front.depth[number])
        axis, reach = self._axis(number, line), (float(position + begin), float(position + depth))
        return shear_share(self.contact, front.sectors[number], state, friction, axis, reach)

    def completed(self, number: int, station: Station) -> Station:
        """The station with its place along the front, and what that makes of the contact there."""
        front, frames = self.track.front, self.track.front.frames
        station = station if self.steps.dundurs else k_n_by_hold(station)
        length = self._length(number)
        lack = Reason(Kind.FREE_END) if front.copied[number] else station.lack
        depth, to_end = float(front.depth[number]), float(frames.to_free_end[number])
        return replace(
            station,
            lack=lack,
            arc=float(frames.arc[number]),
            curvature=float(frames.curvature[number]),
            to_end=to_end,
            depth=depth,
            length=length,
            # Within a local length of a free end fields are those of a vertex.
            end=not to_end > max(min(depth, length), front.sectors[number].along_size),
        )

    def _length(self, number: int) -> float:
        """Length over which the fields of an edge hold, as last known."""
        return last_known(self.track.fit.length[: self.last + 1, number], self.cycle)

    def unknown(self, number: int, fault: Fault) -> Station:
        """A station of which nothing but its place is known."""
        frames = self.track.front.frames
        place = {"point": frames.points[number], "arc": float(frames.arc[number])}
        return replace(super().unknown(number, fault), **place)


def _stiffening(frames: Frames, station: int, length: float, depth: float) -> float:
    """Relative growth of dP/da with the half-width: in the plane, and of the front's length.

    A concave front gets shorter, which takes away half of the former at most.
    """
    growth, curvature = load_growth(length, depth), float(frames.curvature[station])
    round_front = frames.closed and curvature > 0
    return growth + (1 / depth if round_front else max(curvature, -growth / 2))


def moved_stations(
    contact: ContactHistory, front: SpaceFront, stations: slice
) -> tuple[MovedEdge, ...]:
    """K_N of the n stations of a front by its movement about a state.

    Args:
        contact: with its neighbouring loads.
        front: in the reference state.
        stations: which of all stations of the contact they are.
    """
    neighbours, count = contact.nearby_loads, len(front.sectors)
    if neighbours is None:
        return (MovedEdge(reason=NO_LOADS),) * count
    fit = fit_similar(contact, front, neighbours.pressure)
    outward, spread = fit.place[0] - fit.place[1], np.linalg.norm(fit.place_spread, axis=0)
    near = np.abs(fit.place).max(axis=0) <= NEAR * front.sizes
    k_i = neighbours.k_i[:, stations]
    # The border of the nodes in contact is ragged at both loads; see `range_spread`.
    ragged = RAGGED * front.sizes / front.depth
    moved = (_moved(*each) for each in zip(near, outward, spread, k_i.T, ragged, strict=True))
    return tuple(replace(each, state=neighbours.state) for each in moved)


def _moved(near: bool, outward: float, spread: float, k_i: Array, ragged: float) -> MovedEdge:
    """One station.

    Args:
        near: whether its front is close to it at both loads.
        outward: how far it moves from the lower to the higher load.
        spread: error bar of that, as if those of both places had nothing to do with each other.
        k_i: (R,) of the difference of the loads, determined in R ways.
        ragged: error of K_I over it by the border of the nodes in contact.
    """

    def unknown(reason: str) -> MovedEdge:
        return MovedEdge(reason=reason)

    if not np.isfinite([outward, *k_i]).all():
        return unknown(NO_FRONT)
    if not near:
        return unknown(AWAY)
    mean = float(k_i.mean())
    if not (outward > 0 and mean > 0):
        return unknown(STANDS)
    k_n = 2 * mean / outward
    relative = math.hypot(spread / outward, float(np.ptp(k_i)) / 2 / mean, ragged)
    return unknown(POOR) if relative > NO_NUMBER else MovedEdge(k_n, relative * k_n)
