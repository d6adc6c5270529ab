# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts of solids: forces, areas and friction work over time, factors along their fronts."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.evaluate.contacts import Contact, Front, HalfSpaceRatios
from fretfe.report.figures.history import time_panels
from fretfe.report.figures.plot import Plot, envelope, legend_above, make_plot, plain_axis
from fretfe.report.source import force_unit, work_unit
from fretfe.report.texts import number
from fretfe.report.theme import BLUE, DOUBLE, GREEN, GREY, ORANGE, TRIPLE, VERMILLION
from fretfe.results.model import Result

AREAS_INTRO = (
    "P is the integral of the pressure, Q that of the shear that body 1 exerts on body 2, in the "
    "axes of the case. Each node counts with its whole area, so the areas grow in steps of an "
    "element. The largest pressure is a mean around a node; friction work is that of the step to "
    "each state. Shaded: the evaluated cycle."
)
# Of lines that are told apart.
STYLES = ((BLUE, "-", "o"), (VERMILLION, "--", "s"), (GREEN, ":", "^"))
FRONTS_INTRO = (
    "Stations along the boundary of the contact area, over their distance along it. K_N is that of "
    "the last state; ΔK_T, ΔK_S and their vector sum |ΔK| are ranges over the evaluated cycle. "
    "Error bars are meant to contain the true value with a probability of 95 %. d is the width of "
    "the slip zone, inward, in the last half cycle, as found and as predicted by K_N and |ΔK|. "
    "Grey: stations too near a free end."
)


def force_plot(run: Result, area: Contact, key: str) -> Plot:
    """P above the components of Q."""

    def draw(figure: Figure) -> None:
        normal, shear = time_panels(figure, 2, run.case, run.loads)
        _lines(normal, run, {"P": area.normal_force})
        _lines(shear, run, dict(zip(("Q_x", "Q_y", "Q_z"), area.shear_force.T, strict=True)))
        normal.set_ylabel(f"P [{force_unit(run)}]")
        shear.set_ylabel(f"Q [{force_unit(run)}]")
        legend_above(shear, columns=3)

    return make_plot(f"{key}-forces", f"Forces, contact {area.name}", "", DOUBLE, draw)


def area_plot(run: Result, area: Contact, key: str) -> Plot:
    """Areas, largest pressure and friction work, below each other."""
    units = run.case.units

    def draw(figure: Figure) -> None:
        areas, pressure, work = time_panels(figure, 3, run.case, run.loads)
        _lines(areas, run, {"in contact": area.contact_area, "sticks": area.stick_area})
        _lines(pressure, run, {"p_max": area.largest_pressure})
        _lines(work, run, {"work": area.work})
        areas.set_ylabel(f"area [{units.length}²]")
        pressure.set_ylabel(f"p_max [{units.stress}]")
        work.set_ylabel(f"work [{work_unit(run)}]")
        legend_above(areas, columns=2)
        figure.align_ylabels()

    return make_plot(
        f"{key}-areas", f"Areas, pressure and work, contact {area.name}", "", DOUBLE, draw
    )


def _lines(axes: Axes, run: Result, lines: Mapping[str, Array]) -> None:
    """Lines over time, by their labels."""
    for (label, values), (colour, line, mark) in zip(lines.items(), STYLES, strict=False):
        shown = envelope(values)
        marked = mark if len(shown) == len(values) else ""
        axes.plot(
            run.loads.times[shown], values[shown], ls=line, marker=marked, ms=2.5, lw=1.1,
            color=colour, label=label,
        )  # fmt: skip
    if any(np.min(values) < 0 for values in lines.values()):
        axes.axhline(0, color=GREY, lw=0.6)


def front_plot(run: Result, area: Contact, front: Front, key: str) -> Plot:
    """K_N, the ranges of K_T and K_S, and slip zones along one front, below each other."""
    units = run.case.units
    has_zones = any(station.slip_zones for station in front.stations)
    has_ranges = bool(np.isfinite(front.along("k_range")).any())

    def draw(figure: Figure) -> None:
        count = 1 + has_ranges + has_zones
        panels = list(np.atleast_1d(figure.subplots(count, 1, sharex=True)))
        arc = front.along("arc")
        k_n = np.array([station.reported_k_n for station in front.stations])
        spread = np.array([station.last_k_n[1] for station in front.stations])
        _bars(panels[0], arc, k_n, spread, "K_N", BLUE)
        panels[0].set_ylabel(f"K_N [{units.stress}/√{units.length}]")
        panels[0].set_ylim(bottom=0.0)
        if has_ranges:
            _ranges(panels[1], front)
            panels[1].set_ylabel(f"ΔK [{units.stress}·√{units.length}]")
        if has_zones:
            _zones(panels[-1], front)
            panels[-1].set_ylabel(f"d [{units.length}]")
        half = front.length / len(front.stations) / 2
        for axes in panels:
            for station in front.stations:
                if station.end:
                    low, high = station.arc - half, station.arc + half
                    axes.axvspan(low, high, color=GREY, alpha=0.2, lw=0)
            plain_axis(axes, "y")
        panels[-1].set_xlabel(f"distance along {front.name} [{units.length}]")
        figure.align_ylabels()

    title = f"{front.name.capitalize()} of contact {area.name}"
    return make_plot(f"{key}-front", title, _half_spaces(front.half_space_ratios), TRIPLE, draw)


def _half_spaces(found: HalfSpaceRatios) -> str:
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


def _ranges(axes: Axes, front: Front) -> None:
    arc = front.along("arc")
    told = np.array([station.reported_range for station in front.stations])
    _bars(axes, arc, told, front.along("k_range_spread"), "|ΔK|", VERMILLION)
    axes.plot(arc, front.along("k_t_range"), "--", color=GREEN, lw=1.1, label="ΔK_T")
    axes.plot(arc, front.along("k_s_range"), ":", color=ORANGE, lw=1.3, label="ΔK_S")
    axes.set_ylim(bottom=0.0)
    legend_above(axes, columns=3)


def _zones(axes: Axes, front: Front) -> None:
    arc = front.along("arc")
    zones = [station.slip_zones[-1] if station.slip_zones else None for station in front.stations]
    found = np.array([zone.reported_length if zone else np.nan for zone in zones])
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
