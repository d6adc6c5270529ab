# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads of an edge as what it remembers follows them: each increment as if it had one size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.evaluate.contacts import LARGEST_SPREAD, NOTHING, StationHistory
from fretfe.evaluate.increments import left_over, mean_of_ends, next_known
from fretfe.history.solution import Factor

History = TypeVar("History", bound=StationHistory)
# Factors of drivers cancel one another where their sum is less than this part of its terms.
CANCELS = 0.3
# Part of its largest hold up to which an edge counts as parted between bodies with elements, or
# under several drivers: with less, what sums of increments miss of the shear is all that friction
# takes.
VANISHING = 0.05


@dataclass(frozen=True)
class EdgeLoads:
    """Loads of an edge at T states, in units of K of one of them; NaN where not known.

    Attributes:
        hold: (T,) of P, counted from where bodies touched last; 0 where they are apart.
        shear: (T,) along a direction, counted from the first known state.
        unit: (T,) factors of the edge as it is over those in that state.
        apart: second over first singular value of what drives the shear; 0 of one driver.
        loose: part of the range of the shear that cycles leave over, before that is taken out.
    """

    hold: Array
    shear: Array
    unit: Array
    apart: float = 0.0
    loose: float = 0.0


def edge_loads(
    units: Array, drivers: Array, friction: Bools, force: Array, direction: Array, state: int
) -> EdgeLoads:
    """Loads of an edge between similar bodies, each increment as if it had one size.

    Increments of K are those of the drivers times the mean of their factors at both ends over a
    factor of the shear there, in place of K: the ratio of both factors is that of the place, so
    that loads which return bring hold and shear back (exactly for half-planes, and for one driver
    of the shear).

    Args:
        units: (T, d, J) of the edge for a unit of each driver; NaN where unknown.
        drivers: (T, J) values of the drivers.
        friction: (T,) whether there is any in the step that ends at each state.
        force: (T,) P, 0 where there is no contact.
        direction: (2,) of the shear.
        state: of the size, or the last one before in which factors are known.
    """
    steps, axes = np.diff(drivers, axis=0), direction[: units.shape[1] - 1]
    normal, along = units[:, Factor.K_I], np.einsum("tcj,c->tj", units[:, Factor.K_T :], axes)
    unit, apart = _size_of_edge(normal, along, steps, friction[1:])
    known = np.flatnonzero(np.isfinite(unit))
    if len(known):
        unit = unit / unit[known[max(int(np.searchsorted(known, state, "right")) - 1, 0)]]
    ratios, touching = np.stack([normal, along], axis=1) / unit[:, None, None], force > 0
    told = touching & np.isfinite(ratios).all(axis=(1, 2))
    powers = _powers(ratios[told] * np.ptp(drivers, axis=0), force[told])
    # Contacts too small to tell go on from what they are next, or were.
    source = np.minimum(next_known(told), int(np.append(np.flatnonzero(told), 0).max()))
    share = np.divide(force, force[source], out=np.ones_like(force), where=touching & told[source])
    ratios = ratios[source] * share[:, None, None] ** powers
    increments = mean_of_ends(ratios[:, None], steps)[:, 0]
    for step in np.flatnonzero(np.diff(touching)):
        end = ratios[step + int(touching[step + 1])]
        increments[step] = (end / (1 + powers)) @ steps[step]
    increments[~friction[1:], 1] = 0.0
    return EdgeLoads(*_held(increments, touching), unit, apart)


def _powers(terms: Array, force: Array) -> Array:
    """(2, J) powers of P with which terms (n, 2, J) of loads go: -1/2 of a cylinder beside tension.

    Those of small terms are 0. A wedge has -1 there, whose hold has no end: as `VANISHING` has it.
    """
    size, terms = np.log(force / np.max(force, initial=0.0)), np.abs(terms)
    if not size.min(initial=0.0) < -VANISHING:
        return np.zeros(terms.shape[1:])
    large = terms.min(axis=0) > CANCELS * np.median(terms, axis=0).max(axis=1, keepdims=True)
    found = np.tensordot(size - size.mean(), np.log(np.where(large, terms, 1.0)), 1) / len(size)
    return np.asarray((found / size.var()).clip(VANISHING - 1, 1.0))


def returned(
    loads: EdgeLoads, drivers: Array, rubs: Bools, cycles: Sequence[tuple[int, int]]
) -> EdgeLoads:
    """Loads of an edge that return in cycles in which the drivers (T, J) do.

    Args:
        loads: of the edge.
        drivers: (T, J) values of the drivers.
        rubs: (T,) states in which bodies touch with friction.
        cycles: first and last state of each.
    """
    sums = np.array([loads.hold, loads.shear])
    left = left_over(np.diff(sums).T, drivers, rubs, cycles).T
    hold, shear = sums - np.pad(np.cumsum(np.nan_to_num(left), axis=1), ((0, 0), (1, 0)))
    most = max((abs(float(left[1, slice(*each)].sum())) for each in cycles), default=0.0)
    swing = float(np.nanmax(shear, initial=-np.inf) - np.nanmin(shear, initial=np.inf))
    hold = np.where(loads.hold > 0, hold, loads.hold)
    return replace(loads, hold=hold, shear=shear, loose=most / swing if swing > 0 else 0.0)


def without_traces(loads: EdgeLoads, *, exact: bool) -> EdgeLoads:
    """Loads of an edge without what its hold and shear are where that counts as parted.

    The shear is that in the state of the least hold among them: both vanish together. Sums are
    exact for half-planes under one driver.
    """
    least = min(VANISHING, loads.apart) if exact else VANISHING
    vanishes = loads.hold <= least * np.nanmax(loads.hold, initial=0.0)
    shear, runs = loads.shear.copy(), np.cumsum(np.diff(vanishes, prepend=False))
    for run in np.unique(runs[vanishes]):
        states = np.flatnonzero(runs == run)
        shear[states] = loads.shear[states[np.argmin(loads.hold[states])]]
    return replace(loads, hold=np.where(vanishes, 0.0, loads.hold), shear=shear)


def unlike_loads(k_i: Array, along: Array, touching: Bools, most: float) -> EdgeLoads:
    """The same between unlike bodies, whose factors are one number: only where slip turns round.

    Args:
        k_i: (T,) K_I.
        along: (T,) K along a direction.
        touching: (T,) states in which there is contact.
        most: hold in the last known state, with which the contact does not slide as a whole.
    """
    known = k_i[np.isfinite(k_i)]
    held = most + k_i - (known[-1] if len(known) else 0.0)
    return EdgeLoads(np.where(touching, held, 0.0), along, np.ones(len(k_i)))


def _held(increments: Array, touching: Bools) -> tuple[Array, Array]:
    """(T,) hold and shear of an edge from their increments (T - 1, 2), NaN where unknown."""
    sums = np.zeros((len(touching), 2))
    for state, step in enumerate(increments, start=1):
        before, known = sums[state - 1], np.isfinite(step).all()
        if not touching[state]:
            sums[state] = 0.0, before[1] + step[1] if known else before[1]
        elif not known:
            sums[state] = np.nan
        else:
            sums[state] = before + step
    return sums[:, 0], sums[:, 1]


def _size_of_edge(
    normal: Array, shear: Array, steps: Array, friction: Bools
) -> tuple[Array, float]:
    """(T,) factor that tells the size of an edge: of the set of drivers that makes most of a load.

    And how large what is independent of that set is, over it.

    Args:
        normal: (T, J) K_I for a unit of each driver; NaN where unknown.
        shear: (T, J) the same of the shear.
        steps: (T - 1, J) increments of the drivers.
        friction: (T - 1,) whether the shear counts in each.
    """
    known = np.isfinite(shear).all(axis=1)
    if not known.any():
        return np.full(len(shear), np.nan), 0.0
    rubbed = steps * friction[:, None]
    driven, pressed = (np.nansum(np.abs(u[1:] * c)) for u, c in ((shear, rubbed), (normal, steps)))
    # Where P alone drives an edge its own factor tells as much: finite bodies shear by .13 % of it.
    units, counted = (shear, rubbed) if driven > NOTHING / 10 * pressed else (normal, steps)
    sizes = np.median(np.abs(units[known]), axis=0)
    steps = counted * sizes
    # The places of the way that the loads go, by its length: the same however steps are divided.
    length = np.linalg.norm(steps, axis=1)
    way = np.cumsum(steps, axis=0) - steps / 2
    way -= length @ way / (length.sum() or 1.0)
    # A line has its own extent about its middle, whose square is a twelfth of its length's.
    rows = np.vstack([way, steps / np.sqrt(12)]) * np.sqrt(np.tile(length, 2))[:, None]
    _, values, sets = np.linalg.svd(rows, full_matrices=False)
    beside = float(values[1] / values[0]) if len(values) > 1 and values[0] > 0 else 0.0
    shares = np.divide(sets[0], sizes, where=sizes > 0, out=np.zeros_like(sizes))
    together, apart = np.abs(units @ shares), np.linalg.norm(units * shares, axis=1)
    # Drivers that cancel one another at a place are no measure of its size.
    size = apart if (together[known] < CANCELS * apart[known]).any() else together
    size = np.where(size > 0, size, np.nan) if size[known].any() else np.where(known, 1.0, np.nan)
    return size, beside


def k_n_by_hold(station: History) -> History:
    """Its K_N in states that hardly know it by two that do, as a power of the hold.

    As P moves an edge its K_N goes with the hold, but fits know it better or worse as the edge lies
    in an element. The bar has all that it differs by from the nearer one of both, and is less than
    half that of the fit; none is farther from the two than they are apart.
    """
    k_n, spread, hold = station.k_n, station.k_n_spread, station.hold
    known = np.flatnonzero((spread < LARGEST_SPREAD * k_n) & (hold > 0))
    order = known[np.unique(hold[known], return_index=True)[1]]
    if len(order) < 2:
        return station
    at = np.searchsorted(hold[order], hold).clip(1, len(order) - 1)
    low, high = order[at - 1], order[at]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.log(hold / hold[low]) / np.log(hold[high] / hold[low])
    near = abs(share - 0.5) <= 1.5
    found = k_n[low] * (k_n[high] / k_n[low]) ** np.where(near, share, 0.0)
    apart = abs(found - np.where(share < 0.5, k_n[low], k_n[high]))
    bar = np.hypot(np.maximum(spread[low], spread[high]), apart)
    # Where all of a contact slides its edges move by more than their hold: fits are to agree.
    better = near & ~(2 * bar >= spread) & ~(abs(found - k_n) > spread)
    k_n, spread = np.where(better, found, k_n), np.where(better, bar, spread)
    return replace(station, k_n=k_n, k_n_spread=spread)
