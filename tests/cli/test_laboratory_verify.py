# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe verify` as a user meets it: tables, JSON, exit codes."""

from __future__ import annotations

import json
import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from harness.launch import fretfe
from quality.test_verification_benchmarks import NOT_FOR_HALF_PLANES
from typer.testing import CliRunner

from fretfe.backends import Backend, Installed, RunOptions
from fretfe.backends.protocol import DEFAULTS
from fretfe.case import Case
from fretfe.cli.app import app
from fretfe.cli.run import verify as verify_backends
from fretfe.errors import CaseError
from fretfe.quality import verification
from fretfe.quality.comparison import Benchmark, Row
from fretfe.quality.verification import benchmarks, controls
from fretfe.results.model import Result

KEYS = {
    "benchmark", "quantity", "backend", "computed", "reference", "difference", "tolerance",
    "verdict", "reason", "spread",
}  # fmt: skip
BENCHMARK = benchmarks()[0]
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def printed() -> dict[str, str]:
    """Output with and without --json, of benchmarks that are run once for both."""
    run = verification.run_benchmark
    found: dict[str, tuple[Row, ...]] = {}

    def once(benchmark: Benchmark, installed: Installed, *, required: bool) -> tuple[Row, ...]:
        if benchmark.name not in found:
            found[benchmark.name] = run(benchmark, installed, required=required)
        return found[benchmark.name]

    outputs = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verification, "run_benchmark", once)
        for options in ((), ("--json",)):
            done = fretfe("verify", "--backend", "halfplane", *options)
            assert done.returncode == 0, done.stdout + done.stderr
            assert done.stderr == ""
            outputs["".join(options)] = done.stdout
    return outputs


@pytest.fixture(scope="module")
def document(printed: dict[str, str]) -> dict[str, Any]:
    return dict(json.loads(printed["--json"]))


def test_json_document(document: dict[str, Any]) -> None:
    assert document["schema"] == {"name": "fretfe-verify", "version": 2}
    assert document["passed"] is True
    assert "fretfe" in document["versions"]
    assert list(document["seconds"]) == ["halfplane"]


def test_json_rows(document: dict[str, Any]) -> None:
    rows = document["rows"]
    assert all(set(row) == KEYS for row in rows)
    assert {row["verdict"] for row in rows} == {"agrees", "skipped", "caught"}
    assert {row["backend"] for row in rows} == {"halfplane"}
    names = [benchmark.name for benchmark in (*benchmarks(), *controls())]
    assert list(dict.fromkeys(row["benchmark"] for row in rows)) == names


def test_half_planes_pass_every_benchmark_that_they_take(document: dict[str, Any]) -> None:
    found: dict[str, set[str]] = {}
    for row in document["rows"]:
        found.setdefault(row["benchmark"], set()).add(row["verdict"])
    expected = {each.name: {"agrees"} for each in benchmarks()}
    expected |= {name: {"skipped"} for name in NOT_FOR_HALF_PLANES}
    assert found == expected | {each.name: {"caught"} for each in controls()}


def test_json_numbers(document: dict[str, Any]) -> None:
    for row in document["rows"]:
        if row["verdict"] == "agrees":
            assert abs(row["difference"]) <= row["tolerance"]
            # the scale is positive: difference has the sign of the deviation
            assert (row["computed"] - row["reference"]) * row["difference"] >= 0
        else:
            assert row["computed"] is None and row["reason"]


def test_tables(printed: dict[str, str]) -> None:
    for words in ("two cylinders", "reference", "tolerance", "verdict", "agrees", "caught"):
        assert words in printed[""]
    assert "differs" not in printed[""] and "failed" not in printed[""]


def test_unknown_backend() -> None:
    done = fretfe("verify", "--backend", "analitic")
    assert done.returncode == 2
    assert "'analitic'" in done.stderr and "halfplane" in done.stderr


def test_other_ranks_than_0_print_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PMI_RANK", "1")
    monkeypatch.setattr(verification, "benchmarks", lambda: (BENCHMARK,))
    done = CliRunner().invoke(app, ["verify", "--backend", "halfplane"])
    assert (done.exit_code, done.output) == (0, "")


def invoke(
    monkeypatch: pytest.MonkeyPatch, table: tuple[Benchmark, ...], *arguments: str
) -> tuple[int, str]:
    """Exit code and output with another table, without controls."""
    monkeypatch.setattr(verification, "benchmarks", lambda: table)
    monkeypatch.setattr(verification, "controls", lambda: ())
    done = CliRunner().invoke(app, ["verify", "--backend", "halfplane", *arguments])
    return done.exit_code, done.output


def wrong(factor: float) -> Benchmark:
    first, *others = BENCHMARK.quantities
    spoilt = replace(first, reference=first.reference * factor)
    return replace(BENCHMARK, quantities=(spoilt, *others))


def test_right_references_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    assert invoke(monkeypatch, (BENCHMARK,))[0] == 0


@pytest.mark.parametrize("factor", [1.0001, 0.9999])
def test_wrong_reference_fails(monkeypatch: pytest.MonkeyPatch, factor: float) -> None:
    code, output = invoke(monkeypatch, (wrong(factor),))
    assert code == 1
    assert "1 differs" in output and "verification failed" in output


def test_wrong_reference_fails_in_json(monkeypatch: pytest.MonkeyPatch) -> None:
    code, output = invoke(monkeypatch, (wrong(1.01),), "--json")
    document = json.loads(output)
    assert code == 1 and document["passed"] is False
    assert [row["quantity"] for row in document["rows"] if row["verdict"] == "differs"] == ["a"]


def test_control_that_is_accepted_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    code, output = invoke(monkeypatch, (replace(BENCHMARK, control=True),))
    assert code == 1
    assert "not caught" in output


def test_nothing_run_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    code, output = invoke(monkeypatch, benchmarks()[-1:])
    assert code == 1
    assert "Nothing was verified" in output


class Broken(Backend):
    """A backend that crashes."""

    summary = "broken"

    def supports(self, case: Case) -> tuple[str, ...]:
        return ()

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        raise IndexError("index 7 is out of bounds")


@pytest.mark.parametrize(
    ("backend", "reason", "verdict", "words"),
    [
        (Broken(), "", "failed", "IndexError: index 7 is out of bounds"),
        (None, "No module named 'dolfinx'", "failed", "No module named 'dolfinx'"),
    ],
    ids=["crash", "cannot be used"],
)
def test_backend_that_does_not_work(
    monkeypatch: pytest.MonkeyPatch,
    backend: Backend | None,
    reason: str,
    verdict: str,
    words: str,
) -> None:
    installed = (Installed("halfplane", "package 1.0", backend, reason),)
    monkeypatch.setattr(verification, "installed_backends", lambda: installed)
    code, output = invoke(monkeypatch, (BENCHMARK,), "--json")
    (row,) = json.loads(output)["rows"]
    assert code == 1
    assert (row["verdict"], row["reason"]) == (verdict, words)


def test_unknown_backend_is_an_error_of_the_user() -> None:
    with pytest.raises(CaseError, match="'nix'"):
        verify_backends(["nix"], as_json=True)


def cells_of(table: str) -> dict[str, list[str]]:
    """Quantity, difference and tolerance as the page shows them, by benchmark."""
    lines = ([cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:])
    return {benchmark: cells for benchmark, *cells in lines}


def test_the_page_has_these_differences_and_all_benchmarks(document: dict[str, Any]) -> None:
    page = (ROOT / "docs" / "verify.md").read_text("utf-8")
    table = page.partition("<!-- measured differences -->\n\n")[2].partition("\n<!-- end -->")[0]
    shown = cells_of(table)
    tool = runpy.run_path(str(ROOT / "tools" / "verify_docs.py"))
    # Finite elements take a minute: their differences are not looked at here.
    half_planes = cells_of(tool["table"](tool["largest_differences"](document["rows"])))
    assert {name: cells[0] for name, cells in shown.items() if cells[0] != "–"} == {
        name: cells[0] for name, cells in half_planes.items()
    }
    assert set(shown) == {benchmark.name for benchmark in benchmarks()}
    for benchmark in benchmarks():
        tolerances = {
            f"({tolerance:.1e})".replace("e-0", "e-")
            for quantity in benchmark.quantities
            for tolerance in quantity.tolerances.values()
        }
        for cell in shown[benchmark.name]:
            assert cell == "–" or cell[cell.index("(", cell.index(": ")) :] in tolerances
