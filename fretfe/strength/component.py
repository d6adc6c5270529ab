# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges of computed components as points in the plane of K_N and ΔK_T."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fretfe.case import Body
from fretfe.edges.area import AreaSummary
from fretfe.edges.front import ContactSummary, Station
from fretfe.edges.solid_fronts import SolidStation
from fretfe.errors import CaseError
from fretfe.results.model import Result

# f ΔK_I over ΔK_T above which the normal load varies, and turning above which (K_T, K_S) does.
SMALL = 0.05


@dataclass(frozen=True)
class ComponentEdge:
    """An edge of a plane contact, or a station of a front of solids.

    Attributes:
        result: folder of the result.
        contact: its name.
        edge: left or right; of solids the front.
        station: number along the front; 0 in the plane.
        k_n, k_n_spread: K_N in the last state, and error bar; NaN where not known.
        k_t_range, k_t_range_spread: range of K_T over the evaluated cycle, of solids that of
            (K_T, K_S) along its main direction, and error bar; NaN where not known.
        friction: coefficient of the contact.
        bodies: of the contact.
        obstacle: why its strength cannot be judged; empty if it can.
        remarks: what tests at constant P and of equal cycles do not cover.
    """

    result: str
    contact: str
    edge: str
    station: int
    k_n: float
    k_n_spread: float
    k_t_range: float
    k_t_range_spread: float
    friction: float
    bodies: tuple[Body, ...]
    obstacle: str
    remarks: tuple[str, ...]

    @property
    def name(self) -> str:
        """All of it, in words."""
        return " ".join((self.result, self.contact, self.edge))


def component_edges(results: Sequence[Result]) -> tuple[ComponentEdge, ...]:
    """All edges of results, those of solids without ends of fronts.

    Raises:
        CaseError: if the units of the results differ.
    """
    units = {result.case.units for result in results}
    if len(units) > 1:
        listed = "; ".join(", ".join(each.model_dump().values()) for each in units)
        raise CaseError(f"expected results in the same units, found {listed}")
    labels = result_labels(results)
    return tuple(
        edge
        for result, label in zip(results, labels, strict=True)
        for edge in (*_plane_edges(result, label), *_solid_stations(result, label))
    )


def result_labels(results: Sequence[Result]) -> list[str]:
    """Names of folders, or paths where names are the same."""
    folders = [each.directory for each in results]
    names = [
        folder.name if folder else each.case.title
        for folder, each in zip(folders, results, strict=True)
    ]
    return [
        str(folder) if folder and names.count(name) > 1 else name
        for folder, name in zip(folders, names, strict=True)
    ]


def _plane_edges(result: Result, label: str) -> Iterator[ComponentEdge]:
    for contact in result.contacts:
        for edge in contact.stations:
            remarks = []
            if edge.cycles.irregular:
                remarks.append(
                    "the loads are irregular: judged is the range over the whole cycle, other "
                    "counted cycles do no damage here"
                )
            if not contact.steady:
                remarks.append("the cycle is not steady")
            yield _edge(result, label, contact, edge, remarks)


def _solid_stations(result: Result, label: str) -> Iterator[ComponentEdge]:
    for area in result.areas:
        for front in area.fronts:
            for station in front.judged:
                remarks = []
                if station.turning > SMALL:
                    remarks.append(
                        f"(K_T, K_S) turns: the range across its direction is {station.turning:.0%}"
                    )
                yield _edge(result, label, area, station, remarks)


def _edge(
    result: Result,
    label: str,
    contact: ContactSummary | AreaSummary,
    edge: Station | SolidStation,
    remarks: list[str],
) -> ComponentEdge:
    pair = contact.pair
    friction = result.case.contacts[pair].friction
    k_n, k_t_range = edge.told_k_n, edge.told_range
    spread = edge.k_range_spread if isinstance(edge, SolidStation) else edge.k_t_range_spread
    if k_t_range > 0 and friction * edge.k_i_range > SMALL * k_t_range:
        share = friction * edge.k_i_range / k_t_range
        remarks.append(f"P varies: f ΔK_I is {share:.0%} of ΔK_T, which the tests do not cover")
    return ComponentEdge(
        result=label, contact=contact.name, edge=edge.front, station=edge.number,
        k_n=k_n, k_n_spread=float(edge.k_n_spread[-1]),
        k_t_range=k_t_range, k_t_range_spread=float(spread),
        friction=friction, bodies=_bodies(result, pair),
        obstacle=_obstacle(result, k_n, k_t_range), remarks=tuple(remarks),
    )  # fmt: skip


def _bodies(result: Result, pair: str) -> tuple[Body, ...]:
    """The two bodies of a contact; all of the case if a result does not tell which they are."""
    named = result.solution.contacts if result.solution is not None else ()
    for each in named:
        if each.pair == pair:
            return result.case.bodies[each.body1], result.case.bodies[each.body2]
    return tuple(result.case.bodies.values())


def _obstacle(result: Result, k_n: float, k_t_range: float) -> str:
    if result.failure is not None:
        return "the run is not complete"
    if not math.isfinite(k_n):
        return "K_N is not known, or its error bar is more than half of it"
    if result.loads.cycle is None:
        return "there is no evaluated cycle"
    if not math.isfinite(k_t_range):
        return "ΔK_T is not known, or its error bar is more than half of it"
    if not k_t_range > 0:
        return "ΔK_T is zero"
    return ""
