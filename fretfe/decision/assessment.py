# SPDX-License-Identifier: LGPL-3.0-or-later
"""An assessment: the answers of criteria for the bodies at edges and fronts of a result."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from fretfe.case import Units
from fretfe.decision.damage import Damage
from fretfe.decision.short_cracks import Arrest
from fretfe.strength.fit import Survival


class Criterion(Enum):
    """Criteria, in the order in which they are listed."""

    TESTS = "fretting tests"
    ARREST = "arrest of cracks"
    POINT = "SWT, point"
    LINE = "SWT, line"
    AREA = "SWT, area"
    CROSSLAND = "Crossland, point"
    DANG_VAN = "Dang Van, point"
    FINDLEY = "Findley, point"


@dataclass(frozen=True)
class OtherCriterion:
    """A criterion of another package, by its name."""

    value: str


Rule = Criterion | OtherCriterion


@dataclass(frozen=True)
class Judgement:
    """The answer of one criterion.

    Attributes:
        criterion: of it.
        margin: factor of all stresses; NaN where unknown, infinite where no factor breaks it.
        low, high: ends of an interval that holds it: by the bars of the edge and of the stress, and
            by extremes within steps, of tests by their scatter too; NaN where unknown, 0 below one
            that is `outermost`.
        place: worst place along the surface, inward from the edge; NaN where it is the edge.
        reason: why the margin is unknown; empty if it is known.
        outermost: whether it is worst at the first or last place that is judged, and so may be less
            beyond: there it is a matter of the body rather than of the edge.
        station: worst one of a front of solids; -1 in the plane.
        end: name of the free end whose sub-model has this station; empty if the run has it.
        to_end: its distance from that.
    """

    criterion: Rule
    margin: float = math.nan
    low: float = math.nan
    high: float = math.nan
    place: float = math.nan
    reason: str = ""
    outermost: bool = False
    station: int = -1
    end: str = ""
    to_end: float = math.nan

    @property
    def at_station(self) -> tuple[str, int]:
        """The free end whose sub-model has its station, empty for the run, and its number."""
        return self.end, self.station


@dataclass(frozen=True)
class EdgeAssessment:
    """One body at one edge, or at one front of solids: its worst stations.

    Attributes:
        contact, edge, body: their names.
        friction: coefficient of the contact; NaN if it varies.
        judgements: one for each criterion, in the order of `Criterion`, then of other packages.
        arrest: of cracks; None where it is not known.
        life: cycles of the deepest crack between the lengths of the material file; NaN where
            unknown.
        bar: relative error of stresses by the bars of K_N and ΔK_T; NaN where one is unknown.
        spread: error of the stress beside that of the tractions [stress].
        survival: probability to reach the life of the tests; None without tests that say so.
        damage: of counted cycles; None without lives of smooth specimens.
        lost: stations of the front that are not judged, by the reason; without those of ends that
            have a sub-model.
        depth: to which the stress is looked at; NaN where it is unknown.
        element: size of an element at the edge; NaN where the stress is unknown.
        straight: least radius of the front, and distance from its ends, of the stations judged:
            down to depths short against it fields are plane. Infinite in the plane.
        single_steps: whether P changes in single steps between turns of the loads, within which
            extremes of stress are unknown: margins have no intervals.
    """

    contact: str
    edge: str
    body: str
    friction: float
    judgements: tuple[Judgement, ...]
    arrest: Arrest | None
    life: float
    bar: float
    spread: float
    survival: Survival | None = None
    damage: Damage | None = None
    lost: dict[str, tuple[int, ...]] = field(default_factory=dict)
    depth: float = math.nan
    element: float = math.nan
    straight: float = math.inf
    single_steps: bool = False

    @property
    def solid(self) -> bool:
        """True of a front of solids."""
        return any(each.station >= 0 for each in self.judgements)

    @property
    def governing(self) -> Judgement | None:
        """The one with the smallest margin; None if none is known."""
        known = [each for each in self.judgements if not each.reason]
        return min(known, key=lambda each: each.margin, default=None)

    def of(self, criterion: Rule) -> Judgement:
        """The answer of one criterion."""
        return next(each for each in self.judgements if each.criterion == criterion)


@dataclass(frozen=True)
class Assessment:
    """All edges of a result.

    Attributes:
        result: its folder.
        material: file of the data.
        source: of them.
        length: L of critical distances; NaN where unknown.
        edges: of both bodies of each contact.
        remarks: what to know about all of it.
        units: of lengths and stresses.
        others: of other results of these edges, such as with other friction.
    """

    result: str
    material: Path
    source: str
    length: float
    edges: tuple[EdgeAssessment, ...]
    remarks: tuple[str, ...]
    units: Units
    others: tuple[Assessment, ...] = ()

    def range_of(self, edge: EdgeAssessment, criterion: Rule) -> tuple[float, float]:
        """Least and largest margin over all results; NaN without others, or unknown in one."""
        name = edge.contact, edge.edge, edge.body
        own = [edge.of(criterion)]
        for other in self.others:
            own += [
                each.of(criterion) for each in other.edges
                if (each.contact, each.edge, each.body) == name
            ]  # fmt: skip
        if not self.others or len(own) <= len(self.others) or any(each.reason for each in own):
            return math.nan, math.nan
        margins = [each.margin for each in own]
        return min(margins), max(margins)

    def keeps(self, margin: float) -> bool:
        """True if every edge and station of all results is judged, and has this margin at least."""
        every = self, *self.others
        edges = [each for one in every for each in one.edges]
        governing = [each.governing for each in edges]
        kept = all(
            each is not None and each.margin >= margin and not each.outermost for each in governing
        )
        return kept and all(one.edges for one in every) and not any(each.lost for each in edges)

    @property
    def frictions(self) -> tuple[float, float]:
        """Smallest and largest coefficient of friction of any result."""
        every = [each.friction for one in (self, *self.others) for each in one.edges]
        found = [each for each in every if math.isfinite(each)]
        return min(found, default=math.nan), max(found, default=math.nan)

    @property
    def worst(self) -> tuple[EdgeAssessment, Judgement] | None:
        """The edge with the smallest margin and that; None if none is known."""
        known = [(each, each.governing) for each in self.edges]
        found = [(edge, judgement) for edge, judgement in known if judgement is not None]
        return min(found, key=lambda each: each[1].margin, default=None)
