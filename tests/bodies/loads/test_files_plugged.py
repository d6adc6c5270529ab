# SPDX-License-Identifier: LGPL-3.0-or-later
"""Factors of tractions by functions of other packages."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.blocks import block, graded
from cases.pad_cases import pad, press
from harness.packages import EXAMPLE, write_package

from fretfe.bodies.input_files import input_digests
from fretfe.bodies.loads.files import checked_history
from fretfe.bodies.loads.kinds import spread_loads
from fretfe.case import Case, parse_case
from fretfe.errors import CaseError, DependencyError
from fretfe.mesh.mesh import Mesh


def case(**changes: Any) -> Case:
    blown = {"type": "traction", "boundary": "b_top", "direction": "normal", "function": "wind",
             "history": [{"ramp": 1.0, "until": 1.0, "steps": 1}]}  # fmt: skip
    return parse_case(pad(loads={"press": press(), "blown": blown | changes}))


def mesh() -> Mesh:
    return Mesh(bodies={"b": block("b", graded(0, 2, 5, 1.0), graded(0, 1, 3))})


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "site"
    monkeypatch.syspath_prepend(folder)
    monkeypatch.delitem(sys.modules, "other", raising=False)
    return folder


def test_factors_at_the_nodes_and_middles_of_the_boundary(site: Path) -> None:
    """Of the page: 1 - (x/5)²."""
    write_package(site, "other", EXAMPLE, "fretfe.loads", "wind = other:wind")
    checked_history(case())
    load = spread_loads(case(), mesh())[-1]
    assert load.traction is not None
    assert load.traction.factors is not None
    places = np.array([[0.0, 1.0], [0.2, 1.0], [1.0, 1.0], [2.0, 1.0]])
    expected = [1.0, 0.9984, 0.96, 0.84]
    np.testing.assert_allclose(load.traction.factors.at(places), expected, rtol=1e-12)
    before = input_digests(case())
    assert list(before.values())
    (site / "other.py").write_text(EXAMPLE.replace("/ 5", "/ 4"))
    assert input_digests(case()) != before


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("1 / 0", r"'wind' of other 1\.0 failed: ZeroDivisionError: "),
        (
            "places",
            r"an array of the shape \(11,\) .*found an array of the shape \(11, 2\) of float64$",
        ),
        ("places[:, 0] / 0", r"'wind' of other 1\.0: expected .* of which 11 are not finite$"),
    ],
)
@pytest.mark.filterwarnings("ignore:(divide by zero|invalid value):RuntimeWarning")
def test_its_mistakes_are_named_with_it(site: Path, source: str, words: str) -> None:
    source = f"def wind(places): return {source}"
    write_package(site, "other", source, "fretfe.loads", "wind = other:wind")
    with pytest.raises(DependencyError, match=words):
        spread_loads(case(), mesh())


def test_there_is_none_of_that_name() -> None:
    words = r"loads\.blown\.function: .*a plug-in of the group fretfe\.loads \(none\), found 'wind'"
    with pytest.raises(CaseError, match=words):
        checked_history(case())
    words = r"expected one of 'points', 'file' and 'function'"
    with pytest.raises(CaseError, match=words):
        case(file="a.csv")
