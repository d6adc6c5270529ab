# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parts of meshes, and cases of parts of solved ones, driven by the run of the whole."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks

from fretfe.case import changed, load_case, parse_case
from fretfe.case.loads import FieldLoad
from fretfe.case.tables import Part
from fretfe.cli.exchange import submodel
from fretfe.errors import CaseError, MeshError, OutputError
from fretfe.exchange.submodel import told, write_submodel
from fretfe.loads import build_history
from fretfe.mesh.elements import facet_measures
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.load import grouped_mesh, made_mesh
from fretfe.mesh.make import write_mesh
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.part import distances, part_of, seen
from fretfe.quality.companions import CUT, companion_rows, make_variants
from fretfe.quality.global_run import (
    carried,
    carried_notes,
    carried_rows,
    cut_tractions,
    followed_notes,
    second_cut,
)
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.runner import Runner

LINES = np.linspace(-2.0, 2.0, 17)


def two_blocks(order: int = 2) -> Mesh:
    """A block on another one, each with 16 by 8 cells."""
    upper = blocks.block("upper", LINES, np.linspace(0, 2, 9), order=order)
    return Mesh({"upper": upper, "lower": blocks.block("lower", LINES, LINES[:9], order=order)})


SURFACES = ("upper_bottom", "lower_top")


@pytest.mark.parametrize("order", [1, 2])
def test_a_part_has_the_cells_within(order: int) -> None:
    whole = two_blocks(order)
    part = Part(centre=(0.25, 0.0), radius=1.04)
    found = part_of(whole, part, SURFACES)
    assert list(found.bodies) == ["upper", "lower"]
    for name, body in found.bodies.items():
        before = whole.bodies[name]
        inside = (distances(part, before.points) <= 1.04)[before.cells].all(axis=1)
        assert len(body.cells) == np.count_nonzero(inside)
        np.testing.assert_allclose(
            np.sort(body.points[body.cells].mean(axis=1), axis=0),
            np.sort(before.points[before.cells[inside]].mean(axis=1), axis=0),
        )
        surface, cut = (body.boundaries[each] for each in (
            {"upper": "upper_bottom", "lower": "lower_top"}[name], f"{name}_cut"
        ))  # fmt: skip
        assert set(body.boundaries) == {
            {"upper": "upper_bottom", "lower": "lower_top"}[name],
            f"{name}_cut",
        }
        # From end to end of the surface, and the cut goes round the rest: the outside is closed.
        assert facet_measures(body.points, surface).sum() == pytest.approx(2.0)
        ends = np.concatenate([surface[:, :2], cut[:, :2]])
        assert (np.bincount(ends.ravel(), minlength=1)[np.unique(ends)] == 2).all()


def test_pieces_without_contact_and_bodies_without_pieces_are_left_out() -> None:
    whole = two_blocks()
    away = blocks.block("away", LINES[:5] + 0.5, np.linspace(-3, -2.25, 4), order=2)
    # The upper body a second time, apart from the first one: a piece of the same body.
    upper = whole.bodies["upper"]
    count = len(upper.points)
    double = replace(
        upper,
        points=np.concatenate([upper.points, upper.points + np.array([0.0, 2.25])]),
        cells=np.concatenate([upper.cells, upper.cells + count]),
    )
    mesh = Mesh({"upper": double, "lower": whole.bodies["lower"], "away": away})
    found = part_of(mesh, Part(centre=(0.0, 0.0), radius=4.0), SURFACES)
    assert list(found.bodies) == ["upper", "lower"]
    assert len(found.bodies["upper"].cells) == len(upper.cells)
    assert found.bodies["upper"].pieces == 1
    # A whole body stays as it is.
    assert found.bodies["lower"] is mesh.bodies["lower"]


def test_a_part_of_nothing() -> None:
    with pytest.raises(
        MeshError, match=r"found none within 0\.3; the nearest node of these surfac"
    ):
        part_of(two_blocks(), Part(centre=(0.0, 1.0), radius=0.3), SURFACES)


def test_a_boundary_with_the_name_of_a_cut() -> None:
    mesh = two_blocks()
    body = mesh.bodies["upper"]
    body.boundaries["upper_cut"] = body.boundaries["upper_top"]
    part = Part(centre=(0.0, 0.0), radius=1.5)
    assert "upper_cut" in part_of(mesh, part, SURFACES).bodies["upper"].boundaries
    body.boundaries["upper_cut"] = body.boundaries["upper_bottom"]
    with pytest.raises(MeshError, match="expected no boundary called 'upper_cut'"):
        part_of(mesh, part, SURFACES)


def geometry(**keys: Any) -> dict[str, Any]:
    sizes = {"upper_radius": 50, "upper_width": 6, "lower_radius": 0, "lower_width": 6}
    return {"template": "cylinder", "parameters": {**sizes, "size": 0.05}, **keys}


def tables(**keys: Any) -> dict[str, Any]:
    steel = {"young": 210e3, "poisson": 0.3}
    top = {"type": "platen", "boundary": "upper_top", "control": "force"}
    wave = {"wave": "sine", "amplitude": 60.0, "period": 1.0, "cycles": 2, "steps_per_cycle": 8}
    contact = {"surface1": "upper_contact", "surface2": "lower_contact", "friction": 0.4}
    return {
        "geometry": geometry(),
        "bodies": {"upper": steel, "lower": steel},
        "contacts": {"main": {**contact, "friction_from": 1.0}},
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
        "loads": {
            "press": top
            | {"direction": "y", "history": [{"ramp": -600.0, "until": 1.0, "steps": 2}]},
            "shear": top | {"direction": "x", "history": [{"hold": True, "until": 1.0}, wave]},
        },
        "output": {"fields": "all"},
        **keys,
    }


@pytest.mark.parametrize("skew", [0.0, 20.0])
def test_extruded_parts_lean_with_their_bodies(skew: float) -> None:
    part = {"centre": [0.0, 0.0], "radius": 1.5}
    solid = {"length": 2.0, "skew": skew, "layers": 6}
    bare = {key: value for key, value in tables().items() if key not in ("supports", "loads")}
    case = parse_case({**bare, "geometry": geometry(solid=solid, part=part)})
    mesh = grouped_mesh(case)
    plane = made_mesh(parse_case({**bare, "geometry": geometry(part=part)}))
    assert case.geometry.solid is not None
    expected = extrude(plane, case.geometry.solid)
    for name, body in mesh.bodies.items():
        np.testing.assert_array_equal(body.points, expected.bodies[name].points)
        assert np.linalg.norm(seen(case, body.points, 2), axis=1).max() <= 1.5 + 1e-12
        assert len(body.boundaries[f"{name}_cut"])
    top = np.ptp(mesh.bodies["upper"].points[:, 0]) - np.ptp(plane.bodies["upper"].points[:, 0])
    assert top == pytest.approx(2.0 * math.tan(math.radians(skew)))
    ball = {"centre": [0.0, 0.0, 1.0], "radius": 0.9}
    found = made_mesh(parse_case({**bare, "geometry": geometry(solid=solid, part=ball)}))
    # It was cut out of a cylinder, which has all of it.
    whole = extrude(made_mesh(parse_case(bare)), case.geometry.solid)
    expected = part_of(whole, Part.model_validate(ball), ("upper_contact", "lower_contact"))
    for name, body in found.bodies.items():
        twin = expected.bodies[name]
        assert len(body.cells) == len(twin.cells) > 0
        np.testing.assert_allclose(body.points, twin.points, atol=1e-12)
        sizes = {key: len(facets) for key, facets in body.boundaries.items()}
        assert sizes == {key: len(facets) for key, facets in twin.boundaries.items()}


def test_a_ball_in_the_plane() -> None:
    case = parse_case(tables(geometry=geometry(part={"centre": [0.0, 0.0, 0.0], "radius": 1.0})))
    with pytest.raises(CaseError, match=r"geometry\.part\.centre: expected 2 coordinates on this"):
        grouped_mesh(case)


@pytest.fixture(scope="module")
def whole(runner: Runner, tmp_path_factory: pytest.TempPathFactory) -> Result:
    """A pad on a block with coarse elements, 23 over the contact, and its displacements."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    runner.run(parse_case(tables()), folder)
    return load_result(folder)


@pytest.fixture(scope="module")
def part(whole: Result, runner: Runner, tmp_path_factory: pytest.TempPathFactory) -> Result:
    folder = tmp_path_factory.mktemp("part")
    found = write_submodel(whole, "main", folder / "case", radius=2.4, size=0.0125)
    assert found.case.geometry.part is not None and found.case.geometry.part.radius == 2.4
    assert (found.size, found.reach) == (
        ("geometry.parameters.size", 0.0125),
        pytest.approx(0.57, abs=0.03),
    )
    text = "\n".join(told(found, "mm"))
    assert "Outside of the part: support base; loads press, shear" in text
    case = load_case(found.path)
    load = case.loads["upper_cut"]
    assert isinstance(load, FieldLoad) and not Path(load.file).is_absolute()
    result = runner.run(case, folder / "run")
    assert result.failure is None
    return result


def test_each_shape_of_a_cut_is_stored(part: Result) -> None:
    assert part.directory is not None
    stored = load_result(part.directory).solution
    assert stored is not None and stored.drivers == part.solution.drivers
    assert {"upper_cut 1", "upper_cut 2", "lower_cut 1"} <= set(stored.drivers)
    np.testing.assert_array_equal(stored.driver_values, part.solution.driver_values)


def test_a_part_carries_what_the_whole_carries(whole: Result, part: Result) -> None:
    """Half-planes: K_N = 1237.8 by Hertz for P = 600, exact d = 0.0771."""
    (contact,), (other,) = part.contacts, whole.contacts
    np.testing.assert_allclose(part.loads.times, whole.loads.times)
    assert part.loads.cycle == whole.loads.cycle
    # as far as the coarse contact is Hertz's
    np.testing.assert_allclose(contact.normal_force, other.normal_force, rtol=5e-3)
    np.testing.assert_allclose(contact.shear_force, other.shear_force, atol=0.3)
    for station in contact.stations:
        assert station.decisive_k_n[0] == pytest.approx(1237.8, rel=0.01)
        assert station.slip_zones[-1].length == pytest.approx(0.0771, rel=0.03)
    (found,) = carried(part)
    assert max(found.differences) < 5e-3
    (note,) = carried_notes(part)
    assert re.search(r"loads\.upper_cut: through contact main the force differs .* of th", note)
    assert note in part.notes and "does not carry" not in note
    assert [row.verdict for row in carried_rows(part)] == ["agrees", "agrees"]


def test_a_second_cut_has_the_same_factors(part: Result, runner: Runner) -> None:
    variants, reasons = make_variants(part.case, part)
    assert "positions in another run" in reasons["about another mean"]
    (inner,) = (each for each in variants if each.name == CUT)
    assert inner.case.geometry.part is not None
    assert inner.case.geometry.part.radius == pytest.approx(1.6)
    rows = list(companion_rows(CUT, part, runner.run(inner.case)))
    assert [row.quantity.split()[0] for row in rows] == ["K_N", "ΔK", "d"] * 2
    assert [row.verdict for row in rows] == ["agrees"] * 6
    # The tolerances could fail: those of slip zones of six elements are the widest.
    for row in rows:
        assert row.tolerance < 0.07 * row.value


def test_bodies_that_are_not_in_equilibrium_are_told(
    whole: Result, runner: Runner, tmp_path: Path
) -> None:
    """Displacements of the whole, but softer bodies: they carry less, in proportion on the cuts."""
    found = write_submodel(whole, "main", tmp_path / "case", radius=1.2, size=0.05)
    softer = runner.run(load_case(found.path, {"bodies.*.young": 180e3}), tmp_path / "run")
    (note,) = carried_notes(softer)
    assert "The part does not carry what the run carries" in note
    for cut in cut_tractions(softer):
        np.testing.assert_allclose(cut.differences, (1 - 180 / 210) * cut.sizes, rtol=0.05)


def test_what_another_program_makes_of_deformed_surfaces_is_told(part: Result) -> None:
    """Sliding times rotation, over P/E*; nothing of runs that keep their surfaces, as these do."""
    assert list(followed_notes(part)) == []
    loads = {
        name: each.model_copy(update={"file": "run.frd"}) for name, each in part.case.loads.items()
    }
    foreign = replace(part, case=part.case.model_copy(update={"loads": loads}))
    (note,) = followed_notes(foreign)
    slides, turns, gap, share = (
        float(re.findall(rf"{before} ([\d.e-]+\d)", note)[0])
        for before in ("slides by up to", "turns by up to", "has them", "than here,")
    )
    assert slides * turns == pytest.approx(gap, rel=0.05)
    assert gap / (2 * 600.0 * (1 - 0.3**2) / 210e3) == pytest.approx(share, rel=0.05)
    assert "P is wrong" not in note
    turned = tuple(replace(each, found=1e4 * each.found) for each in part.limits)
    (note,) = followed_notes(replace(foreign, limits=turned))
    assert "P is wrong by up to twice that" in note


def test_no_room_for_a_second_cut(part: Result) -> None:
    near = part.case.model_copy(
        update={
            "geometry": part.case.geometry.model_copy(
                update={"part": Part(centre=(0.0, 0.0), radius=0.9)}
            )
        }
    )
    assert str(second_cut(replace(part, case=near))).startswith("no room: the contact reaches 0.5")


def test_an_edge(whole: Result, tmp_path: Path) -> None:
    found = write_submodel(whole, "main.right", tmp_path, radius=0.5)
    assert found.centre[0] == pytest.approx(0.575, abs=0.02)
    assert "the cut runs through the contact" in "\n".join(told(found, "mm"))
    default = write_submodel(whole, "main", tmp_path)
    assert default.radius == pytest.approx(3 * default.reach)
    assert default.size == ("geometry.parameters.size", 0.0125)


def test_a_part_has_local_problems_if_the_run_had_none(whole: Result, tmp_path: Path) -> None:
    """Nobody wants slip lengths of a coarse run; those of the part are what it is for."""
    bare = changed(whole.case, {"edges.local": False, "edges.stations": 12})
    edges = write_submodel(replace(whole, case=bare), "main", tmp_path).case.edges
    assert (edges.local, edges.stations) == (True, 12)


def test_what_cannot_be_cut(whole: Result, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"expected one of the edges main\.left"):
        write_submodel(whole, "other", tmp_path)
    with pytest.raises(
        CaseError, match=r"boundary 'upper_top' within the part, because loads\.pre"
    ):
        write_submodel(whole, "main", tmp_path, radius=13.0)
    with pytest.raises(CaseError, match=r"expected one that cuts a body, found 100, within whi"):
        write_submodel(whole, "main", tmp_path, radius=100.0)
    (tmp_path / "submodel.toml").write_text("title = 'mine'\n")
    with pytest.raises(OutputError, match=r"expected no such file, or a sub-model, found another"):
        write_submodel(whole, "main", tmp_path)
    assert whole.directory is not None
    with pytest.raises(CaseError, match="expected a folder without results of a run"):
        write_submodel(whole, "main", whole.directory)
    bare = replace(whole, directory=tmp_path)
    with pytest.raises(OutputError, match=r'found none: run the case with \[output\] fields = "al'):
        write_submodel(bare, "main", tmp_path)


def test_loads_within_the_part_stay(whole: Result, tmp_path: Path) -> None:
    """All others have done their work in the run; what acts on a part of a boundary is refused."""
    body = {"young": 210e3, "poisson": 0.3, "density": 7.8e-9, "expansion": 1.2e-5}
    body = {**body, "reference_temperature": 20.0}
    ramp = {"history": [{"ramp": 2.0, "until": 1.0, "steps": 1}, {"hold": True, "until": 3.0}]}
    layer = {"type": "eigenstrain", "depths": [0, 0.1], "values": [1e-3, 0]}
    surfaces = ["upper_contact", "lower_bottom"]
    away = {"type": "traction", "boundary": "lower_right", "direction": "normal", **ramp}
    (tmp_path / "heat.csv").write_text("x,y,T\n-20,-20,30\n20,-20,30\n-20,20,30\n20,20,30\n")
    loads = {
        "heat": {"type": "temperature", "file": str(tmp_path / "heat.csv"), **ramp},
        "spin": {"type": "rotation", "centre": [0, -90], **ramp},
        "squeeze": {"type": "interference", "contact": "main", **ramp},
        "peen": {**layer, "surfaces": surfaces, **ramp},
        "pull": away,
        "suck": {**away, "boundary": "lower_contact"},
    }
    case = parse_case({**tables(loads=loads), "bodies": {"upper": body, "lower": body}})
    times = whole.loads.times
    values = np.tile(2.0 * np.minimum(times, 1.0)[:, None], (1, len(loads)))
    history = replace(whole.loads, channels=tuple(loads), values=values, between=None)
    found = write_submodel(replace(whole, case=case, loads=history), "main", tmp_path / "part")
    cuts = ["upper_cut", "lower_cut"]
    assert list(found.case.loads) == ["heat", "spin", "squeeze", "peen", "suck", *cuts]
    assert found.left_out == ("support base", "load pull")
    peen, heat = (found.case.loads[name].model_dump() for name in ("peen", "heat"))
    assert peen["surfaces"] == ("upper_contact",)
    assert found.case.resolve(heat["file"]).resolve() == tmp_path / "heat.csv"
    own = build_history(found.case)
    np.testing.assert_allclose(own.times, times)
    np.testing.assert_allclose(own.values[:, :5], values[:, :5])
    np.testing.assert_allclose(own.values[:, 5], times)
    force = {"type": "force", "boundary": "upper_contact", "direction": "x", **ramp}
    with pytest.raises(
        CaseError, match=r"loads\.push is a force spread over all of it, found a pa"
    ):
        wrong = parse_case(tables(loads={"push": force}))
        write_submodel(replace(whole, case=wrong), "main", tmp_path / "wrong", radius=1.0)


def test_sides_of_a_sector(whole: Result, tmp_path: Path) -> None:
    side = {"type": "cyclic", "sectors": 40, "centre": [0.0, -76.0]}
    symmetry = {"disc": {**side, "boundary1": "lower_left", "boundary2": "lower_right"}}
    case = parse_case(tables(symmetry=symmetry))
    sector = replace(whole, case=case)
    assert not write_submodel(sector, "main", tmp_path, radius=2.0).case.symmetry
    with pytest.raises(CaseError, match=r"found some of those of symmetry\.disc within it"):
        write_submodel(sector, "main", tmp_path, radius=7.0)


def test_another_contact_in_the_part(whole: Result, tmp_path: Path) -> None:
    (contact,) = whole.solution.contacts
    moved = replace(contact.surface, points=contact.surface.points + np.array([3.0, 0.0]))
    other = replace(contact, name="other", pair="other", surface=moved)
    both = replace(whole, root_solution=replace(whole.solution, contacts=(contact, other)))
    with pytest.raises(
        CaseError, match=r"expected less than 2\.4.*, where contact 'other' presses"
    ):
        write_submodel(both, "main", tmp_path, radius=2.6)


def test_a_mesh_file_keeps_its_elements(whole: Result, tmp_path: Path) -> None:
    write_mesh(Mesh(dict(whole.bodies)), tmp_path / "pad.msh")
    own = parse_case(tables(geometry={"file": "pad.msh"}), tmp_path / "case.toml")
    of_file = replace(whole, case=own)
    found = write_submodel(of_file, "main", tmp_path / "part")
    assert found.case.geometry.file == "../pad.msh" and found.size[0] == ""
    assert "The elements are those of the run" in "\n".join(told(found, "mm"))
    mesh = grouped_mesh(load_case(found.path))
    assert sorted(mesh.bodies["lower"].boundaries) == ["lower_contact", "lower_cut"]
    with pytest.raises(CaseError, match=r"--size: expected none, because pad\.msh is a mesh"):
        write_submodel(of_file, "main", tmp_path / "finer", size=0.01)


@pytest.mark.parametrize("size", [None, 0.05])
def test_a_cad_file(whole: Result, tmp_path: Path, size: float | None) -> None:
    """The pad of the demo, whose mesh refines itself unless a size is asked for."""
    demo = load_case(Path(__file__).parents[2] / "demos" / "own_geometry.toml")
    contacts = tuple(replace(each, pair="pad") for each in whole.solution.contacts)
    of_demo = replace(whole, case=demo, root_solution=replace(whole.solution, contacts=contacts))
    found = write_submodel(of_demo, "main", tmp_path, size=size)
    assert list(found.case.bodies) == ["pad", "block"]
    assert (found.case.edges.tolerance, found.case.geometry.size) == (
        (0.01, None) if size is None else (None, size)
    )
    assert found.case.resolve(found.case.geometry.file or "").exists()


def test_the_command(whole: Result, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert whole.directory is not None
    submodel(whole.directory, "main", tmp_path / "case", radius=1.0, size=0.05)
    out = capsys.readouterr().out
    assert out.startswith("Part within a circle of radius 1 mm around (0, 0.0")
    assert f"Case {tmp_path / 'case' / 'submodel.toml'}" in out
    assert write_submodel(whole, "main", tmp_path / "case").path.is_file()


def test_tractions_on_the_cuts_are_those_of_the_run(whole: Result, part: Result) -> None:
    """To the stress of coarse elements, at the extremes of the load, whose fields the part has."""
    cuts = {each.load: each for each in cut_tractions(part)}
    assert set(cuts) == {"upper_cut", "lower_cut"}
    for name, cut in cuts.items():
        np.testing.assert_allclose(cut.times, [2.25, 2.75, 3.0])
        assert cut.differences.max() < 0.01 * cut.sizes.max()
        (note,) = (each for each in part.notes if each.startswith(f"loads.{name}: the tractions"))
        largest = cut.times[cut.differences.argmax()]
        assert f"over the cut, 3 states), at time {largest:g}" in note
