# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts of solids on the map of their contact area, with the station of the largest |ΔK|."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from fretfe._typing import Array
from fretfe.edges.solid_fronts import SolidFront, SolidStation
from fretfe.report.pictures.unroll import Unrolled
from fretfe.report.theme import HALO, PALE, VERMILLION
from fretfe.results.solution import ContactHistory

FRONT: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.1}
STATION: dict[str, Any] = {
    "linestyle": "none", "marker": "o", "markersize": 2.6, "color": VERMILLION,
}  # fmt: skip
END: dict[str, Any] = {**STATION, "markersize": 3.4, "markerfacecolor": PALE}
WORST: dict[str, Any] = {
    "linestyle": "none", "marker": "D", "markersize": 6.0, "color": VERMILLION,
    "markeredgecolor": "black",
}  # fmt: skip
# Distance of the number of the worst station from it, into the contact, in points.
ASIDE = 16.0


def front_handles(fronts: Sequence[SolidFront]) -> list[Line2D]:
    """Entries of the legend for what is drawn of the fronts."""
    entries = [("contact front, stations", {**STATION, **FRONT, "linestyle": "-"}, True)]
    entries.append(
        ("stations too near an end", END, any(len(f.judged) < len(f.stations) for f in fronts))
    )
    entries.append(("largest |ΔK| of a front", WORST, any(f.worst is not None for f in fronts)))
    return [Line2D([], [], label=label, **style) for label, style, drawn in entries if drawn]


def draw_fronts(
    panel: Axes,
    contact: ContactHistory,
    plane: Unrolled,
    fronts: Sequence[SolidFront],
    state: int,
) -> None:
    """Draw fronts where they are in a state; a gap where that is not known."""
    for front in fronts:
        places = plane.at(contact, _points(front, state))
        line = np.vstack([places, places[:1]]) if front.closed else places
        panel.plot(*line.T, path_effects=HALO, zorder=3, **FRONT)
        end = front.along("end").astype(bool)
        panel.plot(*places[~end].T, zorder=3.1, **STATION)
        panel.plot(*places[end].T, zorder=3.1, **END)
        worst = front.worst
        if worst is not None and np.isfinite(places[worst.number]).all():
            panel.plot(*places[worst.number], zorder=3.2, **WORST)
            _name(panel, contact, plane, worst, places[worst.number])


def _points(front: SolidFront, state: int) -> Array:
    """(n, 3) the stations in a state; NaN where they are not known."""
    place = np.array([station.position[state] for station in front.stations])
    points = np.array([station.point for station in front.stations])
    inward = np.array([station.frame.inward for station in front.stations])
    return np.asarray(points + place[:, None] * inward)


def _name(
    panel: Axes, contact: ContactHistory, plane: Unrolled, station: SolidStation, place: Array
) -> None:
    """Write the number of a station next to it, inside the contact."""
    ahead = station.point + 1e-3 * station.depth * station.frame.inward
    inward = np.diff(plane.at(contact, np.array([station.point, ahead])), axis=0)[0]
    x, y = (float(each) for each in ASIDE * inward / np.linalg.norm(inward))
    panel.annotate(
        str(station.number), (float(place[0]), float(place[1])), (x, y), textcoords="offset points",
        ha="center", va="center", path_effects=HALO, zorder=4, fontweight="bold",
    )  # fmt: skip


def fronts_reading(fronts: Sequence[SolidFront]) -> str:
    """How to read what is drawn of fronts; empty without any."""
    if not fronts:
        return ""
    marked = [f"{front.worst.number} of {front.name}" for front in fronts if front.worst]
    which = (
        "; diamond: the largest range |ΔK| of (K_T, K_S) on a front, not too near its end: station "
        f"{' and '.join(marked)} in stations.csv and in the table of fronts"
        if marked
        else ""
    )
    return f" Coloured: the smooth front with its stations{which}."
