# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress around edges of half-planes against closed forms, smooth parts, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from cases.pad_cases import SLIDING, TOP, pad, press, pull, shear
from cases.stored_runs import solved, write_run
from reference.elliptical_stress import elliptical_stress

from fretfe._typing import Array
from fretfe.backends import RunOptions
from fretfe.backends.halfplane import BACKEND as HALFPLANE
from fretfe.case import parse_case
from fretfe.decision import field as module
from fretfe.decision import near_field
from fretfe.decision.field import EdgeField, edge_field, edgeless
from fretfe.evaluate.stress import BodyStress, StressHistory
from fretfe.results.model import Result
from fretfe.results.reader import load_result

# R = 50, P = 600, Q = 60, f = 0.4, steel in plane strain.
E_STAR = 210e3 / (2 * (1 - 0.3**2))
A = np.sqrt(4 * 600 * 50 / (np.pi * E_STAR))
P0 = 2 * 600 / (np.pi * A)
C = A * np.sqrt(1 - 60 / (0.4 * 600))
EDGES = [(edge, body) for edge in (0, 1) for body in (0, 1)]


def field_of(result: Result, edge: int, body: int) -> EdgeField:
    contact = result.contacts[0]
    found = edge_field(result, contact, contact.stations[edge], body)
    assert isinstance(found, EdgeField)
    return found


def at_time(result: Result, field: EdgeField, time: float) -> int:
    return int(np.argmin(np.abs(result.solution.times[field.states] - time)))


def exact(field: EdgeField, points: Array) -> Array:
    """(M, 3) at the largest Q, to +x on body 2; of the edge's own axes."""
    inward = 1 if field.edge == "left" else -1
    x, depth = inward * (points[:, 0] - A), -points[:, 1]
    q = 0.4 * P0 if field.body == "lower" else -0.4 * P0
    stress = elliptical_stress(x, depth, A, P0, q) - elliptical_stress(x, depth, C, 0, q * C / A)
    return stress * [1, 1, inward]


@pytest.mark.parametrize(("edge", "body"), EDGES)
def test_partial_slip_below_an_edge(edge: int, body: int) -> None:
    """McEwen's cylinder and the shear of Cattaneo, to a quarter of the slip zone: 2e-4 of p0."""
    result = solved("halfplane")
    field = field_of(result, edge, body)
    state = at_time(result, field, 2.25)
    distances = np.array([0.25, 0.5, 1, 2, 4, 10]) * (A - C)
    for angle in (-1.0, 0.0, 0.5):
        found = field.along(angle, distances)[state]
        known = exact(field, np.outer(distances, [np.sin(angle), -np.cos(angle)]))
        assert np.abs(found[:, [0, 1, 3]] - known).max() < 2e-4 * P0
        assert found[:, 2] == pytest.approx(0.3 * (found[:, 0] + found[:, 1]))
    assert field.reach(0.0) == pytest.approx(4 * A, rel=1e-3)
    assert field.reach(1.0) == pytest.approx(4 * A / np.sin(1), rel=1e-3)


@pytest.mark.parametrize(("edge", "body"), EDGES)
def test_tension_at_the_trailing_edge(edge: int, body: int) -> None:
    """2 f p0 √(Q/(f P)), and as much pressure at the leading one; tractions are zero there."""
    result = solved("halfplane")
    field = field_of(result, edge, body)
    trailing = (field.edge == "left") == (field.body == "lower")
    known = 2 * 0.4 * P0 * np.sqrt(60 / (0.4 * 600)) * (1 if trailing else -1)
    found = field.along(0.0, np.array([0.0]))[at_time(result, field, 2.25), 0]
    assert found[0] == pytest.approx(known, rel=0.01)
    assert found[[1, 3]] == pytest.approx([0, 0], abs=1e-6 * P0)


@cache
def drawn_in(steps: int = 2) -> Result:
    """P falls to a half, ±Q acts, P rises again in so many steps: one cycle."""
    press = {**TOP, "direction": "y", "history": [
        {"ramp": -600.0, "until": 1.0, "steps": 2},
        {"ramp": -300.0, "until": 2.0, "steps": 2 * steps},
        {"hold": True, "until": 3.0}, {"ramp": -600.0, "until": 4.0, "steps": steps},
    ]}  # fmt: skip
    shear = {**TOP, "direction": "x", "history": [
        {"hold": True, "until": 2.0}, {"ramp": 60.0, "until": 2.25, "steps": 4},
        {"ramp": -60.0, "until": 2.75, "steps": 8}, {"ramp": 0.0, "until": 3.0, "steps": 4},
        {"hold": True, "until": 4.0},
    ]}  # fmt: skip
    tables = pad(loads={"press": press, "shear": shear}, cycle={"start": 1.0, "end": 4.0})
    return replace(HALFPLANE.solve(parse_case(tables), RunOptions()), backend="halfplane")


def test_the_place_of_a_moving_edge_that_is_pulled_most() -> None:
    """Where the edge is at largest Q, 2 f p0 √(Q/(f P)) by the P of then, as after it alone.

    Outside of it, at the outermost place, the stress is that beside a smaller contact.
    """
    narrow, peak = A / np.sqrt(2), P0 / np.sqrt(2)
    core = narrow * np.sqrt(1 - 60 / (0.4 * 300))
    known = 2 * 0.4 * peak * np.sqrt(60 / (0.4 * 300))
    whole, inner = (
        elliptical_stress(np.array([-A]), np.zeros(1), each, p, 0.4 * peak * each / narrow)[0, 0]
        for each, p in ((narrow, peak), (core, 0.0))
    )
    for edge, body in EDGES:
        field = field_of(drawn_in(), edge, body)
        assert field.pulled == pytest.approx(A - narrow, rel=0.02)
        outermost, other = (each.along(0.0, np.zeros(1))[:, 0, 0].max() for each in field.starts)
        assert other == pytest.approx(known, rel=0.01)
        assert outermost == pytest.approx(whole - inner, rel=0.01)
        assert outermost < 0.6 * other
    assert len(field_of(solved("halfplane"), 0, 1).starts) == 1


@cache
def pulled() -> Result:
    """Tension on the right side of the block beside Q, which the left side holds."""
    case = parse_case(
        pad(loads={"press": press(), "shear": shear(20, steps=8), "pull": pull(50, steps=8)},
            supports=SLIDING)
    )  # fmt: skip
    return replace(HALFPLANE.solve(case, RunOptions()), backend="halfplane")


def test_bulk_tension_is_that_of_the_pulled_body() -> None:
    """Far below the contact and beside it, what the tractions make has faded."""
    result = pulled()
    lower, upper = field_of(result, 0, 1), field_of(result, 0, 0)
    state = at_time(result, lower, 2.25)
    below = np.array([[0.0, -lower.reach(0.0)]])
    tension = lower.smooth.at(below)[state, 0]
    # Q reaches the side that is held: half of it is a tension of this one.
    assert tension[0] == pytest.approx(50, rel=0.1) and tension[0] != 50
    assert tension[1:] == pytest.approx([0, 0.3 * tension[0], 0])
    assert (upper.smooth.at(below) == 0).all()
    assert lower.stress(below)[state, 0, 0] == pytest.approx(
        tension[0] + lower.near.at(below)[state, 0, 0]
    )


def test_the_files_alone_will_do(tmp_path: Path) -> None:
    read = load_result(write_run(tmp_path / "run", "halfplane"))
    one, other = field_of(read, 1, 1), field_of(solved("halfplane"), 1, 1)
    distances = np.array([0.0, 0.01, 0.3])
    assert one.along(0.3, distances) == pytest.approx(other.along(0.3, distances), abs=1e-6 * P0)


def test_states_without_contact_have_no_stress() -> None:
    """Before the first touch; in others the stress does not depend on which are looked at."""
    result = solved("halfplane")
    contact, own = result.contacts[0], field_of(result, 0, 1)
    whole = edge_field(result, contact, contact.stations[0], 1, np.arange(own.states[-1] + 1))
    assert isinstance(whole, EdgeField) and contact.normal_force[0] == 0
    distances = np.array([0.01, 0.1, 0.3])
    found = whole.along(0.3, distances)
    assert not found[0].any()
    # More nodes are put next to more places of the edge.
    assert found[own.states] == pytest.approx(own.along(0.3, distances), abs=5e-5 * P0)


def test_what_is_not_known_has_a_reason() -> None:
    result = solved("halfplane")
    contact, incomplete = result.contacts[0], solved("incomplete")
    station = contact.stations[0]
    meshed = replace(result, backend="fem")
    assert "stress_depths" in str(edge_field(meshed, contact, station, 0))
    assert "not complete" in str(
        edge_field(incomplete, incomplete.contacts[0], incomplete.contacts[0].stations[0], 0)
    )
    vague = replace(station, k_n_spread=station.k_n)
    assert "K_N" in str(edge_field(result, contact, vague, 0))
    lost = replace(station, position=np.full_like(station.position, np.nan))
    assert "place" in str(edge_field(result, contact, lost, 0))
    assert edgeless(replace(contact, fronts=())) and not edgeless(contact)


def smooth_case(monkeypatch: pytest.MonkeyPatch, depths: Array) -> tuple[Result, StressHistory]:
    """Elements whose stress is that of half-planes and a field that bends and shears."""
    result = solved("halfplane")
    own = [field_of(result, 0, body) for body in (0, 1)]
    surface = result.solution.contacts[0].surface
    # Beside the contact too, as the surfaces of meshed bodies go on there.
    frames = np.array([[0.0, 1.0], [1.0, 0.0]])
    bodies = []
    for field, up in zip(own, (-1.0, 1.0), strict=True):
        x = surface.arc - result.contacts[0].stations[0].position[field.states].min()
        points = np.stack(np.broadcast_arrays(x, -depths[:, None]), axis=-1)
        flat = points.reshape(-1, 2)
        stress = field.near.at(flat) + bent(flat)
        stress[..., 3] *= up
        shape = len(field.states), len(depths), len(x), 4
        normals = np.tile([0.0, up], (len(x), 1))
        bodies.append(BodyStress(field.body, points, normals, stress.reshape(shape)))
    states = own[0].states
    contact = result.solution.contacts[0]
    history = StressHistory(
        "main", depths, states, result.solution.times[states], surface.arc,
        np.tile(frames, (len(surface.arc), 1, 1)), np.asarray(contact.mean_traction[states]),
        np.asarray(contact.slip[states])[..., 0], np.asarray(contact.status[states]),
        (bodies[0], bodies[1]), (),
    )  # fmt: skip
    monkeypatch.setattr(Result, "has_stress", True)
    monkeypatch.setattr(Result, "stress_history", lambda *_: history)
    return replace(result, backend="fem"), history


def bent(points: Array) -> Array:
    """(M, 4) a smooth stress in balance below a free surface, in a body's own axes.

    By Airy's y² (45 + 10 x - 5 y + 15 (x² - y²/3) + 8 (x³ - x y²)), which is biharmonic.
    """
    x, y = points.T
    along = 90 + 20 * x - 30 * y + 30 * x**2 - 60 * y**2 + 16 * x**3 - 96 * x * y**2
    across, shear = 30 * y**2 + 48 * x * y**2, 32 * y**3 - 20 * y - 60 * x * y - 48 * x**2 * y
    return np.stack([along, across, 10 * x * y, shear], axis=-1)


@pytest.mark.parametrize("body", [0, 1])
def test_what_elements_have_beside_the_tractions(
    monkeypatch: pytest.MonkeyPatch, body: int
) -> None:
    """A cubic field is found exactly, at the surface too, above all depths that are used."""
    depths = np.array([0.0, 0.0002, 0.05, 0.1, 0.2, 0.4])
    result, history = smooth_case(monkeypatch, depths)
    history.bodies[body].stress[:, :2] += 1e3
    field = field_of(result, 0, body)
    points = np.array([[0.0, 0.0], [0.1, -0.02], [0.2, -0.4]])
    assert field.smooth.at(points)[3] == pytest.approx(bent(points), abs=1e-6)
    assert field.smooth.spread == pytest.approx(0, abs=1e-6)
    assert field.reach(0.0) == 0.4 and field.reach(0.5) == pytest.approx(0.4 / np.cos(0.5))
    # Elements end with the contact surface, outward.
    assert field.reach(-0.5) < 0.05


def test_few_depths_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    result, _ = smooth_case(monkeypatch, np.array([0.0, 0.0002, 0.05]))
    contact = result.contacts[0]
    assert "depths of 2 elements" in str(edge_field(result, contact, contact.stations[0], 1))


@pytest.mark.parametrize(("elements", "error"), [(2.6, 0.02), (1.4, 0.06)])
def test_few_elements_in_a_slip_zone_lose_the_stress_next_to_the_edge(
    elements: float, error: float
) -> None:
    """Of nodal tractions that are exact: the tension at the edge, and a tenth of an element in."""
    result = solved("halfplane")
    contact, size = result.contacts[0], (A - C) / elements
    arc = np.arange(-A - 5.3 * size, A + 5 * size, size)
    p, core = (P0 * np.sqrt(np.maximum(1 - (arc / each) ** 2, 0)) for each in (A, C))
    traction = np.stack([p, 0.4 * (p - C / A * core)], axis=1)[None]
    ends = np.array([[-A], [A]])
    nodes = near_field.divided(arc, ends, np.array([-A]))
    pressure, shear = near_field.on_nodes(nodes, arc, traction, ends)
    points = np.array([[0.0, 0.0], [0.0, -0.1 * size]])
    found = near_field.NearField(nodes + A, pressure, shear, 0.3).at(points)[0, :, 0]
    known = exact(field_of(result, 0, 1), points)[:, 0]
    missed = np.abs(found / known - 1).max()
    assert error / 4 < missed < error
    finest = module._finest(contact.stations[0], 0.0718 / elements)
    assert (finest > 0) == (missed > 0.02)


@pytest.mark.parametrize("size", [0.05, 0.1])
def test_rear_edge_of_a_contact_that_slides(size: float) -> None:
    """2 f p0 where q is f p throughout, to 2 % with a tenth of the half-width; by exact nodes."""
    arc = np.arange(-A - 5.3 * size * A, A + 5 * size * A, size * A)
    p = P0 * np.sqrt(np.maximum(1 - (arc / A) ** 2, 0))
    nodes = near_field.divided(arc, np.array([[-A], [A]]), np.array([-A]))
    traction = np.stack([p, 0.4 * p], axis=1)[None]
    pressure, shear = near_field.on_nodes(nodes, arc, traction, np.array([[-A], [A]]))
    points = np.array([[0.0, 0.0], [0.0, -0.1 * A], [0.1 * A, -0.1 * A]])
    found = near_field.NearField(nodes + A, pressure, shear, 0.3).at(points)[0]
    known = elliptical_stress(points[:, 0] - A, -points[:, 1], A, P0, 0.4 * P0)
    assert found[0, 0] == pytest.approx(2 * 0.4 * P0, rel=0.02)
    assert np.abs(found[:, [0, 1, 3]] - known).max() < 0.02 * P0
