# SPDX-License-Identifier: LGPL-3.0-or-later
"""States in which a contact is loaded: its own cycle, the one that decides, those it slides in.

A mission that begins or ends without load, or lifts the bodies off in between, has no edge in some
of its states. Each plane contact is then evaluated over the run of states in which it has edges,
with what lies outside in the error bar of the range.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import SMALL_LOAD
from fretfe.evaluate.factors import WANTED_NODES
from fretfe.evaluate.numerics import EQUAL_LOADS, most_loaded
from fretfe.evaluate.slip import SMALLEST_SLIP, slip_in_steps
from fretfe.history.solution import OPEN, SLIP, STICK, ContactHistory, Solution
from fretfe.history.state_array import blocks

# First and last state of runs of states.
Runs = list[tuple[int, int]]
# Part of the largest P up to which the last state of a history does not count as loaded.
UNLOADED = 0.03
# Part of the largest P up to which states too small for factors leave the others known.
LITTLE = 0.3
# Part of the largest P below which a contact carries nothing but round-off.
NO_LOAD = 1e-6
# Power of P with which K_T of a cylinder grows where P and Q do so together; of flats it is 1.
GROWTH = 0.75


def normal_force(contact: ContactHistory, states: slice = slice(None)) -> Array:
    """(T,) P of a contact, or in some states, by the means of the pressure around its nodes."""
    return _resultant(contact, 0, states)


def _resultant(contact: ContactHistory, component: int, states: slice = slice(None)) -> Array:
    """(T,) a component of the force of a contact."""
    first, last, _ = states.indices(len(contact.mean_traction))
    parts = blocks(last - first, contact.mean_traction[0].size)
    own = (slice(first + each.start, first + each.stop) for each in parts)
    weights = contact.surface.weights
    return np.concatenate([contact.mean_traction[each, :, component] @ weights for each in own])


def loaded(force: Array) -> Bools:
    """(T,) states in which a contact carries more of P (T,) than round-off."""
    return np.asarray(force > NO_LOAD * force.max(initial=0.0))


def hardly_loaded(contact: ContactHistory, force: Array) -> Bools:
    """(T,) states in which a contact carries little of P (T,), and in the plane has few nodes."""
    nodes, plane = contact.pressed_nodes, contact.surface.facets is None
    few = (nodes > 0) & ((nodes < WANTED_NODES) | (not plane))
    return np.asarray(few & (force <= LITTLE * force.max()))


def decisive_state(force: Array, along: Array, cycle: Indices, ends: Indices) -> int:
    """The state at which K_N, position and width of an edge are reported.

    Of the two ends of steps at which K_T is largest and smallest in the cycle, or in all without
    one, that with the larger P; the largest P where K_T is not known or does not vary, or where
    both ends carry less than half of it: K_T begins anew where bodies that were apart touch.

    Args:
        force: (T,) P.
        along: (T,) K_T, or the factor along the direction in which it varies.
        cycle: states of the evaluated cycle, empty without one.
        ends: states at the ends of steps.
    """
    inside = ends[np.isin(ends, cycle)] if len(cycle) else ends
    inside = inside if len(inside) else cycle
    known = inside[np.isfinite(along[inside])]
    if not len(known) or not np.ptp(along[known]) > 0:
        return most_loaded(force, inside)
    values = along[known] - along[known].min()
    turns = [
        known[np.flatnonzero(each >= (1 - EQUAL_LOADS) * each.max())[-1]]
        for each in (values, values.max() - values)
    ]
    turn = most_loaded(force, np.sort(turns))
    heaviest = most_loaded(force, inside)
    return turn if 2 * force[turn] >= force[heaviest] else heaviest


def moving_state(solution: Solution) -> int:
    """The state around which loads are changed to see how edges of plane contacts move.

    It is the last end of a step in the evaluated cycle, or in all, at which the contacts carry at
    least half of the largest load there.
    """
    first, last = solution.cycle or (0, len(solution.times) - 1)
    force = np.sum([normal_force(each) for each in solution.contacts], axis=0)
    inside = solution.ends[(solution.ends >= first) & (solution.ends <= last)]
    return int(inside[2 * force[inside] >= force[inside].max()][-1])


def pressed_state(solution: Solution, contact: ContactHistory) -> int:
    """The last state of the cycle, or of all; the one of the largest P if that carries little."""
    first, last = solution.cycle or (0, len(solution.times) - 1)
    force = normal_force(contact)
    heaviest = most_loaded(force, np.arange(first, last + 1))
    return last if force[last] > UNLOADED * force[heaviest] else heaviest


def with_own_cycle(solution: Solution, contact: ContactHistory) -> Solution:
    """The solution with the part of its cycle in which a plane contact has edges as its cycle.

    Of several runs of such states, between which the contact opens, it is that in which the shear
    force swings most, of those that reach half of the largest P. One of several patches must begin
    and end it with little of that: what it is before it merges, or after it parts, may have any
    range.
    """
    if solution.cycle is None:
        return solution
    first, last = solution.cycle
    force = normal_force(contact)
    if not (inside := _with_edges(contact, force, first, last)).any():
        return solution
    ends = np.flatnonzero(np.diff(inside, prepend=False, append=False)).reshape(-1, 2)
    runs = [(first + int(begin), first + int(end) - 1) for begin, end in ends]
    shear, pressed = _resultant(contact, 1), [force[begin : end + 1].max() for begin, end in runs]
    heavy = [run for run, each in zip(runs, pressed, strict=True) if 2 * each >= max(pressed)]
    least = EQUAL_LOADS * max(pressed)  # of a shear force that is not round-off
    widest = _largest(heavy, [max(np.ptp(shear[begin : end + 1]), least) for begin, end in heavy])
    own = _largest(widest, [force[begin : end + 1].max() for begin, end in widest])[-1]
    beside = [mine for mine, whole in zip(own, (first, last), strict=True) if mine != whole]
    cut = contact.node_range is not None and force[beside].max(initial=0.0) > (
        SMALL_LOAD * force[first : last + 1].max()
    )
    return solution if cut or own[0] == own[1] else replace(solution, cycle=own)


def _largest(runs: Runs, values: Sequence[float]) -> Runs:
    """Those of some runs of states at which a value is largest."""
    least = (1 - EQUAL_LOADS) * max(values)
    return [run for run, value in zip(runs, values, strict=True) if value >= least]


def slides_as_a_whole(contact: ContactHistory) -> Bools:
    """(T,) states that are reached by slip of all that is in contact."""
    slides = contact.friction.acts.copy()
    for part in blocks(len(slides), len(contact.surface.weights)):
        status = np.asarray(contact.status[part])
        slides[part] &= (status == SLIP).any(axis=1) & (status != STICK).all(axis=1)
    return slides


def evaluated_states(solution: Solution, contact: ContactHistory) -> Indices:
    """States of the evaluated cycle, without one the one that decides."""
    if solution.cycle is not None:
        return np.arange(solution.cycle[0], solution.cycle[1] + 1)
    return np.array([most_loaded(normal_force(contact), solution.ends)])


def _with_edges(contact: ContactHistory, force: Array, first: int, last: int) -> Bools:
    """(n,) states of a cycle in which a contact has edges; none if P is too small for that."""
    share = force[first : last + 1] / max(float(force.max()), np.finfo(float).tiny)
    few = contact.nodes_pressed_in(np.arange(first, last + 1)) < WANTED_NODES
    edges = (share > NO_LOAD) & ~(few & (share <= SMALL_LOAD * share.max()))
    return edges & bool(share.max() > NO_LOAD)


def left_out(cycle: tuple[int, int] | None, states: Indices, force: Array) -> float:
    """Range of K_T that may lie in the states of a cycle left out, over that in the others.

    Args:
        cycle: first and last state of all of it.
        states: of its part over which the range is taken.
        force: (T,) P.
    """
    if cycle is None or not len(states):
        return 0.0
    ends = [mine for mine, whole in zip(states[[0, -1]], cycle, strict=True) if mine != whole]
    share = force[ends].max(initial=0.0) / force[states].max()
    part = float(max(share, 0.0) ** GROWTH)
    return part / max(1.0 - part, 0.1)


def whole_sliding(solution: Solution, contact: ContactHistory) -> tuple[float, float]:
    """Share of the time of the cycle, or of all, in which a contact slips as a whole, and how far.

    How far is the range of the mean slip of its nodes that adds up in those steps. The last few
    nodes of a contact that opens slip by nothing but the size of the elements: where P is a small
    part of its largest, slip counts that other displacements of the surfaces do not dwarf.
    """
    first, last = solution.cycle or (0, len(solution.times) - 1)
    moves, whole, largest = [], [], 0.0
    for part in blocks(last - first, contact.traction[0].size):
        begin, end = first + part.start, first + part.stop
        slip = slip_in_steps(contact, begin, end, solution.least_slip)
        closed = np.asarray(contact.status[begin + 1 : end + 1]) != OPEN
        size = np.linalg.norm(slip, axis=2)
        rough = contact.friction.acts[begin + 1 : end + 1]
        whole.append(rough & closed.any(axis=1) & ((size > 0) | ~closed).all(axis=1))
        shares = closed * contact.surface.weights
        shares = shares / np.maximum(shares.sum(axis=1), np.finfo(float).tiny)[:, None]
        moves.append(np.einsum("tn,tnc->tc", shares, slip))
        largest = max(largest, float(size.max(initial=0.0)))
    slides = np.concatenate(whole) if whole else np.zeros(0, dtype=bool)
    if not slides.any():
        return 0.0, 0.0
    steps, times = np.concatenate(moves), np.diff(solution.times[first : last + 1])
    force = normal_force(contact, slice(first + 1, last + 1))
    least = SMALLEST_SLIP * max(largest, _opening(contact, first, last))
    small = (force <= SMALL_LOAD * force.max()) & (np.linalg.norm(steps, axis=1) < least)
    slides = slides & ~small
    path = np.cumsum(steps * slides[:, None], axis=0)
    reach = float(np.linalg.norm(np.ptp(np.vstack([0.0 * path[:1], path]), axis=0)))
    return float(times[slides].sum() / times.sum()), reach


def _opening(contact: ContactHistory, first: int, last: int) -> float:
    """Largest gap of a node that touches in some states, in those in which any node does."""
    touches: Bools = np.zeros(len(contact.surface.weights), dtype=bool)
    widest: Array = np.zeros(len(touches))
    for part in blocks(last + 1 - first, contact.traction[0].size):
        states = slice(first + part.start, first + part.stop)
        closed = np.asarray(contact.status[states]) != OPEN
        touches |= closed.any(axis=0)
        gap = contact.gap[states][closed.any(axis=1)]
        widest = np.maximum(widest, gap.max(axis=0, initial=0.0))
    return float(widest[touches].max(initial=0.0))
