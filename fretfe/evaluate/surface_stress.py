# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress at the surface of a plane body, from the displacement of its surface and the tractions.

The stress of elements is poor at a surface with a traction that ends there. But of the stress at a
contact surface all is known from the contact itself, sigma_nn = -p and sigma_nt = q, except what
acts along the surface: Hooke's law gives it from the strain along the surface, less what is due
to initial strains e0,

    sigma_t = E/(1 - nu^2) (eps_t - e0_t - nu e0_z) - nu/(1 - nu) p    in plane strain,
    sigma_t = E (eps_t - e0_t) - nu p                                  in plane stress,

and eps_t is best at the Gauss points of the facets, as many as the degree of the displacements,
where the error of the slope of a finite-element function is of one order higher (Barlow 1976).

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
from fretfe.case import Body, plane_modulus
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


def tangential_stress(strain: Array, pressure: Array, body: Body, plane: Plane) -> Array:
    """Stress along the surface from the strain along it and the pressure; all of one shape.

    The strain is without the initial one, `free_strain`.
    """
    contraction = body.poisson / (1 - body.poisson) if plane == "strain" else body.poisson
    return plane_modulus(body, plane) * strain - contraction * pressure


def free_strain(strain: Array, tangents: Array, body: Body, plane: Plane) -> Array:
    """(g,) strain along a surface that initial strains (g, 3, 3) cause where nothing hinders it."""
    along = np.einsum("gi,gij,gj->g", tangents, strain[:, :2, :2], tangents)
    return np.asarray(along + body.poisson * strain[:, 2, 2] if plane == "strain" else along)


def surface_tensor(
    tangential: Array, traction: Array, frames: Array, body: Body, plane: Plane, across: Array
) -> Array:
    """(N, 4) stress xx, yy, zz, xy at a surface; the same in both bodies but for `tangential`.

    Args:
        tangential: (N,) stress along the surface.
        traction: (N, 2) p and q, as of `ContactHistory`.
        frames: (N, 2, 2) normal and tangent.
        body: that the surface belongs to.
        plane: of the model.
        across: (N,) initial strain along z.
    """
    p, q = traction.T
    normal, tangent = frames[:, 0], frames[:, 1]
    both = np.einsum("ni,nj->nij", normal, tangent)
    tensor = (
        -p[:, None, None] * np.einsum("ni,nj->nij", normal, normal)
        + q[:, None, None] * (both + both.swapaxes(1, 2))
        + tangential[:, None, None] * np.einsum("ni,nj->nij", tangent, tangent)
    )
    held = body.poisson * (tangential - p) - body.young * across
    along_z = held if plane == "strain" else 0.0 * p
    return np.stack([tensor[:, 0, 0], tensor[:, 1, 1], along_z, tensor[:, 0, 1]], axis=1)


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
