# SPDX-License-Identifier: LGPL-3.0-or-later
"""The loads of a case file: each is one channel, driven by one scalar history."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from fretfe.case.base import (
    TAG,
    Axis,
    Direction,
    Number,
    SurfaceDirection,
    Table,
    Text,
    Vector,
)
from fretfe.case.histories import Segment


class Channel(Table):
    """Base of all loads: each has a history."""

    history: tuple[Segment, ...] = Field(
        min_length=1,
        description="Segments in the order of time, on the clock of the case, which starts at 0 "
        "with the value 0. After the last segment the value stays.",
    )


class PlatenLoad(Channel):
    """A boundary that moves as one rigid piece and does not turn, unless it has a tilt."""

    type: Literal["platen"] = Field(description='"platen": a rigid, guided boundary.')
    boundary: Text = Field(description="Physical group of the boundary.")
    direction: Direction = Field(
        description='Direction of force or displacement: "x", "y", "z" or a vector (its length '
        "does not matter). Directions of a platen without a load are held."
    )
    control: Literal["force", "displacement"] = Field(
        description='What the history prescribes: "force", the total force on the platen for the '
        'whole thickness, in force units, or "displacement", in length units; positive along '
        "direction."
    )


class TiltLoad(Channel):
    """A platen that turns about an axis as well."""

    type: Literal["tilt"] = Field(description='"tilt": a rigid boundary that turns about an axis.')
    boundary: Text = Field(
        description="Physical group of the boundary, a platen. Without a platen load of its own it "
        "is held in every direction, and about every axis without a tilt."
    )
    axis: Direction = Field(
        default="z",
        description='Axis that it turns about, anticlockwise: "x", "y", "z" or a vector (its '
        'length does not matter); "z" in a plane model.',
    )
    centre: tuple[Number, ...] = Field(
        min_length=2, max_length=3, description="A point on the axis, in length units."
    )
    control: Literal["moment", "rotation"] = Field(
        description='What the history prescribes: "moment", about the axis for the whole '
        'thickness, in force times length units (0 lets the platen tilt freely), or "rotation", in '
        "radians."
    )


class TractionLoad(Channel):
    """A uniform traction on a boundary."""

    type: Literal["traction"] = Field(description='"traction": force per area on a boundary.')
    boundary: Text = Field(description="Physical group of the boundary.")
    direction: SurfaceDirection = Field(
        description='"normal" (outward, so that a positive value pulls), "x", "y", "z" or a vector '
        "(its length does not matter). The history is in stress units."
    )


class DisplacementLoad(Channel):
    """One prescribed displacement component of a boundary; the others stay free."""

    type: Literal["displacement"] = Field(
        description='"displacement": one prescribed displacement component.'
    )
    boundary: Text = Field(description="Physical group of the boundary.")
    direction: Axis = Field(
        description='Component that is prescribed: "x", "y" or "z". The history is in length units.'
    )


class RotationLoad(Channel):
    """Centrifugal body force density * omega^2 * r in all bodies."""

    type: Literal["rotation"] = Field(
        description='"rotation": centrifugal body force, density * omega^2 * distance from the '
        "axis. The history is omega, in radians per time unit."
    )
    centre: tuple[Number, ...] = Field(
        min_length=2, max_length=3, description="A point on the axis, in length units."
    )
    axis: Vector = Field(
        default=(0.0, 0.0, 1.0),
        description="Direction of the axis (its length does not matter); [0, 0, 1] in a plane "
        "model.",
    )


Load = PlatenLoad | TiltLoad | TractionLoad | DisplacementLoad | RotationLoad
LOADS: dict[str, type[Channel]] = {
    "platen": PlatenLoad,
    "tilt": TiltLoad,
    "traction": TractionLoad,
    "displacement": DisplacementLoad,
    "rotation": RotationLoad,
}


def _load_type(load: Any) -> str | None:
    """Tag of a raw load, None if its type is missing or unknown."""
    kind = load.get("type") if isinstance(load, dict) else getattr(load, "type", None)
    return f"{TAG}{kind}" if isinstance(kind, str) and kind in LOADS else None


AnyLoad = Annotated[
    Annotated[PlatenLoad, Tag(f"{TAG}platen")]
    | Annotated[TiltLoad, Tag(f"{TAG}tilt")]
    | Annotated[TractionLoad, Tag(f"{TAG}traction")]
    | Annotated[DisplacementLoad, Tag(f"{TAG}displacement")]
    | Annotated[RotationLoad, Tag(f"{TAG}rotation")],
    Discriminator(_load_type),
]
