# SPDX-License-Identifier: LGPL-3.0-or-later
"""Factors around a closed front against the forces that the contact carries, as half-spaces do.

If the front is an ellipse, and it is the only one, the tractions that forces make between stuck
half-spaces are known in closed form: with F = (x - c).A(x - c) = 1 on the front,

    traction = (force / (2 pi a b)) / sqrt(1 - F),    pressure of a moment = v.(x - c) / sqrt(1 - F)

and F = 1 - 2 g s at a distance s inside. Between unlike bodies that is so of K_I and K_T at a
length of about the width of the contact, but for terms of second order in beta: K_T by Q and K_I by
P stay if both bodies change places. Real bodies are no half-spaces: the ratios of the factors found
to these differ from 1 by some per cent, and belong in no error bar.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import HalfSpaceRatios
from fretfe.evaluate.factors import rotated
from fretfe.evaluate.space.fronts import FrontTrack
from fretfe.evaluate.space.sectors import Frames
from fretfe.history.solution import ContactHistory, Factor, Solution

# Deviation of an ellipse, and of its half axes in a circle, over the radius.
ELLIPSE = 0.03
CIRCLE = 0.03
# A force that makes less than this part of the largest factor says nothing of it.
LEAST = 0.02
OPEN_FRONT = "the front is open"
MORE_FRONTS = "the contact has more fronts than this one"
NO_ELLIPSE = "the front is no ellipse"
NO_FACTORS = "factors are not known all around the front"


@dataclass(frozen=True)
class _Ellipse:
    """An ellipse F = (x - c).A(x - c) = 1 in the plane of a front, and n stations on it.

    Attributes:
        basis: (2, 3) unit vectors of the plane.
        centre: (3,)
        places: (n, 2) of the stations from the centre.
        form: (2, 2) A.
    """

    basis: Array
    centre: Array
    places: Array
    form: Array

    @property
    def product(self) -> float:
        """Half axes multiplied."""
        return float(1 / np.sqrt(np.linalg.det(self.form)))

    @property
    def half_axes(self) -> Array:
        """(2,) the longer one first."""
        return np.asarray(1 / np.sqrt(np.linalg.eigvalsh(self.form)))

    @property
    def singular(self) -> Array:
        """(n,) 1/sqrt(2 g): what 1/sqrt(1 - F) has in common with 1/sqrt(s)."""
        return np.asarray(1 / np.sqrt(2 * np.linalg.norm(self.places @ self.form, axis=1)))


def half_space_ratios(
    solution: Solution, contact: ContactHistory, track: FrontTrack, *, alone: bool
) -> HalfSpaceRatios:
    """Ratios to half-spaces of the factors around the first front of a contact.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        track: the front.
        alone: whether the contact has no other one.
    """
    frames, integrals = track.front.frames, contact.integrals
    if not frames.closed:
        return _none(OPEN_FRONT)
    if not alone:
        return _none(MORE_FRONTS)
    if integrals is None or not np.isfinite(integrals.factors[-1]).all():
        return _none(NO_FACTORS)
    ellipse = _ellipse(frames, integrals.positions[-1])
    if ellipse is None:
        return _none(NO_ELLIPSE)
    widths = np.full(len(frames.arc), 2 * math.sqrt(ellipse.product))
    units = rotated(integrals.factors[-1].mean(axis=0), contact.surface.dundurs, widths)
    fields = contact.full_stick.fields[int(integrals.areas[-1])]
    # Drivers count by the loads that they carry.
    loads = np.abs(solution.driver_values).max(axis=0)
    found, forces = units * loads, _resultants(contact, ellipse, fields * loads)
    exact = _exact(ellipse, frames, forces)
    return HalfSpaceRatios(
        half_axes=ellipse.half_axes,
        shear=_ratio(found[:, Factor.K_T :], exact.shear),
        twist=_ratio(found[:, Factor.K_S], exact.twist),
        normal=_ratio(found[:, Factor.K_I], exact.normal),
        pressure=_pressure(contact, track),
        reason="",
    )


def _none(reason: str) -> HalfSpaceRatios:
    return HalfSpaceRatios(np.full(2, np.nan), np.nan, np.nan, np.nan, np.nan, reason)


def _ellipse(frames: Frames, inward: Array) -> _Ellipse | None:
    """The ellipse through stations moved inward (n,); None if it is none."""
    points = frames.points + inward[:, None] * frames.inward
    normal = frames.across.mean(axis=0)
    normal /= np.linalg.norm(normal)
    first = frames.inward[0] - (frames.inward[0] @ normal) * normal
    first /= np.linalg.norm(first)
    basis, middle = np.stack([first, np.cross(normal, first)]), points.mean(axis=0)
    x, y = basis @ (points - middle).T
    conic = np.linalg.lstsq(np.stack([x**2, x * y, y**2, x, y], axis=1), np.ones(len(x)))[0]
    form = np.array([[conic[0], conic[1] / 2], [conic[1] / 2, conic[2]]])
    if not np.linalg.eigvalsh(form)[0] > 0:
        return None
    centre = -np.linalg.solve(form, conic[3:]) / 2
    form = form / (1 + centre @ form @ centre)
    places = np.stack([x, y], axis=1) - centre
    radii = np.sqrt(np.einsum("ni,ij,nj->n", places, form, places))
    if np.abs(radii - 1).max() > ELLIPSE:
        return None
    return _Ellipse(basis, middle + centre @ basis, places, form)


@dataclass(frozen=True)
class _Forces:
    """Forces on body 2 of J full-stick increments.

    Attributes:
        normal: (J,) P.
        shear: (3, J) Q.
        twist: (J,) moment about the normal through the centre.
    """

    normal: Array
    shear: Array
    twist: Array


def _resultants(contact: ContactHistory, ellipse: _Ellipse, fields: Array) -> _Forces:
    """Forces of tractions (N, 3, J)."""
    shear = np.einsum("ntj,ntd->ndj", fields[:, 1:], contact.surface.frames[:, 1:])
    shear = shear * contact.surface.weights[:, None, None]
    axis = np.cross(*ellipse.basis)
    arms = np.cross(axis, contact.surface.points - ellipse.centre)
    return _Forces(
        contact.surface.weights @ fields[:, 0],
        shear.sum(axis=0),
        np.einsum("nd,ndj->j", arms, shear),
    )


@dataclass(frozen=True)
class _Exact:
    """Factors of half-spaces at n stations, (n, 2, J), (n, J) and (n, J), as of their ratios."""

    shear: Array
    twist: Array
    normal: Array


def _exact(ellipse: _Ellipse, frames: Frames, forces: _Forces) -> _Exact:
    singular = ellipse.singular[:, None]
    share = singular / (2 * np.pi * ellipse.product)
    axes = np.stack([frames.inward, frames.along], axis=1)
    longer, shorter = ellipse.half_axes
    circle = longer - shorter < CIRCLE * longer
    twist = -3 / (4 * np.pi * ellipse.product**1.5) * singular
    return _Exact(
        shear=share[..., None] * np.einsum("nad,dj->naj", axes, forces.shear),
        twist=(twist if circle else np.zeros_like(twist)) * forces.twist,
        normal=share * forces.normal,
    )


def _ratio(found: Array, exact: Array) -> float:
    """Found over exact by least squares; NaN if the exact ones are nothing beside the found."""
    if not np.abs(exact).max() > LEAST * np.abs(found).max():
        return np.nan
    return float(np.sum(found * exact) / np.sum(exact**2))


def _pressure(contact: ContactHistory, track: FrontTrack) -> float:
    """Mean of K_N over that of the change of P as the front moves between two loads."""
    neighbours, frames = contact.nearby_loads, track.front.frames
    if neighbours is None:
        return np.nan
    place, k_n = track.fit.place[neighbours.state], track.fit.k_n[neighbours.state]
    if not np.isfinite([place, k_n]).all():
        return np.nan
    places = track.front.fits.fit(neighbours.pressure).place
    ellipse, outward = _ellipse(frames, place), places[0] - places[1]
    if ellipse is None or not (outward > 0).all():
        return np.nan
    change = float(np.diff(neighbours.pressure @ contact.surface.weights)[0])
    k_i = change / (2 * np.pi * ellipse.product) * ellipse.singular
    return float(k_n.sum() / (2 * k_i / outward).sum())
