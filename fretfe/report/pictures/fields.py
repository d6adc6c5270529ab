# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacement and stress of bodies as the run wrote them for ParaView, and images of them.

Needs PyVista, and images need OpenGL. Only what VTK is best at is left to it: axes, colour bars and
texts are drawn around an image, and lines upon it, by Matplotlib.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.report.pictures.panels import Pixels, View
from fretfe.report.source import folder_of
from fretfe.report.theme import COLOURS
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import FIELDS

# Linear pieces of a cell, by its number of nodes in VTK's order.
PIECES = {
    3: ((0, 1, 2),),
    4: ((0, 1, 2, 3),),
    6: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    9: ((0, 4, 8, 7), (4, 1, 5, 8), (7, 8, 6, 3), (8, 5, 2, 6)),
}
# Number of corners of a cell, which come first among its nodes.
CORNERS = {3: 3, 4: 4, 6: 3, 9: 4}
# Nodes along the edges of a cell, edge by edge.
EDGES = {
    3: ((0, 1), (1, 2), (2, 0)),
    4: ((0, 1), (1, 2), (2, 3), (3, 0)),
    6: ((0, 3, 1), (1, 4, 2), (2, 5, 0)),
    9: ((0, 4, 1), (1, 5, 2), (2, 6, 3), (3, 7, 0)),
}
# Times of a file and of the results that differ by less than this fraction are the same.
SAME_TIME = 1e-9
# Nodes of neighbouring elements are at the same place up to this fraction of the body's size.
SAME_PLACE = 1e-9


@dataclass(frozen=True)
class BodyField:
    """A body at one state; n nodes, of which each element has its own.

    Attributes:
        points: (n, 2) before deformation.
        cells: (m, k) nodes of each element in VTK's order.
        displacement: (n, 2).
        stress: (n, 3) σx, σy, τxy.
        poisson: Poisson's ratio for plane strain; None for plane stress.
    """

    points: Array
    cells: Indices
    displacement: Array
    stress: Array
    poisson: float | None

    @cached_property
    def von_mises(self) -> Array:
        """(n,) von Mises' equivalent stress; in plane strain with σz = ν (σx + σy)."""
        x, y, shear = self.stress.T
        z = 0.0 * x if self.poisson is None else self.poisson * (x + y)
        squares = (x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2
        return np.sqrt(squares / 2 + 3 * shear**2)

    @cached_property
    def outline(self) -> Indices:
        """(f, 2 or 3) nodes along the edges that belong to one element only."""
        pattern = np.array(EDGES[self.cells.shape[1]])
        edges = self.cells[:, pattern].reshape(-1, pattern.shape[1])
        middles = (self.points[edges[:, 0]] + self.points[edges[:, -1]]) / 2
        distances = cKDTree(middles).query(middles, k=2)[0][:, 1]
        return edges[distances > SAME_PLACE * np.ptp(self.points, axis=0).max()]

    def deformed(self, scale: float) -> Array:
        """(n, 2) places with the displacements drawn `scale` times."""
        return self.points + scale * self.displacement


def field_times(directory: Path, bodies: Sequence[str]) -> Array:
    """Times whose fields are there for every body; none without files."""
    import pyvista

    paths = [directory / f"{name}.pvd" for name in bodies]
    if not all(path.is_file() for path in paths):
        return np.zeros(0)
    times = [np.array(pyvista.get_reader(path).time_values) for path in paths]
    return times[0] if all(np.array_equal(times[0], other) for other in times) else np.zeros(0)


def find_time(times: Array, time: float) -> int | None:
    """Number of the field of a time, or None."""
    same = np.abs(times - time) <= SAME_TIME * max(abs(time), np.abs(times).max(initial=0.0))
    return int(same.argmax()) if same.any() else None


def read_body(directory: Path, body: str, number: int, poisson: float | None) -> BodyField:
    """Read one field of one body, all pieces of a parallel run together.

    Args:
        directory: folder with the fields.
        body: its name.
        number: of the time among those of the file.
        poisson: as for `BodyField`.
    """
    import pyvista

    reader = pyvista.get_reader(directory / f"{body}.pvd")
    reader.set_active_time_point(number)
    grid = reader.read()[0]
    cells = grid.cell_connectivity.reshape(grid.n_cells, -1).astype(np.int64)
    # Every process writes copies of elements of its neighbours too.
    own = np.asarray(_copies(grid)) == 0
    return BodyField(
        points=np.asarray(grid.points[:, :2], dtype=np.float64),
        cells=cells[own],
        displacement=np.asarray(grid.point_data["displacement"], dtype=np.float64)[:, :2],
        stress=np.asarray(grid.point_data["stress"], dtype=np.float64)[:, [0, 4, 1]],
        poisson=poisson,
    )


def _copies(grid: Any) -> Any:
    name = "vtkGhostType"
    return grid.cell_data[name] if name in grid.cell_data else np.zeros(grid.n_cells)


@dataclass(frozen=True)
class Fields:
    """A run with the fields that it wrote.

    Attributes:
        run: the run.
        times: of the fields.
    """

    run: Result
    times: Array
    _read: dict[int, dict[str, BodyField]] = field(default_factory=dict)

    def available(self, states: Sequence[int]) -> list[int]:
        """Those of the states whose fields are there."""
        return [state for state in states if self._number(state) is not None]

    def bodies(self, state: int) -> dict[str, BodyField]:
        """Fields of all bodies at a state, which must be there."""
        if state not in self._read:
            number, folder = self._number(state), folder_of(self.run) / FIELDS
            assert number is not None
            self._read[state] = {
                name: read_body(folder, name, number, self._poisson(name))
                for name in self.run.bodies
            }
        return self._read[state]

    def forget(self) -> None:
        """Give the memory of all fields back."""
        self._read.clear()

    def _number(self, state: int) -> int | None:
        return find_time(self.times, float(self.run.loads.times[state]))

    def _poisson(self, body: str) -> float | None:
        case = self.run.case
        return None if case.model.plane == "stress" else case.bodies[body].poisson


def open_fields(directory: Path) -> Fields:
    """The results of a run and its fields.

    Raises:
        OutputError: if the results are missing.
    """
    run = load_result(directory)
    return Fields(run, field_times(directory / FIELDS, list(run.bodies)))


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
        self, bodies: Sequence[BodyField], scale: float, view: View, pixels: tuple[int, int]
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
        self._add(bodies, scale, smooth=True)
        distance = 10 * float(view.half_size.max())
        camera = self._plotter.camera
        camera.focal_point = (*view.centre, 0.0)
        camera.position = (*view.centre, distance)
        camera.up = (*view.normal, 0.0)
        camera.parallel_scale = float(view.half_size[1])
        camera.clipping_range = (0.5 * distance, 2.0 * distance)
        self._plotter.window_size = pixels
        self._plotter.render()
        return np.array(self._plotter.screenshot(return_img=True)[..., :3])

    def export(self, bodies: Sequence[BodyField], scale: float, path: Path) -> None:
        """Write bodies in their deformed shape as a glTF file with colours at the nodes."""
        self._add(bodies, scale, smooth=False)
        self._plotter.export_gltf(path)

    def _add(self, bodies: Sequence[BodyField], scale: float, *, smooth: bool) -> None:
        """Have these bodies and no others; smooth: colours follow stresses between nodes."""
        self._plotter.clear_actors()
        for body in bodies:
            actor = self._plotter.add_mesh(
                surface(body, scale),
                scalars="stress",
                cmap=COLOURS,
                clim=(0.0, self._limit),
                interpolate_before_map=smooth,
                lighting=False,
                show_scalar_bar=False,
                copy_mesh=False,
            )
            # Viewers of glTF multiply the colours by this one.
            actor.prop.color = "white"

    def close(self) -> None:
        """Give the memory back."""
        self._plotter.close()


def surface(body: BodyField, scale: float) -> Any:
    """A body as linear pieces with the point data `stress`; a `pyvista.PolyData`."""
    from pyvista import PolyData

    pieces = body.cells[:, PIECES[body.cells.shape[1]]]
    faces = pieces.reshape(-1, pieces.shape[-1])
    points = np.column_stack([body.deformed(scale), np.zeros(len(body.points))])
    mesh: Any = PolyData(points, np.insert(faces, 0, faces.shape[1], axis=1).ravel())
    mesh.point_data["stress"] = body.von_mises
    return mesh
