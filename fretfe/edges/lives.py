# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories of a patch that exists in some of the states only: each of its lives by itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.edges.front import StationHistory
from fretfe.results.solution import ContactHistory

Cycle = tuple[int, int] | None
# From the states of a life, and the cycle as counted in it, to (states, ...) histories.
CountLife = Callable[[slice, Cycle], Array]


def by_life(contact: ContactHistory, cycle: Cycle, count: CountLife) -> Array:
    """Return (T, ...) histories that begin anew with each life; NaN where there is no patch.

    Args:
        contact: one patch, which has a life at least.
        cycle: first and last state of the evaluated cycle, or None.
        count: gives the histories of one life; it gets no cycle that is not all in it.
    """
    found = {}
    for first, last in contact.lives:
        inside = cycle is not None and first <= cycle[0] and cycle[1] <= last
        own = (cycle[0] - first, cycle[1] - first) if cycle is not None and inside else None
        found[first] = count(slice(first, last + 1), own)
    shapes = [each.shape[1:] for each in found.values()]
    histories = np.full((len(contact.traction), *shapes[0]), np.nan)
    for first, each in found.items():
        histories[first : first + len(each)] = each
    return histories


def in_evaluated_life(
    contact: ContactHistory, cycle: Cycle, history: StationHistory
) -> StationHistory:
    """Return a history without what is outside the life of the evaluated cycle.

    Without a cycle that is the last life; if no life holds all of the cycle nothing is left.
    """
    first, last = contact.lives[-1]
    states = np.arange(len(contact.traction))
    known = (states >= first) & (states <= last)
    if cycle is not None:
        known &= first <= cycle[0] < cycle[1] <= last
    return replace(
        history,
        position=_only(history.position, known),
        position_spread=_only(history.position_spread, known),
        k_n=_only(history.k_n, known),
        k_n_spread=_only(history.k_n_spread, known),
        k_t=_only(history.k_t, known),
        k_s=_only(history.k_s, known),
        k_i=_only(history.k_i, known),
    )


def _only(values: Array, known: Bools) -> Array:
    return np.where(known, values, np.nan)
