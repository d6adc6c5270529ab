# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress below the stations of a sphere under ±Q, from exact factors, tractions and stresses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from cases.solid_runs import FRICTION, PEAK, SHEAR, stationed_sphere
from evaluate.space.test_local import cycles, posed
from reference.point_loads import hertzian

from fretfe._typing import Array
from fretfe.case import Body
from fretfe.decision.field import EdgeField
from fretfe.decision.station_field import station_fields
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.stress import station_depths
from fretfe.results.model import Result
from fretfe.results.station_stress import StationStress

STICK = (1 - SHEAR) ** (1 / 3)


def exact(station: Station, points: Array, way: float) -> Array:
    """(M, 6) in body 2 at points inward and across of a front, by ±Q along x; ν = 0."""
    frame, x = station.frame, np.array([1.0, 0.0, 0.0])
    axes = np.array([x, np.cross(-frame.across, x), -frame.across])
    at = -frame.inward + np.outer(points[:, 0], frame.inward) + np.outer(points[:, 1], frame.across)
    found = hertzian(at @ axes.T, 1.0, PEAK, way * FRICTION * PEAK, 0.0)
    found -= hertzian(at @ axes.T, STICK, 0.0, way * FRICTION * PEAK * STICK, 0.0)
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    tensors = np.empty((len(points), 3, 3))
    for place, (i, j) in enumerate(pairs):
        tensors[:, i, j] = tensors[:, j, i] = found[:, place]
    own = axes @ np.array([frame.inward, frame.across, frame.along]).T
    turned = own.T @ tensors @ own
    return np.stack([turned[:, i, j] for i, j in pairs], axis=1)


@pytest.fixture
def sphere(monkeypatch: pytest.MonkeyPatch) -> Result:
    """Elements of a/11 whose stress is exact at two of them and more, at both ends of the cycle."""

    def direction(station: Station) -> float:
        x = np.array([1.0, 0.0, 0.0])
        return math.degrees(math.atan2(x @ station.frame.along, x @ station.frame.inward))

    result = posed(SHEAR * cycles(stationed_sphere()), direction)
    bodies = {name: Body(young=1e5, poisson=0.0) for name in result.case.bodies}
    result = replace(result, case=result.case.model_copy(update={"bodies": bodies}))
    stations = result.contacts[0].stations
    assert result.loads.cycle is not None
    first, last = result.loads.cycle
    shear = cycles(result)[first : last + 1]
    ends = np.sort([int(np.argmin(shear)), int(np.argmax(shear))])
    depths = np.array([station_depths(each) for each in stations])
    places = depths[:, -1:] * np.linspace(-1, 1, 9)
    points = np.stack(np.broadcast_arrays(places[:, None], -depths[..., None]), axis=-1)
    stress = np.array([
        [exact(each, own.reshape(-1, 2), shear[end]) for end in ends]
        for each, own in zip(stations, points, strict=True)
    ]).reshape(len(stations), 2, *points.shape[1:3], 6)  # fmt: skip
    # Before there is contact there is no stress.
    stress = np.concatenate([np.zeros_like(stress[:, :1]), stress], axis=1)
    known = StationStress(
        "main", depths, np.append(0, first + ends), tuple(each.front for each in stations),
        np.array([each.number for each in stations]),
        np.array([each.position[-1] for each in stations]), places, np.array([stress, stress]),
    )  # fmt: skip
    monkeypatch.setattr(Result, "has_station_stress", True)
    monkeypatch.setattr(Result, "station_stress", lambda *_: known)
    return result


def test_stress_is_that_of_half_spaces(sphere: Result) -> None:
    """From a tenth of the radius on, a fifth inside and outside too: 1 % of p0 on the average.

    Elements are used from two tenths on. The most is along the front, whose bend a polynomial has,
    and within its bar; yy and xy err less above the elements that are used: there the plane
    problem, whose pressure falls faster than Hertz's, goes over into that of nodes.
    """
    points = np.stack(np.meshgrid([-0.2, 0.0, 0.2], [-0.1, -0.15, -0.2, -0.4]), axis=-1)
    points, above = points.reshape(-1, 2), slice(0, 9)
    shear = cycles(sphere)
    for station, (_, field) in station_fields(sphere, sphere.contacts[0]):
        assert isinstance(field, EdgeField), field
        for state, own in zip(field.states, field.stress(points), strict=True):
            wrong = (own - (state > 0) * exact(station, points, shear[state])) / PEAK
            assert PEAK * np.abs(wrong).max() < field.smooth.spread < 0.06 * PEAK
            assert np.abs(wrong[above][:, [1, 3]]).max() < 0.025
            assert np.sqrt(np.mean(wrong**2)) < 0.01


def test_tension_at_the_front(sphere: Result) -> None:
    """p0 (1 - 2 ν)/3 and f p0 π (4 + ν)/8 cos θ of a sphere that slides, less that of the core.

    The core is far enough for quadrature, and cos θ that of shear along x whose size depends on
    the radius alone.
    """
    core = hertzian(np.array([[-1.0, 0.0, 0.0]]), STICK, 0.0, STICK, 0.0)[0, 0]
    sheared = FRICTION * (math.pi / 2 - core)
    shear, at_edge = cycles(sphere), np.zeros((1, 2))
    for station, (_, field) in station_fields(sphere, sphere.contacts[0]):
        assert isinstance(field, EdgeField)
        known = 1 / 3 + shear[field.states] * sheared * station.frame.inward[0]
        known[field.states == 0] = 0
        assert field.stress(at_edge)[:, 0, 0] / PEAK == pytest.approx(known, abs=0.02)
