# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip-zone length at an edge of a plane contact, from the slip of its nodes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.growth import FindGrowth, Growth, evened
from fretfe.evaluate.numerics import average, rising_zero
from fretfe.evaluate.plane.section import PlaneFront, hats, main_patch
from fretfe.evaluate.slip import (
    FEWEST_STUCK,
    SMALLEST_SLIP,
    FindBorder,
    SlipBorder,
    slip_in_steps,
)
from fretfe.history.solution import OPEN, ContactHistory
from fretfe.history.state_array import blocks

# Error of a node of slip^(2/3), as an error of its place in elements: of finite elements, and of
# averages over the support of a node.
NODAL_ERROR = 0.05
# Half-width of the 95 % interval over the estimated error.
INTERVAL = 2.0
# Error bar of a border behind few slipping nodes, in elements, times their number to the power of
# 1.5: what they hide. Without a fit it is UNSEEN elements.
FEW = 2.4
UNSEEN = 1.5
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

# What linear elements, which are too stiff, may move the border of slip by, in elements, times the
# length of the zone in elements: one of two of them was .8 of one too long.
LINEAR_ELEMENTS = 1.6
# What bodies of linear elements, which are too stiff, move it by besides: a half-width that is too
# small by half of what K_N is too large by, and 5.3 % where the zone reaches far inward.
LINEAR_BODIES = 0.055

# Means of hat functions nearer to the border than the root of so many variances, .7 of an element,
# reach beyond it too far.
OUTSIDE_HAT = 3.0

# Part of the largest slip of a half cycle from which on the middle of a contact slides. Less is
# what the way to a steady cycle leaves.
SLIDES = 0.01

# Fewer slipping nodes than this leave no two beside the outermost one.
FEWEST_LAST = 3


def slip_border(s: Array, slip: Array, slipping: Bools, *, uneven: bool = False) -> SlipBorder:
    """Return the slip-zone length at one edge; all arrays (n,), nodes *in contact* only.

    |slip|^(2/3) is a smooth function that vanishes linearly at the stick-slip border. The node at
    the border is left out, since its slip is an average over stick and slip; lines and parabolas
    through the next few, or many, nodes are averaged (``average``). Slip of sticking nodes is taken
    as the noise of the samples.

    Args:
        s: distances of the nodes from the edge inward, increasing.
        slip: slip increment since the last reversal (or from zero).
        slipping: whether the node slips.
        uneven: whether errors of nodes go with the elements around each, not with those at the
            border.
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
        border, spread, hidden = _border(s[zone] - low, amount[zone], noise, size, uneven=uneven)
        if abs(border - (high - low) / 2) < 1.5 * size + hidden:
            # Noise hides small slip behind the last node that is known to slip. That node may stand
            # behind the border itself where slip is a mean over the support of each node; few
            # nodes cannot tell.
            behind = size if zone.size >= COUNTS[0] else 0.0
            inside = border if hidden else np.clip(border, -behind, high - low)
            return SlipBorder(float(low + inside), resolved=True, gross=False, spread=spread)
    return SlipBorder(float((low + high) / 2), resolved=False, gross=False, spread=UNSEEN * size)


def _border(
    s: Array, amount: Array, noise: float, size: float, *, uneven: bool
) -> tuple[float, float, float]:
    """Return the place of the border, its error bar, and over what length noise hides the slip.

    Args:
        s: (m,) places of slipping nodes, from the border outward, m >= 2.
        amount: (m,) their slip.
        noise: standard deviation of the slip.
        size: element size at the border.
        uneven: as of `slip_border`.

    Returns:
        NaN, infinity and 0 if the slip does not fall toward the border.
    """
    highest, nodes = HIGHEST if noise else 2, s.size
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
        nodes -= int(np.count_nonzero(~clear))
    noisy = 2 / 3 * noise / np.sqrt(np.maximum(expected, (HIDDEN * noise) ** (2 / 3) or 1.0))
    sizes = np.abs(np.gradient(s)) if uneven else size
    errors = np.hypot(noisy, NODAL_ERROR * sizes * slope)
    fits = _zeros(s, w, errors, highest)
    if s.size < COUNTS[0]:  # nothing to compare a line with, but the one without its last node
        place, bar = fits[0, -1, 0], INTERVAL * fits[1, -1, 0]
        if s.size > 2:
            bar = np.hypot(bar, place - _zero(s[:-1], w[:-1], errors[:-1], 1)[0])
    else:
        known = np.ones_like(fits[0])
        place, bar, _ = average(fits[0], fits[1], 0.0 * known, known, INTERVAL)
    # Slip may be curved, and the mean at the border that is left out is one more node.
    return float(place), float(np.hypot(bar, FEW * size / (nodes + 1) ** 1.5)), hidden


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
    matrix = (s[:, None] / scale) ** np.arange(order + 1) / errors[:, None]
    inverse = np.linalg.pinv(matrix)
    zero, error = rising_zero(-(inverse @ (w / errors)), inverse, 2.0)
    return zero * scale, error * scale


def slip_border_of(
    contact: ContactHistory,
    front: PlaneFront,
    position: Array,
    least: Array,
    degree: int,
    growth: FindGrowth = lambda *_: None,
) -> FindBorder:
    """Slip zones of a solved contact at a front.

    Args:
        contact: one contact.
        front: one of its fronts.
        position: (T,) of the edge.
        least: (T,) slip of a node beyond which it counts in the step to each state.
        degree: of the displacements; 0 of half-planes, which are exact.
        growth: gives the growth of the zone of a half cycle.
    """
    return lambda start, end: _border_between(
        contact, front, start, end, float(position[end]), least, degree, growth(start, end)
    )


def _border_between(
    contact: ContactHistory,
    front: PlaneFront,
    start: int,
    end: int,
    position: float,
    least: Array,
    degree: int,
    growth: Growth | None,
) -> SlipBorder:
    """Slip zone between two states, from the slip that happened while in contact.

    K_T may reverse between two steps, so that the first step of a half cycle still holds slip of
    the half cycle before: only slip in the direction of the largest slip at this front counts.
    `growth` tells what slip to expect if the zone did not grow steadily, and if none is driven from
    the edge: nodes that open and close slip all the same. If the middle slides too, or all does,
    that has come from elsewhere, and no length is that of the edge.
    """
    closed = contact.status[end] != OPEN
    patch = main_patch(contact.surface.arc, contact.traction[end, :, 0])
    closed[: patch.first] = closed[patch.last + 1 :] = False
    nodes = front.from_front(np.flatnonzero(closed))
    nearby = nodes[: len(nodes) // 2]
    steps = partial(_steps, contact, start, end, least, nearby)
    line = np.ones(1) if contact.slip.shape[2] == 1 else _line(steps(), nearby)
    forward, backward = _slip_both_ways(steps(), line)
    total = (forward - backward)[nearby]
    direction = np.sign(total[np.argmax(np.abs(total))])
    slip = {1.0: forward, -1.0: backward}.get(direction, np.zeros_like(forward))
    undriven = growth is not None and growth.nothing
    largest = SLIDES * np.maximum(forward, backward)[nodes].max(initial=0.0)
    middle = slip[nearby[-1:]]
    # Half-planes have their nodes, as if slip were that of points: their bars hold the difference.
    centres, variances = hats(contact.surface.arc) if degree else (contact.surface.arc, None)
    s, slip = front.distances(centres[closed], position), slip[nodes]
    moved = _moved(slip)
    slides = undriven and bool((middle > largest).any() or moved.all())
    if undriven and not slides:
        slip, moved = 0.0 * slip, np.zeros_like(moved)
    find = partial(slip_border, slipping=moved, uneven=degree > 0)
    border, alike, deviation = find(s, slip), s, np.zeros_like(s)
    if variances is not None:
        variances = front.from_front(variances[closed])
        alike, deviation = _alike(s, variances, border.length), np.sqrt(variances)
        border = find(alike, slip)
    place = int(np.clip(np.searchsorted(s, border.length), 1, len(s) - 1))
    size = float(s[place] - s[place - 1])
    if growth is not None:
        border = evened(
            growth, s, border, lambda stretch: find(alike, slip / stretch), size, deviation
        )
    grown = None if growth is None or growth.even else growth
    # What slips a little beyond a loop that all but closes is of no shape: fits are in doubt, too.
    doubted = grown is not None and (grown.nearly_even or border.spread > size / 2)
    # That of unlike bodies, of which no growth is known, has a shape of its own.
    points = degree == 0 and growth is not None and not doubted
    if points and grown and border.length > 0:
        slip = slip / grown.stretch(s / border.length, deviation / border.length) ** 1.5
    border = _as_last_nodes(border, s, slip, moved, points=points, exact=degree == 0)
    if degree and border.length > 0:  # few large elements in front of a kink: up to .28 of one off
        border = replace(border, spread=max(border.spread, size / math.sqrt(12)))
    if degree == 1 and border.length > 0:
        hidden = LINEAR_ELEMENTS * size * min(size / border.length, 0.5)
        stiff = LINEAR_BODIES * border.length
        border = replace(border, spread=math.hypot(border.spread, hidden, stiff))
    behind = _slip_behind(moved)
    missed = [] if behind is None else [float(s[behind]) - border.length]
    if slides:
        missed.append(border.length)
    if border.gross or not missed:
        return border
    return replace(border, resolved=False, spread=max(border.spread, *missed))


def _alike(s: Array, variances: Array, border: float) -> Array:
    """(n,) places at which slip is what its means over hat functions are, x^(3/2) from a border.

    They are farther from it: the mean of x^(3/2) is that of the centre times 1 + 3/8 v/x^2.

    Args:
        s: (n,) distances of the centres from the edge inward.
        variances: (n,) v.
        border: distance of the border; NaN without one.
    """
    x = border - s
    inside = x > np.sqrt(OUTSIDE_HAT * variances)
    return s - np.where(inside, variances / (4 * np.where(inside, x, 1.0)), 0.0)


def _moved(slip: Array) -> Bools:
    """Flags of nodes that have slipped: the last of a zone may have by less than `SMALLEST_SLIP`.

    More than one such is what a loop that almost closes leaves behind the border.

    Args:
        slip: (n,) in the direction that counts, from the edge inward, not negative.
    """
    moved = np.asarray(slip > SMALLEST_SLIP * slip.max())
    stuck = np.flatnonzero(~moved[1:]) + 1  # the status of the outermost node means nothing
    if len(stuck) > 1 and not slip[stuck[0] + 1] > 0:
        moved[stuck[0]] = slip[stuck[0]] > 0
    return moved


def _as_last_nodes(
    border: SlipBorder, s: Array, slip: Array, slips: Bools, *, points: bool, exact: bool
) -> SlipBorder:
    """The border, or what the last nodes that slip say of it if that is clearly something else.

    Of half-planes, whose slip has no noise, it has the truer bar, if fits are not far from it.

    Slip that passes the border of the slip before it is the sum of two powers of 3/2 that end at
    either border, and few nodes may lie between these. But whatever the slip is like, its border
    lies between the last node that slips and the first that does not: the bar holds all between.

    Of one power of 3/2 the line through |slip|^(2/3) at the last two nodes ends x elements behind
    the last one, the border x^1.9: in tractions that are linear between the nodes the last one
    slips by a mean over its support. Half-planes .03 of an element, where P moves the edge .1,
    finite elements .25.

    Args:
        border: by fits through more nodes.
        s: (n,) distances of the nodes from the edge inward.
        slip: (n,) their slip, of nodes means over their supports.
        slips: (n,) whether they slip.
        points: whether slip is one power of 3/2 at the border, without noise.
        exact: whether the bodies are half-planes: their nodes tell it where no fit does.
    """
    count = int(np.argmin(slips[1:])) + 1
    if border.gross or not (border.resolved or exact) or count < FEWEST_LAST:
        return border
    outer, last, first = s[count - 2 : count + 1]
    before, after = slip[count - 2 : count] ** (2 / 3)
    size = float(first - last)
    # A line that ends behind the first node that sticks has a border within it.
    inside = after * (first - outer) < before * size
    part = (after * (last - outer) / ((before - after) * size)) ** 1.9 if inside else 0.5
    other = float(last) + part * size
    apart = abs(border.length - other)
    if points and inside and apart < size / 4 and slip[count + 1] <= ROUND_OFF * slip.max():
        # The first nodes know the edge to half an element, over how many share it.
        spread = math.hypot(INTERVAL * NODAL_ERROR * size, size / (2 * count), apart / 2)
        length = border.length if apart < NODAL_ERROR * size else other
        return replace(border, length=length, spread=spread, resolved=True)
    if border.resolved and apart < math.hypot(border.spread, size / math.sqrt(12)):
        return border
    spread = math.hypot(max(part, 1 - part), INTERVAL * NODAL_ERROR) * size
    return replace(border, length=other, spread=spread, resolved=True)


def _line(steps: Iterator[Array], nodes: Indices) -> Array:
    """(2,) unit vector of the largest slip of some nodes in steps.

    Args:
        steps: (n, N, 2) slip, block by block.
        nodes: (n,) of the slip zone and around it.
    """
    total = np.sum([each[:, nodes].sum(axis=0) for each in steps], axis=0)
    size = np.linalg.norm(total, axis=1)
    largest = int(size.argmax()) if len(size) else 0
    return np.asarray(total[largest] / size[largest]) if size.any() else np.array([1.0, 0.0])


def _steps(
    contact: ContactHistory, start: int, end: int, least: Array, nodes: Indices
) -> Iterator[Array]:
    """(n, N, d - 1) slip in the steps between two states at nodes and around, block by block."""
    for part in blocks(end - start, math.prod(contact.slip.shape[1:])):
        first, last = start + part.start, start + part.stop
        yield slip_in_steps(contact, first, last, least, nodes)


def _slip_both_ways(steps: Iterator[Array], line: Array) -> tuple[Array, Array]:
    """(N,) sums of slip increments in steps (n, N, d - 1) along a line (d - 1,) and against it."""
    along = (each @ line for each in steps)
    both = [(np.maximum(e, 0.0).sum(axis=0), np.maximum(-e, 0.0).sum(axis=0)) for e in along]
    forward, backward = np.sum(both, axis=0)
    return forward, backward


def _slip_behind(moved: Bools) -> int | None:
    """Innermost node that has slipped behind one that has not; None without any.

    What slips beyond the middle belongs to the other edge. Few sticking nodes in between are none.

    Args:
        moved: (n,) nodes in contact that have slipped, from the front inward.
    """
    stuck = np.flatnonzero(~moved[1:]) + 1  # the status of the outermost node means nothing
    if not len(stuck):
        return None
    between = moved[stuck[0] : min(int(stuck[-1]), len(moved) // 2)]
    if len(stuck) < FEWEST_STUCK:
        return len(moved) - 1
    return int(stuck[0] + np.flatnonzero(between)[-1]) if between.any() else None
