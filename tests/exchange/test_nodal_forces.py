# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact tractions on the surface of another mesh: balance, smoothness, and what is refused."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import meshio
import numpy as np
import pandas as pd
import pytest
from cases import solid_runs, stored_runs
from typer.testing import CliRunner

from fretfe._typing import Array
from fretfe.cli.app import app
from fretfe.errors import FretfeError, MeshError
from fretfe.exchange.nodal_forces import NodalForces, nodal_forces
from fretfe.history.solution import ContactHistory
from fretfe.mesh.inp_surfaces import DeckSurface, read_surface


def plane_deck(count: int, order: int, half: float = 1.0, height: float = 0.0) -> str:
    """A row of quadrilaterals with a surface on the upper side, or on the lower one if height < 0.

    Args:
        count: of elements.
        order: 1 or 2.
        half: of its length.
        height: y of its upper side.
    """
    x = np.linspace(-half, half, order * count + 1).tolist()
    lines = ["*NODE"]
    for number, place in enumerate(x):
        lines.append(f"{number + 1}, {place!r}, {height - 0.5}")
        lines.append(f"{number + 10001}, {place!r}, {height}")
    for number in range(1, order * count + 2):
        lines.append(f"{number + 20000}, {x[number - 1]!r}, {height - 0.25}")
    lines.append(f"*ELEMENT, TYPE=CPE{4 * order}, ELSET=BODY")
    for number in range(count):
        first, last = order * number + 1, order * number + order + 1
        nodes = [first, last, last + 10000, first + 10000]
        if order == 2:
            nodes += [first + 1, last + 20000, first + 10001, first + 20000]
        lines.append(", ".join(map(str, [number + 1, *nodes])))
    return "\n".join([*lines, "*SURFACE, NAME=TOP", "BODY, S3", "*SURFACE, NAME=FOOT", "BODY, S1"])


def surface_in(folder: Path, text: str, name: str = "top") -> DeckSurface:
    path = folder / "model.inp"
    path.write_text(text)
    return read_surface(path, name)


def plane_contact() -> ContactHistory:
    solution = stored_runs.solved("halfplane").solution
    return solution.contacts[0]


def resultants(points: Array, forces: Array) -> Array:
    """Force and moment about the origin."""
    if points.shape[1] == 2:
        moment = points[:, 0] @ forces[:, 1] - points[:, 1] @ forces[:, 0]
        return np.array([*forces.sum(axis=0), moment])
    return np.concatenate([forces.sum(axis=0), np.cross(points, forces).sum(axis=0)])


def of_contact(contact: ContactHistory, state: int) -> Array:
    """Force and moment on body 2, from the definitions of p and q."""
    traction = contact.mean_traction[state] * contact.surface.weights[:, None]
    vectors = -traction[:, :1] * contact.surface.frames[:, 0]
    for axis in range(1, traction.shape[1]):
        vectors = vectors + traction[:, axis : axis + 1] * contact.surface.frames[:, axis]
    return resultants(contact.surface.points, vectors)


def require_balance(contact: ContactHistory, state: int, points: Array, found: NodalForces) -> None:
    expected = of_contact(contact, state)
    size = np.abs(expected[: points.shape[1]]).max()
    np.testing.assert_allclose(
        resultants(points, found.forces), expected, rtol=0, atol=1e-10 * size
    )
    np.testing.assert_allclose([*found.force, *found.moment], expected, rtol=0, atol=1e-12 * size)
    assert found.imbalance < 1e-10


# The contact is 0.9 to 1.1 wide, with elements of 0.004 in the mean: 0.02 and 0.0008 here, and two.
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("count", [2, 100, 500, 2500])
def test_balance_in_the_plane(tmp_path: Path, count: int, order: int) -> None:
    contact, surface = plane_contact(), surface_in(tmp_path, plane_deck(count, order))
    for state in (3, 8, len(contact.traction) - 1):
        found = nodal_forces(contact, state, contact.body2, surface)
        require_balance(contact, state, surface.points, found)
        assert found.distance < 1e-12
        assert found.added < 1e-2


def test_the_pressure_comes_through(tmp_path: Path) -> None:
    """Forces on five times finer elements are the pressure times their length, as smooth."""
    contact, surface = plane_contact(), surface_in(tmp_path, plane_deck(2500, 1))
    found = nodal_forces(contact, 10, contact.body2, surface)
    pressure = -found.forces[:, 1] / (2.0 / 2500)
    expected = np.interp(
        surface.points[:, 0], contact.surface.points[:, 0], contact.mean_traction[10, :, 0]
    )
    inside = np.abs(surface.points[:, 0]) < 0.5
    np.testing.assert_allclose(pressure[inside], expected[inside], rtol=0.05)
    assert abs((pressure[inside] / expected[inside]).mean() - 1) < 2e-3


def test_forces_on_both_bodies_are_opposite(tmp_path: Path) -> None:
    contact = plane_contact()
    lower = nodal_forces(contact, 8, "lower", surface_in(tmp_path, plane_deck(100, 1)))
    above = surface_in(tmp_path, plane_deck(100, 1, height=0.5), "foot")
    upper = nodal_forces(contact, 8, "upper", above)
    np.testing.assert_allclose(upper.forces, -lower.forces, atol=1e-9)


def test_units_of_length(tmp_path: Path) -> None:
    """A mesh in metres, and results in millimetres."""
    contact = plane_contact()
    same = nodal_forces(contact, 8, "lower", surface_in(tmp_path, plane_deck(100, 2)))
    metres = surface_in(tmp_path, plane_deck(100, 2, half=1e-3))
    found = nodal_forces(contact, 8, "lower", metres, 1000.0)
    np.testing.assert_allclose(found.forces, same.forces, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("deck", "name", "message"),
    [
        (
            {"height": 0.2},
            "top",
            r"expected a surface within 0\.0\d+ of contact main, which extends",
        ),
        ({"half": 0.4}, "top", r"found the place .* 0\.1\d+ away from it"),
        ({"half": 1000.0}, "top", "faces the other way|expected a surface"),
        ({"height": 0.5}, "foot", "found one that faces the other way"),
    ],
)
def test_surfaces_that_are_elsewhere(
    tmp_path: Path, deck: dict[str, float], name: str, message: str
) -> None:
    contact, surface = plane_contact(), surface_in(tmp_path, plane_deck(100, 1, **deck), name)
    if "half" in deck and deck["half"] > 100:  # larger elements than the contact are no mistake
        require_balance(contact, 8, surface.points, nodal_forces(contact, 8, "lower", surface))
        return
    with pytest.raises(MeshError, match=message):
        nodal_forces(contact, 8, "lower", surface)


def test_a_state_without_contact(tmp_path: Path) -> None:
    surface = surface_in(tmp_path, plane_deck(10, 1))
    with pytest.raises(MeshError, match="expected forces, found none in this state"):
        nodal_forces(plane_contact(), 0, "lower", surface)


def bent(kind: int, count: int, bend: float) -> DeckSurface:
    """A square of facets with `kind` nodes each, bent as the surface of the stored solids."""
    order = 2 if kind in (6, 8) else 1
    lines = np.linspace(-1.5, 1.5, order * count + 1)
    s, z = (each.ravel() for each in np.meshgrid(lines, lines, indexing="ij"))
    points = np.stack([np.sin(s * bend) / bend, (np.cos(s * bend) - 1) / bend, z], axis=1)
    row = order * count + 1
    first = (order * (np.arange(count)[:, None] * row + np.arange(count))).ravel()
    a, b, c, d = first, first + order, first + order * (row + 1), first + order * row
    middle = {
        (0, 1): first + 1, (1, 2): first + row + 2, (2, 3): first + 2 * row + 1,
        (3, 0): first + row, (0, 2): first + row + 1,
    }  # fmt: skip
    if kind == 4:
        facets = np.stack([a, b, c, d], axis=1)
    elif kind == 8:
        facets = np.stack([a, b, c, d, *list(middle.values())[:4]], axis=1)
    else:
        halves = [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
        if kind == 6:
            sides = [((0, 1), (1, 2), (0, 2)), ((0, 2), (2, 3), (3, 0))]
            halves = [
                np.column_stack([half, *(middle[edge] for edge in own)])
                for half, own in zip(halves, sides, strict=True)
            ]
        facets = np.concatenate(halves)
    used, numbers = np.unique(facets, return_inverse=True)
    inside = points[facets].mean(axis=1) - [0, 0.1, 0]
    return DeckSurface(
        points[used], tuple(map(str, used)), (numbers.reshape(facets.shape),), (inside,)
    )


@cache
def solid_contact() -> ContactHistory:
    solution = solid_runs.solid_result().solution
    return solution.contacts[0]


# Facets of the stored contact are 1/12 long, on both sides of it 1.5 wide.
@pytest.mark.parametrize("kind", [3, 4, 6, 8])
@pytest.mark.parametrize("count", [7, 180])
def test_balance_of_solids(kind: int, count: int) -> None:
    contact = solid_contact()
    surface = bent(kind, count // (2 if count > 36 and kind in (6, 8) else 1), 0.3)
    found = nodal_forces(contact, 8, "lower", surface)
    require_balance(contact, 8, surface.points, found)
    assert found.distance < (3 / count) ** 2 * 0.3 / 8 + 1e-3
    assert found.added < 0.02
    assert found.moment.shape == (3,)


def exported(folder: Path, text: str, *words: str, run: str = "halfplane") -> str:
    """What `fretfe forces` prints for the stored run and a model."""
    stored_runs.write_run(folder / "run", run)
    (folder / "model.inp").write_text(text)
    files = [str(folder / name) for name in ("run", "model.inp")]
    command = ["forces", *files, "top", *words, "-o", str(folder / "out")]
    result = CliRunner().invoke(app, command, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_files_of_forces(tmp_path: Path) -> None:
    text = plane_deck(100, 2)
    printed = exported(tmp_path, text, "--body", "lower", "--time", "1.25")
    assert "Contact main on lower at t = 1.25: forces at " in printed
    table = pd.read_csv(tmp_path / "out" / "forces.csv")
    assert list(table) == ["node", "x", "y", "force_x [N]", "force_y [N]"]
    contact = plane_contact()
    times = stored_runs.solved("halfplane").loads.times
    state = int(np.abs(times - 1.25).argmin())
    expected = of_contact(contact, state)
    values = table.to_numpy()
    np.testing.assert_allclose(
        resultants(values[:, 1:3], values[:, 3:]), expected, atol=1e-10 * np.abs(expected).max()
    )
    lines = (tmp_path / "out" / "cload.inp").read_text().splitlines()
    assert lines[:2] == ["** contact main on lower at t = 1.25; forces in N", "*CLOAD"]
    rows = np.array([[float(each) for each in line.split(",")] for line in lines[2:]])
    places = table.set_index("node")
    of_rows = np.zeros((len(rows), 2))
    of_rows[np.arange(len(rows)), rows[:, 1].astype(int) - 1] = rows[:, 2]
    points = places.loc[rows[:, 0].astype(int), ["x", "y"]].to_numpy()
    np.testing.assert_allclose(
        resultants(points, of_rows), expected, atol=1e-10 * np.abs(expected).max()
    )
    # CalculiX reads 20 characters of a number
    assert max(len(line.split(",")[2].strip()) for line in lines[2:]) <= 20
    grid = meshio.read(tmp_path / "out" / "forces.vtu")
    assert [(block.type, len(block.data)) for block in grid.cells] == [("line3", 100)]
    np.testing.assert_allclose(grid.point_data["force"][:, :2], values[:, 3:], rtol=1e-11)


def test_labels_of_instances(tmp_path: Path) -> None:
    part = plane_deck(20, 1).replace("TOP", "Upper side")
    text = f"*PART, NAME=P\n{part}\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=Disc-1, PART=P\n"
    text += "*END INSTANCE\n*SURFACE, NAME=TOP\nDisc-1.BODY, S3\n*END ASSEMBLY\n"
    exported(tmp_path, text, "--body", "lower")
    line = (tmp_path / "out" / "cload.inp").read_text().splitlines()[2]
    assert line.startswith("DISC-1.100")


def test_a_unit_that_is_probably_wrong(tmp_path: Path) -> None:
    printed = exported(tmp_path, plane_deck(100, 1), "--body", "lower")
    assert "Note" not in printed
    printed = exported(tmp_path, plane_deck(100, 1), "--body", "lower", "--factor", "1000")
    assert "times as long as the contact: is the unit of length right (--factor)?" in printed


def forces_refused(folder: Path, text: str, *words: str) -> str:
    with pytest.raises(FretfeError) as caught:
        exported(folder, text, *words)
    assert not (folder / "out").exists()
    return str(caught.value)


def test_what_cannot_be_written(tmp_path: Path) -> None:
    text = plane_deck(20, 1)
    message = forces_refused(tmp_path, text, "--body", "pad")
    assert message == "--body: expected one of upper, lower, found 'pad'"
    message = forces_refused(tmp_path, text, "--body", "lower", "--contact", "left")
    assert message == "--contact: expected one of main, found 'left'"
    message = forces_refused(tmp_path, text, "--body", "lower", "--time", "1.26")
    assert "--time: expected the time of a state with tractions, such as 1.125, 1.25" in message
    for value in ("nan", "inf", "-1", "0"):
        words = ["forces", str(tmp_path), str(tmp_path), "top", "--body", "lower"]
        found = CliRunner().invoke(app, [*words, "--factor", value])
        assert found.exit_code == 2
        assert "'--factor': expected a number" in " ".join(found.output.split())
    message = forces_refused(tmp_path, text, "--body", "lower", "--factor", "0.1")
    assert "model.inp: top: expected a surface within" in message
    message = forces_refused(tmp_path, text.replace("TOP", "HEAD"), "--body", "lower")
    assert "no surface, node set or element set TOP" in message
    solid = text.replace("CPE4", "C3D4")
    message = forces_refused(tmp_path, solid, "--body", "lower")
    assert "model.inp" in message
