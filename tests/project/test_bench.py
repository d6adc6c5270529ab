# SPDX-License-Identifier: LGPL-3.0-or-later
"""The benchmark tells what fails in its row, and goes on."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest


def load_bench() -> ModuleType:
    path = Path(__file__).parents[2] / "tools" / "bench.py"
    spec = spec_from_file_location("bench", path)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules["bench"] = module
    spec.loader.exec_module(module)
    return module


bench = load_bench()


def test_a_row_that_fails_is_told_and_the_rest_goes_on(capsys: pytest.CaptureFixture[str]) -> None:
    def fails() -> Iterator[tuple[str, ...]]:
        yield ("1",)
        raise RuntimeError("no | such\ncase")

    parts = [("first", fails), ("second", lambda: iter([("2",)]))]
    assert bench.print_table(("case", "number"), parts) == ["first"]
    assert capsys.readouterr().out.splitlines() == [
        "| case | number |",
        "|---|---|",
        "| first | 1 |",
        "| first | failed: RuntimeError: no / such case |",
        "| second | 2 |",
    ]


def test_a_command_that_fails_says_why(tmp_path: Path) -> None:
    said = f"import sys; sys.exit('cannot read {tmp_path}')"
    with pytest.raises(RuntimeError, match=rf"exit code 1 .*cannot read {tmp_path}"):
        bench.spent([sys.executable, "-c", said])


def test_phases_of_a_run_by_its_lines() -> None:
    lines = (
        "mesh ...\n",
        "mesh: 330078 unknowns; the bodies are condensed before the first step\n",
        "condensation of the bodies: pad, 165000 unknowns ...\n",
        "step 1/55: 4 iterations, violation 3e-14\n",
        "edge factors: 3 of 8 ...\n",
        "fields: 3 of 84 ...\n",
        "Results in there\n",
    )
    found = [bench.phase_of(line) for line in lines]
    assert found == [
        "mesh",
        None,
        "condensation of the bodies: pad",
        "steps",
        "edge factors",
        "fields",
        "end",
    ]


def test_cases_of_tables_are_there() -> None:
    for table in bench.TABLES.values():
        assert {name for name, _ in table.parts(list(bench.CASES))} <= {
            *bench.CASES,
            *bench.COMMANDS,
        }
    named = {*bench.LONG, *bench.BY_RANKS, *bench.BY_FACTORS, *bench.BY_MEMORY}
    assert named <= set(bench.CASES)
