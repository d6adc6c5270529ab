# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coefficients of friction of a case file that are no numbers but tables."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Discriminator, Field, Tag, model_validator

from fretfe.case.base import (
    TAG,
    NotNegative,
    Number,
    Separator,
    Table,
    Temperature,
    Text,
    require_increasing,
)

Coefficients = Annotated[
    tuple[NotNegative, ...],
    Field(min_length=1, description="Coefficients, one for each; straight lines between them."),
]


class OverTime(Table):
    """Coefficient over time."""

    times: tuple[NotNegative, ...] = Field(
        min_length=1, description="Times on the clock of the case, increasing."
    )
    values: Coefficients

    @model_validator(mode="after")
    def _increasing(self) -> Self:
        require_increasing("times", self.times, self.values)
        return self


class OverArc(Table):
    """Coefficient along the surface of a plane contact."""

    arc: tuple[Number, ...] = Field(
        min_length=2,
        description="Arc lengths along the surface, as results have them, increasing.",
    )
    values: Coefficients

    @model_validator(mode="after")
    def _increasing(self) -> Self:
        require_increasing("arc", self.arc, self.values)
        return self


class OverPressure(Table):
    """Coefficient over the contact pressure, at each node that in the state before the step."""

    pressure: tuple[NotNegative, ...] = Field(
        min_length=2, description="Contact pressures, increasing from 0."
    )
    values: Coefficients

    @model_validator(mode="after")
    def _increasing_from_nothing(self) -> Self:
        require_increasing("pressure", self.pressure, self.values)
        if self.pressure[0] > 0:
            raise ValueError(f"expected pressures from 0 on, found {self.pressure[0]:g} first")
        return self


class OverHeat(Table):
    """Coefficient over the temperature of the surfaces, by the loads that heat the bodies."""

    temperature: tuple[Temperature, ...] = Field(
        min_length=2, description="Mean temperatures of both surfaces, increasing."
    )
    values: Coefficients

    @model_validator(mode="after")
    def _increasing(self) -> Self:
        require_increasing("temperature", self.temperature, self.values)
        return self


class InFile(Table):
    """Coefficient from the column `friction` of a CSV file, over one of the above, or at places."""

    csv: Text = Field(
        description="Text file with the column friction and with time, pressure, temperature, arc, "
        "or x, y (and z), relative to the folder of the case file."
    )
    separator: Separator = None


VARYING: dict[str, type[Table]] = {
    "times": OverTime,
    "arc": OverArc,
    "pressure": OverPressure,
    "temperature": OverHeat,
    "csv": InFile,
}
NUMBER = f"{TAG}number"
# Tags of the tables: loads have tables with the same keys.
TAGS = {f"{TAG}{key}:friction": table for key, table in VARYING.items()}


def friction_kind(value: Any) -> str | None:
    """Tag of a raw coefficient: that of a number, or the key that only this kind of table has."""
    if isinstance(value, Table):
        return next(tag for tag, kind in TAGS.items() if type(value) is kind)
    if not isinstance(value, dict):
        return NUMBER
    return next((tag for tag, key in zip(TAGS, VARYING, strict=True) if key in value), None)


Friction = Annotated[
    Annotated[NotNegative, Tag(NUMBER)]
    | Annotated[OverTime, Tag(f"{TAG}times:friction")]
    | Annotated[OverArc, Tag(f"{TAG}arc:friction")]
    | Annotated[OverPressure, Tag(f"{TAG}pressure:friction")]
    | Annotated[OverHeat, Tag(f"{TAG}temperature:friction")]
    | Annotated[InFile, Tag(f"{TAG}csv:friction")],
    Discriminator(friction_kind),
]
