# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interface problems between half-spaces: a sphere on a flat, no finite elements.

Tractions are constant on the squares of a grid; w is taken at their centres. Components are normal,
t1 = x, t2 = y. With nu = 0 the three directions do not influence each other and have the same
compliance 1 / (pi E* r) (Boussinesq, Cerruti); its integral over a rectangle is Love's (1929). With
the coupling of nu > 0 between similar bodies, Cerruti's part nu (x x^T) / r^2 is integrated with
the trapezoidal rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from cases.marching import march_through
from scipy.interpolate import RegularGridInterpolator

from fretfe._typing import Array
from fretfe.contact.interface import Coordinate, DenseCompliance, Interface
from fretfe.contact.march import March
from fretfe.contact.state import StepLoads


@dataclass(frozen=True)
class SphereOnFlat:
    """Sphere of radius R on a flat; the grid covers a disc.

    Attributes:
        cells: squares along the diameter of the disc.
        extent: radius of the disc.
        radius: of the sphere.
        modulus: E*; the tangential compliance is that of nu = 0 unless nu is given.
        nu: Poisson's ratio in the tangential compliance of similar bodies.
    """

    cells: int = 17
    extent: float = 1.3
    radius: float = 1.0
    modulus: float = 1.0
    nu: float = 0.0

    @property
    def size(self) -> float:
        """Side of a square."""
        return 2 * self.extent / self.cells

    @property
    def centres(self) -> Array:
        x = (np.arange(self.cells) - (self.cells - 1) / 2) * self.size
        grid = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
        return grid[np.linalg.norm(grid, axis=1) <= self.extent]

    def load_for(self, contact_radius: float) -> float:
        """Hertz: P = 4 E* a^3 / (3 R)."""
        return 4 * self.modulus * contact_radius**3 / (3 * self.radius)


def love(offset: Array, side: float) -> Array:
    """Integral of 1 / r over a square of the given side, seen from points (..., 2)."""

    def corner(x: Array, y: Array) -> Array:
        return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))

    x, y = np.moveaxis(offset, -1, 0)
    h = side / 2
    return corner(x + h, y + h) - corner(x - h, y + h) - corner(x + h, y - h) + corner(x - h, y - h)


def cerruti(offset: Array, side: float, points: int = 8) -> Array:
    """(..., 2, 2) integral of (x x^T) / r^3 over a square, seen from points (..., 2)."""
    s = ((np.arange(points) + 0.5) / points - 0.5) * side
    x = offset[..., None, None, 0] - s[:, None]
    y = offset[..., None, None, 1] - s[None, :]
    cubed = np.hypot(x, y) ** 3
    weight = (side / points) ** 2
    xx, xy, yy = ((a / cubed).sum(axis=(-1, -2)) * weight for a in (x * x, x * y, y * y))
    # Their trace is the integral of 1 / r, which is known.
    correction = (love(offset, side) - xx - yy) / 2
    return np.stack([np.stack([xx + correction, xy], -1), np.stack([xy, yy + correction], -1)], -2)


def compliance(problem: SphereOnFlat) -> Array:
    """(N*3, N*3) A."""
    offset = problem.centres[:, None] - problem.centres[None, :]
    n = len(offset)
    full = np.zeros((n, 3, n, 3))
    logarithmic = love(offset, problem.size) / (np.pi * problem.modulus)
    full[:, 0, :, 0] = logarithmic
    # 1/E* = (1 - nu^2) 2/E; tangential: [(1 - nu) / r + nu x x^T / r^3] (1 + nu) 2/E.
    factor = 1 / (1 - problem.nu)
    part = problem.nu * cerruti(offset, problem.size) / (np.pi * problem.modulus)
    full[:, 1:, :, 1:] = np.moveaxis(factor * part, 1, 2)
    full[:, 1, :, 1] += factor * (1 - problem.nu) * logarithmic
    full[:, 2, :, 2] += factor * (1 - problem.nu) * logarithmic
    return full.reshape(3 * n, 3 * n)


def build(
    problem: SphereOnFlat, controls: Sequence[str] = ("force", "force", "force")
) -> Interface:
    """Body 1 moves along n, x and y, each "force" or "displacement"."""
    centres = problem.centres
    n = len(centres)
    root = problem.size
    gap = np.zeros((n, 3))
    gap[:, 0] = root * (centres**2).sum(axis=1) / (2 * problem.radius)
    motion = np.zeros((n, 3, 3))
    motion[:, range(3), range(3)] = root * np.array([1.0, -1.0, -1.0])
    return Interface(
        components=3,
        compliance=DenseCompliance(compliance(problem)),
        gap=gap.ravel(),
        motion=motion.reshape(-1, 3),
        stiffness=np.zeros((3, 3)),
        loads=np.zeros((3 * n, 0)),
        coordinate_loads=np.zeros((3, 0)),
        roots=np.full(n, root),
        coordinates=tuple(
            Coordinate(label, "sphere", control)
            for label, control in zip(("n", "x", "y"), controls, strict=True)
        ),
        contacts={"main": slice(0, n)},
    )


def loads(
    interface: Interface, values: Sequence[float] | Array, friction: float | Array
) -> StepLoads:
    """Force or displacement of the sphere along n, x, y; friction of all nodes, or (N,)."""
    coefficients = np.broadcast_to(friction, interface.size)
    return StepLoads(np.empty(0), np.asarray(values, float), coefficients)


@dataclass(frozen=True)
class HalfSpaceRun:
    """A load history of a sphere on a flat.

    Attributes:
        problem: sphere and grid.
        tractions: (T, N, 3) on the squares.
        motion: (T, 3) of the sphere along n, x, y.
    """

    problem: SphereOnFlat
    tractions: Array
    motion: Array

    def field(self, state: int) -> RegularGridInterpolator:
        """Tractions (..., 3) at places (..., 2), linear between the centres of the squares."""
        problem = self.problem
        count = problem.cells
        x = (np.arange(-1, count + 1) - (count - 1) / 2) * problem.size
        squares = np.zeros((count + 2, count + 2, 3))
        column, row = np.round((problem.centres - x[0]) / problem.size).astype(int).T
        squares[column, row] = self.tractions[state]
        return RegularGridInterpolator((x, x), squares, bounds_error=False, fill_value=0.0)


def run_forces(problem: SphereOnFlat, forces: Array, friction: float | Array) -> HalfSpaceRun:
    """Solve for forces (T, 3) along n, x, y, one after the other."""
    interface = build(problem)
    steps = [loads(interface, force, friction) for force in (np.zeros(3), *forces)]
    results = list(march_through(March(interface), steps))
    root = interface.roots[:, None]
    tractions = np.array([result.state.traction / root for result in results])
    return HalfSpaceRun(problem, tractions, np.array([r.state.coordinates for r in results]))
