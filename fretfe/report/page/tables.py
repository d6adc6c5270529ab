# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables for the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rich import box
from rich.markup import escape
from rich.table import Table

from fretfe._typing import Array
from fretfe.backends import Installed
from fretfe.case import Case
from fretfe.edges.front import ContactSummary, SlipZone, Station
from fretfe.edges.refinement import Refinement, StationValues, changes_by_kind
from fretfe.geometry.templates import Parameter, Template
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
    table = _table(title, headers, text=2)
    for contact in contacts:
        for edge in contact.stations:
            table.add_row(contact.name, edge.front, *_edge_cells(edge))
    return table


def _table(title: str, headers: tuple[str, ...], text: int) -> Table:
    """An empty table whose first `text` columns hold text and the others numbers."""
    table = Table(title=title, title_justify="left", box=box.SIMPLE, title_style="bold")
    table.pad_edge = False
    table.padding = (0, 1, 0, 0)
    for place, header in enumerate(headers):
        table.add_column(header, justify="left" if place < text else "right", no_wrap=True)
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
    table = _table(title, headers, text=1)
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


def _steady(contact: ContactSummary) -> str:
    if not math.isfinite(contact.cycle_change):
        return MISSING
    return "yes" if contact.steady else "no"


def mesh_table(refinement: Refinement) -> Table:
    """One row per mesh of a run that refined its mesh itself, with the changes from the last."""
    headers = ("mesh", "unknowns", "smallest element", "K_N", "K_T", "slip zones")
    table = _table("Changes from mesh to mesh", headers, text=0)
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
    table = _table("Limits that the meshes tend to", headers, text=2)
    for edge, limits in refinement.limits:
        slip = " / ".join(number(limit, 3) for limit in limits[2:])
        table.add_row(edge.contact, edge.front, *map(number, limits[:2]), slip or MISSING)
    return table


def backend_table(backends: tuple[Installed, ...], case: Case | None) -> Table:
    """One row per backend: what it solves, or why it cannot be used or cannot solve the case."""
    table = Table(title="Backends", title_justify="left", box=box.SIMPLE, title_style="bold")
    for header in ("backend", "usable", "package", "what it solves, or why not"):
        table.add_column(header, overflow="fold")
    for installed in backends:
        usable, text = _usable(installed, case)
        table.add_row(installed.name, usable, installed.package, escape(text))
    return table


def _usable(installed: Installed, case: Case | None) -> tuple[str, str]:
    if installed.backend is None:
        return "no", installed.reason
    try:
        reasons = installed.backend.supports(case) if case is not None else ()
    except Exception as error:  # one backend must not hide the others
        reasons = (str(error),)
    return ("no", "\n".join(reasons)) if reasons else ("yes", installed.backend.summary)


def template_table(templates: Sequence[Template]) -> Table:
    """One row per geometry template."""
    table = _table("Templates", ("template",), text=1)
    table.add_column("geometry")
    for template in templates:
        table.add_row(template.name, escape(template.summary))
    return table


def parameter_table(template: Template) -> Table:
    """One row per parameter of a template."""
    title = f"Template {template.name}\n{escape(template.summary)}"
    table = _table(title, ("parameter", "default", "range", "unit"), text=1)
    table.add_column("meaning")
    table.columns[3].justify = "left"
    for each in template.parameters:
        limits, unit = _range_and_unit(each)
        table.add_row(each.name, f"{each.default:g}", limits, unit, escape(each.description))
    return table


def parameter_rows(template: Template) -> str:
    """The parameters of a template as a table in Markdown."""
    lines = ["| parameter | default | range | unit | meaning |", "|---|---|---|---|---|"]
    for each in template.parameters:
        limits, unit = _range_and_unit(each)
        lines.append(
            f"| `{each.name}` | {each.default:g} | {limits} | {unit} | {each.description} |"
        )
    return "\n".join(lines) + "\n"


def _range_and_unit(parameter: Parameter) -> tuple[str, str]:
    limits = f"{parameter.minimum:g} … {parameter.maximum:g}"
    unit = "" if parameter.unit == "-" else parameter.unit
    return limits + (", whole" if parameter.whole else ""), unit


def timing_table(seconds: Mapping[str, float]) -> Table:
    """Wall time of each phase, in the order of their start."""
    table = _table("Timings", ("phase", "seconds"), text=1)
    for phase, value in seconds.items():
        table.add_row(phase, f"{value:.3f}")
    table.add_row("total", f"{sum(seconds.values()):.3f}")
    return table


def _range(values: Array) -> str:
    return f"{number(values.min())} … {number(values.max())}"
