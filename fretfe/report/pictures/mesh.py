# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of plane meshes, and of contacts that stick, slip and are open on them.

They need no fields and no OpenGL. The picture of a mesh has the bodies with all their elements, and
each contact enlarged. Names of boundaries stand in two columns left and right of the bodies, each
with a line to its place. Nothing overlaps because the columns are as wide as their longest name and
the names in them keep their distance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Bools, Indices
from fretfe.case import Case
from fretfe.evaluate.loaded import NO_LOAD
from fretfe.files import writing
from fretfe.history.solution import OPEN, SLIP, STICK, ContactHistory
from fretfe.mesh.elements import CORNERS, shape_values
from fretfe.mesh.mesh import BodyMesh
from fretfe.report.pictures.panels import (
    View,
    draw_cells,
    few_ticks,
    name_axes,
    panel_inches,
    panels,
    plural,
    set_limits,
    settle,
)
from fretfe.report.plotting import (
    Affine2D,
    Axes,
    Figure,
    Line2D,
    LineCollection,
    Patch,
    PolyCollection,
    mpl,
)
from fretfe.report.source import state_title, times_text
from fretfe.report.theme import (
    BLUE,
    BOUNDARY,
    ELEMENTS,
    FILE_DPI,
    FRAMED,
    GREY,
    HEADING,
    ORANGE,
    PALE,
    SURFACES,
    TINTS,
    save_figure,
)
from fretfe.results.model import Result

# Line widths of elements of meshes with fewer cells than this, and with more.
MANY_CELLS = 20_000
FEW_WIDTH = 0.2
MANY_WIDTH = 0.12
# Inches: the bodies without the names beside them, and the panel of a contact.
BODIES_HEIGHT = 6.4
BODIES_WIDTH = 4.8
PANEL_WIDTH = 3.6
PANEL_HEIGHT = 3.2
# Width of the bodies over their height, at least.
BODIES_ASPECT = 0.6
# Panels below each other before there is another column, and those that there is room for.
ROWS = 4
FEWEST_ROWS = 2
# Around the surfaces of a contact and around the bodies, as a fraction of their size.
SURROUNDINGS = 0.08
# Of names, in inches: distance from the next one, from the frame, from their place up or down if
# there is room; and room for the lines between a column and the bodies.
SPACING = 0.2
MARGIN = 0.12
OFFSET = 0.18
LEADERS = 0.45
# Straight pieces that a curved edge is drawn with.
CURVE_PIECES = 6
# Edges whose middle is off their chord by less than this fraction of it are drawn straight.
VISIBLE_BULGE = 1e-3
# Height of a panel over its width.
ASPECT = 0.36
# Around the part of the surfaces that is closed in any of the states, as a fraction of it.
BORDER = 0.06
BODIES = (PALE, "#F0F0F0")
# Width and darkness tell them apart in grey.
STATUS: dict[int, dict[str, Any]] = {
    OPEN: {"color": GREY, "linewidth": 0.9, "linestyle": (0, (1.0, 1.5))},
    STICK: {"color": BLUE, "linewidth": 2.2},
    SLIP: {"color": ORANGE, "linewidth": 6.5},
}
# Slip in a step, over the largest slip in the history, that is round-off.
ROUND_OFF = 1e-9
NAMES = {SLIP: "slip", STICK: "stick", OPEN: "open"}


def write_mesh_picture(path: Path, case: Case, bodies: Mapping[str, BodyMesh]) -> None:
    """Draw the bodies of a plane mesh, and the surroundings of each contact.

    Args:
        path: picture to write; its ending says which format.
        case: names the contacts and the unit of length.
        bodies: plane meshes, by body.

    Raises:
        OutputError: if it cannot be written.
    """
    figure = draw_mesh(case, bodies)
    with writing(path, "the picture"):
        save_figure(figure, path)


@mpl.rc_context(FRAMED)
def draw_mesh(case: Case, bodies: Mapping[str, BodyMesh]) -> Figure:
    """The figure of `write_mesh_picture`."""
    labels = boundary_labels(bodies)
    figure = Figure(dpi=FILE_DPI, layout="constrained")
    main, *panels = _layout(figure, len(case.contacts), labels, bodies)
    main.set_title(case.title or "Mesh", fontsize=HEADING)
    _add_legend(figure, bodies)
    for panel, (name, contact) in zip(panels, case.contacts.items(), strict=True):
        surfaces = (contact.surface1, contact.surface2)
        panel.set_title(f"{name}\n1: {surfaces[0]}\n2: {surfaces[1]}", linespacing=1.1)
        owners = [(body, s) for body in bodies.values() for s in surfaces if s in body.boundaries]
        _show(panel, *_box([curve for pair in owners for curve in boundary_curves(*pair)]))
    for axes in (main, *panels):
        few_ticks(axes)
        name_axes(axes, "x", "y", case.units.length)
    # What is drawn from here on changes neither places nor limits.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in (main, *panels):
        axes.set_aspect("equal", adjustable="datalim")
        axes.apply_aspect()
        axes.autoscale(False)
        # What is left is less than a pixel.
        axes.set_aspect("equal", adjustable="box")
        axes.apply_aspect()
        _draw(axes, case, bodies)
    _draw_labels(main, labels)
    return figure


def _layout(
    figure: Figure, contacts: int, labels: Sequence[Label], bodies: Mapping[str, BodyMesh]
) -> list[Axes]:
    """Axes that show the bodies, with room for their names, and empty ones for each contact."""
    columns = -(-contacts // ROWS)
    rows = max(-(-contacts // columns), FEWEST_ROWS)
    height = max(BODIES_HEIGHT, rows * PANEL_HEIGHT, (len(labels) / 2 + 3) * SPACING)
    width = max(BODIES_WIDTH, BODIES_ASPECT * height)
    left, right = (
        _longest(figure, column) + (MARGIN + LEADERS if column else MARGIN)
        for column in _columns(labels)
    )
    # About an inch for numbers and names of axes.
    size = (width + left + right + 1 + columns * (PANEL_WIDTH + 1), height + 1)
    figure.set_size_inches(*size)
    ratios = [width + left + right, *[PANEL_WIDTH] * columns]
    grid = figure.add_gridspec(rows, 1 + columns, width_ratios=ratios)
    places = [grid[number % rows, 1 + number // rows] for number in range(contacts)]
    main, *panels = [figure.add_subplot(place) for place in (grid[:, 0], *places)]
    low, high = _box([body.points for body in bodies.values()])
    per_inch = float(((high - low) / [width, height]).max())
    _show(main, low - per_inch * np.array([left, 0.0]), high + per_inch * np.array([right, 0.0]))
    return [main, *panels]


def _box(parts: Sequence[Array]) -> tuple[Array, Array]:
    """(2,) lowest and highest corner of a box around places (n, 2), and a little more."""
    points = np.concatenate(parts)
    low, high = points.min(axis=0), points.max(axis=0)
    border = SURROUNDINGS * (high - low).max()
    return low - border, high + border


def _show(axes: Axes, low: Array, high: Array) -> None:
    """Let axes show a box (2,), (2,) at least, at the same scale in x and y."""
    axes.update_datalim([low, high])
    axes.margins(0.0)


def _draw(axes: Axes, case: Case, bodies: Mapping[str, BodyMesh]) -> None:
    """All that is within the limits of the axes; these stay."""
    limits = np.array([axes.get_xlim(), axes.get_ylim()]).T
    for number, body in enumerate(bodies.values()):
        _draw_cells(axes, body, TINTS[number % len(TINTS)], limits)
    styles = {}
    for contact in case.contacts.values():
        styles[contact.surface1], styles[contact.surface2] = SURFACES
    for body in bodies.values():
        for name in body.boundaries:
            style = styles.get(name, BOUNDARY)
            # Wide lines first: narrow ones are seen upon them.
            order = 4 - style["linewidth"] / 4
            lines = LineCollection(boundary_curves(body, name), capstyle="butt", **plural(style))
            axes.add_collection(lines, autolim=False)
            lines.set_zorder(order)


def _draw_cells(axes: Axes, body: BodyMesh, tint: str, limits: Array) -> None:
    outlines, boxes = cell_outlines(body)
    shown = (boxes[:, 0] < limits[1]).all(axis=1) & (boxes[:, 1] > limits[0]).all(axis=1)
    width = FEW_WIDTH if np.count_nonzero(shown) < MANY_CELLS else MANY_WIDTH
    starts = np.cumsum([len(part) for part in outlines])[:-1]
    for part, seen in zip(outlines, np.split(shown, starts), strict=True):
        axes.add_collection(
            PolyCollection(
                part[seen], facecolors=tint, edgecolors=ELEMENTS["colors"], linewidths=width
            ),
            autolim=False,
        )


def _add_legend(figure: Figure, bodies: Mapping[str, BodyMesh]) -> None:
    handles: list[Any] = [
        Patch(
            facecolor=TINTS[number % len(TINTS)],
            edgecolor=ELEMENTS["colors"],
            label=f"{name}, {len(body.cells)} {body.cell}s of order {body.order}",
        )
        for number, (name, body) in enumerate(bodies.items())
    ]
    texts = ("surface 1 of a contact", "surface 2 of a contact", "other boundaries with a name")
    handles += [
        Line2D([], [], label=text, **style)
        for text, style in zip(texts, (*SURFACES, BOUNDARY), strict=True)
    ]
    figure.legend(handles=handles, loc="outside lower left", ncols=3)


@dataclass(frozen=True)
class Label:
    """The name of a boundary, and a place (2,) on it."""

    text: str
    place: Array


def boundary_labels(bodies: Mapping[str, BodyMesh]) -> list[Label]:
    """One label for each boundary of each body, at the facet nearest to the boundary's centre."""
    labels = []
    for body in bodies.values():
        for name, facets in body.boundaries.items():
            middles = body.points[facets[:, :2]].mean(axis=1)
            centre = (middles.min(axis=0) + middles.max(axis=0)) / 2
            nearest = np.linalg.norm(middles - centre, axis=1).argmin()
            labels.append(Label(name, body.points[facets[nearest, 0]]))
    return labels


def _columns(labels: Sequence[Label]) -> tuple[list[Label], list[Label]]:
    """The left and the right half of the labels, each from bottom to top."""
    ordered = sorted(labels, key=lambda label: (label.place[0], label.place[1]))
    half = (len(ordered) + 1) // 2
    left, right = (
        sorted(part, key=lambda label: (label.place[1], label.text))
        for part in (ordered[:half], ordered[half:])
    )
    return left, right


def _draw_labels(axes: Axes, labels: Sequence[Label]) -> None:
    """Write the labels into axes whose place and limits are set."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    width, height = panel_inches(axes)
    to_inches = axes.transData + axes.transAxes.inverted() + Affine2D().scale(width, height)
    from_inches = Affine2D().scale(1 / width, 1 / height) + axes.transAxes
    for column, align in zip(_columns(labels), ("right", "left"), strict=True):
        places = [to_inches.transform(label.place) for label in column]
        # Lines to horizontal boundaries must not lie upon them.
        wanted = [y + (OFFSET if y > height / 2 else -OFFSET) for _, y in places]
        heights = spread(np.array(wanted), SPACING, SPACING, height - SPACING)
        inside = MARGIN + _longest(figure, column)
        x, start = (inside, 1.0) if align == "right" else (width - inside, 0.0)
        line = {"arrowstyle": "-", "linewidth": 0.5, "relpos": (start, 0.5), "shrinkB": 0.0}
        for label, y in zip(column, heights, strict=True):
            axes.annotate(
                label.text, tuple(label.place), (x, y), textcoords=from_inches, arrowprops=line,
                ha=align, va="center", zorder=5,
            )  # fmt: skip
            axes.plot(*label.place, ".", color="black", markersize=3, zorder=5)


def spread(wanted: Array, spacing: float, low: float, high: float) -> Array:
    """Places (n,) near sorted wanted ones, at least `spacing` apart, from `low` to `high`.

    If there is no room for that, they go beyond `low`.
    """
    places = wanted.copy()
    for i in range(len(places)):
        places[i] = max(places[i], places[i - 1] + spacing if i else low)
    for i in reversed(range(len(places))):
        limit = places[i + 1] - spacing if i + 1 < len(places) else high
        places[i] = min(places[i], limit)
    return places


def _longest(figure: Figure, labels: Sequence[Label]) -> float:
    """Width of the longest of the texts in the current font, in inches."""
    probe = figure.text(0.0, 0.0, "\n".join(label.text for label in labels))
    width = probe.get_window_extent().width / figure.dpi
    probe.remove()
    return float(width)


def cell_outlines(body: BodyMesh) -> tuple[list[Array], Array]:
    """The outlines of all cells, and the boxes (m, 2, 2) with their lowest and highest corners.

    Returns:
        Arrays (cells, places, 2): one of the cells with straight edges and, if there are any, one
        of those with curved edges. The boxes are in the same order.
    """
    corners = CORNERS[body.cell]
    straight = body.points[body.cells[:, :corners]]
    parts = [straight]
    if body.order == 2:
        ends = np.roll(straight, -1, axis=1)
        middles = body.points[body.cells[:, corners : 2 * corners]]
        curved = _bulges(straight, ends, middles).any(axis=1)
        edges = [each[curved] for each in (straight, ends, middles)]
        outlines = _along(*edges)[..., :-1, :].reshape(-1, corners * CURVE_PIECES, 2)
        parts = [straight[~curved], *([outlines] if curved.any() else [])]
    boxes = [np.stack([part.min(axis=1), part.max(axis=1)], axis=1) for part in parts]
    return parts, np.concatenate(boxes)


def boundary_curves(body: BodyMesh, name: str) -> list[Array]:
    """The boundary of this name as curves (n, 2), one for each connected piece."""
    facets = body.boundaries[name]
    return [_curve(body.points, facets[chain]) for chain in _chains(facets)]


def _curve(points: Array, facets: Indices) -> Array:
    first, last = points[facets[:, 0]], points[facets[:, 1]]
    if facets.shape[1] == 2:
        return np.concatenate([first, last[-1:]])
    places = _along(first, last, points[facets[:, 2]])
    return np.concatenate([places[:, :-1].reshape(-1, 2), last[-1:]])


def _chains(facets: Indices) -> list[list[int]]:
    """The facets of each connected piece in the order in which they follow each other."""
    by_start = {int(start): number for number, start in enumerate(facets[:, 0])}
    starts = np.setdiff1d(facets[:, 0], facets[:, 1])
    chains = []
    while by_start:
        node = next((int(s) for s in starts if int(s) in by_start), next(iter(by_start)))
        chain = []
        while node in by_start:
            chain.append(by_start.pop(node))
            node = int(facets[chain[-1], 1])
        chains.append(chain)
    return chains


def _bulges(first: Array, last: Array, middle: Array) -> Bools:
    """True if edges are visibly curved."""
    bulge = np.linalg.norm(middle - (first + last) / 2, axis=-1)
    return bulge > VISIBLE_BULGE * np.linalg.norm(last - first, axis=-1)


def _along(first: Array, last: Array, middle: Array) -> Array:
    """(..., CURVE_PIECES + 1, 2) places along quadratic edges (..., 2)."""
    values = shape_values("line", 2, np.linspace(0.0, 1.0, CURVE_PIECES + 1)[:, None])
    return np.einsum("qk,k...d->...qd", values, np.stack([first, last, middle]))


@mpl.rc_context(FRAMED)
def draw_status(run: Result, contacts: Sequence[str], states: Sequence[int]) -> tuple[Figure, str]:
    """One row of panels for each contact, a column for each state, and the caption."""
    shown = [each for each in run.solution.contacts if each.name in contacts]
    columns = len(states)
    figure, axes = panels(columns * len(contacts), ASPECT, columns=columns)
    handles = [Line2D([], [], label=NAMES[kind], **STATUS[kind]) for kind in NAMES]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    for row, contact in enumerate(shown):
        view = contact_view(contact, states)
        for panel, state in zip(axes[row * columns :], states, strict=False):
            set_limits(panel, view)
            _draw_pale_bodies(panel, run.bodies.values(), view)
            _draw_contact(panel, contact, state, view)
            name_axes(panel, "along x", "along y", run.case.units.length)
            title = f"{contact.name}, {state_title(run, state)}"
            panel.set_title(f"{title}\n{shares_text(contact, state)}")
    settle(figure, axes, ASPECT, "Where the contacts stick and slip")
    return figure, (
        f"Status of the contacts in the steps that end at {times_text(run, states)}, drawn on "
        "the bodies before deformation: wide and light where they slip, narrow and dark where "
        "they stick, dotted where they are open. Each panel is turned into the frame of its "
        "contact, with body 2 below."
    )


def contact_view(contact: ContactHistory, states: Sequence[int]) -> View:
    """The part of a contact that is closed in any of the states, or all of it if none is."""
    closed = (contact.status[list(states)] != OPEN).any(axis=0)
    seen = closed if closed.any() else ~closed
    points = contact.surface.points[seen]
    middle = len(points) // 2
    normal = contact.surface.frames[seen][middle, 0, :2]
    upright = View(points[middle], np.ones(2), normal)
    local = upright.local(points)
    low, high = local.min(axis=0), local.max(axis=0)
    size = (high - low) * (1 + 2 * BORDER)
    half = max(size[0], size[1] / ASPECT, np.ptp(contact.surface.arc) * 1e-3) / 2
    shift = (low + high) / 2
    centre = points[middle] + shift @ np.stack([upright.tangent, normal])
    # The axis has the numbers of the arc, as the results have.
    arc = (contact.surface.arc[closed] if closed.any() else contact.surface.arc)[middle]
    origin = np.array([arc + shift[0], 0.0])
    return View(centre, np.array([half, ASPECT * half]), normal, origin)


def visible_status(contact: ContactHistory, state: int) -> npt.NDArray[np.int8]:
    """(N,) status at a state; nodes at the limit of friction that do not move count as sticking.

    Which of them count as slipping in the solution is a matter of round-off. Where the contact
    carries nothing all are open, even if the surfaces still touch.
    """
    status, near = contact.status[state].copy(), np.array([max(state - 1, 0), state])
    # Not all states need be kept: those that are have the one before them.
    force = contact.mean_traction[near][..., 0] @ contact.surface.weights
    if not force[1] > NO_LOAD * force.max():
        status[:] = OPEN
    before, after = contact.slip[max(state - 1, 0)], contact.slip[state]
    moved, largest = np.abs(after - before).max(axis=-1), np.abs([before, after]).max()
    status[(status == SLIP) & (moved <= ROUND_OFF * largest)] = STICK
    return status


def shares_text(contact: ContactHistory, state: int) -> str:
    """Shares of the closed contact that stick and slip."""
    status = visible_status(contact, state)
    lengths = {kind: contact.surface.weights[status == kind].sum() for kind in (STICK, SLIP)}
    total = sum(lengths.values())
    if total == 0:
        return "carries nothing"
    if not contact.friction.at(state, status != OPEN).any():
        return "in contact, without friction"
    return ", ".join(f"{NAMES[kind]} {length / total:.1%}" for kind, length in lengths.items())


def _draw_pale_bodies(panel: Axes, bodies: Iterable[BodyMesh], view: View) -> None:
    """Light grey, one a little darker than the other."""
    for number, body in enumerate(bodies):
        colour = BODIES[number % len(BODIES)]
        for part in cell_outlines(body)[0]:
            draw_cells(panel, view.local(part[view.overlaps(part)]), colour)


def _draw_contact(panel: Axes, contact: ContactHistory, state: int, view: View) -> None:
    """The contact line, in pieces around the nodes that have the same status."""
    points = view.local(contact.surface.points)
    middles = (points[1:] + points[:-1]) / 2
    starts = np.concatenate([points[:1], middles])
    ends = np.concatenate([middles, points[-1:]])
    status = visible_status(contact, state)
    # Narrow lines end upon wide ones.
    for order, (kind, style) in enumerate(sorted(STATUS.items(), key=lambda s: -s[0])):
        chosen = status == kind
        pieces = [
            np.concatenate([starts[run[:1]], points[run], ends[run[-1:]]])
            for run in np.split(np.arange(len(points)), np.flatnonzero(np.diff(chosen)) + 1)
            if chosen[run[0]]
        ]
        lines = LineCollection(pieces, capstyle="butt", zorder=2 + order, **plural(style))
        panel.add_collection(lines, autolim=False)
