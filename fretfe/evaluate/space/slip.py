# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip-zone length at a station of a solid, from the slip of the nodes around it.

Slip between two states counts in the direction that it has on average. As in the plane |slip|^(2/3)
is a smooth function that falls to zero along a line at the border of the slip zone. The area that
slips within the sector tells where that is to a fraction of an element; polynomials through the
slip of the nodes that are clear of the border tell it better. Where the contact area varies, nodes
behind the zone that come and go with its ragged border slip by some per cent of the largest slip:
only larger slip counts for the area.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.growth import FindGrowth, evened
from fretfe.evaluate.numerics import average, rising_zero
from fretfe.evaluate.plane.slip import INTERVAL, NODAL_ERROR
from fretfe.evaluate.slip import SMALLEST_SLIP, FindBorder, SlipBorder, slip_in_steps
from fretfe.evaluate.space.sectors import Sector
from fretfe.history.solution import OPEN, ContactHistory
from fretfe.history.state_array import blocks

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
BY_AREA = 1.0
BY_FIT = 0.15
# Part of the way to the middle of the contact that slips, and of the area to its other side, from
# which all of it does. Zones may end behind the middle, where the other side sticks.
GROSS = 0.98
# Part of the way of the mean slip that goes in its mean direction, below which it turns: .64 of a
# force that turns at constant size, 1 on a line; (K_T, K_S) that turn by a tenth leave .99.
STRAIGHT = 0.95
FARTHEST = 3.0


def sector_border(
    sector: Sector,
    place: float,
    depth: float,
    slip: Array,
    moved: Bools,
    area: Array,
    *,
    turns: bool = False,
) -> SlipBorder:
    """Slip-zone length from the front inward.

    Args:
        sector: m nodes around the station.
        place: of the front, inward from the reference front.
        depth: as far as which the zone is looked for: gross, if it is longer.
        slip: (m,) in the direction of the slip zone since the last reversal.
        moved: (m,) nodes in contact that have slipped.
        area: (m,) areas that belong to the nodes.
        turns: whether the direction of slip turns: then it begins next to linearly behind the
            border, not with the power 3/2, and only the area that slips tells where that is.
    """
    s, size = sector.s - place, sector.size
    inside = (s > 0) & (s <= depth)
    if not inside.any():
        return SlipBorder(np.nan, resolved=False, gross=False, spread=np.inf)
    if not np.any(inside & moved):
        return SlipBorder(0.0, resolved=True, gross=False, spread=size)
    firm = moved & (slip > FIRM * slip[inside & moved].max())
    missed = FIRM if turns else MISSED  # of an onset that is next to linear
    by_area = _by_area(sector, s, area, firm, depth) / (1 - missed)
    if by_area > GROSS * depth:
        return SlipBorder(np.nan, resolved=True, gross=True, spread=np.inf)
    fitted, guess = None, by_area
    for _ in range(0 if turns else PASSES):
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
    matrix = np.column_stack([outward[:, None] ** np.arange(order + 1), *across])
    line = np.linalg.lstsq(matrix[:, [0, 1]], w)[0][1]
    if not line > 0:
        return None
    # Nodes at both ends of the sector tell less of its middle.
    sigma = NODAL_ERROR * line / np.sqrt(np.maximum(sector.fade[window], 1e-3))
    inverse = np.linalg.pinv(matrix / sigma[:, None])
    coefficients = inverse @ (w / sigma)
    zero, error = rising_zero(coefficients[: order + 1], inverse[: order + 1], FARTHEST)
    if not np.isfinite(zero):
        return None
    rest = (matrix @ coefficients - w) / sigma
    misfit = float(rest @ rest) / (len(w) - matrix.shape[1])
    return zero, error, misfit


class SlipBetween:
    """Slip increments of a contact's nodes in steps, read once for all stations.

    Args:
        contact: one contact.
        least: (T,) slip of a node beyond which it counts in the step to each state.
        cycle: first and last state of the evaluated cycle; None without.
    """

    def __init__(
        self, contact: ContactHistory, least: Array, cycle: tuple[int, int] | None = None
    ) -> None:
        self._contact, self._least, self._cycle = contact, least, cycle
        self._read: dict[tuple[int, int], tuple[Array, Bools]] = {}

    def steps(self, start: int, end: int) -> tuple[Array, Bools]:
        """(k, N, 3) slip in each step between two states, and (N,) nodes in contact at the end."""
        if (start, end) not in self._read:
            contact = self._contact
            parts = [np.empty((0, *contact.surface.points.shape))]
            for part in blocks(end - start, contact.surface.points.size):
                first, last = start + part.start, start + part.stop
                slip = slip_in_steps(contact, first, last, self._least)
                parts.append(np.einsum("knt,ntd->knd", slip, contact.surface.frames[:, 1:]))
            closed = np.asarray(contact.status[end] != OPEN)
            self._read[start, end] = np.concatenate(parts), closed
        return self._read[start, end]

    def border_of(
        self,
        sector: Sector,
        chord: Indices,
        place: Array,
        depth: float,
        outer: Bools | None = None,
        growth: FindGrowth = lambda *_: None,
    ) -> FindBorder:
        """Slip zones at a station.

        Args:
            sector: around it.
            chord: nodes from there to the other side of the contact.
            place: (T,) of the front, inward from the reference.
            depth: half of the width of the contact.
            outer: (T,) whether the slip in the step to each state counts; None if all of it does.
            growth: gives the growth of the zone of a half cycle.
        """
        area = self._contact.surface.weights[sector.nodes]

        def find(start: int, end: int) -> SlipBorder:
            steps, closed = self.steps(start, end)
            counted = slice(None) if outer is None else outer[start + 1 : end + 1]
            own = steps[:, sector.nodes][counted]
            slip, straight, moved = _moved(own, closed[sector.nodes], sector.fade * area)
            here, turns, reach = float(place[end]), straight < STRAIGHT, depth

            def by(stretch: Array | float) -> SlipBorder:
                return sector_border(sector, here, reach, slip / stretch, moved, area, turns=turns)

            border = by(1.0)
            held = chord[closed[chord] & (self._contact.status[start][chord] != OPEN)]
            if border.gross and self._sticks(steps[:, held][counted], held):
                reach = float(sector.s.max()) - here
                border = by(1.0)
                if border.gross:  # it ends where nodes are too far from the station
                    border = replace(border, gross=False, resolved=False)
            if border.gross:
                returned = np.minimum(slip, self._back(start, end, sector, area))
                # Else all of it goes one way from cycle to cycle.
                if 2 * returned.max() > slip.max():
                    least = SMALLEST_SLIP * returned.max()
                    slip, moved = returned, closed[sector.nodes] & (returned > least)
                    border = by(1.0)
            grown = growth(start, end)
            if grown is not None:
                return evened(grown, sector.s - here, border, by, sector.size)
            return border

        return find

    def _back(self, start: int, end: int, sector: Sector, area: Array) -> Array:
        """(m,) slip of a sector's nodes in the rest of the cycle against that between two states.

        What creeps from cycle to cycle does not go back: all of a contact may creep by a part of
        what slips at its edges, and no length is that of slip that is none in the steady cycle.
        """
        first, last = self._cycle or (end, start)
        if not first <= start < end <= last:
            return 0.0 * area
        steps = self.steps(first, last)[0][:, sector.nodes]
        own = slice(start - first, end - first)
        total = np.einsum("n,knd->d", sector.fade * area, steps[own])
        along = steps @ (total / (np.linalg.norm(total) or 1.0))
        along[own] = 0.0
        return np.asarray(np.maximum(-along, 0.0).sum(axis=0))

    def _sticks(self, steps: Array, nodes: Indices) -> bool:
        """True if some nodes (m,), all in contact, have not all slipped in steps (k, m, 3)."""
        area = self._contact.surface.weights[nodes]
        *_, moved = _moved(steps, np.ones(len(nodes), dtype=bool), area)
        return bool(area[moved].sum() < GROSS * area.sum())


def shear_share(
    contact: ContactHistory,
    sector: Sector,
    state: int,
    friction: float,
    axis: Array,
    reach: tuple[float, float],
) -> float:
    """Mean shear along an axis over the mean of f p, of the nodes of a sector that are pressed.

    Args:
        contact: one contact.
        sector: around a station.
        state: of the tractions.
        friction: coefficient.
        axis: (3,) unit vector.
        reach: smallest and largest place of the nodes, inward from the reference.

    Returns:
        Positive, or NaN where nothing is pressed or there is no friction.
    """
    traction = contact.traction[state][sector.nodes]
    counted = (sector.s > reach[0]) & (sector.s < reach[1]) & (traction[:, 0] > 0)
    nodes, weights = sector.nodes[counted], sector.fade[counted]
    weights = weights * contact.surface.weights[nodes]
    bound = friction * float(weights @ traction[counted, 0])
    if not bound > 0:
        return np.nan
    shear = np.einsum("nt,ntd->nd", traction[counted, 1:], contact.surface.frames[nodes, 1:])
    return float(abs(weights @ shear @ axis) / bound)


def _moved(steps: Array, closed: Bools, weights: Array) -> tuple[Array, float, Bools]:
    """Slip (m,) as of `_forward`, how straight it is, and nodes in contact (m,) that have slipped.

    Args:
        steps: (k, m, 3) slip in each step.
        closed: (m,) nodes in contact.
        weights: (m,) of all nodes.
    """
    slip, straight = _forward(steps, weights[closed], closed)
    return slip, straight, closed & (slip > SMALLEST_SLIP * slip.max(initial=0.0))


def _forward(steps: Array, weights: Array, closed: Bools) -> tuple[Array, float]:
    """(m,) slip in the direction of the mean of it, and how straight that is, from 0 to 1.

    Increments the other way do not count.

    The step in which slip turns round still holds slip of the half cycle before.

    Args:
        steps: (k, m, 3) slip in each step.
        weights: (n,) of the nodes in contact.
        closed: (m,) which these are.
    """
    means = np.einsum("n,knd->kd", weights, steps[:, closed])
    total = means.sum(axis=0)
    size = float(np.linalg.norm(total))
    if size == 0:
        return np.zeros(steps.shape[1]), 1.0
    along = means @ (total / size)
    # The way forward over its length; the step in which slip turns round goes back.
    forward = along > 0
    straight = along[forward].sum() / np.linalg.norm(means[forward], axis=1).sum()
    return np.maximum(steps @ (total / size), 0.0).sum(axis=0), float(straight)
