# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements and arrays of grids that VTK reads: known kinds, names, and what is refused."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.errors import CaseError
from fretfe.fields.field import Cells, Field, Names, Quantity, read_field
from fretfe.fields.vtk import element_weights

pyvista = pytest.importorskip("pyvista")

POINTS = np.array([[x, y, 0.0] for y in range(3) for x in range(3)])
CELLS = np.array([[k, k + 1, k + 4, k + 3] for k in (0, 1, 3, 4)])
MOVED = 0.5 * POINTS + [1.0, 2.0, 0.0]


def grid(
    folder: Path,
    arrays: Mapping[str, Array] = MappingProxyType({"U": MOVED}),
    *,
    kinds: tuple[int, ...] = (9,) * 4,
    cells: Array = CELLS,
) -> Path:
    path = folder / "run.vtu"
    made = pyvista.UnstructuredGrid(np.insert(cells, 0, 4, axis=1).ravel(), np.full(4, 9), POINTS)
    for name, values in arrays.items():
        made.point_data[name] = values
    made.save(path, binary=False)
    text, types = path.read_text(), "9 9 9 9"
    assert text.count(types) == 1
    path.write_text(text.replace(types, " ".join(map(str, kinds))))
    return path


@pytest.mark.parametrize("kind", [0, 6, 7, 41, 42, 77, 255])
def test_elements_of_unknown_kinds_are_refused(tmp_path: Path, kind: int) -> None:
    """VTK says 0 of those that it does not know, and polygons are off by a third."""
    assert len(read_field(grid(tmp_path)).points) == 9
    with pytest.raises(CaseError, match=r"run\.vtu: expected elements") as caught:
        read_field(grid(tmp_path, kinds=(9, kind, 9, 9)))
    # of some of them VTK itself makes others, or none
    assert f"found element 1 (from 0) of kind {kind}" in str(caught.value) or kind in (42, 77)


def test_elements_with_other_nodes_than_their_kind_are_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"expected 3 nodes .* kind 5, found element 2 .* of 4"):
        read_field(grid(tmp_path, kinds=(9, 9, 5, 9)))


def test_elements_without_extent_are_refused(tmp_path: Path) -> None:
    path = grid(tmp_path, cells=np.where([[0], [1], [0], [0]], 2, CELLS))
    with pytest.raises(CaseError, match=r"elements with an extent, found element 1 .* all nodes"):
        read_field(path)


def test_points_among_elements_are_left_out(tmp_path: Path) -> None:
    """Gmsh writes those of its geometry."""
    path = tmp_path / "run.vtu"
    cells = np.concatenate([[1, 4], np.insert(CELLS, 0, 4, axis=1).ravel()])
    made = pyvista.UnstructuredGrid(cells, np.array([1, 9, 9, 9, 9]), POINTS)
    made.point_data["U"] = MOVED
    made.save(path)
    field = read_field(path)
    assert field.cells is not None and field.cells.shapes.tolist() == [9, 9, 9, 9]
    place = np.array([[1.001, 1.002, 0.0]])
    weights, away = element_weights(field, np.arange(4), place)
    np.testing.assert_allclose(weights @ POINTS, place, atol=1e-12)
    assert away.max() < 1e-12


def test_weights_of_another_place_are_far_away() -> None:
    """A pixel that is none, for VTK takes it for a rectangle along the axes."""
    points = np.array([[0, 0, 0], [1, 0.3, 0], [0.1, 1, 0], [1.2, 1.4, 0.0]])
    cells = Cells(np.arange(4), np.array([0, 4]), np.array([8]), np.zeros(1, dtype=np.int64))
    field = Field(points, np.ones(1), lambda _: points, cells)
    places = np.random.default_rng(1).dirichlet(np.ones(4), 10) @ points
    weights, away = element_weights(field, np.arange(1), places)
    missed = np.linalg.norm(weights @ points - places, axis=1) / np.linalg.norm([1.2, 1.4])
    assert missed.max() > 0.05
    assert (away >= missed - 1e-12).all()


@pytest.mark.parametrize(
    ("kind", "order"), [(69, 3), (70, 2), (22, 2)], ids=["Lagrange, cubic", "Lagrange", "triangle"]
)
def test_elements_of_higher_order(kind: int, order: int) -> None:
    """As DOLFINx writes them: corners, edges, inside; a linear field is met."""
    corners = np.array([[0, 0], [2, 0.2], [0.3, 1.5]])
    steps = np.linspace(0, 1, order + 1)[1:-1, None]
    nodes = list(corners)
    if kind == 70:
        nodes = [np.array(each) for each in ((0, 0), (2, 0), (2, 1), (0, 1))]
    count = len(nodes)
    for k in range(count):
        first, last = nodes[k], nodes[(k + 1) % count]
        ends = (last, first) if kind == 70 and k > 1 else (first, last)
        nodes += list(ends[0] + steps * (ends[1] - ends[0]))
    if order == 3 or kind == 70:
        nodes.append(np.mean(nodes[:count], axis=0))
    points = np.pad(np.array(nodes), ((0, 0), (0, 1)))
    size = len(points)
    cells = Cells(np.arange(size), np.array([0, size]), np.array([kind]), np.zeros(1, np.int64))
    field = Field(points, np.ones(1), lambda _: points, cells)
    places = np.array([[0.7, 0.4, 0], [1.1, 0.3, 0]])
    weights, away = element_weights(field, np.arange(1), places)
    np.testing.assert_allclose(weights @ points, places, atol=1e-9)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-9)
    assert away.max() < 1e-9


X, Y, Z = (MOVED[:, k] for k in range(3))
NAMED: dict[str, tuple[Names, dict[str, Array]]] = {
    "DOLFINx": (("uh",), {"uh": MOVED}),
    "Code_Aster": (("DEPL",), {"DEPL": MOVED}),
    "with a unit": (("Displacement [mm]",), {"Displacement [mm]": MOVED}),
    "two": (("U",), {"U": MOVED, "Displacement": 2 * MOVED}),
    "MOOSE": (("disp_x", "disp_y", "disp_z"), {"disp_x": X, "disp_y": Y, "disp_z": Z}),
    "of a plane": (("disp_x", "disp_y"), {"disp_x": X, "disp_y": Y}),
    "of two components": (("f",), {"f": MOVED[:, :2]}),
}


@pytest.mark.parametrize(("names", "arrays"), NAMED.values(), ids=NAMED)
def test_arrays_that_are_named(tmp_path: Path, names: Names, arrays: dict[str, Array]) -> None:
    path = grid(tmp_path, arrays)
    np.testing.assert_array_equal(read_field(path, arrays=names).values(0), MOVED)
    with pytest.raises(CaseError, match="its name as 'arrays' of the load, found") as caught:
        read_field(path)
    assert all(repr(name) in str(caught.value) for name in arrays)


@pytest.mark.parametrize(
    ("names", "quantity", "expected"),
    [
        (("V",), "displacements", "found none called 'V': 'U', 'T'"),
        (("T",), "displacements", "expected a vector, or a number for each axis, at the nodes"),
        (("U", "T"), "displacements", "found arrays of 3, 1 components"),
        (("U",), "temperatures", "expected a number at the nodes, found arrays of 3 components"),
    ],
)
def test_arrays_that_do_not_fit(
    tmp_path: Path, names: Names, quantity: Quantity, expected: str
) -> None:
    path = grid(tmp_path, {"U": MOVED, "T": X})
    assert read_field(path, "temperatures", ("T",)).values(0)[:, 0].tolist() == X.tolist()
    with pytest.raises(CaseError, match=expected):
        read_field(path, quantity, names)


def test_tables_have_no_arrays_to_name(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("x,y,ux,uy\n0,0,1,1\n1,0,1,1\n0,1,1,1\n")
    read_field(path)
    with pytest.raises(CaseError, match="no 'arrays' but of a file that VTK reads, found 'U'"):
        read_field(path, arrays=("U",))
