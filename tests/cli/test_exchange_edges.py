# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe edges`: tables, JSON, and a clear message for each mistake in the file."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.edge_contacts import FRICTION, HERTZ, HERTZ_LOAD, K_N_HERTZ
from reference.halfplane_galerkin import uniform_nodes

from fretfe.analytic.partial_slip import PartialSlip
from fretfe.cli.app import app, main

SHEAR = 0.3 * FRICTION * HERTZ_LOAD


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """Exact Hertz pressure and Cattaneo-Mindlin shear and slip."""
    x = uniform_nodes(0.02, 0.3)
    problem = PartialSlip(HERTZ, HERTZ_LOAD, FRICTION)
    slip = np.where(np.abs(x) < 1, problem.slip(np.clip(x, -1, 1), SHEAR), 0.0)
    columns = np.column_stack([x, HERTZ.pressure(x, 1.0), problem.shear(x, SHEAR), slip])
    path = tmp_path / "tractions.csv"
    np.savetxt(path, columns, delimiter=",", header="x,p,q,slip", comments="")
    return path


def run(*arguments: str | Path | float) -> None:
    app(["edges", *map(str, arguments)], standalone_mode=False)


def failure(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str | Path
) -> tuple[int | str | None, str]:
    """Exit code and message of a call that fails."""
    monkeypatch.setattr("sys.argv", ["fretfe", "edges", *map(str, arguments)])
    with pytest.raises(SystemExit) as stop:
        main()
    return stop.value.code, capsys.readouterr().err


def test_table(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(table, "--friction", FRICTION)
    text = capsys.readouterr().out
    assert "left" in text and "right" in text
    rows = {line.split("  ")[1].strip(): line for line in text.splitlines() if "±" in line}
    assert list(rows) == ["position", "K_N", "slip zone, from slip", "slip zone, from |q| = f p"]
    assert "-1.0000" in rows["position"]
    assert "Note" not in text
    assert "P = 0.78" in text


def test_example_of_the_guide(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    guide = (Path(__file__).parents[2] / "docs" / "edges.md").read_text("utf-8")
    code, output = re.findall(r"```python\n(.*?)```.*?```\n(.*?)```", guide, re.DOTALL)[0]
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "edges.md", "exec"), {})
    run("tractions.csv", "--friction", 0.5)
    printed = capsys.readouterr().out.splitlines()
    # M and x are differences of nearly equal numbers.
    assert [line.rstrip() for line in printed[:-1]] == output.splitlines()[:-1]


def test_json(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(table, "--friction", FRICTION, "--json")
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["schema"] == {"name": "fretfe-edges", "version": 1}
    left, right = numbers["edges"]
    assert (left["side"], right["side"]) == ("left", "right")
    # Round-off for the pressure; .1 h for the slip zone.
    assert left["k_n"]["value"] == pytest.approx(K_N_HERTZ, rel=1e-6)
    exact = 1 - np.sqrt(0.7)
    assert left["slip_from_slip"]["value"] == pytest.approx(exact, abs=2e-3)
    assert left["slip_from_traction"]["value"] == pytest.approx(exact, abs=1e-6)
    # Trapezoidal sums of square roots.
    assert numbers["shear_force"] == pytest.approx(SHEAR, rel=5e-3)


def test_what_is_missing_is_said(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [line.split(",")[:2] for line in table.read_text("utf-8").splitlines()]
    table.write_text("\n".join(",".join(row) for row in rows), "utf-8")
    run(table)
    text = " ".join(capsys.readouterr().out.split())
    assert "Note: slip zone, from slip: no slip given" in text
    assert "Note: slip zone, from |q| = f p: needs q and the friction coefficient" in text
    assert "Q = -" in text
    run(table, "--json")
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["shear_force"] is None
    assert numbers["edges"][0]["slip_from_slip"]["value"] is None


def test_names_of_columns(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = table.read_text("utf-8")
    table.write_text(text.replace("x,p,q,slip", "arc, CPRESS, CSHEAR, CSLIP"), "utf-8")
    names = ("--x", "arc", "--p", "CPRESS", "--q", "CSHEAR", "--slip", "CSLIP")
    run(table, *names, "--friction", FRICTION, "--json")
    edge = json.loads(capsys.readouterr().out)["edges"][1]
    assert edge["slip_from_slip"]["value"] and edge["slip_from_traction"]["value"]


ROWS = "\n".join(f"{i},1,0" for i in range(20))


@pytest.mark.parametrize(
    ("content", "arguments", "message"),
    [
        ("x,load\n0,1", [], "line 1: expected one column 'p', found 'x', 'load'"),
        ("x|p\n0|1", [], "line 1: expected one column 'x', found 'x|p'"),
        ("x,p\n0,1\n2,1\n\n2,1\n", [], "line 5, column 'x': expected a position after 2, found 2"),
        ("x,p\n0,1\n1,many\n", [], "line 3, column 'p': expected a finite number, found 'many'"),
        ("x,p\n0,1\n1,nan\n", [], "line 3, column 'p': expected a finite number, found 'nan'"),
        ("x,p\n", [], "expected rows of numbers below the header, found none"),
        ("x,p\n0,-1\n1,-2\n", [], "is compression negative in this file?"),
        (f"x,p,q\n{ROWS}", ["--slip", "s"], "line 1: expected one column 's'"),
        (f"x,p,q\n{ROWS}", ["--friction", "-1"], "friction must lie in (0, inf), found -1"),
        (f"x,p,q\n{ROWS}", ["--q", ""], "expected the name of a column with --q, found an empty"),
        (f"x,p,q\n{ROWS}", ["--q", "p"], "'p': expected one quantity in it, found it taken for p"),
        (f"x,p,q\n{ROWS}", ["--slip", "q"], "found it taken for q and for slip"),
    ],
)
def test_mistakes(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    content: str,
    arguments: list[str],
    message: str,
) -> None:
    path = tmp_path / "tractions.csv"
    path.write_text(content, "utf-8")
    code, text = failure(monkeypatch, capsys, path, *arguments)
    assert code == 2
    assert f"fretfe: error: {path}: " in text
    assert message in text


def test_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, text = failure(monkeypatch, capsys, tmp_path / "none.csv")
    assert code == 2
    assert "expected a CSV file, found nothing at" in text


def as_program(table: Path, path: Path, names: str, order: slice = slice(None)) -> Path:
    """The exact tractions as another program would write them."""
    _, *rows = table.read_text("utf-8").splitlines()
    path.write_text("\n".join([names, *rows[order]]), "utf-8")
    return path


def numbers_of(capsys: pytest.CaptureFixture[str], *arguments: str | Path | float) -> Any:
    run(*arguments, "--friction", FRICTION, "--json")
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    "names",
    [
        "COORD,CPRESS,CSHEAR1,CSLIP1",
        "Coor1, cpress ,CShear1,CSLIP1",
        "COORD-COOR1 (mm),CPRESS [MPa],CSHEAR1,CSLIP1",
        "coor1,CONTPRES,TAUR,SLIDE",
    ],
)
def test_names_of_programs(
    table: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], names: str
) -> None:
    own = numbers_of(capsys, table)
    found = numbers_of(capsys, as_program(table, tmp_path / "other.csv", names))
    assert found["shear_force"] == own["shear_force"]
    for one, two in zip(found["edges"], own["edges"], strict=True):
        assert one["k_n"] == two["k_n"]
        assert one["slip_from_traction"] == two["slip_from_traction"]
        # Slip that counts from the start of an analysis is not taken without being told to.
        assert one["slip_from_slip"]["value"] is None
    assert set(found["columns"]) == {"x", "p", "q"}
    text = " ".join(found["remarks"])
    assert "positive in compression" in text and "sign of Q" in text
    assert "is not taken for the slip: it counts from the start" in text


def test_what_is_taken_for_what_is_printed(
    table: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(as_program(table, tmp_path / "other.csv", "COORD,CPRESS,CSHEAR1,CSLIP1"))
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("Columns: ")]
    assert lines[:2] == ["Columns: x is COORD", "Columns: p is CPRESS, positive in compression"]
    assert len(lines) == 4


def test_nodes_in_the_order_of_their_numbers(
    table: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own = numbers_of(capsys, table)
    path = as_program(
        table, tmp_path / "other.csv", "COOR1,CPRESS,CSHEAR1,S", slice(None, None, -1)
    )
    found = numbers_of(capsys, path)
    assert found["edges"][0]["k_n"] == own["edges"][0]["k_n"]
    assert "rows are taken in the order of COOR1" in found["remarks"]


def test_arc_length_along_two_coordinates(
    table: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A flank at 60 degrees has the K_N of a flat contact, and its own width."""
    x, p, q, _ = np.loadtxt(table, delimiter=",", skiprows=1, unpack=True)
    rows = np.column_stack([x / 2, np.sqrt(0.75) * x, p, q])
    path = tmp_path / "flank.csv"
    np.savetxt(path, rows, delimiter=",", header="COOR1,COOR2,CPRESS,CSHEAR1", comments="")
    found = numbers_of(capsys, path)
    assert found["edges"][0]["k_n"]["value"] == pytest.approx(K_N_HERTZ, rel=1e-6)
    width = found["edges"][1]["position"]["value"] - found["edges"][0]["position"]["value"]
    assert width == pytest.approx(2, rel=1e-6)
    assert "x is the arc length along COOR1 and COOR2" in found["remarks"]


@pytest.mark.parametrize(
    ("names", "columns"),
    [
        ("Node Label,X,Y,Z,CPRESS,CSHEAR1", "nxyzpq"),
        ("NODE\tX Location (mm)\tY Location (mm)\tZ Location (mm)\tPressure (MPa)\tq", "nxyzpq"),
        ("Point ID;Points:0;Points:1;Points:2;CPRESS;CSHEAR1", "nxyzpq"),
        ("contact_pressure,id,q,x,y,z", "pnqxyz"),
        ("X_mm,Y_mm,Pressure / MPa,q", "xypq"),
        ("COORD-COOR1,COORD-COOR2,CPRESS   A_PAD/A_BLOCK,CSHEAR1  A_PAD/A_BLOCK", "xypq"),
        ("X,Z,CPRESS  General_Contact_Domain,CSHEAR1  General_Contact_Domain", "xypq"),
        ("arc_length,Points_0,Points_1,CPRESS,CSHEAR1", "sxypq"),
        ("True distance along path 'Path-1',CPRESS,q", "spq"),
    ],
)
def test_a_flank_as_programs_write_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], names: str, columns: str
) -> None:
    """Hertz, a = .5 mm, p0 = 400 MPa, Q = .4 f P on a flank at 55 degrees: K_N = p0 √(2/a)."""
    s = np.linspace(-0.7, 0.7, 141)
    root = np.sqrt(np.clip(1 - (s / 0.5) ** 2, 0, None))
    inner = 0.5 * np.sqrt(0.6)
    held = np.sqrt(0.6) * np.sqrt(np.clip(1 - (s / inner) ** 2, 0, None))
    angle = np.radians(55)
    values = {
        "s": s, "x": 12 + s * np.cos(angle), "y": 3 + s * np.sin(angle), "z": 0 * s,
        "n": 101 + np.arange(141), "p": 400 * root, "q": 240 * (root - held),
    }  # fmt: skip
    separator = next(each for each in "\t;," if each in names)
    path = tmp_path / "flank.csv"
    table = np.column_stack([values[column] for column in columns])
    np.savetxt(path, table[::-1], delimiter=separator, header=names, comments="", fmt="%.9g")
    run(path, "--friction", 0.6, "--json")
    found = json.loads(capsys.readouterr().out)
    # trapezoidal sums of square roots; round-off of nine digits for the fits
    assert found["normal_force"] == pytest.approx(100 * np.pi, rel=2e-3)
    for edge in found["edges"]:
        assert edge["k_n"]["value"] == pytest.approx(800, rel=1e-4)
        assert edge["slip_from_traction"]["value"] == pytest.approx(0.5 - inner, abs=1e-4)


def test_a_pin_in_a_hole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """R = 2 mm, pressed towards 45 degrees: neither coordinate increases all along the path."""
    arc = np.radians(np.linspace(-35, 125, 201))
    half = 2 * np.radians(30)
    away = 2 * (arc - np.radians(45)) / half
    pressure = 400 * np.sqrt(np.clip(1 - away**2, 0, None))
    rows = np.column_stack([2 * np.cos(arc), 2 * np.sin(arc), pressure])
    path = tmp_path / "hole.csv"
    rows = np.random.default_rng(1).permutation(rows)
    np.savetxt(path, rows, delimiter=",", header="COOR1,COOR2,CPRESS", comments="", fmt="%.9g")
    run(path, "--json")
    found = json.loads(capsys.readouterr().out)
    # π a p0/2 by a sum; K_N = p0 √(2/a), along chords that are 8e-6 shorter than arcs
    assert found["normal_force"] == pytest.approx(np.pi * half * 200, rel=1e-3)
    for edge in found["edges"]:
        assert edge["k_n"]["value"] == pytest.approx(400 * np.sqrt(2 / half), rel=1e-4)


def test_pairs_of_surfaces_are_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two pairs: the pressure is to be named, and the shear is that of the same pair."""
    s = np.linspace(-0.7, 0.7, 141)
    root = np.sqrt(np.clip(1 - (s / 0.5) ** 2, 0, None))
    header = "COORD,CPRESS A/B,CPRESS C/D,CSHEAR1 A/B,CSHEAR1 C/D"
    path = tmp_path / "pairs.csv"
    table = np.column_stack([s, 0 * s, 400 * root, 0 * s, 40 * root])
    np.savetxt(path, table, delimiter=",", header=header, comments="")
    code, text = failure(monkeypatch, capsys, path)
    assert code == 2 and "found 'CPRESS A/B' and 'CPRESS C/D': name it with --p" in text
    run(path, "--p", "CPRESS C/D", "--json")
    assert json.loads(capsys.readouterr().out)["columns"] == {
        "x": "COORD", "p": "CPRESS C/D", "q": "CSHEAR1 C/D"
    }  # fmt: skip


@pytest.mark.parametrize("sign", [1, -1])
def test_a_sign_that_is_not_known_is_asked_for(
    table: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    sign: int,
) -> None:
    x, p, q, _ = np.loadtxt(table, delimiter=",", skiprows=1, unpack=True)
    path = tmp_path / "marc.csv"
    header = "Arc Length,Contact Normal Stress,Q"
    np.savetxt(path, np.column_stack([x, sign * p, q]), delimiter=",", header=header, comments="")
    code, text = failure(monkeypatch, capsys, path)
    assert code == 2 and "whose sign is not known: state it with --compression" in text
    word, other = ("positive", "negative") if sign > 0 else ("negative", "positive")
    found = numbers_of(capsys, path, "--compression", word)
    assert found["edges"][0]["k_n"]["value"] == pytest.approx(K_N_HERTZ, rel=1e-6)
    code, text = failure(monkeypatch, capsys, path, "--compression", other)
    assert code == 2 and "expected a positive pressure" in text


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        ("COORD,CPRESS,Pressure", "{0},1,1", "found 'CPRESS' and 'Pressure': name it with --p"),
        ("arc,COOR1,CPRESS", "{0},{0},1", "found 'arc' and 'COOR1': name it with --x"),
        ("COORD,CPRESS,CSHEAR1,CSHEAR2", "{0},1,1,0.5", "expected no shear beside that of"),
        ("COORD,CPRESS", "1,1", "column 'COORD': expected a place that no other row has, found 1"),
        ("COORD,CPRESS", "{0},-1", "state it with --compression negative"),
        ("Instance Name,X,CPRESS", "PAD-{0},{0},1", "column 'Instance Name': expected rows of one"),
        ("X,Y,CPRESS", "1,1,1", "column 'X': expected a place that no other row has, found 1"),
        ("X,Y,Load", "{0},1,1", "expected one column 'p', found 'X', 'Y', 'Load'; names that are"),
        ("Place,CPRESS", "{0},1", "expected one column 'x', found 'Place', 'CPRESS'; names that"),
    ],
)
def test_columns_that_cannot_be_told(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    header: str,
    row: str,
    message: str,
) -> None:
    path = tmp_path / "tractions.csv"
    path.write_text("\n".join([header, *(row.format(number) for number in range(20))]), "utf-8")
    code, text = failure(monkeypatch, capsys, path)
    assert code == 2 and message in text
