# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of solids from templates, each with smaller elements at the edge and thinner layers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from fretfe.case import Case, parse_case
from fretfe.edges.front_means import front_means
from fretfe.edges.refinement import Pass, changes_by_kind
from fretfe.fem.passes import Passes
from fretfe.geometry.templates import find_template
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result
from fretfe.surface.load import load_mesh

# Sizes of a mesh over those of the mesh before: each costs three to five times as much.
FINER = 1.4
# Parameters of templates that are element sizes in the contact.
SIZES = ("size", "edge_size", "end_size", "length_size")


def is_solid(case: Case) -> bool:
    """True if a template makes the bodies, and they are solid."""
    template = case.geometry.template
    return template is not None and (
        case.geometry.solid is not None or find_template(template).solid
    )


class SolidPasses(Passes):
    """Meshes of a template of solids, or of one that is extruded; the first is that of the case."""

    def __init__(self, case: Case, announce: Callable[[str], None]) -> None:
        super().__init__(case, announce)
        self._level = 0

    def _noted(self) -> dict[str, Any]:
        return {"level": self._level}

    def _follow(self, note: dict[str, Any]) -> None:
        self._level = note["level"]

    def _make_mesh(self) -> Mesh:
        return load_mesh(finer_case(self._case, FINER**self._level))

    def _pass(self, result: Result, mesh: Mesh) -> Pass:
        assert result.solution is not None
        values = front_means(result.areas, result.solution)
        before = self._done[-1] if self._done else None
        sizes = [
            station.size
            for area in result.areas
            for front in area.fronts
            for station in front.stations
        ]
        return Pass(
            unknowns=self._unknowns(mesh),
            smallest_element=min(sizes, default=math.nan),
            stations=values,
            resolved=bool(values) and all(math.isfinite(x) for each in values for x in each.values),
            change=max(changes_by_kind(before.stations if before else (), values)),
        )

    def _make_finer(self, result: Result, mesh: Mesh) -> None:
        self._level += 1


def finer_case(case: Case, factor: float) -> Case:
    """The same case with elements at the edge of a contact that are smaller by a factor."""
    geometry = case.geometry
    assert geometry.template is not None
    data = case.model_dump(mode="json", exclude_unset=True)
    sizes = {
        each.name: geometry.parameters.get(each.name, each.default) / factor
        for each in find_template(geometry.template).parameters
        if each.name in SIZES
    }
    data["geometry"]["parameters"] = {**geometry.parameters, **sizes}
    if geometry.solid is not None:
        data["geometry"]["solid"]["layers"] = math.ceil(geometry.solid.layers * factor - 1e-9)
    # The mesh of these sizes, which does not refine itself.
    data["edges"].pop("tolerance")
    return parse_case(data, source=case.source, trust_geo=case.trust_geo)
