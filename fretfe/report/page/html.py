# SPDX-License-Identifier: LGPL-3.0-or-later
"""The report of a run: one HTML file that needs nothing else, and its plots in their order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import tomli_w
from jinja2 import Environment, StrictUndefined, Template
from markupsafe import Markup
from rich.table import Table

from fretfe.caution import grouped
from fretfe.errors import CaseError, FretfeError, ModelError
from fretfe.evaluate.contacts import Contact, Front, Station, worst_of
from fretfe.evaluate.limits import ModelLimit
from fretfe.faults import Fault, guarded
from fretfe.files import replace_text, writing
from fretfe.history.solution import Solution
from fretfe.plugins import SECTIONS, plug_ins, what
from fretfe.quality.rows import Row, own_rows
from fretfe.report.figures import edges, history, tractions
from fretfe.report.page.bodies import body_table, pair_table
from fretfe.report.page.ends import end_tables
from fretfe.report.page.glossary import Glossary, subscripts
from fretfe.report.page.tables import (
    contact_table,
    cycle_table,
    edge_answers,
    range_name,
    refinement_tables,
    station_table,
    summary,
    timing_table,
    work_words,
)
from fretfe.report.pictures.folder import read_pictures
from fretfe.report.source import Shown, shown_contacts
from fretfe.report.texts import number, plain_table, with_error
from fretfe.report.theme import Plot
from fretfe.results.end_answers import read_answers
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import REPORT

# Draws a figure, or some.
Draw = Callable[[], "Plot | list[Plot] | None"]
At = tuple[Contact, Front, Station]
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
        missing: plots that fretfe failed to draw, and why.
    """

    anchor: str
    title: str
    intro: str
    plots: tuple[Plot, ...]
    missing: tuple[str, ...] = ()


# What was computed, in the order of the page.
Sections = tuple[Section, ...]


def draw_plots(run: Result, stations: Sequence[str] = ()) -> Sections:
    """Everything that is drawn from the results but pictures of bodies.

    Args:
        run: the results.
        stations: names of stations of solids that are drawn beside the worst one of each contact.

    Raises:
        FretfeError: if there is no such station, or no plane problem for it.
    """
    failed: list[Fault] = []
    chosen = [_chosen(run, name) for name in stations]
    sections = guarded("figures", lambda: _sections(run, chosen), failed.append) or ()
    if failed:
        sections = (Section("figures", "Figures", "None could be drawn.", (), (failed[0].text,)),)
    return sections + tuple(_by_others(run))


def _by_others(run: Result) -> Iterator[Section]:
    """Sections of other packages; one that fails says so in its place."""
    for each in plug_ins(SECTIONS):
        anchor = f"section-{each.name}"
        try:
            made = each.call(run)
        except FretfeError as error:
            yield Section(anchor, each.name, str(error), ())
            continue
        wrong = f"{each.title}: expected a Section, found {what(made)}"
        good = isinstance(made, Section)
        yield replace(made, anchor=anchor) if good else Section(anchor, each.name, wrong, ())


def _chosen(run: Result, name: str) -> At:
    """A station of solids with its contact and front.

    Raises:
        CaseError: if there is no such station.
        OutputError: if the results are not complete.
        ModelError: if there is no plane problem for the station.
    """
    if not run.solid:
        raise CaseError(
            f"{run.directory or run.case.source}: --station: expected results of solids, found "
            "those of plane bodies"
        )
    contact, front, station = run.find(name)
    if station.local.reason:
        raise ModelError(
            f"station {contact.name_of(station)}: expected its plane problem, found none: "
            f"{station.local.reason}"
        )
    return contact, front, station


def _sections(run: Result, chosen: Sequence[At]) -> tuple[Section, ...]:
    if len(run.loads.times) < 2:
        return ()
    if run.solid:
        return _solid_sections(run, chosen)
    shown, keyed = shown_contacts(run), _keyed(run)
    factors = [
        partial(history.factor_plot, run, contact, key) for key, contact in keyed if contact.edges
    ]
    paths = [partial(history.path_plot, run, contact, key) for key, contact in keyed]
    loads = partial(history.load_plot, run)
    histories = (
        _section("factors", "Edge factors", history.FACTORS_INTRO, factors),
        _section("loads", "Loads", history.LOADS_INTRO, [loads, *paths]),
    )
    stations = [(each, edge) for each in shown for edge in each.summary.edges]
    asymptotes = [partial(edges.edge_plot, *each) for each in stations]
    loops: list[Draw] = [
        *_each(history.slip_loop_plot, shown),
        partial(history.work_loop_plots, run),
    ]
    counted = [partial(edges.cycle_plot, *each) for each in stations]
    irregular = any(edge.cycles.irregular for each in run.contacts for edge in each.stations)
    slip_intro = tractions.SLIP_INTRO + (tractions.ENVELOPE_INTRO if irregular else "")
    sections = (
        _section(
            "tractions",
            "Along the contacts",
            tractions.INTRO,
            _each(tractions.traction_plot, shown),
        ),
        _section("edges", "Next to the edges", edges.INTRO, asymptotes),
        _section("slip", "Stick and slip", slip_intro, _each(tractions.slip_plot, shown)),
        _section("cycles", "Counted cycles", edges.CYCLES_INTRO, counted),
        _section(
            "local", "Local parameters", tractions.LOCAL_INTRO, _each(tractions.local_plot, shown)
        ),
        _section(
            "stress",
            "Stress next to the edges",
            tractions.STRESS_INTRO,
            _each(tractions.stress_plot, shown),
        ),
        _section(
            "slip-systems",
            "Resolved shear on slip systems",
            tractions.SLIP_SYSTEMS_INTRO,
            _each(tractions.slip_system_plot, shown),
        ),
        *histories,
        _section("loops", "Hysteresis", history.LOOPS_INTRO, loops),
    )
    return tuple(section for section in sections if section.plots or section.missing)


def _solid_sections(run: Result, chosen: Sequence[At]) -> tuple[Section, ...]:
    shown, keyed = shown_contacts(run), _keyed(run)
    loops: list[Draw] = [
        *_each(history.slip_loop_plot, shown),
        partial(history.work_loop_plots, run),
    ]
    fronts = [
        partial(edges.front_plot, run, contact, front, f"{key}-{row}")
        for key, contact in keyed
        for row, front in enumerate(contact.fronts)
    ]
    found = [
        partial(edges.end_plot, run, answer, f"end{row}")
        for row, answer in enumerate(read_answers(run))
    ]
    areas = [
        partial(draw, run, contact, key)
        for key, contact in keyed
        for draw in (edges.force_plot, edges.area_plot)
    ]
    loads = [partial(history.load_plot, run)]
    sections = (
        _section("fronts", "Along the fronts", edges.FRONTS_INTRO, fronts),
        _section("ends", "Free ends", edges.ENDS_INTRO, found),
        _section(
            "stations",
            "Next to the worst stations",
            edges.STATIONS_INTRO,
            _station_draws(shown, chosen),
        ),
        _section("areas", "Contacts over time", edges.AREAS_INTRO, areas),
        _section("loads", "Loads", "Shaded: the evaluated cycle.", loads),
        _section("loops", "Hysteresis", history.SOLID_LOOPS_INTRO, loops),
    )
    return tuple(section for section in sections if section.plots or section.missing)


def _station_draws(shown: Iterable[Shown], chosen: Sequence[At]) -> list[Draw]:
    """Draws the worst station of each contact, then others, none of them twice."""
    draws: dict[str, Draw] = {}
    for each in shown:
        fronts, name_of = each.summary.fronts, each.summary.name_of
        solved = (s for front in fronts for s in front.defined if s.local.tractions)
        stations = [worst_of(solved), *(at[2] for at in chosen if at[0] is each.summary)]
        for station in filter(None, stations):
            front = next(front for front in fronts if front.name == station.front)
            draws[name_of(station)] = partial(edges.station_plot, each, front, station)
    return list(draws.values())


def _keyed(run: Result) -> list[tuple[str, Contact]]:
    """The contacts with what starts the ids of their plots."""
    return [(f"contact{place}", contact) for place, contact in enumerate(run.contacts)]


def _each(draw: Callable[[Shown], Plot | None], shown: Iterable[Shown]) -> list[Draw]:
    return [partial(draw, each) for each in shown]


def _section(anchor: str, title: str, intro: str, plots: Sequence[Draw]) -> Section:
    """A section with the plots that there are; one that fretfe fails to draw costs no other."""
    drawn: list[Plot] = []
    failed: list[Fault] = []
    for place, draw in enumerate(plots, start=1):
        name = f"figure {place} of {len(plots)} in {title!r}"
        found = guarded(name, draw, failed.append)
        some = found if isinstance(found, list) else (found,)
        drawn += [plot for plot in some if plot is not None]
    return Section(anchor, title, intro, tuple(drawn), tuple(fault.text for fault in failed))


def write_report(directory: Path, plots: Sections | None = None) -> Path:
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
    with writing(path, "the report"):
        replace_text(path, html)
    return path


def render(directory: Path, plots: Sections | None = None) -> str:
    """The report of the results in a folder, as HTML; arguments as for `write_report`.

    Raises:
        OutputError: if the folder has no complete set of results.
    """
    run, pictures = load_result(directory), read_pictures(directory)
    ranges = range_name(run)
    glossary = Glossary(solid=run.solid, across=ranges == "|ΔK|")
    answers = guarded("answers for edges", lambda: edge_answers(run), lambda _: ())
    return render_page(
        "report.html.j2",
        linked=glossary.linked,
        run=run,
        case=run.case,
        units=run.case.units,
        answers=answers,
        with_error=with_error,
        ranges=ranges,
        summary=guarded("summary", lambda: summary(run), lambda fault: (fault.text,)),
        contacts=_table("table of contacts", lambda: contact_table(run)),
        cycles=_table("table of counted cycles", lambda: cycle_table(run)),
        fronts=_table("table of fronts", lambda: station_table(run)) if run.solid else None,
        ends=guarded("tables of free ends", lambda: end_tables(run), lambda _: []),
        works=[
            f"{contact.name} {work_words(contact)}"
            for contact in run.contacts
            if math.isfinite(contact.dissipation)
        ],
        pictures=pictures,
        plots=draw_plots(run) if plots is None else plots,
        certificate=guarded("certificate", lambda: _certificate_rows(run), lambda _: []),
        limits=_nearest_limits(run),
        checks=guarded("checks of this run", lambda: _checks(run), lambda _: ()),
        meshes=refinement_tables(run.refinement),
        bodies=_table("table of bodies", lambda: body_table(run)),
        pairs=_table("table of contact surfaces", lambda: pair_table(run)),
        faults=run.faults,
        warnings=grouped(run.warnings),
        timings=timing_table(run.seconds),
        # The case as it was understood.
        case_text=tomli_w.dumps(run.case.as_tables()),
        terms=glossary.terms,
    )


def _table(name: str, make: Callable[[], Table | None]) -> Table | None:
    """A table, or an empty one whose title says why fretfe has not made it."""
    return guarded(name, make, lambda fault: plain_table(fault.text, ("",), text=1))


def _nearest_limits(run: Result) -> list[ModelLimit]:
    """Of each quantity the limit that is exceeded most, not measured, or else nearest."""
    limits: dict[str, list[ModelLimit]] = {}
    for limit in run.limits:
        limits.setdefault(limit.quantity, []).append(limit)
    return [
        max(each, key=lambda one: (one.exceeded, math.isnan(one.found), one.used))
        for each in limits.values()
    ]


def render_page(name: str, **content: Any) -> str:
    """A page in the style of all of them: a template of this package with its content."""
    shown = {"linked": subscripts, **content}
    return _template(name).render(style=Markup(_text("report.css")), **shown)


@cache
def _template(name: str) -> Template:
    """A page, for all runs of a process: to compile it takes a tenth of a second."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters.update(svg=Markup, number=number, grid=_grid, subscripts=subscripts)
    return environment.from_string(_text("macros.html.j2") + _text(name))


def _text(name: str) -> str:
    """A file of this package."""
    return files("fretfe.report.page").joinpath(name).read_text(encoding="utf-8")


def _checks(run: Result) -> tuple[Row, ...]:
    return tuple(own_rows(run)) if _solved(run.solution) else ()


def _solved(solution: Solution) -> bool:
    """True if there is a state besides the unloaded one."""
    return len(solution.times) > 1


def _certificate_rows(run: Result) -> list[tuple[str, str, str]]:
    """Conditions, by how much they are violated at most in any step, and over their scale."""
    solution, units = run.solution, run.case.units
    if not _solved(solution):
        return []
    parts = solution.certificates
    kinds = {
        "length": (units.length, parts["gap_scale"].max()),
        "stress": (units.stress, parts["pressure_scale"].max()),
        "force": (run.unit("force"), parts["force_scale"].max()),
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
