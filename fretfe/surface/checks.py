# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks of contact surfaces: opposite each other, initial gap, no bodies over each other.

And the quality of the mesh of each contact: numbers, and warnings in words.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Case
from fretfe.errors import MeshError
from fretfe.mesh.body_overlap import BodyOverlap, body_overlaps
from fretfe.mesh.elements import shape_values
from fretfe.mesh.load import grouped_mesh, naming_case
from fretfe.mesh.make import SetSizes
from fretfe.mesh.mesh import BodySummary, Mesh
from fretfe.surface.overlap import overlap_points, search_reach
from fretfe.surface.surface import Surface, build_surface, curvatures, deviations, facet_turns

# An interpenetration of this fraction of a facet is not resolved by the mesh and does no harm.
INTERPENETRATION_PER_FACET = 0.01
# Coordinates in mesh files may be rounded to this fraction of the size of the surfaces.
FILE_ROUNDING = 1e-6
# What is compared with the reach of the search, by dimension.
_EXTENTS = {2: "length of the shorter", 3: "root of the area of the smaller"}
# Degrees, as of `smallest_angle`. Slivers have less than 5; good tetrahedra, also those of swept
# triangles, have 20 or more.
SMALLEST_ANGLES = {"triangle": 15.0, "quadrilateral": 15.0, "tetrahedron": 5.0, "hexahedron": 15.0}
LARGEST_GAP = 0.01  # of the extent of the overlap
ELEMENTS_PER_RADIUS = 10.0
FEWEST_ELEMENTS = 4
LARGEST_SIZE_RATIO = 3.0
# Gaps that differ by less than this fraction of the extent of a contact are equal.
ROUND_OFF = 1e-9
LARGEST_DEVIATION = 0.1  # of the difference between the largest and the smallest gap


@dataclass(frozen=True)
class InitialGap:
    """Initial gap at n places of surface 2 that lie opposite surface 1.

    Attributes:
        surface1: surface of body 1.
        surface2: surface of body 2.
        points: (n, d) coordinates of the places.
        gap: (n,) distance to surface 1 along the contact normal; negative: interpenetration.
        weights: (n,) arc length or area that a place stands for.
        facet1: (n,) facets of surface 1 that the places meet.
        facet2: (n,) facets of surface 2 that the places are on.
    """

    surface1: Surface
    surface2: Surface
    points: Array
    gap: Array
    weights: Array
    facet1: Indices
    facet2: Indices

    def allowed_interpenetration(self) -> Array:
        """(n,) depth that comes with facets and rounding, not with the shape of the bodies."""
        sides = ((self.surface1, self.facet1), (self.surface2, self.facet2))
        size = max(float(np.ptp(surface.vertices, axis=0).max()) for surface, _ in sides)
        coarsest = np.maximum(*(surface.sizes[facets] for surface, facets in sides))
        deviation = np.add(*(deviations(surface)[facets] for surface, facets in sides))
        return deviation + INTERPENETRATION_PER_FACET * coarsest + FILE_ROUNDING * size


def initial_gap(surface1: Surface, surface2: Surface) -> InitialGap:
    """Initial gap of two surfaces; without any place if they do not lie opposite each other."""
    overlap = overlap_points(surface1, surface2)
    values = shape_values(surface2.shape, surface2.degree, overlap.at2)
    points = np.einsum("nk,nkd->nd", values, surface2.nodes[overlap.facet2])
    return InitialGap(
        surface1, surface2, points, overlap.gap, overlap.weights, overlap.facet1, overlap.facet2
    )


def check_contacts(mesh: Mesh, case: Case) -> None:
    """Check that every contact can close and that no two bodies are in the same place.

    A gap is no problem: loads may close it. Nor is an overlap of the size of what straight facets
    make of arcs that fit into each other.

    Args:
        mesh: bodies that have all the groups that the case names.
        case: validated case.

    Raises:
        MeshError: Contact surfaces have no common orientation, are no open curves in the plane,
            overlap, face the wrong way or never face each other, or bodies overlap. Everything
            found is in the message.
    """
    unit = case.units.length
    overlaps = {frozenset((o.body1, o.body2)): o for o in body_overlaps(mesh)}
    problems = []
    for name, initial in initial_gaps(mesh, case).items():
        bodies = frozenset((initial.surface1.body, initial.surface2.body))
        found = list(_problems(name, initial, unit, bodies in overlaps))
        if found:
            problems += found
            overlaps.pop(bodies, None)
    problems += [_bodies_overlap(overlap, unit) for overlap in overlaps.values()]
    if problems:
        lines = "".join(f"\n  - {problem}" for problem in problems)
        raise MeshError(f"the bodies are not where contact can begin:{lines}")


# Gaps of the pairs of surfaces of meshes: checks, advice and tables ask for them one after another.
_GAPS: WeakKeyDictionary[Mesh, dict[tuple[str, str], InitialGap]] = WeakKeyDictionary()


def initial_gaps(mesh: Mesh, case: Case) -> dict[str, InitialGap]:
    """Initial gap of each contact, by name.

    Raises:
        MeshError: as for `build_surface`.
    """
    bodies = {name: body for body in mesh.bodies.values() for name in body.boundaries}
    pairs = {name: (each.surface1, each.surface2) for name, each in case.contacts.items()}
    known = _GAPS.setdefault(mesh, {})
    for pair in pairs.values():
        if pair not in known:
            known[pair] = initial_gap(*(build_surface(bodies[name], name) for name in pair))
    return {name: known[pair] for name, pair in pairs.items()}


def _problems(name: str, initial: InitialGap, unit: str, bodies_overlap: bool) -> Iterator[str]:
    if len(initial.gap):
        yield from _interpenetration(name, initial, unit)
    elif not bodies_overlap:
        yield f"{_heading(name, initial)} {_why_apart(initial, unit)}"


def _heading(name: str, initial: InitialGap) -> str:
    first, second = initial.surface1, initial.surface2
    return (
        f"contacts.{name}: '{first.name}' of body '{first.body}' and '{second.name}' of body"
        f" '{second.body}'"
    )


def _interpenetration(name: str, initial: InitialGap, unit: str) -> Iterator[str]:
    allowed = initial.allowed_interpenetration()
    if (-initial.gap - allowed).max() <= 0:
        return
    deepest = int(np.argmin(initial.gap))
    measure = initial.weights[initial.gap < 0].sum()
    extent = f"a length of {measure:.4g} {unit}"
    if initial.surface1.dimension == 3:
        extent = f"an area of {measure:.4g} {unit}²"
    yield (
        f"{_heading(name, initial)} overlap before any load acts: by up to"
        f" {-initial.gap[deepest]:.4g} {unit} at {place(initial.points[deepest])}, over"
        f" {extent}; expected at most {allowed[deepest]:.2g} {unit}"
        " there, which the mesh does not resolve. Move the bodies until they touch or stand"
        " apart, and let a load bring them together. For a press fit let them touch, and give"
        " the overlap by a load of type 'interference'"
    )


def _why_apart(initial: InitialGap, unit: str) -> str:
    """Reason why surfaces are never opposite each other, in words that follow their names."""
    first, second = initial.surface1, initial.surface2
    points, partners, normals, opposite = _nearest_places(first, second)
    distance = np.linalg.norm(points - partners, axis=1)
    chosen = int(np.argmin(distance))
    cosines = np.sum(normals * opposite, axis=1)
    # Neighbours of the nearest place count too: the normal at the end of a curve is that of its
    # last facet.
    near = distance <= distance[chosen] + second.sizes.max()
    where = (
        f"{distance[chosen]:.4g} {unit} apart at {place(points[chosen])} and"
        f" {place(partners[chosen])}"
    )
    if cosines[near].min() >= 0:
        return (
            f"face the wrong way: where they are nearest, {where}, the outward normals are"
            f" {place(opposite[chosen], 3)} and {place(normals[chosen], 3)}; expected them to"
            " oppose each other. Is one of the surfaces the back or a side of its body?"
        )
    reach = search_reach(first, second)
    if distance[chosen] > reach:
        return (
            f"are too far apart: nearest {where}; expected less than {reach:.4g} {unit}, half the"
            f" {_EXTENTS[first.dimension]} one. Check the names, and that the bodies are in their"
            " working position"
        )
    return (
        f"pass by each other: nearest {where}, but no normal of the one meets the other. Check"
        " the names, and that the bodies are in their working position"
    )


def _nearest_places(first: Surface, second: Surface) -> tuple[Array, Array, Array, Array]:
    """(n, d) nodes of the second surface, places of the first nearest to them, both normals."""
    points, normals = (x.reshape(-1, second.dimension) for x in (second.nodes, second.normals))
    partners, opposite = first.nearest(points)
    return points, partners, normals, opposite


def _bodies_overlap(overlap: BodyOverlap, unit: str) -> str:
    return (
        f"bodies '{overlap.body1}' and '{overlap.body2}' overlap: a point of"
        f" '{overlap.body1}' at {place(overlap.point)} is {overlap.depth:.4g} {unit} inside"
        f" '{overlap.body2}'; expected separate bodies that touch at most"
    )


def place(point: Array, digits: int = 6) -> str:
    """Coordinates of a point in words."""
    # Adding zero turns -0 into 0.
    return f"({', '.join(f'{round(float(v), 12) + 0.0:.{digits}g}' for v in point)})"


def load_mesh(case: Case, size: SetSizes | None = None, *, section: bool = False) -> Mesh:
    """Read or make the mesh of a case and check it against the case. Serial.

    Args:
        case: validated case.
        size: sets element sizes in place of those of the geometry.
        section: as of `grouped_mesh`.

    Raises:
        CaseError: as for `grouped_mesh`.
        MeshError: as for `grouped_mesh`, and if contact surfaces overlap or do not face each other.
    """
    mesh = grouped_mesh(case, size, section=section)
    with naming_case(case):
        check_contacts(mesh, case)
    return mesh


@dataclass(frozen=True)
class SurfaceQuality:
    """The facets of one contact surface; lengths in the units of the mesh.

    The size of a facet is its length or, in space, the side of an even one of its area.

    Attributes:
        name: of the surface.
        measure: length or area of all facets.
        facets: number of them.
        opposite: number of those that lie opposite the other surface.
        smallest: size of the smallest facet that lies opposite the other surface.
        largest: size of the largest one.
        radius: radius of curvature where a facet turns most; infinite for a flat surface.
        radius_size: size of the facet there.
        deviation: largest distance of a facet from the smooth surface through its nodes.
    """

    name: str
    measure: float
    facets: int
    opposite: int
    smallest: float
    largest: float
    radius: float
    radius_size: float
    deviation: float

    @property
    def per_radius(self) -> float:
        """Smallest number of facets per radius of curvature."""
        return self.radius / self.radius_size


def other_sizes(contacts: Sequence[ContactQuality], size: float, unit: str) -> Iterator[str]:
    """Contact surfaces whose elements are not as long as the case asks for, and why, in words."""
    for surface in {each.name: each for found in contacts for each in found.surfaces}.values():
        # Even triangles have sides from .6 to 1.4 of that.
        if surface.smallest < 0.5 * size or surface.largest > 1.6 * size:
            yield (
                f"{surface.name} has elements of {surface.smallest:.2g} to {surface.largest:.2g} "
                f"{unit} where geometry.size = {size:g}: short edges and small radii of the CAD "
                "file make them smaller, and what does not follow its faces larger"
            )


@dataclass(frozen=True)
class ContactQuality:
    """The mesh of one contact before any load acts; lengths in the units of the mesh.

    Attributes:
        name: of the contact.
        surfaces: surface 1 and surface 2.
        measure: length or area over which the surfaces lie opposite each other.
        gap: the smallest one, 0 if the bodies overlap.
        interpenetration: the largest one, 0 if the surfaces stand apart.
        nearest: (d,) place of the smallest gap or largest interpenetration, in the middle if there
            are many.
        gap_range: difference between the largest and the smallest gap.
        size_ratio: of the larger to the smaller facet, median over the places of the overlap.
    """

    name: str
    surfaces: tuple[SurfaceQuality, SurfaceQuality]
    measure: float
    gap: float
    interpenetration: float
    nearest: Array
    gap_range: float
    size_ratio: float

    @property
    def extent(self) -> float:
        """Length of the overlap, or the root of its area."""
        return float(self.measure ** (1 / (len(self.nearest) - 1)))


def contact_quality(contacts: Mapping[str, InitialGap]) -> tuple[ContactQuality, ...]:
    """Numbers for each contact, whose surfaces lie opposite each other somewhere."""
    return tuple(_contact(name, initial) for name, initial in contacts.items())


def _contact(name: str, initial: InitialGap) -> ContactQuality:
    measure = float(initial.weights.sum())
    round_off = ROUND_OFF * measure ** (1 / (initial.surface1.dimension - 1))
    smallest = float(initial.gap.min())
    if abs(smallest) < round_off:
        smallest = 0.0
    nearest = np.flatnonzero(initial.gap <= smallest + round_off)
    sizes1 = initial.surface1.sizes[initial.facet1]
    sizes2 = initial.surface2.sizes[initial.facet2]
    ratios = np.maximum(sizes1, sizes2) / np.minimum(sizes1, sizes2)
    return ContactQuality(
        name=name,
        surfaces=(
            _surface(initial.surface1, np.unique(initial.facet1)),
            _surface(initial.surface2, np.unique(initial.facet2)),
        ),
        measure=measure,
        gap=max(0.0, smallest),
        interpenetration=max(0.0, -smallest),
        nearest=initial.points[nearest[len(nearest) // 2]],
        gap_range=float(np.ptp(initial.gap)),
        size_ratio=float(np.median(ratios)),
    )


def _surface(surface: Surface, opposite: Indices) -> SurfaceQuality:
    side = 2 / 3**0.25 if surface.shape == "triangle" else 1.0
    sizes, curvature = side * surface.sizes[opposite], curvatures(surface)[opposite]
    turns = facet_turns(surface)[opposite]
    worst = int(np.argmax(turns))
    radius = float(1 / curvature[worst]) if curvature[worst] > 0 else math.inf
    return SurfaceQuality(
        name=surface.name,
        measure=float(surface.measures.sum()),
        facets=len(surface.facets),
        opposite=len(opposite),
        smallest=float(sizes.min()),
        largest=float(sizes.max()),
        radius=radius,
        radius_size=float(turns[worst] * radius) if turns[worst] else float(sizes[worst]),
        deviation=float(deviations(surface)[opposite].max()),
    )


def mesh_warnings(
    bodies: Sequence[BodySummary], contacts: Sequence[ContactQuality], unit: str
) -> tuple[str, ...]:
    """Properties of the mesh that may spoil the results, in words; see docs/mesh.md."""
    found = [
        f"{body.name}: smallest angle {body.smallest_angle:.1f}°; expected at least"
        f" {SMALLEST_ANGLES[body.cell]:g}°"
        for body in bodies
        if body.smallest_angle < SMALLEST_ANGLES[body.cell]
    ]
    straight = all(body.order == 1 for body in bodies)
    for contact in contacts:
        found += [f"{contact.name}: {text}" for text in _contact_warnings(contact, unit, straight)]
    return tuple(found)


def _contact_warnings(contact: ContactQuality, unit: str, straight: bool) -> Iterator[str]:
    if contact.gap > LARGEST_GAP * contact.extent:
        yield (
            f"the surfaces stand apart everywhere, by {contact.gap:.4g} {unit} or more"
            f" ({100 * contact.gap / contact.extent:.2g} % of the {contact.extent:.4g} {unit} over"
            " which they face each other); is this the place where the load begins?"
        )
    if contact.size_ratio > LARGEST_SIZE_RATIO:
        yield (
            f"elements of one surface are {contact.size_ratio:.2g} times as long as those of the"
            f" other; expected at most {LARGEST_SIZE_RATIO:g} times"
        )
    for surface in contact.surfaces:
        if surface.opposite < FEWEST_ELEMENTS:
            yield (
                f"{surface.name} has {surface.opposite} of its elements opposite the other surface;"
                f" expected at least {FEWEST_ELEMENTS}: where the contact ends cannot be told"
            )
        if surface.per_radius < ELEMENTS_PER_RADIUS:
            yield (
                f"{surface.name} has an element of {surface.radius_size:.4g} {unit} where the"
                f" radius of curvature is {surface.radius:.4g} {unit}: {surface.per_radius:.2g}"
                f" elements per radius; expected at least {ELEMENTS_PER_RADIUS:g}"
            )
        if straight and surface.deviation > LARGEST_DEVIATION * contact.gap_range:
            yield (
                f"the straight elements of {surface.name} miss its curve by up to"
                f" {surface.deviation:.2g} {unit}, and the gap varies by no more than"
                f" {contact.gap_range:.2g} {unit}; use elements of order 2, with curved edges"
            )
