# SPDX-License-Identifier: LGPL-3.0-or-later
"""Readers of files of fields that other packages bring."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from harness.packages import EXAMPLE, write_package

from fretfe.errors import CaseError, DependencyError
from fretfe.fields.field import read_field

READER = """
import numpy as np
from fretfe.fields.field import Field

def read(path, quantity, arrays):
    points = np.loadtxt(path)
    return Field(points, np.array([1.0, 2.0]), lambda step: points * (step + 1))
"""


@pytest.fixture
def table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(tmp_path / "site")
    monkeypatch.delitem(sys.modules, "other", raising=False)
    path = tmp_path / "run.ODB"
    path.write_text("0 0 0\n1 0 0\n0 1 0\n")
    return path


def bring(tmp_path: Path, source: str) -> None:
    write_package(tmp_path / "site", "other", source, "fretfe.readers", "odb = other:read")


def test_a_reader_of_another_package(tmp_path: Path, table: Path) -> None:
    bring(tmp_path, EXAMPLE)
    found = read_field(table)
    assert found.times.tolist() == [1.0]
    assert found.points.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    np.testing.assert_array_equal(found.values(0), 0 * found.points)


def test_its_mistakes_are_named_with_it(tmp_path: Path, table: Path) -> None:
    bring(tmp_path, READER.replace("points * (step + 1)", "points[step, 7]"))
    found = read_field(table)
    with pytest.raises(DependencyError, match=r"'odb' of other 1\.0 failed: IndexError: "):
        found.values(0)


@pytest.mark.parametrize(
    ("source", "kind", "words"),
    [
        (
            "def read(*_): return None",
            CaseError,
            "expected a Field of 'odb' of other 1.0, found No",
        ),
        ("def read(*_): return 1 / 0", DependencyError, "'odb' of other 1.0 failed: ZeroDivision"),
        (READER.replace("[1.0, 2.0]", "[2.0, 1.0]"), CaseError, "not negative and increase"),
    ],
    ids=["no field", "raises", "times"],
)
def test_what_it_gives_is_checked(
    tmp_path: Path, table: Path, source: str, kind: type[Exception], words: str
) -> None:
    bring(tmp_path, source)
    with pytest.raises(kind, match=words):
        read_field(table)


def test_without_a_reader_the_endings_are_listed(tmp_path: Path, table: Path) -> None:
    with pytest.raises(CaseError, match=r"in one of \.csv, .*\.pvd, or a results folder"):
        read_field(table)
    bring(tmp_path, READER)
    other = table.with_suffix(".rst")
    other.write_text("")
    with pytest.raises(CaseError, match=r"\.pvd, \.odb, or a results folder"):
        read_field(other)


def test_values_that_no_case_may_have_are_refused(tmp_path: Path, table: Path) -> None:
    bring(tmp_path, READER)
    points = np.loadtxt(table)
    points[1, 0] = 1e300
    np.savetxt(table, points)
    with pytest.raises(CaseError, match=r"coordinates from -1e\+30 to 1e\+30, .*\(point 1\)"):
        read_field(table)
