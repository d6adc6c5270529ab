# SPDX-License-Identifier: LGPL-3.0-or-later
"""The meshes of a case that refines itself, by what its geometry makes."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from fretfe.backends.meshes import Passes, PlanePasses, SolidPasses, without_round_off
from fretfe.backends.protocol import DEFAULTS, RunOptions
from fretfe.bodies.expected import expected_places
from fretfe.bodies.loads.files import checked_history
from fretfe.case import Case
from fretfe.case.base import CAD, file_kind
from fretfe.errors import CaseError
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.refinement import Pass
from fretfe.idealise.section import section_case
from fretfe.mesh.load import makes_solids, sweep_of
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.sections import Sweep
from fretfe.mesh.sizing import FinePlaces, apply_corner_sizes
from fretfe.results.model import Result
from fretfe.surface.checks import load_mesh

# Growth of the element size per distance from the edges of sections, which have many layers.
SWEPT_GROWTH = 0.65
# Unknowns of the largest mesh of bodies that are swept, if the case does not say: about 8 GB with
# factors on disk, by the estimate of checks. A firtree of 775 000 took 13 GB, all in memory.
SWEPT_UNKNOWNS = 1_200_000
# Share of their stations whose error bars are to be within the tolerance.
SHARE = 0.8


class SweptPasses(SolidPasses):
    """Meshes of CAD bodies that are swept: of their section, fine at its edges.

    Args:
        sweep: of the bodies.
    """

    growth = SWEPT_GROWTH

    def __init__(self, case: Case, announce: Callable[[str], None], sweep: Sweep) -> None:
        super().__init__(case, announce)
        self._sweep = sweep

    def section(self) -> PlanePasses:
        """Meshes of the section alone.

        Raises:
            CaseError: the case cannot be one of plane bodies.
        """
        case = section_case(self._case, self._sweep)
        return PlanePasses(case, lambda text: self._announce(f"section, {text}"))

    def follow(self, section: PlanePasses, result: Result) -> None:
        """Make the first mesh fine where the section has its edges by a result of its meshes."""
        self._places = section.edges(result)

    def _make_mesh(self) -> Mesh:
        if not self._done and not len(self._places.sizes):
            self._places = self._expected()
        return super()._make_mesh()

    @property
    def _largest(self) -> int:
        given = "unknowns" in self._edges.model_fields_set
        return self._edges.unknowns if given else SWEPT_UNKNOWNS

    def _fine_enough(self, before: Pass | None, last: Pass, result: Result) -> str:
        # The first mesh is for the tolerance already: a second one takes several times as long.
        stations = [each for contact in result.contacts for each in contact.stations]
        cycle = result.solution.cycle is not None
        bars = np.array([_bar(station, ranged=cycle) for station in stations])
        found = all(contact.stations for contact in result.contacts)
        if found and np.mean(bars <= self._tolerance) >= SHARE:
            return f"the error bars of {SHARE:.0%} of the stations or more are within the tolerance"
        return super()._fine_enough(before, last, result)

    def _expected(self) -> FinePlaces:
        """Fine places of the first mesh by a coarse one of the section, which is not solved."""
        try:
            case = self.section().case
        except CaseError:
            return self._places
        contacts = [(each.surface1, each.surface2) for each in case.contacts.values()]
        coarse = load_mesh(case, partial(apply_corner_sizes, contacts), section=True)
        found = expected_places(case, coarse, checked_history(case))
        return FinePlaces(*without_round_off(found.points, found.sizes))


def _bar(station: Station, *, ranged: bool) -> float:
    """The larger error bar of K_N and, in a cycle, |ΔK|, over them; infinite if one is unknown."""
    numbers = [station.decisive_k_n]
    numbers += [station.told_range] if ranged and not station.undriven else []
    known = all(size > 0 and math.isfinite(spread) for size, spread in numbers)
    return max(spread / size for size, spread in numbers) if known else math.inf


def starting_mesh(case: Case) -> Mesh:
    """The first mesh of a case that refines itself. Serial.

    Raises:
        FretfeError: as for `load_mesh`.
    """
    return passes_of(case, DEFAULTS).load()


def passes_of(case: Case, options: RunOptions) -> Passes:
    """The meshes of a case that asks for an accuracy, on rank 0."""
    file, sweep = case.geometry.file, sweep_of(case)
    if sweep is not None and file is not None and file_kind(file) is CAD:
        return SweptPasses(case, options.announce, sweep)
    kind = SolidPasses if makes_solids(case) else PlanePasses
    return kind(case, options.announce)
