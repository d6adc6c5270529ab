# SPDX-License-Identifier: LGPL-3.0-or-later
"""The report of a run: one HTML file that needs nothing else, and its plots in their order.

Its terms are explained as in the glossary of the documents, `docs/glossary.md`: a heading of the
third level for each term, below it the explanation. An installed package has it in the folder of
this module.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import tomli_w
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup, escape
from rich.table import Table

from fretfe.errors import OutputError
from fretfe.evaluate.contacts import Contact
from fretfe.files import disk_reason, replace_text
from fretfe.history.solution import Solution
from fretfe.quality.rows import own_rows
from fretfe.report.figures import edges, history, solver, tractions
from fretfe.report.page.bodies import body_table, pair_table
from fretfe.report.page.tables import (
    contact_table,
    cycle_table,
    edge_answers,
    range_name,
    refinement_tables,
    station_table,
    summary,
    timing_table,
)
from fretfe.report.pictures.folder import read_pictures
from fretfe.report.source import force_unit, shown_contacts
from fretfe.report.texts import number
from fretfe.report.theme import Plot
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
# Terms of every page, of pages of plane bodies, and of pages of solids.
TERMS = {
    *("Body 1, body 2", "State, step, cycle", "Half cycle", "Pressure, shear", "Friction bound"),
    *("Stick and slip", "Partial slip, gross slip", "Full stick", "Patch", "Edge factor", "K_N"),
    *("K_T", "K_I", "Slip zone", "Error bar", "Resolved", "Certificate", "Friction work"),
    "Verdict",
}
PLANE_TERMS = {"Bulk tension", "Contact edge"}
SOLID_TERMS = {"Front", "Station", "K_S"}
# Headers of tables, with the terms that explain them.
HEADERS = {
    "edge": "Contact edge",
    "front": "Front",
    "K_N": "K_N",
    "K_T": "K_T",
    "ΔK_T": "K_T",
    "mean K_T": "K_T",
    "|ΔK|": "K_S",
    "half cycle": "Half cycle",
    "d found": "Slip zone",
    "d predicted": "Slip zone",
    "slip": "Slip zone",
    "slip zones": "Slip zone",
    "predicted": "Slip zone",
    "verdict": "Verdict",
    "P": "Pressure, shear",
    "Q": "Pressure, shear",
    "|Q|": "Pressure, shear",
    "sticks": "Stick and slip",
    "steady": "State, step, cycle",
    "Δq/(f p_max)": "Friction bound",
    "work": "Friction work",
}
# A reference to another page, which a report cannot lead to, and other links.
REFERENCE, LINK = re.compile(r"\s\(\[[^]]*\]\([^)]*\)\)"), re.compile(r"\[([^]]*)\]\([^)]*\)")


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
    shown, keyed = shown_contacts(run), _keyed(run)
    factors = (history.factor_plot(run, contact, key) for key, contact in keyed)
    paths = (history.path_plot(run, contact, key) for key, contact in keyed)
    histories = (
        _section("factors", "Edge factors", history.FACTORS_INTRO, factors),
        _section("loads", "Loads", history.LOADS_INTRO, [history.load_plot(run), *paths]),
    )
    if not shown:
        none = f"The backend {run.backend} gives no tractions along the contact."
        return (Section("tractions", "Along the contacts", none, ()), *histories)
    asymptotes = (edges.edge_plot(each, edge) for each in shown for edge in each.summary.stations)
    loops = (*map(history.slip_loop_plot, shown), *history.work_loop_plots(run))
    counted = (edges.cycle_plot(each, edge) for each in shown for edge in each.summary.stations)
    irregular = any(edge.cycles.irregular for each in run.contacts for edge in each.stations)
    slip_intro = tractions.SLIP_INTRO + (tractions.ENVELOPE_INTRO if irregular else "")
    sections = (
        _section(
            "tractions", "Along the contacts", tractions.INTRO, map(tractions.traction_plot, shown)
        ),
        _section("edges", "Next to the edges", edges.INTRO, asymptotes),
        _section("slip", "Stick and slip", slip_intro, map(tractions.slip_plot, shown)),
        _section("cycles", "Counted cycles", edges.CYCLES_INTRO, counted),
        _section(
            "local", "Local parameters", tractions.LOCAL_INTRO, map(tractions.local_plot, shown)
        ),
        _section(
            "stress",
            "Stress next to the edges",
            tractions.STRESS_INTRO,
            map(tractions.stress_plot, shown),
        ),
        _section(
            "slip-systems",
            "Resolved shear on slip systems",
            tractions.SLIP_SYSTEMS_INTRO,
            map(tractions.slip_system_plot, shown),
        ),
        *histories,
        _section("loops", "Hysteresis", history.LOOPS_INTRO, loops),
    )
    return tuple(section for section in sections if section.plots)


def _solid_sections(run: Result) -> tuple[Section, ...]:
    shown, keyed = shown_contacts(run), _keyed(run)
    loops = (*map(history.slip_loop_plot, shown), *history.work_loop_plots(run))
    fronts = (
        edges.front_plot(run, contact, front, f"{key}-{row}")
        for key, contact in keyed
        for row, front in enumerate(contact.fronts)
    )
    areas = (
        draw(run, contact, key)
        for key, contact in keyed
        for draw in (edges.force_plot, edges.area_plot)
    )
    sections = (
        _section("fronts", "Along the fronts", edges.FRONTS_INTRO, fronts),
        _section(
            "stations",
            "Next to the worst stations",
            edges.STATIONS_INTRO,
            map(edges.station_plot, shown),
        ),
        _section("areas", "Contacts over time", edges.AREAS_INTRO, areas),
        _section("loads", "Loads", "Shaded: the evaluated cycle.", [history.load_plot(run)]),
        _section("loops", "Hysteresis", history.SOLID_LOOPS_INTRO, loops),
    )
    return tuple(section for section in sections if section.plots)


def _keyed(run: Result) -> list[tuple[str, Contact]]:
    """The contacts with what starts the ids of their plots."""
    return [(f"contact{place}", contact) for place, contact in enumerate(run.contacts)]


def _solver_plots(run: Result) -> tuple[Plot, ...]:
    plots: list[Plot | None] = []
    if run.solution is not None and len(run.loads.times) > 1:
        plots += [solver.iteration_plot(run.solution), solver.certificate_plot(run.solution)]
    if run.refinement is not None:
        plots.append(solver.refinement_plot(run.refinement))
    return tuple(plot for plot in plots if plot is not None)


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
    ranges = range_name(run)
    glossary = Glossary(solid=run.solid, across=ranges == "|ΔK|")
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
        ranges=ranges,
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
        checks=tuple(own_rows(run)) if _solved(run.solution) else (),
        meshes=refinement_tables(run.refinement),
        bodies=body_table(run),
        pairs=pair_table(run),
        timings=timing_table(run.seconds),
        # The case as it was understood.
        case_text=tomli_w.dumps(
            run.case.model_dump(mode="json", exclude_unset=True, exclude_none=True)
        ),
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
    parts = solution.certificates
    kinds = {
        "length": (units.length, parts["gap_scale"].max()),
        "stress": (units.stress, parts["pressure_scale"].max()),
        "force": (force_unit(run), parts["force_scale"].max()),
    }
    rows = []
    for name, (text, kind) in CERTIFICATE.items():
        unit, scale = kinds[kind]
        relative = parts[name].max() / scale if scale > 0 else math.nan
        value = f"{number(float(parts[name].max()), 2)} {unit}"
        rows.append((text, value, number(float(relative), 2)))
    return rows


def _grid(table: Table) -> dict[str, Any]:
    """Title, headers with their alignment, and rows of a table for the terminal."""
    return {
        "title": str(table.title),
        "headers": [(str(column.header), column.justify == "right") for column in table.columns],
        "rows": list(zip(*(column.cells for column in table.columns), strict=True)),
    }


@dataclass(frozen=True)
class Term:
    """A term with its explanation.

    Attributes:
        name: the term.
        text: the explanation in Markdown, without links.
    """

    name: str
    text: str

    @property
    def anchor(self) -> str:
        """Id of the explanation on the page."""
        return "term-" + re.sub(r"\W+", "-", self.name.lower())

    @property
    def hint(self) -> str:
        """The explanation as plain text."""
        return re.sub(r"[*`]", "", self.text)

    @property
    def html(self) -> Markup:
        """The explanation."""
        text = re.sub(r"\*([^*]+)\*", r"<em>\1</em>", str(subscripts(self.text)))
        return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", text))


class Glossary:
    """The terms of a page, in the order of the glossary.

    Args:
        solid: whether the bodies are solids.
        across: whether plane bodies move along z.
    """

    def __init__(self, solid: bool, across: bool = False) -> None:
        wanted = TERMS | (SOLID_TERMS if solid else PLANE_TERMS) | ({"K_S"} if across else set())
        self.terms = tuple(term for term in _read_terms() if term.name in wanted)
        self._by_name = {term.name: term for term in self.terms}

    def linked(self, header: str, unit: str = "") -> Markup:
        """A header of a table, linked to the term that explains it if there is one."""
        shown = subscripts(header) + (f" [{unit}]" if unit else "")
        term = self._by_name.get(HEADERS.get(header, ""))
        if term is None:
            return shown
        link = Markup('<a class="term" href="#{}" title="{}">{}</a>')
        return link.format(term.anchor, term.hint, shown)


def subscripts(text: str) -> Markup:
    """Escaped text in which the index of a symbol such as K_N stands lower."""
    return Markup(re.sub(r"(?<![A-Za-z_])([Kp])_(\w+)", r"\1<sub>\2</sub>", str(escape(text))))


def _read_terms() -> list[Term]:
    installed = Path(__file__).with_name("glossary.md")
    beside = Path(__file__).parents[3] / "docs" / "glossary.md"
    text = (installed if installed.is_file() else beside).read_text(encoding="utf-8")
    text = LINK.sub(r"\1", REFERENCE.sub("", text))
    entries = re.split(r"^#{2,3} ", text, flags=re.MULTILINE)[1:]
    parts = (entry.partition("\n") for entry in entries)
    return [Term(name, " ".join(explanation.split())) for name, _, explanation in parts]
