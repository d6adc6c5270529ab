# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress at the surface of a plane body, from the displacement of its surface and the tractions.

The stress of elements is poor at a surface with a traction that ends there. But of the stress at a
contact surface all is known from the contact itself, sigma_nn = -p and sigma_nt = q, except what
acts along the surface: Hooke's law gives it from the strain along the surface, less what is due
to initial strains e0,

    sigma_t = E/(1 - nu^2) (eps_t - e0_t - nu e0_z) - nu/(1 - nu) p    in plane strain,
    sigma_t = E (eps_t - e0_t) - nu p                                  in plane stress,

and of crystals `SurfaceLaw`. eps_t is best at the Gauss points of the facets, as many as the degree
of the displacements, where the error of the slope of a finite-element function is of one order
higher (Barlow 1976).

Next to an edge p falls with the square root of the distance, and so does -sigma_t: it has a cusp
there. Their sum is smooth throughout the slip zone, as sigma_t by the shear f p is, and grows with
the square root of the distance from the border of the stick zone (Hertz: f p0 (c/a) times
2 sqrt(x^2/c^2 - 1)). Fitted to it in the slip zone, it gives sigma_t at the edge itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.case import AnyBody, compliance
from fretfe.case.tables import Plane
from fretfe.history.solution import OPEN, SLIP, ContactHistory
from fretfe.mesh.elements import quadrature, shape_slopes, shape_values
from fretfe.surface.surface import Surface

# Elements next to the edge, and next to the border of the stick zone, that fits leave out:
# tractions and strains alternate there.
LEFT_OUT = 2.5
# Gauss points that a fit needs.
FEWEST_POINTS = 5


@dataclass(frozen=True)
class SurfaceStrain:
    """The strain along the surface of a body at its Gauss points.

    Attributes:
        arc: (g,) place of the points along the arc of the contact, increasing.
        places: (g, d) their coordinates.
        tangents: (g, d) unit tangents of the surface.
        slopes: (g, k, d) factors by which the displacements of k nodes make the strain.
        nodes: (g, k) numbers of these nodes among `Surface.displacement_points`.
    """

    arc: Array
    places: Array
    tangents: Array
    slopes: Array
    nodes: Indices

    @classmethod
    def of(cls, surface: Surface, degree: int, contact: ContactHistory) -> SurfaceStrain:
        """The points of a surface in the plane.

        Args:
            surface: of the body.
            degree: of its displacements.
            contact: whose arc is meant.
        """
        at = quadrature(surface.shape, degree)[0]
        stretch = np.einsum(
            "qk,fkd->fqd", shape_slopes(surface.shape, surface.degree, at)[:, 0], surface.nodes
        )
        slopes = shape_slopes(surface.shape, degree, at)[:, 0]
        along = stretch / np.sum(stretch**2, axis=2, keepdims=True)
        places = np.einsum(
            "qk,fkd->fqd", shape_values(surface.shape, surface.degree, at), surface.nodes
        )
        facets = surface.displacement_facets(degree)
        count = places.shape[0] * places.shape[1]
        flat = places.reshape(count, -1)
        arc = arc_of(contact, flat)
        order = np.argsort(arc)
        weights = np.einsum("qk,fqd->fqkd", slopes, along).reshape(count, -1, along.shape[2])
        nodes = np.repeat(facets, len(at), axis=0)
        tangents = stretch.reshape(count, -1)
        tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
        return cls(arc[order], flat[order], tangents[order], weights[order], nodes[order])

    def values(self, displacement: Array) -> Array:
        """(g,) strain by displacements (p, d) of the surface."""
        return np.asarray(np.einsum("gkd,gkd->g", self.slopes, displacement[self.nodes]))


def arc_of(contact: ContactHistory, places: Array) -> Array:
    """(m,) arc length of the contact at places (m, d) next to it, beyond its ends too."""
    nearest = cKDTree(contact.points).query(places)[1]
    tangents = contact.frames[nearest, 1]
    ahead = np.sum((places - contact.points[nearest]) * tangents, axis=1)
    return np.asarray(contact.arc[nearest] + ahead)


@dataclass(frozen=True)
class SurfaceLaw:
    """Hooke's law of a plane body as its surface sees it, of crystals too.

    In the plane, with stress and strain xx, yy, xy (strain 2 xy) as vectors,
    eps = compliance sigma + e0 - across e0_z, and sigma_zz = -across sigma - modulus e0_z.

    Attributes:
        compliance: (3, 3) [1/stress].
        across: (3,) S_3a/S_33 with the compliances S of the body; nothing in plane stress.
        modulus: 1/S_33 [stress], of no use in plane stress.
    """

    compliance: Array
    across: Array
    modulus: float

    @classmethod
    def of(cls, body: AnyBody, plane: Plane) -> SurfaceLaw:
        """That of a body of a case."""
        whole, own = compliance(body), [0, 1, 5]
        inner = whole[np.ix_(own, own)]
        if plane == "stress":
            return cls(inner, np.zeros(3), 0.0)
        across, modulus = whole[2, own] / whole[2, 2], float(1 / whole[2, 2])
        return cls(inner - np.outer(across, across) / modulus, across, modulus)

    def tangential_stress(self, strain: Array, traction: Array, frames: Array) -> Array:
        """(n,) stress along a surface from the strain along it and the tractions.

        Args:
            strain: (n,) without the initial one, `free_strain`.
            traction: (n, 2) p and q, as of `ContactHistory`.
            frames: (n, 2, 2) normal and tangent.
        """
        along = _stress_vector(frames[:, 1], frames[:, 1]) @ self.compliance
        free = strain - np.sum(along * _by_traction(traction, frames), axis=1)
        return np.asarray(free / np.sum(along * _stress_vector(frames[:, 1], frames[:, 1]), axis=1))

    def free_strain(self, strain: Array, tangents: Array) -> Array:
        """(g,) strain along a surface by initial strains (g, 3, 3) that nothing hinders."""
        inner = strain[:, [0, 1, 0], [0, 1, 1]] * [1, 1, 2] - self.across * strain[:, 2, 2, None]
        return np.asarray(np.sum(_stress_vector(tangents, tangents) * inner, axis=1))

    def stress(self, tangential: Array, traction: Array, frames: Array, across: Array) -> Array:
        """(N, 4) stress xx, yy, zz, xy at a surface; the same in both bodies but for `tangential`.

        Args:
            tangential: (N,) stress along the surface.
            traction: (N, 2) p and q, as of `ContactHistory`.
            frames: (N, 2, 2) normal and tangent.
            across: (N,) initial strain along z.
        """
        own = tangential[:, None] * _stress_vector(frames[:, 1], frames[:, 1])
        xx, yy, xy = (own + _by_traction(traction, frames)).T
        along_z = -(self.across @ [xx, yy, xy]) - self.modulus * across
        return np.stack([xx, yy, along_z, xy], axis=1)


def _stress_vector(one: Array, other: Array) -> Array:
    """(n, 3) xx, yy, xy of the symmetric part of the products of vectors (n, 2)."""
    return np.stack(
        [
            one[:, 0] * other[:, 0],
            one[:, 1] * other[:, 1],
            (one[:, 0] * other[:, 1] + one[:, 1] * other[:, 0]) / 2,
        ],
        axis=1,
    )


def _by_traction(traction: Array, frames: Array) -> Array:
    """(n, 3) stress xx, yy, xy by tractions (n, 2) alone: nothing along the surface."""
    normal, tangent = frames[:, 0], frames[:, 1]
    pressed = -traction[:, :1] * _stress_vector(normal, normal)
    return pressed + 2 * traction[:, 1:] * _stress_vector(normal, tangent)


@dataclass(frozen=True)
class EdgeValue:
    """sigma_t of a body at an edge.

    Attributes:
        value: NaN where it is not known.
        spread: what other fits differ by.
        reason: why it is not known, or empty.
    """

    value: float
    spread: float
    reason: str = ""


def edge_stress(
    arc: Array, smooth: Array, position: float, inward: int, contact: ContactHistory, status: Array
) -> EdgeValue:
    """Stress along the surface at an edge of a contact, in one state.

    With s the distance from the edge inward and d the length of the zone that slips, the sum of
    sigma_t and p is fitted by 1, sqrt(d - s) and d - s. The spread is what the value differs by
    from a fit without the last one, and by half an element in d, which is what nodes tell of it.

    Args:
        arc: (g,) places of `smooth` along the arc.
        smooth: (g,) sigma_t + p.
        position: of the edge along the arc.
        inward: direction into the contact, 1 or -1.
        contact: that the edge belongs to.
        status: (N,) of its nodes in the step to the state.
    """
    if not np.isfinite(position):
        return EdgeValue(np.nan, np.nan, "the place of the edge is not known")
    order = slice(None, None, inward)
    ahead, state = (inward * (contact.arc - position))[order], status[order]
    inside = np.flatnonzero((ahead > 0) & (state != OPEN))
    if not len(inside) or state[inside[0]] != SLIP:
        return EdgeValue(np.nan, np.nan, "nothing slips next to the edge")
    first = int(inside[0])
    # Behind the last node of the contact there may be nothing at all.
    last = first + int(np.argmin(np.append(state[first:] == SLIP, False)))
    if last == len(state) or state[last] == OPEN:
        return EdgeValue(np.nan, np.nan, "the whole contact slips")
    size, length = ahead[last] - ahead[last - 1], (ahead[last] + ahead[last - 1]) / 2
    distance = inward * (arc - position)
    used = (distance > LEFT_OUT * size) & (distance < length - LEFT_OUT * size)
    if np.count_nonzero(used) < FEWEST_POINTS:
        return EdgeValue(
            np.nan, np.nan, f"the slip zone has {length / size:.0f} elements, too few for a fit"
        )
    value, *others = (
        _extrapolated(distance[used], smooth[used], length + shift * size, terms)
        for shift, terms in ((0, 3), (0, 2), (-0.5, 3), (0.5, 3))
    )
    by_terms, *by_border = (abs(other - value) for other in others)
    return EdgeValue(value, by_terms + max(by_border))


def _extrapolated(distance: Array, values: Array, length: float, terms: int) -> float:
    """Value at the distance 0 by powers of the root of the distance from the other end, `terms`."""
    fit = np.linalg.lstsq(np.vander(np.sqrt(length - distance), terms), values, rcond=None)[0]
    return float(np.polyval(fit, np.sqrt(length)))
