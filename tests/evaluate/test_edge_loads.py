# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads of an edge, each increment as if it had one size."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.evaluate.edge_loads import edge_loads

FORCE = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 0.0])
SHEAR = np.array([0.0, 0.0, 0.2, 0.6, 0.1, 0.0])


@pytest.mark.parametrize("unknown", [[], [1], [1, 2], [4]])
def test_contacts_too_small_to_tell_hold_as_those_beside_them_do(unknown: list[int]) -> None:
    """Of half-planes at one size hold and shear go with P and Q."""
    half_width = np.sqrt(np.where(FORCE > 0, FORCE, np.nan))
    unit = 1 / (np.pi * np.sqrt(2 * half_width))
    units = np.zeros((6, 2, 2))
    units[:, 0, 0] = units[:, 1, 1] = unit
    units[FORCE == 0] = np.nan
    units[unknown] = np.nan
    drivers, touching = np.stack([FORCE, SHEAR], axis=1), FORCE > 0
    rough = np.ones(6, dtype=bool)
    found = edge_loads(units, drivers, rough, touching, np.array([1.0, 0.0]), 3)
    at = unit[3]
    np.testing.assert_allclose(found.hold, at * FORCE, rtol=1e-12)
    np.testing.assert_allclose(found.shear[:5], at * SHEAR[:5], atol=1e-12)
