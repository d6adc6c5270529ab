# SPDX-License-Identifier: LGPL-3.0-or-later
"""The same mesh gives the same results with every DOLFINx, PETSc and MPI library."""

from __future__ import annotations

import numpy as np
import pytest
from reference.reference_numbers import CASES, Numbers, read_references, solved_numbers

REFERENCES = read_references()
NAMES = [(case, name) for case in CASES for name in REFERENCES[case]]


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Numbers]:
    folder = tmp_path_factory.mktemp("meshes")
    return {case: solved_numbers(case, folder) for case in CASES}


@pytest.mark.parametrize("case", CASES)
def test_numbers_have_the_same_names(found: dict[str, Numbers], case: str) -> None:
    assert list(found[case]) == list(REFERENCES[case])


@pytest.mark.parametrize(("case", "name"), NAMES, ids=[": ".join(each) for each in NAMES])
def test_numbers_agree(found: dict[str, Numbers], case: str, name: str) -> None:
    expected = np.array(REFERENCES[case][name])
    # Of the largest of a history: some start from zero or pass through it. Round-off alone, by
    # another order of elimination in the same libraries, makes 3e-9 of slip lengths and K_N.
    scale = np.nanmax(np.abs(expected), initial=0.0)
    assert np.allclose(found[case][name], expected, rtol=0, atol=1e-8 * scale, equal_nan=True)
