# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normals of a contact, between those of its two surfaces.

Where surfaces slide over one another, pairs of opposite points stay pairs, and the gap between them
opens by the sliding along the normal. Where one surface is flat that must not happen, whatever the
other one's curvature: the normal is that of the flat, next to roundings of either body. Between
curved surfaces the normal is the direction from centre to centre, and stays so too. Both are the
field of directions between the normals of both surfaces that turns least along the contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array
from fretfe.mesh.elements import quadrature, shape_slopes, shape_values
from fretfe.surface.surface import GAUSS_POINTS, Surface, mean_curvature

# Not loaded by whoever loads this module: until Gmsh begins SciPy would take a third of the time.
if TYPE_CHECKING:
    from scipy import sparse

# Distance of the surfaces times their curvature beyond which turning counts less: where they touch,
# the normal is that of what is close.
CLOSE = 1e-5
# Weight of the distance from a first guess, over the curvature squared, beside turning per length
# squared: where many fields turn equally little it decides, and elsewhere changes 1e-5 radians.
GUESS = 1e-3
# Steps of Newton's method: each moves many places to the border of what is allowed; few are needed.
PASSES = 50
# Part of a diagonal at which a matrix is taken for singular.
SINGULAR = 1e-12
# Radians: where no direction turns by more in a step, they have been found.
SMALLEST_TURN = 1e-12


def contact_normals(surface1: Surface, surface2: Surface) -> Array:
    """(f, k, d) unit normals of the contact at the nodes of surface 2, out of body 2.

    Those between the normals of both surfaces that turn least: a flat gives its own against any
    roundings, on either body or on both; cylinders give the direction between their axes,
    conforming surfaces their common normal.
    """
    curvature1, curvature2 = mean_curvature(surface1), mean_curvature(surface2)
    if curvature2 == 0:
        return surface2.normals
    places, opposite = surface1.nearest(surface2.points)
    own = np.empty_like(surface2.points)
    own[surface2.facets] = surface2.normals
    normals = -opposite
    if curvature1 > 0:
        # By mean curvatures the direction from centre to centre of cylinders and spheres.
        both = curvature1 + curvature2
        apart = both * np.linalg.norm(places - surface2.points, axis=1)
        turning = _turning(surface2, (CLOSE / (CLOSE + apart)) ** 2)
        arcs = _Arcs.between(-opposite, own)
        normals = arcs.taut(turning, curvature1 / both, GUESS * both**2)
    return normals[surface2.facets]


def mean_share(normals: Array, first: Array, last: Array) -> float:
    """Mean place of directions on the ways from first normals (0) to last ones (1), all (n, d).

    Ways count by their length, squared. 1 if both normals are the same everywhere.
    """
    way = last - first
    squares = float(np.sum(way**2))
    return float(np.sum((normals - first) * way)) / squares if squares > 0 else 1.0


@dataclass(frozen=True)
class _Arcs:
    """Directions on the arcs from one unit normal to another at n nodes, by their angles (n,).

    Attributes:
        first: (n, d) normals at the beginning of the arcs.
        across: (n, d) unit vectors normal to these, in the planes of the arcs.
        angle: (n,) of the whole arcs.
    """

    first: Array
    across: Array
    angle: Array

    @classmethod
    def between(cls, first: Array, last: Array) -> _Arcs:
        """Arcs between unit normals (n, d)."""
        cosine = np.sum(first * last, axis=1)
        across = last - cosine[:, None] * first
        sine = np.linalg.norm(across, axis=1)
        return cls(first, across / np.where(sine > 0, sine, 1.0)[:, None], np.arctan2(sine, cosine))

    def at(self, angle: Array) -> Array:
        """(n, d) unit directions."""
        return np.cos(angle)[:, None] * self.first + np.sin(angle)[:, None] * self.across

    def taut(self, turns: tuple[sparse.csr_array, Array], share: float, stiffness: float) -> Array:
        """(n, d) directions that turn least along a surface, ∫ |∇n|² over it.

        By projected Newton: where the end of an arc is pressed against, directions stay; all others
        take Newton's step, as far as arcs go, halved until it descends (Bertsekas 1982).

        Args:
            turns: as of `_turning`.
            share: of the arcs, a first guess.
            stiffness: with which directions keep to it, per measure of the surface.
        """
        turning, measures = turns
        guess, mass = share * self.angle, stiffness * measures

        def value(angle: Array) -> float:
            normals = self.at(angle)
            return float(np.sum(normals * (turning @ normals)) + mass @ (angle - guess) ** 2) / 2

        angle, round_off = guess, np.finfo(float).eps * float(turning.diagonal().sum())
        for _ in range(PASSES):
            step = self._newton(angle, turning, mass, guess)
            most, size = value(angle) + round_off, 1.0
            while value(moved := np.clip(angle + size * step, 0.0, self.angle)) > most:
                size /= 2
            angle, turned = moved, float(np.abs(moved - angle).max())
            if turned < SMALLEST_TURN:
                break
        return self.at(angle)

    def _newton(self, angle: Array, turning: sparse.csr_array, mass: Array, guess: Array) -> Array:
        """(n,) step of Newton's method with the borders that angles (n,) press against held."""
        from scipy import sparse
        from scipy.sparse.linalg import spsolve

        tangent = self.at(angle + np.pi / 2)
        downhill = mass * (guess - angle) - np.sum(tangent * (turning @ self.at(angle)), axis=1)
        held = (angle <= 0) & (downhill <= 0) | (angle >= self.angle) & (downhill >= 0)
        columns = [sparse.diags_array(each) for each in tangent.T]
        # Where directions may turn together, and next to nothing keeps them, steps stay finite.
        held_back = mass + SINGULAR * turning.diagonal()
        hessian = sum(each @ turning @ each for each in columns) + sparse.diags_array(held_back)
        step, free = np.zeros(len(angle)), np.flatnonzero(~held)
        if len(free):
            step[free] = spsolve(hessian.tocsc()[free][:, free], downhill[free])
        return step


def _turning(surface: Surface, weights: Array) -> tuple[sparse.csr_array, Array]:
    """(n, n) matrix of ∫ w |∇x|² over a surface of values at its nodes, and (n,) ∫ w x.

    Args:
        surface: with n nodes.
        weights: (n,) w at the nodes, of which facets take the mean.
    """
    from scipy import sparse

    at, shares = quadrature(surface.shape, GAUSS_POINTS)
    slopes = shape_slopes(surface.shape, surface.degree, at)
    sides = np.einsum("qak,fkd->fqad", slopes, surface.nodes)
    metric = sides @ sides.swapaxes(2, 3)
    mean = weights[surface.facets].mean(axis=1)[:, None]
    measure = mean * shares * np.sqrt(np.linalg.det(metric))
    gradients = np.linalg.solve(metric, np.broadcast_to(slopes, (len(metric), *slopes.shape)))
    found = np.einsum("fq,qak,fqal->fkl", measure, slopes, gradients)
    rows, size = np.broadcast_to(surface.facets[:, :, None], found.shape), len(surface.points)
    columns = rows.swapaxes(1, 2)
    values = shape_values(surface.shape, surface.degree, at)
    return (
        sparse.csr_array((found.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size)),
        np.bincount(surface.facets.ravel(), (measure @ values).ravel(), size),
    )
