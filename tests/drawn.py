# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders with bodies and fields that no finite elements had to compute."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pad_cases import pad, press, shear

from fretfe._typing import Array
from fretfe.backends import find_backend
from fretfe.case import Case, parse_case
from fretfe.results.writer import FIELDS, write_results

# Places of the six nodes of a triangle in terms of its corners, in VTK's order.
NODES = np.array([[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [0, 1, 1], [1, 0, 1]]) / 2


@dataclass(frozen=True)
class Grid:
    """A rectangle of triangles of order 1."""

    points: Array
    cells: NDArray[np.int64]
    cell: str = "triangle"
    order: int = 1
    boundaries: dict[str, NDArray[np.int64]] = field(default_factory=dict)


def rectangle(low: tuple[float, float], high: tuple[float, float], count: int = 16) -> Grid:
    """2 count² triangles."""
    x, y = np.meshgrid(*(np.linspace(a, b, count + 1) for a, b in zip(low, high, strict=True)))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    first = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    quads = np.stack([first, first + 1, first + count + 2, first + count + 1], axis=1)
    return Grid(points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


BODIES = {"upper": rectangle((-2.0, 0.0), (2.0, 2.0)), "lower": rectangle((-3.0, -2.0), (3.0, 0.0))}


def pad_case(**output: object) -> Case:
    """A cylinder on a block, P = 600 and Q = 60 sin t."""
    loads = {"press": press(steps=2), "shear": shear(steps=4)}
    return parse_case(pad(loads=loads, output=output))


def write_folder(folder: Path, times: Sequence[float]) -> Path:
    """Results of half-planes with bodies, and fields of them at some times."""
    case = pad_case()
    folder.mkdir()
    result = find_backend("halfplane").solve(case)
    write_results(folder, replace(result, backend="fem", bodies=BODIES))
    (folder / FIELDS).mkdir()
    for name in BODIES:
        write_fields(folder / FIELDS, name, times)
    return folder


def fields(points: Array, time: float) -> tuple[Array, Array]:
    """Displacement (n, 2) and stress (n, 3) of a made-up state: pressed down, σx = 100 + 10 x t."""
    displacement = np.stack([0.001 * time * points[:, 1], -0.002 + 0 * points[:, 1]], axis=1)
    stress = np.zeros((len(points), 3))
    stress[:, 0] = 100 + 10 * points[:, 0] * time
    return displacement, stress


def write_fields(folder: Path, name: str, times: Sequence[float], pieces: int = 1) -> None:
    """Files as DOLFINx writes them: triangles of order 2, nodes of their own, copies of neighbours.

    Args:
        folder: to write to.
        name: of the body.
        times: of the fields.
        pieces: number of processes that take part.
    """
    body = BODIES[name]
    parts = np.array_split(np.arange(len(body.cells)), pieces)
    collection = ""
    for number, time in enumerate(times):
        sources = ""
        for rank, own in enumerate(parts):
            copies = np.setdiff1d(np.arange(len(body.cells)), own)[:3]
            file = f"{name}_p{rank}_{number:06}.vtu"
            (folder / file).write_text(_piece(body, own, copies, time))
            sources += f'<Piece Source="{file}" />'
        (folder / f"{name}{number:06}.pvtu").write_text(_pieces(sources))
        collection += f'<DataSet timestep="{time}" part="0" file="{name}{number:06}.pvtu" />'
    text = (
        f'<VTKFile type="Collection" version="1.0"><Collection>{collection}</Collection></VTKFile>'
    )
    (folder / f"{name}.pvd").write_text(text)


def _piece(body: Grid, own: NDArray[np.int64], copies: NDArray[np.int64], time: float) -> str:
    corners = body.points[body.cells[np.concatenate([own, copies])]]
    points = (NODES @ corners).reshape(-1, 2)
    displacement, stress = fields(points, time)
    count, flat = len(corners), np.zeros((len(points), 1))
    tensor = np.zeros((len(points), 9))
    tensor[:, [0, 4, 1]], tensor[:, 3] = stress, stress[:, 2]
    ghosts = [0] * len(own) + [1] * len(copies)
    return (
        '<VTKFile type="UnstructuredGrid" version="2.2"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}"><Points>'
        f"{_array('Float64', '', np.hstack([points, flat]), 3)}</Points><Cells>"
        f"{_array('Int32', 'connectivity', np.arange(6 * count))}"
        f"{_array('Int32', 'offsets', 6 * np.arange(1, count + 1))}"
        f"{_array('Int8', 'types', [69] * count)}</Cells><PointData>"
        f"{_array('Float64', 'displacement', np.hstack([displacement, flat]), 3)}"
        f"{_array('Float64', 'stress', tensor, 9)}</PointData><CellData>"
        f"{_array('UInt8', 'vtkGhostType', ghosts)}</CellData></Piece></UnstructuredGrid></VTKFile>"
    )


def _array(kind: str, name: str, values: object, components: int = 1) -> str:
    text = " ".join(map(repr, np.asarray(values).ravel().tolist()))
    named = f'Name="{name}" ' if name else ""
    shape = f'type="{kind}" NumberOfComponents="{components}"'
    return f'<DataArray {named}{shape} format="ascii">{text}</DataArray>'


def _pieces(sources: str) -> str:
    return (
        '<VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid GhostLevel="1">'
        '<PPointData><PDataArray type="Float64" Name="displacement" NumberOfComponents="3" />'
        '<PDataArray type="Float64" Name="stress" NumberOfComponents="9" /></PPointData>'
        '<PCellData><PDataArray type="UInt8" Name="vtkGhostType" /></PCellData>'
        '<PPoints><PDataArray type="Float64" NumberOfComponents="3" /></PPoints>'
        f"{sources}</PUnstructuredGrid></VTKFile>"
    )
