# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane bodies that move along z too: shear along it, oblique friction, crystals that couple it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import ramp
from cases.pad_cases import HOLD, TOP, pad, press, wave
from dolfinx import fem
from harness.launch import python
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools
from fretfe.case import Body, Crystal, Solid, parse_case
from fretfe.errors import CaseError, ModelError
from fretfe.evaluate.plane.slip import slip_border
from fretfe.evaluate.stress import StressHistory, stress_parameters
from fretfe.exchange.export import export_tables
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.run import solve
from fretfe.local.batches import solve_edges
from fretfe.local.half_planes import Contacts
from fretfe.local.problem import EdgeHistories
from fretfe.materials.crystals import HalfPlane, bunge_rotation, cubic, tensor, turned
from fretfe.materials.material import Material
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result
from fretfe.runner import Runner

Solve = Callable[[dict[str, Any]], Result]
LOAD, SHEAR, FRICTION, RADIUS = 600.0, 60.0, 0.4, 50.0
CONSTANTS = (252e3, 161e3, 131e3)
ASKEW = (20.0, 35.0, 10.0)
# A cylinder of R = 50 on bodies that are large against the contact.
CYLINDER = {
    "upper_radius": RADIUS, "lower_radius": 0.0, "size": 0.02, "zone": 0.8,
    "upper_width": 20.0, "lower_width": 30.0, "lower_height": 30.0, "upper_height": 10.0,
}  # fmt: skip


def steel(poisson: float) -> dict[str, Any]:
    return {"young": 210e3, "poisson": poisson}


def nickel(*euler: float) -> dict[str, Any]:
    return {"elastic": {"cubic": list(CONSTANTS)}, "orientation": {"euler": list(euler)}}


def tables(
    body: dict[str, Any],
    along_x: float | None = 0.0,
    along_z: float | None = SHEAR,
    **timing: int,
) -> dict[str, Any]:
    """A cylinder under P, then Q along x and z; without one of them its top is held there."""
    steps = {"cycles": 2, "steps": 20, **timing}
    loads = {"press": press(LOAD)}
    for axis, force in (("x", along_x), ("z", along_z)):
        if force is not None:
            history = [HOLD, wave(force, **steps)]
            loads[axis] = {**TOP, "direction": axis, "history": history}
    base = {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}
    geometry = {"template": "cylinder", "parameters": CYLINDER}
    bodies = {"upper": body, "lower": body}
    return pad(geometry=geometry, bodies=bodies, loads=loads, supports={"base": base})


def stiffness_of(body: dict[str, Any]) -> Array:
    """(6, 6) in the axes of the model, by Voigt's order."""
    crystal = parse_case(tables(body)).bodies["upper"]
    assert isinstance(crystal, Crystal)
    return np.asarray(crystal.stiffness)


def normal_compliance(body: dict[str, Any]) -> float:
    """A_n of one half-plane."""
    if "elastic" not in body:
        return float(2 * (1 - body["poisson"] ** 2) / body["young"])
    frame = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
    return float(HalfPlane.of(stiffness_of(body), frame).compliance[0, 0])


def half_width(body: dict[str, Any]) -> float:
    """Hertz with the compliance A_n of both half-planes: a² = 2 P R (2 A_n)/π."""
    return float(np.sqrt(4 * LOAD * RADIUS * normal_compliance(body) / np.pi))


def test_shear_along_z_is_the_antiplane_problem_of_cattaneo(solved: Solve) -> None:
    """The same zones as by shear along x, for any Poisson's ratio; the pressure is not touched."""
    contact = solved(tables(steel(0.3))).contacts[0]
    a = half_width(steel(0.3))
    assert not contact.warnings
    assert np.abs(contact.shear_force).max() < 1e-9 * SHEAR
    assert contact.force[:, 2].max() == pytest.approx(SHEAR)
    zone = a - a * np.sqrt(1 - SHEAR / (FRICTION * LOAD))
    for station, sign in zip(contact.stations, (-1, 1), strict=True):
        # The bodies are 17 half-widths wide: .2 to .3 %.
        assert station.k_n[-1] == pytest.approx(2 * LOAD / (np.pi * a) * np.sqrt(2 / a), rel=5e-3)
        largest = contact.force[:, 2].argmax()
        k_s = sign * SHEAR / (np.pi * np.sqrt(2 * a))
        assert station.k_s[largest] == pytest.approx(k_s, rel=5e-3)
        assert abs(station.k_range) == pytest.approx(2 * abs(k_s), rel=5e-3)
        assert station.k_t_range_fitted == pytest.approx(station.k_range, rel=5e-3)
        assert station.k_range_spread < 0.02 * station.k_range
        assert (station.k_t_range, station.k_i_range) < (1e-9, 1e-6)
        assert station.k_angle == pytest.approx(90.0)
        for each in station.slip_zones[-2:]:
            assert each.length == pytest.approx(zone, rel=0.01)
            assert each.prediction == pytest.approx(zone, rel=0.01)
            assert each.predicted == pytest.approx(2 * abs(k_s) / (FRICTION * 1239.3), rel=0.01)


TITANIUM = {"young": 110e3, "poisson": 0.33}


@pytest.mark.parametrize("lower", [steel(0.3), TITANIUM], ids=["similar", "unlike"])
def test_without_shear_along_z_nothing_changes(solved: Solve, lower: dict[str, Any]) -> None:
    """Round-off of the factors of the bodies, and of Newton's steps."""
    case = tables(steel(0.3), SHEAR, None)
    case["bodies"]["lower"] = lower
    held = {"control": "displacement", "direction": "z", "history": [HOLD]}
    case["loads"]["still"] = {**TOP, **held}
    plane = {**case, "loads": {name: case["loads"][name] for name in ("press", "x")}}
    plane = {**plane, "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}}
    two, three = (solved(each) for each in (plane, case))
    old, new = (np.asarray(each.contact_history("main").traction) for each in (two, three))
    assert (old.shape[2], new.shape[2]) == (2, 3)
    assert np.abs(new[..., :2] - old).max() < 1e-9 * old.max()
    assert np.abs(new[..., 2]).max() < 1e-9 * old.max()
    for one, other in zip(two.contacts[0].stations, three.contacts[0].stations, strict=True):
        for name in ("k_n", "k_t"):
            expected = getattr(one, name)
            found = getattr(other, name)
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * one.k_range)
        for name in ("k_range", "k_range_spread", "k_n_moved"):
            expected = pytest.approx(getattr(one, name), rel=1e-9, nan_ok=True)
            assert getattr(other, name) == expected
        last, same = one.slip_zones[-1], other.slip_zones[-1]
        assert same.length == pytest.approx(last.length, rel=1e-9)
        assert np.abs(other.k_s).max() < 1e-9 * one.k_range


def test_antiplane_shear_of_unlike_bodies(solved: Solve) -> None:
    """Beta couples pressure and shear in the plane only: K_S and zones are as of equal bodies."""
    case = tables(steel(0.3))
    case["bodies"]["lower"] = TITANIUM
    contact = solved(case).contacts[0]
    a = contact.half_width[-1]
    for station in contact.stations:
        assert station.oscillation != 0
        assert station.k_s_range == pytest.approx(2 * SHEAR / (np.pi * np.sqrt(2 * a)), rel=5e-3)
        assert station.k_range == pytest.approx(station.k_s_range, rel=1e-3)
        zone = a - a * np.sqrt(1 - SHEAR / (FRICTION * LOAD))
        assert station.slip_zones[-1].length == pytest.approx(zone, rel=0.02)


@pytest.mark.parametrize("angle", [30.0, 75.0])
def test_without_lateral_contraction_the_direction_of_shear_does_not_matter(
    solved: Solve, angle: float
) -> None:
    line = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    straight = solved(tables(steel(0.0), SHEAR, 0.0)).contacts[0]
    oblique = solved(tables(steel(0.0), *(SHEAR * line).tolist())).contacts[0]
    for one, other in zip(straight.stations, oblique.stations, strict=True):
        # In these finite bodies Q along x has an arm, and bends them.
        assert other.k_range == pytest.approx(one.k_range, rel=2e-3)
        # At the left edge `along` is -z, at the right one inward is -x.
        assert other.k_angle == pytest.approx(-angle, abs=0.1)
        assert other.slip_zones[-1].length == pytest.approx(one.slip_zones[-1].length, rel=5e-3)


def plane_problem(result: Result, poisson: float, side: int) -> float:
    """Length of the last slip zone by half-planes with three components, from the edge factors."""
    station = result.contacts[0].stations[side]
    first, last = result.loads.evaluated
    states = np.arange(first - (last - first), last + 1)
    k = np.column_stack([station.k_t, station.k_s])[states]
    start, half = np.zeros((1, 2)), (last - first) // 2
    zone = station.slip_zones[-1]
    ones, end = np.ones(1), len(states)
    angle = np.radians(station.k_angle)
    histories = EdgeHistories(
        contacts=Contacts(result.contacts[0].half_width[-1:], station.k_n[-1:], 2 * ones),
        k=np.concatenate([start, k])[None],
        k_i=np.zeros((1, end + 1)),
        locked=np.zeros((1, 2)),
        direction=np.array([[np.cos(angle), np.sin(angle)]]),
        zone=zone.length * ones,
        halves=(((zone.start - states[0] + 1, zone.end - states[0] + 1),),),
        counted=np.ones((1, end + 1), dtype=bool),
        friction=FRICTION * ones,
        behind=(None,) * len(ones),
        modulus=210e3 / (2 * (1 - poisson**2)) * ones,
        tangential=np.diag([1.0, 1 / (1 - poisson)])[None],
        cycle=(end - 2 * half, end),
    )
    (found,) = solve_edges(histories)
    assert not found.reason
    profile = found.profiles[0]
    moved = profile.slip > 3e-4 * profile.slip.max()
    return slip_border(profile.s, profile.slip, moved).length


@pytest.mark.parametrize("shear", [SHEAR, 0.6 * FRICTION * LOAD])
def test_oblique_slip_is_that_of_half_planes_with_three_components(
    solved: Solve, shear: float
) -> None:
    """Slip is not parallel to the shear then: ν = .3, at 50° to x."""
    parts = shear * np.array([np.cos(np.radians(50)), np.sin(np.radians(50))])
    result = solved(tables(steel(0.3), *parts.tolist(), cycles=3))
    for side, station in enumerate(result.contacts[0].stations):
        expected = plane_problem(result, 0.3, side)
        zone = station.slip_zones[-1]
        # Slip stands at the centres of hat functions: a twentieth of an element nearer to the edge.
        assert zone.length == pytest.approx(expected, rel=0.02)


# Turned about z: c45 is not zero, and shear along z is apart from the plane.
ORTHOTROPIC = {
    "elastic": {
        "orthotropic": {
            "young": [180e3, 120e3, 150e3],
            "poisson": [0.3, 0.25, 0.2],
            "shear": [60e3, 90e3, 40e3],
        }
    },
    "orientation": {"euler": [25.0, 0.0, 0.0]},
}


@pytest.mark.parametrize(
    "body", [nickel(0.0, 0.0, 0.0), nickel(30.0, 0.0, 0.0), ORTHOTROPIC], ids=["0", "30", "c45"]
)
def test_crystal_with_z_along_an_axis(solved: Solve, body: dict[str, Any]) -> None:
    """⟨001⟩ along z: the antiplane problem by itself, and its compliance is that of half-planes.

    K_S by displacements and that compliance are those of Q_z and of the fit to tractions. Slip is
    that of the gap beside a contact of the size of the stick zone, times f and the compliance
    1/√(c44 c55 − c45²) over that to pressure.
    """
    result = solved(tables(body))
    contact, a = result.contacts[0], half_width(body)
    assert np.abs(contact.shear_force).max() < 1e-9 * SHEAR
    c = a * np.sqrt(1 - SHEAR / (FRICTION * LOAD))
    for station in contact.stations:
        assert abs(station.position[-1]) == pytest.approx(a, rel=5e-3)
        assert station.k_range == pytest.approx(2 * SHEAR / (np.pi * np.sqrt(2 * a)), rel=5e-3)
        assert station.k_range == pytest.approx(station.k_t_range_fitted, rel=5e-3)
        # What nodes tell of a border, a twentieth of an element; the zone has four of them.
        assert abs(station.slip_zones[-1].length - (a - c)) < 0.05 * CYLINDER["size"]
    history = result.contact_history("main")
    start, most = (int(np.argmin(np.abs(result.loads.times - time))) for time in (1.0, 1.25))
    x = np.abs(history.surface.arc)
    slips = (x > c) & (x < a)
    found = np.abs(history.slip[most] - history.slip[start])[slips, 1]
    s = x[slips] / c
    gap = c**2 / (2 * RADIUS) * (s * np.sqrt(s**2 - 1) - np.arccosh(s))
    matrix = stiffness_of(body)
    antiplane = 1 / np.sqrt(matrix[3, 3] * matrix[4, 4] - matrix[3, 4] ** 2)
    expected = FRICTION * gap * antiplane / normal_compliance(body)
    # Differences: means around nodes move the border of stick, and all slip with it.
    assert np.ptp(found) == pytest.approx(np.ptp(expected), rel=0.015)


def test_crystal_that_couples_z_with_the_plane(solved: Solve) -> None:
    """Hertz with L⁻¹, and shear of full stick parallel to the resultant, as between half-planes."""
    body = nickel(*ASKEW)
    result = solved(tables(body, None))
    contact, a = result.contacts[0], half_width(body)
    force = contact.shear_vectors
    # The platen is guided along x: the crystals push against it.
    largest, smallest = (int(each) for each in (force[:, 1].argmax(), force[:, 1].argmin()))
    pull = force[largest] - force[smallest]
    assert abs(pull[0]) > 0.05 * pull[1]
    for station, sign in zip(contact.stations, (1, -1), strict=True):
        assert abs(station.position[-1]) == pytest.approx(a, rel=5e-3)
        k_n = 2 * LOAD / (np.pi * a) * np.sqrt(2 / a)
        assert station.k_n[-1] == pytest.approx(k_n, rel=5e-3)
        expected = sign * pull * [1, -1] / (np.pi * np.sqrt(2 * a))
        change = [float(np.diff(k[[smallest, largest]])[0]) for k in (station.k_t, station.k_s)]
        # In finite bodies Q along x has an arm.
        np.testing.assert_allclose(change, expected, atol=5e-3 * np.abs(expected).max())
        assert station.k_range == pytest.approx(station.k_t_range_fitted, rel=5e-3)


DEPTHS = (0.0, 0.03, 0.1)


def stress_of(case: dict[str, Any], folder: Path) -> StressHistory:
    output = {"fields": "none", "stress_depths": DEPTHS}
    result = Runner.find("fem").run(parse_case({**case, "output": output}), folder)
    return result.stress_history("main")


def root_field(z: Any, a: float) -> Any:
    """Analytic below the real axis, where its real part is √(1 − x²/a²), beyond a nothing."""
    return -1j / a * (z - np.sqrt(z - a) * np.sqrt(z + a))


def judged(history: StressHistory, depth: float, roots: list[float]) -> Bools:
    """Nodes of a known stress; at the surface without those next to where it has roots."""
    x = history.arc
    away = np.abs(np.abs(x)[:, None] - roots).min(axis=1)
    return np.asarray((np.abs(x) < 0.79) & ((away > 0.06) | (depth > 0)))


@pytest.mark.parametrize("body", [steel(0.3), nickel(30.0, 0.0, 0.0)], ids=["steel", "crystal"])
def test_stress_of_the_antiplane_problem_of_cattaneo(body: dict[str, Any], tmp_path: Path) -> None:
    """Half the difference between the extremes of Q: shear yz and xz, and nothing else.

    Closed form: yz + i xz is the root field of the shear. .2 % of p0 measured below the surface.
    """
    history = stress_of(tables(body), tmp_path / "run")
    a = half_width(body)
    c, peak = a * np.sqrt(1 - SHEAR / (FRICTION * LOAD)), 2 * LOAD / (np.pi * a)
    ends = [int(np.argmin(np.abs(history.times - time))) for time in (2.25, 2.75)]
    for side, own in zip((-1, 1), history.bodies, strict=True):
        swing = (own.stress[ends[0]] - own.stress[ends[1]]) / 2
        for found, depth in zip(swing, DEPTHS, strict=True):
            z = history.arc - 1j * max(depth, 1e-12)
            shear = FRICTION * peak * (root_field(z, a) - c / a * root_field(z, c))
            seen = judged(history, depth, [a, c])
            assert np.abs(found[seen, :4]).max() < 1e-9 * peak
            expected = np.stack([shear.real, side * shear.imag], axis=1)
            assert np.abs(found[:, 4:] - expected)[seen].max() < 0.004 * peak
    for number in (0, 1):
        parameters = stress_parameters(history, number, Body(young=210e3, poisson=0.3))
        # Largest chord of the shear (xz, yz) over the cycle, on planes that contain z.
        shears = history.bodies[number].stress[..., 4:]
        chord = max(np.nanmax(np.linalg.norm(shears - each, axis=-1)) for each in shears)
        assert np.nanmax(parameters.shear_strain) >= chord * 0.999 / (2 * 210e3 / 2.6)


def test_stress_of_pressed_crystals_that_couple_z_with_the_plane(tmp_path: Path) -> None:
    """Six components by the formalism of Stroh for a half-plane under the pressure of Hertz."""
    case = tables(nickel(*ASKEW), None, None)
    size = {"upper_width": 40.0, "upper_height": 40.0, "lower_width": 90.0, "lower_height": 90.0}
    size["size"] = 0.01
    case["geometry"]["parameters"] = CYLINDER | size
    history = stress_of(case, tmp_path / "run")
    a = half_width(nickel(*ASKEW))
    peak = 2 * LOAD / (np.pi * a)
    matrix = turned(cubic(*CONSTANTS), bunge_rotation(ASKEW).T)
    for side, own in zip((1, -1), history.bodies, strict=True):
        for found, depth in zip(own.stress[-1], DEPTHS, strict=True):
            expected = hertz_by_stroh(matrix, history.arc, side * max(depth, 1e-12), a)
            missing = np.abs(found / peak - expected)[judged(history, depth, [a])].max(axis=0)
            # Along x, and so along z, the bodies add what falls with their size.
            assert np.all(missing < [0.014, 0.01, 0.008, 0.005, 0.001, 0.0015])


def hertz_by_stroh(matrix: Array, x: Array, y: float, a: float) -> Array:
    """(n, 6) stress xx, yy, zz, xy, yz, xz, over p0, of a half-plane that reaches away from 0."""
    c = tensor(matrix)
    q, r, t = c[:, 0, :, 0], c[:, 0, :, 1], np.linalg.inv(c[:, 1, :, 1])
    corner = -t @ r.T
    roots, vectors = np.linalg.eig(np.block([[corner, t], [r @ t @ r.T - q, corner.T]]))
    roots, functions = roots[roots.imag > 0], vectors[3:, roots.imag > 0]
    z = x[:, None] + roots * y
    field = root_field(z, a) if y < 0 else root_field(z.conj(), a).conj()
    own = field * np.linalg.solve(functions, [0.0, -1.0, 0.0])
    by_y, by_x = (own @ functions.T).real, -(own * roots @ functions.T).real
    xx, yy, xy, yz, xz = by_x[:, 0], by_y[:, 1], by_y[:, 0], by_y[:, 2], by_x[:, 2]
    compliance = np.linalg.inv(matrix)
    zz = -(compliance[2, [0, 1, 3, 4, 5]] @ [xx, yy, yz, xz, xy]) / compliance[2, 2]
    return np.stack([xx, yy, zz, xy, yz, xz], axis=1)


def test_crystals_in_a_plane_mesh_are_those_of_its_extrusion() -> None:
    """Forces by displacements that do not vary along z, summed along z; any of the 21 constants."""
    matrix = turned(cubic(252.0, 161.0, 131.0), bunge_rotation(ASKEW))
    matrix = matrix + np.diag([30.0, 0.0, 10.0, 5.0, 0.0, 20.0])
    material = Material(np.nan, np.nan, 0.0, "strain", crystal=tuple(map(tuple, matrix.tolist())))
    flat = blocks.block("b", [0.0, 0.5, 0.8], [0.0, 0.4, 1.0], order=2)
    solid = extrude(Mesh({"b": flat}), Solid(length=0.7, layers=1)).bodies["b"]
    plane, space = (ElasticBody(MPI.COMM_SELF, each, material, 2, 3) for each in (flat, solid))
    values = np.random.default_rng(3).normal(size=(len(plane.node_points), 3))
    found = []
    tree = cKDTree(plane.node_points)
    for body in (plane, space):
        _, number = tree.query(body.node_points[:, :2])
        moved = fem.Function(body.space)
        moved.x.array[:] = values[number].ravel()
        forces = np.zeros_like(values)
        np.add.at(forces, number, body.forces(moved).array.reshape(-1, 3))
        found.append(forces)
    np.testing.assert_allclose(found[1], 0.7 * found[0], atol=1e-11 * np.abs(found[0]).max())


ANGLE = np.radians(31.0)
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE), 0], [np.sin(ANGLE), np.cos(ANGLE), 0], [0, 0, 1]])


def rounded(points: Array) -> Array:
    x, y = points.T
    return np.column_stack([x, y + (0.6 - y) / 0.6 * x**2])


def two_blocks(turn: Array) -> Mesh:
    """A rounded pad on a block."""
    upper = blocks.block(
        "pad", np.linspace(-0.3, 0.3, 49), [0.0, 0.1, 0.3, 0.6], order=2, mapping=rounded
    )
    lower = blocks.block("block", np.linspace(-0.6, 0.6, 101), [-0.8, -0.3, -0.1, 0], order=2)
    bodies = {"pad": upper, "block": lower}
    for body in bodies.values():
        body.points[:] = body.points @ turn[:2, :2].T
    return Mesh(bodies)


def askew(turn: Array) -> dict[str, Any]:
    """Crystals pressed and sheared along x and z; all of it turned about z."""
    axes = bunge_rotation(ASKEW) @ turn.T
    body = {
        "elastic": {"cubic": [252.0, 161.0, 131.0]},
        "orientation": {"matrix": axes.tolist()},
    }

    def platen(direction: Array, force: float, late: int) -> dict[str, Any]:
        hold: list[dict[str, Any]] = [{"hold": True, "until": 1}] * late
        move = {**ramp(force)[0], "until": 1 + late, "steps": 3}
        table = {"type": "platen", "boundary": "pad_top", "control": "force"}
        return {**table, "direction": direction.tolist(), "history": [*hold, move]}

    x, y, z = turn.T
    return {
        "geometry": {"file": "none.msh"},
        "bodies": {"pad": body, "block": body},
        "contacts": {"main": {"surface1": "pad_bottom", "surface2": "block_top", "friction": 0.4}},
        "loads": {"p": platen(y, -3.0, 0), "x": platen(x, 0.4, 1), "z": platen(z, 0.5, 1)},
        "supports": {"base": {"boundary": "block_bottom", "fix": ["x", "y", "z"]}},
    }


@cache
def turned_run(turn: bool) -> Result:
    axes = TURN if turn else np.eye(3)
    result = solve(MPI.COMM_WORLD, parse_case(askew(axes)), load=lambda: two_blocks(axes))
    assert result.failure is None
    return result


def vectors(result: Result) -> Array:
    """(T, N, 3) traction on body 2 in the axes of the case."""
    (history,) = result.solution.contacts
    signed = np.asarray(history.traction) * np.array([-1.0, 1.0, 1.0])
    return np.einsum("tnc,ncd->tnd", signed, history.surface.frames)


def test_turned_with_its_crystals() -> None:
    one, other = turned_run(turn=False), turned_run(turn=True)
    expected = vectors(one) @ TURN.T
    assert np.abs(vectors(other) - expected).max() < 1e-9 * np.abs(expected).max()
    for first, second in zip(one.contacts[0].stations, other.contacts[0].stations, strict=True):
        for name in ("k_t", "k_s", "k_i", "k_n"):
            found, known = getattr(second, name)[-1], getattr(first, name)[-1]
            assert found == pytest.approx(known, rel=1e-8)
    assert (np.asarray(one.solution.contacts[0].status)[-1] == 2).any()
    assert max(one.solution.imbalance("force").max(), one.solution.imbalance("moment").max()) < 1e-9


ON_RANKS = """
import sys
sys.path[:0] = [{tests!r}, {folder!r}]
from fretfe.fem._compat import MPI
import numpy as np
import test_plane_with_z as own
result = own.turned_run(turn=False)
if MPI.COMM_WORLD.rank == 0:
    stations = result.contacts[0].stations
    np.savez({target!r}, vectors=own.vectors(result), k=[each.k_s[-1] for each in stations])
"""


def test_two_ranks_find_what_one_does(tmp_path: Path) -> None:
    folder, target = Path(__file__).parent, tmp_path / "found.npz"
    names = {"tests": str(folder.parent), "folder": str(folder), "target": str(target)}
    done = python("-c", ON_RANKS.format(**names), ranks=2)
    assert done.returncode == 0, done.stderr
    result = turned_run(turn=False)
    expected, k_s = vectors(result), [each.k_s[-1] for each in result.contacts[0].stations]
    with np.load(target) as found:
        assert np.abs(found["vectors"] - expected).max() < 1e-9 * np.abs(expected).max()
        np.testing.assert_allclose(found["k"], k_s, rtol=1e-8)


def test_tables_of_tractions_have_shear_and_slip_along_z(solved: Solve) -> None:
    found = {each.file: each for each in export_tables(solved(tables(steel(0.3))))}
    headings = [each.name for each in found["tractions.csv"].headings]
    assert headings[4:8] == ["p", "q", "q_z", "slip"]


def test_refused_with_a_reason(solved: Solve) -> None:
    case = tables(steel(0.3))
    with pytest.raises(CaseError, match=r"loads\.z\.direction: expected nothing that moves plane"):
        solved({**case, "model": {"plane": "stress"}})
    loose = {**case, "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}}
    with pytest.raises(ModelError, match="free to move along z"):
        solved(loose)
