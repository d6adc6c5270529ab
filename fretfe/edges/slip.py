# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip-zone lengths, found and predicted, and how far a cycle is from the steady one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe.analytic._arguments import FloatArray, Side, check_positive, side_sign
from fretfe.analytic.edges import slip_length_cyclic, slip_length_loop


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
