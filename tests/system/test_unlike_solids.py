# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interaction integrals of solids between unlike bodies, along straight and curved fronts."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from cases import blocks
from reference import bonded_circle
from reference.bonded_interface import POISSON, displacement
from scipy.special import gamma

from fretfe._typing import Array
from fretfe.analytic.edges import oscillation
from fretfe.case import Solid
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.interaction_integral import InteractionForm, Tip, Tube
from fretfe.materials.material import Material
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh


def dundurs(first: Material, second: Material) -> float:
    """Beta of body 1 above body 2."""
    (m1, k1), (m2, k2) = ((each.shear_modulus, 3 - 4 * each.poisson) for each in (first, second))
    return (m1 * (k2 - 1) - m2 * (k1 - 1)) / (m1 * (k2 + 1) + m2 * (k1 + 1))


def pair(beta: float, first: float, second: float) -> tuple[Material, Material]:
    """Bodies with Poisson's ratios, and the ratio of shear moduli that has a beta."""
    k1, k2 = 3 - 4 * first, 3 - 4 * second
    ratio = (k1 - 1 + beta * (k1 + 1)) / (k2 - 1 - beta * (k2 + 1))
    upper = Material(2 * ratio * (1 + first), first, 0.0, "strain")
    lower = Material(2 * (1 + second), second, 0.0, "strain")
    assert dundurs(upper, lower) == pytest.approx(beta)
    return upper, lower


def scales(bodies: tuple[Material, Material]) -> Array:
    """(3,) from integrals to K_I, K_T and K_S."""
    grown = np.cosh(np.pi * oscillation(dundurs(*bodies))) ** 2
    modulus = grown / sum((1 - each.poisson**2) / each.young for each in bodies)
    along = 2 / sum(1 / each.shear_modulus for each in bodies)
    return np.array([-modulus, modulus, along]) / np.sqrt(2 * np.pi)


def integral_over(
    mesh: BodyMesh, bodies: tuple[Material, Material], upper: bool
) -> tuple[ElasticBody, InteractionForm]:
    body, other = bodies if upper else bodies[::-1]
    rank = MPI.COMM_WORLD.rank
    elastic = ElasticBody(MPI.COMM_WORLD, mesh if rank == 0 else None, body, 2)
    excess = (body.first_lame - other.first_lame) / 2
    surface = f"{mesh.name}_{'bottom' if upper else 'top'}"
    epsilon = oscillation(dundurs(*bodies))
    return elastic, InteractionForm(elastic, [surface], upper, (), epsilon, excess)


LENGTH, REACH, SIZE = 0.8, 0.5, 0.05


@pytest.mark.parametrize("inward", [1.0, -1.0])
@pytest.mark.parametrize("beta", [0.07, -0.25])
def test_exact_fields_of_a_straight_front(beta: float, inward: float) -> None:
    """K_S with each body's own shear modulus; ten elements to the reach, two layers."""
    bodies, found = pair(beta, POISSON, POISSON), np.zeros((3, 3))
    span = np.linspace(-0.8, 0.8, round(1.6 / SIZE) + 1)
    depth = np.linspace(0.0, 0.8, round(0.8 / SIZE) + 1)
    for upper, material in zip((True, False), bodies, strict=True):
        name, side, mu = "pad" if upper else "block", 1 if upper else -1, material.shear_modulus
        plane = blocks.block(name, span, depth if upper else depth - 0.8, cell="quadrilateral")
        whole = extrude(Mesh({name: plane}), Solid(length=LENGTH, layers=2)).bodies[name]
        elastic, integral = integral_over(whole, bodies, upper)
        x, y, _ = elastic.space.tabulate_dof_coordinates().T
        z = inward * x + 1j * y
        moved = np.zeros((len(z), 3, 3))
        moved[:, :2, :2] = displacement(z, oscillation(beta), side, mu)
        # The tangent of the front runs against z at the left edge.
        angle = side * (np.pi / 2 + np.arctan2(-z.real, side * z.imag))
        moved[:, 2, 2] = -inward * 2 / mu * np.sqrt(np.abs(z)) * np.sin(angle / 2)
        moved[:, 0] *= inward
        frame = np.array([[0.0, 1.0, 0.0], [inward, 0.0, 0.0], [0.0, 0.0, -inward]])
        tip = Tip(np.array([0.0, 0.0, LENGTH / 2]), frame)
        found += integral.products(tip, [Tube(REACH, LENGTH / 2)], moved)[0]
    whole = scales(bodies)[:, None] * MPI.COMM_WORLD.allreduce(found)
    # 5e-5 is found: interpolation of a singular field.
    assert whole == pytest.approx(np.eye(3), abs=1e-3)


# Along the way of t = tanh(x + i PHI), on which the potentials of all depths have no singularity.
PHI, STEP = np.pi / 8, 0.1
CHUNK = 2000


def pressed_circle(
    points: Array, bodies: tuple[Material, Material], upper: bool
) -> tuple[Array, complex]:
    """(n, 3) displacements of points of a body, bonded in a circle of radius 1, by a unit of P.

    With Hankel transforms of pressure and inward shear int_0^1 f cos(kt) dt and int_0^1 g sin(kt)
    dt, f + i g = A ((1 + t)/(1 - t))^(-i epsilon): Abel's equations for displacements that agree in
    the circle (Mossakovskii 1954, Spence 1968). Also K_I + i K_T at the length 1.
    """
    body, epsilon = bodies[0 if upper else 1], oscillation(dundurs(*bodies))
    k, mu = 3 - 4 * body.poisson, body.shear_modulus
    x = np.arange(-20.0, 20.0, STEP) + 1j * PHI
    t, weight = np.tanh(x), STEP / np.cosh(x) ** 2
    wave = np.exp(-2j * epsilon * x)
    size = np.sinh(np.pi * epsilon) / (2 * np.pi**2 * epsilon)
    p, q = size * (wave + 1 / wave) / 4, -size * (wave - 1 / wave) / 4
    # Body 2 sees the opposite shear.
    q = q if upper else -q
    found = np.empty_like(points)
    for rows in np.array_split(np.arange(len(points)), len(points) // CHUNK + 1):
        px, py, pz = points[rows].T
        radius, depth = np.maximum(np.hypot(px, pz), 1e-12), np.abs(py)
        zeta, r, z = depth[:, None] - 1j * t, radius[:, None], depth[:, None]
        root = np.sqrt(r**2 + zeta**2)
        zero, one = 1 / root, (1 - zeta / root) / r
        both = 2 * z * (p - q) / root**3
        aside = ((k + 1) * q - (k - 1) * p) * one + both * r
        down = ((k + 1) * p - (k - 1) * q) * zero + both * zeta
        along, across = ((each @ weight).real / (4 * mu) for each in (aside, down))
        found[rows] = np.column_stack(
            [along * px / radius, across if upper else -across, along * pz / radius]
        )
    turn = np.sqrt(np.pi) * gamma(1 + 1j * epsilon) / gamma(0.5 + 1j * epsilon)
    return found, size * turn * 2 ** (-0.5 - 1j * epsilon)


CIRCLE_SIZE, HALF, DEPTH = 0.1, 1.6, 0.6
ANGLES = np.array([0.1])
# Nodes farther from the circle are in no tube.
NEAR = 0.6


@cache
def around_a_circle(bodies: tuple[Material, Material]) -> tuple[Array, complex]:
    """(n, 3, 2) K_I, K_T and K_S found at stations under a unit of P and of M, and K_I + i K_T."""
    count = round(2 * HALF / CIRCLE_SIZE)
    span = np.linspace(-HALF, HALF, count + 1)
    depth = np.linspace(0.0, DEPTH, round(DEPTH / CIRCLE_SIZE) + 1)
    points, frames = bonded_circle.frames(ANGLES)
    sums, exact = np.zeros((len(ANGLES), 3, 2)), 0j
    for upper, material in zip((True, False), bodies, strict=True):
        name = "pad" if upper else "block"
        plane = blocks.block(name, span, depth if upper else depth - DEPTH, cell="quadrilateral")
        whole = extrude(Mesh({name: plane}), Solid(length=2 * HALF, layers=count)).bodies[name]
        places = whole.points - [0.0, 0.0, HALF]
        mesh = BodyMesh(name, places, whole.cells, whole.cell, whole.order, whole.boundaries)
        elastic, integral = integral_over(mesh, bodies, upper)
        at = elastic.space.tabulate_dof_coordinates()
        near = np.hypot(np.hypot(at[:, 0], at[:, 2]) - 1, at[:, 1]) < NEAR
        pressed = np.zeros_like(at)
        pressed[near], exact = pressed_circle(at[near], bodies, upper)
        twisted = bonded_circle.displacements(at, upper, material.shear_modulus, 0.3)[..., 2]
        moved = np.stack([pressed, twisted], axis=2)
        for row, each in enumerate(zip(points, frames, strict=True)):
            sums[row] += integral.products(Tip(*each, 1.0), [Tube(0.3, 0.4)], moved)[0]
    return MPI.COMM_WORLD.allreduce(sums) * scales(bodies)[:, None], exact


# Shear moduli 15 to 1, and about those of titanium on steel.
BODIES = {0.25: pair(0.25, 0.3, 0.3), -0.07: pair(-0.07, 0.34, 0.29)}


@pytest.mark.slow
@pytest.mark.parametrize("beta", BODIES)
def test_exact_fields_of_a_circle(beta: float) -> None:
    found, exact = around_a_circle(BODIES[beta])
    wanted = np.array([exact.real, exact.imag, 0.0])
    twisted = bonded_circle.factors(ANGLES)[:, :, 2]
    by_pressure = np.abs(found[..., 0] - wanted).max() / abs(exact)
    by_twist = np.abs(found[..., 1] - twisted).max() / np.abs(twisted).max()
    # As between equal bodies: interpolation of a singular field, ten elements along the radius.
    assert max(by_pressure, by_twist) < 0.013
