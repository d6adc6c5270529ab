# SPDX-License-Identifier: LGPL-3.0-or-later
"""Segments of the histories of loads, as a case file has them."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from fretfe.case.base import (
    MOST_STEPS,
    TAG,
    Count,
    NotNegative,
    Number,
    Positive,
    Separator,
    Table,
    Text,
    require_increasing,
)


class Ramp(Table):
    """Linear change from where the channel stands to a value."""

    ramp: Number = Field(description="Value at the end of the segment.")
    until: Positive = Field(description="Time at which the segment ends.")
    steps: Count = Field(description="Number of equal load steps; >= 1.")


class Hold(Table):
    """The channel keeps its value."""

    hold: Literal[True] = Field(description="Always true: keep the value.")
    until: Positive = Field(description="Time at which the segment ends.")
    steps: Count = Field(default=1, description="Number of equal load steps; >= 1.")


class Wave(Table):
    """Periodic change: mean + amplitude * shape(2 pi (t - t0)/period + phase)."""

    wave: Literal["sine", "triangle"] = Field(
        description='Shape: "sine" or "triangle" (same zeros and peaks, straight in between).'
    )
    mean: Number = Field(default=0.0, description="Mean value.")
    amplitude: Number = Field(description="Half the range.")
    phase: Number = Field(
        default=0.0,
        description="Phase in degrees at the start of the segment: 0 starts at the mean, rising; "
        "90 at the maximum.",
    )
    period: Positive = Field(description="Time of one cycle; > 0.")
    cycles: Count = Field(description="Number of cycles; >= 1.")
    steps_per_cycle: int = Field(
        strict=True,
        ge=4,
        le=MOST_STEPS,
        description="Number of equal load steps per cycle; >= 4. The two instants of each cycle at "
        "which the wave turns are added if they do not fall on a step.",
    )


class Points(Table):
    """Points of time and value joined by straight lines."""

    times: tuple[NotNegative, ...] = Field(
        min_length=1, description="Times on the clock of the case (absolute), increasing."
    )
    values: tuple[Number, ...] = Field(min_length=1, description="Values, one for each time.")

    @model_validator(mode="after")
    def _matching_and_increasing(self) -> Self:
        require_increasing("times", self.times, self.values)
        return self


class CsvPoints(Table):
    """Points of time and value read from two columns of a CSV file."""

    csv: Text = Field(
        description="Text file with a header row and columns, relative to the folder of the case "
        "file."
    )
    time: Text = Field(description="Name of the column with the times (absolute, increasing).")
    value: Text = Field(
        description="Name of the column with the values. A unit that the file states in brackets, "
        "or in a row below the header, must be that of the load."
    )
    scale: Number = Field(
        default=1.0,
        description="Factor of the values of the file; with another one than 1 they may be in any "
        "unit.",
    )
    offset: Number = Field(
        default=0.0, description="Added to the values after they have been multiplied by scale."
    )
    repeat: Count = Field(
        default=1,
        description="How often the rows of the file are run through; >= 1. More than once the "
        "first and the last value must be the same.",
    )
    separator: Separator = None


KINDS: dict[str, type[Table]] = {
    "ramp": Ramp,
    "hold": Hold,
    "wave": Wave,
    "times": Points,
    "csv": CsvPoints,
}


def segment_kind(segment: Any) -> str | None:
    """Tag of a raw segment: the key that only this kind of segment has."""
    if isinstance(segment, Table):
        return next(f"{TAG}{key}" for key, kind in KINDS.items() if isinstance(segment, kind))
    if not isinstance(segment, dict):
        return None
    return next((f"{TAG}{key}" for key in KINDS if key in segment), None)


Segment = Annotated[
    Annotated[Ramp, Tag(f"{TAG}ramp")]
    | Annotated[Hold, Tag(f"{TAG}hold")]
    | Annotated[Wave, Tag(f"{TAG}wave")]
    | Annotated[Points, Tag(f"{TAG}times")]
    | Annotated[CsvPoints, Tag(f"{TAG}csv")],
    Discriminator(segment_kind),
]
