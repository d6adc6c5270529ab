# SPDX-License-Identifier: LGPL-3.0-or-later
"""The plots of the page in their order, with the reasons where there are none."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from fretfe.report.figures import (
    areas,
    cycles,
    edges,
    fronts,
    history,
    local,
    loops,
    slip,
    solver,
    stress,
    tractions,
)
from fretfe.report.figures.plot import Plot
from fretfe.report.source import Shown, ShownArea, shown_areas, shown_contacts
from fretfe.results.model import Result


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
    if run.areas:
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
        _section("local", "Local parameters", local.INTRO, map(local.local_plot, shown)),
        _section(
            "stress", "Stress next to the edges", stress.INTRO, map(stress.stress_plot, shown)
        ),
        *histories,
        _section("loops", "Hysteresis", loops.INTRO, _loops(run, shown)),
    )
    return tuple(section for section in sections if section.plots)


def _slip_intro(run: Result) -> str:
    """How to read the maps, and the envelopes where there are any."""
    edges = [edge for contact in run.contacts for edge in contact.stations]
    irregular = any(edge.cycles.irregular for edge in edges)
    return slip.INTRO + (slip.ENVELOPE_INTRO if irregular else "")


def _solid_sections(run: Result) -> tuple[Section, ...]:
    sections = (
        _section("fronts", "Along the fronts", fronts.INTRO, _fronts(run)),
        _section("areas", "Contacts over time", areas.INTRO, _areas(run)),
        _section("loads", "Loads", "Shaded: the evaluated cycle.", [history.load_plot(run)]),
        _section("loops", "Hysteresis", loops.SOLID_INTRO, _loops(run, shown_areas(run))),
    )
    return tuple(section for section in sections if section.plots)


def _fronts(run: Result) -> Iterable[Plot]:
    for place, area in enumerate(run.areas):
        for number, front in enumerate(area.fronts):
            yield fronts.front_plot(run, area, front, f"contact{place}-{number}")


def _areas(run: Result) -> Iterable[Plot]:
    for place, area in enumerate(run.areas):
        yield areas.force_plot(run, area, f"contact{place}")
        yield areas.area_plot(run, area, f"contact{place}")


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


def _loops(run: Result, shown: Sequence[Shown | ShownArea]) -> Iterable[Plot | None]:
    yield from map(loops.slip_loop_plot, shown)
    yield from loops.work_loop_plots(run)


def _section(anchor: str, title: str, intro: str, plots: Iterable[Plot | None]) -> Section:
    return Section(anchor, title, intro, tuple(plot for plot in plots if plot is not None))
