# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip-zone lengths, found and predicted, and how far a cycle is from the steady one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.analytic._arguments import check_positive
from fretfe.analytic.edges import slip_length_cyclic, slip_length_loop
from fretfe.edges.average import average

# Error of a node of slip^(2/3), as an error of its place in elements: of finite elements, and of
# averages over the support of a node.
NODAL_ERROR = 0.05
# Half-width of the 95 % interval over the estimated error.
INTERVAL = 2.0
# Slip of less than so many standard deviations of the noise takes no part.
HIDDEN = 5.0
# Slip of sticking nodes below this fraction of the largest slip is round-off, no noise.
ROUND_OFF = 1e-9
# Numbers of nodes in the windows, next to the border, and then all.
COUNTS = (4, 6, 9, 13, 19, 28, 42, 63, 94)
# A line through so many nodes takes no part: slip^(2/3) is curved.
LINE = 9
# Highest order of the polynomials through slip^(2/3): one more than the highest that is used.
HIGHEST = 3


@dataclass(frozen=True)
class SlipBorder:
    """Slip-zone length from the edge inward; 0 without slip, NaN if the whole patch slips.

    If not ``resolved``, too few nodes slip, or the slip does not fall to zero where the sticking
    nodes begin: the length then ends half an element inside the last slipping node.

    ``spread`` is half the width of an interval that is meant to hold the place of the border with
    95 %, 0 in closed forms; the error of the edge is not in it. Infinite if a fit has no length.
    """

    length: float
    resolved: bool
    gross: bool
    spread: float = 0.0


@dataclass(frozen=True)
class PredictedSlip:
    """Slip-zone length of the steady cycle: at constant normal load, and by the general loop."""

    cyclic: float
    loop: float


def slip_border(s: Array, slip: Array, slipping: Bools) -> SlipBorder:
    """Return the slip-zone length at one edge; all arrays (n,), nodes *in contact* only.

    |slip|^(2/3) is a smooth function that vanishes linearly at the stick-slip border. The node at
    the border is left out, since its slip is an average over stick and slip; lines and parabolas
    through the next few, or many, nodes are averaged (``average``). Slip of sticking nodes is taken
    as the noise of the samples.

    Args:
        s: distances of the nodes from the edge inward, increasing.
        slip: slip increment since the last reversal (or from zero).
        slipping: whether the node slips.
    """
    amount, slips = np.abs(slip), slipping.copy()
    trusted = slips.copy()
    # The outermost node carries next to no pressure, so its own status means nothing.
    slips[0] |= slips[1:2].any()
    if slips.all():
        return SlipBorder(np.nan, resolved=True, gross=True, spread=np.inf)
    count = int(np.argmin(slips))
    size = float(s[count] - s[count - 1]) if count else float(s[1] - s[0])
    if count == 0:
        return SlipBorder(0.0, resolved=True, gross=False, spread=max(float(s[0]), 0.0) + size)
    low, high = max(s[count - 1], 0.0), s[count]
    zone = np.arange(0, count - 1 if count > 2 else count)[::-1]
    zone = zone[trusted[zone]]
    noise = float(np.sqrt(np.mean(amount[~slips] ** 2)))
    noise = noise if noise > ROUND_OFF * amount.max() else 0.0
    if zone.size > 1:
        border, spread, hidden = _border(s[zone] - low, amount[zone], noise, size)
        if abs(border - (high - low) / 2) < 1.5 * size + hidden:
            # Noise hides small slip behind the last node that is known to slip. That node may stand
            # behind the border itself where slip is a mean over the support of each node; few
            # nodes cannot tell.
            behind = size if zone.size >= COUNTS[0] else 0.0
            inside = border if hidden else np.clip(border, -behind, high - low)
            return SlipBorder(float(low + inside), resolved=True, gross=False, spread=spread)
    return SlipBorder(float((low + high) / 2), resolved=False, gross=False, spread=1.5 * size)


def _border(s: Array, amount: Array, noise: float, size: float) -> tuple[float, float, float]:
    """Return the place of the border, its error bar, and over what length noise hides the slip.

    Args:
        s: (m,) places of slipping nodes, from the border outward, m >= 2.
        amount: (m,) their slip.
        noise: standard deviation of the slip.
        size: element size.

    Returns:
        NaN, infinity and 0 if the slip does not fall toward the border.
    """
    highest = HIGHEST if noise else 2
    if noise == 0.0:
        # Farther nodes may have slipped while the edge moved over them: lines do.
        s, amount = s[: COUNTS[0] + 1], amount[: COUNTS[0] + 1]
    w = amount ** (2 / 3)
    slope, offset = np.polyfit(s, w, 1)
    if not slope < 0.0:
        return np.nan, np.inf, 0.0
    hidden = (HIDDEN * noise) ** (2 / 3) / -slope
    # What the line expects decides which nodes count, and how much: samples there would bias it.
    expected = np.maximum(slope * s + offset, 0.0)
    clear = expected > (HIDDEN * noise) ** (2 / 3)
    if np.count_nonzero(clear) > 1:
        s, w, expected = s[clear], w[clear], expected[clear]
    noisy = 2 / 3 * noise / np.sqrt(np.maximum(expected, (HIDDEN * noise) ** (2 / 3) or 1.0))
    errors = np.hypot(noisy, NODAL_ERROR * size * slope)
    fits = _zeros(s, w, errors, highest)
    if s.size < COUNTS[0]:
        # Nothing to compare a line with: for what it may be curved, and for a mean at its end.
        return float(fits[0, -1, 0]), float(np.hypot(INTERVAL * fits[1, -1, 0], size)), hidden
    known = np.ones_like(fits[0])
    place, bar, _ = average(fits[0], fits[1], 0.0 * known, known, INTERVAL)
    return float(place), float(bar), hidden


def _zeros(s: Array, w: Array, errors: Array, highest: int) -> Array:
    """Return (2, windows, orders) zeros through w (m,) at s (m,) and their standard errors."""
    # Where the samples are means, the first node may still be one over stick and slip.
    starts = (0, 1) if s.size > COUNTS[0] else (0,)
    windows = [slice(i, i + n) for i in starts for n in COUNTS if n < s.size - i]
    windows += [slice(i, None) for i in starts]
    fits = np.full((2, len(windows), HIGHEST), np.nan)
    for number, window in enumerate(windows):
        count = s[window].size
        for order in range(1 if count < LINE else 2, min(highest, count - 1) + 1):
            fits[:, number, order - 1] = _zero(s[window], w[window], errors[window], order)
    return fits


def _zero(s: Array, w: Array, errors: Array, order: int) -> tuple[float, float]:
    """Return the zero of a polynomial through w (m,) at s (m,) and its standard error, or NaN."""
    scale = float(np.ptp(s))
    powers = np.arange(order + 1)
    matrix = (s[:, None] / scale) ** powers / errors[:, None]
    inverse = np.linalg.pinv(matrix)
    coefficients = inverse @ (w / errors)
    zero, slope = 0.0, -1.0
    for _ in range(10):  # Newton, from next to the border
        slope = float(coefficients[1:] @ (powers[1:] * zero ** powers[:-1]))
        if not slope < 0.0 or abs(zero) > 2.0:
            return np.nan, np.nan
        zero -= float(coefficients @ zero**powers) / slope
    return zero * scale, float(np.linalg.norm(zero**powers @ inverse)) * scale / -slope


def cycle_change(q: Array, q_previous: Array, friction: float, p_max: float) -> float:
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
    k_t: Array, k_i: Array, k_n: float, friction: float, reference: int = 0
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
