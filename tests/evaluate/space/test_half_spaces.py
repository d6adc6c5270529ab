# SPDX-License-Identifier: LGPL-3.0-or-later
"""Factors around an ellipse and a circle against exact ones of bonded half-spaces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from evaluate.space.test_evaluate import STATIONS, grid, hertz, means, solved

from fretfe._typing import Array
from fretfe.evaluate.contacts import HalfSpaceRatios
from fretfe.evaluate.space.fronts import FrontTrack, follow_fronts
from fretfe.evaluate.space.half_spaces import (
    MORE_FRONTS,
    NO_ELLIPSE,
    NO_FACTORS,
    OPEN_FRONT,
    half_space_ratios,
)
from fretfe.history.solution import (
    ContactHistory,
    FullStickUnits,
    NearbyLoads,
    Solution,
    StationIntegrals,
)

NORMAL, SHEAR, TWIST = 3.0, np.array([0.6, 0.0, -0.8]), 0.5
# What the exact factors are multiplied with: K_I of P, K_T and K_S of Q, K_S of M.
FOUND = 1.01, 0.97, 1.02
Case = tuple[Solution, ContactHistory, FrontTrack]


def case(a: float, b: float) -> Case:
    """Drivers P, Q and M of an ellipse with half axes a along x and b along z."""
    points, facets = grid(half=1.3, across=1.8)
    solution, contact = solved(points, facets, [hertz(a, b)])
    (track,) = follow_fronts(solution, contact, STATIONS)
    factors = exact_factors(track, a, b) * np.array(FOUND)
    integrals = StationIntegrals(
        np.array([0]), np.zeros((1, STATIONS)), np.arange(2.0), np.array([[factors, factors]])
    )
    units = FullStickUnits(tractions(contact)[None], np.array([-1, 0]))
    scales = np.cbrt([0.95, 1.05])
    pressures = [means(points, facets, hertz(k * a, k * b, peak=k))[0] for k in scales]
    contact = replace(
        contact, integrals=integrals, full_stick=units,
        nearby_loads=NearbyLoads(np.array(pressures), np.ones((2, STATIONS))),
    )  # fmt: skip
    values = np.outer([0.0, 1.0], [1.0, 1.0, 1.0])
    return replace(solution, driver_values=values, contacts=(contact,)), contact, track


def exact_factors(track: FrontTrack, a: float, b: float) -> Array:
    """(n, 3, 3) K_I, K_T and K_S of P, Q and M."""
    frames = track.front.frames
    x, z = frames.points[:, 0], frames.points[:, 2]
    share = 1 / np.sqrt(2 * np.hypot(x / a**2, z / b**2)) / (2 * np.pi * a * b)
    factors = np.zeros((STATIONS, 3, 3))
    factors[:, 0, 0] = NORMAL * share
    factors[:, 1, 1], factors[:, 2, 1] = (
        share * (frames.inward @ SHEAR),
        share * (frames.along @ SHEAR),
    )
    factors[:, 2, 2] = -3 * TWIST / (4 * np.pi * a**2 * np.sqrt(2 * a)) if a == b else 0.0
    return factors


def tractions(contact: ContactHistory) -> Array:
    """(N, 3, 3) uniform tractions with these forces, and one that turns about the middle."""
    inside, w = contact.traction[-1, :, 0] > 0, contact.surface.weights
    area, arms = w @ inside, contact.surface.points
    fields = np.zeros((len(w), 3, 3))
    fields[:, 0, 0] = NORMAL / area * inside
    tangents = contact.surface.frames[:, 1:]
    fields[:, 1:, 1] = tangents @ SHEAR / area * inside[:, None]
    turned = np.cross([0.0, 1.0, 0.0], arms) * inside[:, None]
    size = w @ (inside * np.sum(turned**2, axis=1))
    fields[:, 1:, 2] = np.einsum("ntd,nd->nt", tangents, turned) * TWIST / size
    return fields


@pytest.fixture(scope="module")
def circle() -> Case:
    return case(1.0, 1.0)


def of(case: Case, **changes: Any) -> HalfSpaceRatios:
    solution, contact, track = case
    return half_space_ratios(solution, replace(contact, **changes), track, alone=True)


def test_circle(circle: Case) -> None:
    found = of(circle)
    assert found.reason == ""
    np.testing.assert_allclose(found.half_axes, 1.0, atol=0.01)
    assert [found.normal, found.shear, found.twist] == pytest.approx(FOUND, abs=0.01)
    assert found.pressure == pytest.approx(1.0, abs=0.03)


def test_ellipse_has_no_closed_form_of_torsion() -> None:
    found = of(case(1.0, 1.4))
    np.testing.assert_allclose(found.half_axes, [1.4, 1.0], atol=0.015)
    assert [found.normal, found.shear] == pytest.approx(FOUND[:2], abs=0.015)
    assert np.isnan(found.twist)


def test_forces_that_are_not_there_have_no_ratio(circle: Case) -> None:
    solution, contact, track = circle
    values = solution.driver_values * [1.0, 0.0, 0.0]
    found = half_space_ratios(replace(solution, driver_values=values), contact, track, alone=True)
    assert found.normal == pytest.approx(FOUND[0], abs=0.01)
    assert np.isnan([found.shear, found.twist]).all()


def test_reasons(circle: Case) -> None:
    solution, contact, track = circle
    assert half_space_ratios(solution, contact, track, alone=False).reason == MORE_FRONTS
    assert of(circle, integrals=None).reason == NO_FACTORS
    integrals = contact.integrals
    assert integrals is not None
    wavy = 0.1 * np.sin(4 * np.pi * np.arange(STATIONS) / STATIONS * 2)
    assert of(circle, integrals=replace(integrals, positions=wavy[None])).reason == NO_ELLIPSE
    strip = solved(*grid(), [lambda x, z: np.sqrt(np.clip(1 - x**2, 0.0, None))])
    opened, _ = follow_fronts(*strip, STATIONS)
    assert half_space_ratios(solution, contact, opened, alone=True).reason == OPEN_FRONT
