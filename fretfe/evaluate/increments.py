# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories of singular edge factors, by increments of full stick.

They add up the increments over the steps, each with the mean of the contact areas before and after
it; only steps with friction count. They are counted from the first state, or from the last one
before the cycle, or without one before the largest load, at which an increment is unknown: what is
not known is NaN, never zero. What a contact that carries little and is too small for its factors
adds is that of the nearest known state: it costs neither what lies before it nor what lies behind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import ROUND_OFF
from fretfe.evaluate.cycles import same_cycles
from fretfe.evaluate.factors import FactorHistories
from fretfe.evaluate.loaded import hardly_loaded, normal_force, slides_as_a_whole
from fretfe.evaluate.numerics import count_up, most_loaded
from fretfe.history.solution import ContactHistory, Factor, Solution
from fretfe.loads.history import CLOSED

Cycle = tuple[int, int] | None
# From the states of an interval of contact, and the cycle as counted in it, to (states, ...)
# histories.
CountInterval = Callable[[slice, Cycle], Array]


@dataclass(frozen=True)
class UnitFactors:
    """Singular factors, as `Factor`, for a unit of each of J drivers; NaN where unknown.

    Attributes:
        main: for each of R ways to determine them: (T, stations, d, J). They are made one after
            the other, and only once.
        fitted: (T, stations, d, J) by fits to tractions, as a check; None without them.
        exact: True for closed forms.
    """

    main: Iterable[Array]
    fitted: Array | None = None
    exact: bool = False


@dataclass(frozen=True)
class ContactSteps:
    """The steps of a contact, which add to the factors of its edges.

    Attributes:
        solution: the solved history, with the cycle of the contact.
        dundurs: beta.
        layer: (2,) lengths E*/k of a layer, across and along the surface; zero without one.
        friction: (T,) whether there is any in the step that ends at each state.
        touching: (T,) states in which there is contact.
        slides: (T,) states to which all that is in contact slips.
        cycles: first and last state of the evaluated cycle, and of the same ones before it.
        force: (T,) P.
        small: (T,) states of a contact that carries little and may be too small for its factors.
        intervals: first and last state of each run of states in which the contact exists, one at
            least. Histories begin anew with each.
        whole: the solved history with its own cycle.
    """

    solution: Solution
    dundurs: float
    layer: Array
    friction: Bools
    touching: Bools
    slides: Bools
    cycles: Sequence[tuple[int, int]]
    force: Array
    small: Bools
    intervals: tuple[tuple[int, int], ...]
    whole: Solution

    @classmethod
    def of(cls, solution: Solution, contact: ContactHistory, whole: Solution) -> ContactSteps:
        """Those of one of the contacts of a solved history, with its cycle and the one of all."""
        force = normal_force(contact)
        return cls(
            solution,
            contact.surface.dundurs,
            np.zeros(2) if contact.surface.layer is None else contact.surface.layer,
            contact.friction.acts,
            contact.pressed_nodes > 0,
            slides_as_a_whole(contact),
            same_cycles(solution, contact.friction),
            force,
            hardly_loaded(contact, force),
            contact.intervals,
            whole,
        )

    @property
    def swing(self) -> Cycle:
        """First and last state of the cycle with the states beside it that it leaves out.

        Factors of full stick are known there from one side, though the edges are not.
        """
        own, outer = self.solution.cycle, self.whole.cycle
        if own is None or outer is None:
            return None
        return max(own[0] - 1, outer[0]), min(own[1] + 1, outer[1])

    @property
    def known(self) -> Bools:
        """(T,) states in the interval of contact of the evaluated cycle.

        Without a cycle that is the last one; if no interval holds all of the cycle there are none.
        """
        cycle, states = self.solution.cycle, np.arange(len(self.solution.times))
        for first, last in self.intervals[::-1]:
            if cycle is None or first <= cycle[0] < cycle[1] <= last:
                return np.asarray((states >= first) & (states <= last))
        return np.zeros(len(states), dtype=bool)

    def by_interval(self, count: CountInterval) -> Array:
        """(T, ...) histories that begin anew with each interval of contact; NaN between them.

        Args:
            count: gives the histories of one interval; in place of a cycle that is not all in it
                it gets the state of the largest P.
        """
        cycle, found = self.solution.cycle, {}
        for first, last in self.intervals:
            inside = cycle is not None and first <= cycle[0] and cycle[1] <= last
            heaviest = most_loaded(self.force, np.arange(first, last + 1))
            begin, end = cycle if cycle is not None and inside else (heaviest, heaviest)
            found[first] = count(slice(first, last + 1), (begin - first, end - first))
        shapes = [each.shape[1:] for each in found.values()]
        histories = np.full((len(self.solution.times), *shapes[0]), np.nan)
        for first, each in found.items():
            histories[first : first + len(each)] = each
        return histories

    def histories(self, units: UnitFactors, *, alone: bool) -> FactorHistories:
        """Histories of factors from those for a unit of each driver.

        Args:
            units: of all stations.
            alone: whether each station counts by itself where it is unknown; otherwise all of them
                are unknown where one is.
        """
        drivers = self.solution.driver_values
        ways: list[Array] = []
        mean = np.zeros(0)
        known = np.zeros(len(drivers), dtype=bool)
        one_sided = uneven = np.empty(0)
        for each in units.main:
            groups = np.split(each, each.shape[1], axis=1) if alone else [each]
            filled = [self._filled(group) for group in groups]
            # What steps may be wrong by is the same in all ways, to a part of itself.
            if not ways:
                pairs = zip(groups, filled, strict=True)
                one_sided = np.concatenate([one_sided_sums(*pair, drivers) for pair in pairs])
                uneven = uneven_sums(each, drivers, self.friction)
                known = np.any([_known(group) for group in groups], axis=0)
            ways.append(np.concatenate([self._added(group) for group in filled]))
            whole = np.concatenate(filled, axis=1)
            mean = mean + (whole - mean) / len(ways) if mean.size else whole
        fitted = None
        if units.fitted is not None:
            fitted = self._added(self._filled(units.fitted))
        return FactorHistories(np.array(ways), fitted, units.exact, one_sided, uneven, known, mean)

    def without_small(self, known: Bools) -> ContactSteps:
        """The same with the part of the cycle around its largest P as the cycle of the contact.

        It ends before states that carry little and whose factors are not among those known (T,).
        """
        cycle = self.solution.cycle
        lost = np.flatnonzero(self.small & ~known)
        if cycle is None or not len(lost):
            return self
        heaviest = most_loaded(self.force, np.arange(cycle[0], cycle[1] + 1))
        begin = max(cycle[0], int(lost[lost < heaviest].max(initial=-1)) + 1)
        end = min(cycle[1], int(lost[lost > heaviest].min(initial=len(known))) - 1)
        return replace(self, solution=replace(self.solution, cycle=(begin, end)))

    def _filled(self, units: Array) -> Array:
        return beside_known(within_known(units, self.solution.step), self.small)

    def _added(self, units: Array) -> Array:
        """(stations, T, d) histories from known units (T, stations, d, J)."""

        def count(interval: slice, cycle: Cycle) -> Array:
            drivers, friction = self.solution.driver_values[interval], self.friction[interval]
            touching, unlike = self.touching[interval], self.dundurs != 0
            found = add_up(units[interval], drivers, friction, touching, cycle, unlike)
            return found.swapaxes(0, 1)

        return self.by_interval(count).swapaxes(0, 1)


def add_up(
    units: Array,
    drivers: Array,
    friction: Bools,
    touching: Bools,
    cycle: tuple[int, int] | None,
    unlike: bool = False,
) -> Array:
    """(stations, T, d) singular factors at each station, in the order of `Factor`.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        drivers: (T, J) values of the drivers.
        friction: (T,) whether there is any in the step that ends at each state.
        touching: (T,) states in which there is contact.
        cycle: its first and last state, or None.
        unlike: whether the bodies are: K_I and K_T are then one number, and counted together.
    """
    steps = np.diff(drivers, axis=0)
    increments = mean_of_ends(units, steps)
    increments[~steps.any(axis=1) | ~(touching[1:] | touching[:-1])] = 0.0
    increments[~friction[1:], :, 0 if unlike else Factor.K_T :] = 0.0
    increments -= left_over(increments, drivers, friction & touching, [cycle] if cycle else [])
    return count_up(increments, cycle).swapaxes(0, 1)


def _repeats(drivers: Array, rubs: Bools, cycle: tuple[int, int]) -> bool:
    """True if all drivers (T, J) return in a cycle in which bodies touch with friction (T,)."""
    first, last = cycle
    change = np.abs(drivers[last] - drivers[first])
    size = np.abs(drivers[first : last + 1]).max(axis=0)
    returns = np.all((change <= CLOSED * size) | (size <= ROUND_OFF * size.max()))
    return bool(last > first and returns and rubs[first + 1 : last + 1].all())


def left_over(
    increments: Array, drivers: Array, rubs: Bools, cycles: Sequence[tuple[int, int]]
) -> Array:
    """(T - 1, ..., d) what increments of cycles leave over though the drivers return, by step.

    At an edge that moves that is not nothing along a loop of P and Q. It is shared out over the
    steps in which the edge moves, as far as P changes K_I in each.
    """
    left = np.zeros_like(increments)
    for cycle in cycles:
        own = increments[slice(*cycle)]
        if _repeats(drivers, rubs, cycle):
            moved, drift = np.abs(own[..., Factor.K_I]), own.sum(axis=0)
            whole = moved.sum(axis=0)
            shares = moved / np.where(whole > 0, whole, 1.0)
            left[slice(*cycle)] = shares[..., None] * np.where(np.isfinite(drift), drift, 0.0)
    return left


def mean_of_ends(units: Array, steps: Array) -> Array:
    """(n, stations, d) what n steps add.

    The mean of what the factors at both ends give, or what those of the known end do.

    Args:
        units: (n + 1, stations, d, J) factors for a unit of each driver; NaN where unknown.
        steps: (n, J) increments of the drivers.
    """
    known = _known(units)
    ends = [np.einsum("tsdj,tj->tsd", each, steps) for each in (units[:-1], units[1:])]
    both, first, last = known[:-1] & known[1:], known[:-1], known[1:]
    found = np.where(first[:, None, None], ends[0], np.where(last[:, None, None], ends[1], np.nan))
    return np.where(both[:, None, None], (ends[0] + ends[1]) / 2, found)


def _known(units: Array) -> Bools:
    """(T,) states in which all units (T, stations, d, J) are known."""
    return np.asarray(np.isfinite(units).all(axis=(1, 2, 3)))


def next_known(known: Bools) -> Indices:
    """(T,) the next of T states that is known, each its own if it is; T where none follows."""
    states = np.where(known, np.arange(len(known)), len(known))
    return np.asarray(np.minimum.accumulate(states[::-1])[::-1])


def within_known(units: Array, step: Indices | None) -> Array:
    """Units of all states, those unknown within a step taken from the next known state in it.

    Where none follows, from the last one before, back to the end of the step before: as far as a
    contact that touches or opens is too small to tell its factors, a divided step counts like an
    undivided one, with the factors of the end that is known.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        step: (T,) number of the step in which each state lies; None if each is the end of one.
    """
    if step is None:
        return units
    count = len(units)
    states, known = np.arange(count), _known(units)
    inside = np.append(step[1:] == step[:-1], False)
    later = next_known(known)
    earlier = np.maximum.accumulate(np.where(known, states, -1))
    follows = (later < count) & (step[np.minimum(later, count - 1)] == step)
    begin = np.searchsorted(step, step) - 1
    precedes = (earlier >= 0) & (earlier >= begin)
    source = np.where(follows, later, np.where(precedes, earlier, states))
    return np.asarray(units[np.where(inside & ~known, source, states)])


def beside_known(units: Array, small: Bools) -> Array:
    """Units of all states, those unknown in a run of small ones those of the known state beside it.

    Of that behind it, else of that before.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        small: (T,) states that carry little; the contact is not open in them.
    """
    known, states = _known(units), np.arange(len(units))
    lost = small & ~known
    if not lost.any():
        return units
    behind = next_known(~lost)
    before = np.maximum.accumulate(np.where(lost, -1, states))
    # Where no known state is next to the run, it stays as it is.
    there = np.append(known, False)
    source = np.where(there[behind], behind, np.where(there[before], before, states))
    return np.asarray(units[np.where(lost, source, states)])


def one_sided_sums(units: Array, filled: Array, drivers: Array) -> Array:
    """(stations, T) half of what steps up to each state add to |K| of which one end only is known.

    Their increments take the factors of that end for those of both, and factors may change as much
    within a step as over it where the contact is about to open or hardly resolved.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        filled: the same, as of `within_known`.
        drivers: (T, J) values of the drivers.
    """
    known = _known(units)
    increments = mean_of_ends(filled, np.diff(drivers, axis=0))[:, :, Factor.K_T :]
    increments = np.linalg.norm(increments, axis=2)
    one_end = ~(known[1:] & known[:-1]) & np.isfinite(increments).all(axis=1)
    return _summed(np.where(one_end[:, None], increments, 0.0) / 2)


def uneven_sums(units: Array, drivers: Array, friction: Bools) -> Array:
    """(stations, T) what steps up to each state may be wrong by in |K| as an edge moves.

    Within a step what the loads add to K per part of it changes as the edge moves, and not evenly.
    The mean of both ends exceeds their harmonic mean by du^2/(2 (u1 + u2)); for loads on a line and
    any movement of the edge of a cylinder or a wedge the truth is below by no more than twice that
    (P up to 40 times as large at one end of the step: 1.5 and 1.9 times). Flats with rounded ends
    need more (P three times as large at one end: 2.3 times du^2/(2 (u1 + u2))). All drivers count
    together: the shapes that move the cuts of a part nearly cancel one another.

    Args:
        units: (T, stations, d, J) factors for a unit of each driver; NaN where unknown.
        drivers: (T, J) values of the drivers.
        friction: (T,) whether there is any in the step that ends at each state.
    """
    factors, steps = units[:, :, Factor.K_T :], np.diff(drivers, axis=0) * friction[1:, None]
    begin, end = (np.einsum("tsdj,tj->tsd", each, steps) for each in (factors[:-1], factors[1:]))
    size = np.linalg.norm(begin, axis=2) + np.linalg.norm(end, axis=2)
    change = np.linalg.norm(end - begin, axis=2)
    return _summed(1.5 * np.divide(change**2, size, where=size > 0, out=np.zeros_like(size)))


def _summed(errors: Array) -> Array:
    """(stations, T) sums of errors (T - 1, stations) of the steps up to each state."""
    return np.pad(np.cumsum(np.nan_to_num(errors), axis=0), ((1, 0), (0, 0))).T
