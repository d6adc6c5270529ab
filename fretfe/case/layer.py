# SPDX-License-Identifier: LGPL-3.0-or-later
"""A layer between the surfaces of a contact that gives under tractions, in a case file."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from fretfe.case.base import Positive, Table, Text

STIFFNESS = ("normal", "tangential")
COATING = ("thickness", "young", "poisson")


class Layer(Table):
    """Linear layer, such as a coating or an interface whose stiffness was measured."""

    normal: Positive | None = Field(
        default=None, description="Pressure per approach of the surfaces, in stress per length."
    )
    tangential: Positive | None = Field(
        default=None, description="Shear per displacement along the surface, in stress per length."
    )
    thickness: Positive | None = Field(
        default=None, description="Of a coating, thin against the contact; length."
    )
    young: Positive | None = Field(default=None, description="Young's modulus of the coating.")
    poisson: float | None = Field(
        default=None, ge=0, lt=0.5, description="Poisson's ratio of the coating."
    )

    csv: Text | None = Field(
        default=None,
        description="Text file with the columns normal and tangential and with arc, or with x, y "
        "(and z), relative to the folder of the case file.",
    )

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if self.model_fields_set not in ({*STIFFNESS}, {*COATING}, {"csv"}):
            raise ValueError(
                f"expected either {' and '.join(STIFFNESS)}, or {', '.join(COATING[:-1])} and "
                f"{COATING[-1]}, or csv, found "
                f"{', '.join(sorted(self.model_fields_set)) or 'none of them'}"
            )
        return self

    @property
    def compliances(self) -> tuple[float, float]:
        """Approach per pressure, and displacement along the surface per shear; 0 if it varies.

        A coating is much stiffer along the surface than across (Johnson, Contact Mechanics, 1985,
        section 5.8): thin against the contact it is compressed without stretching, by p t / M with
        M = E (1 - nu) / ((1 + nu) (1 - 2 nu)), and sheared by q t / G.
        """
        if self.normal is not None and self.tangential is not None:
            return 1 / self.normal, 1 / self.tangential
        if self.thickness is None:
            return 0.0, 0.0
        assert self.young is not None
        assert self.poisson is not None
        shear = self.young / (2 * (1 + self.poisson))
        compressed = 2 * shear * (1 - self.poisson) / (1 - 2 * self.poisson)
        return self.thickness / compressed, self.thickness / shear
