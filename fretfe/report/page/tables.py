# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables for the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from rich.table import Table

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.edges.area import AreaSummary
from fretfe.edges.front import ContactSummary, SlipZone, Station
from fretfe.edges.refinement import Refinement, StationValues, changes_by_kind
from fretfe.report.page.listings import plain_table
from fretfe.report.texts import MISSING, number, percent


def edge_table(case: Case, contacts: tuple[ContactSummary, ...]) -> Table:
    """One row per contact edge, with the slip zones of the last two half cycles.

    The prediction follows the load loop where there is a cycle, else it is that of first loading.
    """
    units = case.units
    title = (
        f"Contact edges: x and slip zones in {units.length}, "
        f"K_N in {units.stress}/√{units.length}, ΔK_T in {units.stress}·√{units.length}"
    )
    headers = ("contact", "edge", "x", "K_N", "ΔK_T", "slip zones", "predicted")
    table = plain_table(title, headers, text=2)
    for contact in contacts:
        for edge in contact.stations:
            table.add_row(contact.name, edge.front, *_edge_cells(edge))
    return table


def _edge_cells(edge: Station) -> list[str]:
    zones = edge.slip_zones[-2:]
    measured = [_zone_length(zone) for zone in zones]
    return [
        number(edge.position[-1]),
        _marked(number(edge.told_k_n), edge.uncertain),
        _marked(number(edge.told_range), edge.uncertain_range),
        " / ".join(measured) or MISSING,
        " / ".join(number(zone.prediction, 3) for zone in zones) or MISSING,
    ]


def _zone_length(zone: SlipZone) -> str:
    """Length of a slip zone; ~ marks one that the mesh does not resolve well."""
    if zone.gross:
        return "gross"
    return _marked(number(zone.told_length, 3), not zone.resolved)


def _marked(text: str, uncertain: bool) -> str:
    """A number with ~ before it if it is uncertain; what is missing carries no mark."""
    return f"~{text}" if uncertain and text != MISSING else text


def contact_table(
    case: Case, evaluated: tuple[int, int] | None, contacts: tuple[ContactSummary, ...]
) -> Table:
    """One row per contact: ranges of forces over the cycle and whether the cycle is steady.

    Args:
        case: for the units.
        evaluated: first and last state of the cycle; None for all states.
        contacts: the contacts.
    """
    units = case.units
    title = f"Contacts: P, Q in {units.force}/{units.length}, half-width in {units.length}"
    headers = ("contact", "P", "Q", "half-width", "steady", "Δq/(f p_max)")
    table = plain_table(title, headers, text=1)
    cycle = slice(evaluated[0], evaluated[1] + 1) if evaluated else slice(None)
    for contact in contacts:
        table.add_row(
            contact.name,
            _range(contact.normal_force[cycle]),
            _range(contact.shear_force[cycle]),
            number(contact.half_width[-1]),
            _steady(contact),
            number(contact.cycle_change),
        )
    return table


def area_table(
    case: Case, evaluated: tuple[int, int] | None, areas: tuple[AreaSummary, ...]
) -> Table:
    """One row per contact of solids: forces over the cycle, areas at its end.

    Args:
        case: for the units.
        evaluated: first and last state of the cycle; None for all states.
        areas: the contacts.
    """
    units = case.units
    title = (
        f"Contacts: P, |Q| in {units.force}, areas at the end in {units.length}², largest "
        f"pressure in {units.stress}, friction work in {units.force}·{units.length}"
    )
    headers = ("contact", "P", "|Q|", "in contact", "sticks", "p_max", "work", "steady")
    table = plain_table(title, headers, text=1)
    cycle = slice(evaluated[0], evaluated[1] + 1) if evaluated else slice(None)
    for area in areas:
        table.add_row(
            area.name,
            _range(area.normal_force[cycle]),
            _range(np.linalg.norm(area.shear_force[cycle], axis=1)),
            number(area.contact_area[-1]),
            number(area.stick_area[-1]),
            number(area.largest_pressure[cycle].max()),
            number(area.dissipation),
            _steady(area),
        )
    return table


def _steady(contact: ContactSummary | AreaSummary) -> str:
    if not math.isfinite(contact.cycle_change):
        return MISSING
    return "yes" if contact.steady else "no"


def mesh_table(refinement: Refinement) -> Table:
    """One row per mesh of a run that refined its mesh itself, with the changes from the last."""
    headers = ("mesh", "unknowns", "smallest element", "K_N", "K_T", "slip zones")
    table = plain_table("Changes from mesh to mesh", headers, text=0)
    before: tuple[StationValues, ...] = ()
    for place, done in enumerate(refinement.passes, start=1):
        changes = changes_by_kind(before, done.stations)
        table.add_row(
            str(place),
            str(done.unknowns),
            number(done.smallest_element, 3),
            *(percent(change) for change in changes[:2]),
            percent(changes[2]) if any(edge.slip for edge in done.stations) else MISSING,
        )
        before = done.stations
    return table


def limit_table(refinement: Refinement) -> Table:
    """What the values at each edge tend to over the sequence of meshes."""
    headers = ("contact", "edge", "K_N", "K_T", "slip zones")
    table = plain_table("Limits that the meshes tend to", headers, text=2)
    for edge, limits in refinement.limits:
        slip = " / ".join(number(limit, 3) for limit in limits[2:])
        table.add_row(edge.contact, edge.front, *map(number, limits[:2]), slip or MISSING)
    return table


def timing_table(seconds: Mapping[str, float]) -> Table:
    """Wall time of each phase, in the order of their start."""
    table = plain_table("Timings", ("phase", "seconds"), text=1)
    for phase, value in seconds.items():
        table.add_row(phase, f"{value:.3f}")
    table.add_row("total", f"{sum(seconds.values()):.3f}")
    return table


def _range(values: Array) -> str:
    return f"{number(values.min())} … {number(values.max())}"
