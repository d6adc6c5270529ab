# SPDX-License-Identifier: LGPL-3.0-or-later
"""A crystal sphere on a flat of the same crystal, with ⟨001⟩ along the normal of both.

Of a parabolic gap the contact of anisotropic half-spaces is an ellipse with the pressure of Hertz
(J. R. Willis, J. Mech. Phys. Solids 14, 1966), here by symmetry a circle, with the modulus of the
mean of the compliance to pressure over all directions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from cases.cycled_sphere import RADIUS
from cases.cycled_sphere import tables as isotropic_tables

from fretfe.case import parse_case
from fretfe.materials.moduli import contact_modulus
from fretfe.results.model import Result

pytestmark = pytest.mark.slow

NICKEL = {"elastic": {"cubic": [252e3, 161e3, 131e3]}}
# Radii of the contact in the three steps.
WANTED = np.array([0.8, 1.0, 1.2])


def test_k_n_of_stations_is_that_of_the_growth_of_the_contact(
    solved: Callable[[dict[str, Any]], Result],
) -> None:
    """K_N = dP/da/(pi a sqrt(2 a)) at every station."""
    case = isotropic_tables(0.0) | {"bodies": {"upper": NICKEL, "lower": NICKEL}}
    upper, lower = parse_case(case).bodies.values()
    modulus = contact_modulus(upper, lower, "strain", np.array([0.0, 1.0, 0.0]))
    forces = 4 * modulus * WANTED**3 / (3 * RADIUS)
    history = [
        {"ramp": -force, "until": float(step), "steps": 1} for step, force in enumerate(forces, 1)
    ]
    press = {**case["loads"]["press"], "history": history}
    answer = solved({**case, "loads": {"press": press}, "edges": {"local": False, "stations": 16}})
    (contact,) = answer.contacts
    (front,) = contact.fronts
    k_n = np.array([each.k_n[-3:] for each in front.stations])
    points = np.array([each.point for each in front.stations])
    position = np.array([each.position[-3:] for each in front.stations])
    radii = np.hypot(points[:, 0], points[:, 2])[:, None] - position  # inward
    radius = radii.mean(axis=0)
    assert np.abs(radii / radius - 1).max() < 0.01
    np.testing.assert_allclose(radius, WANTED, rtol=0.01)
    growth = np.polyfit(np.log(radius), np.log(forces), 1)[0]
    assert growth == pytest.approx(3.0, rel=0.01)
    expected = growth * forces / (np.pi * radius**2 * np.sqrt(2 * radius))
    # Stations scatter by the position of the front within an element, as those of isotropic bodies.
    assert np.abs(k_n / expected - 1).max() < 0.02
    np.testing.assert_allclose(k_n.mean(axis=0), expected, rtol=0.01)
