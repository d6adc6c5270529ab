# SPDX-License-Identifier: LGPL-3.0-or-later
"""Maps of where a contact is open, sticks and slips; its range of slip under irregular loads."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fretfe._typing import Array, Bools
from fretfe.evaluate.contacts import SlipZone, Station
from fretfe.evaluate.slip import SMALLEST_SLIP
from fretfe.history.solution import OPEN, SLIP, STICK
from fretfe.history.state_array import blocks
from fretfe.report.figures.plot import Plot, envelope, make_plot, plain_axis
from fretfe.report.source import Shown, edge_title, inward
from fretfe.report.theme import BLUE, DOUBLE, PALE, SKY, VERMILLION

# By status, the direction of slip, and whether there is friction; from light to dark in grey too.
KINDS = {
    OPEN: ("open", "#FFFFFF"),
    STICK: ("sticks", PALE),
    SLIP: ("slips, q > 0", SKY),
    SLIP + 1: ("slips, q < 0", VERMILLION),
    SLIP + 2: ("in contact, no friction", "#333333"),
}
# The windows at the edges are this many slip zones wide, and not less than this fraction of the
# half-width.
ZONES, NARROWEST = 2.5, 0.02
# More load steps are not drawn, nor the ends of more slip zones.
MOST_ROWS, MOST_ZONES = 1500, 50
NOT_KEPT = "the states are not kept:\n[output] tractions"
INTRO = (
    "Each row is a load step. Body 1 slips over body 2 towards larger x where q > 0, towards "
    "smaller x where q < 0. Lines: the contact edges. Above: the whole contact and history, with "
    "the evaluated cycle between dashed lines. Below: the two edges in the evaluated cycle, or in "
    "the whole history if there is none; circles mark the inner ends of the slip zones found, "
    "crosses those predicted. A row in which the load reverses may show slip beyond the circle; it "
    "is too small to count."
)
ENVELOPE_INTRO = (
    " If loads are irregular, the lower panels show how far each point slips to and fro in the "
    "evaluated cycle, or in the whole history if there is none; grey: points that stick at all "
    "times. Circles and crosses belong to the worst counted cycle."
)


def draw_envelope(
    axes: Axes, shown: Shown, edge: Station, window: tuple[float, float], states: tuple[int, int]
) -> None:
    """Range of the slip next to an edge between two states, the stick zone shaded."""
    axes.set_xlim(*window)
    solution = shown.run.solution
    assert solution is not None
    if not solution.keeps(*states):
        axes.text(0.5, 0.5, NOT_KEPT, ha="center", va="center", transform=axes.transAxes)
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
        _mark_zone(axes, edge, zone, 0.0)
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


def slip_plot(shown: Shown) -> Plot:
    """Space-time map of a contact."""
    return make_plot(
        f"{shown.key}-slip", shown.title, "", DOUBLE, lambda figure: _draw(figure, shown)
    )


def _draw(figure: Figure, shown: Shown) -> None:
    panels = figure.subplot_mosaic([["whole", "whole"], ["left", "right"]])
    times, units = shown.run.loads.times, shown.run.case.units
    first, last = shown.run.loads.evaluated
    positions = np.concatenate([edge.position for edge in shown.summary.stations])
    low, high = _limits(shown, positions)
    _map(panels["whole"], shown, low, high, (0, len(times) - 1))
    panels["whole"].set_ylim(times[0], times[-1])
    if shown.run.loads.cycle is not None:
        for time in times[[first, last]]:
            panels["whole"].axhline(time, color="black", lw=0.8, ls="--")
    irregular = any(edge.cycles.irregular for edge in shown.summary.stations)
    for edge in shown.summary.stations:
        axes = panels[edge.front]
        window = edge_window(shown, edge, first, last)
        if irregular:
            draw_envelope(axes, shown, edge, window, (first, last))
        else:
            _map(axes, shown, *window, (first, last))
            zones = [zone for zone in edge.slip_zones if first < zone.end <= last]
            for zone in zones if len(zones) <= MOST_ZONES else ():
                _mark_zone(axes, edge, zone, times[zone.end])
            axes.set_ylim(times[first], times[last])
        axes.set_title(edge_title(edge))
        axes.tick_params(axis="x", labelrotation=30)
    for axes in panels.values():
        axes.set_xlabel(f"x [{units.length}]")
    panels["whole"].set_ylabel(f"time [{units.time}]")
    below = f"range of slip [{units.length}]" if irregular else f"time [{units.time}]"
    panels["left"].set_ylabel(below)
    handles = [
        Patch(facecolor=colour, edgecolor="black", lw=0.4, label=name)
        for kind, (name, colour) in KINDS.items()
        if kind <= SLIP + 1 or not shown.tractions.friction[1:].all()
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=3)


def _limits(shown: Shown, positions: Array) -> tuple[float, float]:
    """Limits of what was in contact at any time, and a little beyond."""
    arc, known = shown.tractions.arc, positions[np.isfinite(positions)]
    touched = np.zeros(len(arc), dtype=bool)
    solution = shown.run.solution
    assert solution is not None
    kept = np.arange(len(solution.times)) if solution.kept is None else solution.kept
    for part in blocks(len(kept), len(arc)):
        touched |= np.any(shown.tractions.status[kept[part]] != OPEN, axis=0)
    closed = arc[touched]
    places = np.concatenate([known, closed]) if len(closed) else arc
    margin = 0.04 * float(np.ptp(places))
    return max(places.min() - margin, arc[0]), min(places.max() + margin, arc[-1])


def edge_window(shown: Shown, edge: Station, first: int, last: int) -> tuple[float, float]:
    """Places that an edge and its slip zones reach in some states, and as much again."""
    places = edge.position[first : last + 1]
    half_width = np.nanmax(shown.summary.half_width, initial=0.0)
    zones = [zone for zone in edge.slip_zones[-2:] if zone.end > first]
    lengths = [length for z in zones for length in (z.length, z.prediction) if length > 0]
    depth = ZONES * max(lengths, default=0.0)
    if not np.isfinite(places).any() or any(zone.gross for zone in zones):
        return _limits(shown, np.concatenate([each.position for each in shown.summary.stations]))
    low, high = np.nanmin(places), np.nanmax(places)
    depth = min(max(depth, high - low, NARROWEST * half_width), 2 * half_width)
    below, above = (0.25 * depth, depth)[:: int(inward(edge))]
    return low - below, high + above


def _map(axes: Axes, shown: Shown, low: float, high: float, states: tuple[int, int]) -> None:
    """Colours of all nodes in the steps between two states, and the lines of the edges."""
    tractions, times = shown.tractions, shown.run.loads.times
    solution = shown.run.solution
    assert solution is not None
    axes.set_xlim(low, high)
    if not solution.keeps(states[0] + 1, states[1]):
        axes.text(0.5, 0.5, NOT_KEPT, ha="center", va="center", transform=axes.transAxes)
        return
    # Of a long history some steps, evenly spread: each row reaches from the one below.
    rows = np.unique(np.linspace(*states, min(states[1] - states[0], MOST_ROWS) + 1).astype(int))
    steps = rows[1:]
    kind = tractions.status[steps].astype(int)
    kind = np.where((kind == SLIP) & (tractions.traction[steps, :, 1] < 0), SLIP + 1, kind)
    frictionless = tractions.friction[steps, None] == 0
    kind = np.where(frictionless & (kind != OPEN), SLIP + 2, kind)
    arc = tractions.arc
    borders = np.concatenate([[arc[0]], (arc[1:] + arc[:-1]) / 2, [arc[-1]]])
    seen = np.flatnonzero((borders[1:] >= low) & (borders[:-1] <= high))
    nodes = slice(seen[0], seen[-1] + 1)
    axes.pcolormesh(
        borders[seen[0] : seen[-1] + 2],
        times[rows],
        kind[:, nodes],
        cmap=ListedColormap([colour for _, colour in KINDS.values()]),
        norm=BoundaryNorm(np.arange(len(KINDS) + 1) - 0.5, len(KINDS)),
        rasterized=True,
    )
    for edge in shown.summary.stations:
        seen = envelope(edge.position)
        axes.plot(edge.position[seen], times[seen], color="black", lw=0.7)


def _mark_zone(axes: Axes, edge: Station, zone: SlipZone, height: float) -> None:
    """The inner end of a slip zone as found and as predicted."""
    predicted = edge.position[zone.end] + inward(edge) * zone.prediction
    for place, mark in ((zone.border, "o"), (predicted, "x")):
        (point,) = axes.plot(place, height, mark, mfc="none", color="black", ms=6)
        # Whole at the first and last state too, beyond the frame.
        point.set(clip_on=False, in_layout=False)
