# SPDX-License-Identifier: LGPL-3.0-or-later
"""The bodies of a case file: isotropic ones, crystals, and the moduli of their contacts."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    Tag,
    TypeAdapter,
    ValidationError,
    model_validator,
)

from fretfe.case.base import TAG, Number, Positive, Table, Temperature, Text

if TYPE_CHECKING:
    from fretfe._typing import Array

# Rows of a rotation, and two crystal directions, may miss right angles and lengths by this: numbers
# typed with four digits pass.
ORTHOGONALITY = 1e-3
# Largest stiffness that couples displacements in the plane with those across, over the largest one:
# its square is what the plane leaves out.
COUPLED = 1e-6


class OverTemperature(Table):
    """Constants over temperature, linear in between."""

    temperatures: tuple[Temperature, ...] = Field(
        min_length=2, max_length=10_000, description="Temperatures, in degrees Celsius, increasing."
    )
    values: tuple[Any, ...] = Field(
        description="Constant, or list of constants, at each temperature."
    )

    @model_validator(mode="after")
    def _one_each(self) -> Self:
        if len(self.temperatures) != len(self.values):
            raise ValueError(
                "expected as many values as temperatures, "
                f"found {len(self.temperatures)} temperatures and {len(self.values)} values"
            )
        if any(b <= a for a, b in pairwise(self.temperatures)):
            raise ValueError(f"expected increasing temperatures, found {list(self.temperatures)}")
        rows = [value if isinstance(value, list | tuple) else [value] for value in self.values]
        if len({len(row) for row in rows}) > 1:
            raise ValueError("expected as many constants at each temperature, found several counts")
        for number, row in enumerate(rows, 1):
            try:
                TypeAdapter(tuple[Number, ...]).validate_python(tuple(row))
            except ValidationError:
                raise ValueError(
                    f"expected numbers, found another value in item {number}"
                ) from None
        return self

    def at(self, temperature: float) -> Any:
        """The constant, or the list of them, at a temperature within the table."""
        above = min(bisect_right(self.temperatures, temperature), len(self.temperatures) - 1)
        low, high = self.temperatures[above - 1 : above + 1]
        part = (temperature - low) / (high - low)
        one, other = self.values[above - 1 : above + 1]
        if isinstance(one, list | tuple):
            return [(1 - part) * a + part * b for a, b in zip(one, other, strict=True)]
        return (1 - part) * one + part * other


@dataclass(frozen=True)
class Given:
    """Bodies as a case gives them, before tables and files became numbers.

    Attributes:
        bodies: their tables.
        notes: where constants come from, in words.
        young: Young's modulus over temperature in the units of the case, of bodies that have it.
    """

    bodies: Mapping[str, Any]
    notes: tuple[str, ...]
    young: Mapping[str, OverTemperature]


# Shared by isotropic bodies and crystals.
Density = Annotated[
    Positive | None,
    Field(
        description="Mass density in consistent units (mm, N, s: t/mm^3); > 0. "
        "Needed in every body when a load is a rotation or an acceleration."
    ),
]
Expansion = Annotated[
    Number | None,
    Field(
        description="Coefficient of thermal expansion, per degree. Needed, with "
        "reference_temperature, in every body that a temperature load acts on."
    ),
]
Reference = Annotated[
    Temperature | None,
    Field(description="Temperature without thermal strain, in degrees Celsius."),
]


Material = Annotated[
    Text | None,
    Field(
        description="Material whose constants the body has where it gives none of its own: the "
        "name of one that comes with fretfe, or of a file (.toml), relative to the folder of the "
        "case file."
    ),
]
At = Annotated[
    Temperature | None,
    Field(
        description="Temperature at which constants are taken that are tables over temperature, "
        "in degrees Celsius, within all of these tables."
    ),
]


class Body(Table):
    """An isotropic elastic body; its key is the physical surface group of the mesh."""

    young: Positive = Field(description="Young's modulus, in stress units; > 0.")
    poisson: Number = Field(gt=-1, lt=0.5, description="Poisson's ratio; -1 < poisson < 0.5.")
    density: Density = None
    expansion: Expansion = None
    reference_temperature: Reference = None
    material: Material = None
    temperature: At = None

    # Displacements in the plane and across it do not depend on each other.
    couples_across: ClassVar[bool] = False

    @cached_property
    def stiffness(self) -> Array:
        """(6, 6) in Voigt's order."""
        from fretfe.materials.crystals import isotropic

        return isotropic(self.young, self.poisson)


Three = tuple[Number, Number, Number]


class Orthotropic(Table):
    """Engineering constants of a material with three planes of symmetry."""

    young: tuple[Positive, Positive, Positive] = Field(
        description="Young's moduli E1, E2, E3 along its axes, in stress units."
    )
    poisson: Three = Field(
        description="Poisson's ratios nu12, nu13, nu23: nu_ij is the contraction along j over the "
        "strain along i in tension along i, so that nu_ij/E_i = nu_ji/E_j."
    )
    shear: tuple[Positive, Positive, Positive] = Field(
        description="Shear moduli G12, G13, G23, in stress units."
    )


class Elastic(Table):
    """Elastic constants of a crystal in its own axes; exactly one way to give them."""

    cubic: Three | None = Field(
        default=None, description="c11, c12 and c44 of a cubic crystal, in stress units."
    )
    orthotropic: Orthotropic | None = Field(default=None, description="Engineering constants.")
    constants: Annotated[tuple[Number, ...], Field(min_length=21, max_length=21)] | None = Field(
        default=None,
        description="The 21 stiffnesses of any material, in stress units: upper triangle of the "
        "matrix row by row, C11, C12 ... C16, C22 ... C66, in Voigt's order 11, 22, 33, 23, 13, "
        "12, for engineering shear strains.",
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(map(repr, given)) or "none"
            raise ValueError(
                f"expected exactly one of 'cubic', 'orthotropic' and 'constants', found {found}"
            )
        return self

    @model_validator(mode="after")
    def _positive_definite(self) -> Self:
        from fretfe.materials.crystals import smallest_eigenvalue

        what = "stiffness" if self.orthotropic is None else "compliance"
        smallest = smallest_eigenvalue(self._given)
        if not smallest > 0:
            raise ValueError(
                f"expected constants by which every strain takes energy (a positive definite {what}"
                f"), found a {what} with the eigenvalue {smallest:.4g}"
            )
        return self

    @property
    def _given(self) -> Array:
        """(6, 6) stiffness, of engineering constants compliance."""
        from fretfe.materials import crystals

        if self.cubic is not None:
            return crystals.cubic(*self.cubic)
        if self.orthotropic is not None:
            each = self.orthotropic
            return crystals.orthotropic_compliance(each.young, each.poisson, each.shear)
        assert self.constants is not None
        return crystals.triclinic(self.constants)

    @cached_property
    def stiffness(self) -> Array:
        """(6, 6) in Voigt's order, in the axes of the crystal."""
        import numpy as np

        return np.linalg.inv(self._given) if self.orthotropic is not None else self._given


def _right_handed(matrix: tuple[Three, Three, Three]) -> tuple[Three, Three, Three]:
    import numpy as np

    rows = np.array(matrix)
    worst, volume = np.abs(rows @ rows.T - np.eye(3)).max(), np.linalg.det(rows)
    if worst > ORTHOGONALITY or volume < 0:
        raise ValueError(
            "expected a rotation (rows of length 1 at right angles, determinant 1), found a matrix "
            f"with the determinant {volume:.4g} whose rows miss that by {worst:.2g}"
        )
    return matrix


class Orientation(Table):
    """Orientation of a crystal in the axes of the model; exactly one way to say it."""

    x: Three | None = Field(
        default=None, description="Direction in the crystal that lies along x of the model."
    )
    y: Three | None = Field(default=None, description="The same along y.")
    z: Three | None = Field(default=None, description="The same along z.")
    euler: Three | None = Field(
        default=None,
        description="Bunge's Euler angles phi1, Phi, phi2 in degrees: they turn the axes of the "
        "model into those of the crystal, about z, then the new x, then the new z.",
    )
    matrix: Annotated[tuple[Three, Three, Three], AfterValidator(_right_handed)] | None = Field(
        default=None,
        description="Rotation whose rows are the axes of the crystal in those of the model.",
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        directions = self._directions
        ways = [name for name in ("euler", "matrix") if getattr(self, name) is not None]
        if len(ways) + bool(directions) > 1 or len(directions) not in (0, 2):
            raise ValueError(
                "expected two of the directions 'x', 'y' and 'z', or 'euler', or 'matrix', found "
                f"{' and '.join(map(repr, [*directions, *ways]))}"
            )
        if directions:
            (first, u), (second, v) = directions.items()
            lengths = math.hypot(*u), math.hypot(*v)
            if 0 in lengths:
                raise ValueError("expected directions of non-zero length, found a zero vector")
            cosine = sum(a * b for a, b in zip(u, v, strict=True)) / math.prod(lengths)
            if abs(cosine) > ORTHOGONALITY:
                angle = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
                raise ValueError(
                    f"expected crystal directions {first!r} and {second!r} at right angles, found "
                    f"{angle:.1f} degrees between them"
                )
        return self

    @property
    def _directions(self) -> dict[str, Three]:
        given = {name: getattr(self, name) for name in "xyz"}
        return {name: each for name, each in given.items() if each is not None}

    @cached_property
    def axes(self) -> Array:
        """(3, 3) rows: axes of the crystal in the axes of the model."""
        import numpy as np

        from fretfe.materials.crystals import bunge_rotation

        if self.euler is not None:
            return bunge_rotation(self.euler)
        if self.matrix is not None:
            left, _, right = np.linalg.svd(np.array(self.matrix))  # the nearest rotation
            return np.asarray(left @ right)
        if not self._directions:
            return np.eye(3)
        columns = {name: np.array(each) for name, each in self._directions.items()}
        (first, one), (second, two) = columns.items()
        columns[first] = one = one / np.linalg.norm(one)
        two = two - one * (one @ two)
        columns[second] = two / np.linalg.norm(two)
        third, before, after = next(
            turn for turn in ("xyz", "yzx", "zxy") if turn[0] not in columns
        )
        columns[third] = np.cross(columns[before], columns[after])
        return np.column_stack([columns[name] for name in "xyz"])


class Crystal(Table):
    """An anisotropic elastic body; its key is the physical surface group of the mesh."""

    elastic: Elastic = Field(description="Elastic constants, in place of young and poisson.")
    orientation: Orientation = Field(
        default=Orientation(),
        description="Orientation of the crystal; without it its axes are those of the model.",
    )
    density: Density = None
    expansion: Expansion = None
    reference_temperature: Reference = None
    material: Material = None
    temperature: At = None

    @model_validator(mode="before")
    @classmethod
    def _either(cls, value: Any) -> Any:
        given = value if isinstance(value, dict) else {}
        isotropic = [key for key in ("young", "poisson") if key in given]
        if isotropic:
            crystal = [key for key in ("elastic", "orientation") if key in given]
            raise ValueError(
                "expected either 'young' and 'poisson', or 'elastic' and perhaps an 'orientation' "
                f"of a crystal, found {' and '.join(map(repr, isotropic + crystal))}"
            )
        return value

    @cached_property
    def stiffness(self) -> Array:
        """(6, 6) in Voigt's order, in the axes of the model."""
        from fretfe.materials.crystals import turned

        return turned(self.elastic.stiffness, self.orientation.axes.T)

    @property
    def couples_across(self) -> bool:
        """True if displacements in the plane and across it depend on each other."""
        from fretfe.materials.crystals import couples_across

        return couples_across(self.stiffness) > COUPLED


ISOTROPIC = f"{TAG}isotropic"
CRYSTAL = f"{TAG}crystal"


def _kind(value: Any) -> str:
    crystal = isinstance(value, Crystal) or (
        isinstance(value, dict) and ("elastic" in value or "orientation" in value)
    )
    return CRYSTAL if crystal else ISOTROPIC


AnyBody = Annotated[
    Annotated[Body, Tag(ISOTROPIC)] | Annotated[Crystal, Tag(CRYSTAL)], Discriminator(_kind)
]
# Why a number is not known that isotropic bodies have.
IS_CRYSTAL = "unknown, because a body is a crystal"


def isotropic(body: AnyBody) -> Body | None:
    """The body if it is isotropic, whichever way its constants are given; None for a crystal."""
    if isinstance(body, Body):
        return body
    from fretfe.materials.crystals import young_and_poisson

    found = young_and_poisson(body.stiffness)
    if found is None:
        return None
    return Body(
        young=found[0],
        poisson=found[1],
        density=body.density,
        expansion=body.expansion,
        reference_temperature=body.reference_temperature,
    )
