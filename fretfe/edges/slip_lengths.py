# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip-zone lengths of one state in two ways: from the slip, and from where |q| falls below f p."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.edges.patches import Patch, main_patch
from fretfe.edges.pressure import fit_edge
from fretfe.edges.sampling import scatter
from fretfe.edges.section import PlaneFront
from fretfe.edges.slip import slip_border

# Less than this part of the largest pressure, slip or friction bound counts as zero.
TRACE = 1e-6
# Slip and distance from the friction bound count from so many standard deviations of their noise.
SLIP_NOISE, BOUND_NOISE = 4.0, 3.0
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
    remark = "" if border.resolved else "too few nodes slip, or slip does not fall to zero"
    if border.length == 0.0:
        remark = "no node slips"
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
