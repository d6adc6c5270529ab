# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ends of contacts in the model, behind which the bodies that it stands for go on.

At a plane of symmetry the mirror image continues both bodies, at the side of a sector the next
sector does: a front that ends there has no free end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.bodies.definition import BodyDefinition, ModelDefinition, Pair, couple_contacts
from fretfe.bodies.loads.strain import heatings
from fretfe.bodies.point_values import FLAT
from fretfe.case import Case
from fretfe.errors import CaseError
from fretfe.loads.friction import read_coefficients
from fretfe.loads.over_surface import OverSurface, read_gap, read_layer
from fretfe.materials.crystals import turned
from fretfe.materials.moduli import contact_modulus
from fretfe.mesh.mesh import BodyMesh, Mesh, place_text
from fretfe.reason import Kind
from fretfe.report.texts import rounded
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.friction import require_covered
from fretfe.surface.gap import LARGEST_MISS, gap_at_nodes, gap_missed
from fretfe.surface.mortar import Coupling
from fretfe.surface.placed import layer_at_nodes
from fretfe.surface.surface import Surface, boundary_surface

# Cosine of the angle between the contact and a plane of symmetry from which the contact is smooth
# across it: surfaces of elements are not quite normal to it.
SQUARE = 0.1
# How far the boundary of a body may be from the node of a contact, over an element there, across
# the normal: nodes of the opposite body lie elsewhere along the end.
BESIDE = 0.5
# Parts of the stiffness of a crystal that may differ from those of its mirror image.
ALIKE = 1e-6


@dataclass(frozen=True)
class _Side:
    """Boundary of a body that goes on behind it.

    Attributes:
        surface: the boundary.
        normal: (d,) of a plane of symmetry; zero for the side of a sector.
    """

    surface: Surface
    normal: Array

    def continues(self, other: _Side, points: Array, across: Array, sizes: Array) -> Bools:
        """(n,) nodes of a contact at which both bodies go on behind sides of the same kind.

        Args:
            other: side of the other body.
            points: (n, d) of the nodes.
            across: (n, d) unit normals of the contact.
            sizes: (n,) of elements.
        """
        found = np.full(len(points), abs(self.normal @ other.normal) > 1 - FLAT)
        if not self.normal.any():
            found[:] = not other.normal.any()
        for side in (self, other):
            away = points - side.surface.nearest(points)[0]
            away -= np.einsum("nd,nd->n", away, across)[:, None] * across
            found &= np.linalg.norm(away, axis=1) < BESIDE * sizes
            found &= np.abs(away @ side.normal) < FLAT * side.surface.extent
        return found & (np.abs(across @ self.normal) < SQUARE)


def continued_nodes(case: Case, model: ModelDefinition, mesh: Mesh, pair: Pair) -> Array | None:
    """Normals of planes behind which both bodies of a contact go on.

    Returns:
        (N, d) at nodes on the rim, in the plane at both ends, unit normals of planes of symmetry,
        zero where the next sector continues the bodies; NaN elsewhere. None in the plane if they
        end at both ends.
    """
    surface = pair.coupling.surface
    found = np.full(surface.points.shape, np.nan)
    if surface.free is None:  # an end node has half of the element next to it
        rows, sizes = np.array([0, len(found) - 1]), 2 * surface.weights
    else:
        rows, sizes = np.flatnonzero(surface.free), np.sqrt(surface.weights)
    nodes = surface.points[rows], surface.frames[rows, 0, : found.shape[1]], sizes[rows]
    found[rows] = normals_behind(case, model, mesh, (pair.body1, pair.body2), nodes)
    return None if surface.free is None and np.isnan(found).all() else found


def normals_behind(
    case: Case,
    model: ModelDefinition,
    mesh: Mesh,
    bodies: tuple[str, str],
    nodes: tuple[Array, Array, Array],
) -> Array:
    """Normals (n, d) of planes behind which two bodies go on, as of `continued_nodes`.

    Args:
        case: of the bodies.
        model: with their supports.
        mesh: of the bodies.
        bodies: names of the two.
        nodes: points (n, d) of a contact, unit normals (n, d) of it, sizes (n,) of its elements.
    """
    found = np.full(nodes[0].shape, np.nan)
    own = (
        list(_sides(case, model, body, mesh.bodies[body.name]))
        for name in bodies
        for body in model.bodies
        if body.name == name
    )
    for one, other in product(*own):
        found[one.continues(other, *nodes)] = one.normal
    return found


def coupled_contacts(
    case: Case, model: ModelDefinition, mesh: Mesh, surfaces: Mapping[str, Surface]
) -> tuple[Pair, ...]:
    """The contact pairs of a case, which know where the bodies go on behind their ends.

    Arc lengths of a half model begin at its plane of symmetry.

    Raises:
        CaseError: friction, a gap or a layer is not given all over a surface.
    """
    pairs = []
    for pair in couple_contacts(case, surfaces, model.components):
        continued, surface = continued_nodes(case, model, mesh, pair), pair.coupling.surface
        surface = replace(surface, continued=continued)
        if (end := half_end(surface)) is not None:
            surface = replace(surface, arc=surface.arc - surface.arc[end])
        given = read_coefficients(case, pair.name)
        if given.temperature is not None:
            _require_heat(given.key, model, (pair.body1, pair.body2))
        require_covered(given, surface)
        coupling = replace(pair.coupling, surface=surface)
        if (gap := read_gap(case, pair.name)) is not None:
            bodies = [mesh.bodies[body].points for body in (pair.body1, pair.body2)]
            _require_smaller(gap, bodies, case.units.length)
            coupling = _with_gap(case, pair, surface, gap)
        if (layer := read_layer(case, pair.name)) is not None:
            pair = replace(pair, layer=layer_at_nodes(layer, surface))
        pairs.append(replace(pair, coupling=coupling))
    return tuple(pairs)


def _require_smaller(gap: OverSurface, bodies: Sequence[Array], unit: str) -> None:
    """Check that a gap is smaller than the larger of two bodies with their points (n, d).

    Raises:
        CaseError: if it is larger, as one in other units.
    """
    size = max(float(np.linalg.norm(np.ptp(points, axis=0))) for points in bodies)
    if (largest := float(np.abs(gap.values).max())) > size:
        raise CaseError(
            f"{gap.key}: expected a gap that is smaller than the bodies ({size:.4g} {unit}), found "
            f"{largest:.4g} {unit}"
        )


def _require_heat(key: str, model: ModelDefinition, bodies: tuple[str, str]) -> None:
    """Check that something heats the bodies of a contact.

    Raises:
        CaseError: nothing does.
    """
    if not any(heatings(model.loads, body) for body in bodies):
        raise CaseError(
            f"{key}: expected a load that changes the temperature of {' or '.join(bodies)}, "
            "found none: their surfaces stay at the reference temperature"
        )


def _with_gap(case: Case, pair: Pair, surface: ContactSurface, given: OverSurface) -> Coupling:
    """The coupling of a pair on a surface, with the gap that a case adds.

    Raises:
        CaseError: that is not given all over the surface, or the surfaces overlap by it.
    """
    coupling, added = pair.coupling, gap_at_nodes(given, surface)
    mean = coupling.averaging @ added
    gap = coupling.gap + surface.weights * mean
    before, after = (each / surface.weights for each in (coupling.gap, gap))
    deepest = int(np.argmin(after))
    # Interpolated values of surfaces that are meant to touch may overlap by some of their range.
    if after[deepest] < min(before.min(), 0.0) - 0.01 * np.ptp(added):
        raise CaseError(
            f"{given.key}: expected a gap that leaves the surfaces apart or touching before any "
            f"load acts, found an overlap of {-after[deepest]:.4g} {case.units.length} at "
            f"{place_text(surface.points[deepest])}: add that to all values, or press them "
            "together by an 'interference'"
        )
    bodies = case.bodies[pair.body1], case.bodies[pair.body2]
    modulus = contact_modulus(*bodies, case.model.plane, surface.mean_normal)
    return replace(coupling, surface=replace(surface, added_gap=modulus * added), gap=gap)


def between_surfaces(case: Case, pair: Pair) -> Iterator[str]:
    """Gap and layer between the surfaces of a contact, in words."""
    units, contact = case.units, case.contacts[pair.name]
    if contact.gap is not None:
        gap = pair.coupling.gap / pair.coupling.surface.weights
        low, high = (rounded(float(each)) for each in (gap.min(), gap.max()))
        yield f"gap with that of {contact.gap}: {low} to {high} {units.length}"
    if pair.layer.any():
        stiffest = 1 / pair.layer.min(axis=0)
        softest, unit = 1 / softest_layer(case, pair), f"{units.stress}/{units.length}"
        for number, way in enumerate(("across", "along")):
            ends = dict.fromkeys(rounded(float(each[number])) for each in (softest, stiffest))
            yield f"layer: {' to '.join(ends)} {unit} {way} the surface"


def softest_layer(case: Case, pair: Pair) -> Array:
    """(2,) largest compliances of the layer of a contact to pressure and to shear.

    Of a curve that at small pressures, as next to edges.
    """
    found, layer = pair.layer.max(axis=0), case.contacts[pair.name].layer
    if layer is not None and layer.curve is not None:
        found[0] = max(layer.slopes)
    return np.asarray(found)


def missed_gaps(case: Case, pairs: Sequence[Pair]) -> Iterator[str]:
    """Contacts whose elements miss the gap that a case gives, in words."""
    for pair in pairs:
        given = read_gap(case, pair.name)
        missed = gap_missed(given, pair.coupling.surface) if given is not None else 0.0
        if missed > LARGEST_MISS:
            yield (
                f"contact {pair.name}: elements miss the gap given by {missed:.0%} of its range: "
                f"{Kind.GAP_MISSED.remedy}"
            )


def half_end(surface: ContactSurface) -> int | None:
    """The only end, 0 or -1, at which a plane contact goes on behind a plane of symmetry."""
    continued = surface.continued
    if surface.facets is not None or continued is None:
        return None
    ends = [end for end in (0, -1) if np.isfinite(continued[end]).all() and continued[end].any()]
    return ends[0] if len(ends) == 1 else None


def half_middles(pairs: Sequence[Pair]) -> dict[str, Array]:
    """(2,) places where plane contacts end in a plane of symmetry at one end, by contact."""
    ends = {pair.name: (pair.coupling.surface, half_end(pair.coupling.surface)) for pair in pairs}
    return {name: each.points[end] for name, (each, end) in ends.items() if end is not None}


def _sides(
    case: Case, model: ModelDefinition, body: BodyDefinition, mesh: BodyMesh
) -> Iterator[_Side]:
    """Sides of a body behind which it goes on."""
    for sector in case.symmetry.values():
        for name in {sector.boundary1, sector.boundary2} & mesh.boundaries.keys():
            yield _Side(boundary_surface(mesh, name), np.zeros(mesh.points.shape[1]))
    for number, held in enumerate(body.constraints):
        normal = np.array(held.direction)[: mesh.points.shape[1]]
        surface = boundary_surface(mesh, held.boundary)
        if body.coordinates[number].control != "fixed" or not normal.any() or held.at:
            continue
        flat = np.abs(np.abs(surface.normals @ normal) - 1) < FLAT
        # Other boundaries in the plane may be held across it, too: both cuts of half a ring.
        across = [
            coordinate.control == "fixed" and abs(np.dot(each.direction, held.direction)) > 1 - FLAT
            for each, coordinate in zip(body.constraints, body.coordinates, strict=True)
        ]
        others = zip(body.constraints, across, strict=True)
        acting = {each.boundary for each, same in others if not same and not each.at}
        acting |= {each.traction.boundary for each in model.loads if each.traction is not None}
        acting &= mesh.boundaries.keys()
        alone = not any(_lies_in(mesh, name, surface, normal) for name in acting)
        if flat.all() and alone and _is_its_image(body, normal):
            yield _Side(surface, normal)


def _lies_in(mesh: BodyMesh, name: str, surface: Surface, normal: Array) -> bool:
    """True if some facet of a boundary lies in the plane of a surface."""
    height = (mesh.points[mesh.boundaries[name]] - surface.points[0]) @ normal
    return bool((np.abs(height) < FLAT * surface.extent).all(axis=1).any())


def _is_its_image(body: BodyDefinition, normal: Array) -> bool:
    """True if the material of a body is its own mirror image."""
    if body.material.crystal is None:
        return True
    stiffness = body.material.stiffness
    image = turned(stiffness, np.eye(3) - 2 * np.outer(normal, normal))
    return bool(np.abs(image - stiffness).max() < ALIKE * np.abs(stiffness).max())
