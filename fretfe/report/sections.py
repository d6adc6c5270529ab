# SPDX-License-Identifier: LGPL-3.0-or-later
"""The plots of the page in their order, with the reasons where there are none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from fretfe.report import plots_edges, plots_loops, plots_slip, plots_tractions
from fretfe.report.drawing import Plot
from fretfe.report.plots_edges import edge_plot
from fretfe.report.plots_history import (
    FACTORS_INTRO,
    LOADS_INTRO,
    factor_plot,
    load_plot,
    path_plot,
)
from fretfe.report.plots_loops import slip_loop_plot, work_loop_plots
from fretfe.report.plots_slip import slip_plot
from fretfe.report.plots_solver import certificate_plot, iteration_plot, refinement_plot
from fretfe.report.plots_tractions import traction_plot
from fretfe.report.states import Shown
from fretfe.results.reader import Results


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


def plot_sections(results: Results) -> tuple[Section, ...]:
    """Everything that is drawn from the results, section by section."""
    if len(results.result.history.times) < 2:
        return ()
    shown = _shown(results)
    histories = (
        _section("factors", "Edge factors", FACTORS_INTRO, _factors(results)),
        _section("loads", "Loads", LOADS_INTRO, _loads(results)),
    )
    if not shown:
        none = f"The backend {results.backend} gives no tractions along the contact."
        return (Section("tractions", "Along the contacts", none, ()), *histories)
    edges = (edge_plot(each, edge) for each in shown for edge in each.summary.stations)
    sections = (
        _section(
            "tractions", "Along the contacts", plots_tractions.INTRO, map(traction_plot, shown)
        ),
        _section("edges", "Next to the edges", plots_edges.INTRO, edges),
        _section("slip", "Stick and slip", plots_slip.INTRO, map(slip_plot, shown)),
        *histories,
        _section("loops", "Hysteresis", plots_loops.INTRO, _loops(results, shown)),
    )
    return tuple(section for section in sections if section.plots)


def solver_plots(results: Results) -> tuple[Plot, ...]:
    """How the steps were solved, and the meshes."""
    result = results.result
    plots: list[Plot | None] = []
    if result.solution is not None and len(result.history.times) > 1:
        plots += [iteration_plot(result.solution), certificate_plot(result.solution)]
    if result.refinement is not None:
        plots.append(refinement_plot(result.refinement))
    return tuple(plot for plot in plots if plot is not None)


def _shown(results: Results) -> list[Shown]:
    solution = results.result.solution
    if solution is None:
        return []
    pairs = zip(results.result.contacts, solution.contacts, strict=True)
    return [
        Shown(results, summary, history, f"contact{number}")
        for number, (summary, history) in enumerate(pairs)
    ]


def _factors(results: Results) -> Iterable[Plot]:
    for place, contact in enumerate(results.result.contacts):
        yield factor_plot(results, contact, f"contact{place}")


def _loads(results: Results) -> Iterable[Plot | None]:
    yield load_plot(results)
    for place, contact in enumerate(results.result.contacts):
        yield path_plot(results, contact, f"contact{place}")


def _loops(results: Results, shown: list[Shown]) -> Iterable[Plot | None]:
    yield from map(slip_loop_plot, shown)
    yield from work_loop_plots(results)


def _section(anchor: str, title: str, intro: str, plots: Iterable[Plot | None]) -> Section:
    return Section(anchor, title, intro, tuple(plot for plot in plots if plot is not None))
