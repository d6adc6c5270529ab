# SPDX-License-Identifier: LGPL-3.0-or-later
"""The monolithic solver: its tangent, and the same answer as the condensed path in every step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from cases import blocks
from cases.b1_meshes import write_b1
from cases.contact_runs import run
from reference.monolithic import Iterate, MonolithicSolver, cone_projection
from reference.monolithic_runs import assert_same, monolithic, statuses

from fretfe._typing import Array
from fretfe.contact.state import SLIP, STICK
from fretfe.errors import ConvergenceError, FretfeError
from fretfe.fem.model import Model
from fretfe.mesh.make import mesh_template, read_mesh
from fretfe.mesh.mesh import BodyMesh
from fretfe.mesh.templates import find_template

Data = dict[str, Any]

STEEL = {"young": 210e3, "poisson": 0.3, "density": 8e-9}
SOFT = {"young": 100e3, "poisson": 0.2, "density": 3e-9}


# --- the projection on the friction cone


def directions(count: int, d: int) -> Array:
    vectors = np.random.default_rng(1).normal(size=(count, d))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def trial_tractions(d: int, excess: float) -> tuple[Array, Array]:
    """Trial tractions of pressure 1 to 3 whose shear is (1 + excess) times the bound."""
    friction = np.linspace(0.1, 1.2, 20)
    pressure = np.linspace(1.0, 3.0, 20)
    shear = (1 + excess) * (friction * pressure)[:, None] * directions(20, d - 1)
    return np.column_stack([pressure, shear]), friction


def slope(trial: Array, friction: Array, change: Array, step: float) -> Array:
    ahead, behind = (cone_projection(trial + s * change, friction)[0] for s in (step, -step))
    return (ahead - behind) / (2 * step)


DIMENSIONS = pytest.mark.parametrize("d", [2, 3])
STATES = {
    "stuck far inside": -0.99,
    "stuck at the limit": -1e-6,
    "slip 1e-6": 1e-6,
    "slip 1e-4": 1e-4,
    "slip 1e-2": 1e-2,
    "slip 1": 1.0,
    "slip 1e2": 1e2,
    "slip 1e4": 1e4,
}


@DIMENSIONS
@pytest.mark.parametrize("excess", STATES.values(), ids=STATES.keys())
def test_projection_derivative(d: int, excess: float) -> None:
    trial, friction = trial_tractions(d, excess)
    change = directions(20, d)
    _, derivative = cone_projection(trial, friction)
    step = 1e-3 * min(abs(excess), 0.1)  # far from the kink at the bound
    expected = slope(trial, friction, change, step)
    found = np.einsum("nij,nj->ni", derivative, change)
    # Round-off of tractions of about 1 over a step of 1e-9, which is the shortest.
    np.testing.assert_allclose(found, expected, atol=2e-6)


@DIMENSIONS
def test_open_node_has_no_traction(d: int) -> None:
    trial = np.column_stack([-np.ones(20), directions(20, d - 1)])
    projected, derivative = cone_projection(trial, np.full(20, 0.5))
    assert not projected.any()
    assert not derivative.any()


@DIMENSIONS
def test_limit_belongs_to_stick(d: int) -> None:
    trial, friction = trial_tractions(d, 0.0)
    trial[:, 1:] *= 1 - 1e-15  # not beyond the bound by round-off
    _, derivative = cone_projection(trial, friction)
    np.testing.assert_array_equal(derivative, np.broadcast_to(np.eye(d), derivative.shape))


@DIMENSIONS
def test_derivative_is_unsymmetric(d: int) -> None:
    """The bound follows the pressure; the pressure does not follow the shear."""
    trial, friction = trial_tractions(d, 0.5)
    _, derivative = cone_projection(trial, friction)
    pull = np.linalg.norm(derivative[:, 1:, 0], axis=1)
    np.testing.assert_allclose(pull, friction, rtol=1e-14)  # round-off
    assert not derivative[:, 0, 1:].any()


# --- against the condensed path


@pytest.fixture(scope="module")
def pads(tmp_path_factory: pytest.TempPathFactory) -> dict[int, list[BodyMesh]]:
    """Coarse meshes of B1, by order; the contact is about ten elements wide."""
    folder = tmp_path_factory.mktemp("b1")
    return {order: pad(folder / f"{order}.msh", order, 0.1, 0.4) for order in (1, 2)}


def pad(path: Path, order: int, h: float, growth: float) -> list[BodyMesh]:
    write_b1(path, order, h, growth)
    return list(read_mesh(path).bodies.values())


def case(loads: Data, degree: int = 2, **contact: Any) -> Data:
    main = {"surface1": "pad_contact", "surface2": "substrate_contact", "friction": 0.4}
    return {
        "model": {"degree": degree, "thickness": 2.5},
        "bodies": {"pad": SOFT, "substrate": STEEL},
        "contacts": {"main": main | contact},
        "supports": {"base": {"boundary": "substrate_bottom", "fix": ["x", "y"]}},
        "loads": loads,
    }


def platen(direction: Any, control: str, history: list[Data]) -> Data:
    return {
        "type": "platen",
        "boundary": "pad_top",
        "direction": direction,
        "control": control,
        "history": history,
    }


def pressed(value: float) -> list[Data]:
    return [{"ramp": value, "until": 2.0, "steps": 2}]


def reversed_once(value: float) -> list[Data]:
    return [
        {"hold": True, "until": 2.0},
        {"ramp": value, "until": 4.0, "steps": 2},
        {"ramp": -value, "until": 7.0, "steps": 3},
    ]


PRESS = platen("y", "force", pressed(-1500.0))
MOVED = {
    "press": platen("y", "displacement", pressed(-0.042)),
    "shear": platen("x", "displacement", reversed_once(0.012)),
}
FORCED = {"press": PRESS, "shear": platen("x", "force", reversed_once(250.0))}
TRACTION = {"type": "traction", "boundary": "pad_top"}
CASES: dict[str, Data] = {
    "partial slip": case(MOVED),
    "frictionless preload": case(MOVED, friction_from=2.0),
    "frictionless": case(MOVED, friction=0.0),
    "gross slip": case(MOVED | {"shear": platen("x", "displacement", reversed_once(0.1))}),
    "multipliers on the substrate": case(MOVED, multipliers="surface2"),
    "lift-off": case(
        MOVED
        | {
            "press": platen(
                "y",
                "displacement",
                [
                    *pressed(-0.03),
                    {"ramp": 0.01, "until": 4.0, "steps": 2},
                    {"ramp": -0.03, "until": 7.0, "steps": 3},
                ],
            )
        }
    ),
    "held by contact": case(FORCED),
    "no platen at all": case(
        {
            "press": TRACTION | {"direction": "y", "history": pressed(-75.0)},
            "shear": TRACTION | {"direction": "x", "history": reversed_once(5.0)},
        }
    ),
    "inclined platen": case(
        {
            "press": platen([0.6, -0.8], "force", pressed(1500.0)),
            "shear": platen([0.8, 0.6], "displacement", reversed_once(0.008)),
        },
        friction=1.0,
    ),
    "bulk tension": case(
        {
            "press": PRESS,
            "bulk": {
                "type": "traction",
                "boundary": "substrate_right",
                "direction": "normal",
                "history": reversed_once(60.0),
            },
        }
    ),
    "prescribed side": case(
        {
            "press": PRESS,
            "side": {
                "type": "displacement",
                "boundary": "substrate_right",
                "direction": "x",
                "history": reversed_once(0.01),
            },
        }
    ),
    "rotation": case(
        {
            "press": PRESS,
            "spin": {
                "type": "rotation",
                "centre": [0, -100],
                "history": [
                    {"hold": True, "until": 2.0},
                    {"ramp": 1000.0, "until": 7.0, "steps": 3},
                ],
            },
        }
    ),
}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_same_as_condensed(name: str, order: int, pads: dict[int, list[BodyMesh]]) -> None:
    data = CASES[name] | {"model": {"degree": order, "thickness": 2.5}}
    condensed = run(data, *pads[order])
    assert_same(condensed, monolithic(condensed))


def test_cases_stick_and_slip(pads: dict[int, list[BodyMesh]]) -> None:
    """The comparison would say little if all nodes were in one state."""
    assert {STICK, SLIP} <= statuses(run(CASES["partial slip"], *pads[2]))
    sliding = run(CASES["gross slip"], *pads[2]).results[-1].state
    assert not np.any(sliding.status == STICK)


def test_surface_that_ends_on_moving_boundaries() -> None:
    """The corner of the contact belongs to the driven side of each block."""
    lower = blocks.block("substrate", blocks.graded(0, 2, 7), [-1.0, -0.4, 0.0], order=2)
    upper = blocks.block("pad", blocks.graded(0, 2, 5, 0.8), [0.0, 0.3, 0.8], order=2)
    data = case(MOVED | {"press": platen("y", "displacement", pressed(-0.004))})
    data["contacts"]["main"] |= {"surface1": "pad_bottom", "surface2": "substrate_top"}
    data["loads"]["shear"] = {
        "type": "displacement",
        "boundary": "substrate_left",
        "direction": "x",
        "history": reversed_once(0.006),
    }
    condensed = run(data, upper, lower)
    assert {STICK, SLIP} <= statuses(condensed)
    assert_same(condensed, monolithic(condensed))


def test_two_flanks_under_random_forces() -> None:
    """A dovetail blade that only its flanks and a platen under force hold; it slides as a whole."""
    sizes = {"edge_size": 0.1, "flank_size": 0.2}
    mesh = mesh_template(find_template("dovetail"), sizes, 2)
    forces = np.random.default_rng(4).uniform(300.0, 5000.0, 8)
    table = {"times": [0.0, *range(1, 9)], "values": [0.0, *forces]}
    data = {
        "bodies": {"blade": STEEL, "disc": STEEL},
        "contacts": {
            side: {
                "surface1": f"blade_flank_{side}",
                "surface2": f"disc_flank_{side}",
                "friction": 0.3,
            }
            for side in ("left", "right")
        },
        "supports": {"base": {"boundary": "disc_bottom", "fix": ["x", "y"]}},
        "loads": {"pull": platen("y", "force", [table]) | {"boundary": "blade_top"}},
    }
    condensed = run(data, *mesh.bodies.values())
    assert_same(condensed, monolithic(condensed))


@pytest.mark.slow
def test_b1_as_condensed(tmp_path: Path) -> None:
    """The benchmark's mesh: 32 000 unknowns, 105 nodes in contact."""
    shear = [
        {"hold": True, "until": 5.0},
        {"ramp": 0.012, "until": 8.0, "steps": 3},
        {"ramp": -0.012, "until": 12.0, "steps": 4},
    ]
    press = [{"ramp": -0.042, "until": 5.0, "steps": 5}]
    data = case(
        {"press": platen("y", "displacement", press), "shear": platen("x", "displacement", shear)}
    )
    data["bodies"] = {"pad": STEEL, "substrate": STEEL}
    condensed = run(data, *pad(tmp_path / "b1.msh", 2, 0.02, 0.15))
    steps = monolithic(condensed)
    assert_same(condensed, steps)
    # Regression: 5.3 iterations on average (DOLFINx 0.11, PETSc 3.25).
    assert np.mean([step.iterations for step in steps]) < 6.5


# --- the tangent of the whole system


@pytest.mark.parametrize("slip", [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4])
def test_tangent(slip: float, pads: dict[int, list[BodyMesh]]) -> None:
    """Against finite differences with nodes open, stuck, and on both sides of the bound by `slip`.

    Tractions over r are about 1e-3 (length).
    """
    condensed = run(CASES["held by contact"], *pads[2])
    solver, loads = MonolithicSolver(condensed.model), condensed.steps[-1]
    system, random = solver.system, np.random.default_rng(7)
    count = len(system.gap)
    x = 1e-3 * random.normal(size=system.stiffness.shape[0])
    increment = slip * random.choice([-1.0, 1.0], size=(count, 1))
    relative = system.relative(x)
    trial = 1e-3 * random.uniform(-1.0, 3.0, size=count)
    share = random.choice([-1.0, -0.5, 0.5, 1.0], size=count)
    shear = share * loads.friction * np.maximum(trial, 0.0)
    scaled = np.column_stack([trial + relative[:, 0], shear])
    change = random.normal(size=len(solver.free) + scaled.size)

    def at(step: float) -> Iterate:
        moved = x.copy()
        moved[solver.free] += step * change[: len(solver.free)]
        pulled = scaled + step * change[len(solver.free) :].reshape(scaled.shape)
        return solver.evaluate(loads, relative[:, 1:] - increment, moved, pulled)

    here = at(0.0)
    closed, stuck = here.derivative[:, 0, 0] == 1, here.derivative[:, 1, 1] == 1
    groups = [~closed, closed & stuck, closed & ~stuck]
    assert min(group.sum() for group in groups) >= 4
    step = 1e-2 * slip
    ahead, behind = (
        np.concatenate([i.equilibrium, i.contact.ravel()]) for i in (at(step), at(-step))
    )
    expected = (ahead - behind) / (2 * step)
    found = solver.tangent(here) @ change
    # All is linear between the kinks: round-off of residuals below .1 over the step; at the
    # smallest step one entry of 3724 reaches .078 with PETSc 3.25 and .105 with 3.22.
    np.testing.assert_allclose(found, expected, atol=1e-16 / step * 0.3 + 1e-9)


def test_loads_without_equilibrium(pads: dict[int, list[BodyMesh]]) -> None:
    """More shear than friction bears: the steps before stand."""
    condensed = run(CASES["held by contact"], *pads[2])
    labels = [c.label for c in condensed.model.reduction.interface.coordinates]
    last = condensed.steps[3]
    values = last.values * np.where(np.array(labels) == "shear", 10.0, 1.0)
    steps = MonolithicSolver(condensed.model).run(
        [*condensed.steps[:4], replace(last, values=values)]
    )
    assert len([next(steps) for _ in range(3)]) == 3
    with pytest.raises(ConvergenceError, match=r"step 4 of 4 .* 3 steps before it are kept"):
        next(steps)


def test_one_rank_only() -> None:
    model = cast(Model, SimpleNamespace(comm=SimpleNamespace(size=2)))
    with pytest.raises(FretfeError, match="expected 1 MPI rank, found 2"):
        MonolithicSolver(model)
