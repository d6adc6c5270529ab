# SPDX-License-Identifier: LGPL-3.0-or-later
"""The pictures that a run should have, and looks of bodies in them.

A look is what is seen, how much bodies deform, and where colours end.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeVar

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.verdicts import longest_verdict
from fretfe.history.solution import OPEN, ContactHistory
from fretfe.report.pictures.fields import BodyField, Fields
from fretfe.report.pictures.panels import SpaceView, View
from fretfe.report.source import edge_title, extremes
from fretfe.results.model import Result
from fretfe.verdict import Verdict

T = TypeVar("T")

# Panels in one picture.
MOST_EDGES = 6
MOST_CONTACTS = 4
STRESS = "Stress in the bodies at the load extremes"

Kind = Literal["bodies", "edges", "status", "surface"]
# Of the area that is shown, or of the volume around the contact of solids, per cent that stay below
# the last colour.
BODIES_PERCENTAGE = 99.8
EDGES_PERCENTAGE = 98.0
# Largest displacement that is drawn, and largest overlap of the bodies, as fractions of their size.
DRAWN_DISPLACEMENT = 0.04
DRAWN_OVERLAP = 0.003
# Around plane bodies and solids, as a fraction of their size; height of a panel of solids over its
# width.
BORDER = 0.03
SPACE_BORDER = 0.04
SPACE_ASPECT = 0.78
# Half the width of the view of an edge: in slip zones, and at most in half-widths of the contact.
SLIP_ZONES = 3.0
LARGEST_VIEW = 0.3
# And at least in elements.
FEWEST_ELEMENTS = 10.0
# Height of the view of an edge over its width.
EDGE_ASPECT = 0.8
# Towards the viewer along the three axes, the upright one last.
WHOLE = np.array([0.9, 0.5, 0.42])
# Tilt of the view onto a cut, as parts of its normal, to the top and to the side.
TILT = (0.3, 0.2)
# Half the width of the view onto a cut, in half-widths of the contact there.
AROUND = 2.2
# Areas of contacts that face opposite ways, over those of all, below which they are balanced.
BALANCED = 0.1
# Part of the largest area along an axis from which y is upright.
Y_UPRIGHT = 0.6
# Distance of a cut from the ends of the contact, in parts of its length across the cut.
FROM_ENDS = 0.1
# An axis this close to the normal of a cut cannot be upright.
UPRIGHT = 0.9
# Tetrahedra that a solid cell consists of, by its number of corners.
TETRAHEDRA = {
    4: ((0, 1, 2, 3),),
    8: ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)),
}


@dataclass(frozen=True)
class EdgePlace:
    """An edge of a contact at a state.

    Attributes:
        contact: name.
        title: of its panel.
        state: that is shown.
        position: along the arc.
        slip: length of its longest slip zone; 0 if there is none, NaN if that is not known.
        half_width: of the contact.
        gross: whether the whole contact slips in a half cycle.
        overlap: of the surfaces, by interferences of the contact.
    """

    contact: str
    title: str
    state: int
    position: float
    slip: float
    half_width: float
    gross: bool = False
    overlap: float = 0.0


@dataclass(frozen=True)
class Wanted:
    """A picture to make.

    Attributes:
        file: its name.
        title: what it shows.
        kind: of picture.
        states: that it shows.
        edges: that it shows, one panel each.
        contacts: that it shows, one row of panels each.
    """

    file: str
    title: str
    kind: Kind
    states: tuple[int, ...]
    edges: tuple[EdgePlace, ...] = ()
    contacts: tuple[str, ...] = ()


def plan_pictures(run: Result) -> list[Wanted]:
    """The pictures that a run should have."""
    return _plan_solids(run) if run.solid else _plan_plane(run)


def _plan_solids(run: Result) -> list[Wanted]:
    states = tuple(extremes(run))
    names = [contact.name for contact in run.contacts]
    surfaces = [
        Wanted(f"contact{mark}.png", f"Contact {name}", "surface", states, contacts=(name,))
        for mark, _, (name,) in _chunks(names, 1)
    ]
    return [Wanted("stress.png", STRESS, "bodies", states), *surfaces]


def _plan_plane(run: Result) -> list[Wanted]:
    states = tuple(extremes(run))
    bodies = Wanted("stress.png", STRESS, "bodies", states)
    # Its reason stands where edges are not found; there may be none to be found.
    nowhere = [("", "", ())] if any(each.edges for each in run.contacts) else []
    edges = [
        Wanted(f"edges{mark}.png", f"Stress at the contact edges{part}", "edges", states, chunk)
        for mark, part, chunk in _chunks(_edge_places(run), MOST_EDGES) or nowhere
    ]
    status = [
        Wanted(
            f"status{mark}.png", f"Stick and slip at the load extremes{part}", "status", states,
            contacts=chunk,
        )
        for mark, part, chunk in _chunks([each.name for each in run.contacts], MOST_CONTACTS)
    ]  # fmt: skip
    return [bodies, *edges, *status]


def _chunks(items: Sequence[T], most: int) -> list[tuple[str, str, tuple[T, ...]]]:
    """Parts of about equal size, with what to add to the name of a file and to a title."""
    count = -(-len(items) // most)
    limits = [round(number * len(items) / count) for number in range(count + 1)] if count else []
    parts = [tuple(items[low:high]) for low, high in itertools.pairwise(limits)]
    if count < 2:
        return [("", "", part) for part in parts]
    return [(f"_{number}", f" ({number} of {count})", part) for number, part in enumerate(parts, 1)]


def _edge_places(run: Result) -> list[EdgePlace]:
    """All edges that there are at the load extremes."""
    places = []
    for contact in run.contacts:
        for edge, state in itertools.product(contact.edges, extremes(run)):
            position, half_width = float(edge.position[state]), float(contact.half_width[state])
            if np.isfinite([position, half_width]).all():
                title, slip = f"{contact.name}, {edge_title(edge)}", _longest(edge)
                overlap = float(overlaps(run, [state], contact.pair).sum())
                places.append(
                    EdgePlace(
                        contact.name, title, state, position, slip, half_width, edge.slides, overlap
                    )
                )
    return places


def _longest(edge: Station) -> float:
    """Length of the longest slip zone; NaN if it may hide between nodes."""
    zone = edge.longest_zone
    if zone is None:
        return 0.0 if longest_verdict(edge).verdict is Verdict.NO_ZONE else math.nan
    return math.nan if zone.gross or zone.hides or zone.unknown else zone.length


def edges_left_out(run: Result) -> list[str]:
    """Titles of the edges of contacts that have not both their edges at a load extreme."""
    shown = {edge.title for edge in _edge_places(run)}
    titles = [f"{each.name}, {edge_title(edge)}" for each in run.contacts for edge in each.edges]
    return [title for title in titles if title not in shown]


@dataclass(frozen=True)
class Look:
    """Look of bodies, the same at several states.

    Attributes:
        scale: of the displacements.
        limit: stress of the last colour.
        largest: stress in any element.
        views: plane bodies; or solids as a whole, and cut open.
        contact: name of the contact where solids are cut.
    """

    scale: float
    limit: float
    largest: float
    views: tuple[View] | tuple[SpaceView, SpaceView]
    contact: str = ""


def find_look(source: Fields, states: Sequence[int]) -> Look:
    """The look that suits some states."""
    fields = [body for state in states for body in source.bodies(state).values()]
    contacts = source.run.solution.contacts
    overlap = float(np.abs(overlaps(source.run, states)).max(initial=0.0))
    scale = deformation_scale(fields, contacts, states, overlap)
    if source.dimension == 2:
        view = _surroundings([body.deformed(factor) for body in fields for factor in (0.0, scale)])
        limit, largest = colour_limit([(body, None) for body in fields], BODIES_PERCENTAGE)
        return Look(scale, limit, largest, (view,))
    points = np.concatenate([body.deformed(scale) for body in fields])
    whole = _whole(points, contacts)
    # Cut where the pressure is largest.
    pairs = [(contact, state) for contact in contacts for state in states]
    contact, state = max(pairs, key=lambda pair: float(pair[0].mean_traction[pair[1]][:, 0].max()))
    cut = _cut(points, contact, state, whole)
    limit, largest = _space_limit(fields, cut)
    return Look(scale, limit, largest, (whole, cut), contact.name)


def overlaps(run: Result, states: Sequence[int], contact: str = "") -> Array:
    """(T, n) overlaps by which n loads press surfaces apart in T states, of one contact or all."""
    columns = [
        number
        for number, name in enumerate(run.loads.channels)
        if (load := run.case.loads[name]).type == "interference"
        and contact in ("", getattr(load, "contact", ""))
    ]
    return np.asarray(run.loads.values[np.ix_(list(states), columns)])


def deformation_scale(
    fields: Sequence[BodyField],
    contacts: Sequence[ContactHistory],
    states: Sequence[int],
    interference: float = 0.0,
) -> float:
    """Round factor of the displacements that shows them and lets no bodies overlap visibly.

    Where a contact closes from the initial gap g0 to the gap g, displacements drawn s times leave
    the gap g0 − s (g0 − g). Its negative must be small.

    Args:
        fields: of all bodies at all states that are drawn.
        contacts: between them.
        states: that are drawn.
        interference: by which bodies move apart that touch before and after.
    """
    size = float(np.ptp(np.concatenate([body.grid.points for body in fields]), axis=0).max())
    largest = max(float(np.linalg.norm(body.displacement, axis=1).max()) for body in fields)
    scales = [DRAWN_DISPLACEMENT * size / largest] if largest > 0 else [1.0]
    if interference > 0:
        scales.append(DRAWN_OVERLAP * size / interference)
    for contact in contacts:
        for state in states:
            closing = contact.gap[0] - contact.gap[state]
            closes = closing > 0
            limits = (contact.gap[0] + DRAWN_OVERLAP * size)[closes] / closing[closes]
            scales += limits[limits > 0].tolist()
    return max(round_down(min(scales)), 1.0)


def round_down(value: float) -> float:
    """The next smaller one of the numbers 1, 2 and 5 times powers of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-12)) * power


def round_up(value: float) -> float:
    """The next larger number with two digits."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / power * (1 - 1e-12)) * power


def colour_limit(
    shown: Sequence[tuple[BodyField, View | None]], percentage: float
) -> tuple[float, float]:
    """Stress of the last colour, and the largest stress in what is shown.

    What counts is the area that has a stress, not the number of elements, of which most are at the
    contact edges, where stresses have no bounds. All views count alike, however large they are.

    Args:
        shown: bodies, and what is seen of them: elements that reach into the view, or all.
        percentage: of the area that stays below the last colour.
    """
    stresses, areas = [], []
    for body, view in shown:
        corners = body.deformed(1.0)[body.grid.corners]
        seen = np.ones(len(corners), bool) if view is None else view.overlaps(corners)
        stresses.append(body.von_mises[body.grid.cells[seen]].max(axis=1))
        scale = 1.0 if view is None else float(view.half_size.prod())
        areas.append(polygon_areas(corners[seen]) / scale)
    return _limit(np.concatenate(stresses), np.concatenate(areas), percentage)


def _limit(stress: Array, area: Array, percentage: float) -> tuple[float, float]:
    """As `colour_limit`, for the stresses (m,) and areas, or volumes, of elements."""
    if not len(stress) or stress.max() <= 0:
        return 1.0, 0.0
    order = np.argsort(stress)
    below = np.cumsum(area[order]) / area.sum()
    number = min(int(np.searchsorted(below, percentage / 100)), len(order) - 1)
    return round_up(float(stress[order][number])), float(stress.max())


def polygon_areas(corners: Array) -> Array:
    """(m,) areas of polygons (m, k, 2)."""
    following = np.roll(corners, -1, axis=1)
    doubled = corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0]
    return np.abs(doubled.sum(axis=1)) / 2


def _surroundings(points: Sequence[Array]) -> View:
    """The upright view that shows all points (n, 2)."""
    every = np.concatenate(points)
    low, high = every.min(axis=0), every.max(axis=0)
    border = BORDER * float((high - low).max())
    centre, half_size = (low + high) / 2, (high - low) / 2 + border
    return View(centre, half_size, np.array([0.0, 1.0]), centre)


def edge_view(
    contact: ContactHistory, edge: EdgePlace, bodies: Mapping[str, BodyField]
) -> tuple[View, dict[str, BodyField]]:
    """The surroundings of an edge at its displaced place, body 2 below, and the bodies there.

    Wide enough for its slip zone, or for a part of the contact where nothing slips; never so narrow
    that single elements are all that is seen. The two bodies are moved along x so that the places
    of the edge on both of them are in the middle: contact is between places that are opposite to
    each other before deformation (small sliding), and a body that slid as a whole would hide that.
    Of an interference surfaces keep their distance as drawn: body 1 is put where it touches.
    """
    number = int(np.abs(contact.surface.arc - edge.position).argmin())
    point = np.array(
        [np.interp(edge.position, contact.surface.arc, x) for x in contact.surface.points.T]
    )
    element = float(np.diff(contact.surface.arc[max(number - 1, 0) : number + 2]).max())
    most = LARGEST_VIEW * edge.half_width
    wanted = SLIP_ZONES * edge.slip if edge.slip > 0 else most
    half = max(min(wanted, most), FEWEST_ELEMENTS * element)
    normal = contact.surface.frames[number, 0, :2]
    lower = bodies[contact.body2]
    height = (lower.deformed(1.0)[nearest_node(point, lower)] - point) @ normal
    view = View(point + height * normal, np.array([half, EDGE_ASPECT * half]), normal)
    moved = dict(bodies)
    for name in (contact.body1, contact.body2):
        body = bodies[name]
        along = body.displacement[nearest_node(point, body)] @ view.tangent
        shift = along * view.tangent + (edge.overlap * normal if name == contact.body1 else 0.0)
        moved[name] = replace(body, displacement=body.displacement - shift)
    return view, moved


def nearest_node(point: Array, body: BodyField) -> int:
    """The node next to a place (2,) before deformation."""
    return int(np.linalg.norm(body.grid.points - point, axis=1).argmin())


def _whole(points: Array, contacts: Sequence[ContactHistory]) -> SpaceView:
    """All bodies, y upright unless the contacts press together along another axis.

    Flanks to either side of a blade press it up. Contacts that press against one another alone, as
    on both sides of a plate, are taken one by one. A single flank stands as it does with the other
    one.
    """
    normals = np.array([each.surface.weights @ each.surface.frames[:, 0] for each in contacts])
    together = np.abs(normals.sum(axis=0))
    alone = np.abs(normals).sum(axis=0)
    pressed = together if together.max() > BALANCED * alone.max() else alone
    top = 1 if pressed[1] > Y_UPRIGHT * pressed.max() else int(np.argmax(pressed))
    viewer = np.zeros(3)
    viewer[[(top + 1) % 3, (top + 2) % 3, top]] = WHOLE
    view = _towards(np.zeros(3), viewer, np.eye(3)[top])
    seen = points @ view.across.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    centre = ((low + high) / 2) @ view.across + (points.mean(axis=0) @ view.viewer) * view.viewer
    half = (high - low) / 2 * (1 + 2 * SPACE_BORDER)
    width = max(half[0], half[1] / SPACE_ASPECT)
    return replace(view, centre=centre, half_size=np.array([width, SPACE_ASPECT * width]))


def _towards(centre: Array, viewer: Array, upright: Array) -> SpaceView:
    viewer = viewer / np.linalg.norm(viewer)
    up = upright - (upright @ viewer) * viewer
    return SpaceView(centre, viewer, up / np.linalg.norm(up), np.ones(2))


def _cut(points: Array, contact: ContactHistory, state: int, whole: SpaceView) -> SpaceView:
    """The surroundings of the largest pressure, cut along the tangent with the larger shear."""
    tractions = contact.mean_traction[state]
    place = int(tractions[:, 0].argmax())
    shears = contact.surface.weights @ np.abs(tractions[:, 1:])
    centre, (_, *tangents) = contact.surface.points[place], contact.surface.frames[place]
    along, normal = tangents if shears[0] >= shears[1] else tangents[::-1]
    normal = normal if normal @ whole.viewer >= 0 else -normal
    # The axis that is upright as a whole, or the normal of the contact.
    upright = np.eye(3)[int(np.abs(whole.up).argmax())]
    if abs(upright @ normal) > UPRIGHT:
        upright = contact.surface.frames[place, 0]
    upright = upright - (upright @ normal) * normal
    upright /= np.linalg.norm(upright)
    # A cut in the end face of a body would show none of it.
    across = (contact.surface.points - centre) @ normal
    margin = FROM_ENDS * float(np.ptp(across))
    centre = centre + np.clip(0.0, across.min() + margin, across.max() - margin) * normal
    side = np.cross(upright, normal)
    side = side if side @ whole.viewer >= 0 else -side
    view = _towards(centre, normal + TILT[0] * upright + TILT[1] * side, upright)
    closed = contact.status[state] != OPEN
    spread = (contact.surface.points[closed if closed.any() else ~closed] - centre) @ along
    largest = float(np.ptp(points, axis=0).max()) / 2
    half = min(AROUND * max(float(np.abs(spread).max()), 1e-3 * largest), largest)
    return replace(view, half_size=np.array([half, SPACE_ASPECT * half]), cut=normal)


def _space_limit(fields: Sequence[BodyField], cut: SpaceView) -> tuple[float, float]:
    """Stress of the last colour, from what is next to the contact, and the largest stress."""
    stresses, volumes = [], []
    largest = 0.0
    for body in fields:
        cells = body.grid.cells
        corners = body.grid.points[body.grid.corners]
        near = np.linalg.norm(corners.mean(axis=1) - cut.centre, axis=1) < cut.half_size[0]
        values = body.von_mises[cells].max(axis=1)
        largest = max(largest, float(values.max()))
        stresses.append(values[near])
        volumes.append(cell_volumes(corners[near]))
    limit, _ = _limit(np.concatenate(stresses), np.concatenate(volumes), BODIES_PERCENTAGE)
    return limit, largest


def cell_volumes(corners: Array) -> Array:
    """(m,) volumes of solid cells with corners (m, 4 or 8, 3)."""
    parts = corners[:, np.array(TETRAHEDRA[corners.shape[1]])]
    edges = parts[:, :, 1:] - parts[:, :, :1]
    return np.asarray(np.abs(np.linalg.det(edges)).sum(axis=1) / 6)
