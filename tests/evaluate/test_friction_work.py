# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error bar of the friction work of nodes, of half-planes and half-spaces, by closed forms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import solid_runs
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, problem
from cases.marching import march_through
from reference.halfspace import SphereOnFlat, build, loads

from fretfe._typing import Array, Indices
from fretfe.analytic.partial_slip import hertz_dissipation
from fretfe.contact.march import March
from fretfe.evaluate.friction_work import friction_work
from fretfe.halfplane import solve_half_planes
from fretfe.history.solution import SLIP, Solution
from fretfe.surface.friction import Friction

TURNS = np.append(np.arange(0, 1, 0.25), np.cos(np.linspace(0, 4 * np.pi, 5)))


def told(solution: Solution) -> tuple[float, float]:
    """Friction work and its bar."""
    work, bar = friction_work(solution, solution.contacts[0])
    return float(work.sum()), float(bar.sum())


def half_planes(elements: int, share: float) -> Solution:
    return solve_half_planes(problem(LOAD, share * LIMIT * TURNS, cycle=2), elements).solution


def test_the_bar_holds_in_the_plane_and_is_no_wider_than_it_must_be() -> None:
    """Slip zones of 1 to 15 elements; of contacts of 8 to 16 elements bars hold 90 %."""
    found = []
    for elements in range(18, 42, 2):
        for share in (0.2, 0.3, 0.6, 0.9):
            work, bar = told(half_planes(elements, share))
            exact = float(hertz_dissipation(HERTZ, LOAD, FRICTION, share * LIMIT))
            found.append((abs(work / exact - 1), bar / exact))
    error, bar = np.array(found).T
    assert np.count_nonzero(error > bar) <= 3  # of 48, by chance one more than 5 %
    assert np.median(bar) < 5 * np.median(error)


def mindlin(modulus: float, load: float, share: float) -> float:
    """Work of a cycle (Mindlin and Deresiewicz 1953), contact radius 1, 2 (2 - ν)/G = 4/E*."""
    left = 1 - share
    shape = 1 - left ** (5 / 3) - 5 * share / 6 * (1 + left ** (2 / 3))
    return 9 * (FRICTION * load) ** 2 / 10 * 4 / modulus * shape


def corners(grid: SphereOnFlat) -> Indices:
    """(F, 4) middles of the squares that are solved, four around each corner of squares."""
    places = np.round(grid.centres / grid.size * 2).astype(int).tolist()
    number = {tuple(each): count for count, each in enumerate(places)}
    around = [[(x, y), (x + 2, y), (x + 2, y + 2), (x, y + 2)] for x, y in number]
    return np.array([[number[c] for c in each] for each in around if number.keys() >= set(each)])


def sphere(cells: int, share: float) -> tuple[float, float]:
    """Work and bar of half-spaces over the exact work."""
    grid = SphereOnFlat(cells=cells, extent=1.25)
    load = grid.load_for(1.0)
    shear = share * FRICTION * load * np.array([0.0, 1.0, -1.0, 1.0])
    work, bar = np.array(half_spaces(grid, np.outer(shear, [1.0, 0.0]), 2))
    return tuple(np.array([work, bar]) / mindlin(grid.modulus, load, share))


def half_spaces(grid: SphereOnFlat, shear: Array, cycle: int) -> tuple[float, float]:
    """Work and bar of the last steps that are a cycle, under (n, 2) forces in the plane."""
    interface = build(grid)
    forces = np.insert(shear, 0, -grid.load_for(1.0), axis=1)
    steps = [loads(interface, force, FRICTION) for force in (np.zeros(3), *forces)]
    results = list(march_through(March(interface), steps))
    solution = solved(
        np.insert(grid.centres, 1, 0.0, axis=1), corners(grid), interface.roots**2,
        traction=np.array([each.state.traction for each in results]) / grid.size,
        slip=np.array([each.state.relative[:, 1:] for each in results]) / grid.size,
        status=np.array([each.state.status for each in results]),
        dissipation=np.array([each.dissipation for each in results]),
        cycle=(len(results) - 1 - cycle, len(results) - 1),
    )  # fmt: skip
    return told(solution)


def solved(
    points: Array, facets: Indices, weights: Array, cycle: tuple[int, int], **fields: Any
) -> Solution:
    """A contact of solids with a history of T states."""
    old = solid_runs.solid_result().solution
    states = len(fields["status"])
    surface = replace(old.contacts[0].surface, points=points, facets=facets, weights=weights)
    friction = Friction.uniform(np.full(states, FRICTION), len(points))
    contact = replace(
        old.contacts[0], surface=surface, friction=friction, mean_traction=fields["traction"],
        **fields,
    )  # fmt: skip
    certificates = {name: np.zeros(states) for name in old.certificates}
    times = np.arange(float(states))
    return replace(old, times=times, cycle=cycle, contacts=(contact,), certificates=certificates)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("cells", [9, 13, 17])
def test_the_bar_holds_around_a_circle(cells: int, share: float) -> None:
    """Squares of .28, .19 and .15 of the radius: slip zones of .4 to 3.6 elements."""
    work, bar = sphere(cells, share)
    assert abs(work - 1) < bar < (0.7 if share > 0.5 else 2.0)  # errors of .1 to 67 %


def test_the_bar_holds_what_shear_that_turns_within_steps_leaves_open() -> None:
    """Around a hexagon; errors of 24 and 9 % of the work with 1 and 4 steps a side."""
    grid = SphereOnFlat(cells=13, extent=1.25)
    turns = np.pi / 3 * np.arange(13)
    force = 0.5 * FRICTION * grid.load_for(1.0)
    around = force * np.column_stack([np.cos(turns), np.sin(turns)])

    def by(steps: int) -> tuple[float, float]:
        way = np.linspace(around[:-1], around[1:], steps, endpoint=False).swapaxes(0, 1)
        return half_spaces(grid, np.vstack([np.zeros(2), *way, around[-1]]), 6 * steps)

    (coarse, bar), (finer, smaller), (fine, _) = by(1), by(4), by(16)
    assert fine - bar < coarse < fine + bar
    assert fine - smaller < finer < fine + smaller


def extruded(plane: Solution, turned: float) -> Solution:
    """Half-planes as a solid of four layers of triangles, with every other row of nodes moved."""
    contact, rows = plane.contacts[0], 5
    count, arc = len(contact.surface.arc), contact.surface.arc
    number = np.arange(rows * count).reshape(rows, count)
    square = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    first, second, third, fourth = (each.ravel() for each in square)
    facets = np.concatenate(
        [np.stack([first, second, third], axis=1), np.stack([first, third, fourth], axis=1)]
    )
    along = np.linspace(0, 1, rows)[:, None] + 0 * arc
    across = arc + turned * (np.arange(rows) % 2)[:, None]
    points = np.stack([across, 0 * along, along], axis=2).reshape(-1, 3)
    share = np.array([0.5, 1, 1, 1, 0.5]) / (rows - 1)
    tile = (1, rows, 1)
    return solved(
        points, facets, np.outer(share, contact.surface.weights).ravel(), plane.cycle or (0, 0),
        traction=np.tile(contact.mean_traction, tile),
        slip=np.tile(contact.slip, tile),
        status=np.tile(contact.status, (1, rows)),
        dissipation=np.concatenate([each * contact.dissipation for each in share], axis=1),
    )  # fmt: skip


def test_layers_have_the_bar_of_the_plane_and_triangles_that_lie_anyhow_less() -> None:
    """Of triangles covariances are 8/9 of those over two corners; 2/3 in place of 3/2 count."""
    plane = half_planes(30, 0.5)
    work, bar = told(plane)
    assert told(extruded(plane, 0.0)) == pytest.approx((work, 8 / 9 * bar), rel=1e-3)
    assert told(extruded(plane, 0.2)) == pytest.approx((work, 32 / 81 * bar), rel=1e-3)


def test_elements_hide_nothing_of_a_contact_that_slides_as_a_whole() -> None:
    """Slip is the same all over, and P is known."""
    plane = half_planes(20, 0.5)
    contact = plane.contacts[0]
    slip = np.zeros_like(contact.slip) + np.cumsum(np.ones(len(plane.times)))[:, None, None]
    last = np.asarray(contact.status[-1])
    sliding = replace(
        contact, slip=slip, status=np.where(last > 0, SLIP, 0) * np.ones_like(contact.status)
    )
    assert told(replace(plane, contacts=(sliding,)))[1] < 1e-9


def test_the_work_of_a_node_without_an_element_in_contact_is_all_bar() -> None:
    plane = half_planes(20, 0.5)
    contact = plane.contacts[0]
    alone = np.zeros_like(np.asarray(contact.status))
    middle = alone.shape[1] // 2
    alone[:, middle] = SLIP
    found = np.zeros_like(np.asarray(contact.dissipation))
    found[:, middle] = 1.0
    work, bar = told(replace(plane, contacts=(replace(contact, status=alone, dissipation=found),)))
    assert bar >= work > 0
