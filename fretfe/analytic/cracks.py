# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress intensity of straight cracks that start at the surface of a half-plane, at any angle.

x runs along the surface, y along its outward normal, and the body is at y < 0. The angle of a crack
is that from the inward normal, positive where the crack goes to +x. n is the direction along the
crack turned by a quarter to the left: (1, 0) of a crack along the inward normal. By superposition
the crack has the tractions that the uncracked body has on its line, with the other sign.

An edge dislocation at z0 = x0 + i y0 of an infinite plane has Muskhelishvili's potentials

    Φ0 = B/(z - z0),   Ψ0 = B̄/(z - z0) + B z̄0/(z - z0)²,

with B the Burgers vector times G/(π i (κ + 1)). That the surface is free asks for

    Φ1 = -(B/m + B̄ e/m²),   Ψ1 = -(B̄/m + Φ1 + z Φ1'),   m = z - z̄0,   e = z0 - z̄0

in addition: on the real axis Φ + Φ̄ + z Φ' + Ψ is the traction, and what of it is analytic above
the surface and what is below must vanish each. On a line along exp(i α)

    σ_nn + i σ_nt = Φ + Φ̄ + exp(2 i α) (z̄ Φ' + Ψ).

Distributed along the crack, they make it open (Hills, Kelly, Dai and Korsunsky: Solution of crack
problems, 1996). The integral equations are solved by Gauss-Chebyshev quadrature (Erdogan and Gupta,
Quart. Appl. Math. 29, 1972), in v from -1 at the mouth to 1 at the tip with r/c = ((1 + v)/2)^1.5:
a density that is finite at the mouth is then smooth there, as 1/√(1 - v) at the tip is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array, Complexes
from fretfe.analytic._numerics import check_positive, check_range

# Of the distance from the mouth in v.
POWER = 1.5


@dataclass(frozen=True)
class EdgeCracks:
    """Straight cracks from one mouth in a half-plane, at A angles.

    Attributes:
        angles: (A,) from the inward normal, positive to +x [rad].
        places: (m,) where the stress on a crack is asked for, as parts of its length.
        weights: (2, A, 2, m) K_I and K_II over √(π c) by unit normal and shear tractions there.
    """

    angles: Array
    places: Array
    weights: Array

    @classmethod
    def of(cls, angles: ArrayLike, count: int = 60) -> EdgeCracks:
        """Cracks at some angles.

        Args:
            angles: (A,) between -80 and 80 degrees, in rad. Beyond 60 degrees more dislocations
                are needed.
            count: number of dislocations; of 60 factors under uniform tension are right to 1e-4
                up to 60 degrees.

        Raises:
            ValueError: if an angle is outside.
        """
        widest = np.radians(80.0)
        angles = np.atleast_1d(check_range("angles", angles, low=-widest, high=widest))
        rule = _Rule.of(count)
        weights = np.stack([rule.weights(float(each)) for each in angles], axis=1)
        return cls(angles, rule.loaded, weights)

    @property
    def directions(self) -> Array:
        """(A, 2) unit vectors into the body along the cracks."""
        return np.stack([np.sin(self.angles), -np.cos(self.angles)], axis=1)

    def points(self, lengths: ArrayLike) -> Array:
        """(A, C, m, 2) points from the mouth at which `factors` needs the stress.

        Args:
            lengths: (C,) of the cracks.

        Raises:
            ValueError: if a length is not positive.
        """
        along = np.multiply.outer(check_positive("lengths", lengths), self.places)
        return np.asarray(self.directions[:, None, None] * along[..., None])

    def factors(self, lengths: ArrayLike, stress: Array) -> Array:
        """(2, ..., A, C) K_I and K_II, in stress times root of length.

        K_I is negative where the tractions press the faces together: a crack that closes has none.
        K_II is positive where the side of the crack that n points to moves to the tip.

        Args:
            lengths: (C,) of the cracks.
            stress: (..., A, C, m, 3) components xx, yy, xy in the uncracked body at `points`.

        Raises:
            ValueError: if a length is not positive.
        """
        scale = np.sqrt(np.pi * check_positive("lengths", lengths))
        sine, cosine = np.sin(self.angles), np.cos(self.angles)
        # Components of n n and of n along the crack.
        normal = np.stack([cosine**2, sine**2, 2 * sine * cosine], axis=1)
        shear = np.stack([sine * cosine, -sine * cosine, sine**2 - cosine**2], axis=1)
        onto = np.stack([normal, shear], axis=1)
        return np.asarray(
            np.einsum("katm,atj,...acmj->k...ac", self.weights, onto, stress, optimize=True) * scale
        )


@dataclass(frozen=True)
class _Rule:
    """Quadrature along a crack of length 1.

    Attributes:
        places: (n,) of the dislocations.
        loaded: (n - 1,) of the tractions.
        measure: (n,) weights times dr/dv.
        mouth, tip: (n,) factors that take values at the dislocations to the ends.
    """

    places: Array
    loaded: Array
    measure: Array
    mouth: Array
    tip: Array

    @classmethod
    def of(cls, count: int) -> _Rule:
        """That with a number of dislocations."""
        turn = (2 * np.arange(count) + 1) * np.pi / (2 * count)
        inner, between = np.cos(turn), np.cos(np.arange(1, count) * np.pi / count)
        slope = POWER / 2 * ((1 + inner) / 2) ** (POWER - 1)
        # Chebyshev polynomials through the n values, at v = 1 and at v = -1.
        orders = np.arange(count)
        series = np.where(orders, 2, 1)[:, None] * np.cos(np.outer(orders, turn)) / count
        return cls(
            ((1 + inner) / 2) ** POWER,
            ((1 + between) / 2) ** POWER,
            np.pi / count * slope,
            (-1.0) ** orders @ series,
            series.sum(axis=0),
        )

    def weights(self, angle: float) -> Array:
        """(2, 2, m) as of `EdgeCracks` at one angle."""
        n, m = len(self.places), len(self.loaded)
        direction = np.exp(1j * (angle - np.pi / 2))
        places, loaded = direction * self.places, direction * self.loaded[:, None]
        system = np.zeros((2, m + 1, 2, n))
        for mode, strength in enumerate((direction, -1j * direction)):
            stress = dislocation_traction(loaded, places, strength, direction) * self.measure
            system[:, :m, mode] = stress.real, stress.imag
            # The density is finite at the mouth.
            system[mode, m, mode] = self.mouth
        unit = np.zeros((2, m + 1, 2, m))
        unit[0, :m, 0] = unit[1, :m, 1] = -np.eye(m)
        shape = 2 * (m + 1)
        density = np.linalg.solve(system.reshape(shape, 2 * n), unit.reshape(shape, 2 * m))
        at_tip = np.einsum("n,knm->km", self.tip, density.reshape(2, n, 2 * m))
        # A density A/√(1 - r) has 2 π A/√(r - 1) ahead of the tip: K = (2 π)^1.5 A, over √π; and
        # A = √(1/2) √(power/2) times the density in v over 1/√(1 - v²).
        return at_tip.reshape(2, 2, m) * np.pi * np.sqrt(2 * POWER)


def dislocation_traction(
    z: Complexes, z0: Complexes, strength: complex, along: complex | Complexes
) -> Complexes:
    """σ_nn + i σ_nt on a line by dislocations in a half-plane whose surface is the real axis.

    Args:
        z: places on the line, below the real axis; any shape that broadcasts with the others.
        z0: places of the dislocations, below the real axis.
        strength: B of the module.
        along: exp(i α), the direction of the line.
    """
    conjugate = np.conj(strength)
    here, mirrored, across = z - z0, z - np.conj(z0), z0 - np.conj(z0)
    image = -(strength / mirrored + conjugate * across / mirrored**2)
    image_slope = strength / mirrored**2 + 2 * conjugate * across / mirrored**3
    phi = strength / here + image
    slope = -strength / here**2 + image_slope
    psi = conjugate / here + strength * np.conj(z0) / here**2
    psi = psi - (conjugate / mirrored + image + z * image_slope)
    return np.asarray(phi + np.conj(phi) + along**2 * (np.conj(z) * slope + psi))
