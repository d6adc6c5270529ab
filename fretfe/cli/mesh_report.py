# SPDX-License-Identifier: LGPL-3.0-or-later
"""Texts about the mesh of a case for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from fretfe.case import Case
from fretfe.mesh.elements import PLURALS
from fretfe.mesh.groups import BodySummary, mesh_summary
from fretfe.mesh.mesh import Mesh
from fretfe.surface.checks import initial_gaps, place
from fretfe.surface.quality import (
    ContactQuality,
    SurfaceQuality,
    contact_quality,
    mesh_warnings,
)


def print_mesh(console: Console, case: Case, mesh: Mesh) -> None:
    """Print size and quality of the bodies and the contacts, and what may spoil the results."""
    bodies = mesh_summary(mesh)
    unit = case.units.length
    console.print(_body_table(bodies))
    contacts = contact_quality(initial_gaps(mesh, case))
    measure = "length" if mesh.dimension == 2 else "area"
    console.print(_surface_table(contacts, unit, measure))
    console.print(_gap_table(contacts, unit, measure))
    for warning in mesh_warnings(bodies, contacts, unit):
        console.print(f"Warning: {warning}", highlight=False, markup=False)
    for note in mesh.notes:
        console.print(f"Note: {note}", highlight=False, markup=False)


def _table(title: str, headers: Sequence[str], text: int) -> Table:
    """An empty table whose first `text` columns hold text and the others numbers."""
    table = Table(title=title, title_justify="left", box=box.SIMPLE, pad_edge=False)
    table.padding = (0, 1, 0, 0)
    for number, header in enumerate(headers):
        table.add_column(header, justify="left" if number < text else "right", overflow="fold")
    return table


def _body_table(bodies: Sequence[BodySummary]) -> Table:
    headers = ("body", "elements", "nodes", "order", "smallest angle [°]")
    table = _table("Bodies", headers, text=1)
    for body in bodies:
        table.add_row(
            body.name,
            f"{body.elements} {PLURALS[body.cell]}",
            str(body.nodes),
            str(body.order),
            f"{body.smallest_angle:.1f}",
        )
    return table


def _surface_table(contacts: Sequence[ContactQuality], unit: str, measure: str) -> Table:
    title = f"Contact surfaces: {measure}s, element sizes h and radii of curvature R in {unit}"
    headers = ("contact", "surface", measure, "facing", "min h", "max h", "R", "R/h")
    table = _table(title, headers, text=2)
    for contact in contacts:
        for number, surface in enumerate(contact.surfaces):
            table.add_row("" if number else contact.name, surface.name, *_surface_cells(surface))
    return table


def _surface_cells(surface: SurfaceQuality) -> list[str]:
    straight = math.isinf(surface.radius)
    return [
        f"{surface.measure:.4g}",
        f"{surface.opposite} of {surface.facets}",
        f"{surface.smallest:.3g}",
        f"{surface.largest:.3g}",
        "flat" if straight else f"{surface.radius:.3g}",
        "inf" if straight else f"{surface.per_radius:.3g}",
    ]


def _gap_table(contacts: Sequence[ContactQuality], unit: str, measure: str) -> Table:
    headers = ("contact", measure, "gap", "overlap", "at", "size ratio")
    table = _table(f"Before any load: smallest gap or largest overlap in {unit}", headers, text=1)
    for contact in contacts:
        table.add_row(
            contact.name,
            f"{contact.measure:.4g}",
            f"{contact.gap:.3g}",
            f"{contact.interpenetration:.3g}",
            place(contact.nearest, 4),
            f"{contact.size_ratio:.2f}",
        )
    return table
