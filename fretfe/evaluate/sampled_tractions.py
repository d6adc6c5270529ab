# SPDX-License-Identifier: LGPL-3.0-or-later
"""Everything that sampled tractions of one state tell about the edges of a contact, with errors.

Slip-zone lengths in two ways: from the slip, and from where |q| falls below f p.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic._numerics import Side, check_positive, check_range
from fretfe.evaluate.plane.pressure_fit import FEWEST_NODES, fit_edge, scatter, why_no_root
from fretfe.evaluate.plane.section import (
    PLANE_FRONTS,
    Patch,
    PlaneFront,
    Resultants,
    contact_patches,
    main_patch,
    resultants,
)
from fretfe.evaluate.plane.slip import slip_border

# Less than this part of the largest pressure, slip or friction bound counts as zero.
TRACE = 1e-6
# Slip and distance from the friction bound count from so many standard deviations of their noise.
SLIP_NOISE = 4.0
BOUND_NOISE = 3.0
# Shear beyond the friction bound, over the largest one, that noise and round-off do not explain.
BEYOND_BOUND = 0.02
# Fewest nodes on the friction bound, next to the edge, between which and the others a border is.
FEWEST_SLIPPING = 3


@dataclass(frozen=True)
class Estimate:
    """A number with half the width of the interval that is meant to hold the truth with 95 %.

    ``remark`` says why a number could not be determined (it is NaN, the spread infinite), or what
    to know about it; else it is empty.
    """

    value: float
    spread: float
    remark: str = ""

    @property
    def known(self) -> bool:
        """True if there is a number."""
        return math.isfinite(self.value)


def unknown(remark: str) -> Estimate:
    """Return an estimate without a number, for a reason."""
    return Estimate(math.nan, math.inf, remark)


def length_from_slip(
    x: Array, slip: Array, patch: Patch, edge: Estimate, front: PlaneFront
) -> Estimate:
    """Return the length from the slip, in the direction of the largest slip in this half.

    Args:
        x: (n,) positions along the arc, increasing.
        slip: (n,) slip since the last reversal of the load, or from zero.
        patch: in contact.
        edge: position of the edge along the arc.
        front: that of the edge.
    """
    if not edge.known:
        return unknown("the position of the edge is not known")
    inside = slice(patch.first, patch.last + 1)
    s, moved = front.distances(x[inside], edge.value), front.from_front(slip[inside])
    half = moved[: s.size // 2]
    direction = np.sign(half[np.argmax(np.abs(half))])
    limit = max(SLIP_NOISE * float(scatter(s, moved)), TRACE * float(np.abs(moved).max()))
    forward = np.where(direction * moved < -limit, 0.0, direction * moved)
    border = slip_border(s, forward, forward > limit)
    if border.gross:
        return unknown("the whole contact slips")
    unclear = "" if border.resolved else "too few nodes slip, or slip does not fall to zero"
    remark = unclear if border.length else "no node slips"
    return Estimate(border.length, math.hypot(border.spread, edge.spread), remark)


def length_from_traction(
    x: Array, bound: Array, q: Array, patch: Patch, edge: Estimate, front: PlaneFront
) -> Estimate:
    """Return the length over which |q| = f p, from the missing f p - |q| inside.

    That starts like a root at the border, as a pressure does at its edge (for Cattaneo and Mindlin
    it is the pressure of a smaller contact), and is fitted in the same way.

    Args:
        x: (n,) positions along the arc, increasing.
        bound: (n,) f p.
        q: (n,) shear.
        patch: in contact.
        edge: position of the edge along the arc.
        front: that of the edge.
    """
    if not edge.known:
        return unknown("the position of the edge is not known")
    inside = front.from_front(np.arange(patch.first, patch.last + 1))
    excess = float(np.max((np.abs(q) - bound)[inside]))
    direction = np.sign(q[inside[1:5]].sum())
    missing = bound - direction * q
    noise = float(scatter(x[inside], missing[inside]))
    largest = float(bound.max())
    if excess > BEYOND_BOUND * largest + 2 * BOUND_NOISE * noise:
        return unknown(f"|q| exceeds f p by up to {excess:.2g}")
    limit = max(BOUND_NOISE * noise, TRACE * largest)
    missing = np.where((bound > 0.0) & (missing > limit), missing, 0.0)
    if not missing.any():
        return unknown("the whole contact slips")
    stick = main_patch(x, missing)
    slipping = front.inward * (front.outermost(stick) - front.outermost(patch))
    if slipping < FEWEST_SLIPPING:
        return unknown(f"|q| = f p at {slipping} nodes only, {FEWEST_SLIPPING} are needed")
    fit = fit_edge(front.section(x, missing[None], [stick]))
    border, spread = float(fit.position[0]), float(fit.spread_position[0])
    if not np.isfinite(border):
        return unknown("f p - |q| does not start like a root, or too few nodes stick")
    return Estimate(front.inward * (border - edge.value), math.hypot(spread, edge.spread))


@dataclass(frozen=True)
class EdgeAnalysis:
    """One edge: position, K_N (stress over root of length), slip-zone lengths from the edge inward.

    ``slip_from_slip`` is found by slip^(2/3), ``slip_from_traction`` by where |q| falls below f p.
    """

    side: Side
    position: Estimate
    k_n: Estimate
    slip_from_slip: Estimate
    slip_from_traction: Estimate

    @property
    def slip_length(self) -> Estimate:
        """The length from the slip if that is known, else the one from the tractions."""
        return self.slip_from_slip if self.slip_from_slip.known else self.slip_from_traction


@dataclass(frozen=True)
class TractionAnalysis:
    """Both edges, resultants about the centre of the contact (Q is NaN without q), remarks."""

    edges: tuple[EdgeAnalysis, EdgeAnalysis]
    resultants: Resultants
    centre: float
    remarks: tuple[str, ...]


def analyse_tractions(
    x: ArrayLike,
    p: ArrayLike,
    q: ArrayLike | None = None,
    slip: ArrayLike | None = None,
    friction: float | None = None,
) -> TractionAnalysis:
    """Return position, K_N and slip-zone length at both edges, and the resultants, of one state.

    Conventions of ``fretfe.analytic.edges``; any consistent units. What cannot be determined is NaN
    and says why.

    Args:
        x: (n,) positions along the contact, strictly increasing; nodes out of contact may follow.
        p: (n,) pressure, positive; zero out of contact.
        q: (n,) shear traction.
        slip: (n,) slip since the last reversal of the load, or from zero; zero where it sticks.
        friction: coefficient f; needed, with q, for the length from the tractions.

    Raises:
        ValueError: if arrays are not finite or differ in shape, x does not increase, friction is
            not positive or nothing is in contact.
    """
    x, p = _column("x", x), _column("p", p)
    shear = None if q is None else _column("q", q, x.size)
    moved = None if slip is None else _column("slip", slip, x.size)
    _column("p", p, x.size)
    check_positive("differences of x", np.diff(x))
    if friction is not None:
        check_positive("friction", friction)
        if math.isinf(friction):
            raise ValueError(f"friction must be finite, found {friction:g}")
    p = np.where(p > TRACE * max(p.max(), 0.0), p, 0.0)
    patch = main_patch(x, p)
    left, right = (_edge(x, p, shear, moved, friction, patch, front) for front in PLANE_FRONTS)
    ends = left.position, right.position
    middle = (x[patch.first] + x[patch.last]) / 2
    centre = sum(end.value for end in ends) / 2 if all(end.known for end in ends) else middle
    forces = resultants(x, p, np.zeros_like(p) if shear is None else shear, float(centre))
    if shear is None:
        forces = replace(forces, shear_force=math.nan)
    return TractionAnalysis((left, right), forces, float(centre), _remarks(x, p, (left, right)))


def _column(name: str, values: ArrayLike, size: int | None = None) -> Array:
    column = check_range(name, values, low=-np.finfo(float).max, high=np.finfo(float).max)
    if column.ndim != 1 or column.size < 2 or size not in (None, column.size):
        expected = "(n,), n >= 2" if size is None else f"({size},), that of x"
        raise ValueError(f"{name} must have the shape {expected}, found {column.shape}")
    return column


def _edge(
    x: Array,
    p: Array,
    q: Array | None,
    slip: Array | None,
    friction: float | None,
    patch: Patch,
    front: PlaneFront,
) -> EdgeAnalysis:
    fit = fit_edge(front.section(x, p[None], [patch]))
    nodes = patch.last - patch.first + 1
    remark = ""
    if nodes < FEWEST_NODES:
        remark = f"{nodes} nodes in contact, {FEWEST_NODES} are needed"
    elif not np.isfinite(fit.position[0]):
        remark = why_no_root(x, p, patch, front).text
    position = Estimate(float(fit.position[0]), float(fit.spread_position[0]), remark)
    k_n = Estimate(float(fit.k_n[0]), float(fit.spread_k_n[0]), remark)
    if slip is None:
        from_slip = unknown("no slip given")
    else:
        from_slip = length_from_slip(x, slip, patch, position, front)
    if q is None or friction is None:
        from_traction = unknown("needs q and the friction coefficient")
    else:
        from_traction = length_from_traction(x, friction * p, q, patch, position, front)
    return EdgeAnalysis(front.name, position, k_n, from_slip, from_traction)


def _remarks(x: Array, p: Array, edges: tuple[EdgeAnalysis, ...]) -> tuple[str, ...]:
    """Return what concerns the whole contact, or how two results for an edge differ."""
    patches, remarks = contact_patches(x, p), []
    if len(patches) > 1:
        remarks.append(
            f"{len(patches)} separate patches are in contact: edges are those of the one that "
            "carries the largest force, resultants those of all"
        )
    for edge in edges:
        one, other = edge.slip_from_slip, edge.slip_from_traction
        if one.known and other.known and abs(one.value - other.value) > one.spread + other.spread:
            remarks.append(
                f"{edge.side} edge: the slip-zone lengths from slip and from tractions, "
                f"{one.value:.4g} and {other.value:.4g}, differ by more than their errors"
            )
    return tuple(remarks)
