# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shared by all tables of a case file: numbers, names, directions, and parts of geometry files."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import PurePath
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    StrictInt,
    Tag,
    model_validator,
)

from fretfe.case.toml_file import plain_value
from fretfe.errors import CaseError

# Tags mark which alternative of a table was read. The prefix cannot start a key of a case file that
# passes, so that messages can tell tags from keys.
TAG = "::"

# Products and squares of a few such numbers can be computed; no unit makes them larger or smaller.
LARGEST = 1e30
SMALLEST = 1e-30
# Steps of a load, or cycles: far more than can be solved.
MOST_STEPS = 1_000_000


def _not_tiny(value: float) -> float:
    if value < SMALLEST:
        raise ValueError(f"expected a number of {SMALLEST:g} or more, found {value:g}")
    return value


def _zero_or_not_tiny(value: float) -> float:
    if 0 < abs(value) < SMALLEST:
        raise ValueError(f"expected 0, or a number of {SMALLEST:g} or more, found {value:g}")
    return value


_Finite = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
Number = Annotated[_Finite, AfterValidator(_zero_or_not_tiny)]
Positive = Annotated[_Finite, Field(gt=0), AfterValidator(_not_tiny)]
NotNegative = Annotated[Number, Field(ge=0)]
# Degrees Celsius, or kelvins where the reference is in kelvins too: colder is nothing.
ABSOLUTE_ZERO = -273.15
Temperature = Annotated[_Finite, Field(ge=ABSOLUTE_ZERO)]
Count = Annotated[int, Field(strict=True, ge=1, le=MOST_STEPS)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_-]*$", max_length=100)]
Text = Annotated[str, Field(strict=True, min_length=1, max_length=1000)]
Point = Annotated[tuple[Number, ...], Field(min_length=2, max_length=3)]
Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, ...] = ("x", "y", "z")
# The last two are about the axis of a sector.
HeldAlong = Literal["x", "y", "z", "radial", "tangential"]


def positive_number(key: str, value: object) -> float:
    """Return a number that a program gives, if a case may have it where it has to be > 0.

    Raises:
        CaseError: if it is none, with the key.
    """
    number = plain_value(value)
    valid = isinstance(number, int | float) and not isinstance(number, bool)
    if not (valid and SMALLEST <= number <= LARGEST):
        raise CaseError(
            f"{key}: expected a number > 0, from {SMALLEST:g} to {LARGEST:g}, found {value!r}"
        )
    return float(number)


# What Python reads besides, 1_0 and nan and digits of other scripts, is a slip of the pen.
WRITTEN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)


def written_number(text: str) -> float:
    """The number that a text is, like 3, -0.5 or 1e-3; NaN if it is none."""
    return float(text) if WRITTEN.fullmatch(text) else math.nan


Separator = Annotated[
    Literal[",", ";", "tab", "space"] | None,
    Field(
        description='What stands between the cells: ",", ";", "tab" or "space"; without it that is '
        "told from the header row."
    ),
]


class Table(BaseModel):
    """A table of the case file: read once, never changed, no unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def require_increasing(name: str, places: Sequence[float], values: Sequence[float]) -> None:
    """Check that there are as many values as times or places, and that these increase.

    Raises:
        ValueError: with the first ones that do not.
    """
    if len(places) != len(values):
        raise ValueError(f"expected as many values as {name}, {len(places)}, found {len(values)}")
    for number, (before, after) in enumerate(pairwise(places), 1):
        if after <= before:
            raise ValueError(
                f"expected strictly increasing {name}, found {before:g} followed by {after:g} "
                f"(items {number} and {number + 1})"
            )


def _normalised(vector: tuple[float, ...]) -> tuple[float, ...]:
    length = math.hypot(*vector)
    if length == 0:
        raise ValueError("expected a direction of non-zero length, found a zero vector")
    return tuple(component / length for component in vector)


def _named_or_vector(value: Any) -> str:
    return f"{TAG}vector" if isinstance(value, list | tuple) else f"{TAG}name"


Vector = Annotated[
    tuple[Number, ...], Field(min_length=2, max_length=3), AfterValidator(_normalised)
]
Direction = Annotated[
    Annotated[Axis, Tag(f"{TAG}name")] | Annotated[Vector, Tag(f"{TAG}vector")],
    Discriminator(_named_or_vector),
]
SurfaceDirection = Annotated[
    Annotated[Literal["normal", "x", "y", "z"], Tag(f"{TAG}name")]
    | Annotated[Vector, Tag(f"{TAG}vector")],
    Discriminator(_named_or_vector),
]


def unit_vector(direction: str | tuple[float, ...], dimension: int) -> tuple[float, ...]:
    """Components of a direction of a case file.

    Args:
        direction: an axis name, or a normalised vector of 2 or 3 components.
        dimension: number of components wanted, at least as many as the direction has.

    Returns:
        Unit vector of ``dimension`` components.
    """
    if isinstance(direction, str):
        return tuple(float(axis == direction) for axis in AXES[:dimension])
    return direction + (0.0,) * (dimension - len(direction))


def _colour(value: str) -> str:
    digits = value.removeprefix("#")
    if len(value) != 7 or len(digits) != 6 or set(digits.lower()) - set("0123456789abcdef"):
        raise ValueError(f"expected a colour as in '#ff0000', found {value!r}")
    return value.lower()


Colour = Annotated[Text, AfterValidator(_colour)]


class Selector(Table):
    """Parts of a geometry file that a name of the case stands for."""

    point: Point | None = Field(
        default=None,
        description="A point in a face, or nearest to it or to a curve; in a volume, or nearest to "
        "it or to a face, with three coordinates, of solid bodies.",
    )
    points: tuple[Point, ...] | None = Field(
        default=None, min_length=1, description="Several such points: one part for each."
    )
    label: Text | None = Field(default=None, description="Name in the file.")
    color: Colour | None = Field(default=None, description="Colour in the file, as '#ff0000'.")
    tag: StrictInt | None = Field(default=None, description="Number of the group in the file.")
    tags: tuple[StrictInt, ...] | None = Field(
        default=None, min_length=1, description="Several such numbers."
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if len(self.ways) != 1:
            found = " and ".join(map(repr, self.ways)) or "none"
            raise ValueError(f"expected exactly one of {_listed(WAYS)}, found {found}")
        return self

    @property
    def ways(self) -> tuple[str, ...]:
        """The keys that choose something: one, in a selector that is valid."""
        return tuple(way for way in WAYS if getattr(self, way) is not None)

    @property
    def all_points(self) -> tuple[tuple[float, ...], ...]:
        """The points, however many; none with another way."""
        return (self.point,) if self.point is not None else self.points or ()

    @property
    def all_tags(self) -> tuple[int, ...]:
        """The numbers, however many; none with another way."""
        return (self.tag,) if self.tag is not None else self.tags or ()


class BoundarySelector(Selector):
    """Parts of a geometry file that the name of a boundary stands for."""

    body: Text | None = Field(
        default=None,
        description="Only curves or faces of this body: where bodies touch, a point is as near to "
        "both.",
    )


WAYS = ("point", "points", "label", "color", "tag", "tags")


@dataclass(frozen=True)
class FileKind:
    """A kind of geometry file.

    Attributes:
        text: what it is, for messages.
        suffixes: how its name ends.
        keys: of [geometry] that go with it.
        ways: of choosing bodies and boundaries in it.
        named: whether the bodies have to be chosen.
    """

    text: str
    suffixes: tuple[str, ...]
    keys: tuple[str, ...] = ()
    ways: tuple[str, ...] = ()
    named: bool = False


GMSH_MESH = FileKind("Gmsh mesh", (".msh",), ("merge", "solid"))
GMSH_SCRIPT = FileKind("Gmsh script", (".geo",), ("parameters", "order", "solid"))
CAD = FileKind(
    "CAD file",
    (".step", ".stp", ".brep"),
    ("size", "order", "bodies", "boundaries", "solid"),
    ("point", "points", "label", "color"),
    named=True,
)
XDMF = FileKind(
    "XDMF mesh",
    (".xdmf",),
    ("facets", "merge", "bodies", "boundaries", "solid"),
    ("tag", "tags"),
    named=True,
)
ABAQUS = FileKind(
    "Abaqus or CalculiX mesh",
    (".inp",),
    ("merge", "bodies", "boundaries", "solid"),
    ("label",),
)
FILE_KINDS = (GMSH_MESH, GMSH_SCRIPT, CAD, XDMF, ABAQUS)


def file_kind(file: str) -> FileKind:
    """The kind of a geometry file, from how its name ends.

    Raises:
        ValueError: it ends like nothing that can be read.
    """
    suffix = PurePath(file).suffix.lower()
    for kind in FILE_KINDS:
        if suffix in kind.suffixes:
            return kind
    known = "; ".join(f"{kind.text}: {', '.join(kind.suffixes)}" for kind in FILE_KINDS)
    raise ValueError(f"expected a file name that ends in one of ({known}), found {file!r}")


def file_problem(
    file: str,
    keys: Iterable[str],
    bodies: Mapping[str, Selector],
    boundaries: Mapping[str, BoundarySelector],
) -> str | None:
    """Reason why tables of [geometry] do not fit the kind of its file, or None.

    Args:
        file: name of the file.
        keys: given besides it.
        bodies: selectors of [geometry.bodies].
        boundaries: selectors of [geometry.boundaries].
    """
    kind = file_kind(file)
    if wrong := sorted(set(keys) - set(kind.keys)):
        return f"{_listed(wrong)} cannot be given with {file!r} ({kind.text})"
    for table, selectors in (("bodies", bodies), ("boundaries", boundaries)):
        for name, selector in selectors.items():
            if selector.ways[0] not in kind.ways:
                return (
                    f"{table}.{name}: expected {_listed(kind.ways)} for {file!r} ({kind.text}), "
                    f"found {selector.ways[0]!r}"
                )
    if kind is not CAD and (
        named := [name for name, each in boundaries.items() if each.body is not None]
    ):
        return f"boundaries.{named[0]}: expected 'body' with a {CAD.text} only"
    if kind.named and not bodies:
        return (
            f"expected a table [geometry.bodies] that names the bodies of {file!r} by "
            f"{_listed(kind.ways)}, found none"
        )
    return None


def _listed(names: Iterable[str]) -> str:
    return ", ".join(map(repr, names))
