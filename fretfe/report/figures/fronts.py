# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors and slip zones along the fronts of solids."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.edges.area import AreaSummary
from fretfe.edges.solid_fronts import Closure, SolidFront
from fretfe.report.figures.plot import Plot, legend_above, make_plot, plain_axis
from fretfe.report.texts import number
from fretfe.report.theme import BLUE, GREEN, GREY, ORANGE, TRIPLE, VERMILLION
from fretfe.results.model import Result

INTRO = (
    "Stations along the boundary of the contact area, over their distance along it. K_N is that of "
    "the last state; ΔK_T, ΔK_S and their vector sum |ΔK| are ranges over the evaluated cycle. "
    "Error bars are meant to contain the true value with a probability of 95 %. d is the width of "
    "the slip zone, inward, in the last half cycle, as found and as predicted by K_N and |ΔK|. "
    "Grey: stations too near a free end."
)


def front_plot(run: Result, area: AreaSummary, front: SolidFront, key: str) -> Plot:
    """K_N, the ranges of K_T and K_S, and slip zones along one front, below each other."""
    units = run.case.units
    has_zones = any(station.slip_zones for station in front.stations)
    has_ranges = bool(np.isfinite(front.along("k_range")).any())

    def draw(figure: Figure) -> None:
        count = 1 + has_ranges + has_zones
        panels = list(np.atleast_1d(figure.subplots(count, 1, sharex=True)))
        arc = front.along("arc")
        k_n = np.array([station.told_k_n for station in front.stations])
        spread = np.array([station.k_n_spread[-1] for station in front.stations])
        _bars(panels[0], arc, k_n, spread, "K_N", BLUE)
        panels[0].set_ylabel(f"K_N [{units.stress}/√{units.length}]")
        panels[0].set_ylim(bottom=0.0)
        if has_ranges:
            _ranges(panels[1], front)
            panels[1].set_ylabel(f"ΔK [{units.stress}·√{units.length}]")
        if has_zones:
            _zones(panels[-1], front)
            panels[-1].set_ylabel(f"d [{units.length}]")
        for axes in panels:
            _shade_ends(axes, front)
            plain_axis(axes, "y")
        panels[-1].set_xlabel(f"distance along {front.name} [{units.length}]")
        figure.align_ylabels()

    title = f"{front.name.capitalize()} of contact {area.name}"
    return make_plot(f"{key}-front", title, _closure(front.closure), TRIPLE, draw)


def _closure(found: Closure) -> str:
    """The factors against those of half-spaces, in words; empty if there is nothing to tell."""
    ratios = {
        "K_T and K_S due to Q": found.shear,
        "K_S due to torsion": found.twist,
        "K_I due to P": found.normal,
        "K_N from dP/da": found.pressure,
    }
    told = [f"{name} {ratio:.3f}" for name, ratio in ratios.items() if np.isfinite(ratio)]
    if not told:
        return ""
    axes = " and ".join(number(float(each)) for each in found.half_axes)
    return (
        f"Factors over those of half-spaces with an elliptical contact, half-axes {axes}, under "
        f"the same forces, on average along the front: {', '.join(told)}. For bodies of finite "
        "size the ratios differ from 1 by some per cent."
    )


def _ranges(axes: Axes, front: SolidFront) -> None:
    arc = front.along("arc")
    told = np.array([station.told_range for station in front.stations])
    _bars(axes, arc, told, front.along("k_range_spread"), "|ΔK|", VERMILLION)
    axes.plot(arc, front.along("k_t_range"), "--", color=GREEN, lw=1.1, label="ΔK_T")
    axes.plot(arc, front.along("k_s_range"), ":", color=ORANGE, lw=1.3, label="ΔK_S")
    axes.set_ylim(bottom=0.0)
    legend_above(axes, columns=3)


def _zones(axes: Axes, front: SolidFront) -> None:
    arc = front.along("arc")
    zones = [station.slip_zones[-1] if station.slip_zones else None for station in front.stations]
    found = np.array([zone.told_length if zone else np.nan for zone in zones])
    spread = np.array([zone.spread if zone else np.nan for zone in zones])
    predicted = np.array([zone.prediction if zone else np.nan for zone in zones])
    _bars(axes, arc, found, spread, "found", BLUE)
    axes.plot(arc, predicted, "--", color=VERMILLION, lw=1.1, label="predicted")
    axes.set_ylim(bottom=0.0)
    legend_above(axes, columns=2)


def _bars(axes: Axes, arc: Array, values: Array, spread: Array, label: str, colour: str) -> None:
    shown = np.where(np.isfinite(spread), spread, 0.0)
    axes.errorbar(
        arc, values, shown, fmt="o-", ms=2.5, lw=1.0, elinewidth=0.7, color=colour, label=label
    )


def _shade_ends(axes: Axes, front: SolidFront) -> None:
    """Grey behind the stations that are too near an end."""
    ends = [station for station in front.stations if station.end]
    half = front.length / len(front.stations) / 2
    for station in ends:
        axes.axvspan(station.arc - half, station.arc + half, color=GREY, alpha=0.2, lw=0)
