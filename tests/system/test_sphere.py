# SPDX-License-Identifier: LGPL-3.0-or-later
"""Spheres on flats, ν = 0, against Hertz, Mindlin, the torsion of a bonded circle and half-spaces.

Edge factors and slip zones along the front are there against closed forms too.

E* = E / 2 and the contact radius is a. What differs from half-spaces is told apart by other runs:
bodies w a wide and high move by a share of their motion that goes with 1 / w, the curvature a / R
takes part (R = 50 a: tangential displacement +2.3 %, work +2.3 %), and shear around the border of
stick is a matter of the elements (rms 2.4 % of its peak with a / 12, 1.6 % with a / 20, whatever
R and w are).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from campaign.extent import every_so_many_weeks
from reference.halfspace import HalfSpaceRun, SphereOnFlat, run_forces
from scipy.spatial import cKDTree

from fretfe._typing import Array
from fretfe.evaluate.contacts import Front, Station
from fretfe.exchange.joint import joint_loops
from fretfe.history.solution import SLIP as SLIPS
from fretfe.history.solution import STICK as STICKS
from fretfe.history.solution import ContactHistory, Solution
from fretfe.results.model import Result

Data = dict[str, Any]
Solve = Callable[[Data], Result]

RADIUS, YOUNG, FRICTION, SHARE = 200.0, 2e5, 0.5, 0.4
SIZE, WIDTH = 1 / 16, 40.0
FORCE = 2 * YOUNG / (3 * RADIUS)  # a = 1
PEAK = 3 * FORCE / (2 * np.pi)
COMPLIANCE = 8 / YOUNG  # (2 - ν1)/G1 + (2 - ν2)/G2
STICK = (1 - SHARE) ** (1 / 3)
LIMIT = FRICTION * FORCE
MOMENT = 1e-3 * FORCE
HOLD = [{"hold": True, "until": 1.0}]
K_N = PEAK * np.sqrt(2)
# ΔK of a bonded circle under the range of Q.
RANGE = 2 * SHARE * LIMIT / (2 * np.pi * np.sqrt(2))
# Where nothing is asked about fronts, which take most of the time.
NO_FRONTS: Data = {"stations": 8, "local": False}
# Steps to a load of half the limit, and of its turn by 360 degrees.
RISE, TURN, HALF = 4, 12, 0.5
ANGLES = 2 * np.pi * np.concatenate([np.zeros(RISE), np.arange(1, TURN + 1) / TURN])

pytestmark = pytest.mark.slow


def geometry(size: float, width: float) -> Data:
    sides = {f"{body}_{side}": width for body in ("upper", "lower") for side in ("width", "height")}
    parameters = {"radius_x": RADIUS, "size": size, "growth": 0.45, **sides}
    return {"template": "sphere", "parameters": parameters}


def tables(
    friction: float,
    *,
    shear: list[Data] = HOLD,
    cross: list[Data] = HOLD,
    twist: list[Data] = HOLD,
    size: float = SIZE,
    width: float = WIDTH,
    edges: Data = NO_FRONTS,
) -> Data:
    def platen(direction: str, history: list[Data]) -> Data:
        kind = {"type": "platen", "boundary": "upper_top", "control": "force"}
        return {**kind, "direction": direction, "history": history}

    turn = {"type": "tilt", "boundary": "upper_top", "axis": "y", "centre": [0, 0, 0]}
    return {
        "geometry": geometry(size, width),
        "bodies": {name: {"young": YOUNG, "poisson": 0.0} for name in ("upper", "lower")},
        "contacts": {
            "main": {
                "surface1": "upper_contact",
                "surface2": "lower_contact",
                "friction": friction,
            }
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        "loads": {
            "press": platen("y", [{"ramp": -FORCE, "until": 1.0, "steps": 1}]),
            "shear": platen("x", shear),
            "cross": platen("z", cross),
            "twist": {**turn, "control": "moment", "history": twist},
        },
        "edges": edges,
    }


def cycles() -> list[Data]:
    """Q to the largest value in four steps, then two cycles of twelve."""
    load = SHARE * LIMIT
    turns = [{"ramp": (-1) ** k * load, "until": 2.0 + k, "steps": 6} for k in range(1, 5)]
    return [*HOLD, {"ramp": load, "until": 2.0, "steps": 4}, *turns]


def turning(component: Callable[[Array], Array]) -> list[Data]:
    """Half of the limit along x, then turned by 360 degrees at constant size."""
    load = HALF * LIMIT * component(ANGLES[RISE:])
    ends = 2 + np.arange(1, TURN + 1) / TURN
    turn = [
        {"ramp": float(q), "until": float(t), "steps": 1} for q, t in zip(load, ends, strict=True)
    ]
    start = HALF * LIMIT * float(component(np.zeros(1))[0])
    return [*HOLD, {"ramp": start, "until": 2.0, "steps": RISE}, *turn]


@pytest.fixture(scope="module")
def cycled(solved: Solve) -> Result:
    case = tables(FRICTION, shear=cycles(), edges={"stations": 40})
    return solved(case | {"cycle": {"start": 4.0, "end": 6.0}})


@pytest.fixture(scope="module")
def sheared(cycled: Result) -> Solution:
    return solution(cycled)


@pytest.fixture(scope="module")
def front(cycled: Result) -> Front:
    (area,) = cycled.contacts
    (front,) = area.fronts
    return front


@pytest.fixture(scope="module")
def twisted(solved: Solve, sheared: Solution) -> Solution:
    """Pressed, then turned, with more friction than slips; of the bodies of `sheared`."""
    return solution(solved(tables(1e4, twist=[*HOLD, {"ramp": MOMENT, "until": 2.0, "steps": 1}])))


@pytest.fixture(scope="module")
def turned(solved: Solve, sheared: Solution) -> Solution:
    """Under a load that turns; of the bodies of `sheared`."""
    return solution(solved(tables(FRICTION, shear=turning(np.cos), cross=turning(np.sin))))


@pytest.fixture(scope="module")
def twin() -> HalfSpaceRun:
    """The same load on half-spaces; with 50 cells shear differs by 1.1 % of its peak."""
    problem = SphereOnFlat(cells=36, extent=1.06)
    load = problem.load_for(1.0)
    size = HALF * np.minimum(np.arange(1, len(ANGLES) + 1) / RISE, 1.0)
    shear = FRICTION * load * size[:, None] * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
    forces = np.column_stack([np.full(len(ANGLES), -load), shear])
    return run_forces(problem, np.vstack([[-load, 0, 0], forces]), FRICTION)


def solution(result: Result) -> Solution:
    assert result.failure is None
    return result.solution


def moved(found: Solution, name: str) -> Array:
    return np.asarray(found.amplitudes[:, found.coordinates.index(name)])


def distance(contact: ContactHistory) -> Array:
    return np.hypot(contact.surface.points[:, 0], contact.surface.points[:, 2])


def vectors(contact: ContactHistory, state: int) -> Array:
    """(N, 3) mean shear around the nodes."""
    shear = np.asarray(contact.mean_traction[state])[:, 1:]
    return np.asarray(np.einsum("nk,nkd->nd", shear, contact.surface.frames[:, 1:]))


def circle(squared: Array, r: Array, within: float) -> tuple[float, float]:
    """Value in the middle and radius of squares that fall with r²."""
    inside = r < within
    slope, middle = np.polyfit(r[inside] ** 2, squared[inside], 1)
    return float(np.sqrt(middle)), float(np.sqrt(-middle / slope))


def hertz(r: Array, radius: float) -> Array:
    return np.sqrt(np.maximum(1 - (r / radius) ** 2, 0.0))


def hat_means(contact: ContactHistory, function: Callable[[Array], Array]) -> Array:
    """(N, ...) means of a function of (x, z) around the nodes, as those of the tractions."""
    assert contact.surface.facets is not None
    s = (np.arange(16) + 0.5) / 16
    u, v = (each.ravel() for each in np.meshgrid(s, s))
    hats = np.column_stack([1 - u, u * (1 - v), u * v])
    corners = contact.surface.points[contact.surface.facets]
    sides = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.linalg.norm(np.cross(*sides), axis=1) / 2
    values = function(np.einsum("gk,fkd->fgd", hats, corners)[..., [0, 2]])
    # The map of the square to the triangle has the determinant 2 u.
    shares = hats * (2 * u / len(u))[:, None]
    parts = np.einsum("f,fg...,gk->fk...", area, values, shares).reshape(-1, *values.shape[2:])
    sums = np.zeros((len(contact.surface.weights), *values.shape[2:]))
    np.add.at(sums, contact.surface.facets.ravel(), parts)
    weights = np.bincount(contact.surface.facets.ravel(), np.repeat(area / 3, 3), len(sums))
    return np.asarray((sums.T / weights).T)


def radial(function: Callable[[Array], Array]) -> Callable[[Array], Array]:
    return lambda places: function(np.linalg.norm(places, axis=-1))


def rms(difference: Array, contact: ContactHistory) -> float:
    """Of the lengths of vectors (N, k), or of values (N,), in the contact and around it."""
    near = distance(contact) < 1.3
    squares = (difference.reshape(len(difference), -1) ** 2).sum(axis=1)
    return float(np.sqrt(np.average(squares[near], weights=contact.surface.weights[near])))


def test_pressure_is_that_of_hertz(sheared: Solution) -> None:
    (contact,) = sheared.contacts
    pressure = np.asarray(contact.mean_traction[1])[:, 0]
    peak, radius = circle(pressure**2, distance(contact), 0.8)
    assert peak == pytest.approx(PEAK, rel=3e-3)  # +.15 %
    assert radius == pytest.approx(1.0, rel=3e-3)  # -.19 %
    expected = hat_means(contact, radial(lambda r: PEAK * hertz(r, 1.0)))
    assert rms(pressure - expected, contact) < 0.012 * PEAK  # .8 %


def test_approach_is_that_of_hertz(sheared: Solution, size_effect: float) -> None:
    approach = -moved(sheared, "press")[1] * RADIUS
    assert approach - size_effect / WIDTH == pytest.approx(1.0, abs=3e-3)  # -1.30 % + 1.23 %


@pytest.fixture(scope="module")
def size_effect(solved: Solve) -> float:
    """Slope of approaches over 1 / width, of coarser elements in the contact."""

    def approach(width: float) -> float:
        found = solution(solved(tables(FRICTION, size=0.25, width=width)))
        return float(-moved(found, "press")[1]) * RADIUS

    widths = np.array([WIDTH / 2, WIDTH, 2 * WIDTH])
    approaches = [approach(width) for width in widths]
    slope, limit = np.polyfit(1 / widths, approaches, 1)
    assert np.ptp(approaches - slope / widths) < 1e-3
    assert limit == pytest.approx(1.0, abs=0.01)
    return float(slope)


def stick_radius(contact: ContactHistory, state: int, within: float) -> float:
    """From what friction leaves over, the squares of which fall with r²."""
    tractions = np.asarray(contact.mean_traction[state])
    missing = FRICTION * tractions[:, 0] - np.linalg.norm(tractions[:, 1:], axis=1)
    return circle(missing**2, distance(contact), within)[1]


def test_shear_is_that_of_mindlin(sheared: Solution) -> None:
    (contact,) = sheared.contacts
    shear = vectors(contact, 5)
    sign = np.sign(shear[:, 0].sum())
    peak = FRICTION * PEAK
    top = peak * float(hertz(np.array([STICK]), 1.0)[0])

    def exact(r: Array) -> Array:
        return peak * (hertz(r, 1.0) - STICK * hertz(r, STICK))

    off = sign * shear[:, 0] - hat_means(contact, radial(exact))
    assert rms(off, contact) < 0.02 * top  # 1.93 %
    assert np.abs(shear[:, 2]).max() < 0.025 * top
    assert stick_radius(contact, 5, 0.9 * STICK) == pytest.approx(STICK, abs=5e-3)  # -.32 %


def test_displacement_is_that_of_mindlin(sheared: Solution) -> None:
    whole = moved(sheared, "shear")
    mindlin = 3 * LIMIT / 16 * COMPLIANCE * (1 - (1 - SHARE) ** (2 / 3))
    assert whole[5] - whole[1] == pytest.approx(mindlin, rel=0.01)  # +.70 %


def test_dissipation_is_that_of_mindlin_and_deresiewicz(sheared: Solution) -> None:
    (contact,) = sheared.contacts
    left = 1 - SHARE
    shape = 1 - left ** (5 / 3) - 5 * SHARE / 6 * (1 + left ** (2 / 3))
    expected = 9 * LIMIT**2 / 10 * COMPLIANCE * shape
    found = np.asarray(contact.dissipation[18:30]).sum()
    assert found == pytest.approx(expected, rel=0.02)  # +.85 %


def test_cycle_nearly_returns_and_bodies_balance(sheared: Solution) -> None:
    """It is approached; `test_equal_spheres` shows why."""
    (contact,) = sheared.contacts
    first, second, third = (np.asarray(contact.mean_traction[n]) for n in (5, 17, 29))
    assert np.abs(second - first).max() < 0.015 * FRICTION * PEAK
    assert np.abs(third - second).max() < 0.004 * FRICTION * PEAK
    errors = sheared.certificates
    for kind in ("force", "moment"):
        assert (errors[f"{kind}_imbalance"] <= 1e-8 * errors[f"{kind}_scale"]).all()
    assert errors["worst"].max() < 1e-8
    assert sheared.iterations.max() <= 25 and not sheared.fallbacks.any()


def test_it_is_the_joint_of_mindlin_and_deresiewicz(cycled: Result) -> None:
    """Secant stiffness over that of full stick, and loss, by branches as Masing doubles them."""
    (loop,) = joint_loops(cycled)
    share = np.linspace(0, SHARE, 2001)
    branch = 1.5 * (1 - (1 - share) ** (2 / 3))  # over the displacement of f P in full stick
    stuck = loop.force_range * COMPLIANCE / 8
    found = 1 / (1 + loop.slip_range / stuck)
    assert found == pytest.approx(SHARE / branch[-1], rel=0.005)
    work = 8 * float(np.trapezoid(share, branch)) - 4 * SHARE * branch[-1]
    loss = 4 * loop.work / (np.pi * loop.force_range * (stuck + loop.slip_range))
    assert loss == pytest.approx(work / (np.pi * SHARE * branch[-1]), rel=0.02)


def falling(radius: Array) -> Array:
    """Coefficient of friction by the distance from the middle."""
    return 0.6 - 0.3 * radius**2


@every_so_many_weeks(2, 0)
def test_friction_by_radius_is_that_of_half_spaces(
    solved: Solve, sheared: Solution, tmp_path: Path
) -> None:
    grid = np.linspace(-2.5, 2.5, 101)
    x, z = (each.ravel() for each in np.meshgrid(grid, grid))
    coefficients = np.maximum(falling(np.hypot(x, z)), 0.1)
    rows = np.column_stack([x, 0 * x, z, coefficients])
    np.savetxt(tmp_path / "f.csv", rows, delimiter=",", header="x,y,z,friction", comments="")
    share = 0.7 * 0.42  # of P; f is .42 in the mean over p
    case = tables(0.0, shear=[*HOLD, {"ramp": share * FORCE, "until": 2.0, "steps": 2}])
    case["contacts"]["main"]["friction"] = {"csv": str(tmp_path / "f.csv")}
    found = solution(solved(case))
    problem = SphereOnFlat(cells=36, extent=1.06)
    load = problem.load_for(1.0)
    own = np.maximum(falling(np.linalg.norm(problem.centres, axis=1)), 0.1)
    forces = np.column_stack([np.full(3, -load), share * load * np.arange(3) / 2, np.zeros(3)])
    twin = run_forces(problem, forces, own)
    (contact,) = found.contacts
    shear = vectors(contact, len(found.times) - 1)[:, [0, 2]]
    off = shear - PEAK / (2 / np.pi) * hat_means(contact, lambda x: twin.field(2)(x)[..., 1:])
    top = 0.42 * PEAK
    assert rms(smoothed(off, contact), contact) < 0.02 * top
    moves = twin.motion[:, 1] * FORCE / load * 2 / YOUNG
    path = moved(found, "shear")
    assert path[-1] - path[1] == pytest.approx(moves[-1] - moves[0], rel=0.02)


@every_so_many_weeks(2, 1)
def test_turning_load_moves_the_sphere_as_half_spaces_do(
    turned: Solution, twin: HalfSpaceRun
) -> None:
    found = np.stack([moved(turned, name) for name in ("shear", "cross")], axis=1)
    path = found[2:] - found[1]
    # Lengths of the twin: E* = R = a = 1.
    expected = twin.motion[1:, 1:] * FORCE / twin.problem.load_for(1.0) * 2 / YOUNG
    assert np.linalg.norm(path - expected, axis=1).max() < 0.01 * np.abs(expected).max()


@every_so_many_weeks(2, 1)
@pytest.mark.parametrize("state", [RISE + TURN // 2, RISE + TURN], ids=["180", "360"])
def test_turning_load_leaves_the_shear_of_half_spaces(
    turned: Solution, twin: HalfSpaceRun, state: int
) -> None:
    """The border of stick is sharper than elements are: shear oscillates around it.

    The largest change of the direction is there; the rms is 5.7 % of the peak with a / 12, 4.5 %
    with a / 18, and 2.1 % between twins of 36 and 50 squares. It is gone one and a half elements
    away, or in means over three.
    """
    (contact,) = turned.contacts
    shear = vectors(contact, state + 1)[:, [0, 2]]
    expected = hat_means(contact, lambda x: twin.field(state)(x)[..., 1:])
    scale = PEAK / (2 / np.pi)
    off = shear - scale * expected
    top = FRICTION * PEAK * float(hertz(np.array([(1 - HALF) ** (1 / 3)]), 1.0)[0])
    sticking = contact.status[state + 1] == STICKS
    border = float(np.sqrt(contact.surface.weights[sticking].sum() / np.pi))
    away = np.abs(distance(contact) - border) > 1.5 * SIZE
    assert rms(off, contact) < 0.055 * top
    assert rms(off * away[:, None], contact) < 0.025 * top
    assert rms(smoothed(off, contact), contact) < 0.02 * top


def smoothed(values: Array, contact: ContactHistory) -> Array:
    """(N, k) means over discs of one and a half elements around the nodes."""
    near = cKDTree(contact.surface.points).query_ball_point(contact.surface.points, 1.5 * SIZE)
    return np.array(
        [np.average(values[i], axis=0, weights=contact.surface.weights[i]) for i in near]
    )


def test_torsion_of_a_bonded_sphere(twisted: Solution) -> None:
    (contact,) = twisted.contacts
    assert not np.any(np.asarray(contact.status[2]) == SLIPS)
    # The radius is .2 % too small, and the turn +1.0 %: it goes with the cube.
    _, radius = circle(np.asarray(contact.mean_traction[1])[:, 0] ** 2, distance(contact), 0.8)
    turn = 3 * MOMENT / (16 * radius**3) * 2 * (2 / YOUNG)
    assert moved(twisted, "twist")[2] == pytest.approx(turn, rel=0.01)
    r, shear = distance(contact), vectors(contact, 2) - vectors(contact, 1)
    around = shear[:, 0] * contact.surface.points[:, 2] - shear[:, 2] * contact.surface.points[:, 0]
    weights = contact.surface.weights
    assert abs((weights * around).sum()) == pytest.approx(MOMENT, rel=1e-3)

    def exact(r: Array) -> Array:
        return 3 * MOMENT * r**2 / (4 * np.pi * np.sqrt(np.maximum(1 - r**2, 1e-300))) * (r < 1)

    expected = hat_means(contact, radial(exact))
    ring = (r > 0.1) & (r < 0.6)
    mean = abs((weights * around)[ring].sum()) / (weights * expected)[ring].sum()
    assert mean == pytest.approx(1.0, abs=0.01)  # +.24 %


def of_stations(front: Front, number: Callable[[Station], float]) -> Array:
    return np.array([number(station) for station in front.stations])


def angles(front: Front) -> Array:
    points = np.array([station.point for station in front.stations])
    return np.arctan2(-points[:, 2], points[:, 0])


def test_front_is_the_circle_of_hertz(front: Front) -> None:
    assert front.closed and len(front.judged) == 40
    points = np.array([station.point for station in front.stations])
    radii = np.linalg.norm(points[:, [0, 2]], axis=1)
    assert np.abs(radii - 1).max() < 0.004
    assert abs(radii.mean() - 1) < 0.001


def test_k_n(front: Front) -> None:
    found = of_stations(front, lambda station: station.k_n[-1]) / K_N - 1
    spread = of_stations(front, lambda station: station.k_n_spread[-1]) / K_N
    assert np.abs(found).max() < 0.01  # .6 %
    assert abs(found.mean()) < 0.003  # .13 %
    assert np.mean(np.abs(found) < spread) > 0.95


def test_k_n_by_the_movement_of_the_front(front: Front) -> None:
    """Loads 5 % apart to either side move the front by .5 of an element; no fit to the pressure."""
    found = front.along("k_n_moved") / K_N - 1
    spread = front.along("k_n_moved_spread") / K_N
    assert abs(found.mean()) < 0.015
    assert np.abs(found).max() < 0.07
    assert np.mean(np.abs(found) < spread) > 0.95
    assert spread.max() < 0.17


def test_half_spaces(front: Front) -> None:
    """The forces that factors and front need are those of the contact, but for finite bodies."""
    found = front.half_space_ratios
    assert found.reason == ""
    assert found.half_axes == pytest.approx([1.0, 1.0], abs=0.004)
    assert found.shear == pytest.approx(1.0, abs=0.02)
    assert found.normal == pytest.approx(1.0, abs=0.02)
    assert found.pressure == pytest.approx(1.0, abs=0.02)
    assert np.isnan(found.twist)


def test_factors_of_full_stick(front: Front) -> None:
    """K_T = -K cos θ, K_S = K sin θ for a force along +x on body 2, θ about y from x.

    The platen pulls body 1 along x with the force of the case, and body 1 body 2.
    """
    theta = angles(front)
    count = len(front.stations[0].k_t)
    first = count - 13  # with the largest Q; six steps later it is the smallest one
    for name, exact in (("k_t", -np.cos(theta)), ("k_s", np.sin(theta))):
        histories = np.array([getattr(station, name) for station in front.stations])
        change = (histories[:, first + 6] - histories[:, first]) / -RANGE
        assert np.abs(change - exact).max() < 0.03
        assert float(change @ exact / (exact @ exact)) == pytest.approx(1.0, abs=0.01)


def test_range_of_the_vector(front: Front) -> None:
    found = front.along("k_range") / RANGE - 1
    assert abs(found.mean()) < 0.01
    assert np.abs(found).max() < 0.035
    spread = front.along("k_range_spread") / RANGE
    assert np.mean(np.abs(found) < spread) > 0.9
    assert np.median(spread) < 0.04
    assert front.along("turning").max() < 1e-6


def test_slip_zones(front: Front) -> None:
    """Widths within .005 a of Cattaneo's and Mindlin's, by what edges remember within 3 %."""
    zones = [station.slip_zones[-1] for station in front.stations]
    length = np.array([zone.length for zone in zones])
    assert all(zone.resolved and not zone.gross for zone in zones)
    assert np.abs(length - (1 - STICK)).max() < 0.008  # .0041
    predicted = np.array([zone.prediction for zone in zones])
    assert np.abs(predicted / (1 - STICK) - 1).max() < 0.04
