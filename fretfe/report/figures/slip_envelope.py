# SPDX-License-Identifier: LGPL-3.0-or-later
"""Range of the slip next to an edge under irregular loads, and the zone that always sticks."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from fretfe._typing import Array, Bools
from fretfe.edges.front import Station
from fretfe.edges.slip_zones import SMALLEST_SLIP
from fretfe.report.figures.plot import plain_axis
from fretfe.report.source import Shown, inward
from fretfe.report.theme import BLUE, PALE
from fretfe.results.solution import OPEN
from fretfe.results.states import blocks


def draw_envelope(
    axes: Axes, shown: Shown, edge: Station, window: tuple[float, float], states: tuple[int, int]
) -> None:
    """Range of the slip next to an edge between two states, the stick zone shaded."""
    axes.set_xlim(*window)
    solution = shown.run.solution
    assert solution is not None
    if not solution.keeps(*states):
        text = "the states are not kept:\n[output] tractions"
        axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes)
        return
    arc = shown.tractions.arc
    slip, closed = _slip_range(shown, states)
    touched = slip > 0
    stuck = closed & (slip <= SMALLEST_SLIP * slip.max(initial=0.0))
    seen = (arc >= window[0]) & (arc <= window[1])
    axes.plot(arc[seen & touched], slip[seen & touched], ".-", ms=4, lw=1.2, color=BLUE)
    top = 1.08 * float(slip[seen].max(initial=0.0)) or 1.0
    axes.fill_between(arc, 0.0, top, where=stuck.tolist(), color=PALE, step="mid", lw=0)
    places = edge.position[states[0] : states[1] + 1]
    for end in {np.nanmin(places), np.nanmax(places)} if np.isfinite(places).any() else ():
        axes.axvline(end, color="black", lw=0.7)
    for zone in edge.slip_zones:
        predicted = edge.position[zone.end] + inward(edge) * zone.prediction
        for place, mark in ((zone.border, "o"), (predicted, "x")):
            (point,) = axes.plot(place, 0.0, mark, mfc="none", color="black", ms=6)
            point.set(clip_on=False, in_layout=False)
    axes.set_ylim(0.0, top)
    plain_axis(axes, "y")


def _slip_range(shown: Shown, states: tuple[int, int]) -> tuple[Array, Bools]:
    """(N,) range of the slip of each node that is in contact at some time, and of those always."""
    tractions, (first, last) = shown.tractions, states
    count = len(tractions.arc)
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    always = np.ones(count, dtype=bool)
    for part in blocks(last - first, count):
        rows = slice(first + 1 + part.start, first + 1 + part.stop)
        closed, slip = tractions.status[rows] != OPEN, tractions.slip[rows, :, 0]
        always &= closed.all(axis=0)
        low = np.minimum(low, np.where(closed, slip, np.inf).min(axis=0))
        high = np.maximum(high, np.where(closed, slip, -np.inf).max(axis=0))
    return np.where(high >= low, high - low, 0.0), always
