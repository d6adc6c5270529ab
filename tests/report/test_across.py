# SPDX-License-Identifier: LGPL-3.0-or-later
"""Lines across contacts of solids: linear fields exactly, Hertz and Mindlin to the mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.solid_runs import (
    FRICTION,
    SHEAR,
    exact_station,
    hertz,
    mindlin,
    solid_result,
    stationed_sphere,
    surface,
    with_stations,
)
from matplotlib.figure import Figure

import fretfe
from fretfe._typing import Array
from fretfe.results.model import Result


def drawn(result: Result) -> tuple[str, dict[str, Array]]:
    """Name of x, and what stands over it by the beginnings of the labels of a state."""
    (panel,) = fretfe.plot_tractions(result, Figure().subplots())
    lines = {str(each.get_label()).partition(",")[0]: each for each in panel.lines}
    values = {name: np.asarray(each.get_ydata()) for name, each in lines.items()}
    return panel.get_xlabel(), {**values, "x": np.asarray(lines["p"].get_xdata())}


@pytest.mark.parametrize("corners", [3, 4])
def test_fields_that_are_linear_on_a_bent_surface_are_read_exactly(corners: int) -> None:
    """From the facet of the largest pressure, which is at a corner of the surface, along z."""
    shape = surface(bend=0.3, corners=corners, count=6)
    result = solid_result({"main": shape})
    (history,) = result.solution.contacts
    s, z = shape.plane.T
    field = np.stack([40 + 3 * s + 2 * z, 5 - s, 1 + z], axis=1)
    linear = np.broadcast_to(field, history.traction.shape)
    history = replace(history, mean_traction=linear, status=np.ones_like(history.status))
    solution = replace(result.solution, contacts=(history,))
    label, found = drawn(replace(result, root_solution=solution))
    assert label == "from the largest pressure [mm]"
    # Across is where the second axis of the plane leads: one of s and z is constant on the line.
    p, bound = found["p"], found["±f p"]
    slope = np.polyfit(found["x"], p, 1)[0]
    np.testing.assert_allclose(p, p[0] + slope * (found["x"] - found["x"][0]), rtol=1e-12)
    assert abs(slope) == pytest.approx(2.0, rel=1e-12)
    assert np.ptp(found["x"]) == pytest.approx(3.0)
    np.testing.assert_allclose(abs(bound), FRICTION * p, rtol=1e-12)
    # q along the line is that along z, whose sign is that of the line; z from p.
    z = (p - (p.max() + p.min()) / 2) / 2
    np.testing.assert_allclose(abs(found["q"]), abs(1 + z), atol=1e-12)


def test_a_sphere_from_the_station_of_the_largest_range() -> None:
    sphere = stationed_sphere()
    load = np.linspace(0, SHEAR, len(sphere.loads.times))
    result = with_stations(sphere, lambda station: exact_station(station, load, 0.0))
    (contact,) = result.contacts
    worst = contact.fronts[0].worst
    label, found = drawn(result)
    assert worst is not None and label == f"from front 1, station {worst.number} [mm]"
    # The line leads through the middle; sides of facets are .12 long at most, and the shear has a
    # kink at .74.
    inside = abs(1 - found["x"]) < 0.6
    radius = abs(1 - found["x"])[inside]
    np.testing.assert_allclose(found["p"][inside], hertz(radius, 1.0), atol=2.0)
    cosine = worst.frame.inward[0]
    shear = mindlin(radius, SHEAR)[0]
    np.testing.assert_allclose(abs(found["q"][inside]), abs(cosine) * shear, atol=2.0)
    across = abs(found["q⊥"][inside])
    np.testing.assert_allclose(across, np.sqrt(1 - cosine**2) * shear, atol=2.0)
