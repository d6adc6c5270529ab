# SPDX-License-Identifier: LGPL-3.0-or-later
"""Moduli of the bodies of a case, isotropic ones and crystals, and of their contacts."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.case import AnyBody, Crystal, Plane, isotropic
from fretfe.materials.crystals import HalfPlane, around, plane_stress


def stiffness(body: AnyBody, plane: Plane) -> Array:
    """(6, 6) stiffness in the axes of the model; in plane stress that of strains in the plane."""
    return plane_stress(body.stiffness) if plane == "stress" else body.stiffness


def compliance(body: AnyBody) -> Array:
    """(6, 6) in the axes of the model, in Voigt's order for engineering strains."""
    return np.linalg.inv(body.stiffness)


def half_plane(body: AnyBody, plane: Plane, frame: Array) -> HalfPlane:
    """The half-plane of a body with a frame (d, d): rows normal, tangent and, in space, across."""
    if (known := isotropic(body)) is not None:
        return HalfPlane.isotropic(known.young, known.poisson, plane)
    whole = np.eye(3)
    whole[: len(frame), : len(frame)] = frame
    return HalfPlane.of(stiffness(body, plane), whole)


def half_planes(body: AnyBody, plane: Plane, normal: Array) -> list[HalfPlane]:
    """Half-planes of a body with a normal (d,): in space all around it."""
    if len(normal) == 2:
        return [half_plane(body, plane, np.array([normal, [normal[1], -normal[0]]]))]
    return [half_plane(body, plane, frame) for frame in around(np.asarray(normal))]


def plane_modulus(body: AnyBody, plane: Plane, along: tuple[float, float] = (1.0, 0.0)) -> float:
    """Modulus of uniaxial stress in the plane: E/(1 - nu^2) in plane strain, E in plane stress.

    Args:
        body: the body.
        plane: state of the plane.
        along: direction (2,) of the stress, which matters to a crystal.
    """
    known = isotropic(body)
    if known is not None:
        return known.young / (1 - known.poisson**2) if plane == "strain" else known.young
    assert isinstance(body, Crystal)
    x, y = along
    tensile = np.array([x * x, y * y, 0.0, 0.0, 0.0, x * y])
    own = compliance(body)
    across = own[2] if plane == "strain" else np.zeros(6)
    stretch = own @ tensile - across * (across @ tensile) / own[2, 2]
    return float(1 / (stretch @ tensile))


def normal_modulus(body: AnyBody, plane: Plane, normal: Array | None = None) -> float:
    """Modulus by which pressure on a half-plane, or half-space, displaces its surface.

    E' of an isotropic body. Of a crystal 2/A_n with the normal component A_n of the compliance; in
    space the mean of A_n over all directions, which is that of the Green's function.

    Args:
        body: the body.
        plane: state of the plane; without meaning in space.
        normal: (d,) of its surface; a crystal needs it.
    """
    if (known := isotropic(body)) is not None:
        return plane_modulus(known, plane)
    assert normal is not None
    surfaces = half_planes(body, plane, normal)
    return 2 * len(surfaces) / float(sum(each.compliance[0, 0] for each in surfaces))


def contact_modulus(
    body1: AnyBody, body2: AnyBody, plane: Plane, normal: Array | None = None
) -> float:
    """Contact modulus E*: 1/E* = sum of 1/normal_modulus of the two bodies (Hertz).

    For two isotropic bodies of E and nu in plane strain E* = E/(2(1 - nu^2)). In space the contact
    of crystals is not quite that of isotropic bodies with this modulus.
    """
    return 1 / sum(1 / normal_modulus(body, plane, normal) for body in (body1, body2))
