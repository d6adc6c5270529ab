# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of a match: pressures of the choices, and tractions of solved tests."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.matching.choose import length_that_counts, pressure_of
from fretfe.matching.match import Comparison, Match
from fretfe.report.pictures.panels import save_png
from fretfe.report.theme import BLUE, GREEN, GREY, PALE, PICTURE_DPI, PURPLE, STYLE, VERMILLION

# Inches; lengths shown over the one that counts; points of a curve.
SIZE, PAIR = (6.4, 4.4), (6.4, 7.4)
SHOWN, POINTS = 3.0, 400
# Of tests; of more than three they begin again.
LOOKS = ((VERMILLION, "--"), (GREEN, "-."), (PURPLE, ":"))
NAMES = {"cylinder": "cylinder", "flat_rounded": "flat and rounded", "wedge": "wedge"}


@mpl.rc_context(STYLE)
def draw_choices(match: Match, path: Path) -> None:
    """Draw the pressure of the component's edge and of the best test with each shape."""
    figure = Figure(figsize=SIZE, dpi=PICTURE_DPI, layout="constrained")
    axes = figure.subplots()
    profile = match.target.profile
    assert profile is not None
    end = min(_shown(match), float(profile.s[-1]))
    s = np.linspace(end / POINTS, end, POINTS)
    inside = profile.s <= end
    axes.plot(profile.s[inside], profile.pressure[inside], color=BLUE, lw=2.2, label="component")
    axes.plot(s, match.target.k_n * np.sqrt(s), color=GREY, lw=0.8, label="K_N √s, common to all")
    found = [each for each in match.shapes if each.choices]
    for each, (colour, style) in zip(found, LOOKS, strict=False):
        test = each.choices[each.best].test
        within = s < 2 * test.half_width
        axes.plot(
            s[within], pressure_of(test, s[within]), style, color=colour, label=NAMES[each.shape]
        )
    axes.set_ylim(0.0, 1.35 * float(profile.pressure[inside].max()))
    _finish(axes, match, f"p [{match.rig.units.stress}]")
    axes.set_title(f"Edge {match.target.name}: pressure, tests by closed form", loc="left")
    axes.set_xlabel(f"distance from the edge [{match.rig.units.length}]")
    figure.legend(loc="outside lower center", ncols=3)
    save_png(figure, path)


@mpl.rc_context(STYLE)
def draw_agreement(match: Match, comparison: Comparison, path: Path) -> None:
    """Draw pressure and change of shear of the component and of solved tests."""
    figure = Figure(figsize=PAIR, dpi=PICTURE_DPI, layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    end = _shown(match)
    profile = match.target.profile
    assert profile is not None
    for axes, values in ((upper, profile.pressure), (lower, profile.shear_change)):
        _curve(axes, profile.s, values, end, color=BLUE, lw=2.2, label="component")
    for n, each in enumerate(comparison.agreements):
        colour, style = LOOKS[n % len(LOOKS)]
        other = each.test.profile
        assert other is not None
        name = Path(each.name).name
        for axes, values, reach in (
            (upper, other.pressure, each.pressure_reach[0]),
            (lower, other.shear_change, each.shear_reach[0]),
        ):
            label = f"{name}: 5 % up to {reach.length:.3g}"
            _curve(axes, other.s, values, end, color=colour, ls=style, label=label)
            if 0 < reach.length <= end:
                height = np.interp(reach.length, other.s, values)
                axes.plot(reach.length, height, "o", ms=5, color=colour)
    _finish(upper, match, f"p [{match.rig.units.stress}]")
    _finish(lower, match, f"change of q in the cycle [{match.rig.units.stress}]")
    upper.set_title(f"Edge {match.target.name} and tests, all computed", loc="left")
    lower.set_xlabel(f"distance from the edge [{match.rig.units.length}]")
    for axes in (upper, lower):
        axes.legend(loc="lower right" if axes is upper else "upper right")
    save_png(figure, path)


def _curve(axes: Axes, s: Array, values: Array, end: float, **look: object) -> None:
    inside = s <= end
    axes.plot(s[inside], values[inside], **look)  # type: ignore[arg-type]


def _shown(match: Match) -> float:
    return SHOWN * length_that_counts(match.target, match.rig)


def _finish(axes: Axes, match: Match, label: str) -> None:
    """Slip zone shaded, process zone as a line."""
    axes.axvspan(0.0, match.target.longest_slip, color=PALE, lw=0.0, zorder=0, label="slip zone")
    if match.rig.process_zone:
        axes.axvline(match.rig.process_zone, color=GREY, lw=0.9, ls=":", label="process zone")
    axes.set_xlim(0.0, _shown(match))
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(label)
