# SPDX-License-Identifier: LGPL-3.0-or-later
"""What each room may hold: modules, lines and numbers found by trial; who may know a case.

A figure goes up only in a commit of its own, which says what the room may now do. Lists of what is
still too much only shrink: what has become better must be taken off them.
"""

from __future__ import annotations

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest
from project.test_layers import MODULES, ROOT, code_lines

TESTS = Path(__file__).parents[1]
# Folders of tests that stand for no room: whole runs, the project itself, random cases, and what
# builds cases, knows the answers or starts processes.
BESIDE_ROOMS = {"system", "project", "campaign", "cases", "reference", "harness", "faults", "data"}
# Code lines (no docstrings, comments, blanks, imports) of each room; five in a hundred are free.
ROOM_LINES = {
    "_core": 0,
    "analytic": 1209,
    "backends": 541,
    "bodies": 2745,
    "case": 2959,
    "cli": 1558,
    "contact": 2285,
    "decision": 1985,
    "evaluate": 8743,
    "exchange": 2114,
    "fem": 4129,
    "fields": 1126,
    "halfplane": 162,
    "history": 402,
    "idealise": 539,
    "loads": 884,
    "local": 738,
    "matching": 1121,
    "materials": 226,
    "mesh": 5898,
    "quality": 2133,
    "report": 3691,
    "results": 2066,
    "strength": 885,
    "surface": 1219,
    "sweeps": 564,
    "top": 1687,
}
SLACK = 1.05
LONGEST = 500
# Modules with more lines.
TOO_LONG = {
    "fretfe.analytic.edges",
    "fretfe.case.loads",
    "fretfe.contact.linear_operator",
    "fretfe.contact.march",
    "fretfe.contact.recorder",
    "fretfe.evaluate.contacts",
    "fretfe.evaluate.space.fronts",
    "fretfe.evaluate.space.local",
    "fretfe.fem.elasticity",
    "fretfe.fem.extraction",
    "fretfe.fem.limits",
    "fretfe.fem.run",
    "fretfe.loads.csv_file",
    "fretfe.loads.history",
    "fretfe.mesh.elements",
    "fretfe.mesh.inp",
    "fretfe.quality.rows",
    "fretfe.report.figures.edges",
    "fretfe.report.figures.tractions",
    "fretfe.report.page.tables",
    "fretfe.surface.surface",
}
# Plain numbers that modules name: most were found by trial, and each has to be known to be changed.
NUMBERS = {
    "analytic": 27,
    "backends": 13,
    "bodies": 39,
    "case": 21,
    "cli": 4,
    "contact": 57,
    "decision": 8,
    "evaluate": 264,
    "exchange": 31,
    "fem": 55,
    "fields": 16,
    "halfplane": 3,
    "history": 7,
    "idealise": 17,
    "loads": 10,
    "local": 32,
    "matching": 28,
    "materials": 6,
    "mesh": 84,
    "quality": 68,
    "report": 96,
    "results": 6,
    "strength": 15,
    "surface": 27,
    "sweeps": 5,
    "top": 18,
}
# Names of constants in more than three modules.
COMMON_NAMES = {
    "AROUND",
    "BESIDE",
    "COARSE",
    "DEEPEST",
    "DIGITS",
    "EDGES",
    "ELEMENTS",
    "FAR",
    "FARTHEST",
    "FEWEST",
    "FEWEST_ELEMENTS",
    "FEWEST_NODES",
    "FINEST",
    "FLAT",
    "GROWTH",
    "ITERATIONS",
    "KINDS",
    "MARGIN",
    "MOST",
    "NEAR",
    "NUMBERS",
    "ORDERS",
    "PARTS",
    "PASSES",
    "POINTS",
    "ROUND_OFF",
    "ROWS",
    "SAME",
    "SAME_TIME",
    "SCHEMA",
    "SHORTEST",
    "SIDES",
    "STEP",
    "STRAIGHT",
    "T",
    "TOLERANCE",
    "UNITS",
    "WIDEST",
    "YOUNG",
    "ZONES",
}
# Rooms that make cases, or turn them into a model, and those that have not learnt to do without.
KNOW_CASES = {"api", "backends", "bodies", "case", "checked", "cli", "fem", "idealise", "loads",
              "materials", "mesh", "runner", "work"}  # fmt: skip
STILL_KNOW_CASES = {
    "fretfe.exchange.part_tables",
    "fretfe.exchange.submodel",
    "fretfe.quality.companions",
    "fretfe.quality.comparison",
    "fretfe.quality.cycles",
    "fretfe.quality.global_run",
    "fretfe.quality.loading",
    "fretfe.quality.pads",
    "fretfe.quality.solids",
    "fretfe.quality.validation",
    "fretfe.quality.verification",
    "fretfe.report.figures.history",
    "fretfe.report.figures.tractions",
    "fretfe.report.pictures.mesh",
    "fretfe.results.model",
    "fretfe.results.reader",
    "fretfe.surface.ahead",
    "fretfe.surface.checks",
    "fretfe.sweeps.engine",
}


def room(module: str) -> str:
    """The room of a module; those beside the rooms are together in one."""
    parts = module.split(".")
    return parts[1] if len(parts) > 2 or MODULES[module].name == "__init__.py" else "top"


def rooms_of_modules() -> dict[str, list[str]]:
    found = defaultdict(list)
    for module in MODULES:
        found["top" if module == "fretfe" else room(module)].append(module)
    return found


ROOMS = rooms_of_modules()


def trees() -> Iterator[tuple[str, ast.Module]]:
    for module, path in MODULES.items():
        yield module, ast.parse(path.read_text("utf-8"))


def constants(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Names in capitals that a module assigns, with their values."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            if node.targets[0].id.isupper():
                yield node.targets[0].id, node.value


def is_number(value: ast.expr) -> bool:
    inner = value.operand if isinstance(value, ast.UnaryOp) else value
    plain = isinstance(inner, ast.Constant) and isinstance(inner.value, int | float)
    return plain and not isinstance(inner.value, bool)  # type: ignore[attr-defined]


def test_every_room_has_its_figure() -> None:
    assert ROOMS.keys() == ROOM_LINES.keys()


@pytest.mark.parametrize("name", sorted(ROOM_LINES))
def test_lines_of_a_room(name: str) -> None:
    lines = sum(code_lines(MODULES[each].read_text("utf-8")) for each in ROOMS[name])
    assert lines <= SLACK * ROOM_LINES[name]


def test_lengths_of_modules() -> None:
    lengths = {name: path.read_text("utf-8").count("\n") for name, path in MODULES.items()}
    assert {name for name, lines in lengths.items() if lines > LONGEST} == TOO_LONG


def test_numbers_found_by_trial_only_fall() -> None:
    count = Counter(
        room(module) for module, tree in trees() for _, value in constants(tree) if is_number(value)
    )
    assert dict(count) == NUMBERS, "fewer: lower the figure; more: does a formula give the number?"


def test_names_of_constants_are_rare() -> None:
    count = Counter(name for _, tree in trees() for name in {each for each, _ in constants(tree)})
    assert {name for name, modules in count.items() if modules > 3} == COMMON_NAMES


def test_each_constant_has_a_line() -> None:
    several = [
        f"{module}:{node.lineno}"
        for module, tree in trees()
        for node in tree.body
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Tuple)
        and isinstance(node.value, ast.Tuple)
    ]
    assert several == []


def test_who_knows_cases() -> None:
    knowing = {
        module
        for module, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("fretfe.case")
        if any(alias.name == "Case" for alias in node.names)
    }
    others = {each for each in knowing if each.split(".")[1] not in KNOW_CASES}
    assert others == STILL_KNOW_CASES


def stems(name: str) -> set[str]:
    """Names of the modules and folders of a room."""
    # Of the checkout: what is installed has no C++ sources.
    folder = TESTS.parent / "fretfe" / name
    paths = [folder, *folder.rglob("*")]
    return {
        path.stem.lstrip("_") for path in paths if path.is_dir() or path.suffix in {".py", ".cpp"}
    }


@pytest.mark.parametrize("path", sorted(TESTS.rglob("test_*.py")), ids=lambda path: path.stem)
def test_tests_stand_in_the_room_of_what_they_test(path: Path) -> None:
    *folders, _ = path.relative_to(TESTS).parts
    if folders and folders[0] in BESIDE_ROOMS:
        return
    known = stems(folders[0]) if folders else {each.stem for each in ROOT.glob("*.py")}
    subject = path.stem.removeprefix("test_")
    assert any(subject == each or subject.startswith(f"{each}_") for each in known)
