# SPDX-License-Identifier: LGPL-3.0-or-later
"""Quality of the mesh of each contact: numbers, and warnings in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.mesh.groups import BodySummary
from fretfe.surface.checks import InitialGap
from fretfe.surface.surface import Surface, curvatures, deviations

# Degrees. Tetrahedra that are long along a straight edge are flat but good; slivers are flatter.
SMALLEST_ANGLES = {"triangle": 15.0, "quadrilateral": 15.0, "tetrahedron": 0.3, "hexahedron": 15.0}
LARGEST_GAP = 0.01  # of the extent of the overlap
ELEMENTS_PER_RADIUS = 10.0
FEWEST_ELEMENTS = 4
LARGEST_SIZE_RATIO = 3.0
# Gaps that differ by less than this fraction of the extent of a contact are equal.
ROUND_OFF = 1e-9
LARGEST_DEVIATION = 0.1  # of the difference between the largest and the smallest gap


@dataclass(frozen=True)
class SurfaceQuality:
    """The facets of one contact surface; lengths in the units of the mesh.

    The size of a facet is its length or, in space, the root of its area.

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
    sizes, curvature = surface.sizes[opposite], curvatures(surface)[opposite]
    worst = int(np.argmax(curvature * sizes))
    return SurfaceQuality(
        name=surface.name,
        measure=float(surface.measures.sum()),
        facets=len(surface.facets),
        opposite=len(opposite),
        smallest=float(sizes.min()),
        largest=float(sizes.max()),
        radius=float(1 / curvature[worst]) if curvature[worst] > 0 else math.inf,
        radius_size=float(sizes[worst]),
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
