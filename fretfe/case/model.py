# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case as a whole, and its JSON schema."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Self

from pydantic import Field, PrivateAttr, model_validator

from fretfe.case.base import Name, Table
from fretfe.case.channels import AnyLoad
from fretfe.case.checks import Problem, cross_problems
from fretfe.case.tables import Body, Contact, Cycle, Edges, Geometry, Model, Output, Support, Units


class Contradiction(ValueError):
    """Tables that are valid one by one but not together."""

    def __init__(self, problems: list[Problem]) -> None:
        """Keep the problems, all of them."""
        super().__init__("; ".join(problem.text for problem in problems))
        self.problems = problems


class Case(Table):
    """Everything that a case file says."""

    title: str = Field(
        default="", strict=True, max_length=1000, description="Title, shown in the output."
    )
    units: Units = Field(default=Units(), description="Labels of the units used in the file.")
    model: Model = Field(default=Model(), description="Plane state, thickness, discretisation.")
    geometry: Geometry = Field(description="Where the mesh comes from.")
    bodies: dict[Name, Body] = Field(
        min_length=2, description="Bodies; the key is the physical surface group of the mesh."
    )
    contacts: dict[Name, Contact] = Field(
        min_length=1, description="Contacts, by names that you choose."
    )
    supports: dict[Name, Support] = Field(
        default={}, description="Held boundaries, by names that you choose."
    )
    loads: dict[Name, AnyLoad] = Field(
        default={},
        description="Loads, by names that you choose; each is one channel with one history.",
    )
    cycle: Cycle = Field(
        default=Cycle(),
        description="The cycle to evaluate; without it the last period of the slowest wave.",
    )
    edges: Edges = Field(
        default=Edges(),
        description="Accuracy of the edge factors; without a tolerance the mesh is that of the "
        "geometry.",
    )
    output: Output = Field(
        default=Output(), description="What is written in addition to the results."
    )

    _source: Path = PrivateAttr(default=Path("case.toml"))
    _trust_geo: bool = PrivateAttr(default=False)

    @model_validator(mode="after")
    def _no_contradictions(self) -> Self:
        problems = cross_problems(self.bodies, self.contacts, self.supports, self.loads)
        if problems:
            raise Contradiction(problems)
        return self

    @property
    def source(self) -> Path:
        """The case file; what it names is relative to its folder."""
        return self._source

    @property
    def trust_geo(self) -> bool:
        """True if a .geo file that the case names may run: the caller says so, never the file."""
        return self._trust_geo

    def resolve(self, file: str) -> Path:
        """Path of a file that the case names."""
        return self._source.parent / file


def case_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a case file, with a description of every key."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Case.model_json_schema(),
    }
