# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields that VTK reads, and where places are in the elements of a field, by PyVista."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from fretfe._typing import Array, Indices
from fretfe.errors import CaseError
from fretfe.fields.field import ONLY_STEP, Cells, Field, Names, Quantity
from fretfe.fields.older_vtk import errors_of_vtk
from fretfe.results.tables import require

# Names among the values at nodes that programs write, in small letters, and their components.
NAMES: Mapping[Quantity, tuple[str, ...]] = {
    "displacements": ("displacement", "displacements", "disp", "u"),
    "temperatures": ("temperature", "temp", "ndtemp", "nt", "nt11", "t"),
}
SHAPES: Mapping[Quantity, tuple[tuple[int, ...], ...]] = {
    "displacements": ((2,), (3,)),
    "temperatures": ((), (1,)),
}
# VTK's kinds of elements that are points: nothing is between their nodes.
LONE = (1, 2)
# A place is in an element if it is nearer to it than this part of the extent of all.
INSIDE = 1e-9
# Steps to a place in an element from where VTK finds it.
NEWTON_STEPS = 2
# Nodes of the largest elements that VTK knows, and more.
MOST_NODES = 512
# Files of which errors of VTK do no harm, such as NaN in the range of an array: what they state has
# been compared with what they have.
IN_XML = (".vtu", ".pvd")
# Of more pieces around a cut, each element may be one: the file has nodes for each of them.
MOST_PIECES = 16

# Points, elements and values in a step.
Grid = tuple[Array, Cells, Array]


def read_grid(path: Path, quantity: Quantity, arrays: Names) -> tuple[Array, Callable[[int], Grid]]:
    """(T,) times of the steps of a file, and what reads one of them; see `read_field`.

    Raises:
        CaseError: if it is not as expected.
        DependencyError: if PyVista is not installed.
    """
    pyvista = require("pyvista")
    try:
        reader = pyvista.get_reader(path)
        times, set_step = _steps(reader)
    except Exception as error:  # of many types, PyVista's and Python's
        raise CaseError(f"{path}: expected a file that VTK reads, found a damaged one") from error

    def read(step: int) -> Grid:
        try:
            with errors_of_vtk() as told:
                set_step(step)
                grid = reader.read()
                if isinstance(grid, pyvista.MultiBlock):
                    grid = grid.combine()
                grid = grid.cast_to_unstructured_grid()
        except Exception as error:
            raise CaseError(
                f"{path}: expected step {step + 1} as VTK reads it, found it damaged"
            ) from error
        if told and path.suffix.lower() not in IN_XML:
            # It goes on with what its arrays hold by chance.
            raise CaseError(
                f"{path}: expected step {step + 1} as VTK reads it, found an error: {told[0]}"
            )
        cells = _cells(grid) if grid.n_cells else None
        if cells is None or not len(cells.shapes):
            raise CaseError(f"{path}: expected elements, found none in step {step + 1}")
        return np.array(grid.points, dtype=float), cells, _values(path, grid, quantity, arrays)

    return times, read


def _steps(reader: Any) -> tuple[Array, Callable[[int], None]]:
    """(T,) times of the steps of a reader, and what sets one of them."""
    if hasattr(reader, "set_active_time_point"):
        return np.array(reader.time_values, dtype=float), reader.set_active_time_point
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

    source = reader.reader
    source.UpdateInformation()
    information, key = source.GetOutputInformation(0), vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    if information.Has(key):
        times = np.array(information.Get(key), dtype=float)
        if len(times) > 1:
            return times, lambda step: source.UpdateTimeStep(times[step])
    return np.array([ONLY_STEP]), lambda step: None


def _cells(grid: Any) -> Cells:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    # By VTK itself: PyVista has changed their names.
    cells = grid.GetCells()
    nodes = np.array(vtk_to_numpy(cells.GetConnectivityArray()), dtype=np.int64)
    offsets: Indices = np.array(vtk_to_numpy(cells.GetOffsetsArray()), dtype=np.int64)
    counts = offsets[1:] - offsets[:-1]
    shapes = np.array(grid.celltypes, dtype=np.int64)
    if (lone := np.isin(shapes, LONE)).any() and len(shapes) == len(counts):
        nodes, counts, shapes = nodes[~np.repeat(lone, counts)], counts[~lone], shapes[~lone]
    return Cells(
        nodes, np.cumsum(np.append(0, counts)), shapes, np.zeros(len(shapes), dtype=np.int64)
    )


def _values(path: Path, grid: Any, quantity: Quantity, names: Names) -> Array:
    """(n, 3) displacements or (n, 1) temperatures among the values at the nodes."""
    arrays = {name: np.asarray(grid.point_data[name]) for name in grid.point_data}
    chosen = names or _usual(path, arrays, quantity)
    if missing := [name for name in chosen if name not in arrays]:
        raise CaseError(
            f"{path}: expected the arrays {', '.join(map(repr, chosen))} among the values at the "
            f"nodes, found none called {missing[0]!r}: {_listed(arrays)}"
        )
    columns = [arrays[name].astype(float).reshape(grid.n_points, -1) for name in chosen]
    found, wide = np.hstack(columns), [each.shape[1] for each in columns]
    fitting = {"displacements": ([2], [3], [1, 1], [1, 1, 1]), "temperatures": ([1],)}
    if wide not in fitting[quantity]:
        what = "a vector, or a number for each axis," if quantity == "displacements" else "a number"
        raise CaseError(
            f"{path}: expected {what} at the nodes, found arrays of "
            f"{', '.join(map(str, wide))} components: {_listed(arrays)}"
        )
    return np.pad(found, ((0, 0), (0, 3 - found.shape[1]))) if found.shape[1] == 2 else found


def _usual(path: Path, arrays: Mapping[str, Array], quantity: Quantity) -> Names:
    """The array that is called as programs call theirs.

    Raises:
        CaseError: if there are several, or none.
    """
    named = tuple(
        name
        for name, each in arrays.items()
        if each.shape[1:] in SHAPES[quantity] and name.lower() in NAMES[quantity]
    )
    if len(named) != 1:
        what = "vector" if quantity == "displacements" else "number"
        raise CaseError(
            f"{path}: expected one {what} at the nodes that is called one of "
            f"{', '.join(NAMES[quantity])}, or its name as 'arrays' of the load, found "
            f"{_listed(arrays)}"
        )
    return named


def _listed(arrays: Mapping[str, Array]) -> str:
    return ", ".join(map(repr, arrays)) or "none"


def element_weights(
    field: Field, chosen: Indices, places: Array
) -> tuple[sparse.csr_matrix, Array]:
    """Weights of the points of a field at places, by the shape functions of its elements.

    Args:
        field: with elements.
        chosen: numbers of the elements to look in.
        places: (m, 3).

    Returns:
        (m, n) weights at the place of the elements that is nearest to each of the places, and (m,)
        distances from it, or from the place that the weights reproduce if that is farther, over the
        diagonal of the box of its element.

    Raises:
        DependencyError: if PyVista is not installed.
    """
    pyvista = require("pyvista")
    from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

    assert field.cells is not None
    starts, ends = field.cells.offsets[chosen], field.cells.offsets[chosen + 1]
    counts = ends - starts
    # In VTK's list each element begins with the number of its nodes.
    rows = np.repeat(starts - np.cumsum(counts) + counts, counts) + np.arange(counts.sum())
    listed = np.insert(field.cells.nodes[rows], np.cumsum(counts) - counts, counts)
    grid = pyvista.UnstructuredGrid(listed, field.cells.shapes[chosen], field.points)
    locator = vtkStaticCellLocator()
    locator.SetDataSet(grid)
    locator.BuildLocator()
    near = INSIDE * float(np.ptp(field.points, axis=0).max())
    found = [_locate(locator, place, near) for place in places]
    entries = np.concatenate([weights for _, weights, *_ in found])
    columns = np.concatenate([nodes for nodes, *_ in found])
    row_ends = np.cumsum([0, *(len(nodes) for nodes, *_ in found)])
    shape = len(places), len(field.points)
    weights = sparse.csr_matrix((entries, columns, row_ends), shape=shape)
    distances, diagonals = np.array([own for *_, own in found]).T
    # Whatever VTK takes for inside: weights are those of the place that they reproduce.
    missed = np.linalg.norm(weights @ field.points - places, axis=1)
    return weights, np.maximum(distances, missed) / diagonals


def body_weights(field: Field, places: Array, outside: float) -> tuple[sparse.csr_matrix, Array]:
    """Weights of the points of a field at places of one body, from elements that hang together.

    Where two bodies touch, elements of both are at one place, with the slip of the contact between
    their displacements. The elements are those of the fewest pieces of the mesh that reach all
    places: one, unless the body itself is made of several. Pieces are taken in the order of how
    many places are nearest to them.

    Args:
        field: with elements, of any number of bodies.
        places: (m, 3) of one body.
        outside: distance, as of `element_weights`, from which a place is in no element.

    Returns:
        (m, n) weights and (m,) distances, as of `element_weights`.

    Raises:
        DependencyError: if PyVista is not installed.
    """
    assert field.cells is not None
    starts, nodes = field.cells.offsets[:-1], field.cells.nodes
    first = np.repeat(nodes[starts], np.diff(field.cells.offsets))
    shape = len(field.points), len(field.points)
    links = sparse.csr_matrix((np.ones(len(nodes)), (first, nodes)), shape=shape)
    pieces = connected_components(links, directed=False)[1]
    weights, away = element_weights(field, np.arange(len(starts)), places)
    nearest = pieces[weights.indices[weights.indptr[:-1]]]
    if len(set(nearest)) > MOST_PIECES:
        return weights, away
    kept = np.zeros(len(starts), dtype=bool)
    left = np.flatnonzero(away <= outside)
    while len(left):
        own = pieces[nodes[starts]] == np.bincount(nearest[left]).argmax()
        kept |= own
        left = left[element_weights(field, np.flatnonzero(own), places[left])[1] > outside]
    return element_weights(field, np.flatnonzero(kept), places) if kept.any() else (weights, away)


def _locate(locator: Any, place: Array, near: float) -> tuple[Indices, Array, tuple[float, float]]:
    """Nodes of the element nearest to a place (3,), and their weights.

    Then the distance of the place from the element, and the diagonal of its box.
    """
    from vtkmodules.vtkCommonCore import reference
    from vtkmodules.vtkCommonDataModel import vtkGenericCell

    cell: Any = vtkGenericCell()
    part: Any = reference(0)
    square: Any = reference(0.0)
    local, weights, away = [0.0, 0.0, 0.0], np.zeros(MOST_NODES), 0.0
    inside = locator.FindCell(place, near**2, cell, part, local, weights) >= 0
    if not inside:
        closest, number = [0.0, 0.0, 0.0], reference(0)
        locator.FindClosestPoint(place, closest, cell, number, part, square)
        away = float(np.sqrt(square.get()))
        cell.EvaluatePosition(closest, [0.0, 0.0, 0.0], part, local, square, weights)
    count = cell.GetNumberOfPoints()
    nodes = np.array([cell.GetPointId(node) for node in range(count)], dtype=np.int64)
    own = _refined(cell, place, local) if inside else weights[:count].copy()
    return nodes, own, (away, float(np.sqrt(cell.GetLength2())))


def _refined(cell: Any, place: Array, local: list[float]) -> Array:
    """(k,) weights of the nodes at a place inside of an element, near local coordinates.

    VTK ends its own iterations at a thousandth of an element.
    """
    count, size = cell.GetNumberOfPoints(), cell.GetCellDimension()
    own = cell.GetPoints()
    points = np.array([own.GetPoint(node) for node in range(count)])
    weights, slopes, at = np.zeros(count), np.zeros(size * count), np.array(local)
    for _ in range(NEWTON_STEPS):
        cell.InterpolateFunctions(at, weights)
        cell.InterpolateDerivs(at, slopes)
        tangents = (slopes.reshape(size, count) @ points).T
        at[:size] += np.linalg.lstsq(tangents, place - weights @ points, rcond=None)[0]
    cell.InterpolateFunctions(at, weights)
    return weights
