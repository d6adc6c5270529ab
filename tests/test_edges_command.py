# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe edges`: tables, JSON, and a clear message for each mistake in the file."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from edge_contacts import FRICTION, HERTZ, HERTZ_LOAD, K_N_HERTZ
from halfplane_galerkin import uniform_nodes

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
    guide = (Path(__file__).parents[1] / "docs" / "edges.md").read_text("utf-8")
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
        ("x,pressure\n0,1", [], "line 1: expected one column 'p', found 'x', 'pressure'"),
        ("x|p\n0|1", [], "line 1: expected one column 'x', found 'x|p'"),
        ("x,p\n0,1\n2,1\n\n2,1\n", [], "line 5, column 'x': expected a position after 2, found 2"),
        ("x,p\n0,1\n1,many\n", [], "line 3, column 'p': expected a finite number, found 'many'"),
        ("x,p\n0,1\n1,nan\n", [], "line 3, column 'p': expected a finite number, found 'nan'"),
        ("x,p\n", [], "expected rows of numbers below the header, found none"),
        ("x,p\n0,-1\n1,-2\n", [], "is compression negative in this file?"),
        (f"x,p,q\n{ROWS}", ["--slip", "s"], "line 1: expected one column 's'"),
        (f"x,p,q\n{ROWS}", ["--friction", "-1"], "friction must lie in (0, inf), found -1"),
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
