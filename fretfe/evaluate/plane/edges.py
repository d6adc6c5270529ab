# SPDX-License-Identifier: LGPL-3.0-or-later
"""The two edges of a plane contact, as their stations are made of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import Frame, SlipZone, Station
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.factors import (
    SMALLEST_MOVE,
    FactorHistories,
    along_line,
    cycle_range,
    misplaced_range,
    misplaced_sums,
    range_error,
)
from fretfe.evaluate.friction_behind import FrictionBehind
from fretfe.evaluate.growth import FindGrowth
from fretfe.evaluate.loaded import left_out
from fretfe.evaluate.numerics import last_known
from fretfe.evaluate.plane.edge_fits import with_gap
from fretfe.evaluate.plane.pressure_fit import FEWEST_NODES, RISEN, fit_edge
from fretfe.evaluate.plane.section import PLANE_FRONTS, PlaneFront, nearest_front, plane_sections
from fretfe.evaluate.plane.slip import slip_border_of
from fretfe.evaluate.seen_slip import seen_slip
from fretfe.evaluate.slip import FindBorder, cycle_states, slip_in_steps
from fretfe.evaluate.stations import EdgeData, MovedEdge
from fretfe.history.solution import OPEN, ContactHistory, NearbyLoads
from fretfe.history.state_array import blocks

# Bodies are too stiff for waves of any length along the contact whose elements grow by g of the
# distance from it, however fine they are at the edges: K_N is this times g^2 high with elements of
# order 1, or g^4 with those of order 2. Half of it in cylinders, most of it in wedges and in flats
# with rounded ends, for growths of the templates of .2 to .45, in the mean of which g is 1.1 times
# as much, and on meshes that refine themselves.
TOO_STIFF = {1: 0.3, 2: 0.06}
# The edge of a discrete contact area may lie anywhere in an element, half of it to either side with
# equal chance: nineteen of twenty are nearer than this.
WITHIN_ELEMENT = 0.475
# Half-planes know the forces on an element exactly; elements that grow inward leave the edge open
# by this part of the smallest ones. Measured: .01 with 300 elements on all profiles.
WITHIN_GRID = 0.02


@dataclass(frozen=True, kw_only=True)
class PlaneEdges(EdgeData):
    """Both edges of a contact, with what only plane contacts have.

    Attributes:
        contact: the contact.
        works: (N,) friction work of each node, and its error bar.
    """

    contact: ContactHistory
    works: tuple[Array, Array]

    @property
    def centre(self) -> Array:
        """(T,) middle between the edges."""
        return np.asarray((self.fits[0].position + self.fits[1].position) / 2)

    @property
    def half_width(self) -> Array:
        """(T,) half the distance between the edges."""
        return np.asarray((self.fits[1].position - self.fits[0].position) / 2)

    def front(self, number: int) -> tuple[str, int]:
        """Left or right, of one edge each."""
        return PLANE_FRONTS[number].name, 0

    def label(self, number: int) -> str:
        """An edge in words, for messages."""
        return f"contact {self.contact.name}, {PLANE_FRONTS[number].name} edge"

    def place(self, number: int, state: int) -> tuple[Array, Frame]:
        """Point (3,) and frame in a state, or in the last one in which the position is known."""
        surface, position = self.contact.surface, self.fits[number].position
        place = float(position[state])
        if math.isnan(place):
            place = last_known(position, np.array([], dtype=np.int64))
        frames = surface.frames[:, :2, :2].reshape(len(surface.arc), -1)
        rows = np.hstack([surface.points, frames]).T
        point, across, tangent = np.reshape(
            [np.interp(place, surface.arc, row) for row in rows], (3, 2)
        )
        return np.append(point, 0.0 * place), PLANE_FRONTS[number].frame(across, tangent)

    def size(self, number: int) -> float:
        """Length of the element at the last known place of an edge."""
        arc, place = self.contact.surface.arc, last_known(self.fits[number].position, self.cycle)
        return float(np.diff(arc)[max(int(np.searchsorted(arc[1:-1], place)), 0)])

    def friction_behind(self, number: int) -> FrictionBehind:
        """Coefficient along the arc, as of `EdgeData.friction_behind`."""
        places = PLANE_FRONTS[number].inward * self.contact.surface.arc
        friction = self.contact.friction.at(self.last)
        return FrictionBehind.of(places, friction, float(self.frictions[number][self.last]))

    def moved(self, number: int) -> MovedEdge:
        """K_N by the movement of an edge."""
        fit, front = self.fits[number], PLANE_FRONTS[number]
        exponents = np.broadcast_to(fit.exponent, fit.k_n.shape)
        nearby = self.contact.nearby_loads
        if nearby is None:
            return MovedEdge()
        half_width = abs(float((self.centre - fit.position)[nearby.state]))
        found = moved_edge(self.contact, nearby, front, half_width, float(exponents[nearby.state]))
        cycle = self.cycle[np.isfinite((fit.position + fit.k_n)[self.cycle])]
        if len(cycle) < 2 or self.contact.surface.dundurs:
            return found
        outward = -front.inward * fit.position[cycle]
        growth, spread = growth_with_edge(outward, fit.k_n[cycle], fit.spread_k_n[cycle])
        # Edges move farther in the cycle where P varies enough.
        if math.isnan(found.stiffening) or not spread < found.stiffening_spread:
            return found
        return replace(found, stiffening=growth + 0.5 / half_width, stiffening_spread=spread)

    def moved_inward(self, number: int) -> Array | float:
        """(T,) distances of an edge by fits from the last node under pressure, behind a layer."""
        if not self.steps.layer[0]:
            return 0.0
        traction, outward = self.contact.traction, -PLANE_FRONTS[number].inward
        places, last = outward * self.contact.surface.arc, np.zeros(len(traction))
        for states in blocks(len(traction), traction[0].size):
            last[states] = np.where(traction[states, :, 0] > 0, places, -np.inf).max(axis=1)
        return np.abs(np.nan_to_num(last - outward * self.fits[number].position, neginf=0.0))

    def unresolved(self, number: int, direction: Array) -> list[float]:
        """Errors of the range along a direction (2,) by the elements."""
        return self._unresolved[number]

    def beside(self, number: int, along: Array, states: Indices) -> float:
        """Range of a factor (T,) that may lie in states of the cycle without edges.

        Where bodies part nothing is left of K_T, and it counts from where they touch again: what it
        is in the first state with edges, by their place there, is as much on flats, 4/3 of it on
        cylinders and twice on wedges. In what they do just before they part they slide.
        """
        swing = cycle_range(along, states)
        cycle, touching = cycle_states(self.steps.whole.cycle), self.steps.touching
        proportional = left_out(self.steps.whole.cycle, states, self.force) * swing
        if touching[cycle].all():
            whole = along[cycle]
            if not (len(whole) and np.isfinite(whole).all()):
                return proportional
            # Full stick has factors up to P = 0, with areas that are hardly known.
            sums = misplaced_sums(whole, np.where(np.isin(cycle, states), 0.0, 1.0))
            return range_error(whole, sums, np.arange(len(cycle))) + float(np.ptp(whole)) - swing
        touched = np.maximum.accumulate(np.where(touching, 0, np.arange(len(along))))
        # A patch begins anew where it appears, also where others were before.
        since = np.where(self.contact.exists, along - along[touched], 0.0)
        located = np.isfinite(self.fits[number].position) | ~touching
        missed, begin = 0.0, int(self.cycle[0])
        if known := bool(np.isfinite(since[cycle]).all()):
            first = abs(float(since[begin])) if touched[begin] in cycle else 0.0
            missed = max(cycle_range(since, cycle[located[cycle]]) - swing, 0.0) + first
        if known and self.contact.node_range is None:
            return missed
        shear = float(self.contact.mean_traction[begin, :, 1] @ self.contact.surface.weights)
        first = abs(shear) / (math.pi * math.sqrt(2 * self.half_width[begin]))
        return max(missed, proportional, 2 * first - abs(float(along[begin] - along[states[0]])))

    @cached_property
    def _unresolved(self) -> list[list[float]]:
        """Those of both edges along their own directions: one counts by the range of the other."""
        return unresolved(self.factors, self.fits, self.contact.surface.arc, self.cycle)

    def border(self, number: int, position: Array, outer: Bools, growth: FindGrowth) -> FindBorder:
        """Slip zones by the slip of the nodes, as of `EdgeData.border`."""
        solution, front = self.steps.solution, PLANE_FRONTS[number]
        least = np.where(outer, solution.least_slip, np.inf)
        degree = 0 if self.factors.exact else solution.degree
        return slip_border_of(self.contact, front, position, least, degree, growth)

    def seen(self, number: int, direction: Array) -> tuple[Array, Array]:
        """Slip of nodes, as of `EdgeData.seen`."""
        contact, front, place = self.contact, PLANE_FRONTS[number], self.fits[number].position
        steps = slip_in_steps(contact, 0, len(place) - 1, self.steps.solution.least_slip)
        along = steps @ front.axis(direction, steps.shape[2])
        s = front.inward * (contact.surface.arc - place[1:, None])
        return seen_slip(along, s, np.asarray(contact.status[1:]) != OPEN, self.half_width[1:])

    @cached_property
    def _sliding(self) -> Array:
        """(T, d - 1) shear force in states to which all slips, else zero."""
        contact = self.contact
        shear = np.zeros((len(self.steps.slides), contact.traction.shape[2] - 1))
        for state in np.flatnonzero(self.steps.slides):
            shear[state] = contact.surface.weights @ contact.mean_traction[state, :, 1:]
        return shear

    def slid(self, number: int, direction: Array) -> Array:
        """(T,) way in which all slips, as of `EdgeData.slid`."""
        return np.sign(self._sliding @ PLANE_FRONTS[number].axis(direction, self._sliding.shape[1]))

    def shear_share(
        self, number: int, state: int, zone: SlipZone, line: Array, begin: float
    ) -> float:
        """Mean shear along a line over that of f p, as of `EdgeData.shear_share`."""
        front, contact = PLANE_FRONTS[number], self.contact
        position, traction = self.fits[number].position[state], contact.mean_traction[state]
        s = front.inward * (contact.surface.arc - position)
        middle = front.inward * (self.centre[state] - position)
        behind = (s > begin) & (s < middle) & (traction[:, 0] > 0)
        weights = contact.surface.weights[behind]
        bound = float((contact.friction.at(zone.end, behind) * weights) @ traction[behind, 0])
        shear = traction[behind, 1:] @ front.axis(line, traction.shape[1] - 1)
        return abs(float(weights @ shear)) / bound if bound > 0 else np.nan

    def completed(self, number: int, station: Station) -> Station:
        """The station with the friction work on its side of the contact."""
        arc, centre = self.contact.surface.arc, last_known(self.centre, self.cycle)
        here = nearest_front(arc, centre) == number
        work, spread = (float(each[here].sum()) for each in self.works)
        if station.still:  # what nodes do that open and close
            work, spread = 0.0, work + spread
        unseen = work == 0 and self.contact.friction.acts.any() and not station.still
        if unseen or any(zone.hides for zone in station.evaluated_zones):
            spread = math.inf  # that of nodes that do not slip is no measure of it
        return replace(station, dissipation=work, dissipation_spread=spread)


def with_stiff_elements(
    station: Station, contact: ContactHistory, degree: int, k_i: Array
) -> Station:
    """A station with the bars of K_N and of the edge that hold what stiffer bodies do.

    The pressure is that of P less a part of it, times 1 and that part. The edge moves with P as
    dK_I = K_N/2 da. Both have one sign and add to what fits may be off. The range has no bar where
    K_N is then not known to half of it.

    Args:
        station: whose bars are those of the fits.
        contact: whose elements grow.
        degree: of the displacements.
        k_i: (T,) K_I by all of P on the contact as it is.
    """
    too_stiff = TOO_STIFF[degree] * contact.surface.growth ** (2 * degree)
    place = station.position_spread + 2 * too_stiff * k_i / station.k_n
    bars = station.k_n_spread + too_stiff * station.k_n, place
    k_n, place = (np.where(np.isnan(each), math.inf, each) for each in bars)
    found = replace(station, k_n_spread=k_n, position_spread=place)
    # Where elements show no root of the pressure, the contact area of the increments is as vague.
    vague = math.isfinite(found.decisive_k_n[0]) and math.isnan(found.reported_k_n)
    if not vague:
        return found
    parts = replace(found.k_range_parts, discretisation=math.inf)
    return replace(found, k_range_parts=parts, k_range_spread=parts.total)


def moved_edge(
    contact: ContactHistory,
    neighbours: NearbyLoads,
    front: PlaneFront,
    half_width: float,
    exponent: float = 0.5,
) -> MovedEdge:
    """Movement of an edge between the two neighbours of a state, whose half-width is given.

    NaN if the edge does not move, or reaches the end of the surface. Between unlike bodies, whose
    edges shear moves as well, K_N is NaN, and the growth is that of the pressure behind the edge,
    which falls like s^exponent.
    """
    unknown = MovedEdge()
    if np.any(neighbours.pressure[:, [0, -1]] > 0):
        return unknown
    if np.count_nonzero(neighbours.pressure > 0, axis=1).min() < FEWEST_NODES:
        return unknown
    if contact.surface.dundurs:
        return MovedEdge(
            stiffening=_growth_behind(contact, neighbours.state, front, half_width, exponent)
        )
    sections = plane_sections(contact.surface.arc, neighbours.pressure)
    fits = [fit_edge(section, solved=True) for section in sections]
    beside = None if contact.beside is None else contact.beside[[neighbours.state] * 2]
    fit = with_gap(fits, contact, neighbours.pressure, beside)[front.number]
    outward = -front.inward * float(fit.position[1] - fit.position[0])
    # A jammed blade root presses less when it is pulled more: its edges move inward then.
    moved = abs(outward)
    if not moved > SMALLEST_MOVE * np.ptp(contact.surface.arc):
        return unknown
    # The last way is the one with the largest circle, which the edge stays away from.
    k_i = float(neighbours.k_i[-1, front.number])
    growth, vague = growth_with_edge(-front.inward * fit.position, fit.k_n, fit.spread_k_n)
    k_n = 2 * k_i / outward
    shift = float(np.linalg.norm(fit.spread_position)) / moved
    # If the edge moved less than it seems by as much, K_N is larger by more than that.
    between = shift / (1 - shift) if shift < 1 else np.inf
    spread = abs(k_n) * between + float(np.ptp(neighbours.k_i[:, front.number])) / moved
    return MovedEdge(
        k_n,
        spread,
        stiffening=growth + 0.5 / half_width,
        stiffening_spread=vague,
        state=neighbours.state,
    )


def growth_with_edge(position: Array, k_n: Array, spread: Array) -> tuple[float, float]:
    """Slope of ln K_N over the place of an edge in n states, and its error bar.

    The slope is that of least squares; the bar is what two bars of K_N do at both ends of the way,
    and infinite if there is none.

    Args:
        position: (n,) in the direction that counts.
        k_n: (n,) K_N.
        spread: (n,) error bars.
    """
    travel = float(np.ptp(position))
    if not travel > 0:
        return math.nan, math.inf
    slope = np.polyfit(position - position.mean(), np.log(k_n), 1)[0]
    return float(slope), math.sqrt(2 * float(np.mean((spread / k_n) ** 2))) / travel


def _growth_behind(
    contact: ContactHistory, state: int, front: PlaneFront, half_width: float, exponent: float
) -> float:
    """(d2P/da2)/(dP/da) between unlike bodies, from the pressure of a state behind an edge.

    With dP/da growing at the relative rate g a symmetric
    contact of half-planes has p^2 = K_N^2 s (1 + c s), c = 5/(6a) - 4g/3 (from (A0)).
    """
    x, pressure = contact.surface.arc, contact.mean_traction[state, :, 0]
    section = plane_sections(x, pressure[None])[front.number]
    s, p = section.s[0, : section.nodes[0]], section.values[0, : section.nodes[0]]
    risen = s[int(np.argmax(p >= RISEN * p.max()))]
    near = (s > 0) & (s <= risen)
    if np.count_nonzero(near) <= 2:  # a line through them tells nothing of how far it is off
        return math.nan
    slope, square = np.polyfit(s[near], p[near] ** (1 / exponent) / s[near], 1)
    return float(0.75 * (5 / (6 * half_width) - 2 * exponent * slope / square))


def unresolved(
    histories: FactorHistories, fits: Sequence[EdgeFit], arc: Array, cycle: Indices
) -> list[list[float]]:
    """Errors of the range of (K_T, K_S) over a cycle by elements, for each station.

    They are what integral and fits differ by, and what it means that a discrete contact area ends
    somewhere within an element: K_T goes with the root of its half-width, so that an error of the
    edge counts half, and by the largest range of all stations, since K_T of one may be a small
    difference.

    Args:
        histories: the factors.
        fits: position of each station, and its error bar.
        arc: (N,) nodes of the contact.
        cycle: states of the evaluated cycle.
    """
    directions = [direction for direction, _ in histories.directions(cycle)]
    mean = [*map(along_line, histories.ways.mean(axis=0), directions)]
    ranges = [cycle_range(each, cycle) for each in mean]
    shares = _misplaced(fits, arc, WITHIN_GRID if histories.exact else WITHIN_ELEMENT)
    others: list[list[float]] = [[] for _ in mean]
    if histories.fitted is not None:
        for apart, known, line, fitted in zip(
            others, ranges, directions, histories.fitted, strict=True
        ):
            found = cycle_range(along_line(fitted, line), cycle)
            # Where there are too few nodes for fits, integrals stand alone.
            apart.append(found - known if np.isfinite(found) else 0.0)
    return [
        [*misplaced_range(own, mean[int(np.argmax(ranges))], share, cycle), *other]
        for own, share, other in zip(mean, shares, others, strict=True)
    ]


def _misplaced(fits: Sequence[EdgeFit], arc: Array, elements: float) -> Array:
    """(2, T) half the error of each edge over the half-width; NaN where it is not known."""
    positions = np.array([fit.position for fit in fits])
    sizes = np.diff(arc)[np.clip(np.searchsorted(arc, positions) - 1, 0, arc.size - 2)]
    # The two errors are independent, but the larger one counts.
    errors = np.hypot(elements * sizes, [fit.spread_position for fit in fits])
    return np.asarray(errors / np.ptp(positions, axis=0))
