# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts of unlike bodies against closed forms, and slices of solids against the plane."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from cases import blocks
from scipy.optimize import brentq
from scipy.special import ellipk

from fretfe._typing import Array
from fretfe.analytic.edges import oscillation
from fretfe.case import Solid, parse_case
from fretfe.evaluate.contacts import Contact, Station
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.history.solution import Factor
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.results.model import Result

Data = dict[str, Any]
RADIUS = 20.0
# The contact of Hertz has a half-width of 1.
TITANIUM, STEEL = {"young": 114e3, "poisson": 0.34}, {"young": 210e3, "poisson": 0.29}
# beta = -.248 and its opposite.
SOFT, HARD = {"young": 1000.0, "poisson": 0.2}, {"young": 4000.0, "poisson": 0.3}
BETA = 0.24842


def modulus(*bodies: Data) -> float:
    return float(1 / sum((1 - each["poisson"] ** 2) / each["young"] for each in bodies))


def lines(size: float, growth: float, fine: int, far: float) -> Array:
    """From 0 on, the first ones apart by a size, the last one at `far` or before."""
    steps = size * np.concatenate([np.ones(fine), growth ** np.arange(1, 16)])
    ends = np.concatenate([[0.0], np.cumsum(steps)])
    return ends[: int(np.searchsorted(ends, far)) + 1]


def bodies(size: float, growth: float, far: float, *, whole: bool) -> Mesh:
    """A cylinder on a flat, or half of both."""
    x, y = lines(size, growth, round(1.2 / size), far), lines(size, growth, 1, far)
    if whole:
        x = np.concatenate([-x[:0:-1], x])

    def rounded(points: Array) -> Array:
        rise = points[:, 0] ** 2 / (2 * RADIUS) * (1 - points[:, 1] / y[-1])
        return points + rise[:, None] * [0.0, 1.0]

    upper = blocks.block("upper", x, y, mapping=rounded, cell="quadrilateral")
    return Mesh({"upper": upper, "lower": blocks.block("lower", x, -y[::-1], cell="quadrilateral")})


def tables(pair: tuple[Data, Data], force: float, friction: float, **press: Any) -> Data:
    platen = {"type": "platen", "boundary": "upper_top", "control": "force", "direction": "y"}
    return {
        "geometry": {"file": "none.msh"},
        "model": {"degree": 2},
        "bodies": dict(zip(("upper", "lower"), pair, strict=True)),
        "contacts": {
            "main": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": friction}
        },
        "loads": {
            "press": {**platen, "history": [{"ramp": -force, "until": 1, "steps": 2, **press}]}
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
    }


def sheared(pair: tuple[Data, Data], friction: float, share: float) -> Data:
    """A cylinder under Q = ± a share of f P."""
    force = np.pi * modulus(*pair) / (4 * RADIUS)
    data = tables(pair, force, friction)
    wave_ = {"wave": "sine", "amplitude": share * friction * force, "period": 1, "cycles": 1}
    history = [{"hold": True, "until": 1}, {**wave_, "steps_per_cycle": 8}]
    data["loads"]["shear"] = {**data["loads"]["press"], "direction": "x", "history": history}
    data["contacts"]["main"]["friction_from"] = 1
    return data


def solved_on(data: Data, mesh: Mesh) -> Result:
    result = solve(MPI.COMM_WORLD, parse_case(data), load=lambda: mesh)
    assert result.failure is None
    return result


def stuck_strip(resultant: complex, moment: complex, half_width: float, beta: float) -> Array:
    """(2,) K_I + i K_T, at the length 2a, of p + i q of full stick on a strip, q along x.

    p + i q = (A + B x) ((a + x)/(a - x))^(i eps)/sqrt(a^2 - x^2) is what bonded half-planes carry
    whatever strains and turns them alike at a distance (Mossakovskii 1954): its resultant and
    first moment tell A and B.
    """
    t = np.linspace(-40.0, 40.0, 8001)
    x, weight = np.tanh(t), 0.01 / np.cosh(t)
    shape = np.exp(2j * oscillation(beta) * t) * weight
    moments = [np.sum(x**power * shape) for power in range(3)]
    given = [resultant / half_width, moment / half_width**2]
    a, b = np.linalg.solve([moments[:2], moments[1:]], given)
    return np.sqrt(half_width / 2) * np.array([a - b, np.conj(a + b)])


@pytest.mark.parametrize(("pair", "beta"), [((SOFT, HARD), -BETA), ((HARD, SOFT), BETA)])
def test_factors_of_full_stick_are_those_of_a_bonded_strip(
    pair: tuple[Data, Data], beta: float
) -> None:
    """By P and by Q, both factors at once; .3 and .6 % are found, half of that on half the size."""
    data = sheared(pair, 0.6, 0.02)
    result = solved_on(data, bodies(0.025, 1.4, 12.0, whole=True))
    (contact,) = result.solution.contacts
    assert contact.integrals is not None
    for driver in range(2):
        field = contact.full_stick.fields[int(contact.integrals.areas[0])][:, :2, driver]
        traction, places = field @ [1, 1j], contact.integrals.positions[0]
        half_width, x = np.ptp(places) / 2, contact.surface.points[:, 0] - places.mean()
        exact = stuck_strip(
            contact.surface.weights @ traction,
            (contact.surface.weights * x) @ traction,
            half_width,
            beta,
        )
        # (stations, 2) at the length 1.
        found = contact.integrals.factors[0, ..., driver].mean(axis=0)
        found = found[:, Factor.K_I] + 1j * found[:, Factor.K_T]
        found = found * (2 * half_width) ** (1j * oscillation(beta))
        assert np.abs(found - exact).max() < 0.008 * np.abs(exact).max()


def quarter(body: BodyMesh, far: Array) -> BodyMesh:
    """A slice as the quarter of a body that is round about y, with layers like its columns."""
    points = body.points.copy()
    layer = (points[:, 2] - points[:, 2].min()) / np.ptp(points[:, 2]) * (len(far) - 1)
    points[:, 2] = np.interp(layer, np.arange(len(far)), far)
    if body.name == "upper":
        top = points[:, 1].max()
        points[:, 1] += points[:, 2] ** 2 / (2 * RADIUS) * (1 - points[:, 1] / top)
    return replace(body, points=points)


def pressed_sphere(size: float, friction: float, steps: int) -> tuple[Contact, Result]:
    """A quarter of an unlike sphere on a flat between two planes of symmetry."""
    x, mesh = lines(size, 1.6, round(1.2 / size), 9.0), bodies(size, 1.6, 9.0, whole=False)
    slices = extrude(mesh, Solid(length=1.0, layers=len(x) - 1))
    parts = {name: quarter(body, x) for name, body in slices.bodies.items()}
    force = modulus(SOFT, HARD) / (3 * RADIUS)
    data = tables((SOFT, HARD), force, friction, steps=steps)
    data["model"]["degree"], data["edges"] = 1, {"stations": 8}
    data["supports"]["base"]["fix"] = ["x", "y", "z"]
    for body in parts:
        for side, axis in (("back", "z"), ("left", "x")):
            data["supports"][f"{body}_{side}"] = {"boundary": f"{body}_{side}", "fix": [axis]}
    result = solved_on(data, Mesh(parts))
    return result.contacts[0], result


def test_unlike_spheres_without_friction_are_those_of_hertz() -> None:
    """E* by both bodies; seven elements over the radius, bodies of nine radii."""
    contact, _ = pressed_sphere(0.14, 0.0, 2)
    (front,) = contact.fronts
    assert not front.closed and not front.along("end").any()
    radii = np.array([np.hypot(*each.point[[0, 2]]) for each in front.stations])
    np.testing.assert_allclose(radii, 1.0, atol=0.015)
    k_n, bar = np.transpose([each.decisive_k_n for each in front.stations])
    # p0 sqrt(2/a), with a as it is: K_N goes with a^(-5/2) under a given force.
    own = 2 * modulus(SOFT, HARD) / (np.pi * RADIUS) * np.sqrt(2) * radii.mean() ** -2.5
    assert k_n.mean() == pytest.approx(own, rel=0.02)
    assert np.all(np.abs(k_n - own) < bar)


@pytest.mark.slow
def test_unlike_spheres_slip_from_the_edge_inward() -> None:
    """Artanh(k)/k = (f/beta) K(sqrt(1 - k^2)), k = c/a (Spence 1975), under P with friction.

    Nodes stick or slip as a whole: half of an element.
    """
    friction, size = 0.2, 0.1
    exact = brentq(lambda k: np.arctanh(k) / k - friction / BETA * ellipk(1 - k**2), 1e-6, 1 - 1e-9)
    contact, _ = pressed_sphere(size, friction, 10)
    found = np.sqrt(contact.stick_area[-1] / contact.contact_area[-1])
    assert found == pytest.approx(exact, abs=size / 2)
    for station in contact.fronts[0].stations:
        (zone,) = station.slip_zones  # of the last step, which formulas of shear do not predict
        assert np.isnan(zone.prediction)
        assert abs(zone.length - (1 - exact)) < zone.spread


@cache
def edges_of_a_slice(layers: int) -> list[Station]:
    """Left, right; in the middle of fronts. Twenty elements over the half-width, four to a zone."""
    data, mesh = sheared((TITANIUM, STEEL), 0.6, 0.4), bodies(0.05, 1.4, 12.0, whole=True)
    data["edges"] = {"stations": 8, "reference_length": 0.15}
    if layers:
        mesh = extrude(mesh, Solid(length=1.0, layers=layers))
        for body in ("upper", "lower"):
            for end in ("front", "back"):
                data["supports"][f"{body}_{end}"] = {"boundary": f"{body}_{end}", "fix": ["z"]}
    (contact,) = solved_on(data, mesh).contacts
    stations = [front.stations[len(front.stations) // 2] for front in contact.fronts]
    return sorted(stations, key=lambda each: each.point[0])


@pytest.mark.slow
def test_a_slice_has_the_factors_of_the_plane() -> None:
    plane, solid = edges_of_a_slice(0), edges_of_a_slice(2)
    for flat, deep in zip(plane, solid, strict=True):
        assert not deep.end
        for name in ("k_range", "k_i_range"):
            assert getattr(deep, name) == pytest.approx(getattr(flat, name), rel=0.01)
    # By elements of a/160, in the steady cycle; the middle of both directions is .2254.
    lengths = [[zone.local for zone in each.slip_zones[-2:]] for each in solid]
    bars = [[zone.local_spread for zone in each.slip_zones[-2:]] for each in solid]
    fine = np.array([[0.2155, 0.2354], [0.2354, 0.2155]])
    assert np.all(np.abs(lengths - fine) < bars)
    # Likewise, in two cycles. Beta makes 2.4 % of difference.
    ends = [[zone.end for zone in each.slip_zones[-2:]] for each in solid]
    k_n = np.array([each.k_n[end] for each, end in zip(solid, ends, strict=True)])
    widths = np.array([each.k_n_spread[end] for each, end in zip(solid, ends, strict=True)])
    exact = np.array([[2885.8, 2955.2], [2955.2, 2885.8]])
    np.testing.assert_allclose(k_n, exact, rtol=0.006)
    assert np.all(np.abs(k_n - exact) < widths) and np.all(widths < 0.025 * exact)
