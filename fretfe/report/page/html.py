# SPDX-License-Identifier: LGPL-3.0-or-later
"""The report of a run: one HTML file that needs nothing else, and its plots in their order."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import tomli_w
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from rich.table import Table

from fretfe.errors import OutputError
from fretfe.files import disk_reason, replace_text
from fretfe.history.solution import Solution
from fretfe.quality.validate.single import own_rows
from fretfe.quality.validate.solids import solid_rows
from fretfe.report.figures import cycles, edges, history, slip, solids, solver, stress, tractions
from fretfe.report.figures.plot import Plot
from fretfe.report.page.answer import edge_answers, summary
from fretfe.report.page.glossary import Glossary, subscripts
from fretfe.report.page.tables import (
    contact_table,
    cycle_table,
    limit_table,
    mesh_table,
    station_table,
    timing_table,
)
from fretfe.report.pictures.folder import read_pictures
from fretfe.report.source import Shown, force_unit, shown_contacts
from fretfe.report.texts import number
from fretfe.results.model import Result
from fretfe.results.reader import load_result
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


@dataclass(frozen=True)
class Section:
    """Some plots below a heading.

    Attributes:
        anchor: of the heading.
        title: the heading.
        intro: how to read the plots, or why there are none.
        plots: the plots.
    """

    anchor: str
    title: str
    intro: str
    plots: tuple[Plot, ...]


@dataclass(frozen=True)
class Plots:
    """All plots of the page.

    Attributes:
        sections: what was computed.
        solver: how the steps were solved, and the meshes.
    """

    sections: tuple[Section, ...]
    solver: tuple[Plot, ...]


def draw_plots(run: Result) -> Plots:
    """Everything that is drawn from the results but pictures of bodies."""
    return Plots(_sections(run), _solver_plots(run))


def _sections(run: Result) -> tuple[Section, ...]:
    if len(run.loads.times) < 2:
        return ()
    if run.solid:
        return _solid_sections(run)
    shown = shown_contacts(run)
    histories = (
        _section("factors", "Edge factors", history.FACTORS_INTRO, _factors(run)),
        _section("loads", "Loads", history.LOADS_INTRO, _loads(run)),
    )
    if not shown:
        none = f"The backend {run.backend} gives no tractions along the contact."
        return (Section("tractions", "Along the contacts", none, ()), *histories)
    asymptotes = (edges.edge_plot(each, edge) for each in shown for edge in each.summary.stations)
    counted = (cycles.cycle_plot(each, edge) for each in shown for edge in each.summary.stations)
    sections = (
        _section(
            "tractions", "Along the contacts", tractions.INTRO, map(tractions.traction_plot, shown)
        ),
        _section("edges", "Next to the edges", edges.INTRO, asymptotes),
        _section("slip", "Stick and slip", _slip_intro(run), map(slip.slip_plot, shown)),
        _section("cycles", "Counted cycles", cycles.INTRO, counted),
        _section(
            "local", "Local parameters", tractions.LOCAL_INTRO, map(tractions.local_plot, shown)
        ),
        _section(
            "stress", "Stress next to the edges", stress.INTRO, map(stress.stress_plot, shown)
        ),
        *histories,
        _section("loops", "Hysteresis", history.LOOPS_INTRO, _loops(run, shown)),
    )
    return tuple(section for section in sections if section.plots)


def _slip_intro(run: Result) -> str:
    """Legend of the maps, and of the envelopes where there are any."""
    edges = [edge for contact in run.contacts for edge in contact.stations]
    irregular = any(edge.cycles.irregular for edge in edges)
    return slip.INTRO + (slip.ENVELOPE_INTRO if irregular else "")


def _solid_sections(run: Result) -> tuple[Section, ...]:
    shown = shown_contacts(run)
    sections = (
        _section("fronts", "Along the fronts", solids.FRONTS_INTRO, _fronts(run)),
        _section("areas", "Contacts over time", solids.AREAS_INTRO, _areas(run)),
        _section("loads", "Loads", "Shaded: the evaluated cycle.", [history.load_plot(run)]),
        _section("loops", "Hysteresis", history.SOLID_LOOPS_INTRO, _loops(run, shown)),
    )
    return tuple(section for section in sections if section.plots)


def _fronts(run: Result) -> Iterable[Plot]:
    for place, contact in enumerate(run.contacts):
        for row, front in enumerate(contact.fronts):
            yield solids.front_plot(run, contact, front, f"contact{place}-{row}")


def _areas(run: Result) -> Iterable[Plot]:
    for place, contact in enumerate(run.contacts):
        yield solids.force_plot(run, contact, f"contact{place}")
        yield solids.area_plot(run, contact, f"contact{place}")


def _solver_plots(run: Result) -> tuple[Plot, ...]:
    plots: list[Plot | None] = []
    if run.solution is not None and len(run.loads.times) > 1:
        plots += [solver.iteration_plot(run.solution), solver.certificate_plot(run.solution)]
    if run.refinement is not None:
        plots.append(solver.refinement_plot(run.refinement))
    return tuple(plot for plot in plots if plot is not None)


def _factors(run: Result) -> Iterable[Plot]:
    for place, contact in enumerate(run.contacts):
        yield history.factor_plot(run, contact, f"contact{place}")


def _loads(run: Result) -> Iterable[Plot | None]:
    yield history.load_plot(run)
    for place, contact in enumerate(run.contacts):
        yield history.path_plot(run, contact, f"contact{place}")


def _loops(run: Result, shown: Sequence[Shown]) -> Iterable[Plot | None]:
    yield from map(history.slip_loop_plot, shown)
    yield from history.work_loop_plots(run)


def _section(anchor: str, title: str, intro: str, plots: Iterable[Plot | None]) -> Section:
    return Section(anchor, title, intro, tuple(plot for plot in plots if plot is not None))


def write_report(directory: Path, plots: Plots | None = None) -> Path:
    """Make the report from the results in a folder, and return its file.

    Args:
        directory: results folder.
        plots: as `draw_plots` made them from these results; None draws them.

    Raises:
        OutputError: if the folder has no complete set of results, or the file cannot be written:
            the report before stays.
    """
    html = render(directory, plots)
    path = directory / REPORT
    try:
        replace_text(path, html)
    except OSError as error:
        raise OutputError(f"{path}: cannot write the report: {disk_reason(error)}") from error
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
    glossary = Glossary(solid=run.solid)
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
        contacts=contact_table(run),
        cycles=cycle_table(run),
        fronts=station_table(run) if run.solid else None,
        works=[
            f"{contact.name} {number(contact.dissipation)}"
            for contact in run.contacts
            if math.isfinite(contact.dissipation)
        ],
        pictures=pictures,
        plots=plots or draw_plots(run),
        certificate=_certificate_rows(run),
        checks=(*own_rows(run), *solid_rows(run)) if _solved(run.solution) else (),
        meshes=_mesh_tables(run),
        timings=timing_table(run.seconds),
        case_text=_case_text(run),
        terms=glossary.terms,
    )


def _solved(solution: Solution | None) -> bool:
    """True if there is a state besides the unloaded one; true without tractions."""
    return solution is None or len(solution.times) > 1


def _certificate_rows(run: Result) -> list[tuple[str, str, str]]:
    """Conditions, by how much they are violated at most in any step, and over their scale."""
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
