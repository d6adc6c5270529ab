# SPDX-License-Identifier: LGPL-3.0-or-later
"""Local parameters of a Hertz contact in partial slip, against closed forms and sums."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, loop, problem

from fretfe.analytic.partial_slip import PartialSlip
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.stress import local_parameters
from fretfe.halfplane import solve_half_planes
from fretfe.history.solution import STICK

AMPLITUDE = 0.4 * LIMIT
# Largest slip is at the edges, which lie between two of 300 nodes.
ACCURACY = 1e-3


@pytest.fixture(scope="module")
def outcome():  # type: ignore[no-untyped-def]
    first = np.linspace(0.0, AMPLITUDE, 24)[1:]
    shear = np.concatenate([first, AMPLITUDE * np.cos(loop(24, 2))])
    return solve_half_planes(problem(LOAD, shear, cycle=24))


def test_closed_forms_of_partial_slip(outcome) -> None:  # type: ignore[no-untyped-def]
    (contact,) = outcome.solution.contacts
    found = local_parameters(contact, outcome.solution.loads.evaluated)
    exact = PartialSlip(HERTZ, LOAD, FRICTION)
    inside = np.abs(contact.surface.arc) < exact.half_width
    x = contact.surface.arc[inside]
    slip = 2 * np.abs(exact.slip(x, AMPLITUDE))
    assert found.slip_range[inside] == pytest.approx(slip, abs=ACCURACY * slip.max())
    assert not found.slip_range[~inside].any()
    # There and back.
    assert found.path == pytest.approx(2 * found.slip_range, rel=1e-9, abs=1e-12 * slip.max())
    bound = FRICTION * HERTZ.pressure(x, exact.half_width)
    expected = slip * bound
    # At the edges means around a node are not the values there.
    deep = np.abs(x) < 0.97
    assert found.ruiz[inside][deep] == pytest.approx(expected[deep], abs=3e-3 * expected.max())
    work = float(found.work @ contact.surface.weights)
    assert work == pytest.approx(exact.dissipation(AMPLITUDE), rel=ACCURACY)
    wear = float(FRICTION * found.pressed_path @ contact.surface.weights)
    assert wear == pytest.approx(work, rel=ACCURACY)


def test_the_sum_of_the_work_is_the_friction_work_of_the_cycle(outcome) -> None:  # type: ignore[no-untyped-def]
    (contact,) = outcome.solution.contacts
    found = local_parameters(contact, outcome.solution.loads.evaluated)
    (summary,) = evaluate(outcome.solution, outcome.unit_factors)
    assert float(found.work @ contact.surface.weights) == pytest.approx(
        summary.dissipation, rel=1e-12
    )


def test_slip_in_two_directions(outcome) -> None:  # type: ignore[no-untyped-def]
    """A node that slips round a square: the range is its diagonal, the path its circumference."""
    (contact,) = outcome.solution.contacts
    square = np.array([[0, 0], [3, 0], [3, 3], [0, 3], [0, 0]], dtype=float)
    states, nodes = len(square), len(contact.surface.arc)
    traction = np.zeros((states, nodes, 3))
    traction[..., 0], traction[..., 1] = 2.0, 1.0
    solid = replace(
        contact,
        slip=np.repeat(square[:, None], nodes, axis=1),
        mean_traction=traction,
        status=np.full((states, nodes), STICK, dtype=np.int8),
        dissipation=np.zeros((states, nodes)),
    )
    found = local_parameters(solid, (0, states - 1))
    assert found.slip_range == pytest.approx(3 * np.sqrt(2))
    assert found.path == pytest.approx(12.0)
    assert found.pressed_path == pytest.approx(24.0)
    assert found.ruiz == pytest.approx(3 * np.sqrt(2))
