# SPDX-License-Identifier: LGPL-3.0-or-later
"""A layer between the surfaces of a contact that gives under tractions, in a case file."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Self

from pydantic import Field, model_validator

from fretfe.case.base import NotNegative, Positive, Table, Text, require_increasing

STIFFNESS = ("normal", "tangential")
CURVE = ("pressure", "approach", "tangential")
COATING = ("thickness", "young", "poisson")


class Layer(Table):
    """Layer, such as a coating or rough surfaces, whose stiffness was measured."""

    normal: Positive | None = Field(
        default=None, description="Pressure per approach of the surfaces, in stress per length."
    )
    tangential: Positive | None = Field(
        default=None, description="Shear per displacement along the surface, in stress per length."
    )
    pressure: tuple[NotNegative, ...] | None = Field(
        default=None,
        min_length=3,
        description="Pressures from 0 on, increasing, at which the approach of the surfaces is "
        "given, in place of 'normal'.",
    )
    approach: tuple[NotNegative, ...] | None = Field(
        default=None, description="Approach at each pressure, increasing from 0; length."
    )
    thickness: Positive | None = Field(
        default=None, description="Of a coating, thin against the contact; length."
    )
    young: Positive | None = Field(default=None, description="Young's modulus of the coating.")
    poisson: Annotated[float, Field(strict=True, ge=0, lt=0.5)] | None = Field(
        default=None, description="Poisson's ratio of the coating."
    )

    csv: Text | None = Field(
        default=None,
        description="Text file with the columns normal and tangential and with arc, or with x, y "
        "(and z), relative to the folder of the case file.",
    )

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if self.model_fields_set not in ({*STIFFNESS}, {*COATING}, {*CURVE}, {"csv"}):
            listed = (f"{', '.join(each[:-1])} and {each[-1]}" for each in (COATING, CURVE))
            raise ValueError(
                f"expected either {' and '.join(STIFFNESS)}, or {', or '.join(listed)}, or csv, "
                f"found {', '.join(sorted(self.model_fields_set)) or 'none of them'}"
            )
        if self.pressure is not None and self.approach is not None:
            for name, values in (("pressure", self.pressure), ("approach", self.approach)):
                require_increasing(name, values, self.pressure)
                if values[0] > 0:
                    raise ValueError(f"expected a {name} of 0 first, found {values[0]:g}")
        return self

    @property
    def slopes(self) -> tuple[float, ...]:
        """Approach per pressure between those that are given."""
        assert self.pressure is not None
        assert self.approach is not None
        pairs = zip(pairwise(self.approach), pairwise(self.pressure), strict=True)
        return tuple((b - a) / (q - p) for (a, b), (p, q) in pairs)

    @property
    def curve(self) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        """Pressures, and the approach beyond that of the linear part; it goes on as it ends."""
        if self.pressure is None or self.approach is None:
            return None
        far = 1000 * self.pressure[-1]
        end = self.approach[-1] + self.slopes[-1] * (far - self.pressure[-1])
        pressures, linear = (*self.pressure, far), self.compliances[0]
        rest = zip((*self.approach, end), pressures, strict=True)
        return pressures, tuple(each - linear * pressure for each, pressure in rest)

    @property
    def compliances(self) -> tuple[float, float]:
        """Approach per pressure, and displacement along the surface per shear; 0 if it varies.

        Of a curve the approach is that of its linear part, the mean slope to the last pressure.
        A coating is much stiffer along the surface than across (Johnson, Contact Mechanics, 1985,
        section 5.8): thin against the contact it is compressed without stretching, by p t / M with
        M = E (1 - nu) / ((1 + nu) (1 - 2 nu)), and sheared by q t / G.
        """
        if self.normal is not None and self.tangential is not None:
            return 1 / self.normal, 1 / self.tangential
        if self.approach is not None and self.pressure is not None and self.tangential is not None:
            return self.approach[-1] / self.pressure[-1], 1 / self.tangential
        if self.thickness is None:
            return 0.0, 0.0
        assert self.young is not None
        assert self.poisson is not None
        shear = self.young / (2 * (1 + self.poisson))
        compressed = 2 * shear * (1 - self.poisson) / (1 - 2 * self.poisson)
        return self.thickness / compressed, self.thickness / shear
