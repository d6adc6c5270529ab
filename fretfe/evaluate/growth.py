# SPDX-License-Identifier: LGPL-3.0-or-later
"""Growth of a slip zone in a half cycle, by the edge factors: the slip that it leaves behind.

Where forward slip has come to the depth D, by what places remember (`edge_memory`), another dK of
K_T - f K_I makes slip in proportion to sqrt(D - y) dK (the field of a stuck edge, theory guide,
slip zones).

If D grows steadily from zero the slip of a half cycle is (D - y)^(3/2). It is not if an inner loop
closes on the way, so that D jumps, or if the load goes beyond all that was before, behind which D
grows twice as fast.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import StationHistory
from fretfe.evaluate.edge_memory import SLACK, depths, remembered
from fretfe.evaluate.slip import SlipBorder

# Next to the border no shape.
TIP = 0.02
# Part of the drive by which a loop may miss its beginning by the error of K_T; f K_I, which moves
# the edge to first order only, counts besides; and the most of both.
LOOSE = 0.005
MOST_LOOSE = 0.1
# Part of the drive that is round-off, and of K_T and f K_I that drives nothing.
ROUND_OFF = 1e-12
UNDRIVEN = 1e-6
# Times that a border is found with the shape by the border of the time before, part of what that
# changes that may be wrong, and the fewest elements of a zone that tell its shape.
PASSES = 3
UNSURE = 0.2
FEWEST = 4.0
# Growth other than the loads tell has to leave an error bar so many times as small.
CLEARLY = 3.0
# Points, in standard deviations, and weights of a mean by three.
MEAN = ((-math.sqrt(3), 1 / 6), (0.0, 2 / 3), (math.sqrt(3), 1 / 6))
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
        lengths: (n,) from the edge to the inner end at each state of the half cycle.
    """

    depth: Array
    rate: Array
    edge: float
    unit: float
    loose: float
    lengths: Array

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

    @property
    def even(self) -> bool:
        """True if the zone has grown steadily, or there is none."""
        if not self.border > self.edge:
            return True
        stretch = self.stretch(np.linspace(0.0, 0.95, 20))
        return bool(np.ptp(stretch) < EVEN)

    def versions(self) -> tuple[Growth, ...]:
        """The growth, and up to where it jumps at the end by little of the drive.

        Where a loop closes then the zone jumps, or does not.
        """
        beyond, jumps = self._beyond, self._jumps
        return self, *map(self._before, jumps[beyond[jumps] < MOST_LOOSE * beyond[0]])

    @property
    def nearly_even(self) -> bool:
        """True if the zone has grown steadily but for the last loose part of the drive."""
        beyond = self._beyond
        kept = np.where(beyond > self.loose * beyond[0], self.rate, 0.0)
        return replace(self, rate=kept).even

    @property
    def beyond(self) -> float:
        """Part of its length by which the zone jumps at its end while no node need show it.

        That takes little of the drive; what f K_I moves the edge by may close a loop as well, and
        edges of finite elements move a little at constant P.
        """
        beyond, jumps = self._beyond, self._jumps
        if not len(jumps):
            return 0.0
        last = jumps[-1]
        if not max(self.loose - LOOSE, 0.1 * LOOSE) < beyond[last] / beyond[0] < MOST_LOOSE:
            return 0.0
        kept = self._before(last).length
        return self.length / kept - 1.0 if kept > 0 else math.inf

    def _before(self, jump: int) -> Growth:
        """The growth up to where it jumps to a depth."""
        return replace(self, rate=np.where(np.arange(len(self.rate)) < jump, self.rate, 0.0))

    @property
    def _jumps(self) -> Indices:
        """Depths to which the zone jumps."""
        return np.flatnonzero((self.rate[1:] > 0) & (self.rate[:-1] == 0)) + 1

    @property
    def _beyond(self) -> Array:
        """(m,) the drive while the zone ended at each depth or farther inward."""
        return np.asarray(np.cumsum(self.rate[::-1])[::-1])

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


def zone_growth(
    station: StationHistory, friction: Array, start: int, end: int, outer: Bools
) -> Growth | None:
    """Growth of the slip zone of a half cycle at a station; None if its factors are not known.

    Of slip forward and backward in it that counts which is driven farther.

    Args:
        station: its factors, K_T along the direction of the slip.
        friction: (T,) coefficient in the step that ends at each state.
        start: first state.
        end: last state.
        outer: (T,) whether the slip in the step to each state counts.
    """
    f = float(friction.max())
    first = max(int(np.argmax(friction > 0)) - 1, 0)
    known = np.isfinite(station.k_t) & np.isfinite(station.k_i)
    known[end] &= np.isfinite(station.k_n[end])
    gaps = np.flatnonzero(~known[: start + 1])
    begin = max(first, int(gaps[-1]) + 1 if len(gaps) else 0)
    if not f > 0 or begin > start or not known[begin : end + 1].all():
        return None
    states = np.arange(begin, end + 1)
    k_t, retreat = station.k_t[states], f * (station.k_i[states].max() - station.k_i[states])
    ends = depths(k_t, retreat)
    if not ends[-1] > 0:
        return None
    counted = outer[states] & (states > start)
    depth = (ends[1:] + ends[:-1]) / 2
    driven = _driven(k_t, retreat, ends, counted, WAYS)
    way, (rates, reach) = max(driven.items(), key=lambda each: float(each[1][0].sum()))
    if begin > first and reach.max() > 2 * retreat[0]:  # places that may have slipped before
        return None
    if rates.any() and (np.diff(retreat) < 0).any():  # the shape is that of the nodes
        rates, _ = _driven(k_t, retreat, ends, counted, (way,), in_steps=True)[way]
    if not rates.sum() > UNDRIVEN * ends[-1]:
        rates, reach = 0.0 * rates, 0.0 * reach
    # A steady cycle comes back to its extreme but for round-off, which moves no border.
    rates = np.where(rates > ROUND_OFF * rates.sum(), rates, 0.0)
    half_cycle = slice(start - begin, None)
    drive, moved = float(rates.sum()), float(np.ptp(retreat[half_cycle]))
    loose = min(LOOSE + moved / drive, MOST_LOOSE) if drive > 0 else 0.0
    lengths = np.maximum(reach - 2 * retreat, 0.0)[half_cycle] / (f * station.k_n[start : end + 1])
    return Growth(depth, rates, 2 * float(retreat[-1]), f * float(station.k_n[end]), loose, lengths)


def evened(
    growth: Growth,
    s: Array,
    border: SlipBorder,
    find: Callable[[Array], SlipBorder],
    size: float,
    deviation: Array | float = 0.0,
) -> SlipBorder:
    """Border of a zone that need not have grown steadily.

    The slip is made what steady growth would leave; of all versions of the growth, and steady
    growth, that one counts which leaves the straightest lines: steady growth if it is clearly
    straighter, or if only the end of the growth tells otherwise, and not clearly. The bar then
    holds half of the way to those that are not clearly less straight.

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
    jump, apart = growth.beyond, size / math.sqrt(12)
    if growth.even:
        # Borders behind edges that move are off by up to .27 of an element.
        spread = math.hypot(border.spread, apart if growth.loose > 2 * LOOSE else 0.0)
        return replace(border, spread=spread, beyond=jump * border.length)
    versions = [each for each in growth.versions() if not each.even]
    nearly = growth.nearly_even
    weight = 1 / CLEARLY if nearly else CLEARLY
    if border.length < FEWEST * size:
        missed = min(abs(border.length - each.length) for each in versions)
        spread = math.hypot(border.spread, apart, missed)
        return replace(border, spread=spread, beyond=jump * border.length)
    found = [border, *(_settled(each, s, border, find, deviation) for each in versions)]
    straight = [each.spread * (weight if each is border else 1.0) for each in found]
    number = int(np.argmin(straight))
    best = found[number]
    rivals = [each for each in found if each.spread < (CLEARLY if nearly else 1.0) * best.spread]
    doubt = max((abs(each.length - best.length) / 2 for each in rivals), default=0.0)
    changed = UNSURE * (best.length - border.length)
    spread = math.hypot(best.spread, apart, changed, doubt)
    shown = number > 0 and versions[number - 1] is growth
    return replace(best, spread=spread, beyond=0.0 if shown else jump * best.length)


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


def _driven(
    k_t: Array,
    retreat: Array,
    depth: Array,
    counted: Bools,
    ways: Sequence[int],
    in_steps: bool = False,
) -> dict[int, tuple[Array, Array]]:
    """(m,) increase of the drive in some steps while the zone ended between two depths, by way.

    And (n,) the depth that slip has come to in them at each state.

    Args:
        k_t: (n,) at the states.
        retreat: (n,) f K_I below its largest value.
        depth: (m + 1,) f K_N y.
        counted: (n,) whether the step to each state counts.
        ways: of the slip, 1 forward and -1 backward.
        in_steps: as of `remembered`.
    """
    radius = depth / 2
    found = {way: (np.zeros(len(depth) - 1), np.zeros(len(k_t))) for way in ways}
    since = max(int(np.argmax(counted)) - 1, 0)
    steps = remembered(k_t, retreat, depth, in_steps, since)
    for state, memory in enumerate(steps, start=since + 1):
        now, moved = retreat[state], retreat[state] - retreat[state - 1]
        inside = int(np.searchsorted(radius, now))
        for way, (rates, reach) in found.items():
            reach[state] = reach[state - 1]
            if not counted[state]:
                continue
            drive, before = way * k_t[state] + now, way * k_t[state - 1] + retreat[state - 1]
            edge = now + way * float(np.interp(now, radius, memory))
            before = max(before, edge)
            # An edge that draws back over places that stick slips no more than round-off.
            if not drive - before > max(ROUND_OFF * depth[-1], SLACK * moved):
                continue
            # The drive from which on slip reaches each depth.
            onset = way * memory + radius
            onset[:inside] = edge
            onset = np.maximum.accumulate(onset)
            rates += np.diff(np.minimum(np.maximum(onset, before), drive))
            reach[state] = max(reach[state], float(np.interp(drive, onset, depth)))
    return found
