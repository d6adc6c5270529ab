# SPDX-License-Identifier: LGPL-3.0-or-later
"""Everything that sampled tractions of one state tell about the edges of a contact, with errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic._arguments import Side, check_positive, check_range, side_sign
from fretfe.edges.patches import Patch, Resultants, contact_patches, main_patch, resultants
from fretfe.edges.pressure import FEWEST_NODES, fit_edge
from fretfe.edges.sampling import scatter
from fretfe.edges.slip import slip_border

# Less than this part of the largest pressure, slip or friction bound counts as zero.
TRACE = 1e-6
# Slip and distance from the friction bound count from so many standard deviations of their noise.
SLIP_NOISE, BOUND_NOISE = 4.0, 3.0
# Shear beyond the friction bound, over the largest one, that noise and round-off do not explain.
BEYOND_BOUND = 0.02
# Error bar of K_N, relative, from which K_N and edge are marked.
LARGEST_SPREAD = 0.5
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
        """Whether there is a number."""
        return math.isfinite(self.value)


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
    p = np.where(p > TRACE * max(p.max(), 0.0), p, 0.0)
    patch = main_patch(x, p)
    left, right = (_edge(x, p, shear, moved, friction, patch, side) for side in ("left", "right"))
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
    side: Side,
) -> EdgeAnalysis:
    fit = fit_edge(x, p, side)
    nodes = patch.last - patch.first + 1
    remark = ""
    if nodes < FEWEST_NODES:
        remark = f"{nodes} nodes in contact, {FEWEST_NODES} are needed"
    elif not np.isfinite(fit.position):
        remark = (
            "the pressure does not fall to zero like a root, or the rows end inside the contact"
        )
    position = Estimate(float(fit.position), float(fit.spread_position), remark)
    k_n = Estimate(float(fit.k_n), float(fit.spread_k_n), remark)
    if slip is None:
        from_slip = _unknown("no slip given")
    else:
        from_slip = _from_slip(x, slip, patch, position, side)
    if q is None or friction is None:
        from_traction = _unknown("needs q and the friction coefficient")
    else:
        from_traction = _from_traction(x, p, q, friction, patch, position, side)
    return EdgeAnalysis(side, position, k_n, from_slip, from_traction)


def _unknown(remark: str) -> Estimate:
    return Estimate(math.nan, math.inf, remark)


def _from_slip(x: Array, slip: Array, patch: Patch, edge: Estimate, side: Side) -> Estimate:
    """Return the length from the slip, in the direction of the largest slip in this half."""
    if not edge.known:
        return _unknown("the position of the edge is not known")
    inside = slice(patch.first, patch.last + 1)
    here, moved = x[inside], slip[inside]
    half = moved[: here.size // 2] if side == "left" else moved[here.size // 2 :]
    direction = np.sign(half[np.argmax(np.abs(half))])
    limit = max(SLIP_NOISE * scatter(here, moved), TRACE * float(np.abs(moved).max()))
    forward = np.where(direction * moved < -limit, 0.0, direction * moved)
    border = slip_border(here, forward, forward > limit, edge.value, side)
    if border.gross:
        return _unknown("the whole contact slips")
    remark = "" if border.resolved else "too few nodes slip, or slip does not fall to zero"
    if border.length == 0.0:
        remark = "no node slips"
    return Estimate(border.length, math.hypot(border.spread, edge.spread), remark)


def _from_traction(
    x: Array,
    p: Array,
    q: Array,
    friction: float,
    patch: Patch,
    edge: Estimate,
    side: Side,
) -> Estimate:
    """Return the length over which |q| = f p, from the missing f p - |q| inside.

    That starts like a root at the border, as a pressure does at its edge (for Cattaneo and Mindlin
    it is the pressure of a smaller contact), and is fitted in the same way.
    """
    if not edge.known:
        return _unknown("the position of the edge is not known")
    step = int(side_sign(side))
    inside = np.arange(patch.first, patch.last + 1)[::step]
    bound = friction * p
    excess = float(np.max((np.abs(q) - bound)[inside]))
    direction = np.sign(q[inside[1:5]].sum())
    missing = bound - direction * q
    noise = scatter(x[inside], missing[inside])
    largest = float(bound.max())
    if excess > BEYOND_BOUND * largest + 2 * BOUND_NOISE * noise:
        return _unknown(f"|q| exceeds f p by up to {excess:.2g}")
    limit = max(BOUND_NOISE * noise, TRACE * largest)
    missing = np.where((p > 0.0) & (missing > limit), missing, 0.0)
    if not missing.any():
        return _unknown("the whole contact slips")
    stick = main_patch(x, missing)
    slipping = stick.first - patch.first if side == "left" else patch.last - stick.last
    if slipping < FEWEST_SLIPPING:
        return _unknown(f"|q| = f p at {slipping} nodes only, {FEWEST_SLIPPING} are needed")
    fit = fit_edge(x, missing, side)
    if not np.isfinite(fit.position):
        return _unknown("f p - |q| does not start like a root, or too few nodes stick")
    length = step * (float(fit.position) - edge.value)
    return Estimate(length, math.hypot(float(fit.spread_position), edge.spread))


def _remarks(x: Array, p: Array, edges: tuple[EdgeAnalysis, ...]) -> tuple[str, ...]:
    """Return what concerns the whole contact, or how two results for an edge differ."""
    patches, remarks = contact_patches(x, p), []
    if len(patches) > 1:
        remarks.append(
            f"{len(patches)} separate patches are in contact: edges are those of the one that "
            "carries most force, resultants those of all"
        )
    for edge in edges:
        one, other = edge.slip_from_slip, edge.slip_from_traction
        if one.known and other.known and abs(one.value - other.value) > one.spread + other.spread:
            remarks.append(
                f"{edge.side} edge: the slip-zone lengths from slip and from tractions, "
                f"{one.value:.4g} and {other.value:.4g}, differ by more than their errors"
            )
    return tuple(remarks)
