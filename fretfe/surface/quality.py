# SPDX-License-Identifier: LGPL-3.0-or-later
"""Quality of the mesh of each contact: numbers, and warnings in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.mesh.groups import BodySummary
from fretfe.surface.chain import Chain
from fretfe.surface.gap import InitialGap
from fretfe.surface.surface import Surface

# Degrees. Tetrahedra that are long along a straight edge are flat but good; slivers are flatter.
SMALLEST_ANGLES = {"triangle": 15.0, "quadrilateral": 15.0, "tetrahedron": 1.0, "hexahedron": 15.0}
LARGEST_GAP = 0.01  # of the length of the overlap
ELEMENTS_PER_RADIUS = 10.0
LARGEST_SIZE_RATIO = 3.0
# Gaps that differ by less than this fraction of the length of a contact are equal.
ROUND_OFF = 1e-9
LARGEST_DEVIATION = 0.1  # of the difference between the largest and the smallest gap


@dataclass(frozen=True)
class SurfaceQuality:
    """The facets of one contact surface; lengths in the units of the mesh.

    Attributes:
        name: of the surface.
        length: of all facets.
        facets: number of them.
        opposite: number of those that lie opposite the other surface.
        smallest: length of the shortest facet that lies opposite the other surface.
        largest: length of the longest one.
        radius: radius of curvature where a facet turns most; infinite for a straight surface.
        radius_size: length of the facet there.
        deviation: largest distance of a facet from the smooth curve through its nodes.
    """

    name: str
    length: float
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
        length: over which the surfaces lie opposite each other.
        gap: the smallest one, 0 if the bodies overlap.
        interpenetration: the largest one, 0 if the surfaces stand apart.
        nearest: (2,) place of the smallest gap or largest interpenetration, in the middle if there
            are many.
        gap_range: difference between the largest and the smallest gap.
        size_ratio: of the longer to the shorter facet, median over the places of the overlap.
    """

    name: str
    surfaces: tuple[SurfaceQuality, SurfaceQuality]
    length: float
    gap: float
    interpenetration: float
    nearest: Array
    gap_range: float
    size_ratio: float


def contact_quality(contacts: Mapping[str, InitialGap]) -> tuple[ContactQuality, ...]:
    """Numbers for each contact, whose surfaces lie opposite each other somewhere."""
    return tuple(_contact(name, initial) for name, initial in contacts.items())


def _contact(name: str, initial: InitialGap) -> ContactQuality:
    length = float(initial.weights.sum())
    smallest = float(initial.gap.min())
    if abs(smallest) < ROUND_OFF * length:
        smallest = 0.0
    nearest = np.flatnonzero(initial.gap <= smallest + ROUND_OFF * length)
    lengths1 = initial.surface1.measures[initial.facet1]
    lengths2 = initial.surface2.measures[initial.facet2]
    ratios = np.maximum(lengths1, lengths2) / np.minimum(lengths1, lengths2)
    return ContactQuality(
        name=name,
        surfaces=(
            _surface(initial.surface1, np.unique(initial.facet1)),
            _surface(initial.surface2, np.unique(initial.facet2)),
        ),
        length=length,
        gap=max(0.0, smallest),
        interpenetration=max(0.0, -smallest),
        nearest=initial.points[nearest[len(nearest) // 2]],
        gap_range=float(np.ptp(initial.gap)),
        size_ratio=float(np.median(ratios)),
    )


def _surface(surface: Surface, opposite: Indices) -> SurfaceQuality:
    chain, lengths = Chain(surface), surface.measures[opposite]
    curvatures = chain.curvatures[opposite]
    worst = int(np.argmax(curvatures * lengths))
    return SurfaceQuality(
        name=surface.name,
        length=float(surface.measures.sum()),
        facets=len(surface.facets),
        opposite=len(opposite),
        smallest=float(lengths.min()),
        largest=float(lengths.max()),
        radius=float(1 / curvatures[worst]) if curvatures[worst] > 0 else math.inf,
        radius_size=float(lengths[worst]),
        deviation=float(chain.deviations[opposite].max()),
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
    if contact.gap > LARGEST_GAP * contact.length:
        yield (
            f"the surfaces stand apart everywhere, by {contact.gap:.4g} {unit} or more"
            f" ({100 * contact.gap / contact.length:.2g} % of the {contact.length:.4g} {unit} over"
            " which they face each other); is this the place where the load begins?"
        )
    if contact.size_ratio > LARGEST_SIZE_RATIO:
        yield (
            f"elements of one surface are {contact.size_ratio:.2g} times as long as those of the"
            f" other; expected at most {LARGEST_SIZE_RATIO:g} times"
        )
    for surface in contact.surfaces:
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
