# SPDX-License-Identifier: LGPL-3.0-or-later
"""Growth of a slip zone in a half cycle, by the edge factors: the slip that it leaves behind.

Where slip has come to the depth D, by what the edge remembers (`edge_memory`), another dK that it
takes there makes slip in proportion to sqrt(D - y) dK (the field of a stuck edge, theory guide,
slip zones).

If D grows steadily from zero the slip of a half cycle is (D - y)^(3/2). It is not if an inner loop
closes on the way, so that D jumps, or if the load goes beyond all that was before, behind which D
grows twice as fast.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.evaluate.edge_memory import LEVELS, EdgeMemory
from fretfe.evaluate.edge_slip import TOLERANCE
from fretfe.evaluate.slip import LEFT_OPEN, SlipBorder

# Next to the border no shape.
TIP = 0.02
# Part of the drive by which a loop may miss its beginning by the error of K_T; f K_I, which moves
# the edge to first order only, counts besides, to `LEFT_OPEN`.
LOOSE = 0.005
# Times that a border is found with the shape by the border of the time before, part of what that
# changes that may be wrong, and the fewest elements of a zone that tell its shape.
PASSES = 3
UNSURE = 0.2
FEWEST = 4.0
# Growth other than the loads tell has to leave an error bar so many times as small.
CLEARLY = 3.0
# Points, in standard deviations, and weights of a mean by three.
MEAN = ((-math.sqrt(3), 1 / 6), (0.0, 2 / 3), (math.sqrt(3), 1 / 6))
# Elements by which borders behind edges that move, or of zones that jumped, may be off: 320 of
# 322 zones of half-planes with this in their bars.
APART = 0.2
# Slip forward and backward.
WAYS = (1, -1)
# A shape within so much of (D - y)^(3/2) is that.
EVEN = 0.05


@dataclass(frozen=True)
class Growth:
    """Slip zone of a half cycle.

    Attributes:
        depth: (m,) f K_N y, from the outermost place of the edge inward.
        rate: (m,) increase of the drive while the zone ended at each depth.
        edge: f K_N y of the edge at the end of the half cycle.
        unit: f K_N then.
        loose: part of the drive by which a loop may miss its beginning.
    """

    depth: Array
    rate: Array
    edge: float
    unit: float
    loose: float

    @property
    def border(self) -> float:
        """The inner end, as f K_N y."""
        return float(self.depth[self.rate > 0].max(initial=self.edge))

    @property
    def length(self) -> float:
        """From the edge to the inner end."""
        return (self.border - self.edge) / self.unit

    @property
    def nothing(self) -> bool:
        """True if nothing drives slip but round-off."""
        return not self.rate.any()

    @cached_property
    def even(self) -> bool:
        """True if the zone has grown steadily, or there is none."""
        if not self.border > self.edge:
            return True
        return bool(np.ptp(self.stretch(np.linspace(0.0, 0.95, 20))) < EVEN)

    @cached_property
    def nearly_even(self) -> bool:
        """True if the zone has grown steadily but for the last loose part of the drive."""
        beyond = np.cumsum(self.rate[::-1])[::-1]
        return replace(self, rate=np.where(beyond > self.loose * beyond[0], self.rate, 0.0)).even

    def stretch(self, share: Array, deviation: Array | float = 0.0) -> Array:
        """(n,) |slip|^(2/3) over that of a zone that grew steadily, but for a factor.

        Args:
            share: (n,) places as parts of the length of the zone from the edge inward.
            deviation: (n,) standard deviations of weights with these centres over which both are
                means, in the same parts.
        """
        slip, steady = np.zeros(len(share)), np.zeros(len(share))
        for point, weight in MEAN:
            part = np.clip(share, 0.0, 1.0 - TIP) + point * deviation
            y = self.edge + part * (self.border - self.edge)
            slip += weight * np.sqrt(np.maximum(self.depth - y[:, None], 0.0)) @ self.rate
            steady += weight * np.maximum(self.border - y, 0.0) ** 1.5
        found = (slip / steady) ** (2 / 3)
        return np.asarray(found / found.mean())


# Growth of the zone between two states; None if it is not known.
FindGrowth = Callable[[int, int], Growth | None]


def zone_growth(memory: EdgeMemory, start: int, end: int, outer: Bools) -> Growth | None:
    """Growth of the slip zone of a half cycle; None if what is locked in there is not known.

    Of slip forward and backward in it that counts which takes more of the shear.

    Args:
        memory: of the edge.
        start: first state.
        end: last state.
        outer: (T,) whether the slip in the step to each state counts.
    """
    station, f = memory.station, float(memory.friction.max())
    if start < memory.begin or not math.isfinite(station.k_n[end]):
        return None
    hold, unit = station.hold[: end + 1], f * float(station.unit[end])
    half = slice(start, end + 1)
    largest = float(hold[half].max())
    way = max(WAYS, key=lambda each: memory.slip.between(start, end, each, outer).taken)
    pieces = memory.slip.between(start, end, way, outer)
    if not memory.knows(pieces.deepest, start):
        return None
    slips = pieces.taken > TOLERANCE * f * largest
    if slips and (np.diff(hold[memory.begin :]) > 0).any():  # the shape of the nodes
        pieces = memory.of_nodes.between(start, end, way, outer)
    levels = np.linspace(largest, memory.hold_of(pieces.deepest), LEVELS + 1)
    depth, rates = 2 * unit * (largest - levels), unit / f * pieces.within(memory.made(levels))
    drive, moved = float(rates.sum()), 2 * unit * float(np.ptp(hold[half]))
    if not drive > TOLERANCE * unit * largest:
        rates, drive = 0.0 * rates, 0.0
    loose = min(LOOSE + moved / (2 * drive), LEFT_OPEN) if drive > 0 else 0.0
    edge = 2 * unit * (largest - float(hold[end]))
    middle, k_n = (depth[1:] + depth[:-1]) / 2, float(station.k_n[end])
    return Growth(middle, rates, edge, f * k_n, loose)


def evened(
    growth: Growth,
    s: Array,
    border: SlipBorder,
    find: Callable[[Array], SlipBorder],
    size: float,
    deviation: Array | float = 0.0,
) -> SlipBorder:
    """Border of a zone that need not have grown steadily.

    The slip is made what steady growth would leave; of the growth and steady growth that one counts
    which leaves the straighter line: steady growth if it is clearly straighter, or if only the end
    of the growth tells otherwise, and not clearly. The bar then holds half of the way to the other
    one, or all of it, if that is not clearly less straight.

    Args:
        growth: of the zone.
        s: (n,) distances of the nodes from the edge inward.
        border: as if the zone had grown steadily.
        find: gives the border if slip is divided by factors (n,).
        size: of the elements at the border.
        deviation: (n,) as of `Growth.stretch`, as a length.
    """
    if border.gross or not border.length > 0:
        return border
    apart = APART * size
    if growth.even:
        moved = apart if growth.loose > 2 * LOOSE else 0.0
        return replace(border, spread=math.hypot(border.spread, moved))
    if border.length < FEWEST * size:
        spread = math.hypot(border.spread, apart, border.length - growth.length)
        return replace(border, spread=spread)
    grown = _settled(growth, s, border, find, deviation)
    # Loops that all but close may as well be closed.
    clearly = 1 / CLEARLY if growth.nearly_even else CLEARLY
    best, other = (grown, border) if grown.spread <= clearly * border.spread else (border, grown)
    doubt = other.length - best.length if other.spread < CLEARLY * best.spread else 0.0
    doubt = doubt if growth.nearly_even else doubt / 2
    if math.isinf(grown.spread):  # no border has slip of that shape before it
        doubt = growth.length - best.length
    changed = UNSURE * (best.length - border.length)
    return replace(best, spread=math.hypot(best.spread, apart, changed, doubt))


def _settled(
    growth: Growth,
    s: Array,
    border: SlipBorder,
    find: Callable[[Array], SlipBorder],
    deviation: Array | float,
) -> SlipBorder:
    """Border with the shape by the border of the time before; arguments as of `evened`."""
    before = border
    for _ in range(PASSES):
        stretch = growth.stretch(s / border.length, deviation / border.length)
        before, border = border, find(stretch**1.5)
        if border.gross or not border.resolved or not border.length > 0:
            return replace(before, spread=math.inf)
    return replace(border, spread=math.hypot(border.spread, border.length - before.length))
