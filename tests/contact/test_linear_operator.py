# SPDX-License-Identifier: LGPL-3.0-or-later
"""What every interface operator has to do, on random problems solved directly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fretfe._typing import Array, Bools
from fretfe.contact import dense, linear_operator
from fretfe.contact.interface import Coordinate, DenseCompliance, Interface
from fretfe.contact.linear_operator import (
    Conditions,
    ContactOrder,
    DirectSystem,
    FactoredOperator,
    Response,
    unknown_tractions,
)
from fretfe.contact.state import OPEN, SLIP, STICK

NODES = 40
CASES = 3
CONTROLS = ("force", "displacement", "fixed", "displacement")
# Round-off of random systems of a hundred unknowns.
SAME = 1e-9

OPERATORS = pytest.mark.parametrize("make", [FactoredOperator])
DIMENSIONS = pytest.mark.parametrize("d", [2, 3])


@pytest.fixture(params=[True, False], ids=["directly", "with the inverse"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of solving systems, whatever pays."""
    monkeypatch.setattr(ContactOrder, "direct_pays", lambda *_: request.param)


def problem(d: int) -> Interface:
    rng = np.random.default_rng(d)
    size, count = NODES * d, len(CONTROLS)
    root, stiff = rng.standard_normal((size, size)), rng.standard_normal((count, count))
    return Interface(
        components=d,
        compliance=DenseCompliance(root @ root.T / size + np.eye(size)),
        gap=rng.standard_normal(size),
        motion=rng.standard_normal((size, count)),
        stiffness=stiff @ stiff.T,
        loads=np.zeros((size, 0)),
        coordinate_loads=np.zeros((count, 0)),
        roots=np.ones(NODES),
        coordinates=tuple(Coordinate(f"c{j}", "body", c) for j, c in enumerate(CONTROLS)),
        contacts={"main": slice(0, NODES)},
    )


def conditions(interface: Interface, known: Bools) -> Conditions:
    """Every third node open, stuck and slipping; directions that turn."""
    rng, tangents = np.random.default_rng(9), interface.components - 1
    return Conditions(
        status=np.tile([STICK, SLIP, OPEN], NODES)[:NODES].astype(np.int8),
        pull=0.5 * rng.standard_normal((NODES, tangents)),
        turning=rng.uniform(0.0, 1.0, NODES),
        penalty=rng.uniform(0.5, 1.5, NODES),
        known=known,
        amplitudes=rng.standard_normal((known.sum(), CASES)),
    )


def matrix_of(interface: Interface) -> Array:
    """A, column by column."""
    unit = np.eye(len(interface.gap))
    return np.array([interface.compliance.apply(column) for column in unit]).T


def turning_matrix(wanted: Conditions, node: int) -> Array:
    """T of a slipping node; nothing turns in the plane."""
    pull = wanted.pull[node]
    across = np.eye(len(pull)) - np.outer(pull, pull) / max(pull @ pull, 1e-300)
    return np.asarray(wanted.turning[node] * across * (len(pull) > 1))


def solved_directly(
    interface: Interface, wanted: Conditions, free: Array, forces: Array
) -> tuple[Array, Array, Array]:
    """y, w and c by one system for the tractions and coordinates, one row for each condition."""
    d, size = interface.components, NODES * interface.components
    flat = free.reshape(size, -1)
    displacement = np.hstack([matrix_of(interface), interface.motion])
    system = np.vstack(
        [displacement, np.hstack([-interface.motion.T, interface.stiffness])]
    )  # w - free and R + H a by all unknowns
    rhs = np.vstack([-flat, forces])
    traction = np.eye(*displacement.shape)
    for node, status in enumerate(wanted.status):
        rows = np.arange(d * node, d * (node + 1))
        if status == OPEN:
            system[rows], rhs[rows] = traction[rows], 0.0
        if status == SLIP:
            shear, turning = rows[1:], turning_matrix(wanted, node)
            r = wanted.penalty[node]
            trial = traction[shear] - r * displacement[shear]
            system[shear] = traction[shear] - turning @ trial
            system[shear] -= np.outer(wanted.pull[node], traction[rows[0]])
            rhs[shear] = -r * turning @ flat[shear]
    known = size + np.flatnonzero(wanted.known)
    system[known], rhs[known] = np.eye(len(system))[known], wanted.amplitudes
    solve = np.linalg.pinv(system, 1e-12) if wanted.floating else np.linalg.inv(system)
    unknowns = solve @ rhs
    relative = flat + displacement @ unknowns
    return unknowns[:size].reshape(NODES, d, -1), relative.reshape(NODES, d, -1), unknowns[size:]


def assert_solved_directly(
    found: Response, interface: Interface, wanted: Conditions, free: Array, forces: Array
) -> None:
    traction, relative, coordinates = solved_directly(interface, wanted, free, forces)
    np.testing.assert_allclose(found.traction, traction, atol=SAME)
    np.testing.assert_allclose(found.relative, relative, atol=SAME)
    np.testing.assert_allclose(found.coordinates, coordinates, atol=SAME)


def loads(interface: Interface) -> tuple[Array, Array]:
    rng = np.random.default_rng(5)
    free = rng.standard_normal((NODES, interface.components, CASES))
    return free, rng.standard_normal((len(interface.coordinates), CASES))


@pytest.mark.parametrize("known", [np.array([False, True, True, True]), np.zeros(4, dtype=bool)])
def test_a_direct_system_is_the_same_without_its_matrix(known: Bools) -> None:
    interface = problem(3)
    system = DirectSystem(interface, conditions(interface, known))
    size = system.count + len(CONTROLS)
    columns = np.stack([system.apply(unit) for unit in np.eye(size)], axis=1)
    np.testing.assert_allclose(columns, system.matrix(), rtol=0.0, atol=1e-12)


@pytest.mark.usefixtures("way")
@OPERATORS
@DIMENSIONS
@pytest.mark.parametrize(
    "known",
    [[False, True, True, True], [False, False, True, False]],
    ids=["driven by displacement", "driven by force"],
)
def test_release_meets_the_conditions(make: type[FactoredOperator], d: int, known: Bools) -> None:
    interface = problem(d)
    operator = make(interface)
    wanted = conditions(interface, np.array(known))
    free, forces = loads(interface)
    area = operator.area(wanted.status != OPEN, free[:, 0, 0])
    found = area.stuck(free, forces).release(wanted)
    assert_solved_directly(found, interface, wanted, free, forces)


@pytest.mark.usefixtures("way")
@OPERATORS
@DIMENSIONS
@pytest.mark.parametrize(
    "status", [[SLIP, SLIP, SLIP, OPEN], [SLIP, SLIP, OPEN, *[SLIP] * 9, STICK]]
)
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_contacts_most_of_which_slide(
    make: type[FactoredOperator], d: int, friction: float, status: list[int]
) -> None:
    """Without friction a direction turns freely, as that of a node that just closed."""
    interface = problem(d)
    wanted = conditions(interface, np.array([False, True, True, True]))
    wanted = replace(
        wanted,
        status=np.tile(status, NODES)[:NODES].astype(np.int8),
        pull=2 * friction * wanted.pull,
    )
    if interface.components == 2:  # solved by the factors of sliding contacts
        counts = np.bincount(wanted.status)
        assert unknown_tractions(wanted) <= linear_operator.SLIDES * counts[SLIP]
    free, forces = loads(interface)
    found = make(interface).area(wanted.status != OPEN, free[:, 0, 0]).stuck(free, forces)
    response = found.release(wanted)
    assert_solved_directly(response, interface, wanted, free, forces)


@pytest.fixture
def factorised(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes of the systems of sliding contacts that are factorised."""
    sizes: list[int] = []
    factorise = dense.factorise

    def count(matrix: Array) -> object:
        sizes.append(len(matrix))
        return factorise(matrix)

    monkeypatch.setattr(dense, "factorise", count)
    return sizes


def test_sliding_contacts_that_change_a_little_share_factors(factorised: list[int]) -> None:
    """Nodes open, close, stick and slip again; another friction coefficient is another system."""
    interface = problem(2)
    first = conditions(interface, np.array([False, True, True, True]))
    status = np.full(NODES, SLIP, dtype=np.int8)
    status[:6], status[6:8] = OPEN, STICK
    first = replace(first, status=status)
    free, forces = loads(interface)
    operator = FactoredOperator(interface)
    changes = [{}, {5: SLIP, 20: OPEN}, {5: STICK, 6: SLIP}, {7: OPEN, 20: STICK}, {30: STICK}, {}]
    for change in changes:
        now = status.copy()
        now[list(change)] = list(change.values())
        wanted = replace(first, status=now)
        area = operator.area(now != OPEN, free[:, 0, 0])
        found = area.stuck(free, forces).release(wanted)
        assert_solved_directly(found, interface, wanted, free, forces)
    assert len(factorised) == 1
    again = FactoredOperator(interface)
    again.recall(operator.memory())
    for each, pull in ((again, 1.0), (operator, 0.5)):
        wanted = replace(first, pull=pull * first.pull)
        area = each.area(status != OPEN, free[:, 0, 0])
        found = area.stuck(free, forces).release(wanted)
        assert_solved_directly(found, interface, wanted, free, forces)
    assert len(factorised) == 3


def test_a_border_that_leaves_too_much_is_factorised(
    factorised: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(linear_operator, "BORDER_ERROR", 0.0)
    interface = problem(2)
    wanted = conditions(interface, np.array([False, True, True, True]))
    wanted = replace(wanted, status=np.full(NODES, SLIP, dtype=np.int8))
    free, forces = loads(interface)
    operator = FactoredOperator(interface)
    for opened in (1, 2):
        status = np.where(np.arange(NODES) < opened, OPEN, SLIP).astype(np.int8)
        now = replace(wanted, status=status)
        area = operator.area(status != OPEN, free[:, 0, 0])
        found = area.stuck(free, forces).release(now)
        assert_solved_directly(found, interface, now, free, forces)
    assert factorised == [NODES + 3, NODES + 2]


@OPERATORS
@DIMENSIONS
def test_bodies_that_float_in_equilibrium(make: type[FactoredOperator], d: int) -> None:
    """Two coordinates that move everything alike: only their difference acts on the contact."""
    interface = problem(d)
    motion = interface.motion.copy()
    motion[:, 3] = -motion[:, 1]
    interface = replace(interface, motion=motion, stiffness=np.zeros((4, 4)))
    wanted = conditions(interface, np.array([False, False, True, False]))
    wanted = replace(wanted, floating=True)
    free, forces = loads(interface)
    forces[3] = -forces[1]
    area = make(interface).area(wanted.status != OPEN, free[:, 0, 0])
    found = area.stuck(free, forces).release(wanted)
    traction, _, coordinates = solved_directly(interface, wanted, free, forces)
    np.testing.assert_allclose(found.traction, traction, atol=SAME)
    np.testing.assert_allclose(
        found.coordinates[1] - found.coordinates[3], coordinates[1] - coordinates[3], atol=SAME
    )


@OPERATORS
def test_motion_without_resistance_is_singular(make: type[FactoredOperator]) -> None:
    interface = problem(2)
    interface = replace(interface, stiffness=np.zeros((4, 4)))
    wanted = conditions(interface, np.zeros(4, bool))
    # Four forces on one node that slides without friction: its pressure can balance only one.
    status = np.where(np.arange(NODES) == 0, SLIP, OPEN).astype(np.int8)
    wanted = replace(wanted, status=status, pull=np.zeros((NODES, 1)))
    free, forces = loads(interface)
    stuck = make(interface).area(wanted.status != OPEN, free[:, 0, 0]).stuck(free, forces)
    try:
        motion = np.abs(stuck.release(wanted).coordinates).max()
    except np.linalg.LinAlgError:
        return
    assert motion > 1e7 * np.abs(stuck.coordinates).max()


@OPERATORS
def test_area_is_the_same_while_it_serves(make: type[FactoredOperator]) -> None:
    interface = problem(2)
    operator = make(interface)
    gap, closed = np.arange(float(NODES)), np.arange(NODES) < 20
    first = operator.area(closed, gap)
    assert operator.area(np.arange(NODES) < 18, gap) is not first
    again = operator.area(closed, gap)
    assert again.order.rows  # factorised: another order takes work
    assert operator.area((np.arange(NODES) < 20) & (np.arange(NODES) != 3), gap) is again


@pytest.mark.usefixtures("way")
@OPERATORS
@DIMENSIONS
def test_nodes_that_are_not_factorised_come_into_contact(
    make: type[FactoredOperator], d: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Areas that grow, move away and come back meet the conditions as one that is solved alone."""
    monkeypatch.setattr(linear_operator, "FEWEST", 4)
    interface = problem(d)
    operator = make(interface)
    wanted = conditions(interface, np.array([False, True, True, True]))
    free, forces = loads(interface)
    for first, last in ((0, 6), (0, 18), (22, NODES), (3, 15)):
        inside = (np.arange(NODES) >= first) & (np.arange(NODES) < last)
        now = replace(wanted, status=np.where(inside, wanted.status, OPEN).astype(np.int8))
        area = operator.area(now.status != OPEN, free[:, 0, 0])
        found = area.stuck(free, forces).release(now)
        assert_solved_directly(found, interface, now, free, forces)


def test_systems_are_solved_directly_until_the_inverse_pays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With many nodes stuck an inverse pays; with none stuck it never does."""
    monkeypatch.setattr(linear_operator, "READING", 0)  # which counts in small systems alone
    interface = problem(3)
    free, forces = loads(interface)
    for status, limit in (([SLIP, SLIP, OPEN], 100), ([STICK, SLIP, STICK], 20)):
        operator = FactoredOperator(interface)
        wanted = conditions(interface, np.array([False, True, True, True]))
        wanted = replace(wanted, status=np.tile(status, NODES)[:NODES].astype(np.int8))
        area = operator.area(wanted.status != OPEN, free[:, 0, 0])
        assert not area.order.factorised
        for _ in range(limit):
            found = area.stuck(free, forces).release(wanted)
        assert area.order.factorised == (STICK in status)
        assert_solved_directly(found, interface, wanted, free, forces)


@OPERATORS
@DIMENSIONS
def test_elastic_layer(make: type[FactoredOperator], d: int) -> None:
    interface, penalty = problem(d), 0.7
    rng = np.random.default_rng(3)
    traction, moved = rng.standard_normal(NODES * d), rng.standard_normal(1)
    free_coordinate = ~interface.prescribed
    motion = interface.motion[:, free_coordinate]
    displacement = interface.compliance.apply(traction) + penalty * traction + motion @ moved
    stiffness = interface.stiffness[np.ix_(free_coordinate, free_coordinate)]
    forces = motion.T @ traction - stiffness @ moved
    found = make(interface).regularised(penalty).tractions(displacement, forces)
    np.testing.assert_allclose(found, traction, atol=SAME)


@DIMENSIONS
def test_operations_of_the_compliance(d: int) -> None:
    compliance = problem(d).compliance
    matrix = matrix_of(problem(d))
    np.testing.assert_array_equal(compliance.diagonal, np.diagonal(matrix))
    assert compliance.level == pytest.approx(np.trace(matrix) / len(matrix))
    rows, columns = np.array([3, 1]), np.array([0, 5, 2])
    np.testing.assert_array_equal(compliance.block(rows, columns), matrix[[3, 1]][:, [0, 5, 2]])
