# SPDX-License-Identifier: LGPL-3.0-or-later
"""The report of a run: one HTML file that needs nothing else."""

from __future__ import annotations

import math
from importlib.resources import files
from pathlib import Path
from typing import Any

import tomli_w
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from rich.table import Table

from fretfe.errors import OutputError
from fretfe.quality.validate.single import own_rows
from fretfe.report.page.answer import edge_answers, summary
from fretfe.report.page.cycle_table import cycle_table
from fretfe.report.page.front_table import front_table
from fretfe.report.page.glossary import Glossary, subscripts
from fretfe.report.page.sections import Plots, draw_plots
from fretfe.report.page.tables import (
    area_table,
    contact_table,
    limit_table,
    mesh_table,
    timing_table,
)
from fretfe.report.pictures.folder import read_pictures
from fretfe.report.source import force_unit
from fretfe.report.texts import number
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.solution import Solution
from fretfe.results.writer import REPORT

TEMPLATE, STYLE = "report.html.j2", "report.css"
# Parts of a certificate, in the order of the page, with what they are a violation of.
CERTIFICATE = {
    "penetration": ("largest penetration", "length"),
    "closed_gap": ("largest gap of a node in contact", "length"),
    "stuck_drift": ("largest movement of a node that sticks", "length"),
    "slip_with_traction": ("largest slip along the shear, or across it", "length"),
    "adhesion": ("largest tension", "stress"),
    "open_traction": ("largest traction at an open node", "stress"),
    "cone": ("largest excess of the shear over f p", "stress"),
    "force_imbalance": ("largest sum of all forces on a body", "force"),
}


def write_report(directory: Path, plots: Plots | None = None) -> Path:
    """Make the report from the results in a folder, and return its file.

    Args:
        directory: results folder.
        plots: as `draw_plots` made them from these results; None draws them.

    Raises:
        OutputError: if the folder has no complete set of results, or the file cannot be written.
    """
    html = render(directory, plots)
    path = directory / REPORT
    try:
        path.write_text(html, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot write the report: {error.strerror}") from error
    return path


def render(directory: Path, plots: Plots | None = None) -> str:
    """The report of the results in a folder, as HTML; arguments as for `write_report`.

    Raises:
        OutputError: if the folder has no complete set of results.
    """
    run, pictures = load_result(directory), read_pictures(directory)
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    glossary = Glossary(solid=bool(run.areas))
    environment.filters.update(svg=Markup, number=number, grid=_grid)
    environment.filters.update(linked=glossary.linked, subscripts=subscripts)
    package = files("fretfe.report.page")
    template = environment.from_string(package.joinpath(TEMPLATE).read_text(encoding="utf-8"))
    answers = edge_answers(run)
    return template.render(
        style=Markup(package.joinpath(STYLE).read_text(encoding="utf-8")),
        run=run,
        case=run.case,
        units=run.case.units,
        answers=answers,
        summary=summary(run, answers),
        contacts=_contacts(run),
        cycles=cycle_table(run),
        fronts=front_table(run.case, run.areas) if _has_fronts(run) else None,
        works=[
            f"{contact.name} {number(contact.dissipation)}"
            for contact in run.summaries
            if math.isfinite(contact.dissipation)
        ],
        pictures=pictures,
        plots=plots or draw_plots(run),
        certificate=_certificate_rows(run),
        checks=tuple(own_rows(run)) if _solved(run.solution) else (),
        meshes=_mesh_tables(run),
        timings=timing_table(run.seconds),
        case_text=_case_text(run),
        terms=glossary.terms,
    )


def _contacts(run: Result) -> Table:
    """One row per contact, of plane bodies or of solids."""
    if run.areas:
        return area_table(run.case, run.loads.cycle, run.areas)
    return contact_table(run.case, run.loads.cycle, run.contacts)


def _has_fronts(run: Result) -> bool:
    return any(area.fronts for area in run.areas)


def _solved(solution: Solution | None) -> bool:
    """Whether there is a state besides the unloaded one; true without tractions."""
    return solution is None or len(solution.times) > 1


def _certificate_rows(run: Result) -> list[tuple[str, str, str]]:
    """What is violated, by how much at most in any step, and over its scale."""
    solution, units = run.solution, run.case.units
    if solution is None or not _solved(solution):
        return []
    labels = {
        "length": units.length,
        "stress": units.stress,
        "force": force_unit(run),
    }
    parts = solution.certificates
    scales = {
        "length": parts["gap_scale"],
        "stress": parts["pressure_scale"],
        "force": parts["force_scale"],
    }
    rows = []
    for name, (text, kind) in CERTIFICATE.items():
        scale = scales[kind].max()
        relative = parts[name].max() / scale if scale > 0 else math.nan
        value = f"{number(float(parts[name].max()), 2)} {labels[kind]}"
        rows.append((text, value, number(float(relative), 2)))
    return rows


def _case_text(run: Result) -> str:
    """The case as it was understood, as TOML."""
    return tomli_w.dumps(run.case.model_dump(mode="json", exclude_unset=True, exclude_none=True))


def _mesh_tables(run: Result) -> list[Table]:
    refinement = run.refinement
    return [] if refinement is None else [mesh_table(refinement), limit_table(refinement)]


def _grid(table: Table) -> dict[str, Any]:
    """Title, headers with their alignment, and rows of a table for the terminal."""
    return {
        "title": str(table.title),
        "headers": [(str(column.header), column.justify == "right") for column in table.columns],
        "rows": list(zip(*(column.cells for column in table.columns), strict=True)),
    }
