# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories of edges whose factors are given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import StationHistory
from fretfe.evaluate.slip import States, last_state

# Hold of an edge that stands still, over the largest change of its factors.
FAR = 1e3


def edge_history(
    k_t: Array,
    k_i: Array | None = None,
    front: str = "left",
    position: Array | None = None,
    hold: Array | None = None,
) -> StationHistory:
    """A history with K_N = 1 and exact places.

    Args:
        k_t: (T,) K_T.
        k_i: (T,) K_I; zero if not given.
        front: name of the front.
        position: (T,) of the edge, else where K_I moves it to.
        hold: (T,) with which the edge stands there; else far more than K_T and K_I vary by.
    """
    zero, one = np.zeros(len(k_t)), np.ones(len(k_t))
    k_i = zero if k_i is None else k_i
    most = float(np.nanmax(np.abs(k_t)) + np.nanmax(np.abs(k_i)))
    return StationHistory(
        front,
        0,
        (-2.0 * k_i if position is None else position),
        zero,
        one,
        zero,
        k_t=k_t,
        k_s=zero,
        k_i=k_i,
        hold=k_i + FAR * (most or 1.0) if hold is None else hold,
        shear=k_t,
        unit=one,
        slid=zero,
    )


def in_cycle(cycle: States, station: StationHistory) -> StationHistory:
    """The history of a station, with the first and last state that count in it."""
    first = int(cycle[0]) if len(cycle) else -1
    return replace(station, last=last_state(cycle, station), first=first)
