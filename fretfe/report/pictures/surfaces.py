# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of the contact surfaces of solids: pressure, shear, stick and slip, and the fronts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import Front, Station
from fretfe.history.solution import OPEN, SLIP, STICK, ContactHistory
from fretfe.report.pictures.mesh import NAMES, STATUS, shares_text, visible_status
from fretfe.report.pictures.panels import BAR_ASPECT, name_axes, panel_inches, panels, settle
from fretfe.report.pictures.unroll import Unrolled, unroll
from fretfe.report.plotting import (
    Axes,
    BoundaryNorm,
    Figure,
    Line2D,
    MaxNLocator,
    Patch,
    ScalarMappable,
    Triangulation,
    mpl,
)
from fretfe.report.source import state_title, times_text
from fretfe.report.texts import direction_text, number, rounded
from fretfe.report.theme import COLOURS, FRAMED, HALO, PALE, VERMILLION
from fretfe.results.field_files import in_space
from fretfe.results.model import Result

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
# Around the part of the surface that is closed in any of the states, as a fraction of it.
BORDER = 0.1
# Height of a panel over its width, at least: a slender contact is drawn wider than it is.
LOWEST = 0.3
LEGEND_COLUMNS = 3
# Colours of the pressure. Places of arrows along the longer side, and along the shorter one.
LEVELS = 12
ARROWS = (12, 8)
# Arrows of less shear than this fraction of the largest are left out; length of the longest in
# distances between arrows, and their width in inches.
SHORTEST = 0.03
LONGEST = 0.95
ARROW_WIDTH = 0.014
LINES: dict[str, dict[str, Any]] = {
    "edge of the contact": {"colors": "black", "linewidths": 1.0, "linestyles": "-"},
    "edge of stick": {"colors": "black", "linewidths": 1.2, "linestyles": "--"},
}
FILLS = {SLIP: STATUS[SLIP]["color"], STICK: STATUS[STICK]["color"], OPEN: PALE}


def front_handles(fronts: Sequence[Front]) -> list[Line2D]:
    """Entries of the legend for what is drawn of the fronts."""
    entries = [("contact front, stations", {**STATION, **FRONT, "linestyle": "-"}, True)]
    entries.append(
        ("stations too near an end", END, any(len(f.judged) < len(f.stations) for f in fronts))
    )
    entries.append(("largest |ΔK| of a front", WORST, any(f.worst is not None for f in fronts)))
    return [Line2D([], [], label=label, **style) for label, style, drawn in entries if drawn]


def draw_fronts(
    panel: Axes, contact: ContactHistory, plane: Unrolled, fronts: Sequence[Front], state: int
) -> None:
    """Draw fronts where they are in a state; a gap where that is not known."""
    for front in fronts:
        places = plane.at(contact, np.array([each.places[state] for each in front.stations]))
        line = np.vstack([places, places[:1]]) if front.closed else places
        panel.plot(*line.T, path_effects=HALO, zorder=3, **FRONT)
        end = front.along("end").astype(bool)
        panel.plot(*places[~end].T, zorder=3.1, **STATION)
        panel.plot(*places[end].T, zorder=3.1, **END)
        worst = front.worst
        if worst is not None and np.isfinite(places[worst.number]).all():
            panel.plot(*places[worst.number], zorder=3.2, **WORST)
            _name(panel, contact, plane, worst, places[worst.number])


def _name(
    panel: Axes, contact: ContactHistory, plane: Unrolled, station: Station, place: Array
) -> None:
    """Write the number of a station next to it, inside the contact."""
    inward = inward_in_plane(contact, plane, station)[1]
    x, y = (float(each) for each in ASIDE * inward)
    panel.annotate(
        str(station.number), (float(place[0]), float(place[1])), (x, y), textcoords="offset points",
        ha="center", va="center", path_effects=HALO, zorder=4, fontweight="bold",
    )  # fmt: skip


def inward_in_plane(
    contact: ContactHistory, plane: Unrolled, station: Station
) -> tuple[Array, Array]:
    """(2,) place of a station, and unit vector that leads from it into the contact."""
    ahead = station.point + 1e-3 * station.depth * station.frame.inward
    place, end = plane.at(contact, np.array([station.point, ahead]))
    return place, (end - place) / np.linalg.norm(end - place)


def fronts_reading(fronts: Sequence[Front], states: Sequence[int]) -> str:
    """Legend of the fronts in some states; empty without any."""
    if not fronts:
        return ""
    marked = [f"{front.worst.number} of {front.name}" for front in fronts if front.worst]
    which = (
        "; diamond: the largest range |ΔK| of (K_T, K_S) that is known on a front: station "
        f"{' and '.join(marked)} in stations.csv and in the table of fronts"
        if marked
        else ""
    )
    lost = [
        station
        for front in fronts
        for station in front.stations
        if not np.isfinite(station.position[list(states)]).all()
    ]
    why = next((each.lack.text for each in lost if each.lack.text), "the pressure ends elsewhere")
    breaks = f" The line breaks off where the front is not found ({why})." if lost else ""
    return f" Coloured: the smooth front with its stations{which}.{breaks}"


@dataclass(frozen=True)
class Sheet:
    """A contact surface in the plane of a picture, with what is common to its panels.

    Attributes:
        run: the run.
        contact: its arrays.
        plane: the surface in the plane.
        triangles: of the surface.
        low, high: (2,) corners of what is shown.
        pressure, shear: largest of all panels.
    """

    run: Result
    contact: ContactHistory
    plane: Unrolled
    triangles: Triangulation
    low: Array
    high: Array
    pressure: float
    shear: float

    @property
    def aspect(self) -> float:
        """Height of a panel over its width."""
        return max(self.true_aspect, LOWEST)

    @property
    def true_aspect(self) -> float:
        """Height over width of what is shown."""
        width, height = self.high - self.low
        return float(height / width)

    @property
    def levels(self) -> Array:
        """Limits of the colours, round numbers."""
        largest = self.pressure if self.pressure > 0 else 1.0
        places = MaxNLocator(LEVELS, steps=[1, 2, 2.5, 5, 10])
        return np.asarray(places.tick_values(0.0, largest))

    @property
    def norm(self) -> BoundaryNorm:
        """Number of the colour of a pressure."""
        return BoundaryNorm(self.levels, mpl.colormaps[COLOURS].N)

    def shear_at(self, state: int) -> Array:
        """(N, 2) shear along the axes of the plane."""
        vectors = in_space(self.contact, self.contact.mean_traction[state][:, 1:])
        return np.asarray(np.einsum("nad,nd->na", self.plane.axes, vectors))


def lay_out(run: Result, name: str, states: Sequence[int]) -> Sheet:
    """The contact `name` as it is shown in some states, the longer side of the contact across."""
    contact = run.contact_history(name)
    assert contact.surface.facets is not None
    closed = np.zeros(len(contact.surface.points), dtype=bool)
    pressure = shear = 0.0
    for state in states:
        closed |= contact.status[state] != OPEN
        traction = contact.mean_traction[state]
        pressure = max(pressure, float(traction[:, 0].max()))
        shear = max(shear, float(np.linalg.norm(traction[:, 1:], axis=1).max()))
    shown = closed if closed.any() else ~closed
    plane = unroll(contact)
    width, height = np.ptp(plane.places[shown], axis=0)
    if height > width:
        plane = plane.turned()
    if plane.names[1].startswith("−"):
        # Up is where the axis of the case grows.
        plane = plane.turned().turned()
    low, high = plane.places[shown].min(axis=0), plane.places[shown].max(axis=0)
    # A single row of nodes has no height.
    margin = BORDER * np.maximum(high - low, 0.05 * (high - low).max())
    facets = contact.surface.facets
    parts = facets if facets.shape[1] == 3 else np.vstack([facets[:, :3], facets[:, [0, 2, 3]]])
    triangles = Triangulation(plane.places[:, 0], plane.places[:, 1], parts)
    return Sheet(run, contact, plane, triangles, low - margin, high + margin, pressure, shear)


@mpl.rc_context(FRAMED)
def draw_surface(run: Result, name: str, states: Sequence[int]) -> tuple[Figure, str]:
    """Pressure above status, a column for each state, and the caption."""
    sheet = lay_out(run, name, states)
    columns = len(states)
    figure, axes = panels(2 * columns, sheet.aspect, columns=columns)
    for panel, state in zip(axes, states, strict=False):
        frame(panel, sheet)
        panel.set_title(frame_title(sheet, state))
    for panel, state in zip(axes[columns:], states, strict=True):
        frame(panel, sheet)
        panel.set_title(shares_text(sheet.contact, state))
    fronts = next(each.fronts for each in run.contacts if each.name == name)
    fills = [Patch(color=FILLS[kind], label=NAMES[kind]) for kind in NAMES]
    finish(figure, axes, sheet, [*fills, *front_handles(fronts)])
    for upper, lower, state in zip(axes, axes[columns:], states, strict=False):
        draw_pressure(upper, sheet, state)
        _draw_status(lower, sheet, state)
        for panel in (upper, lower):
            draw_fronts(panel, sheet.contact, sheet.plane, fronts, state)
    return (
        figure,
        f"Pressure and shear, and below stick and slip, at {times_text(run, states)}. "
        + reading(sheet)
        + fronts_reading(fronts, states),
    )


def frame_title(sheet: Sheet, state: int) -> str:
    """Time, loads and largest pressure of a state."""
    largest = float(sheet.contact.mean_traction[state][:, 0].max())
    pressure = f"largest pressure {rounded(largest)} {sheet.run.case.units.stress}"
    return f"{state_title(sheet.run, state)}\n{pressure}"


def frame(panel: Axes, sheet: Sheet) -> None:
    """Limits and names of the axes of a panel."""
    panel.set_xlim(sheet.low[0], sheet.high[0])
    panel.set_ylim(sheet.low[1], sheet.high[1])
    first, second = (f"towards {name}" for name in sheet.plane.names)
    name_axes(panel, first, second, sheet.run.case.units.length)


def finish(figure: Figure, axes: Sequence[Axes], sheet: Sheet, handles: list[Any]) -> None:
    """Colour bar, legend and heading; then everything has its place."""
    bar = figure.colorbar(ScalarMappable(sheet.norm, COLOURS), ax=axes, aspect=BAR_ASPECT, pad=0.02)
    bar.set_label(f"pressure [{sheet.run.case.units.stress}]", labelpad=6)
    lines = [
        Line2D([], [], color=style["colors"], lw=style["linewidths"], ls=style["linestyles"],
               label=label)
        for label, style in LINES.items()
    ]  # fmt: skip
    every = [*handles, *lines]
    columns = min(len(every), LEGEND_COLUMNS)
    figure.legend(handles=every, loc="outside lower center", ncols=columns, handlelength=2.2)
    contact = sheet.contact
    settle(
        figure, axes, sheet.aspect, f"Contact {contact.name} ({contact.body1} on {contact.body2})"
    )


def draw_pressure(panel: Axes, sheet: Sheet, state: int) -> None:
    """Pressure, edges of contact and stick, and shear at a state, in a panel that has its place."""
    levels = sheet.levels
    _fill(panel, sheet, np.ones(len(sheet.plane.places)), FILLS[OPEN])
    pressure = np.clip(sheet.contact.mean_traction[state][:, 0], 0.0, levels[-1])
    panel.tricontourf(sheet.triangles, pressure, levels=levels, norm=sheet.norm, cmap=COLOURS)
    # The interpolated pressure ends at the first open nodes, the contact half-way before them.
    _fill(panel, sheet, sheet.contact.status[state] == OPEN, FILLS[OPEN])
    _draw_edges(panel, sheet, state)
    _draw_arrows(panel, sheet, state)


def _draw_status(panel: Axes, sheet: Sheet, state: int) -> None:
    status = visible_status(sheet.contact, state)
    _fill(panel, sheet, np.ones(len(status)), FILLS[OPEN])
    _fill(panel, sheet, status != OPEN, FILLS[SLIP])
    _fill(panel, sheet, status == STICK, FILLS[STICK])
    _draw_edges(panel, sheet, state)


def _fill(panel: Axes, sheet: Sheet, nodes: Array, colour: str) -> None:
    """Fill the surface up to half-way behind the nodes that are set."""
    panel.tricontourf(sheet.triangles, nodes.astype(float), levels=[0.5, 1.5], colors=[colour])


def _draw_edges(panel: Axes, sheet: Sheet, state: int) -> None:
    """Edges of the contact and of its part that sticks, half-way between nodes."""
    status = visible_status(sheet.contact, state)
    for inside, style in zip((status != OPEN, status == STICK), LINES.values(), strict=True):
        if inside.any() and not inside.all():
            lines = panel.tricontour(sheet.triangles, inside.astype(float), levels=[0.5], **style)
            lines.set_path_effects(HALO)


def _draw_arrows(panel: Axes, sheet: Sheet, state: int) -> None:
    """The shear on body 2 at the nodes in contact that are nearest to places of a regular grid."""
    closed = np.flatnonzero(sheet.contact.status[state] != OPEN)
    if not len(closed) or sheet.shear <= 0:
        return
    # Imported where it is needed: pictures of plane contacts do without.
    from scipy.spatial import cKDTree

    size = sheet.high - sheet.low
    counts = np.array([ARROWS[0], round(float(np.clip(ARROWS[0] * sheet.aspect, 5, ARROWS[1])))])
    lines = [
        low + (np.arange(count) + 0.5) * extent / count
        for low, extent, count in zip(sheet.low, size, counts, strict=True)
    ]
    grid = np.stack([each.ravel() for each in np.meshgrid(*lines)], axis=1)
    # Distances in cells of the grid: as they are seen where the axes differ.
    cell = size / counts
    distance, nearest = cKDTree(sheet.plane.places / cell).query(grid / cell)
    nodes = np.intersect1d(nearest[distance < 1], closed)
    shear = sheet.shear_at(state)[nodes]
    long = np.linalg.norm(shear, axis=1) > SHORTEST * sheet.shear
    spacing = float((panel_inches(panel) / counts).min())
    panel.quiver(
        *sheet.plane.places[nodes[long]].T, *shear[long].T, angles="uv", scale_units="inches",
        scale=sheet.shear / (LONGEST * spacing), units="inches", width=ARROW_WIDTH, pivot="mid",
        headwidth=4.0, headlength=4.5, headaxislength=4.0, minshaft=1.2,
        facecolor="black", edgecolor="white", linewidth=0.5,
    )  # fmt: skip


def reading(sheet: Sheet) -> str:
    """Legend of the picture of a surface."""
    plane, units = sheet.plane, sheet.run.case.units
    right, up = (direction_text(direction) for direction in plane.directions)
    least = 1e-4 * float(np.ptp(sheet.contact.surface.points, axis=0).max())
    middle = ", ".join(number(float(v) if abs(v) > least else 0.0) for v in plane.middle)
    stretched = "" if sheet.true_aspect >= LOWEST else " The axes have different scales."
    arrows = (
        f" Arrows: shear that body 1 exerts on body 2, the longest {rounded(sheet.shear)} "
        f"{units.stress}."
        if sheet.shear > 0
        else ""
    )
    return (
        f"The surface is seen from outside body 2, {plane.how}; in its middle, at ({middle}) "
        f"{units.length}, {right} points to the right and {up} up.{stretched}{arrows} "
        "Solid line: border of the contact; dashed: "
        "border of its part that sticks."
    )
