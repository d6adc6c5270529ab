# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of the stress in solids: as a whole, and cut open at a contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.history.solution import OPEN, ContactHistory
from fretfe.report.pictures.fields import BodyField, Fields, surface
from fretfe.report.pictures.fields import Scene as PlaneScene
from fretfe.report.pictures.panels import (
    Pixels,
    panel_pixels,
    panels,
    set_limits,
    settle,
    show_image,
)
from fretfe.report.pictures.panels import View as PlaneView
from fretfe.report.pictures.stress import BODIES_PERCENTAGE, add_bar, deformation_scale, limit_of
from fretfe.report.source import loading, when
from fretfe.report.texts import direction_text, number, rounded
from fretfe.report.theme import COLOURS, FRAMED, HALO, PICTURE_WIDTH
from fretfe.results.field_files import CELL_TYPES

# Height of a panel over its width, and room around the bodies as a fraction of them.
ASPECT, BORDER = 0.78, 0.04
# Towards the viewer along the three axes, the upright one last.
WHOLE = np.array([0.9, 0.5, 0.42])
# Tilt of the view onto a cut, as parts of its normal, to the top and to the side.
TILT = (0.3, 0.2)
# Half the width of the view onto a cut, in half-widths of the contact there.
AROUND = 2.2
# An axis this close to the normal of a cut cannot be upright.
UPRIGHT = 0.9
# Angle in degrees between faces that meet in an edge which is drawn.
CREASE = 30.0
LINE: dict[str, Any] = {"color": "#949494", "line_width": 1.6, "lighting": False}
# Parts of a colour that do and do not depend on the light.
LIGHT: dict[str, Any] = {"ambient": 0.55, "diffuse": 0.45, "specular": 0.0}
ARROW: dict[str, Any] = {"arrowstyle": "->", "lw": 1.0, "path_effects": HALO}
# Tetrahedra that a solid cell consists of, by its number of corners; corners by number of nodes.
TETRAHEDRA = {
    4: ((0, 1, 2, 3),),
    8: ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)),
}
CORNERS = {4: 4, 8: 8, 10: 4, 27: 8}


@dataclass(frozen=True)
class View:
    """A view of solids.

    Attributes:
        centre: (3,) what is in the middle.
        viewer: (3,) unit vector towards the viewer.
        up: (3,) unit vector that points up in the picture, across `viewer`.
        half_size: (2,) half the width and height of what is seen.
        cut: (3,) unit normal of the plane through `centre` that cuts off what lies before it, or
            None.
    """

    centre: Array
    viewer: Array
    up: Array
    half_size: Array
    cut: Array | None = None

    @property
    def across(self) -> Array:
        """(2, 3) unit vectors to the right and up."""
        return np.stack([np.cross(self.up, self.viewer), self.up])


@dataclass(frozen=True)
class Look:
    """Look of solids, the same at several states.

    Attributes:
        scale: of the displacements.
        limit: stress of the last colour.
        largest: stress in any element.
        views: the bodies as a whole, and cut open.
        contact: name of the contact where they are cut.
    """

    scale: float
    limit: float
    largest: float
    views: tuple[View, View]
    contact: str


def find_look(source: Fields, states: Sequence[int]) -> Look:
    """The look that suits some states."""
    solution = source.run.solution
    assert solution is not None
    fields = [body for state in states for body in source.bodies(state).values()]
    scale = deformation_scale(fields, solution.contacts, states)
    points = np.concatenate([body.deformed(scale) for body in fields])
    whole = _whole(points, solution.contacts)
    contact, state = _loaded_most(solution.contacts, states)
    cut = _cut(points, contact, state, whole)
    limit, largest = _colour_limit(fields, cut)
    return Look(scale, limit, largest, (whole, cut), contact.name)


def _whole(points: Array, contacts: Sequence[ContactHistory]) -> View:
    """All bodies, the axis next to the normals of the contacts upright."""
    normal = sum(np.abs(each.weights @ each.frames[:, 0]) for each in contacts)
    top = int(np.argmax(normal))
    viewer = np.zeros(3)
    viewer[[(top + 1) % 3, (top + 2) % 3, top]] = WHOLE
    view = _towards(np.zeros(3), viewer, np.eye(3)[top])
    seen = points @ view.across.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    centre = ((low + high) / 2) @ view.across + (points.mean(axis=0) @ view.viewer) * view.viewer
    half = (high - low) / 2 * (1 + 2 * BORDER)
    return View(centre, view.viewer, view.up, _in_panel(half))


def _in_panel(half: Array) -> Array:
    """Half the size of the panel that shows (2,)."""
    width = max(half[0], half[1] / ASPECT)
    return np.array([width, ASPECT * width])


def _towards(centre: Array, viewer: Array, upright: Array) -> View:
    viewer = viewer / np.linalg.norm(viewer)
    up = upright - (upright @ viewer) * viewer
    return View(centre, viewer, up / np.linalg.norm(up), np.ones(2))


def _loaded_most(
    contacts: Sequence[ContactHistory], states: Sequence[int]
) -> tuple[ContactHistory, int]:
    """The contact and the state, of some, with the largest pressure."""
    pairs = [(contact, state) for contact in contacts for state in states]
    return max(pairs, key=lambda pair: float(pair[0].mean_traction[pair[1]][:, 0].max()))


def _cut(points: Array, contact: ContactHistory, state: int, whole: View) -> View:
    """The surroundings of the largest pressure, cut across the first tangent of the contact."""
    place = int(contact.mean_traction[state][:, 0].argmax())
    centre, (_, normal, along) = contact.points[place], contact.frames[place]
    normal = normal if normal @ whole.viewer >= 0 else -normal
    # The axis that is upright as a whole, or the normal of the contact.
    upright = np.eye(3)[int(np.abs(whole.up).argmax())]
    if abs(upright @ normal) > UPRIGHT:
        upright = contact.frames[place, 0]
    upright = upright - (upright @ normal) * normal
    upright /= np.linalg.norm(upright)
    side = np.cross(upright, normal)
    side = side if side @ whole.viewer >= 0 else -side
    view = _towards(centre, normal + TILT[0] * upright + TILT[1] * side, upright)
    closed = contact.status[state] != OPEN
    spread = (contact.points[closed if closed.any() else ~closed] - centre) @ along
    largest = float(np.ptp(points, axis=0).max()) / 2
    half = min(AROUND * max(float(np.abs(spread).max()), 1e-3 * largest), largest)
    return View(centre, view.viewer, view.up, np.array([half, ASPECT * half]), normal)


def _colour_limit(fields: Sequence[BodyField], cut: View) -> tuple[float, float]:
    """Stress of the last colour, from what is next to the contact, and the largest stress."""
    stresses, volumes = [], []
    largest = 0.0
    for body in fields:
        cells = body.grid.cells
        corners = body.grid.points[cells[:, : CORNERS[cells.shape[1]]]]
        near = np.linalg.norm(corners.mean(axis=1) - cut.centre, axis=1) < cut.half_size[0]
        values = body.von_mises[cells].max(axis=1)
        largest = max(largest, float(values.max()))
        stresses.append(values[near])
        volumes.append(cell_volumes(corners[near]))
    limit, _ = limit_of(np.concatenate(stresses), np.concatenate(volumes), BODIES_PERCENTAGE)
    return limit, largest


def cell_volumes(corners: Array) -> Array:
    """(m,) volumes of solid cells with corners (m, 4 or 8, 3)."""
    parts = corners[:, np.array(TETRAHEDRA[corners.shape[1]])]
    edges = parts[:, :, 1:] - parts[:, :, :1]
    return np.asarray(np.abs(np.linalg.det(edges)).sum(axis=1) / 6)


class Scene(PlaneScene):
    """Draws solids again and again, with the same colours."""

    def view(
        self, bodies: Sequence[BodyField], scale: float, view: View, pixels: tuple[int, int]
    ) -> Pixels:
        """Solids in their deformed shape; arguments and result as of `Scene.image`."""
        self._plotter.clear_actors()
        for body in bodies:
            skin = surface(body, scale)
            if view.cut is not None:
                self._colour(section(body, scale, view), lighting=False)
                skin = skin.clip(normal=view.cut, origin=view.centre)
            self._colour(skin, lighting=True, **LIGHT)
        camera = self._plotter.camera
        distance = 10 * float(np.abs(view.half_size).max()) + self._plotter.length
        camera.focal_point = tuple(view.centre)
        camera.position = tuple(view.centre + distance * view.viewer)
        camera.up = tuple(view.up)
        camera.parallel_scale = float(view.half_size[1])
        return self._shot(pixels)

    def _colour(self, mesh: Any, **light: Any) -> None:
        """Add a mesh in the colours of its stress, with its edges."""
        if not mesh.n_cells:
            return
        self._plotter.add_mesh(
            mesh, scalars="stress", cmap=COLOURS, clim=(0.0, self._limit),
            interpolate_before_map=True, show_scalar_bar=False, render=False, **light,
        )  # fmt: skip
        edges = mesh.clean(tolerance=0.0).extract_feature_edges(
            feature_angle=CREASE, manifold_edges=False, non_manifold_edges=False
        )
        if edges.n_cells:
            actor = self._plotter.add_mesh(edges, render=False, **LINE)
            # Lines lie on the faces that they bound.
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()


def section(body: BodyField, scale: float, view: View) -> Any:
    """Cut through a solid in a view, with the point data `stress`; a `pyvista.PolyData`."""
    from pyvista import UnstructuredGrid

    assert view.cut is not None
    cells = body.grid.cells
    places = body.deformed(scale)
    heights = ((places - view.centre) @ view.cut)[cells]
    met = cells[(heights.min(axis=1) <= 0) & (heights.max(axis=1) >= 0)]
    nodes = met.ravel()
    numbers = np.arange(len(nodes)).reshape(met.shape)
    mesh: Any = UnstructuredGrid({CELL_TYPES[3, cells.shape[1]]: numbers}, places[nodes])
    mesh.point_data["stress"] = body.von_mises[nodes]
    return mesh.slice(normal=view.cut, origin=view.centre)


@mpl.rc_context(FRAMED)
def draw_bodies(
    source: Fields,
    states: Sequence[int],
    look: Look,
    scene: Scene,
    width: float = PICTURE_WIDTH,
) -> Figure:
    """Solids as a whole above solids cut open, one column for each state."""
    run, count = source.run, len(states)
    figure, axes = panels(2 * count, ASPECT, columns=count, width=width)
    unit = run.case.units.length
    for place, panel in enumerate(axes):
        view = look.views[place // count]
        set_limits(panel, PlaneView(np.zeros(2), view.half_size, np.array([0.0, 1.0])))
        panel.set_xticks([])
        panel.set_yticks([])
        shown = f"panel {rounded(2 * float(view.half_size[0]))} {unit} wide"
        state = states[place % count]
        texts = [when(run, state), loading(run, state)] if view.cut is None else []
        panel.set_title("\n".join(filter(None, [": ".join(filter(None, texts)), shown])))
    add_bar(figure, axes, look.limit, run.case.units.stress)
    settle(figure, axes, ASPECT, f"Von Mises stress, displacements × {look.scale:g}")
    for place, panel in enumerate(axes):
        view = look.views[place // count]
        bodies = list(source.bodies(states[place % count]).values())
        show_image(panel, scene.view(bodies, look.scale, view, panel_pixels(panel)))
        _draw_axes(panel, view)
    return figure


def _draw_axes(panel: Axes, view: View) -> None:
    """The axes of the case as arrows in a corner of a panel."""
    pixels = 0.07 * panel.get_window_extent().width
    origin = np.array([0.1, 0.1 / ASPECT])
    scale = pixels / np.array(panel.get_window_extent().size)
    for name, axis in zip("xyz", np.eye(3), strict=True):
        seen = view.across @ axis
        if np.linalg.norm(seen) < 0.1:
            continue
        x, y = origin + seen * scale
        panel.annotate(
            "", xy=(x, y), xytext=(origin[0], origin[1]), xycoords="axes fraction",
            textcoords="axes fraction", arrowprops=ARROW,
        )  # fmt: skip
        x, y = origin + seen * scale * (1 + 0.22 / np.linalg.norm(seen))
        panel.text(
            x, y, name, transform=panel.transAxes, ha="center", va="center", path_effects=HALO
        )


def bodies_caption(source: Fields, states: Sequence[int], look: Look) -> str:
    """Caption of the picture of `draw_bodies`."""
    times = " and ".join(when(source.run, state) for state in states)
    drawn = f"enlarged {look.scale:g} times" if look.scale > 1 else "in true size"
    units = source.run.case.units
    cut = look.views[1]
    assert cut.cut is not None
    place = ", ".join(number(float(value) + 0.0) for value in cut.centre)
    ends = (
        f"Colours end at {rounded(look.limit)} {units.stress}, which is not exceeded in "
        f"{BODIES_PERCENTAGE:g} % of the volume around the contact; the largest value in an "
        f"element is {rounded(look.largest)} {units.stress}."
    )
    return (
        f"Von Mises equivalent stress of the bodies at {times}; displacements {drawn}. Below: cut "
        f"open at the contact {look.contact}, through its largest pressure at ({place}) "
        f"{units.length} and across {direction_text(cut.cut)}. {ends} Outer surfaces are shaded, "
        "the cut is not."
    )
