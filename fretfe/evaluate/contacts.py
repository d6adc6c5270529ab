# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts, their fronts and stations, and what an evaluation tells of them.

A front is a boundary curve of the contact area, a station a point of it with a frame. A plane
contact has two fronts, "left" and "right", of one station each: its edges. T is the number of
states; lengths, stresses and forces are in the units of the case, forces of plane contacts per unit
thickness.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Annotated, Any, get_origin, get_type_hints

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.caution import Caution
from fretfe.evaluate.friction_behind import FrictionBehind
from fretfe.local.problem import Tractions
from fretfe.reason import TOLD, Kind, Reason

# Error bar of K_N or of the range of K_T, relative to it, from which it is marked as uncertain.
LARGEST_SPREAD = 0.05
# The same of the length of a slip zone.
LARGEST_ZONE_SPREAD = 0.1
# Error bar, relative to its number, beyond which tables show no number.
NO_NUMBER = 0.5
# Range of (K_T, K_S) over f K_I that drives no slip worth the name, over less than .5 % of the
# Part of the hold of an edge within which it is at rest.
STILL = 1e-3
# half-width, and that which is round-off.
NOTHING = 0.02
ROUND_OFF = 1e-8
# The formulas hold for loads on a line: range across the direction of (K_T, K_S) over that along.
LARGEST_TURNING = 0.1
# Part of the largest P up to which a state whose contact has too few nodes is left out.
SMALL_LOAD = 0.1
# Distance from a free end over the slip zone by the factors from which these mean something: half
# of a dovetail has the same ranges within their bars there with layers of .2, .1 and .05 mm.
FAR_FROM_END = 3.0
# Error of a range over the square of the length of an element along the front over the distance to
# a free end, towards which ranges grow: a skewed dovetail with layers of 1.5, .2 and .1 mm.
NEAR_FREE_END = 0.06
# Counted cycles whose ranges differ by less than this fraction are the same cycle.
SAME_RANGE = 1e-3


@dataclass(frozen=True)
class Quantity:
    """Unit and meaning of a field, from which all tables take them.

    Attributes:
        kind: of quantity, a key of `fretfe.results.quantities.UNITS`; empty for pure numbers.
        meaning: in words.
        symbol: in tables and figures; empty if it has none.
    """

    kind: str
    meaning: str
    symbol: str = ""


@cache
def quantities(owner: type) -> Mapping[str, Quantity]:
    """The fields and properties of `Station` or `Contact` with unit and meaning, by name."""
    hints = get_type_hints(owner, include_extras=True)
    read = {name: each.fget for name, each in vars(owner).items() if isinstance(each, property)}
    hints |= {
        name: get_type_hints(each, include_extras=True)["return"] for name, each in read.items()
    }
    return {
        name: hints[name].__metadata__[0] for name in hints if get_origin(hints[name]) is Annotated
    }


def histories(owner: type) -> list[str]:
    """Names of the fields of `StationHistory` or `Contact` with a row for every state."""
    plain = get_type_hints(owner)
    return [name for name in quantities(owner) if plain.get(name) == Array]


def reported(value: float, spread: float) -> float:
    """A number with its error bar; NaN if the bar is unknown or more than half of the number."""
    return float(value) if spread <= NO_NUMBER * abs(value) else math.nan


def _reported_work(value: float, spread: float) -> float:
    return math.nan if spread > value > 0 or math.isinf(spread) else value


def uncertain_factor(value: float, spread: float) -> bool:
    """True if a factor is known to less than a twentieth, or not how well."""
    return math.isfinite(value) and not spread <= LARGEST_SPREAD * abs(value)


def known_length(length: float, spread: float) -> bool:
    """True if the length of a slip zone is known to a tenth or better, or there is no slip."""
    return length == 0 or spread <= LARGEST_ZONE_SPREAD * length


@dataclass(frozen=True)
class Frame:
    """Right-handed unit vectors of a station before deformation, (3,) each; NaN where unknown.

    Attributes:
        inward: normal of the front in the tangent plane of the contact, into the contact.
        along: tangent of the front, `across` x `inward`; in the plane out of it.
        across: outward normal of body 2.
    """

    inward: Array
    along: Array
    across: Array


@dataclass(frozen=True)
class SlipZone:
    """Slip at one station in one direction, from one reversal to the next.

    Attributes:
        start, end: states between which the nodes slipped: from a reversal to where it is longest.
        length: slip-zone length from the front at `end`, inward; NaN if the whole contact slipped.
        border: position along the arc of the inner end of all slip up to the next reversal.
        spread: half the width of an interval that is meant to hold `length` with 95 %: border of
            the slip, position of the front, and extremes of the cycle between the steps; infinite
            where it cannot be told.
        resolved: whether the mesh resolves the zone: its border and the front.
        gross: whether the whole contact slipped.
        predicted: slip length from K_T and K_N: 2 K_T/(f K_N) for first loading, ΔK_T/(f K_N) in
            the evaluated cycle; NaN elsewhere, and where (K_T, K_S) turns.
        predicted_loop: the same with varying normal load, from `end`; NaN outside the cycle, but
            not where the edge draws back over the zone later on.
        across: the mean shear across the direction of (K_T, K_S) over that of f p, behind the
            predicted zone and when the half cycle begins; NaN in the plane without motion along z.
        flank: mean shear along that direction over that of f p, farther behind and at `end`, where
            the mesh does not resolve the zone; NaN elsewhere.
        missed: length by which the zone is longer, as predicted, since it ends between two steps.
        local: between solids the length by the plane problem next to the station, whose pressure
            and shear follow from its factors; NaN where that is not solved.
        local_spread: its error bar: by those of K_N and of the range, by the shape of the contact
            behind the edge, and by the elements of the plane problem.
        unknown: whether nothing is known of the zone, but that there may be one: the coefficient
            falls meanwhile, so that points slip though no factor changes.
    """

    start: int
    end: int
    length: float
    border: float
    spread: float
    resolved: bool
    gross: bool
    predicted: float
    predicted_loop: float
    across: float = field(default=math.nan, kw_only=True)
    flank: float = field(default=math.nan, kw_only=True)
    missed: float = field(default=0.0, kw_only=True)
    local: float = field(default=math.nan, kw_only=True)
    local_spread: float = field(default=math.nan, kw_only=True)
    unknown: bool = field(default=False, kw_only=True)

    @classmethod
    def untold(cls, start: int, end: int, foretold: float | None = None) -> SlipZone:
        """A zone of which nothing is known, as where friction falls, or its prediction alone."""
        lost, unknown = math.nan, foretold is None
        loop = lost if foretold is None else foretold
        return cls(start, end, lost, lost, math.inf, False, False, lost, loop, unknown=unknown)

    @property
    def reported_length(self) -> float:
        """The length, unless its error bar is unknown or more than half of it: then NaN.

        No slip is 0, with its bar; NaN where a zone may hide between the nodes.
        """
        if self.length == 0:
            return math.nan if self.hides else 0.0
        return reported(self.length, self.spread)

    @property
    def hides(self) -> bool:
        """True if no node slips, but a zone of a length up to `spread` may lie between them."""
        return self.length == 0 and not self.resolved

    @property
    def reported_local(self) -> float:
        """The length by the plane problem, unless its bar is more than half of it: then NaN."""
        return 0.0 if self.local == 0 else reported(self.local, self.local_spread)

    @property
    def told(self) -> tuple[float, float]:
        """The length to tell with its error bar: by the plane problem, else by the nodes."""
        if math.isfinite(self.reported_local):
            return self.reported_local, self.local_spread
        return self.reported_length, self.spread

    @property
    def rank(self) -> float:
        """The length within steps, as well as it is known, by which the longer zone is found."""
        if self.gross or self.unknown:
            return math.inf
        longer = self.missed + np.array([self.local, self.length, self.prediction, math.inf])
        return next(float(each) for each in (self.told[0], *longer) if not math.isnan(each))

    @property
    def within_step(self) -> bool:
        """True if the steps leave its length open, not the mesh."""
        return self.resolved and 2 * self.missed > self.spread

    @property
    def uncertain(self) -> bool:
        """True if the mesh does not resolve the zone, or its length is known to a tenth at best."""
        return not (self.gross or (self.resolved and known_length(self.length, self.spread)))

    @property
    def prediction(self) -> float:
        """Predicted length to compare with: `predicted_loop` in the cycle, else `predicted`."""
        return self.predicted_loop if np.isfinite(self.predicted_loop) else self.predicted


@dataclass(frozen=True)
class CountedCycles:
    """Cycles of a station, counted by the rainflow method: n of them.

    Attributes:
        start, end: (n,) states of the two reversals. `start` may be the later one in a cycle that
            repeats itself: the range then goes on in the next repetition.
        count: (n,) 1, or 0.5 for a range that nothing closes.
        k_t_range, k_t_mean: (n,) difference of K_T at the two reversals, positive, and its mean.
        slip: (n,) predicted length of the slip zone by that range; NaN where K_N is unknown at
            `end`, P moves the edge in between, or (K_T, K_S) turns.
        closed: whether the history that was counted repeats itself: all counts are 1.
        reason: why nothing was counted; empty if it was.
    """

    start: Annotated[Indices, Quantity("", "state of the first reversal")]
    end: Annotated[Indices, Quantity("", "state of the second reversal")]
    count: Annotated[Array, Quantity("", "1, or 0.5 for a range that nothing closes")]
    k_t_range: Annotated[Array, Quantity("k_t", "difference of the two, positive")]
    k_t_mean: Annotated[Array, Quantity("k_t", "mean of the two")]
    slip: Annotated[Array, Quantity("length", "slip length by that range")]
    closed: bool
    reason: str

    @property
    def worst(self) -> int:
        """Number of the cycle with the largest range of K_T, the last one of equal ones.

        Raises:
            ValueError: if there is none.
        """
        size = self.k_t_range
        return int(np.flatnonzero(size >= (1 - SAME_RANGE) * size.max())[-1])

    @property
    def irregular(self) -> bool:
        """True if the cycles differ, those aside in which the history begins and ends."""
        inner = self.k_t_range[~self._outermost]
        return len(inner) > 1 and bool(np.ptp(inner) > SAME_RANGE * inner.max())

    @property
    def _outermost(self) -> Bools:
        """(n,) half cycles of first loading, and those that the end of the history cuts off."""
        if self.closed or not len(self.count):
            return np.zeros(len(self.count), dtype=bool)
        ends = (self.start == self.start.min()) | (self.end == self.end.max())
        return np.asarray((self.count < 1) & ends)


def no_cycles(reason: str) -> CountedCycles:
    """No counted cycles, and why."""
    none, states = np.zeros(0), np.zeros(0, dtype=np.int64)
    return CountedCycles(states, states, none, none, none, none, False, reason)


@dataclass(frozen=True)
class StationHistory:
    """Position and factors of a station in every state.

    Arrays are (T,), NaN where there is no contact or a number is not known. (K_T, K_S) and K_I are
    counted from the first state with friction, or in contact, or the first one from which on they
    are known; before they are NaN. K_T is the factor of the shear along `frame.inward`, K_S of that
    along `frame.along`.

    Attributes:
        front: name of its front.
        friction_behind: coefficient behind the edge, where it is not the same everywhere.
    """

    front: str
    number: Annotated[int, Quantity("", "of the station along its front, from 0")]
    position: Annotated[
        Array, Quantity("length", "of the edge; of solids from the point of the station, inward")
    ]
    position_spread: Annotated[Array, Quantity("length", "its error bar")]
    k_n: Annotated[Array, Quantity("k_n", "K_N in the state", "K_N")]
    k_n_spread: Annotated[Array, Quantity("k_n", "its error bar")]
    k_t: Annotated[Array, Quantity("k_t", "K_T, counted from the first state", "K_T")]
    k_s: Annotated[Array, Quantity("k_t", "K_S, the same along the edge; zero in the plane", "K_S")]
    k_i: Annotated[Array, Quantity("k_t", "K_I, the same of normal increments", "K_I")]
    hold: Annotated[Array, Quantity("k_t", "K_I with the edge as large as in one state")]
    shear: Annotated[Array, Quantity("k_t", "K along its main direction, likewise")]
    unit: Annotated[Array, Quantity("", "factors of the edge as it is over those")]
    slid: Annotated[Array, Quantity("", "way in which all slips in the step to the state, or 0")]
    last: Annotated[int, Quantity("", "last state of the evaluated cycle, or of all")] = field(
        default=-1, kw_only=True
    )
    first: Annotated[int, Quantity("", "first state of that cycle, -1 without")] = field(
        default=-1, kw_only=True
    )
    loose: Annotated[
        float, Quantity("", "part of the range of that shear which cycles leave over")
    ] = field(default=0.0, kw_only=True)
    apart: Annotated[
        float, Quantity("", "second over first of the independent parts of what drives the shear")
    ] = field(default=0.0, kw_only=True)
    decisive: Annotated[
        int, Quantity("", "reversal of K_T with the larger P: of K_N and position in tables")
    ] = field(default=-1, kw_only=True)
    friction_behind: FrictionBehind = field(default_factory=FrictionBehind, kw_only=True)

    @property
    def inward(self) -> int:
        """Sign of inward in positions: -1 at the right edge of a plane contact, else 1."""
        return -1 if self.front == "right" else 1

    def at_rest(self, start: int, end: int, within: float = STILL) -> bool:
        """True if P does not move the edge between two states, but for a part of its hold."""
        hold = self.hold[start : end + 1]
        most = hold.max(initial=0.0)
        return bool(most - hold.min(initial=math.inf) <= within * most)

    @property
    def decisive_k_n(self) -> tuple[float, float]:
        """K_N in the state `decisive`, and its error bar."""
        return float(self.k_n[self.decisive]), float(self.k_n_spread[self.decisive])

    @property
    def reported_k_n(self) -> float:
        """K_N in the state `decisive`; NaN if its bar is unknown or more than half of it."""
        return reported(*self.decisive_k_n)


@dataclass(frozen=True)
class RangeSpread:
    """Parts of the error bar of a range of K_T, each half the width of a 95 % interval.

    Attributes:
        extraction: half the difference of the ranges that the radii of the interaction integral
            give; 0 if K_T is known in closed form, NaN if nothing can be compared.
        discretisation: difference from the range by fits to tractions, and what near cuts leave
            open.
        steps: how far K_T exceeds the range between the steps.
        layer: what a layer between the surfaces gives.
        moved: what the movement of the edge within steps may change, and what those contribute of
            which one end is unknown.
        beside: what may lie in states of the cycle in which there is no edge.
    """

    extraction: float
    discretisation: float
    steps: float
    layer: float = 0.0
    moved: float = 0.0
    beside: float = 0.0

    @property
    def total(self) -> float:
        """All parts together; NaN if one is unknown."""
        return math.hypot(*vars(self).values())


@dataclass(frozen=True)
class LocalProblem:
    """The plane problem next to a station, with three displacement components.

    Attributes:
        half_width: of the contact of half-planes that stands for the edge; NaN without a solution.
        power: of the gap of its bodies, |x|^power.
        slip: largest slip of the last half cycle, at the edge.
        work: friction work in the evaluated cycle, or in all steps without one, per unit length of
            the front.
        change: of the shear over the last cycle, over the swing of the force.
        tractions: next to the edge, at the ends of the half cycle of the longest slip zone, which
            has two but where nothing acts before it. The mean of the shear
            behind the slip zone is not known where the contact slid before the cycle.
        reason: why there is no solution, in words; empty if there is.
    """

    half_width: float
    power: float
    slip: Annotated[float, Quantity("length", "largest slip by it, in the last half cycle")]
    work: Annotated[float, Quantity("work per length", "friction work by it")]
    change: Annotated[float, Quantity("", "its change over the last cycle")]
    tractions: tuple[Tractions, ...]
    reason: Annotated[str, Quantity("", "why it is not solved")]


def no_local_problem(reason: str) -> LocalProblem:
    """A plane problem that is not solved, and why."""
    return LocalProblem(math.nan, math.nan, math.nan, math.nan, math.nan, (), reason)


@dataclass(frozen=True, kw_only=True, repr=False)
class Station(StationHistory):
    """A point of a contact front, evaluated.

    Ranges are those over the evaluated cycle, NaN without one, or where a factor is unknown in one
    of its states. In the plane `position` is that along the arc, (K_T, K_S) is K_T unless bodies
    move along z, and a front has no curvature and no ends. Between solids `position` is the
    distance of the front from `point` along `frame.inward`. Cycles are counted of K along
    `k_angle`.

    Attributes:
        frame: in the plane in the state `decisive`, or the last one in which the position is known,
            of solids before deformation.
        point: (3,) place before deformation: in the plane in the same state as `frame`, of solids
            on the front in the reference state; NaN where unknown.
        curvature: positive where the contact is convex.
        to_end: infinite on a front that does not end with the bodies, NaN in the plane.
        length: half-width of the Hertzian contact whose pressure falls behind K_N sqrt(s) as fast.
        k_n_moved: from the movement of the front between two load levels, 2 dK_I/da; not known
            between dissimilar bodies with friction either.
        stiffening: relative growth of dP/da with the half-width a in the last state, from the same
            two loads; it tells how long a slip zone may be for the edge description. Of solids by
            `length`, the depth of the contact and the bend of the front.
        lack: why K_N in the state `decisive`, or the range, or nothing at all is known: it is no
            edge as the bodies go on behind it, or fretfe failed.
        k_angle: in degrees, between -90 and 90.
        k_range_spread: half the width of an interval that is meant to hold `k_range` with 95 %; 0
            if the factors are known in closed form at any time, NaN if nothing can be compared.
        k_range_parts: what that is made of.
        equivalent_range: at constant P the range of K. NaN without a cycle, or if all slides.
        largest_range: of all half cycles of the whole history in which the contact does not slide
            as a whole. First loading counts only if P moves the edge after it, or nothing follows.
        cycles: counted in the evaluated cycle, or in the whole history without one.
        slip_zones: one for each half cycle, in time order; if the counted cycles are irregular,
            only those of the worst one.
        dissipation: on this side of the contact, per unit thickness; NaN of solids.
    """

    frame: Frame
    point: Annotated[Array, Quantity("length", "point of the station before deformation")] = field(
        default_factory=lambda: np.full(3, np.nan)
    )
    arc: Annotated[float, Quantity("length", "place along the front")] = 0.0
    curvature: Annotated[float, Quantity("curvature", "of the front in the tangent plane")] = 0.0
    to_end: Annotated[
        float, Quantity("length", "distance to the nearer free end of the front; empty without one")
    ] = math.nan
    size: Annotated[float, Quantity("length", "an element across the front")] = 0.0
    depth: Annotated[
        float, Quantity("length", "half of the width of the contact inward; NaN in the plane")
    ] = math.nan
    length: Annotated[
        float, Quantity("length", "over which K_N makes the pressure; NaN in the plane")
    ] = math.nan
    end: Annotated[bool, Quantity("", "whether it is too near an end for a verdict")] = False
    lack: Reason = TOLD
    k_n_moved: Annotated[float, Quantity("k_n", "K_N by the movement of the front")]
    k_n_moved_spread: Annotated[float, Quantity("k_n", "its error bar")]
    k_n_moved_reason: Annotated[str, Quantity("", "why that is not known")] = ""
    stiffening: Annotated[
        float, Quantity("curvature", "relative growth of dP/da with the half-width a")
    ] = math.nan
    stiffening_spread: Annotated[float, Quantity("curvature", "its error bar; 0 of solids")] = 0.0
    k_t_range: Annotated[float, Quantity("k_t", "range of K_T over the evaluated cycle", "ΔK_T")]
    k_s_range: Annotated[float, Quantity("k_t", "range of K_S")] = 0.0
    k_range: Annotated[
        float, Quantity("k_t", "range of (K_T, K_S) along the direction in which it varies most")
    ]
    k_angle: Annotated[float, Quantity("angle", "that direction, from inward towards along")] = 0.0
    turning: Annotated[float, Quantity("", "range across that direction over that along it")] = 0.0
    k_range_spread: Annotated[float, Quantity("k_t", "its error bar")]
    k_range_parts: RangeSpread
    k_t_range_fitted: Annotated[
        float, Quantity("k_t", "k_range by fits to the tractions of full stick; NaN without")
    ] = math.nan
    k_i_range: Annotated[float, Quantity("k_t", "range of K_I")]
    reference_length: Annotated[
        float,
        Quantity("length", "at which K_N is told between unlike bodies; NaN between similar ones"),
    ] = math.nan
    exponent: Annotated[
        float, Quantity("", "lambda of the pressure, s^lambda, in the state `decisive`")
    ] = 0.5
    oscillation: Annotated[
        float, Quantity("", "epsilon of full stick; zero between similar bodies")
    ] = 0.0
    coupling: Annotated[
        float, Quantity("", "f times |beta| of unlike bodies, of which formulas leave out a part")
    ] = 0.0
    friction: Annotated[
        float, Quantity("", "coefficient at the edge in the step to the state `decisive`")
    ] = math.nan
    equivalent_range: Annotated[
        float, Quantity("k_t", "f K_N d of the evaluated cycle by the memory of the edge")
    ] = math.nan
    equivalent_misheld: Annotated[
        float, Quantity("k_t", "part of its bar by drivers out of phase and by where edges move")
    ] = 0.0
    equivalent_end: Annotated[int, Quantity("", "state in which its zone is longest, or 0")] = 0
    largest_start: Annotated[int, Quantity("", "first state of the largest half cycle of all")] = 0
    largest_end: Annotated[int, Quantity("", "state in which its zone is longest; 0 without")] = 0
    largest_range: Annotated[float, Quantity("k_t", "its f K_N d by the memory")] = math.nan
    largest_slip: Annotated[float, Quantity("length", "its d by the memory of the edge")] = math.nan
    cycles: CountedCycles
    slip_zones: tuple[SlipZone, ...]
    dissipation: Annotated[float, Quantity("work", "friction work at the edge in the cycle")] = (
        math.nan
    )
    dissipation_spread: Annotated[
        float, Quantity("work", "error bar of that; NaN of solids and closed forms")
    ] = math.nan
    local: LocalProblem = field(default_factory=lambda: no_local_problem("it was not solved"))

    def __repr__(self) -> str:
        """One line: its place and its factors."""
        return (
            f"<Station {self.front}.{self.number}: K_N {self.decisive_k_n[0]:.4g}, "
            f"range of K {self.k_range:.4g}>"
        )

    @property
    def no_edge(self) -> bool:
        """True at a plane of symmetry, behind which the contact goes on."""
        return self.lack.kind is Kind.NO_EDGE

    @property
    def reported_dissipation(self) -> float:
        """Friction work; NaN if its error bar is larger."""
        return _reported_work(self.dissipation, self.dissipation_spread)

    @property
    def direction(self) -> Array:
        """(2,) unit vector at `k_angle`, along which (K_T, K_S) varies most."""
        angle = math.radians(self.k_angle)
        return np.array([math.cos(angle), math.sin(angle)])

    @property
    def k_along(self) -> Array:
        """(T,) the vector (K_T, K_S) along `k_angle`; K_T in the plane without motion along z."""
        inward, along = self.direction
        return np.asarray(inward * self.k_t + along * self.k_s)

    @property
    def stick_border(
        self,
    ) -> Annotated[
        float, Quantity("length", "border of permanent stick by both, from the point, inward")
    ]:
        """Place of the border of permanent stick by the plane problem, as `position`; else NaN.

        That is the farthest inner end of the slip zones of the last two half cycles, and what slip
        of nodes comes deeper before or after they are longest.
        """
        zones = self.slip_zones[-2:]
        # What the inner ends count from: farther inward than the front where slip comes deeper.
        starts = [
            zone.border - zone.length if zone.length >= 0 else self.position[zone.end]
            for zone in zones
        ]
        inner = [start + zone.reported_local for start, zone in zip(starts, zones, strict=True)]
        return float(max(inner)) if inner and np.isfinite(inner).all() else math.nan

    @property
    def longest_zone(self) -> SlipZone | None:
        """The longest slip zone of `evaluated_zones`, the last of equal ones; None without any.

        Every verdict that stands alone for a station is on this one. Where no length is told it is
        ranked by what is known of it.
        """
        return max(self.evaluated_zones[::-1], key=lambda each: each.rank, default=None)

    @property
    def slides(self) -> bool:
        """True if the whole contact slips in a half cycle: no length is found, and none meant."""
        return self.longest_zone is not None and self.longest_zone.gross

    @property
    def evaluated_zones(self) -> tuple[SlipZone, ...]:
        """Slip zones that end in the evaluated cycle, in time order; all without any."""
        inside = [zone for zone in self.slip_zones if zone.end > self.first >= 0]
        return tuple(inside) or self.slip_zones

    @property
    def still(self) -> bool:
        """True if nothing slips, and nodes would show it: friction work is zero within its bar."""
        zones = self.evaluated_zones
        return bool(zones) and all(zone.length == 0 and zone.resolved for zone in zones)

    def longest_by(self, length: Callable[[SlipZone], float]) -> SlipZone | None:
        """The zone of `evaluated_zones` of which some length is largest; None without any.

        That is `longest_zone` where the length of that is not known, and may be the largest.
        """
        longest = self.longest_zone
        if longest is None or math.isnan(length(longest)):
            return longest
        known = [zone for zone in self.evaluated_zones if not math.isnan(length(zone))]
        return max(known[::-1], key=length)

    @property
    def places(self) -> Array:
        """(T, 3) places of the front before deformation, NaN where unknown."""
        return self.point + self.position[:, None] * self.frame.inward

    @property
    def reversals(self) -> Array:
        """(2, n) K_T at both reversals of the counted cycles, which may lie within steps."""
        cycles = self.cycles
        way = self.k_along[cycles.end] - self.k_along[cycles.start]
        half = np.copysign(cycles.k_t_range / 2, way)
        return np.array([cycles.k_t_mean - half, cycles.k_t_mean + half])

    @property
    def moves(self) -> bool:
        """True if P moves the edge in the cycle, so that slip goes by what the edge remembers."""
        return math.isfinite(self.equivalent_range) and not self.at_rest(self.first, self.last)

    @property
    def driven_range(self) -> tuple[float, float]:
        """The range that slip follows, with its bar: the equivalent one where P moves the edge."""
        if not self.moves:
            return self.k_range, self.k_range_spread
        # Where the edge was in a step is no matter for what it remembers, nor what was without it.
        spread = replace(self.k_range_parts, moved=0.0, beside=0.0).total
        if self.k_range > 0:
            spread *= max(self.equivalent_range / self.k_range, 1.0)
        return self.equivalent_range, math.hypot(spread, self.equivalent_misheld)

    @property
    def equivalent_spread(self) -> Annotated[float, Quantity("k_t", "bar of equivalent_range")]:
        """Error bar of the range that slip follows."""
        return self.driven_range[1]

    @property
    def range_error(self) -> float:
        """Error bar of the range that slip follows over it; 0 without any."""
        size, spread = self.driven_range
        return spread / size if size > 0 else 0.0

    @property
    def slip_by_range(self) -> float:
        """|ΔK|/(f K_N), with the coefficient at the edge; NaN if one of both is not told."""
        return self.reported_range / (self.friction * self.reported_k_n or math.nan)

    @property
    def undriven(self) -> bool:
        """True if the range that slip follows is zero within its bar, and that drives nothing.

        As where P alone varies, or by round-off.
        """
        scale = self.friction * float(np.nanmax(np.abs(self.k_i), initial=0.0))
        size, spread = self.driven_range
        return size <= max(spread, ROUND_OFF * scale) and size + spread <= NOTHING * scale

    @property
    def told_range(self) -> tuple[float, float]:
        """The range to tell with its error bar: 0, and all of it, if undriven."""
        size, spread = self.driven_range
        if self.undriven:
            return 0.0, size + spread
        # Where nothing slips the sum of the increments tells how much the bar is.
        told = math.isfinite(reported(max(size, self.k_range), spread))
        return size if told else math.nan, spread

    @property
    def reported_range(self) -> float:
        """The range to tell; NaN if its error bar is unknown or more than half of it."""
        return self.told_range[0]

    @property
    def uncertain(self) -> bool:
        """True if the fits of K_N in the state `decisive` spread too far for a prediction."""
        return uncertain_factor(*self.decisive_k_n)

    @property
    def uncertain_range(self) -> bool:
        """True if the range of (K_T, K_S) is known to less than a twentieth, or not how well."""
        size, spread = self.driven_range
        return not self.undriven and uncertain_factor(max(size, self.k_range), spread)

    @property
    def defined(self) -> bool:
        """True if it has factors of its own: it is not near an end, or far from it against d.

        Nearer to a free end than the width of the field of K_N slip is not that of an edge, but the
        loading increments of full stick have factors as far as slip zones are short.
        """
        return not self.end or self.to_end > FAR_FROM_END * self.slip_by_range

    def told_prediction(self, zone: SlipZone) -> float:
        """Predicted length of a slip zone; NaN where K_N or the range in it is not told."""
        k_n = reported(float(self.k_n[zone.end]), float(self.k_n_spread[zone.end]))
        ranged = math.isfinite(self.reported_range) or not self.k_range > 0
        if self.undriven or (ranged and zone.prediction == 0):
            return 0.0
        return zone.prediction if ranged and math.isfinite(k_n) else math.nan


def without_formulas(station: Station) -> Station:
    """The station without predicted lengths if (K_T, K_S) turns: there is no formula then."""
    if not station.turning > LARGEST_TURNING:
        return station
    return replace(
        station,
        largest_slip=math.nan,
        equivalent_range=math.nan,
        cycles=replace(station.cycles, slip=np.full_like(station.cycles.slip, math.nan)),
        slip_zones=tuple(
            replace(zone, predicted=math.nan, predicted_loop=math.nan)
            for zone in station.slip_zones
        ),
    )


def unknown_station(front: str, number: int, states: int, lack: Reason) -> Station:
    """A station of which nothing is known.

    Args:
        front: name of its front.
        number: of it along the front.
        states: T.
        lack: why.
    """
    lost, nowhere = np.full(states, math.nan), np.full(3, math.nan)
    unknown: dict[str, Any] = dict.fromkeys(histories(StationHistory), lost)
    return Station(
        front=front,
        number=number,
        **unknown,
        frame=Frame(nowhere, nowhere, nowhere),
        k_n_moved=math.nan,
        k_n_moved_spread=math.nan,
        k_n_moved_reason=lack.text,
        k_t_range=math.nan,
        k_s_range=math.nan,
        k_range=math.nan,
        k_range_spread=math.nan,
        k_range_parts=RangeSpread(math.nan, math.nan, math.nan),
        k_i_range=math.nan,
        cycles=no_cycles(lack.text),
        slip_zones=(),
        lack=lack,
    )


@dataclass(frozen=True)
class HalfSpaceRatios:
    """Ratios of the factors found around a front to those of half-spaces under the same forces.

    NaN where there is no such force. Means over the stations, by least squares.

    Attributes:
        half_axes: (2,) of the ellipse, the longer one first.
        shear: of (K_T, K_S) to those of the shear force.
        twist: of K_S to that of the moment about the normal; circles only.
        normal: of K_I to that of P.
        pressure: of K_N to that of dP/da, between two loads.
        reason: why there are no ratios, in words; empty if there are.
    """

    half_axes: Array
    shear: float
    twist: float
    normal: float
    pressure: float
    reason: str


NO_RATIOS = HalfSpaceRatios(np.full(2, np.nan), np.nan, np.nan, np.nan, np.nan, "")


@dataclass(frozen=True)
class Front:
    """A boundary curve of a contact area, as its stations along it; at least one.

    Attributes:
        name: in the plane "left" or "right", of solids "front 1" and so on, the longest first, and
            borders along which no front can be followed last.
        stations: along it at an even spacing.
        closed: whether it runs into itself.
        length: of it in the reference state, the last one of the evaluated cycle; NaN in the plane.
        half_space_ratios: its factors against those of half-spaces under the same forces.
        patch: number of its patch in `Contact.patches`, from 1; 0 where the area is a single one.
        local_work: of solids the friction work by the plane problems of its stations, that of each
            over its part of the length, as for `Contact.dissipation`; NaN without any.
        local_length: length of the parts whose stations have a plane problem.
    """

    name: str
    stations: tuple[Station, ...]
    closed: bool = False
    length: float = math.nan
    half_space_ratios: HalfSpaceRatios = NO_RATIOS
    patch: int = 0
    local_work: float = math.nan
    local_length: float = 0.0

    @property
    def lost(self) -> bool:
        """True if it is a border of the contact area along which no front can be followed."""
        return self.stations[0].lack.kind is Kind.LOST

    @property
    def judged(self) -> tuple[Station, ...]:
        """Stations that are not marked as too near an end."""
        return tuple(station for station in self.stations if not station.end)

    @property
    def defined(self) -> tuple[Station, ...]:
        """Stations that have factors of their own, those near an end among them."""
        return tuple(station for station in self.stations if station.defined)

    @property
    def worst(self) -> Station | None:
        """Of the stations with factors of their own that of the largest |ΔK|; None without any."""
        return worst_of(each for each in self.defined if np.isfinite(each.reported_range))

    def along(self, attribute: str) -> Array:
        """(n,) a number of all stations, by the name of the attribute."""
        return np.array([getattr(station, attribute) for station in self.stations])


def worst_of(stations: Iterable[Station]) -> Station | None:
    """The station of the largest range, in a cycle or of all; of the largest K_N without any.

    The first one of equal ones; None where nothing is known.
    """

    def severity(station: Station) -> list[float]:
        sizes = station.reported_range, station.largest_range, station.reported_k_n
        return [each if math.isfinite(each) else -1.0 for each in sizes]

    return max((e for e in stations if max(severity(e)[::2]) > -1.0), key=severity, default=None)


def fronts_of(stations: Iterable[Station]) -> tuple[Front, ...]:
    """The fronts that stations belong to, in the order in which they occur."""
    named: dict[str, list[Station]] = {}
    for station in stations:
        named.setdefault(station.front, []).append(station)
    return tuple(Front(name, tuple(each)) for name, each in named.items())


@dataclass(frozen=True)
class AreaPatch:
    """One of several patches of the contact area of solids.

    Histories are (T,), vectors (T, 3): zero where the patch does not touch, NaN where it cannot be
    told from others. In the plane each patch is a contact of its own.

    Attributes:
        name: that of the contact with a number in brackets, the largest P in the state that has the
            fronts first.
        reason: why it has no fronts, or cannot be told from others, and when; empty if it always
            can.
    """

    name: str
    normal_force: Annotated[Array, Quantity("force", "P, integral of the pressure")]
    shear_force: Annotated[Array, Quantity("force", "Q, integral of the shear on body 2")]
    contact_area: Annotated[Array, Quantity("area", "of the nodes under pressure")]
    reason: str


def _none() -> Array:
    return np.empty(0)


@dataclass(frozen=True, kw_only=True, repr=False)
class Contact:
    """One contact, evaluated: a surface pair, or one of several patches of it.

    Forces are per unit thickness in the plane; between solids vectors (T, 3) are in the axes of the
    case. Areas are widths in the plane. They belong to the nodes, which count as a whole: areas
    grow in steps of an element. Histories are (T,), of solids vectors (T, 3); those that a backend
    does not know are (0,), as `half_width` and `effective_tension` of solids are.

    Attributes:
        name: that of the pair; with a number in brackets for one of several patches.
        pair: name of the surface pair, the contact in the case.
        fronts: in the plane left and right; between solids the boundary curves of the contact area,
            none where they cannot be told.
        shear_force: (T,) Q along the arc; (T, 3) of solids, integral of the shear traction that
            body 1 exerts on body 2.
        force: (T, d), as `shear_force`; on curved surfaces the pressure has a share in every
            component.
        centre: NaN where nothing presses.
        moment: of solids (T, 3), of all tractions on body 2.
        half_width: NaN where there is no contact.
        effective_tension: gives half-planes the same mean of K_T over the two fronts, counted like
            K_T.
        shear_mismatch: (range of Q that half-planes need for K_T at the two fronts)/(range of Q of
            full stick) - 1 over the cycle: zero if the half-plane description holds; NaN without a
            cycle, and of solids.
        steady: False without a cycle.
        dissipation_change: NaN if there is no cycle before.
        lack: why solids that carry a force have no fronts at the end of the cycle; those there are
            belong to the state of the largest contact.
        warnings: what a reader must know.
        patches: of the contact area of solids; none where it is a single one, and in the plane.
    """

    name: str
    pair: str
    fronts: tuple[Front, ...]
    normal_force: Annotated[Array, Quantity("force", "P, integral of the pressure", "P")]
    shear_force: Annotated[Array, Quantity("force", "Q, integral of the shear on body 2", "Q")]
    force: Annotated[Array, Quantity("force", "all on body 2")] = field(default_factory=_none)
    centre: Annotated[
        Array, Quantity("length", "middle between the two edges, of solids the centre of pressure")
    ]
    moment: Annotated[
        Array, Quantity("moment", "moment about the centre, in the plane of the pressure")
    ]
    half_width: Annotated[Array, Quantity("length", "half the distance between the edges")] = field(
        default_factory=_none
    )
    contact_area: Annotated[
        Array, Quantity("area", "of the nodes in contact, in the plane their width", "area")
    ] = field(default_factory=_none)
    stick_area: Annotated[Array, Quantity("area", "of those that stick", "sticks")] = field(
        default_factory=_none
    )
    largest_pressure: Annotated[
        Array, Quantity("stress", "largest mean around a node", "p_max")
    ] = field(default_factory=_none)
    work: Annotated[Array, Quantity("work", "friction work in the step to the state", "work")] = (
        field(default_factory=_none)
    )
    effective_tension: Annotated[
        Array, Quantity("stress", "bulk tension that half-planes need for these K_T", "σ0")
    ] = field(default_factory=_none)
    shear_mismatch: Annotated[
        float, Quantity("", "range of Q by half-planes over that of full stick, less 1")
    ] = math.nan
    cycle_change: Annotated[
        float, Quantity("", "change of the shear over the evaluated cycle, by the friction bound")
    ]
    steady: Annotated[bool, Quantity("", "whether the cycle is steady")]
    dissipation: Annotated[
        float, Quantity("work", "friction work in the evaluated cycle, or of all steps without one")
    ]
    dissipation_spread: Annotated[
        float, Quantity("work", "error bar of that; NaN of closed forms")
    ] = math.nan
    dissipation_change: Annotated[
        float, Quantity("", "relative change of that from the cycle before")
    ]
    smallest_normal_force: Annotated[
        float, Quantity("force", "smallest P in the cycle, also within steps")
    ] = math.nan
    largest_normal_force: Annotated[float, Quantity("force", "largest P then")] = math.nan
    smallest_shear_force: Annotated[float, Quantity("force", "smallest Q, of solids |Q|")] = (
        math.nan
    )
    largest_shear_force: Annotated[float, Quantity("force", "largest Q, of solids |Q|")] = math.nan
    sliding_share: Annotated[
        float, Quantity("", "share of the time of the cycle in which all of the contact slips")
    ] = 0.0
    sliding_range: Annotated[
        float, Quantity("length", "range of the mean slip of the contact in that time")
    ] = 0.0
    lack: Reason = TOLD
    warnings: tuple[Caution, ...]
    patches: tuple[AreaPatch, ...] = ()

    def __repr__(self) -> str:
        """One line: its name, how many states, and its fronts."""
        fronts = ", ".join(f"{each.name} ({len(each.stations)})" for each in self.fronts)
        return f"<Contact {self.name!r}: {len(self.force)} states, stations of fronts {fronts}>"

    @property
    def shear_vectors(self) -> Array:
        """(T, d - 1) Q in the plane: along the arc and, where bodies move along z, along z."""
        across = self.force[:, 2:] if self.force.ndim == 2 else np.zeros((len(self.shear_force), 0))
        return np.column_stack([self.shear_force, across])

    @property
    def solid(self) -> bool:
        """True between solids."""
        return self.shear_force.ndim == 2

    @property
    def stations(self) -> tuple[Station, ...]:
        """The stations of all fronts in one row: in the plane the left and the right edge."""
        return tuple(station for front in self.fronts for station in front.stations)

    @property
    def reported_dissipation(self) -> float:
        """Friction work; NaN if its error bar is larger."""
        return _reported_work(self.dissipation, self.dissipation_spread)

    @property
    def local_dissipation(
        self,
    ) -> Annotated[float, Quantity("work", "friction work by the plane problems of solids")]:
        """Friction work as `dissipation`, by the plane problems along the fronts; NaN without any.

        Parts of the fronts whose stations have none are left out: see `local_share`.
        """
        known = [front.local_work for front in self.fronts if math.isfinite(front.local_work)]
        return sum(known) if known else math.nan

    @property
    def local_share(
        self,
    ) -> Annotated[float, Quantity("", "share of the fronts' length that has plane problems")]:
        """Share of the length of the fronts whose stations have a plane problem."""
        lengths = [(front.local_length, front.length) for front in self.fronts]
        known, whole = np.sum(lengths, axis=0) if lengths else (0.0, math.nan)
        return float(known / whole)

    @property
    def edges(self) -> tuple[Station, ...]:
        """The stations but for ends at planes of symmetry, which are no edges."""
        return tuple(station for station in self.stations if not station.no_edge)

    @property
    def lacks(self) -> tuple[Reason, ...]:
        """Reasons why the contact has no fronts, or factors of its stations are not known."""
        return tuple(filter(None, (self.lack, *(each.lack for each in self.stations))))

    def name_of(self, station: Station) -> str:
        """Name of one of its stations: CONTACT.left or CONTACT.right in the plane.

        Of solids CONTACT.FRONT.STATION, fronts counted from 1 and stations from 0.
        """
        if not self.solid:
            return f"{self.name}.{station.front}"
        return f"{self.name}.{station.front.removeprefix('front ')}.{station.number}"
