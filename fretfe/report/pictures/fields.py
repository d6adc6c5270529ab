# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacement and stress of bodies as the run wrote them, and images of them.

Images need PyVista and OpenGL. Only what VTK is best at is left to it: axes, colour bars and
texts are drawn around an image, and lines upon it, by Matplotlib.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.mesh.elements import CORNERS, FACETS, MIDDLES, SHAPES, VTK_MIDDLES, nodes_of_facets
from fretfe.report.pictures.panels import Pixels, SpaceView, View
from fretfe.report.theme import COLOURS
from fretfe.results.field_files import CELL_TYPES, FIELDS, FieldReader
from fretfe.results.model import Result
from fretfe.results.reader import load_result

# Linear pieces of a cell, by its number of nodes in VTK's order.
PIECES = {
    3: ((0, 1, 2),),
    4: ((0, 1, 2, 3),),
    6: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    9: ((0, 4, 8, 7), (4, 1, 5, 8), (7, 8, 6, 3), (8, 5, 2, 6)),
}
# Nodes of the faces of a solid cell, in the order of the cells above, by its number of nodes.
FACES = {
    count: nodes_of_facets(shape, count, FACETS[shape], VTK_MIDDLES[shape])
    for (dimension, count), shape in SHAPES.items()
    if dimension == 3
}
# Nodes along the edges of a plane cell, edge by edge.
EDGES = {
    count: [
        (first, *middle, last)
        for first, last, *middle in nodes_of_facets(shape, count, FACETS[shape], MIDDLES[shape])
    ]
    for (dimension, count), shape in SHAPES.items()
    if dimension == 2
}
# Angle in degrees between faces of solids that meet in an edge which is drawn.
CREASE = 30.0
LINE: dict[str, Any] = {"color": "#949494", "line_width": 1.6, "lighting": False}
# Parts of a colour that do and do not depend on the light.
LIGHT: dict[str, Any] = {"lighting": True, "ambient": 0.55, "diffuse": 0.45, "specular": 0.0}
# Times of a file and of the results that differ by less than this fraction are the same.
SAME_TIME = 1e-9


class Grid:
    """The elements of a body before deformation; n nodes, of which each element has its own.

    Args:
        nodes: (m, k, d) places of the nodes of each element, in VTK's order.
    """

    def __init__(self, nodes: Array) -> None:
        self.points: Array = nodes.reshape(-1, nodes.shape[2])
        self.cells: Indices = np.arange(len(self.points)).reshape(nodes.shape[:2])

    @property
    def corners(self) -> Indices:
        """(m, c) nodes at the corners of the elements."""
        return self.cells[:, : CORNERS[SHAPES[self.points.shape[1], self.cells.shape[1]]]]

    @property
    def edges(self) -> Indices:
        """(e, 2 or 3) nodes along each edge of elements in the plane, once."""
        return self._edges[0]

    @property
    def outline(self) -> Indices:
        """(f, 2 or 3) nodes along the edges that belong to one element only, in the plane."""
        edges, counts = self._edges
        return edges[counts == 1]

    @cached_property
    def _edges(self) -> tuple[Indices, Indices]:
        """Edges in the plane, and the number of elements of each."""
        pattern = np.array(EDGES[self.cells.shape[1]])
        edges = self.cells[:, pattern].reshape(-1, pattern.shape[1])
        middles = self.points[edges[:, 0]] + self.points[edges[:, -1]]
        # Nodes of neighbouring elements are at exactly the same place.
        places = np.ascontiguousarray(middles).view(np.complex128).ravel()
        _, first, counts = np.unique(places, return_index=True, return_counts=True)
        return edges[first], counts

    @cached_property
    def faces(self) -> Indices:
        """(f, k) nodes of the faces that are seen: elements in the plane, the skin of solids."""
        if self.points.shape[1] == 2:
            return self.cells
        pattern = np.array(FACES[self.cells.shape[1]])
        faces = self.cells[:, pattern].reshape(-1, pattern.shape[1])
        corners = faces[:, : CORNERS[SHAPES[2, faces.shape[1]]]]
        # Nodes of neighbouring elements are at exactly the same place.
        _, places = np.unique(self.points, axis=0, return_inverse=True)
        same = np.sort(places.ravel()[corners], axis=1)
        _, numbers, counts = np.unique(same, axis=0, return_inverse=True, return_counts=True)
        return faces[counts[numbers.ravel()] == 1]


@dataclass(frozen=True)
class BodyField:
    """A body at one state.

    Attributes:
        grid: its elements.
        displacement: (n, d) at the nodes.
        stress: (n, 6) σx, σy, σz, τxy, τyz, τxz at the nodes.
    """

    grid: Grid
    displacement: Array
    stress: Array

    @cached_property
    def von_mises(self) -> Array:
        """(n,) von Mises' equivalent stress."""
        x, y, z = self.stress[:, :3].T
        squares = (x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2
        return np.sqrt(squares / 2 + 3 * (self.stress[:, 3:] ** 2).sum(axis=1))

    def deformed(self, scale: float) -> Array:
        """(n, d) places with the displacements drawn `scale` times."""
        return self.grid.points + scale * self.displacement


def find_time(times: Array, time: float) -> int | None:
    """Number of the field of a time, or None."""
    same = np.abs(times - time) <= SAME_TIME * max(abs(time), np.abs(times).max(initial=0.0))
    return int(same.argmax()) if same.any() else None


class Fields:
    """A run with the fields that it wrote.

    Args:
        run: the run.
        source: its fields, or None if it wrote none.
    """

    def __init__(self, run: Result, source: FieldReader | None) -> None:
        self.run = run
        self._source = source
        self._grids: dict[str, Grid] = {}
        self._read: dict[int, dict[str, BodyField]] = {}

    @property
    def dimension(self) -> int:
        """Number of coordinates of the bodies."""
        return self.run.solution.dimension

    def available(self, states: Sequence[int]) -> list[int]:
        """Those of the states whose fields are there."""
        return [state for state in states if self._number(state) is not None]

    def bodies(self, state: int) -> dict[str, BodyField]:
        """Fields of all bodies at a state, which must be there."""
        source, number = self._source, self._number(state)
        assert source is not None
        assert number is not None
        dimension = self.dimension
        if not self._grids:
            nodes = {name: source.nodes(name)[..., :dimension] for name in source.bodies}
            self._grids = {name: Grid(each) for name, each in nodes.items()}
        if state not in self._read:
            self._read[state] = {
                name: BodyField(
                    grid,
                    source.values("displacement", name, number).reshape(-1, 3)[:, :dimension],
                    source.values("stress", name, number).reshape(-1, 6),
                )
                for name, grid in self._grids.items()
            }
        return self._read[state]

    def _number(self, state: int) -> int | None:
        times = self._source.times if self._source is not None else np.zeros(0)
        return find_time(times, float(self.run.loads.times[state]))


def open_fields(directory: Path) -> Fields:
    """The results of a run and its fields.

    Raises:
        OutputError: if the results are missing, or the fields cannot be read.
    """
    path = directory / FIELDS
    return Fields(load_result(directory), FieldReader(path) if path.exists() else None)


class Scene:
    """Draws bodies again and again, with the same colours.

    Args:
        limit: von Mises stress of the last colour; the first one is zero.
    """

    def __init__(self, limit: float) -> None:
        from pyvista import Plotter

        plotter: Any = Plotter
        self._limit = limit
        self._plotter = plotter(off_screen=True)
        self._plotter.set_background("white")
        self._plotter.enable_parallel_projection()

    def image(
        self,
        bodies: Sequence[BodyField],
        scale: float,
        view: View | SpaceView,
        pixels: tuple[int, int],
    ) -> Pixels:
        """Bodies in their deformed shape.

        Args:
            bodies: what to draw.
            scale: of the displacements.
            view: what is seen; of the same proportions as `pixels`.
            pixels: width and height.

        Returns:
            (height, width, 3) red, green and blue.
        """
        self._plotter.clear_actors()
        camera, distance = self._plotter.camera, 10 * float(view.half_size.max())
        if isinstance(view, SpaceView):
            for body in bodies:
                self._add_solid(body, scale, view)
            centre, viewer, up = view.centre, view.viewer, view.up
            distance += self._plotter.length
        else:
            for body in bodies:
                self._add(surface(body, scale), lighting=False)
            centre, up = np.append(view.centre, 0.0), np.append(view.normal, 0.0)
            viewer = np.array([0.0, 0.0, 1.0])
            camera.clipping_range = (0.5 * distance, 2.0 * distance)
        camera.focal_point = tuple(centre)
        camera.position = tuple(centre + distance * viewer)
        camera.up = tuple(up)
        camera.parallel_scale = float(view.half_size[1])
        # The plotter's own setter would draw once more.
        self._plotter.render_window.SetSize(*pixels)
        self._plotter.render()
        return np.array(self._plotter.screenshot(return_img=True)[..., :3])

    def _add(self, mesh: Any, **look: Any) -> Any:
        """Add a mesh in the colours of its stress, which follow it between the nodes."""
        return self._plotter.add_mesh(
            mesh, scalars="stress", cmap=COLOURS, clim=(0.0, self._limit),
            show_scalar_bar=False, render=False, **{"interpolate_before_map": True, **look},
        )  # fmt: skip

    def _add_solid(self, body: BodyField, scale: float, view: SpaceView) -> None:
        """Add the shaded skin of a solid and, where it is cut, the section, with their edges."""
        skin = surface(body, scale)
        parts = [(skin, LIGHT)]
        if view.cut is not None:
            skin = skin.clip(normal=view.cut, origin=view.centre)
            parts = [(section(body, scale, view), {"lighting": False}), (skin, LIGHT)]
        for mesh, light in parts:
            if not mesh.n_cells:
                continue
            self._add(mesh, **light)
            edges = mesh.clean(tolerance=0.0).extract_feature_edges(
                feature_angle=CREASE, manifold_edges=False, non_manifold_edges=False
            )
            if edges.n_cells:
                actor = self._plotter.add_mesh(edges, render=False, **LINE)
                # Lines lie on the faces that they bound.
                actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()

    def close(self) -> None:
        """Give the memory back."""
        self._plotter.close()


def surface(body: BodyField, scale: float) -> Any:
    """A plane body, or the skin of a solid, as linear pieces with the point data `stress`.

    Returns:
        A `pyvista.PolyData`.
    """
    from pyvista import PolyData

    pieces = body.grid.faces[:, PIECES[body.grid.faces.shape[1]]]
    faces = pieces.reshape(-1, pieces.shape[-1])
    places = body.deformed(scale)
    points = np.zeros((len(places), 3))
    points[:, : places.shape[1]] = places
    mesh: Any = PolyData(points, np.insert(faces, 0, faces.shape[1], axis=1).ravel())
    mesh.point_data["stress"] = body.von_mises
    return mesh


def section(body: BodyField, scale: float, view: SpaceView) -> Any:
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
