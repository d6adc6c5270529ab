# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress at the surface of a plane body, from the displacement of its surface and the tractions.

The stress of elements is poor at a surface with a traction that ends there. But of the stress at a
contact surface all is known from the contact itself, sigma_nn = -p, sigma_nt = q and sigma_nz =
q_z, except what acts along the surface: Hooke's law gives it from the strain along the surface,
less what is due to initial strains e0. Of isotropic bodies

    sigma_t = E/(1 - nu^2) (eps_t - e0_t - nu e0_z) - nu/(1 - nu) p    in plane strain,
    sigma_t = E (eps_t - e0_t) - nu p                                  in plane stress,
    sigma_tz = G du_z/dt                                               of displacements along z,

and of crystals `SurfaceLaw`. The slopes of displacements are best at the Gauss points of the
facets, as many as the degree of the displacements, where the error of the slope of a finite-element
function is of one order higher (Barlow 1976).

Next to an edge p falls with the square root of the distance, and so does -sigma_t: it has a cusp
there. Their sum is smooth throughout the slip zone, as sigma_t by the shear f p is, and grows with
the square root of the distance from the border of the stick zone (Hertz: f p0 (c/a) times
2 sqrt(x^2/c^2 - 1)). Fitted to it in the slip zone, it gives sigma_t at the edge itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import AnyBody
from fretfe.case.tables import Plane
from fretfe.evaluate.critical_planes import PAIRS as ORDER
from fretfe.history.solution import OPEN, SLIP
from fretfe.materials.crystals import PAIRS
from fretfe.materials.moduli import compliance
from fretfe.mesh.elements import quadrature, shape_slopes, shape_values
from fretfe.surface.contact_surface import ContactSurface
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
        tangents: (g, d) unit tangents of the surface, along the arc.
        slopes: (g, k) factors by which values at k nodes make the derivative along the tangent.
        nodes: (g, k) numbers of these nodes among `Surface.displacement_points`.
    """

    arc: Array
    places: Array
    tangents: Array
    slopes: Array
    nodes: Indices

    @classmethod
    def of(cls, surface: Surface, degree: int, contact: ContactSurface) -> SurfaceStrain:
        """The points of a surface in the plane.

        Args:
            surface: of the body.
            degree: of its displacements.
            contact: with the arc that is meant.
        """
        at = quadrature(surface.shape, degree)[0]
        stretch = np.einsum(
            "qk,fkd->fqd", shape_slopes(surface.shape, surface.degree, at)[:, 0], surface.nodes
        )
        places = np.einsum(
            "qk,fkd->fqd", shape_values(surface.shape, surface.degree, at), surface.nodes
        )
        dimension = places.shape[2]
        flat, tangents = places.reshape(-1, dimension), stretch.reshape(-1, dimension)
        arc, along = _on_arc(contact, flat)
        sign = np.where(np.sum(tangents * along, axis=1) < 0, -1, 1)
        lengths = sign * np.linalg.norm(tangents, axis=1)
        slopes = shape_slopes(surface.shape, degree, at)[:, 0]
        derivatives = np.tile(slopes, (len(places), 1)) / lengths[:, None]
        nodes = np.repeat(surface.displacement_facets(degree), len(at), axis=0)
        order = np.argsort(arc)
        tangents = tangents / lengths[:, None]
        return cls(arc[order], flat[order], tangents[order], derivatives[order], nodes[order])

    def values(self, displacement: Array) -> Array:
        """(g, 3) strains tt, zz, 2 tz by displacements (p, c) of the surface."""
        slopes = np.einsum("gk,gkc->gc", self.slopes, displacement[self.nodes])
        found = np.zeros((len(slopes), 3))
        found[:, 0] = np.sum(slopes[:, :2] * self.tangents, axis=1)
        found[:, 2] = slopes[:, 2:].sum(axis=1)
        return found


def _on_arc(contact: ContactSurface, places: Array) -> tuple[Array, Array]:
    """Arc length (m,) of the contact at places (m, d) next to it, beyond its ends too.

    And the tangents (m, d) there.
    """
    nearest = contact.tree.query(places)[1]
    tangents = contact.frames[nearest, 1, : places.shape[1]]
    ahead = np.sum((places - contact.points[nearest]) * tangents, axis=1)
    return contact.arc[nearest] + ahead, tangents


@dataclass(frozen=True)
class SurfaceLaw:
    """Hooke's law of a plane body as its surface sees it, of crystals too.

    Of the stress, the part along the surface is unknown: in plane strain sigma_t, sigma_z and
    sigma_tz, in plane stress the first one only. As many strains along the surface are known.

    Attributes:
        compliance: (6, 6) as of `crystals.PAIRS`, for engineering strains.
        unknown: how many of these there are.
    """

    compliance: Array
    unknown: int

    @classmethod
    def of(cls, body: AnyBody, plane: Plane) -> SurfaceLaw:
        """That of a body of a case."""
        return cls(compliance(body), 1 if plane == "stress" else 3)

    def stress(self, strain: Array, traction: Array, frames: Array) -> Array:
        """(n, 6) stress at a surface, components as of `critical_planes.PAIRS`.

        Args:
            strain: (n, 3) strains tt, zz, 2 tz, less the initial ones.
            traction: (n, c) p, q and, of displacements with three components, q_z, as of
                `ContactHistory`.
            frames: (n, c, c) normal, tangent and z.
        """
        along = _along(frames[:, 1])[..., : self.unknown]
        found = _by_traction(traction, frames)
        strained = self.compliance @ along
        missing = strain[:, : self.unknown] - np.einsum("nai,na->ni", strained, found)
        matrix = along.swapaxes(1, 2) @ strained
        found += np.einsum("nai,ni->na", along, np.linalg.solve(matrix, missing[..., None])[..., 0])
        return found[:, [PAIRS.index(pair) for pair in ORDER]]


def along_surface(strain: Array, tangents: Array) -> Array:
    """(g, 3) components tt, zz, 2 tz of strains (g, 3, 3); tangents (g, 2)."""
    parts = np.stack([strain[:, i, j] * (1 + (i != j)) for i, j in PAIRS], axis=1)
    return np.asarray(np.einsum("gai,ga->gi", _along(tangents), parts))


def _along(tangents: Array) -> Array:
    """(n, 6, 3) stresses of units along the surface: tt, zz, tz; tangents (n, 2) or (n, 3)."""
    z = np.array([[0.0, 0.0, 1.0]])
    t = np.pad(tangents, ((0, 0), (0, 3 - tangents.shape[1])))
    return np.stack(np.broadcast_arrays(_pair(t, t) / 2, _pair(z, z) / 2, _pair(t, z)), axis=2)


def _pair(one: Array, other: Array) -> Array:
    """(n, 6) components of a b + b a of vectors (n, 3)."""
    return np.stack([one[:, i] * other[:, j] + one[:, j] * other[:, i] for i, j in PAIRS], axis=1)


def _by_traction(traction: Array, frames: Array) -> Array:
    """(n, 6) stress by tractions (n, c) alone: nothing along the surface."""
    signs = np.array([-0.5, 1.0, 1.0])[: traction.shape[1]]
    axes = np.pad(frames, ((0, 0), (0, 0), (0, 3 - frames.shape[2])))
    parts = np.stack([_pair(axes[:, 0], axis) for axis in axes.swapaxes(0, 1)], axis=2)
    return np.asarray(np.einsum("nac,nc->na", parts, signs * traction))


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
    arc: Array, smooth: Array, position: float, inward: int, nodes: Array, status: Array
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
        nodes: (N,) places of those of the contact along the arc.
        status: (N,) of its nodes in the step to the state.
    """
    if not np.isfinite(position):
        return EdgeValue(np.nan, np.nan, "the place of the edge is not known")
    order = slice(None, None, inward)
    ahead, state = (inward * (nodes - position))[order], status[order]
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


def near_edge(arc: Array, smooth: Array, position: float, inward: int, nodes: Array) -> float:
    """Mean of sigma_t + p over an element to both sides of an edge; NaN without an edge.

    What slips next to an edge since another state changes sigma_t most at the edge itself, also
    where the slip zone is too short for `edge_stress`. Where this mean has fallen, so has sigma_t.

    Args:
        arc: (g,) places of `smooth` along the arc.
        smooth: (g,) sigma_t + p.
        position: of the edge along the arc.
        inward: direction into the contact, 1 or -1.
        nodes: (N,) places of those of the contact along the arc.
    """
    if not np.isfinite(position):
        return np.nan
    node = int(np.clip(np.searchsorted(nodes, position), 1, len(nodes) - 1))
    size = nodes[node] - nodes[node - 1]
    beside = position + inward * size * np.array([-1.0, -0.5, 0.5, 1.0])
    return float(np.interp(beside, arc, smooth).mean())


def _extrapolated(distance: Array, values: Array, length: float, terms: int) -> float:
    """Value at the distance 0 by powers of the root of the distance from the other end, `terms`."""
    fit = np.linalg.lstsq(np.vander(np.sqrt(length - distance), terms), values, rcond=None)[0]
    return float(np.polyval(fit, np.sqrt(length)))
