# SPDX-License-Identifier: LGPL-3.0-or-later
"""One case, two backends and closed forms: the same edge factors and slip zones."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases.pad_cases import SLIDING, cylinder, pad, press, pull, shear
from reference.closed_forms import closed_contact

from fretfe.backends import find_backend
from fretfe.case import parse_case
from fretfe.evaluate.contacts import Contact
from fretfe.fem.backend import MpiProcesses

FINE = cylinder(size=0.008)
CASES: dict[str, dict[str, Any]] = {
    "shear": pad(geometry=FINE),
    "bulk tension in phase": pad(
        geometry=FINE,
        supports=SLIDING,
        loads={"press": press(), "shear": shear(), "pull": pull(60.0)},
    ),
}


@pytest.fixture(scope="module", params=list(CASES))
def answers(request: pytest.FixtureRequest) -> dict[str, Contact]:
    case = parse_case(CASES[request.param])
    found = {name: find_backend(name).solve(case).contacts[0] for name in ("halfplane", "fem")}
    return {"closed forms": closed_contact(case), **found}


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
@pytest.mark.parametrize("name", ["closed forms", "halfplane"])
def test_edges_agree(answers: dict[str, Contact], name: str, side: int) -> None:
    edge, reference = (answers[n].stations[side] for n in (name, "fem"))
    half_width = float(answers["closed forms"].half_width[-1])
    assert edge.position[-1] == pytest.approx(reference.position[-1], abs=0.01 * half_width)
    assert edge.k_n[-1] == pytest.approx(reference.k_n[-1], rel=0.01)
    assert edge.k_t_range == pytest.approx(reference.k_t_range, rel=0.01)
    largest = np.abs(reference.k_t).max()
    assert edge.k_t == pytest.approx(reference.k_t, abs=0.01 * largest)
    for mine, other in zip(edge.slip_zones[-2:], reference.slip_zones[-2:], strict=True):
        assert mine.length == pytest.approx(other.length, abs=0.01 * half_width)
        assert (mine.start, mine.end) == (other.start, other.end)


def test_forces_agree(answers: dict[str, Contact]) -> None:
    exact, other = answers["closed forms"], answers["fem"]
    assert other.normal_force == pytest.approx(exact.normal_force, abs=1e-6)
    assert other.shear_force == pytest.approx(exact.shear_force, abs=1e-6)


def test_only_finite_elements_are_parallel() -> None:
    parallel = [isinstance(find_backend(n).processes, MpiProcesses) for n in ("halfplane", "fem")]
    assert parallel == [False, True]
