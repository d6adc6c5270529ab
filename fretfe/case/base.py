# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shared by all tables of a case file: the base model, numbers, names and directions."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag

# Tags mark which alternative of a table was read. The prefix cannot start a key of a case file that
# passes, so that messages can tell tags from keys.
TAG = "::"

# Products and squares of a few such numbers can be computed; no unit makes them larger or smaller.
LARGEST, SMALLEST = 1e30, 1e-30
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
Count = Annotated[int, Field(strict=True, ge=1, le=MOST_STEPS)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_-]*$", max_length=100)]
Text = Annotated[str, Field(strict=True, min_length=1, max_length=1000)]
Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, ...] = ("x", "y", "z")


class Table(BaseModel):
    """A table of the case file: read once, never changed, no unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


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
