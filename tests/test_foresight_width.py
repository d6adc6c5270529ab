# SPDX-License-Identifier: LGPL-3.0-or-later
"""Width of a contact that the initial gap tells before anything is solved."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.evaluate.resolution import half_width

X = np.linspace(-8.0, 8.0, 641)


def test_a_cylinder_and_two_of_them() -> None:
    # a² = 4 P R/(π E*)
    found, centre = half_width(X, (X - 1) ** 2 / 100, np.pi / 200)
    assert found == pytest.approx(1.0, rel=1e-3)
    assert centre == pytest.approx(1.0, abs=1e-9)
    two = np.minimum((X - 3) ** 2, (X + 3) ** 2) / 100
    assert half_width(X, two, np.pi / 200)[0] == np.inf
