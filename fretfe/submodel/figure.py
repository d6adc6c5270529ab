# SPDX-License-Identifier: LGPL-3.0-or-later
"""Picture of a station of solids beside its plane problem."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe.case import Units
from fretfe.report.pictures.panels import save_png
from fretfe.report.theme import BLUE, GREEN, PICTURE_DPI, STYLE, VERMILLION
from fretfe.submodel.comparison import StationModel

SIZE = (10.4, 3.6)


@mpl.rc_context(STYLE)
def draw_station(units: Units, model: StationModel, path: Path) -> None:
    """Draw tractions next to the edge, histories of K, and slip zones, side by side."""
    figure = Figure(figsize=SIZE, dpi=PICTURE_DPI, layout="constrained")
    tractions, histories, zones = figure.subplots(1, 3, width_ratios=(1.5, 1, 1))
    figure.suptitle(f"Station {model.station} of {model.front}, contact {model.contact}")
    _tractions(tractions, model)
    tractions.set_xlabel(f"distance from the front [{units.length}]")
    tractions.set_ylabel(f"traction [{units.stress}]")
    histories.plot(model.times, model.k, "o", ms=3.5, color=BLUE, label="solid")
    histories.plot(model.times, model.plane_k, "-", color=VERMILLION, label="plane")
    histories.set_xlabel(f"time [{units.time}]")
    histories.set_ylabel(f"K − K at the end [{units.stress}·√{units.length}]")
    _zones(zones, model)
    zones.set_xlabel(f"end of the half cycle [{units.time}]")
    zones.set_ylabel(f"slip zone [{units.length}]")
    for axes in (tractions, histories, zones):
        axes.legend()
    save_png(figure, path)


def _tractions(axes: Axes, model: StationModel) -> None:
    solid, plane = model.solid_tractions, model.plane_tractions
    axes.plot(solid.s, solid.pressure, "o", ms=3, color=BLUE, label="p, solid")
    axes.plot(plane.s, plane.pressure, "-", color=BLUE, label="p, plane")
    axes.plot(solid.s, solid.shear, "s", ms=3, color=VERMILLION, label="q, solid")
    axes.plot(plane.s, plane.shear, "-", color=VERMILLION, label="q, plane")
    axes.set_title(f"t = {model.time:g}", loc="left")


def _zones(axes: Axes, model: StationModel) -> None:
    ends = np.array([zone.end for zone in model.zones])
    spread = np.array([zone.solid_spread for zone in model.zones])
    axes.errorbar(
        ends, [zone.solid for zone in model.zones], np.where(np.isfinite(spread), spread, 0.0),
        fmt="o", ms=4, color=BLUE, label="solid",
    )  # fmt: skip
    axes.plot(ends, [zone.plane for zone in model.zones], "x", color=VERMILLION, label="plane")
    axes.plot(ends, [zone.predicted for zone in model.zones], "_", color=GREEN, label="predicted")
    axes.set_ylim(bottom=0.0)
