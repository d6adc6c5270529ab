# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear elasticity of a body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.case import AnyBody, Plane, isotropic
from fretfe.materials.crystals import isotropic as isotropic_stiffness
from fretfe.materials.crystals import plane_stress, tensor
from fretfe.materials.moduli import stiffness

# Stiffnesses below this part of the largest one are not listed.
SHOWN = 1e-6


@dataclass(frozen=True)
class Material:
    """Linear elasticity of a body.

    Attributes:
        young: Young's modulus (stress); NaN of a crystal.
        poisson: Poisson's ratio; NaN of a crystal.
        density: mass per volume, zero if no load needs it.
        plane: "strain" or "stress"; without meaning in three dimensions.
        expansion: coefficient of thermal expansion, zero if no load needs it.
        reference_temperature: without thermal strain.
        crystal: (6, 6) stiffness of a crystal in the axes of the model, in Voigt's order as in
            `materials.crystals`, in plane stress that of strains in the plane; None if isotropic.
    """

    young: float
    poisson: float
    density: float
    plane: str
    expansion: float = 0.0
    reference_temperature: float = 0.0
    crystal: tuple[tuple[float, ...], ...] | None = None

    @classmethod
    def of(cls, body: AnyBody, plane: Plane) -> Material:
        """The material of a body of a case."""
        known = isotropic(body)
        young, poisson = (known.young, known.poisson) if known else (np.nan, np.nan)
        rest = body.density or 0.0, plane, body.expansion or 0.0, body.reference_temperature or 0.0
        crystal = None if known else tuple(map(tuple, stiffness(body, plane).tolist()))
        return cls(young, poisson, *rest, crystal)

    @property
    def text(self) -> str:
        """The elastic constants, for people."""
        if self.crystal is None:
            return f"E = {self.young:g}, ν = {self.poisson:g}"
        matrix = np.array(self.crystal)
        return "crystal, in the axes of the model " + ", ".join(
            f"C{i + 1}{j + 1} = {matrix[i, j]:.5g}"
            for i, j in zip(*np.triu_indices(6), strict=True)
            if abs(matrix[i, j]) > SHOWN * np.abs(matrix).max()
        )

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

    @property
    def stiffness(self) -> Array:
        """(6, 6) in the axes of the model, in plane stress that of strains in the plane."""
        if self.crystal is not None:
            return np.array(self.crystal)
        whole = isotropic_stiffness(self.young, self.poisson)
        return plane_stress(whole) if self.plane == "stress" else whole

    @property
    def tensor(self) -> Array:
        """(3, 3, 3, 3) stiffness."""
        return tensor(self.stiffness)

    @property
    def across(self) -> Array:
        """(3,) stress zz of plane bodies by a unit of xx, yy and xy; nothing in plane stress."""
        if self.plane == "stress":
            return np.zeros(3)
        matrix, own = self.stiffness, [0, 1, 5]
        return np.asarray(np.linalg.solve(matrix[np.ix_(own, own)], matrix[2, own]))

    def initial_stress(self, strain: Array) -> Array:
        """(m, 3, 3) stress without which initial strains (m, 3, 3) would deform a body.

        In plane strain nothing moves along z, in plane stress nothing holds it there.
        """
        return np.einsum("ijkl,mkl->mij", self.tensor, strain)
