# SPDX-License-Identifier: LGPL-3.0-or-later
"""Messages are for people: no code of fretfe reads its own warnings, errors, verdicts or labels."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import fretfe

ROOT = Path(fretfe.__file__).parent
# Names of what is said to people. What they mean has a type: `Kind`, `Verdict`, a class of errors.
SAID = {
    *("caution", "warning", "error", "fault", "message", "reason", "remark", "verdict", "label"),
    *("cautions", "warnings", "errors", "faults", "messages", "reasons", "verdicts", "labels"),
}
READS = {
    *("startswith", "endswith", "removeprefix", "removesuffix", "find", "index", "count"),
    *("split", "rsplit", "partition", "rpartition", "splitlines"),
}
PATTERNS = {"search", "match", "fullmatch", "findall", "finditer"}
# Collections: what is in them is asked for itself.
MANY = {each for each in SAID if each.endswith("s")} - {"messages"}
# Messages of other programs, which have no types. Only modules that run these read them.
OF_OTHERS = {
    "case/toml_file.py": "tomllib: the line of a mistake",
    "environment.py": "MPI and the system: no memory",
    "mesh/contained.py": "Python: a traceback of a child process",
    "mesh/gmsh.py": "gmsh: errors of a script, and commands that it does not know",
    "report/pictures/folder.py": "Python and OpenGL: the end of a child process",
    "mesh/cad.py": "labels that a STEP file has",
    "mesh/inp_outline.py": "labels that a deck has",
    "results/hdf5_file.py": "HDF5: a checksum that does not fit",
}


# Of fretfe itself, still to be given a type: this list only shrinks.
STILL = {
    "mesh/load.py": "whether an error names the case",
    "mesh/inp_groups.py": "the folder in the place of a card",
}


def said(node: ast.expr) -> bool:
    """True for a message: a name or an attribute called so, or the text of one."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "str":
        return len(node.args) == 1 and said(node.args[0])
    if isinstance(node, ast.Subscript):
        return said(node.value)
    if isinstance(node, ast.Attribute):
        return node.attr in SAID or (node.attr == "text" and said(node.value))
    return isinstance(node, ast.Name) and node.id in SAID


def many(node: ast.expr) -> bool:
    """True for a collection of messages."""
    name = getattr(node, "attr", getattr(node, "id", ""))
    return name in MANY


def reads(source: str) -> Iterator[int]:
    """Lines that look into a message."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            method, owner = node.func.attr, node.func.value
            looks = method in READS and said(owner) and not many(owner)
            if looks or (method in PATTERNS and any(map(said, node.args))):
                yield node.lineno
        elif isinstance(node, ast.Compare):
            for operator, right in zip(node.ops, node.comparators, strict=True):
                if isinstance(operator, ast.In | ast.NotIn) and said(right) and not many(right):
                    yield node.lineno


def test_no_code_reads_messages() -> None:
    found = {
        path.relative_to(ROOT).as_posix(): list(reads(path.read_text("utf-8")))
        for path in sorted(ROOT.rglob("*.py"))
    }
    known = {name for name, lines in found.items() if lines}
    listed = OF_OTHERS.keys() | STILL.keys()
    assert {name: found[name] for name in known - listed} == {}
    assert listed - known == set()


@pytest.mark.parametrize(
    ("source", "read"),
    [
        ("'K_N' in warning", True),
        ("'K_N' in contact.warnings[0].text", True),
        ("label.startswith('force ')", True),
        ("str(error).startswith(path)", True),
        ("PATTERN.search(str(error))", True),
        ("each.verdict.split()", True),
        ("'K_N' not in fault.reason", True),
        ("messages.splitlines()", True),
        ("caution in contact.warnings", False),
        ("verdict is Verdict.AGREES", False),
        ("Kind.UNITS in {each.kind for each in contact.warnings}", False),
        ("text.split()", False),
        ("str(error)", False),
    ],
)
def test_reading_a_message_is_found(source: str, read: bool) -> None:
    assert any(reads(source)) == read
