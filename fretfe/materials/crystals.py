# SPDX-License-Identifier: LGPL-3.0-or-later
"""Anisotropic elasticity: constants, rotations, half-planes and crack tips (NumPy only).

Stiffnesses are matrices (6, 6) in Voigt's order 11, 22, 33, 23, 13, 12, for engineering strains
(twice the tensor's shear), or tensors (3, 3, 3, 3).

A half-plane has the outward normal n or its opposite, and fields that do not vary along the
direction across the plane of n and a tangent m. With

    Q_ik = C_ijkl m_j m_l,    R_ik = C_ijkl m_j n_l,    T_ik = C_ijkl n_j n_l

for m and n turned by an angle about their common normal, and N1 = -T^-1 R^t, N2 = T^-1,
N3 = R T^-1 R^t - Q, the means of N1, N2 and N3 over all angles are S, H and -L (Barnett and
Lothe, Phys. Norv. 7, 1973; T. C. T. Ting, Anisotropic Elasticity, Oxford 1996, section 7.6). The
tractions t on the surface of the body below it displace the surface by

    du/dx = L^-1 (1/pi) PV int t(xi)/(x - xi) dxi  -  S L^-1 t

which L^-1 takes along m from the traction's own component by the same law as an isotropic body,
diag(2/E', 2/E', 1/G), and S L^-1 is its skew part: what pressure moves along the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Complexes

PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
# Means of periodic functions by the trapezoidal rule: round-off for ratios of stiffnesses up to
# about a hundred.
ANGLES = 720
# Directions of a plane over which a half-space is averaged.
DIRECTIONS = 24
# Constants that differ from isotropic ones by less than this part of them are isotropic.
ISOTROPIC = 1e-11
# Distance of eigenvalues p, and part of the stiffness that moves them apart by about its root,
# below which eigenvectors lose more digits than the change costs.
DISTINCT = 1e-4
SEPARATION = 1e-11


def cubic(c11: float, c12: float, c44: float) -> Array:
    """(6, 6) stiffness of a cubic crystal in its own axes."""
    return orthorhombic((c11, c11, c11), (c12, c12, c12), (c44, c44, c44))


def orthorhombic(normal: Sequence[float], mixed: Sequence[float], shear: Sequence[float]) -> Array:
    """(6, 6) matrix of 11, 22, 33, then 23, 13, 12, then 44, 55, 66."""
    matrix = np.diag([*normal, *shear]).astype(float)
    for (i, j), value in zip(((1, 2), (0, 2), (0, 1)), mixed, strict=True):
        matrix[i, j] = matrix[j, i] = value
    return matrix


def orthotropic_compliance(
    young: Sequence[float], poisson: Sequence[float], shear: Sequence[float]
) -> Array:
    """(6, 6) compliance from E1, E2, E3, then nu12, nu13, nu23, then G12, G13, G23.

    nu_ij = -eps_j/eps_i in tension along i, so that nu_ij/E_i = nu_ji/E_j.
    """
    (e1, e2, e3), (nu12, nu13, nu23), (g12, g13, g23) = young, poisson, shear
    return orthorhombic(
        (1 / e1, 1 / e2, 1 / e3), (-nu23 / e2, -nu13 / e1, -nu12 / e1), (1 / g23, 1 / g13, 1 / g12)
    )


def triclinic(constants: Sequence[float]) -> Array:
    """(6, 6) stiffness from its upper triangle, row by row: C11 ... C16, C22 ... C26, ... C66."""
    upper = np.zeros((6, 6))
    upper[np.triu_indices(6)] = constants
    return upper + np.triu(upper, 1).T


def isotropic(young: float, poisson: float) -> Array:
    """(6, 6) stiffness of an isotropic body."""
    shear = young / (2 * (1 + poisson))
    lame = 2 * shear * poisson / (1 - 2 * poisson)
    return cubic(lame + 2 * shear, lame, shear)


def tensor(matrix: Array) -> Array:
    """(3, 3, 3, 3) stiffness from a matrix (6, 6)."""
    found: Array = matrix[VOIGT[:, :, None, None], VOIGT]
    return found


def turned(matrix: Array, axes: Array) -> Array:
    """(6, 6) stiffness with respect to axes whose unit vectors are the rows of (3, 3)."""
    full = np.einsum("ai,bj,ck,dl,ijkl->abcd", *(axes,) * 4, tensor(matrix), optimize=True)
    return np.array([[full[(*first, *second)] for second in PAIRS] for first in PAIRS])


def bunge_rotation(angles: Sequence[float]) -> Array:
    """(3, 3) crystal axes, as rows, for Bunge's Euler angles phi1, Phi, phi2 in degrees.

    The axes of the model are turned by phi1 about z, then by Phi about the new x, then by phi2
    about the new z: H.-J. Bunge, Texture Analysis in Materials Science, 1982, section 2.1.2.
    """
    first, second, third = np.radians(angles)

    def about(axis: int, angle: float) -> Array:
        i, j = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(3)
        matrix[i, i] = matrix[j, j] = np.cos(angle)
        matrix[i, j], matrix[j, i] = np.sin(angle), -np.sin(angle)
        return matrix

    return about(2, third) @ about(0, second) @ about(2, first)


def smallest_eigenvalue(matrix: Array) -> float:
    """Smallest eigenvalue of the energy as a form of the strain tensor; <= 0: no material.

    It does not depend on the axes: shear counts with the root of two in stress and strain.
    """
    scale = np.sqrt([1, 1, 1, 2, 2, 2])
    return float(np.linalg.eigvalsh(matrix * np.outer(scale, scale))[0])


def young_and_poisson(matrix: Array) -> tuple[float, float] | None:
    """E and nu of an isotropic stiffness (6, 6); None if it is not isotropic."""
    shear = float(matrix[3:, 3:].diagonal().mean())
    lame = float(matrix[[0, 0, 1], [1, 2, 2]].mean())
    poisson = lame / (2 * (lame + shear))
    young = 2 * shear * (1 + poisson)
    wrong = np.abs(matrix - isotropic(young, poisson)).max() if lame + shear > 0 else np.inf
    return (young, poisson) if wrong < ISOTROPIC * np.abs(matrix).max() else None


def plane_stress(matrix: Array) -> Array:
    """(6, 6) stiffness for strains in the plane if nothing holds it across, with a row of zeros.

    Only for a material of which z is normal to a plane of symmetry.
    """
    return matrix - np.outer(matrix[:, 2], matrix[2]) / matrix[2, 2]


def couples_across(matrix: Array) -> float:
    """Largest stiffness that z being normal to a plane of symmetry forbids, over the largest."""
    across = matrix[np.ix_([0, 1, 2, 5], [3, 4])]
    return float(np.abs(across).max() / np.abs(matrix).max())


def slip_systems(axes: Array) -> tuple[Array, Array]:
    """Schmid tensors (12, 3, 3) of {111}<110> and (6, 3, 3) of {001}<110> in a cubic crystal.

    Their products with a stress are the shear stresses on these planes along these directions.

    Args:
        axes: (3, 3) rows: axes of the crystal in those of the model.
    """
    signs = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]])
    along = np.array([[1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]])
    found = []
    for planes in (signs, np.eye(3)):
        pairs = [(n, b) for n in planes for b in along if n @ b == 0]
        normals, directions = (
            np.array(each) / np.linalg.norm(each, axis=1, keepdims=True) @ axes
            for each in zip(*pairs, strict=True)
        )
        products = np.einsum("si,sj->sij", directions, normals)
        found.append((products + products.swapaxes(1, 2)) / 2)
    return found[0], found[1]


def _parts(stiffness: Array, m: Array, n: Array) -> tuple[Array, Array, Array]:
    """(..., 3, 3) Q, R and T for unit vectors m and n (..., 3)."""
    first = np.einsum("ijkl,...j->...ikl", stiffness, m)
    second = np.einsum("ijkl,...j->...ikl", stiffness, n)
    return (
        np.einsum("...ikl,...l->...ik", first, m),
        np.einsum("...ikl,...l->...ik", first, n),
        np.einsum("...ikl,...l->...ik", second, n),
    )


@dataclass(frozen=True)
class HalfPlane:
    """Surface of a half-plane, in the axes of its frame: normal, tangent, across the plane.

    Attributes:
        compliance: (3, 3) L^-1 [1/stress].
        skew: (3, 3) S L^-1 [1/stress], skew-symmetric.
    """

    compliance: Array
    skew: Array

    @classmethod
    def of(cls, matrix: Array, frame: Array) -> HalfPlane:
        """The half-plane of a stiffness (6, 6) with a frame (3, 3) of rows normal, tangent, across.

        The same for the body above and the one below; S L^-1 is that of the normal as given.
        """
        own = tensor(turned(matrix, frame))
        angle = np.arange(ANGLES) * np.pi / ANGLES
        cosine, sine, nothing = np.cos(angle), np.sin(angle), np.zeros(ANGLES)
        m, n = (
            np.stack(parts, axis=1) for parts in ((sine, cosine, nothing), (cosine, -sine, nothing))
        )
        q, r, t = _parts(own, m, n)
        inverse = np.linalg.inv(t)
        transposed = r.swapaxes(1, 2)
        s = -(inverse @ transposed).mean(axis=0)
        compliance = np.linalg.inv(-(r @ inverse @ transposed - q).mean(axis=0))
        skew = s @ compliance
        return cls((compliance + compliance.T) / 2, (skew - skew.T) / 2)

    @classmethod
    def isotropic(cls, young: float, poisson: float, plane: str) -> HalfPlane:
        """That of an isotropic body in plane "strain" or "stress", with any frame."""
        shear = young / (2 * (1 + poisson))
        kolosov = 3 - 4 * poisson if plane == "strain" else (3 - poisson) / (1 + poisson)
        compliance = np.diag([kolosov + 1, kolosov + 1, 4.0]) / (4 * shear)
        skew = np.zeros((3, 3))
        skew[0, 1] = (kolosov - 1) / (4 * shear)
        return cls(compliance, skew - skew.T)


def coupling(first: HalfPlane, second: HalfPlane) -> float:
    """Size of the generalised Dundurs constant beta of two half-planes with the same frame.

    beta² = -tr((D^-1 W)²)/2 with D the sum of both compliances and W the difference of the skew
    parts: full stick oscillates next to an edge with (1/2 pi) ln((1 + beta)/(1 - beta)) (Ting 1996,
    section 11.6). For isotropic bodies it is Dundurs' one.
    """
    both = np.linalg.solve(first.compliance + second.compliance, first.skew - second.skew)
    return float(np.sqrt(max(0.0, -np.trace(both @ both) / 2)))


def around(normal: Array, directions: int = DIRECTIONS) -> Array:
    """(n, 3, 3) frames of half-planes with a unit normal (3,) and tangents all around it."""
    start = np.eye(3)[np.argmin(np.abs(normal))]
    first = start - normal * (normal @ start)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    angle = np.arange(directions)[:, None] * np.pi / directions
    tangents = np.cos(angle) * first + np.sin(angle) * second
    normals = np.broadcast_to(normal, tangents.shape)
    return np.stack([normals, tangents, np.cross(normals, tangents)], axis=1)


@dataclass(frozen=True)
class CrackTip:
    """Field next to a crack tip: u = sqrt(2/pi) Re sum_a c_a sqrt(x + p_a y), c = A_a (B^-1 k)_a.

    x is ahead of the tip, y along the normal, k the stress intensity factors: sqrt(2 pi x) times
    the traction ahead (Ting 1996, section 11.2; Stroh 1958).

    Attributes:
        roots: (d,) p, with positive imaginary parts.
        shapes: (d, d, d) c for each unit factor, each component of the displacement, each root; in
            the order normal, ahead and, where d = 3, along the front.
    """

    roots: Complexes
    shapes: Complexes

    @classmethod
    def of(cls, matrix: Array, size: int) -> CrackTip:
        """The field in a body of stiffness (6, 6) in the axes normal, ahead, along.

        Where two roots are equal, as in isotropic bodies, they are moved apart a little, which
        changes the field by about 1e-10 of it.

        Args:
            matrix: stiffness.
            size: number of displacement components: 2 for those in the plane.
        """
        roots, vectors = _stroh(matrix, size)
        apart = np.abs(roots[:, None] - roots) + np.eye(size)
        if apart.min() < DISTINCT:
            largest = np.abs(matrix).max()
            away = cubic(1.0, -0.5, -0.3) + np.diag([0.0, 0.3, 0.0, 0.0, 0.2, 0.0])
            roots, vectors = _stroh(matrix + SEPARATION * largest * away, size)
        a, b = vectors[:size], vectors[size:]
        shapes = np.einsum("ia,am->mia", a, np.linalg.inv(b))
        return cls(roots, shapes)


def _stroh(matrix: Array, size: int) -> tuple[Complexes, Complexes]:
    """(d,) eigenvalues with positive imaginary parts, and (2 d, d) eigenvectors a and b."""
    parts = _parts(tensor(matrix), np.eye(3)[1], np.eye(3)[0])
    q, r, t = (each[:size, :size] for each in parts)
    # Of one order, for the sake of the eigenvectors.
    unit = np.abs(t).max()
    inverse = np.linalg.inv(t / unit)
    n1, n3 = -inverse @ r.T / unit, (r @ inverse @ r.T / unit - q) / unit
    values, vectors = np.linalg.eig(np.block([[n1, inverse], [n3, n1.T]]))
    upper = np.argsort(-values.imag)[:size]
    found = vectors[:, upper]
    found[size:] *= unit
    return values[upper], found
