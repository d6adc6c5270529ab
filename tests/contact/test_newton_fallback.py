# SPDX-License-Identifier: LGPL-3.0-or-later
"""The slow method, and what the march does when Newton fails."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from cases.marching import march_through
from reference import halfplane_interface as halfplane
from reference import halfspace
from reference.halfplane_interface import Flank
from reference.halfspace import SphereOnFlat

from fretfe.contact.interface import Interface
from fretfe.contact.linear_operator import FactoredOperator
from fretfe.contact.march import MAX_CUTS, March, StepResult
from fretfe.contact.newton import Newton, NotConverged, status_by_fixed_point
from fretfe.contact.state import ContactState, StepLoads, certify, unloaded
from fretfe.errors import ConvergenceError

Solve = Callable[..., tuple[ContactState, int]]

FRICTION = 0.5
FORCE = ("force", "force", "fixed")
TRAVEL = ("displacement", "displacement", "fixed")
SPHERE = SphereOnFlat(cells=15, nu=0.3)


def cylinder(controls: tuple[str, ...] = FORCE, beta: float = 0.2) -> Interface:
    nodes = np.arange(-1.5, 1.5, 0.03) + 0.003
    return halfplane.build([Flank(nodes, halfplane.parabola(1.0))], controls, beta=beta)


def blade(beta: float) -> Interface:
    nodes = np.arange(-1.5, 1.5, 0.03) + 0.003
    flanks = [
        Flank(nodes, halfplane.parabola(3.0), 45.0, (3.0, 0.0)),
        Flank(-nodes[::-1], halfplane.parabola(3.0), -45.0, (-3.0, 0.0)),
    ]
    return halfplane.build(flanks, ("free", "force", "free"), beta=beta)


def plane(interface: Interface, values: tuple[float, ...], friction: float = FRICTION) -> StepLoads:
    return halfplane.loads(interface, values, friction)


def space(ratio: float) -> tuple[Interface, StepLoads]:
    interface, load = halfspace.build(SPHERE), SPHERE.load_for(1.0)
    shear = ratio * FRICTION * load
    return interface, halfspace.loads(interface, (-load, 0.8 * shear, 0.6 * shear), FRICTION)


def under_force(ratio: float, beta: float = 0.2) -> tuple[Interface, StepLoads]:
    interface = cylinder(beta=beta)
    return interface, plane(interface, (ratio * FRICTION * 0.8, -0.8, 0.0))


def under_displacement(travel: float) -> tuple[Interface, StepLoads]:
    interface = cylinder(TRAVEL)
    return interface, plane(interface, (travel, -2.5, 0.0))


def on_flanks(friction: float, beta: float) -> tuple[Interface, StepLoads]:
    interface = blade(beta)
    return interface, plane(interface, (0.0, -0.8, 0.0), friction)


CASES: dict[str, Callable[[], tuple[Interface, StepLoads]]] = {
    "plane, normal force": lambda: under_force(0.0),
    "plane, partial slip": lambda: under_force(0.7),
    "plane, nearly sliding": lambda: under_force(0.97),
    "plane, similar materials": lambda: under_force(0.7, 0.0),
    "plane, similar materials, nearly sliding": lambda: under_force(0.97, 0.0),
    "plane, gap closed by displacement": lambda: under_displacement(0.3),
    "plane, gross slip": lambda: under_displacement(3.0),
    "blade slides": lambda: on_flanks(0.2, 0.0),
    "blade sticks": lambda: on_flanks(1.1, 0.2),
    "blade on dissimilar material": lambda: on_flanks(0.9, 0.2),
    "space, normal force": lambda: space(0.0),
    "space, partial slip": lambda: space(0.7),
    "space, nearly sliding": lambda: space(0.95),
}


@pytest.mark.parametrize("make", CASES.values(), ids=CASES.keys())
def test_newton_needs_few_iterations_from_a_cold_start(
    make: Callable[[], tuple[Interface, StepLoads]],
) -> None:
    interface, loads = make()
    state = unloaded(interface)
    reference = state.relative[:, 1:]
    operator = FactoredOperator(interface)
    status, direction = status_by_fixed_point(operator, loads, reference, state.traction)
    solved, iterations = Newton(operator).solve(loads, reference, status, direction)
    # The status of a few nodes at the borders may be wrong: their traction is below the tolerance.
    assert np.count_nonzero(solved.status != status) <= 0.03 * interface.size
    assert iterations <= 12
    assert certify(interface, loads, solved, reference).worst < 1e-8


WALK = np.array([[0, 0, 0], [0.0, -0.8, 0], [0.3, -0.8, 0], [-0.2, -0.5, 0], [0.1, -0.9, 0]])


def march(interface: Interface) -> list[StepResult]:
    return list(march_through(March(interface), [plane(interface, tuple(row)) for row in WALK]))


def always(failing: Callable[[int], bool]) -> Callable[[Solve], Solve]:
    """Newton that gives up on the calls (counted from 1) for which `failing` is true."""

    def wrap(solve: Solve) -> Solve:
        calls = 0

        def unreliable(self: Newton, *arguments: object) -> tuple[ContactState, int]:
            nonlocal calls
            calls += 1
            if failing(calls):
                raise NotConverged("made to fail", 7)
            return solve(self, *arguments)

        return unreliable

    return wrap


def test_march_falls_back_and_finds_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    interface = cylinder()
    expected = march(interface)
    # Every first attempt fails; the second starts from the slow method's status, but while the
    # body is loose from where it touches first.
    monkeypatch.setattr(Newton, "solve", always(lambda call: call % 2 == 1)(Newton.solve))
    found = march(interface)
    assert [result.fallbacks for result in found] == [0, 1, 1, 1]
    assert [result.parts for result in found] == [1] * 4
    assert all(result.iterations > 7 for result in found)  # those of the failure count
    assert max(result.certificate.worst for result in found) < 1e-8
    for one, two in zip(expected, found, strict=True):
        np.testing.assert_array_equal(two.state.status, one.state.status)
        np.testing.assert_allclose(two.state.traction, one.state.traction, rtol=0, atol=1e-10)


def test_march_cuts_a_step_that_fails_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton and the slow method fail in step 3: two halves instead, of which nothing is lost."""
    interface = cylinder()
    halved = np.insert(WALK, 3, (WALK[2] + WALK[3]) / 2, axis=0)
    expected = list(
        march_through(March(interface), [plane(interface, tuple(row)) for row in halved])
    )
    monkeypatch.setattr(Newton, "solve", always(lambda call: call in (3, 4))(Newton.solve))
    found = march(interface)
    assert [result.parts for result in found] == [1, 1, 2, 1]
    np.testing.assert_allclose(
        found[2].state.traction, expected[3].state.traction, rtol=0, atol=1e-12
    )
    halves = expected[2].dissipation + expected[3].dissipation
    np.testing.assert_allclose(found[2].dissipation, halves, rtol=0, atol=1e-12)
    assert found[2].iterations == expected[2].iterations + expected[3].iterations


def test_march_gives_up_after_all_cuts(monkeypatch: pytest.MonkeyPatch) -> None:
    interface = cylinder()
    monkeypatch.setattr(Newton, "solve", always(lambda call: call > 2)(Newton.solve))
    steps = [plane(interface, tuple(row)) for row in WALK]
    marching = march_through(March(interface), steps)
    next(marching), next(marching)
    message = rf"step 3 of 4 .*: made to fail .*halving the step {MAX_CUTS} times.*the 2 steps"
    with pytest.raises(ConvergenceError, match=message):
        next(marching)


def test_a_guess_without_contact_is_none() -> None:
    """From there a body whose own stiffness errs by round-off would come to rest anywhere."""
    interface, loads = under_force(0.5)
    count = len(interface.stiffness)
    interface = replace(interface, stiffness=interface.stiffness - 1e-12 * np.eye(count))
    start = plane(interface, (0.0, 0.0, 0.0))
    state = unloaded(interface)
    assert not state.closed.any()
    result = March(interface).advance(state, start, loads, guess=state)
    force = interface.roots @ result.state.traction
    assert np.abs(force) == pytest.approx([0.8, 0.2], rel=1e-6)
