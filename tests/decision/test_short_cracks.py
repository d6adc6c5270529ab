# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cracks from the edges of half-planes: uniform fields, mirrored edges, size of a contact."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from cases.stored_runs import solved
from reference.elliptical_stress import elliptical_stress

from fretfe._typing import Array
from fretfe.analytic.cracks import EdgeCracks
from fretfe.analytic.partial_slip import (
    PartialSlip,
    shear_moderate_tension,
)
from fretfe.analytic.profiles import Hertz
from fretfe.decision.field import EdgeField, SmoothStress, edge_field
from fretfe.decision.near_field import NearField
from fretfe.decision.short_cracks import (
    CRACK_ANGLES,
    CrackDrive,
    crack_drive,
    first_length,
    judge_arrest,
)
from fretfe.decision.thresholds import FatigueLimit, Threshold, opening_range, short_length

# An aluminium alloy, for illustration: MPa √mm and MPa.
THRESHOLD = Threshold(np.array([0.0]), np.array([4.2 * math.sqrt(1000)]), 0.5)
LIMIT = FatigueLimit(248.0, 0.0)
SHORTEST = first_length(short_length(THRESHOLD, LIMIT))


def field_of(edge: int, body: int) -> EdgeField:
    contact = solved("halfplane").contacts[0]
    found = edge_field(solved("halfplane"), contact, contact.stations[edge], body)
    assert isinstance(found, EdgeField)
    return found


def under_tension(tension: Array) -> EdgeField:
    """Without a contact."""
    field = field_of(0, 1)
    nodes = np.array([-1.0, 0.0, 1.0])
    none = np.zeros((len(tension), 3))
    values = np.zeros((len(tension), 1, 4))
    values[:, 0, 0] = tension
    return replace(
        field,
        states=np.arange(len(tension)),
        near=NearField(nodes, none, none, 0.3),
        smooth=replace(field.smooth, values=values),
    )


def test_uniform_tension_at_any_angle() -> None:
    drive = crack_drive(
        under_tension(np.array([0.0, 100.0])), SHORTEST, np.array([-45.0, 0.0, 45.0])
    )
    scale = 100 * np.sqrt(np.pi * drive.lengths)
    # Places at which the stress is known limit slanted cracks no less than straight ones.
    assert np.isfinite(drive.k_1[1]).all(axis=1).tolist() == [True, False, True]
    assert drive.k_1[1, 2] / scale == pytest.approx(0.705, abs=5e-4)
    assert drive.k_2[1, 2] / scale == pytest.approx(0.3645, abs=5e-4)
    assert drive.ranges[0] == pytest.approx(np.hypot(0.705, 0.3645) * scale, rel=1e-3)
    known = np.isfinite(drive.ranges[1])
    assert drive.ranges[1, known] == pytest.approx(1.1215 * scale[known], rel=1e-3)


def test_a_crack_below_an_edge_by_points_of_its_own() -> None:
    """Interpolated along the ray as well as at the places of the quadrature themselves."""
    field = field_of(0, 1)
    drive = crack_drive(field, SHORTEST, np.array([20.0]))
    cracks = EdgeCracks.of(np.radians([20.0]))
    lengths = drive.lengths[[3, 15, 30]]
    points = cracks.points(lengths)
    stress = field.stress(points.reshape(-1, 2)).reshape(-1, *points.shape[:-1], 4)[..., [0, 1, 3]]
    k_1, k_2 = cracks.factors(lengths, stress)
    scale = np.abs(k_1).max(axis=0)[0]
    assert np.abs(drive.k_1[:, 0, [3, 15, 30]] - k_1[:, 0]).max(axis=0) / scale == pytest.approx(
        [0, 0, 0], abs=3e-3
    )
    assert np.abs(drive.k_2[:, 0, [3, 15, 30]] - k_2[:, 0]).max(axis=0) / scale == pytest.approx(
        [0, 0, 0], abs=3e-3
    )


def test_the_four_edges_of_two_equal_bodies_are_one() -> None:
    """Half a cycle apart: the ranges of both bodies at both edges agree."""
    ranges = [
        crack_drive(field_of(edge, body), SHORTEST).ranges for edge in (0, 1) for body in (0, 1)
    ]
    for other in ranges[1:]:
        assert other == pytest.approx(ranges[0], rel=0.01, abs=0.5, nan_ok=True)


def pulled(tension: float) -> EdgeField:
    """The body that Q pulls, at its trailing edge, with a tension in phase with that."""
    field = field_of(0, 1)
    phase = solved("halfplane").solution.driver_values[field.states, 0] / 60
    values = field.smooth.values.copy()
    values[:, 0, 0] += tension * phase
    return replace(field, smooth=replace(field.smooth, values=values))


def test_the_margin_is_the_factor_that_makes_a_crack_grow_through() -> None:
    drive = crack_drive(pulled(60.0), SHORTEST)
    found = judge_arrest(drive, THRESHOLD, LIMIT)
    assert not isinstance(found, str)
    assert found.a0 == pytest.approx(short_length(THRESHOLD, LIMIT))
    assert math.isfinite(found.margin) and found.start < found.margin
    for factor in (
        0.99 * found.start,
        1.01 * found.start,
        0.99 * found.margin,
        1.01 * found.margin,
    ):
        scaled = judge_arrest(replace(drive, ranges=factor * drive.ranges), THRESHOLD, LIMIT)
        assert not isinstance(scaled, str)
        assert scaled.critical.angle == found.critical.angle
        if factor < found.start:
            assert scaled.deepest.stop == 0
        elif factor < found.margin:
            assert 0 < scaled.deepest.stop <= scaled.deepest.lengths[-1]
        else:
            assert scaled.deepest.stop == math.inf
            assert scaled.deepest.angle == found.critical.angle


def test_a_straight_crack_stops_where_a_weight_function_has_it() -> None:
    """Under the stress of McEwen and Cattaneo; Bueckner's (1970) function is right to 1 %."""
    e_star = 210e3 / (2 * (1 - 0.3**2))
    a = math.sqrt(4 * 600 * 50 / (math.pi * e_star))
    p0, share = 2 * 600 / (math.pi * a), math.sqrt(1 - 60 / (0.4 * 600))
    places, weights = np.polynomial.legendre.leggauss(100)
    roots = (1 + places) / 2
    kernel = (1 + 0.6147 * roots**2 + 0.2502 * roots**4) * weights

    def relative(length: float) -> float:
        depth = length * (1 - roots**2)
        here = np.full_like(depth, -a)
        pulled = elliptical_stress(here, depth, a, p0, 0.4 * p0)[:, 0]
        pulled -= elliptical_stress(here, depth, share * a, 0.0, 0.4 * share * p0)[:, 0]
        k = math.sqrt(2 * length / math.pi) * float(kernel @ pulled)
        return k / (THRESHOLD.ranges[0] * math.sqrt(length / (length + 10 * SHORTEST)))

    stops = []
    for shortest, angles in (
        (SHORTEST, np.array([0.0])),
        (SHORTEST, CRACK_ANGLES),
        (1e-4 * SHORTEST, CRACK_ANGLES),
    ):
        drive = crack_drive(field_of(0, 1), shortest, angles)
        opened = opening_range(drive.k_1, 0 * drive.k_2)[0]
        for ranges in (opened, drive.ranges):
            found = judge_arrest(replace(drive, ranges=2.5 * ranges), THRESHOLD, LIMIT)
            assert not isinstance(found, str)
            stops.append(found.deepest.stop)
    assert 2.5 * relative(stops[0]) == pytest.approx(1, abs=0.02)
    # K_II adds to it, other angles stop later, and the shortest length does not matter.
    assert stops[5] == pytest.approx(stops[3], rel=0.01) and stops[3] >= stops[1] >= stops[0] > 0


def test_the_deepest_crack_need_not_be_the_one_that_sets_the_margin() -> None:
    """At one angle cracks start and stop, at another none starts, but pressure hardly closes it."""
    lengths = SHORTEST * np.array([1.0, 10.0, 100.0, 200.0])
    long = THRESHOLD.ranges[0] * np.sqrt(lengths / (lengths + 10 * SHORTEST))
    ranges = np.array([[1.5, 1.2, 0.2, 0.3], [0.9, 0.9, 0.8, 0.7]]) * long
    none = np.zeros((2, 2, 4))
    cut = np.array([False, True])
    drive = CrackDrive(np.array([0.0, -50.0]), lengths, none, none, ranges, np.zeros((2, 4)), cut)
    found = judge_arrest(drive, THRESHOLD, LIMIT)
    assert not isinstance(found, str)
    assert found.deepest.angle == 0 and lengths[1] < found.deepest.stop < lengths[2]
    assert found.critical.angle == -50 and found.critical.stop == 0
    assert found.margin == pytest.approx(1 / 0.7) and found.start == pytest.approx(1 / 1.5)
    # That one leaves what is known, and may stop beyond.
    assert found.critical.cut and found.largest == pytest.approx(1 / 0.2)
    # One that is nearest to stopping at the last length may stop beyond, however deep that is.
    falling = replace(
        drive,
        cut=cut & False,
        lengths=lengths[:3],
        ranges=drive.ranges[:, :3],
        ratios=none[0, :, :3],
    )
    known = judge_arrest(falling, THRESHOLD, LIMIT)
    assert not isinstance(known, str)
    assert known.margin == pytest.approx(1 / 0.8) and known.largest == math.inf


def test_longer_cracks_do_not_show_what_starts() -> None:
    drive = crack_drive(field_of(0, 1), 2 * SHORTEST)
    found = judge_arrest(drive, THRESHOLD, LIMIT)
    assert not isinstance(found, str) and math.isnan(found.start)


def test_the_contact_alone_stops_its_cracks() -> None:
    """What presses the bodies together closes long cracks, whatever the shear is."""
    drive = crack_drive(field_of(0, 1), SHORTEST)
    found = judge_arrest(replace(drive, ranges=3 * drive.ranges), THRESHOLD, LIMIT)
    assert not isinstance(found, str)
    assert found.margin == math.inf and found.start < 1
    assert 0 < found.deepest.stop < found.deepest.lengths[-1]


def test_no_crack_under_pressure() -> None:
    drive = crack_drive(under_tension(np.array([-100.0, -20.0])), SHORTEST)
    found = judge_arrest(drive, THRESHOLD, LIMIT)
    assert not isinstance(found, str)
    assert found.margin == found.start == math.inf and found.deepest.stop == 0


def test_thresholds_that_do_not_reach() -> None:
    drive = crack_drive(under_tension(np.array([80.0, 100.0])), SHORTEST)
    table = Threshold(np.array([0.0, 0.5]), np.array([130.0, 100.0]))
    assert "R = 0.8" in str(judge_arrest(drive, table, LIMIT))


def cylinder(radius: float) -> EdgeField:
    """The pulled body at the trailing edge, at the two extremes of Q and of the bulk stress.

    p0 = 157 MPa, Q/P = .45, f = .75 and a bulk stress of 92.7 MPa, aluminium: specimens of Nowell
    and Hills (1990), of which those with large pads failed.
    """
    e_star, friction, share, bulk = 74e3 / (2 * (1 - 0.33**2)), 0.75, 0.45, 92.7
    a = 157 * 2 * radius / e_star
    force = math.pi * a * 157 / 2
    contact = PartialSlip(Hertz(radius, e_star), force, friction)
    inner = -a + a * np.geomspace(1e-7, 1e-2, 50)
    x = np.union1d(a * np.cos(np.linspace(0, np.pi, 401)), inner)
    pressure = 157 * np.sqrt(np.maximum(1 - (x / a) ** 2, 0))
    shear = shear_moderate_tension(contact, np.clip(x, -a, a), share * force, bulk)
    pressure[[0, -1]] = shear[[0, -1]] = 0
    values = np.zeros((2, 1, 4))
    values[:, 0, 0] = bulk, -bulk
    reach = 4 * a
    return EdgeField(
        "main", "left", "lower", np.arange(2), 0.0,
        NearField(x + a, np.array([pressure, pressure]), np.array([shear, -shear]), 0.33),
        SmoothStress(np.zeros((1, 2), dtype=np.int64), 1.0, values, 0.0, reach, (reach, reach)),
    )  # fmt: skip


def test_small_contacts_stop_their_cracks_and_large_ones_do_not() -> None:
    """At the same stresses everywhere but for the size: one critical size, monotone."""
    drives = [crack_drive(cylinder(radius), SHORTEST) for radius in (12.5, 50, 100, 150)]
    found = [judge_arrest(each, THRESHOLD, LIMIT) for each in drives]
    margins = [each.margin for each in found if not isinstance(each, str)]
    assert margins == sorted(margins, reverse=True) and len(margins) == 4
    assert margins[1] > 1.1 > 1 > margins[2]
    stopped = [each.deepest.stop for each in found if not isinstance(each, str)]
    assert math.isfinite(stopped[1]) and stopped[2] == stopped[3] == math.inf
