# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies: material, supports and loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices


@dataclass(frozen=True)
class Material:
    """Isotropic linear elasticity.

    Attributes:
        young: Young's modulus (stress).
        poisson: Poisson's ratio.
        density: mass per volume, zero if no load needs it.
        plane: "strain" or "stress"; without meaning in three dimensions.
    """

    young: float
    poisson: float
    density: float
    plane: str

    @property
    def shear_modulus(self) -> float:
        """Second Lamé parameter (stress)."""
        return self.young / (2 * (1 + self.poisson))

    @property
    def first_lame(self) -> float:
        """First Lamé parameter (stress), the effective one in plane stress."""
        nu = self.poisson
        if self.plane == "stress":
            return self.young * nu / (1 - nu**2)
        return self.young * nu / ((1 + nu) * (1 - 2 * nu))

    @property
    def kolosov(self) -> float:
        """Kolosov's constant: 3 - 4 nu in plane strain, (3 - nu)/(1 + nu) in plane stress."""
        mu, lame = self.shear_modulus, self.first_lame
        return (lame + 3 * mu) / (lame + mu)


@dataclass(frozen=True)
class DistributedLoad:
    """A load per unit of its channel that is spread over a boundary or the volume.

    Attributes:
        channel: name of the load in the case file.
        kind: "traction" (along `direction`), "normal" (outward traction), or "rotation".
        boundary: physical group of a traction, "" for a rotation.
        direction: unit vector of a traction; axis of a rotation.
        centre: a point on the axis of a rotation.
    """

    channel: str
    kind: str
    boundary: str = ""
    direction: tuple[float, ...] = ()
    centre: tuple[float, ...] = ()


@dataclass(frozen=True)
class Constraint:
    """A boundary that moves by one amplitude: along a direction, or about an axis.

    Attributes:
        label: name used in results and messages.
        boundary: physical group.
        direction: unit vector (gdim,); (0, ...) of a tilt.
        roller: true if only the displacement along `direction` is constrained, false if each of its
            non-zero components is.
        axis: unit vector (3,) of the axis of a tilt; empty otherwise.
        centre: (gdim,) a point on that axis.
    """

    label: str
    boundary: str
    direction: tuple[float, ...]
    roller: bool = False
    axis: tuple[float, ...] = ()
    centre: tuple[float, ...] = ()

    @property
    def components(self) -> Indices:
        """Components of the displacement that it constrains, unless it is a roller."""
        if self.axis:
            return np.arange(len(self.direction))
        return np.flatnonzero(self.direction)

    def displacement(self, points: Array) -> Array:
        """(n, gdim) displacement of points (n, gdim) by a unit amplitude."""
        if not self.axis:
            return np.tile(np.array(self.direction), (len(points), 1))
        arms = points - np.array(self.centre)
        if points.shape[1] == 2:
            return self.axis[2] * np.column_stack([-arms[:, 1], arms[:, 0]])
        return np.cross(self.axis, arms)
