# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors and slip zones from sampled tractions, whatever computed them.

A contact is sampled at arc positions ``x`` (n,), increasing; ``p``, ``q`` (n,) are the nodal values
of piecewise-linear pressure and shear, zero at nodes out of contact. Conventions of
``fretfe.analytic.edges``. Next to an edge nodal values oscillate, integrals do not: singular
tractions are fitted through the cumulative force, and all fits leave out the outermost nodes.

Each fit is made over many windows. Those whose estimated error is within a factor 2 of the best are
kept, the result is their median, and the spread is made of their range and standard error
(``edge_fits.consensus``). It does not see an error that all windows share. Where no window holds
enough nodes, the result is NaN with an infinite spread.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe.analytic._arguments import FloatArray, Side, check_positive, check_range, side_sign
from fretfe.analytic.bonded_fits import fit_overhang, fits_of_window, increment, windows
from fretfe.analytic.edge_fits import consensus, fit_square_root, pressure_windows
from fretfe.analytic.edges import slip_length_cyclic, slip_length_loop

# How far, in elements, the effective edge of a bonded increment stands outside the outermost node
# in contact, per displacement degree. Measured on half-planes with matching meshes, four gradings,
# two sizes: .56 to .59 and .90 to 1.05. An exact Galerkin solution has .53.
OVERHANG = {1: 0.98, 2: 0.57}
OVERHANG_UNCERTAINTY = 0.05


@dataclass(frozen=True)
class Patch:
    """A run of nodes in contact, first to last (both included), and the force it carries."""

    first: int
    last: int
    force: float


@dataclass(frozen=True)
class Resultants:
    """P, Q (force per thickness) and the moment of the pressure about the given centre."""

    normal_force: float
    shear_force: float
    moment: float


@dataclass(frozen=True)
class EdgeFit:
    """Edge position and K_N (stress over root of length) of the main patch, with spreads."""

    position: float
    k_n: float
    spread_position: float
    spread_k_n: float


@dataclass(frozen=True)
class BondedFit:
    """Edge term k (1 + beta s)/sqrt(s) of a bonded increment, with the sign of the traction.

    For the edge that was passed; ``spread`` is the uncertainty of ``k``.
    """

    k: float
    beta: float
    spread: float


@dataclass(frozen=True)
class SlipBorder:
    """Slip-zone length from the edge inward; 0 without slip, NaN if the whole patch slips.

    If not ``resolved``, too few nodes slip, or the slip does not fall to zero where the sticking
    nodes begin: the length then ends half an element inside the last slipping node.
    """

    length: float
    resolved: bool
    gross: bool


@dataclass(frozen=True)
class PredictedSlip:
    """Slip-zone length of the steady cycle: at constant normal load, and by the general loop."""

    cyclic: float
    loop: float


def contact_patches(x: FloatArray, p: FloatArray, tol: float = 0.0) -> list[Patch]:
    """Return the runs of nodes with p > tol (a pressure), from left to right; x, p (n,)."""
    ends = np.flatnonzero(np.diff(p > tol, prepend=False, append=False)).reshape(-1, 2)
    share = p * _node_lengths(x)
    return [Patch(int(i), int(j) - 1, float(share[i:j].sum())) for i, j in ends]


def main_patch(x: FloatArray, p: FloatArray, tol: float = 0.0) -> Patch:
    """Return the patch that carries most force.

    Raises:
        ValueError: if no node has p > tol.
    """
    patches = contact_patches(x, p, tol)
    if not patches:
        raise ValueError(f"p must exceed tol = {tol:g} at one node at least, found none")
    return max(patches, key=lambda patch: patch.force)


def resultants(x: FloatArray, p: FloatArray, q: FloatArray, centre: float) -> Resultants:
    """Return the exact resultants of piecewise-linear tractions; x, p, q (n,).

    A positive moment presses on the side x > centre.
    """
    length, h, arm = _node_lengths(x), np.diff(x), x - centre
    left, right = p[:-1], p[1:]
    moments = arm[:-1] * (2 * left + right) + arm[1:] * (left + 2 * right)
    return Resultants(float(length @ p), float(length @ q), float(h @ moments / 6))


def fit_edge(x: FloatArray, p: FloatArray, side: Side) -> EdgeFit:
    """Return edge position and K_N of the main patch; x, p (n,).

    p^2 = K_N^2 s + c2 s^2 + c3 s^3 with unknown edge. The window is chosen by the data, so that a
    short square-root zone (rounded edge) and a long one (cylinder) both work.

    Raises:
        ValueError: if nothing is in contact or ``side`` is unknown.
    """
    sign, patch = side_sign(side), main_patch(x, p)
    inside, step = slice(patch.first, patch.last + 1), int(sign)
    inward, pressure = (sign * x[inside])[::step], p[inside][::step]
    fits = [
        fit
        for drop, end in pressure_windows(inward.size)
        if (fit := fit_square_root(inward[drop:end] - inward[0], pressure[drop:end])) is not None
    ]
    if not fits:
        return EdgeFit(np.nan, np.nan, np.inf, np.inf)
    positions, factors, position_errors, factor_errors = np.array(fits).T
    score = factor_errors / factors
    position, spread_position = consensus(positions, position_errors, score)
    k_n, spread_k_n = consensus(factors, factor_errors, score)
    return EdgeFit(sign * (inward[0] + position), k_n, spread_position, spread_k_n)


def bonded_factors(
    x: FloatArray, q: FloatArray, edges: tuple[float, float], overhang: float
) -> tuple[BondedFit, BondedFit]:
    """Return the singular edge terms of a bonded increment at the left and the right edge.

    The cumulative force is fitted (``bonded_fits.fit_bonded``) with up to 14 terms; the error of a
    fit is what the next two orders change, and the spread holds the effect of OVERHANG_UNCERTAINTY
    too. At least 16 nodes must be in contact.

    Args:
        x: (n,) arc positions.
        q: (n,) increment of the shear, or of the pressure (which gives K_I), not zero in contact.
        edges: true left and right edge, from ``fit_edge``.
        overhang: distance of the effective edges of the discrete increment from the outermost nodes
            in contact, in elements: OVERHANG of the displacement degree.

    Raises:
        ValueError: if ``edges`` do not increase, ``overhang`` is negative or ``q`` zero everywhere.
    """
    check_positive("edges[1] - edges[0]", edges[1] - edges[0])
    check_range("overhang", overhang, low=0.0)
    here = _terms(x, q, edges, overhang)
    shifted = _terms(x, q, edges, overhang + OVERHANG_UNCERTAINTY)
    left, right = (
        BondedFit(k, beta, float(np.hypot(spread, other - k)))
        for (k, beta, spread), (other, *_) in zip(here, shifted, strict=True)
    )
    return left, right


def effective_overhang(x: FloatArray, q: FloatArray) -> float:
    """Return the overhang that a bonded increment shows; x, q (n,), at least 16 nodes in contact.

    To calibrate a discretisation on an increment whose mismatch is next to linear, such as a shear
    force between bodies that are large against the contact. Any other increment misleads.

    Raises:
        ValueError: if ``q`` is zero everywhere or too few nodes are in contact.
    """
    data, inside = increment(x, q)
    check_range("nodes in contact", inside.size, low=16)
    found = [fit_overhang(data, window, n) for window in windows(inside) for n in (1, 2, 3)]
    return float(np.median(found))


def _terms(
    x: FloatArray, q: FloatArray, edges: tuple[float, float], overhang: float
) -> list[tuple[float, float, float]]:
    """Return k, beta and the spread of k, left and right, that all fits agree on."""
    data, inside = increment(x, q)
    fits = [
        fit for window in windows(inside) for fit in fits_of_window(data, window, overhang, edges)
    ]
    if not fits:
        return [(np.nan, np.nan, np.inf)] * 2
    values, changes = (np.array(column) for column in zip(*fits, strict=True))
    score, found = changes.max(axis=1), []
    for k, beta, change in zip(*values.transpose(2, 1, 0), changes.T, strict=True):
        middle, spread = consensus(k, change, score)
        found.append((middle, consensus(beta, change, score)[0], spread))
    return found


def edge_factor_k_t(k: float, side: Side) -> float:
    """Return K_T, positive where the traction on body 2 points inward, from the k of a shear.

    Raises:
        ValueError: if ``side`` is unknown.
    """
    return side_sign(side) * k


def slip_border(
    x: FloatArray, slip: FloatArray, slipping: np.ndarray, edge: float, side: Side
) -> SlipBorder:
    """Return the slip-zone length at one edge; all arrays (n,), nodes *in contact* only.

    |slip|^(2/3) is linear in the distance to the stick-slip border. The node at the border is left
    out, since its slip is an average over stick and slip; the next four give the straight line.

    Args:
        x: arc positions of the nodes in contact.
        slip: slip increment since the last reversal (or from zero).
        slipping: whether the node slips.
        edge: position of the edge.
        side: "left" or "right".

    Raises:
        ValueError: if ``side`` is unknown.
    """
    sign, step = side_sign(side), int(side_sign(side))
    s, amount, slips = sign * (x - edge)[::step], np.abs(slip)[::step], slipping[::step].copy()
    trusted = slips.copy()
    # The outermost node carries next to no pressure, so its own status means nothing.
    slips[0] |= slips[1:2].any()
    if slips.all():
        return SlipBorder(np.nan, resolved=True, gross=True)
    count = int(np.argmin(slips))
    if count == 0:
        return SlipBorder(0.0, resolved=True, gross=False)
    low, high = max(s[count - 1], 0.0), s[count]
    zone = np.arange(max(0, count - 5), count - 1 if count > 2 else count)
    zone = zone[trusted[zone]]
    if zone.size > 1:
        slope, offset = np.polyfit(s[zone], amount[zone] ** (2 / 3), 1)
        border = -offset / slope if slope < 0.0 else np.inf
        if abs(border - (low + high) / 2) < 1.5 * (high - low):
            return SlipBorder(float(np.clip(border, low, high)), resolved=True, gross=False)
    return SlipBorder(float((low + high) / 2), resolved=False, gross=False)


def cycle_change(q: FloatArray, q_previous: FloatArray, friction: float, p_max: float) -> float:
    """Return the largest change of q between the same states of two cycles, relative to f p_max.

    Args:
        q: (..., n) shear in one cycle.
        q_previous: (..., n) shear in the cycle before.
        friction: coefficient f.
        p_max: largest pressure.

    Raises:
        ValueError: if ``friction`` or ``p_max`` is not positive.
    """
    bound = check_positive("friction", friction) * check_positive("p_max", p_max)
    return float(np.max(np.abs(q - q_previous)) / bound)


def predicted_slip(
    k_t: FloatArray, k_i: FloatArray, k_n: float, friction: float, reference: int = 0
) -> PredictedSlip:
    """Return the slip lengths that the edge factors of one closed cycle predict.

    Args:
        k_t: (T,) K_T over the cycle.
        k_i: (T,) K_I over the cycle; zero at constant normal load.
        k_n: K_N in the reference state.
        friction: coefficient f.
        reference: index of the state whose edge the loop length is measured from.

    Raises:
        ValueError: if ``k_n`` or ``friction`` is not positive.
    """
    cyclic = slip_length_cyclic(np.ptp(k_t), k_n, friction)
    loop = slip_length_loop(k_t, k_i, k_n, friction, reference)
    return PredictedSlip(float(cyclic), float(loop))


def _node_lengths(x: FloatArray) -> FloatArray:
    """Return the integrals of the hat functions of all nodes."""
    h = np.diff(x, prepend=x[0], append=x[-1])
    return (h[1:] + h[:-1]) / 2
