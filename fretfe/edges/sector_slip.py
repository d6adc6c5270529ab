# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip-zone length at a station of a solid, from the slip of the nodes around it.

As in the plane |slip|^(2/3) is a smooth function that falls to zero along a line at the border of
the slip zone. The area that slips within the sector tells where that is to a fraction of an
element; polynomials through the slip of the nodes that are clear of the border tell it better.
Where the contact area varies, nodes behind the zone that come and go with its ragged border slip by
some per cent of the largest slip: only larger slip counts for the area.
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.edges.average import average
from fretfe.edges.sectors import Sector
from fretfe.edges.slip import INTERVAL, NODAL_ERROR, SlipBorder

# Nodes closer to the border than that, in elements, are means over stick and slip.
CLEAR = 0.7
# Variance of the place in a node's mean, along `inward`, over the square of an element's size.
VARIANCE = 0.14
# Part of the largest slip from which nodes count for the area that slips, and what they miss of the
# length of the zone.
FIRM = 0.03
MISSED = FIRM ** (2 / 3)
# Times that the border is found with the means of the time before.
PASSES = 3
# Lengths of the windows from there outward, in elements.
WINDOWS = (2.5, 3.5, 5.0, 7.0, 10.0, 14.0)
ORDERS = (1, 2, 3)
# Nodes more than terms that a fit needs.
SPARE = 3
# Error bar of a border by the area, in elements, and the least one of a border by fits: nodes slip
# or stick as a whole, and a border need not run along the front.
BY_AREA, BY_FIT = 1.0, 0.15
# Part of the way to the middle of the contact that slips, from which all of it does.
GROSS = 0.98
FARTHEST = 3.0


def sector_border(
    sector: Sector, place: float, depth: float, slip: Array, moved: Bools, area: Array
) -> SlipBorder:
    """Slip-zone length from the front inward.

    Args:
        sector: m nodes around the station.
        place: of the front, inward from the reference front.
        depth: half of the width of the contact at the station.
        slip: (m,) in the direction of the slip zone since the last reversal.
        moved: (m,) nodes in contact that have slipped.
        area: (m,) areas that belong to the nodes.
    """
    s, size = sector.s - place, sector.size
    inside = (s > 0) & (s <= depth)
    if not inside.any():
        return SlipBorder(np.nan, resolved=False, gross=False, spread=np.inf)
    if not np.any(inside & moved):
        return SlipBorder(0.0, resolved=True, gross=False, spread=size)
    firm = moved & (slip > FIRM * slip[inside & moved].max())
    by_area = _by_area(sector, s, area, firm, depth) / (1 - MISSED)
    if by_area > GROSS * depth:
        return SlipBorder(np.nan, resolved=True, gross=True, spread=np.inf)
    fitted, guess = None, by_area
    for _ in range(PASSES):
        fitted = _border(sector, s, slip, moved & inside, guess)
        if fitted is None:
            break
        guess = fitted[0]
    if fitted is None:
        return SlipBorder(by_area, resolved=False, gross=False, spread=BY_AREA * size)
    length, spread = fitted
    if abs(length - by_area) > BY_AREA * size:
        return SlipBorder(
            by_area, resolved=False, gross=False, spread=BY_AREA * size + abs(length - by_area)
        )
    return SlipBorder(length, resolved=True, gross=False, spread=spread)


def _by_area(sector: Sector, s: Array, area: Array, moved: Bools, depth: float) -> float:
    """Length of the slip zone by the share of the area that slips within some depth.

    All of the sector is in contact behind the front. The depth is halved as long as less than half
    of it slips: sectors of round contacts are narrow far inside.
    """
    # Areas are those between curved lines.
    weights = area * sector.fade / np.maximum(1 - sector.curvature * sector.s, 0.1)
    while True:
        inside = (s > 0) & (s <= depth)
        share = float(weights[inside & moved].sum() / max(weights[inside].sum(), 1e-300))
        if share > 0.4 or depth < 4 * sector.size:
            return share * depth
        depth /= 2


def _border(
    sector: Sector, s: Array, slip: Array, moved: Bools, guess: float
) -> tuple[float, float] | None:
    """Border and its error bar; None without fits of two orders that can be compared."""
    size = sector.size
    fits = np.full((2, len(WINDOWS), len(ORDERS)), np.nan)
    misfits = np.ones(fits.shape[1:])
    outward = (guess - s) / size
    for number, length in enumerate(WINDOWS):
        window = moved & (outward > CLEAR) & (outward < CLEAR + length)
        for column, order in enumerate(ORDERS):
            found = _zero(sector, outward[window], slip[window], window, order)
            if found is not None:
                fits[0, number, column], fits[1, number, column], misfits[number, column] = found
        if not np.any(moved & (outward >= CLEAR + length)):
            break
    place, bar, _ = average(fits[0], fits[1], np.zeros_like(fits[0]), misfits, INTERVAL)
    if not np.isfinite(place):
        return None
    return guess - float(place) * size, float(np.hypot(bar, BY_FIT)) * size


def _zero(
    sector: Sector, outward: Array, slip: Array, window: Bools, order: int
) -> tuple[float, float, float] | None:
    """Zero of slip^(2/3) outward of the guess, in elements, its standard error and chi^2/nu."""
    along = sector.along[window] / sector.half_width
    rows = len(np.unique(np.round(5 * along)))
    across = [along**power for power in (1, 2) if power < rows]
    if len(outward) < order + 1 + len(across) + SPARE:
        return None
    # The mean of x^(3/2) around a node is larger than its value there.
    w = np.abs(slip) ** (2 / 3) / (1 + VARIANCE / (4 * outward**2))
    powers = np.arange(order + 1)
    matrix = np.column_stack([outward[:, None] ** powers, *across])
    line = np.linalg.lstsq(matrix[:, [0, 1]], w)[0][1]
    if not line > 0:
        return None
    # Nodes at both ends of the sector tell less of its middle.
    sigma = NODAL_ERROR * line / np.sqrt(np.maximum(sector.fade[window], 1e-3))
    inverse = np.linalg.pinv(matrix / sigma[:, None])
    coefficients = inverse @ (w / sigma)
    c, zero = coefficients[: order + 1], 0.0
    for _ in range(10):
        slope = float(c[1:] @ (powers[1:] * zero ** powers[:-1]))
        if not slope > 0 or abs(zero) > FARTHEST:
            return None
        zero -= float(c @ zero**powers) / slope
    error = np.linalg.norm(zero**powers @ inverse[: order + 1]) / slope
    rest = (matrix @ coefficients - w) / sigma
    misfit = float(rest @ rest) / (len(w) - matrix.shape[1])
    return zero, float(error), misfit
