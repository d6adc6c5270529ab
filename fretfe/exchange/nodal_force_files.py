# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact forces at the nodes of another mesh as CSV, loads of Abaqus and CalculiX, and VTU."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array
from fretfe.case.base import AXES, positive_number
from fretfe.errors import CaseError, MeshError
from fretfe.exchange.nodal_forces import NodalForces, nodal_forces
from fretfe.files import replace_text, writing
from fretfe.history.solution import ContactHistory, Solution
from fretfe.mesh.inp_surfaces import DeckSurface, read_surface
from fretfe.results.model import Result
from fretfe.results.writer import prepare_other

TABLE = "forces.csv"
LOADS = "cload.inp"
GRID = "forces.vtu"
# VTK's numbers of facets, by dimension of space and number of nodes.
CELL_TYPES = {(2, 2): 3, (2, 3): 21, (3, 3): 5, (3, 4): 9, (3, 6): 22, (3, 8): 23}
# A time that is given with six digits is found.
SAME_TIME = 1e-6


@dataclass(frozen=True)
class ForceExport:
    """Forces that were written.

    Attributes:
        contact: its name.
        body: on which the forces act.
        time: of the state.
        thickness: of plane bodies, for the whole of which the forces are; None for solids.
        nodes: number of nodes with a force.
        found: the forces, in the plane per unit thickness.
        files: that were written.
    """

    contact: str
    body: str
    time: float
    thickness: float | None
    nodes: int
    found: NodalForces
    files: tuple[Path, ...]


@dataclass(frozen=True)
class Wanted:
    """Choice among the tractions of a result.

    Attributes:
        body: on which they act.
        contact: its name; None for the only one.
        time: of a state whose tractions are kept; None for the last one.
        factor: length unit of the other mesh, in that of the results.
    """

    body: str
    contact: str | None = None
    time: float | None = None
    factor: float = 1.0


def export_forces(
    result: Result, mesh: Path, surface: str, wanted: Wanted, folder: Path
) -> ForceExport:
    """Map the tractions of a contact onto a surface of an Abaqus or CalculiX model and write them.

    Args:
        result: with tractions.
        mesh: input file of the model.
        surface: name of a surface, node set or element set in it.
        wanted: which tractions.
        folder: for the files; made if missing.

    Raises:
        CaseError: if the result has no such tractions, or the folder holds results of a run.
        MeshError: if the surface cannot be read, or does not fit.
        OutputError: if a file cannot be written.
    """
    positive_number("--factor", wanted.factor)
    contact = _contact(result.solution, wanted)
    state = _state(result.solution, wanted.time)
    other = read_surface(mesh, surface)
    dimension = contact.surface.points.shape[1]
    if other.points.shape[1] != dimension:
        kinds = {2: "plane elements", 3: "solid elements"}
        raise MeshError(
            f"{mesh}: expected {kinds[dimension]} as the results have, found "
            f"{kinds[other.points.shape[1]]}"
        )
    try:
        found = nodal_forces(contact, state, wanted.body, other, wanted.factor)
    except MeshError as error:
        raise MeshError(f"{mesh}: {surface}: {error}") from None
    thickness = result.case.model.thickness if dimension == 2 else None
    forces = found.forces * (thickness or 1.0)
    time = float(result.solution.times[state])
    about = f"contact {contact.name} on {wanted.body} at t = {time:.9g}"
    units = result.case.units
    texts = {
        TABLE: _table(other, forces, units.force),
        LOADS: _loads(other, forces, f"{about}; forces in {units.force}"),
        GRID: _grid(other, forces),
    }
    files = _write(folder, texts)
    count = int(np.count_nonzero(forces.any(axis=1)))
    return ForceExport(contact.name, wanted.body, time, thickness, count, found, files)


def _contact(solution: Solution, wanted: Wanted) -> ContactHistory:
    named = {each.name: each for each in solution.contacts}
    if wanted.contact is None and len(named) > 1:
        raise CaseError(f"--contact: expected one of {', '.join(named)}, found none")
    name = wanted.contact if wanted.contact is not None else next(iter(named))
    if name not in named:
        raise CaseError(f"--contact: expected one of {', '.join(named)}, found {name!r}")
    found = named[name]
    if wanted.body not in (found.body1, found.body2):
        raise CaseError(
            f"--body: expected one of {found.body1}, {found.body2}, found {wanted.body!r}"
        )
    return found


def _state(solution: Solution, time: float | None) -> int:
    """The state at a time."""
    kept = np.arange(len(solution.times)) if solution.kept is None else solution.kept
    if time is None:
        return int(kept[-1])
    times = solution.times[kept]
    nearest = int(np.abs(times - time).argmin())
    if not abs(times[nearest] - time) <= SAME_TIME * float(np.abs(solution.times).max()):
        around = times[max(nearest - 1, 0) : nearest + 2]
        raise CaseError(
            f"--time: expected the time of a state with tractions, such as "
            f"{', '.join(f'{each:.9g}' for each in around)}, found {time:g}"
        )
    return int(kept[nearest])


def _write(folder: Path, texts: Mapping[str, Iterable[str]]) -> tuple[Path, ...]:
    prepare_other(folder)
    with writing(folder, "the forces"):
        for name, lines in texts.items():
            replace_text(folder / name, "\n".join(lines) + "\n")
    return tuple(folder / name for name in texts)


def _table(surface: DeckSurface, forces: Array, unit: str) -> Iterator[str]:
    """A row for each node; places are those of the file."""
    axes = AXES[: forces.shape[1]]
    yield ",".join(["node", *axes, *(f"force_{axis} [{unit}]" for axis in axes)])
    for label, point, force in zip(surface.labels, surface.points, forces, strict=True):
        values = ",".join(f"{value:.12e}" for value in force)
        yield f"{label},{','.join(f'{value!r}' for value in point.tolist())},{values}"


def _loads(surface: DeckSurface, forces: Array, about: str) -> Iterator[str]:
    """Lines for a step of Abaqus or CalculiX; numbers with the 20 characters that this reads."""
    yield f"** {about}"
    yield "*CLOAD"
    for label, force in zip(surface.labels, forces, strict=True):
        for axis, value in enumerate(force, start=1):
            if value:
                yield f"{label}, {axis}, {value:.12e}"


def _grid(surface: DeckSurface, forces: Array) -> Iterator[str]:
    """A grid with the force at each node, as VTK's XML has it."""
    points, vectors = (
        np.pad(each, ((0, 0), (0, 3 - each.shape[1]))) for each in (surface.points, forces)
    )
    count = sum(map(len, surface.facets))
    sizes = [facets.shape[1] for facets in surface.facets for _ in facets]
    shapes = [CELL_TYPES[forces.shape[1], size] for size in sizes]
    yield '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">'
    yield f'<UnstructuredGrid><Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">'
    yield "<Points>"
    yield from _array("Points", points, 'type="Float64" NumberOfComponents="3"')
    yield "</Points><Cells>"
    nodes = (row for facets in surface.facets for row in facets)
    yield from _array("connectivity", nodes, 'type="Int64"')
    yield from _array("offsets", np.cumsum(sizes)[:, None], 'type="Int64"')
    yield from _array("types", np.array(shapes)[:, None], 'type="UInt8"')
    yield '</Cells><PointData Vectors="force">'
    yield from _array("force", vectors, 'type="Float64" NumberOfComponents="3"')
    yield "</PointData></Piece></UnstructuredGrid></VTKFile>"


def _array(name: str, rows: Iterable[np.ndarray], kind: str) -> Iterator[str]:
    yield f'<DataArray Name="{name}" format="ascii" {kind}>'
    yield from (" ".join(map(repr, row.tolist())) for row in rows)
    yield "</DataArray>"
