# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that are spread over a boundary, a volume or a contact."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import ClassVar, Self

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.loads.cut import Cut
from fretfe.bodies.loads.files import factors_by, values_at_points
from fretfe.bodies.point_values import NodalValues, PointValues, require_points_around
from fretfe.case import Case, complaint, unit_vector
from fretfe.case.loads import (
    AccelerationLoad,
    ForceLoad,
    InterferenceLoad,
    RotationLoad,
    TractionLoad,
)
from fretfe.errors import CaseError
from fretfe.materials.material import Material
from fretfe.mesh.mesh import Mesh
from fretfe.surface.overlap import GAUSS_POINTS
from fretfe.surface.surface import Surface, boundary_surface

# From a node to the nearest point of integration of a part of a boundary, over the extent of its
# facet: at most .03 along a line, .06 in a triangle.
POINTS_BESIDE = 0.06


@dataclass(frozen=True)
class SurfaceTraction:
    """A traction that is integrated over a boundary.

    Attributes:
        boundary: physical group.
        direction: unit vector; () for the outward normal.
        factors: of the traction, by places; None for 1 everywhere.
        even: whether it is divided by the area that it acts on, so that its resultant is one.
        centre: of the part of the boundary that it acts on.
        radius: of that part; 0 for all of the boundary.
        through: a point on the line of action of an even one, which becomes linear in the place;
            empty for the middle.
    """

    boundary: str
    direction: tuple[float, ...] = ()
    factors: PointValues | NodalValues | None = None
    even: bool = False
    centre: tuple[float, ...] = ()
    radius: float = 0.0
    through: tuple[float, ...] = ()

    def forces(self, surface: Surface) -> tuple[Array, Array]:
        """Places (n, d) and forces (n, c) by a unit of it on its boundary."""
        places, vectors = surface.integration_points(GAUSS_POINTS)
        areas = np.linalg.norm(vectors, axis=1)
        if self.even:
            if self.radius:
                away = places - np.array(self.centre[: surface.dimension])
                areas = areas * (np.linalg.norm(away, axis=1) < self.radius)
            through = self.through[: surface.dimension] or areas @ places / areas.sum()
            return np.array([through]), np.array([self.direction])
        forces = np.outer(areas, self.direction) if self.direction else vectors
        return places, forces if self.factors is None else forces * self.factors.at(places)[:, None]


@dataclass(frozen=True)
class SpreadLoad:
    """A load per unit of its amplitude. Each kind acts in one way; bodies ask for all of them.

    Attributes:
        channel: name of the load in the case file.
        closes: contact whose gap is less by the amplitude; empty without one.
        total: whether amplitudes are forces, for the whole thickness.
        pushes: whether it is a body force.
    """

    channel: str
    closes: str = field(default="", kw_only=True)

    total: ClassVar[bool] = False
    pushes: ClassVar[bool] = False

    @property
    def label(self) -> str:
        """Name of its own: that of its channel, with a number where this has several."""
        return self.channel

    @property
    def traction(self) -> SurfaceTraction | None:
        """Traction on a boundary by a unit of the amplitude."""
        return None

    @property
    def given(self) -> tuple[PointValues | NodalValues, ...]:
        """Values at points that it has."""
        return ()

    @property
    def run(self) -> Cut | None:
        """Field of another run that it is a part of."""
        return None

    def amplitudes(self, values: Array) -> Array:
        """(T,) amplitudes by values (T,) of its channel."""
        return values

    def strains(self, body: str) -> bool:
        """True if it causes an initial strain of a body."""
        return False

    def initial_strain(self, body: str, material: Material, places: Array) -> Array:
        """(m, 3, 3) initial strain at places (m, d) of a body that it strains, for a unit."""
        raise NotImplementedError

    def body_force(self, material: Material, places: Array) -> Array:
        """(m, d) force per volume at places (m, d) by a unit of the amplitude, if it pushes.

        (m, 3) of an acceleration that plane bodies feel along z.
        """
        raise NotImplementedError

    def require_mesh(self, case: Case, mesh: Mesh) -> None:
        """Check that it can act on the bodies of a mesh.

        Raises:
            CaseError: says where it cannot.
        """

    def notes(self, case: Case, mesh: Mesh) -> Iterator[str]:
        """Things that a mesh does not resolve of it, in words."""
        yield from ()


@dataclass(frozen=True)
class Traction(SpreadLoad):
    """A traction along a direction, or along the outward normal for ()."""

    boundary: str
    direction: tuple[float, ...] = ()
    factors: PointValues | NodalValues | None = None

    @classmethod
    def of(cls, case: Case, name: str, load: TractionLoad, mesh: Mesh) -> tuple[Self]:
        """Those of a load of a case."""
        size, direction = case.components(mesh.dimension), load.direction
        along = () if direction == "normal" else unit_vector(direction, size)
        factors: PointValues | NodalValues | None = None
        if load.function is not None:
            places = np.concatenate(
                [boundary_surface(body, load.boundary).displacement_points(case.model.degree)
                 for body in mesh.bodies.values() if load.boundary in body.boundaries]
            )  # fmt: skip
            factors = NodalValues(places, factors_by(case, name, load.function, places))
        elif load.at_points:
            factors = values_at_points(case, name, load, mesh.dimension)
        return (cls(name, load.boundary, along, factors),)

    @property
    def traction(self) -> SurfaceTraction:
        """Traction on the boundary."""
        return SurfaceTraction(self.boundary, self.direction, self.factors)

    @property
    def given(self) -> tuple[PointValues | NodalValues, ...]:
        """The factors."""
        return () if self.factors is None else (self.factors,)

    def require_mesh(self, case: Case, mesh: Mesh) -> None:
        """Check that factors reach as far as the boundary."""
        for body in mesh.bodies.values():
            if isinstance(self.factors, PointValues) and self.boundary in body.boundaries:
                places = body.points[np.unique(body.boundaries[self.boundary])]
                what = f"the boundary {self.boundary!r}"
                require_points_around(case, self.channel, self.factors, places, what)


@dataclass(frozen=True)
class Force(SpreadLoad):
    """A force spread over a boundary, or over its part within a radius of a centre."""

    boundary: str
    direction: tuple[float, ...]
    centre: tuple[float, ...] = ()
    radius: float = 0.0
    through: tuple[float, ...] = ()

    total = True

    @classmethod
    def of(cls, case: Case, name: str, load: ForceLoad, mesh: Mesh) -> tuple[Self]:
        """That of a load of a case."""
        direction = unit_vector(load.direction, case.components(mesh.dimension))
        if load.through is not None and len(direction) > mesh.dimension and direction[2]:
            text = "expected a force in the plane with 'through', found one along z"
            raise CaseError(complaint(case.source, ("loads", name, "through"), text))
        part = load.centre or (), load.radius or 0.0
        return (cls(name, load.boundary, direction, *part, load.through or ()),)

    @property
    def traction(self) -> SurfaceTraction:
        """Traction whose resultant is one."""
        return SurfaceTraction(self.boundary, self.direction, even=True, centre=self.centre,
                               radius=self.radius, through=self.through)  # fmt: skip

    def require_mesh(self, case: Case, mesh: Mesh) -> None:
        """Check that it acts on some elements, not only within one of them."""
        for body in mesh.bodies.values():
            if self.radius and self.boundary in body.boundaries:
                surface = boundary_surface(body, self.boundary)
                places, facets = surface.displacement_points(2), surface.displacement_facets(2)
                away = np.linalg.norm(places - np.array(self.centre), axis=1)
                nearest = int(np.argmin(away))
                around = places[facets[(facets == nearest).any(axis=1)]]
                size = np.linalg.norm(np.ptp(around, axis=1), axis=1).max()
                # Points of integration lie next to nodes, not on them.
                least = float(away[nearest] + POINTS_BESIDE * size)
                if least > self.radius:
                    raise CaseError(
                        f"{case.source}: loads.{self.channel}.radius: expected at least "
                        f"{least:.4g}, so that nodes or middles of elements of the boundary "
                        f"{self.boundary!r} are well within it, found {self.radius:g}"
                    )


@dataclass(frozen=True)
class Rotation(SpreadLoad):
    """Centrifugal force; its amplitude is the square of the angular speed."""

    axis: tuple[float, ...]
    centre: tuple[float, ...]

    pushes = True

    @classmethod
    def of(cls, case: Case, name: str, load: RotationLoad, mesh: Mesh) -> tuple[Self]:
        """That of a load of a case."""
        return (cls(name, unit_vector(load.axis, 3), load.centre),)

    def amplitudes(self, values: Array) -> Array:
        """(T,) squares of angular speeds (T,)."""
        return values**2

    def body_force(self, material: Material, places: Array) -> Array:
        """(m, d) force per volume at places (m, d)."""
        size = places.shape[1]
        arms = places - np.array(self.centre[:size])
        if size == 3:  # in the plane the axis is normal to it
            axis = np.array(self.axis)
            arms = arms - np.outer(arms @ axis, axis)
        return np.asarray(material.density * arms)


@dataclass(frozen=True)
class Acceleration(SpreadLoad):
    """Body force density * acceleration along a direction."""

    direction: tuple[float, ...]

    pushes = True

    @classmethod
    def of(cls, case: Case, name: str, load: AccelerationLoad, mesh: Mesh) -> tuple[Self]:
        """That of a load of a case."""
        return (cls(name, unit_vector(load.direction, case.components(mesh.dimension))),)

    def body_force(self, material: Material, places: Array) -> Array:
        """(m, c) force per volume at places (m, d)."""
        return np.tile(material.density * np.array(self.direction), (len(places), 1))


@dataclass(frozen=True)
class Interference(SpreadLoad):
    """An overlap of the surfaces of a contact; bodies feel it only by the contact."""

    @classmethod
    def of(cls, case: Case, name: str, load: InterferenceLoad, mesh: Mesh) -> tuple[Self]:
        """That of a load of a case."""
        return (cls(name, closes=load.contact),)
