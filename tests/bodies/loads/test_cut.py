# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields of other runs: read, interpolated to a cut, reduced in time; files that are refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from cases import blocks
from cases.pad_cases import pad, press

from fretfe._typing import Array
from fretfe.bodies.definition import define_model, require_possible
from fretfe.bodies.loads import cut as bodies_cut
from fretfe.bodies.loads.cut import Asked, Cut, read_cuts, read_temperatures, reduce_in_time
from fretfe.bodies.loads.motion import read_all_cuts
from fretfe.case import Case, parse_case
from fretfe.case.loads import FieldLoad, TemperatureFieldLoad
from fretfe.errors import CaseError, FretfeError
from fretfe.fields.field import Field, read_field
from fretfe.loads import build_history, csv_file
from fretfe.mesh.mesh import Mesh
from fretfe.results.field_files import FieldWriter

pyvista = pytest.importorskip("pyvista")


@pytest.fixture(autouse=True)
def _here(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Read files in this process, which is faster, unless they are to break it."""
    if request.function is not test_broken_grids:
        monkeypatch.setattr(bodies_cut, "arrays_of", lambda work, path: work(lambda *_: None))


RANDOM = np.random.default_rng(3)
RAMP = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
TIMES = (0.5, 1.0, 2.5)
# Places of a cut inside of the unit square or cube.
INSIDE = 0.1 + 0.8 * RANDOM.random((7, 3))


def linear(points: Array, time: float = 1.0) -> Array:
    """(n, 3) a displacement that every element follows."""
    slopes = np.array([[0.1, 0.3, 0.2], [-0.2, 0.5, 0.1], [0.4, -0.1, 0.3]])
    return np.asarray(time * (points @ slopes + np.array([1.0, 2.0, 3.0])))


def field_load(file: str = "run", **keys: Any) -> FieldLoad:
    data = {"type": "field", "boundary": "b", "file": file, "history": RAMP, **keys}
    return FieldLoad.model_validate(data)


def cut(path: Path, places: Array, **keys: Any) -> Cut:
    return read_cuts(path, [Asked("cut", field_load(**keys), "upper", places)])["cut"]


def displacement(found: Cut, position: float) -> Array:
    """(m, d) at a position."""
    amplitudes = [course.at(np.array([position]))[0] for course in found.courses]
    return np.asarray(np.einsum("r,rmd->md", amplitudes, found.shapes))


def write_csv(path: Path, points: Array, dimension: int, times: tuple[float, ...] = TIMES) -> None:
    axes = "xyz"[:dimension]
    names = [*axes, *(f"u{axis}" for axis in axes), "time"]
    rows = [
        ",".join(f"{v:.17g}" for v in [*point[:dimension], *moved[:dimension], time])
        for time in times
        for point, moved in zip(points, linear(points, time), strict=True)
    ]
    path.write_text("\n".join(["# a run", ",".join(names), *rows]) + "\n")


@pytest.mark.parametrize("dimension", [2, 3])
def test_points_of_a_table(tmp_path: Path, dimension: int) -> None:
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 6)] * dimension), axis=-1)
    points = np.pad(grid.reshape(-1, dimension), ((0, 0), (0, 3 - dimension)))
    write_csv(tmp_path / "run.csv", points, dimension)
    places = INSIDE * (np.arange(3) < dimension)
    found = cut(tmp_path / "run.csv", places[:, :dimension])
    assert (len(found.shapes), found.rest < 1e-10) == (1, True)
    for time in (0.0, 0.2, 0.5, 1.75, 2.5):
        expected = linear(places, time)[:, :dimension]
        np.testing.assert_allclose(displacement(found, time), expected, atol=1e-12)
    numbered = cut(tmp_path / "run.csv", places[:, :dimension], position="number")
    np.testing.assert_array_equal(numbered.positions, [1, 2, 3])


def test_other_units(tmp_path: Path) -> None:
    points = np.pad(RANDOM.random((200, 2)), ((0, 0), (0, 1)))
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
    write_csv(tmp_path / "run.csv", np.concatenate([points, corners]), 2)
    places = INSIDE * [1, 1, 0]
    found = cut(tmp_path / "run.csv", 1000 * places[:, :2], factor=1000.0)
    np.testing.assert_allclose(displacement(found, 1.0), 1000 * linear(places)[:, :2], rtol=1e-9)
    for far, told in ((1000 * places, True), (2 * places, False)):
        with pytest.raises(CaseError, match=r"run\.csv: expected points around all no") as caught:
            cut(tmp_path / "run.csv", far[:, :2])
        assert str(caught.value).endswith("; are its coordinates in another unit (factor)?") == told


def test_anisotropic_points_are_found_far_away(tmp_path: Path) -> None:
    x, y = np.meshgrid(np.linspace(0, 1, 3), np.linspace(0, 1, 400))
    write_csv(tmp_path / "run.csv", np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), 2)
    places = np.array([[0.25, 0.5, 0], [0.25, 0.501, 0]])
    found = cut(tmp_path / "run.csv", places[:, :2])
    np.testing.assert_allclose(displacement(found, 1.0), linear(places)[:, :2], rtol=1e-9)


def test_points_with_a_hole_around_the_cut(tmp_path: Path) -> None:
    """Rows of long cells are none; a metre for a millimetre is one."""
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(-4, 4, 21)] * 2))
    points = np.stack([x, y, 0 * x], axis=1)[np.hypot(x, y) > 3]
    write_csv(tmp_path / "run.csv", points, 2)
    expected = r"at \(0, 1\) in a hole: the nearest point is 2\..* away, where .* 0\.566 apart"
    with pytest.raises(CaseError, match=expected):
        cut(tmp_path / "run.csv", np.array([[0.0, 1.0], [0.0, 3.1]]))
    with pytest.raises(CaseError, match="in a hole"):
        cut(tmp_path / "run.csv", np.array([[0.0, 3.5], [3.5, 0.0]]), factor=1000.0)
    cut(tmp_path / "run.csv", np.array([[0.0, 3.5], [3.5, 0.1]]))


def test_a_part_of_a_table_is_refused(tmp_path: Path) -> None:
    """Its points are of no part: the key would be passed over."""
    write_csv(tmp_path / "run.csv", np.pad(RANDOM.random((50, 2)), ((0, 0), (0, 1))), 2)
    with pytest.raises(CaseError, match=r"run\.csv: expected no 'part' .* found 'blade'"):
        cut(tmp_path / "run.csv", np.full((3, 2), 0.5), part="blade")


def test_loads_take_other_arrays_of_one_file(tmp_path: Path) -> None:
    points = np.array([[x, y, 0.0] for y in (-1, 2) for x in (-1, 2)])
    grid = pyvista.UnstructuredGrid(np.array([4, 0, 1, 3, 2]), np.array([9]), points)
    for name, factor in (("uh", 1.0), ("vh", 2.0)):
        grid.point_data[name] = factor * linear(points)
    grid.save(tmp_path / "run.vtu")
    data = driven(tmp_path, RAMP).model_dump(mode="json", exclude_unset=True)
    load = data["loads"].pop("cut") | {"file": "run.vtu"}
    for name, side in (("uh", "upper_right"), ("vh", "lower_right")):
        data["loads"][name] = {**load, "boundary": side, "arrays": [name]}
    case = parse_case(data, tmp_path / "case.toml")
    cuts = read_all_cuts(case, mesh())
    for name, factor in (("uh", 1.0), ("vh", 2.0)):
        asked, found = cuts[name]
        places = np.pad(asked.places, ((0, 0), (0, 1)))
        expected = factor * linear(places)[:, :2]
        np.testing.assert_allclose(displacement(found, 1.0), expected, rtol=1e-6)


def test_missing_files_are_named(tmp_path: Path) -> None:
    case = driven(tmp_path, RAMP)
    (tmp_path / "run.csv").unlink()
    with pytest.raises(CaseError, match=r"loads\.cut\.file: .*run\.csv: expected a file with dis"):
        define_model(case, mesh())


def test_gaps_between_numbers_of_steps(tmp_path: Path) -> None:
    """A history stays at the steps that there are, of times linear in between."""
    history = [{"times": [1, 2, 3], "values": [1, 2, 3]}]
    case = driven(tmp_path, history)
    text = (tmp_path / "run.csv").read_text()
    lines = [each for each in text.splitlines() if not each.endswith(",1")]
    lines = [re.sub(r",2\.5$", ",3", re.sub(r",0\.5$", ",1", each)) for each in lines]
    (tmp_path / "run.csv").write_text("\n".join(lines))
    require_possible(case, define_model(case, mesh()), build_history(case))
    (tmp_path / "run.csv").write_text("\n".join(lines).replace("time", "step"))
    definition = define_model(case, mesh())
    with pytest.raises(CaseError, match=r"found 2 at time 2, between 1 and 3 \(steps: 1, 3\)"):
        require_possible(case, definition, build_history(case))


def grid_of(kind: str) -> Any:
    cube = pyvista.ImageData(dimensions=(5, 5, 5), spacing=(0.25, 0.25, 0.25))
    grid = {
        "hexahedra": lambda: cube.cast_to_unstructured_grid(),
        "tetrahedra": lambda: cube.to_tetrahedra(),
        "square": lambda: pyvista.ImageData(
            dimensions=(5, 5, 1), spacing=(0.25, 0.25, 0.25)
        ).cast_to_unstructured_grid(),
    }[kind]()
    return grid


@pytest.mark.parametrize("ending", [".vtu", ".vtk"])
@pytest.mark.parametrize("kind", ["hexahedra", "tetrahedra", "square"])
def test_elements_of_a_grid(tmp_path: Path, kind: str, ending: str) -> None:
    grid = grid_of(kind)
    grid.point_data["U"] = linear(np.asarray(grid.points, dtype=float))
    grid.point_data["S"] = np.zeros((grid.n_points, 6))
    path = tmp_path / f"run{ending}"
    grid.save(path)
    dimension = 2 if kind == "square" else 3
    # corners and sides of elements as well
    places = np.concatenate([INSIDE, [[0.0, 1.0, 1.0], [1.0, 0.3, 0.25]]])
    places = places * (np.arange(3) < dimension)
    found = cut(path, places[:, :dimension])
    np.testing.assert_allclose(found.positions, [1.0])
    expected = linear(places)[:, :dimension]
    np.testing.assert_allclose(displacement(found, 1.0), expected, atol=1e-6)
    outside = places.copy()
    outside[3, 0] = 1.1
    with pytest.raises(CaseError, match=r"expected elements at all nodes, found the no"):
        cut(path, outside[:, :dimension])


SLIP = np.array([0.3, -0.2, 0.1])


@pytest.mark.parametrize("halves", [False, True])
def test_bodies_that_touch_keep_their_own_displacements(tmp_path: Path, *, halves: bool) -> None:
    """The file does not say which elements are whose; the lower body may be in two pieces."""
    lower = [grid_of("tetrahedra")]
    if halves:
        left = lower[0].cell_centers().points[:, 0] < 0.5
        lower = [lower[0].extract_cells(np.flatnonzero(side)) for side in (left, ~left)]
    upper = grid_of("tetrahedra").translate((0.0, 0.0, 1.0))
    for grid, slip in ((upper, SLIP), *((each, 0 * SLIP) for each in lower)):
        grid.point_data["U"] = linear(np.asarray(grid.points, dtype=float)) + slip
    pyvista.merge([*lower, upper], merge_points=False).save(tmp_path / "run.vtu")
    # nodes of the contact, the last of which is in the other body by a hundredth of an element
    touching = [[0.0, 0.0, 0.0], [0.3, 0.4, 0.0], [1.0, 1.0, 0.0], [0.6, 0.2, -0.003]]
    for side, slip in ((1.0, SLIP), (-1.0, 0 * SLIP)):
        places = np.concatenate([INSIDE, touching]) * [1.0, 1.0, side] + [0.0, 0.0, 1.0]
        off = displacement(cut(tmp_path / "run.vtu", places), 1.0) - linear(places) - slip
        assert np.abs(off[:-1]).max() < 1e-6
        assert np.abs(off[-1]).max() < 0.005


@pytest.mark.parametrize("name", ["solids.frd", "solids_binary.frd"])
def test_a_run_of_calculix(name: str) -> None:
    """The first element grows freely from its corner at the origin, by 1e-3 and then 2e-3."""
    places = np.array([[0.3, 0.2, 0.9], [0.7, 0.5, 0.1], [0.1, 0.9, 0.4]])
    found = cut(Path(__file__).parents[2] / "data" / name, places)
    for position, growth in ((0.5, 0.5e-3), (1.0, 1e-3), (1.5, 2e-3)):
        np.testing.assert_allclose(displacement(found, position), growth * places, rtol=2e-5)


def test_steps_of_a_series(tmp_path: Path) -> None:
    grid = grid_of("hexahedra")
    entries = []
    for number, time in enumerate(TIMES):
        grid.point_data["displacement"] = linear(np.asarray(grid.points, dtype=float), time)
        grid.save(tmp_path / f"run{number}.vtu")
        entries.append(f'<DataSet timestep="{time}" part="0" file="run{number}.vtu"/>')
    head = '<?xml version="1.0"?><VTKFile type="Collection" version="0.1"><Collection>'
    text = "".join([head, *entries, "</Collection></VTKFile>"])
    (tmp_path / "run.pvd").write_text(text)
    found = cut(tmp_path / "run.pvd", INSIDE)
    np.testing.assert_allclose(found.positions, TIMES)
    np.testing.assert_allclose(displacement(found, 2.5), linear(INSIDE, 2.5), atol=1e-5)


def write_results(folder: Path) -> None:
    """Two bodies of quadratic elements, side by side; the second one moves twice as far."""
    nodes = {}
    for number, name in enumerate(("upper", "other")):
        body = blocks.block(name, np.linspace(0, 1, 4) + number, np.linspace(0, 1, 4), order=2)
        nodes[name] = body.points[body.cells]
    writer = FieldWriter(folder / "fields.hdf", nodes)
    for time in (0.0, *TIMES):
        moved = []
        for factor, places in zip((1, 2), nodes.values(), strict=True):
            flat = np.pad(places.reshape(-1, 2), ((0, 0), (0, 1)))
            moved.append(factor * linear(flat, time).reshape(*places.shape[:2], 3)[..., :2])
        stress = [np.zeros((*places.shape[:2], 6)) for places in nodes.values()]
        writer.add(time, {"displacement": moved, "stress": stress})
    writer.close()


def test_a_results_folder(tmp_path: Path) -> None:
    write_results(tmp_path)
    places = INSIDE * [1, 1, 0]
    found = cut(tmp_path, places[:, :2])
    np.testing.assert_allclose(found.positions, TIMES)
    assert len(found.shapes) == 1 and found.rest < 1e-7
    expected = linear(places, 2.5)[:, :2]
    np.testing.assert_allclose(displacement(found, 2.5), expected, rtol=1e-6)
    beside = places + np.array([1.0, 0.0, 0.0])
    other = cut(tmp_path, beside[:, :2], part="other")
    np.testing.assert_allclose(displacement(other, 1.0), 2 * linear(beside)[:, :2], rtol=1e-6)
    with pytest.raises(CaseError, match="expected elements at all nodes"):
        cut(tmp_path, beside[:, :2])
    with pytest.raises(
        CaseError, match="expected one of its parts 'upper', 'other', found 'blade'"
    ):
        cut(tmp_path, places[:, :2], part="blade")


@pytest.mark.parametrize("rounding", [0.0, 1e-8])
def test_a_long_mission_has_few_shapes(rounding: float) -> None:
    """A field of a few loads and of contacts that change a little, in single precision too."""
    time = np.linspace(0, 1, 500)
    courses = np.stack([np.sin(2 * np.pi * (k + 1) * time) * 10.0**-k for k in range(9)])
    moved = np.einsum("kt,kmd->tmd", courses, RANDOM.standard_normal((9, 300, 3)))
    noisy = moved * (1 + rounding * RANDOM.standard_normal(moved.shape))
    found = reduce_in_time("cut", np.arange(1.0, 501), noisy)
    assert len(found.shapes) == (20 if rounding else 9)
    assert found.rest < (1e-6 if rounding else 1e-10)
    known = reduce_in_time("cut", np.arange(1.0, 501), noisy, rounding)
    assert len(known.shapes) == 9
    for step in (3, 250, 499):
        expected = moved[step]
        np.testing.assert_allclose(
            displacement(found, step + 1.0), expected, atol=1e-7 if rounding else 1e-9
        )


def test_few_digits_do_not_become_shapes(tmp_path: Path) -> None:
    """A table of six digits: what they round off is left out, and no field of the run is."""
    time = np.arange(1.0, 61)
    courses = np.stack([np.sin(2 * np.pi * (k + 1) * time / 60) * 10.0**-k for k in range(4)])
    points = np.stack([each.ravel() for each in np.meshgrid(*[np.linspace(0, 1, 9)] * 2)], axis=1)
    moved = np.einsum("kt,knd->tnd", courses, RANDOM.standard_normal((4, len(points), 2)))
    rows = [
        f"{number:g},{x:.17g},{y:.17g},{u:.5e},{v:.5e}"
        for number, step in zip(time, moved, strict=True)
        for (x, y), (u, v) in zip(points, step, strict=True)
    ]
    (tmp_path / "run.csv").write_text("\n".join(["step,x,y,ux,uy", *rows]) + "\n")
    found = cut(tmp_path / "run.csv", points)
    assert len(found.shapes) == 4 and found.rest < 5e-6
    scale = np.abs(moved).max()
    for step in (0, 29, 59):
        assert np.abs(displacement(found, step + 1.0) - moved[step]).max() < 5e-6 * scale


BAD_TABLES = {
    "no column": ("x,y,ux\n0,0,1\n", "line 1: expected one column 'uy'"),
    "z alone": ("x,y,z,ux,uy\n0,0,0,1,1\n", "expected both or none of the columns 'z' and 'uz'"),
    "two clocks": ("x,y,ux,uy,time,step\n0,0,1,1,1,1\n", "one of the columns 'time' and 'step'"),
    "nan": ("x,y,ux,uy\n0,0,1,nan\n", "line 2, column 'uy': expected a finite number"),
    "one point": ("x,y,ux,uy\n0,0,1,1\n", "expected at least 2 points, found 1"),
    "twice": ("x,y,ux,uy\n0,0,1,1\n0,0,1,2\n", "line 3, column 'x': expected a point of its own"),
    "other points": (
        "x,y,ux,uy,step\n0,0,1,1,1\n1,1,1,1,1\n0,0,1,1,2\n",
        "expected the same points in every step, found others at 2 than at 1",
    ),
    "before 0": ("x,y,ux,uy,time\n0,0,1,1,-1\n", "expected times of steps that are not negative"),
    "on a line": ("x,y,ux,uy\n0,0,1,1\n1,0,1,2\n", "found the node at"),
    "elsewhere": (
        "x,y,ux,uy\n5,5,1,1\n6,5,1,2\n6,6,1,1\n",
        "expected points around all nodes, found the node at (0.",
    ),
    "at time 0": (
        "x,y,ux,uy,time\n0,0,1,1,0\n1,0,1,2,0\n0,1,1,1,0\n1,1,1,1,0\n",
        "expected no displacement at time 0, the unloaded state, found",
    ),
    "only 0": (
        "x,y,ux,uy,time\n0,0,0,0,1\n1,0,0,0,1\n0,1,0,0,1\n1,1,0,0,1\n",
        "found none but 0: hold a boundary at rest by a support instead",
    ),
}


@pytest.mark.parametrize(("text", "expected"), BAD_TABLES.values(), ids=BAD_TABLES)
def test_bad_tables(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "run.csv").write_text(text)
    with pytest.raises(CaseError, match=re.escape(expected)):
        cut(tmp_path / "run.csv", INSIDE[:, :2])


def test_bad_grids(tmp_path: Path) -> None:
    grid = grid_of("hexahedra")
    path = tmp_path / "run.vtu"
    grid.point_data["temperature"] = np.zeros(grid.n_points)
    grid.save(path)
    with pytest.raises(CaseError, match="expected one vector at the nodes that is called one of"):
        cut(path, INSIDE)
    grid.point_data["U"] = np.where(np.arange(3) == 1, np.nan, linear(grid.points))
    grid.save(path)
    with pytest.raises(CaseError, match=r"expected finite displacements, found others near .* 1$"):
        cut(path, INSIDE)


def test_broken_grids(tmp_path: Path) -> None:
    """In the process that reads them, whatever VTK does with them."""
    path = tmp_path / "run.vtu"
    grid_of("square").save(path)
    data = path.read_bytes()
    for broken in (data[: len(data) // 2], bytes(500)):
        path.write_bytes(broken)
        with pytest.raises(FretfeError, match=r"run\.vtu"):
            cut(path, INSIDE)


def test_bad_results(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"expected a file with displacements, or a results folder"):
        read_field(tmp_path)
    with pytest.raises(CaseError, match=r"whose name ends in one of \.csv, "):
        (tmp_path / "run.odb").write_text("")
        read_field(tmp_path / "run.odb")
    write_results(tmp_path)
    with h5py.File(tmp_path / "fields.hdf", "r+") as file:
        file["VTKHDF/Points"][3] = np.nan
    with pytest.raises(CaseError, match="expected finite coordinates"):
        cut(tmp_path, INSIDE[:, :2])


def mesh() -> Mesh:
    upper = blocks.block("upper", [0, 0.5, 1], [0, 1])
    return Mesh({"upper": upper, "lower": blocks.block("lower", [0, 1, 2], [-1, 0])})


def driven(folder: Path, history: list[dict[str, Any]], **keys: Any) -> Case:
    """The right side of the upper body of `mesh` is driven by run.csv."""
    points = np.array([[x, y, 0] for x in (-1, 2) for y in (-1, 2.0)])
    write_csv(folder / "run.csv", points, 2)
    own = {"type": "field", "boundary": "upper_right", "file": "run.csv", "history": history}
    data = pad(loads={"press": press(), "cut": {**own, **keys}})
    contact = {**data["contacts"]["main"], "surface1": "upper_bottom", "surface2": "lower_top"}
    return parse_case({**data, "contacts": {"main": contact}}, folder / "case.toml")


HISTORIES: dict[str, tuple[list[dict[str, Any]], str]] = {
    "all steps": ([{"times": [1, 2, 3], "values": TIMES}], ""),
    "within": ([{"times": [1, 2, 3, 4], "values": [0.2, 0.5, 0.9, 0.7]}], ""),
    "beyond": (
        [{"times": [1, 2, 3, 4], "values": [0.5, 1, 2.5, 3]}],
        "loads.cut.history: expected positions in the run, from 0 (unloaded) to 2.5 (its last step)"
        ", found 3 at time 4",
    ),
    "before": ([{"times": [1], "values": [-0.1]}], "to 2.5 (its last step), found -0.025 at"),
    "missing": (
        [{"times": [1, 2], "values": [0.5, 2.5]}],
        "loads.cut.history: expected a load step at every step of the run, found none at 1, between"
        " 0.5 at time 1 and 2.5 at time 2",
    ),
}


@pytest.mark.parametrize(("history", "expected"), HISTORIES.values(), ids=HISTORIES)
def test_histories(tmp_path: Path, history: list[dict[str, Any]], expected: str) -> None:
    case = driven(tmp_path, history)
    definition = define_model(case, mesh())
    note, doubt = definition.cuts[0].notes
    assert doubt.startswith("loads.cut: the displacements change the shape of the cut by 1.")
    assert note.startswith("loads.cut: 3 steps of the run, up to 2.5, as 1 shape; ")
    if not expected:
        require_possible(case, definition, build_history(case))
        return
    with pytest.raises(CaseError, match=re.escape(expected)):
        require_possible(case, definition, build_history(case))


def test_messages_name_the_load(tmp_path: Path) -> None:
    case = driven(tmp_path, RAMP, part="blade")
    (tmp_path / "run.csv").write_text("x,y,ux\n")
    with pytest.raises(CaseError, match=r"case\.toml: loads\.cut\.file: .*run\.csv: line 1: expec"):
        define_model(case, mesh())


def test_loads_of_one_file_read_it_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each with its own places and factor."""
    points = np.array([[x, y, 0.0] for x in (0, 0.4, 1) for y in (0, 0.7, 1)])
    write_csv(tmp_path / "run.csv", points, 2)
    files = []

    def read(work: Any, path: Path) -> Any:
        files.append(path)
        return work(lambda *_: None)

    monkeypatch.setattr(bodies_cut, "arrays_of", read)
    one, other = INSIDE[:4, :2], INSIDE[4:, :2]
    metres = field_load(factor=1000.0)
    asked = [
        Asked("one", field_load(), "upper", one),
        Asked("other", metres, "lower", 1000 * other),
    ]
    found = read_cuts(tmp_path / "run.csv", asked)
    assert files == [tmp_path / "run.csv"]
    for name, places, factor in (("one", one, 1.0), ("other", other, 1000.0)):
        expected = factor * linear(np.pad(places, [(0, 0), (0, 1)]))[:, :2]
        np.testing.assert_allclose(displacement(found[name], 1.0), expected, rtol=1e-9)


@pytest.mark.parametrize("names", [("far", "near"), ("near", "far")])
def test_of_loads_of_one_file_that_which_fails_is_named(
    tmp_path: Path, names: tuple[str, str]
) -> None:
    """The table reaches as far as the upper body, and not to the right side of the lower one."""
    data = driven(tmp_path, RAMP).model_dump(mode="json", exclude_unset=True)
    points = np.array([[x, y, 0] for x in (-1, 1.5) for y in (-1, 2.0)])
    write_csv(tmp_path / "run.csv", points, 2)
    load = data["loads"].pop("cut")
    for name in names:
        side = {"far": "lower_right", "near": "upper_right"}[name]
        data["loads"][name] = {**load, "boundary": side}
    case = parse_case(data, tmp_path / "case.toml")
    with pytest.raises(CaseError, match=r"loads\.far\.file: .*expected points around all nodes"):
        define_model(case, mesh())


def test_large_tables_are_the_same_read_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.csv"
    write_csv(path, RANDOM.random((50, 3)), 3)
    names = ("x", "uz", "time")
    slow = csv_file.read_table(path, names, ("none",))
    monkeypatch.setattr(csv_file, "LARGE", 0)
    fast = csv_file.read_table(path, names, ("none",))
    assert isinstance(fast.lines, range) and list(slow.lines) == list(fast.lines)
    assert list(slow.columns) == list(fast.columns)
    for name, column in slow.columns.items():
        np.testing.assert_array_equal(fast.columns[name], column)
    text = path.read_text()
    for wrong, expected in (
        (text.replace("\n0.", "\n\n0.", 1), None),
        (text + "1,2,3\n", "line 153, column 'uz': expected a finite number, found an empty"),
        (text + "1,2,3,4,5,6,7,8\n", "line 153: expected at most 7 cells"),
        (text + "1,2,3,4,5,6,nan\n", "line 153, column 'time': expected a finite number, found 'n"),
        (text + "1,2,3,4,5,6,1e-320\n", "line 153, column 'time': expected 0, or a number of"),
    ):
        path.write_text(wrong)
        if expected is None:
            assert len(csv_file.read_table(path, names).lines) == len(slow.lines)
            continue
        with pytest.raises(CaseError, match=re.escape(expected)):
            csv_file.read_table(path, names)


def heat(points: Array, time: float) -> Array:
    """(n,) a temperature that every element follows; 20 at time 0."""
    return np.asarray(20 + time * (30 + points @ [100.0, -50.0, 10.0]))


def heated(path: Path, places: Array, **keys: Any) -> Cut:
    data = {"type": "temperature_field", "file": "run", "history": RAMP, **keys}
    load = TemperatureFieldLoad.model_validate(data)
    return read_temperatures(path, load, "heat", {"upper": places}, np.full(len(places), 20.0))


def write_temperatures(path: Path, times: tuple[float, ...] = TIMES) -> None:
    """In the unit cube, of the kind that the name of the file tells."""
    grid = grid_of("hexahedra")
    points = np.asarray(grid.points, dtype=float)
    if path.suffix == ".csv":
        rows = [
            f"{time},{x},{y},{z},{value:.17g}"
            for time in times
            for (x, y, z), value in zip(points, heat(points, time), strict=True)
        ]
        path.write_text("\n".join(["time,x,y,z,T", *rows]) + "\n")
        return
    entries = []
    for number, time in enumerate(times):
        grid.point_data["NT11"] = heat(points, time)
        grid.save(path.parent / f"{number}.vtu")
        entries.append(f'<DataSet timestep="{time}" part="0" file="{number}.vtu"/>')
    head = '<?xml version="1.0"?><VTKFile type="Collection" version="0.1"><Collection>'
    path.write_text("".join([head, *entries, "</Collection></VTKFile>"]))


@pytest.mark.parametrize("name", ["run.csv", "run.pvd"])
def test_temperatures(tmp_path: Path, name: str) -> None:
    write_temperatures(tmp_path / name)
    found = heated(tmp_path / name, INSIDE)
    (note,) = found.notes
    assert len(found.shapes) == 1 and "of the changes of temperature is left out" in note
    for time in (0.0, 0.3, 2.5):
        expected = heat(INSIDE, time)[:, None] - 20
        np.testing.assert_allclose(displacement(found, time), expected, atol=1e-9 * 200)
    with pytest.raises(CaseError, match=r"expected (one column 'ux'|one vector at the nodes)"):
        cut(tmp_path / name, INSIDE)


def test_temperatures_of_calculix() -> None:
    path = Path(__file__).parents[2] / "data" / "solids.frd"
    found = heated(path, np.array([[0.3, 0.2, 0.9], [0.7, 0.5, 0.1]]))
    for position, change in ((0.5, 50.0), (1.0, 100.0), (1.5, 200.0)):
        np.testing.assert_allclose(displacement(found, position), change, rtol=1e-9)


BAD_TEMPERATURES = {
    "too cold": (
        "x,y,T\n0,0,-300\n1,0,-300\n0,1,-300\n1,1,-300\n",
        "expected temperatures >= -273.15",
    ),
    "reference": ("x,y,T\n0,0,20\n1,0,20\n0,1,20\n1,1,20\n", "a change of temperature in some"),
    "nan": ("x,y,T\n0,0,nan\n", "line 2, column 'T': expected a finite number"),
    "elsewhere": ("x,y,T\n5,5,1\n6,5,1\n6,6,1\n", "expected points around all nodes, found the"),
    "hot at time 0": (
        "x,y,T,time\n0,0,50,0\n1,0,50,0\n0,1,50,0\n1,1,50,0\n",
        "expected no change of temperature at time 0, the unloaded state, found 30: count",
    ),
    "a displacement": ("x,y,ux,uy\n0,0,1,1\n", "line 1: expected one column 'T'"),
}


@pytest.mark.parametrize(("text", "expected"), BAD_TEMPERATURES.values(), ids=BAD_TEMPERATURES)
def test_bad_temperatures(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "run.csv").write_text(text)
    with pytest.raises(CaseError, match=re.escape(expected)):
        heated(tmp_path / "run.csv", INSIDE[:, :2])
    with pytest.raises(CaseError, match="expected temperatures, found a run that has displacem"):
        write_results(tmp_path)
        heated(tmp_path, INSIDE[:, :2])


def test_a_plane_field_may_lie_at_any_height(tmp_path: Path) -> None:
    """A plane mesh at z = 5 is moved to z = 0, and so is the field of the run that it is of."""
    points = np.array([[0.0, 0.0, 5.0], [1.0, 0.0, 5.0]])
    field = Field(points, np.array([1.0]), lambda _: np.zeros((2, 3)))
    moved = bodies_cut._in_plane(tmp_path, "displacements", field)
    assert moved.points.tolist() == [[0, 0, 0], [1, 0, 0]]
    thick = Field(points * [[1, 1, 1], [1, 1, -1]], field.times, field.values)
    with pytest.raises(CaseError, match=r"points from z = -5 to 5.*OUTPUT=2D"):
        bodies_cut._in_plane(tmp_path, "displacements", thick)
