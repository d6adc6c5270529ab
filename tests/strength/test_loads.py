# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors of a test from its loads, against closed forms and half-planes with a history."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import SLIDING, pad, press, pull, shear

from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, peak_pressure
from fretfe.backends import RunOptions
from fretfe.backends.halfplane import BACKEND
from fretfe.case import parse_case
from fretfe.idealise.bodies import Block, read_block
from fretfe.mesh.templates import check_parameters, find_template
from fretfe.strength.loads import PadEdge, PadLoads, edge_of

E_STAR = 210e3 / (2 * (1 - 0.3**2))
CYLINDER = Hertz(50.0, E_STAR)
INFINITE = (math.inf, math.inf)


def loads(
    shear: float = 40.0, bulk: complex = 0.0, *, profile: Profile = CYLINDER,
    height: float = math.inf, force: float = 400.0, yield_stress: float = math.inf,
) -> PadLoads:  # fmt: skip
    block = Block(profile, math.inf, (math.inf, height), INFINITE, math.inf)
    return PadLoads(block, force, shear, bulk, 0.4, yield_stress)


def test_a_cylinder_in_closed_form() -> None:
    """K_N = E*/(2R) √(2a), ΔK_T = 2 Q/(π √(2a)), and d of Cattaneo and Mindlin."""
    edge = edge_of(loads())
    a = math.sqrt(4 * 400 * 50 / (math.pi * E_STAR))
    assert edge.k_n == pytest.approx(E_STAR / 100 * math.sqrt(2 * a))
    assert edge.k_t_range == pytest.approx(2 * 40 / (math.pi * math.sqrt(2 * a)))
    assert edge.slip == pytest.approx(edge.k_t_range / (0.4 * edge.k_n))
    stick = a * math.sqrt(1 - 40 / (0.4 * 400))
    assert edge.slip / (1 + edge.error) == pytest.approx(a - stick)
    assert not edge.outside and not edge.reverses


@pytest.mark.parametrize(
    ("profile", "radius", "slip", "bulk"),
    [
        (CYLINDER, 50.0, 0.75, 0.0),
        (FlatRounded(0.5, 50.0, E_STAR), 50.0, 0.6, 0.0),
    ],
)
def test_d_of_partial_slip(profile: Profile, radius: float, slip: float, bulk: float) -> None:
    """Against the exact zone of the steady cycle between ±Q."""
    edge = edge_of(loads(slip * 40, profile=profile))
    contact = PartialSlip(profile, 400.0, 0.4)
    exact = contact.half_width - contact.cyclic_stick_half_width(slip * 40, slip * 40, rising=True)
    assert edge.slip / (1 + edge.error) == pytest.approx(float(exact), rel=1e-9)


@pytest.mark.parametrize(
    ("force", "tension", "lag"), [(60.0, 0.0, 0.0), (40.0, 40.0, 180.0), (20.0, 80.0, 90.0)]
)
def test_bulk_and_height_as_in_a_run(force: float, tension: float, lag: float) -> None:
    """A block of a height, held at its left end and pulled at the right one."""
    bulk = pull(tension or 1e-6, phase=-lag, steps=24)
    bulk["history"][1]["mean"] = tension * math.sin(math.radians(lag))
    tables = pad(
        loads={"press": press(), "shear": shear(force, steps=24), "bulk": bulk}, supports=SLIDING
    )
    case = parse_case(tables)
    (contact,) = BACKEND.solve(case, RunOptions()).contacts
    values = check_parameters(find_template("cylinder", length="mm"), case.geometry.parameters)
    block = read_block("cylinder", values, case)
    found = edge_of(
        PadLoads(block, 600, force, cmath.rect(tension, -math.radians(lag)), 0.4, math.inf)
    )
    worst: Any = max(contact.stations, key=lambda each: each.k_range)
    assert found.k_n == pytest.approx(worst.reported_k_n, rel=1e-6)
    assert found.k_t_range == pytest.approx(worst.k_range, rel=1e-4)
    zone = worst.longest_zone
    assert found.slip / (1 + found.error) == pytest.approx(zone.length, rel=4e-3)
    assert found.reverses == (tension > 2 * force)


def test_a_held_end_carries_the_shear_force() -> None:
    """Q/(2 height) besides, in phase with Q."""
    tall, low = edge_of(loads(bulk=10.0 + 2.0)), edge_of(loads(bulk=10.0, height=10.0))
    assert low.k_t_range == pytest.approx(tall.k_t_range)
    assert low.size_errors[0] > 0 and tall.size_errors == (0, 0)


def reason(test: PadLoads) -> str:
    edge: PadEdge = edge_of(test)
    assert edge.k_n > 0 and edge.k_t_range > 0
    return edge.outside


def test_what_lies_outside() -> None:
    assert reason(loads(160.0)) == "the contact slides as a whole: Q = 160, f P = 160"
    assert reason(loads(161.0)).startswith("the contact slides as a whole")
    # -d/(2a) of a cylinder is a tenth at Q = .36 f P.
    assert reason(loads(0.35 * 160)) == ""
    assert reason(loads(0.37 * 160)).startswith("the slip zone is too long: d is 0.19 of a, ")
    assert "-23 % off" in reason(loads(0.7 * 160))
    assert reason(loads(height=0.9)).startswith("it is no half-plane: the half-width of the cont")
    largest = peak_pressure(CYLINDER, float(CYLINDER.half_width(400.0)))
    assert largest == pytest.approx(math.sqrt(400 * E_STAR / (math.pi * 50)))
    assert reason(loads(yield_stress=1.01 * largest / 1.67)) == ""
    assert reason(loads(yield_stress=0.99 * largest / 1.67)).startswith("it yields: the largest p")
    assert reason(loads(bulk=500.0, yield_stress=490.0)) == "it yields: the bulk stress is 500"


def test_a_large_bulk_stress_reverses_slip() -> None:
    """Both edges slip in opposite directions from a tension of 4 Q/(π a) on."""
    limit = 4 * 10 / (math.pi * float(CYLINDER.half_width(400.0)))
    below, above = (edge_of(loads(10.0, factor * limit)) for factor in (0.99, 1.01))
    assert (below.reverses, above.reverses) == (False, True)
    far = edge_of(loads(10.0, 20 * limit))
    assert np.isnan(far.error) or abs(far.error) > 0.1
    assert "the bulk stress reverses the slip of the other edge" in far.outside
