# SPDX-License-Identifier: LGPL-3.0-or-later
"""The Python interface: `fretfe.load_case`, `fretfe.run`, `fretfe.sweep` and others.

Under MPI every process calls these functions, with the same arguments. All get the same numbers and
histories; tractions, meshes and files are those of process 0.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fretfe
from fretfe._typing import Array
from fretfe.backends import Observer
from fretfe.backends.protocol import LOG, SILENT
from fretfe.case import Case, load_case
from fretfe.case.arguments import typed
from fretfe.checked import Checked, check, make_mesh
from fretfe.decision.assess import assess
from fretfe.decision.assessment import Assessment
from fretfe.errors import OutputError
from fretfe.exchange.comparison import Comparison, compare
from fretfe.exchange.export import export_result
from fretfe.matching.match import compare_tests, match_test
from fretfe.matching.rig import load_rig
from fretfe.quality.validation import Validation
from fretfe.quality.verification import Verification, verify
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.runner import Runner, draw_report
from fretfe.strength.margins import StrengthMap, strength_map
from fretfe.sweeps import Points, Sweep, sample

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fretfe.exchange.submodel import Submodel

# What the package has, and types of what its functions give.
__all__ = ["Assessment", "Checked", "StrengthMap", "Validation", "Verification"]
__all__ += fretfe.__all__


def run(
    case: Case,
    backend: str = "fem",
    output: Path | str | None = None,
    observer: Observer = SILENT,
    *,
    resume: bool = False,
) -> Result:
    """Solve a case.

    Args:
        case: from `load_case`.
        backend: name of what solves it.
        output: folder for what `fretfe run` writes; None writes nothing.
        observer: follows the run, and may end it.
        resume: whether to go on with the run of this case in the folder, if there is one.

    Raises:
        FretfeError: if the case cannot be solved; what was solved is written before. Its message
            is that of the command line.

    Returns:
        The result; its `faults` say what is unknown because of an error of fretfe itself.
    """
    runner = Runner.find(backend)
    result = runner.run(case, _folder(output), observer, resume=resume)
    if runner.processes.rank == 0:
        name = case.title or case.source.name
        for note in result.notes:
            LOG.info("%s: %s", name, note)
        for each in result.warnings:
            LOG.warning("%s: %s", name, each.sentence)
    directory = result.directory
    if directory is not None:
        drawn = runner.write(lambda: draw_report(directory))
        if drawn is not None and runner.processes.rank == 0:
            failed = (f"no report: {drawn.failure}",) if drawn.failure else ()
            for problem in (*drawn.problems, *failed):
                warnings.warn(problem, stacklevel=2)
    if result.failure is not None:
        raise result.failure
    return result


def sweep(
    case: Case,
    vary: Mapping[str, Sequence[Any] | Array],
    backend: str = "fem",
    output: Path | str | None = None,
    observer: Observer = SILENT,
) -> Sweep:
    """Solve all combinations of values of some keys; what they share is computed once.

    Args:
        case: with all that does not vary.
        vary: values by key, such as ``{"contacts.main.friction": [0.4, 0.6]}``; `Points`, as from
            `sample`, are not combined.
        backend: name of what solves them.
        output: folder for what `fretfe sweep` writes; None writes nothing.
        observer: follows the runs; each case is announced when it is done.

    Returns:
        All cases, the last key varying fastest; one that could not be solved says why.

    Raises:
        FretfeError: before any work, if a combination is not a valid case.
    """
    return Runner.find(backend).sweep(case, vary, _folder(output), observer)


def write_submodel(
    result: Result,
    around: str,
    output: Path | str,
    radius: float | None = None,
    size: float | None = None,
) -> Submodel:
    """Write the case of a part of a solved case, with finer elements, as `fretfe submodel` does.

    On process 0 only.

    Args:
        result: with all of its steps, from a folder that has the displacements of all of them
            (``[output] fields = "all"``).
        around: "CONTACT", "CONTACT.left" or "CONTACT.right", of solids "CONTACT.FRONT.STATION".
        output: folder for the files; made if missing.
        radius: of the part; None for three times the distance of the edges from the middle.
        size: of the elements at contact edges; None for a quarter of those of the run.

    Raises:
        FretfeError: if there is no such contact, a part of the case cannot be cut, displacements
            are missing, or a file cannot be written.
    """
    from fretfe.exchange.submodel import write_submodel as write

    return write(result, around, Path(output), radius, size)


def export(
    result: Result, output: Path | str, fatemi_socie: tuple[float, float] | None = None
) -> tuple[Path, ...]:
    """Write the numbers of a result as CSV files, as `fretfe export` does; on process 0 only.

    Args:
        result: of plane bodies or of solids.
        output: folder for the files; made if missing.
        fatemi_socie: k and yield stress of that parameter, for results with the stress near the
            contacts; None leaves it out.

    Returns:
        The files; the last one lists their columns.

    Raises:
        FretfeError: if the folder holds results of a run, or a file cannot be written.
    """
    return tuple(each.path for each in export_result(result, Path(output), fatemi_socie))


def validate(
    case: Case,
    backend: str = "fem",
    output: Path | str | None = None,
    observer: Observer = SILENT,
) -> Validation:
    """Run a case and its companions, and compare their numbers.

    Args:
        case: from `load_case`.
        backend: name of what solves it.
        output: folder for what `fretfe validate` writes; None writes nothing.
        observer: follows the runs; each is a phase.

    Raises:
        FretfeError: if the case itself cannot be solved.
    """
    return Runner.find(backend).validate(case, _folder(output), observer)


def _folder(output: Path | str | None) -> Path | None:
    return None if output is None else Path(output)


def plot_tractions(result: Result, ax: Axes | Iterable[Axes] | None = None) -> tuple[Axes, ...]:
    """Draw pressure and shear along every contact at the two load extremes.

    Of solids along a line across it: inward from the station with the largest |ΔK|, or without one
    through the largest pressure.

    Args:
        result: of plane bodies or of solids.
        ax: axes to draw in, one for each contact; None makes a new figure of pyplot.

    Returns:
        The axes.

    Raises:
        OutputError: if this is not process 0, or axes are missing.
    """
    from fretfe.report.figures.across import draw_across
    from fretfe.report.figures.tractions import draw_tractions
    from fretfe.report.theme import SINGLE, draw_in

    contacts, solution = result.contacts, result.solution

    def draw(panels: list[Axes]) -> None:
        if result.solid:
            draw_across(panels, result)
        else:
            draw_tractions(panels, result.case, solution, contacts)

    return draw_in(ax, len(contacts), min(2, len(contacts)), SINGLE, draw)


def plot_factors(result: Result, ax: Axes | Iterable[Axes] | None = None) -> tuple[Axes, ...]:
    """Draw K_N and K_T of every edge over time.

    Of solids it is the station of the largest range of each front.

    Args:
        result: of plane bodies or of solids.
        ax: two axes to draw in; None makes a new figure of pyplot.

    Returns:
        The axes, of K_N and of K_T.

    Raises:
        OutputError: if no station of solids has a range, or these are not two axes.
    """
    from fretfe.evaluate.headline import shown_stations
    from fretfe.report.figures.history import draw_factors
    from fretfe.report.theme import DOUBLE, draw_in

    if not shown_stations(result.contacts):
        raise OutputError("expected a station with a known range of K_T and K_S, found none")

    def draw(panels: list[Axes]) -> None:
        draw_factors(panels, result.case, result.loads, result.contacts)

    return draw_in(ax, 2, 1, DOUBLE / 2, draw, sharex=True)


def plot_comparison(
    comparison: Comparison, ax: Axes | Iterable[Axes] | None = None
) -> tuple[Axes, ...]:
    """Draw pressure and shear of two results over each other, at the load extremes.

    Args:
        comparison: of two results.
        ax: two axes to draw in for each contact; None makes a new figure of pyplot.

    Returns:
        The axes.

    Raises:
        OutputError: if there are no tractions to compare, or axes are missing.
    """
    if not comparison.tractions:
        raise OutputError(f"expected tractions, found none: {'; '.join(comparison.notes)}")
    from fretfe.exchange.comparison_files import compared_contacts, draw_tractions, name_results
    from fretfe.report.theme import SINGLE, draw_in

    def draw(panels: list[Axes]) -> None:
        draw_tractions(panels, comparison)
        name_results(panels[0], comparison.labels)

    count = len(compared_contacts(comparison))
    return draw_in(ax, 2 * count, min(2, count), SINGLE, draw)


def plot_strength(found: StrengthMap, ax: Axes | None = None) -> Axes:
    """Draw tests, strength and component edges over K_N and ΔK_T, and return the axes.

    Args:
        found: from `strength_map`.
        ax: to draw in; None makes a new figure of pyplot.
    """
    from fretfe.report.theme import draw_in
    from fretfe.strength.files import HEIGHT, draw_strength

    return draw_in(ax, 1, 1, HEIGHT, lambda panels: draw_strength(panels[0], found))[0]


def plot_loads(result: Result, ax: Axes | Iterable[Axes] | None = None) -> tuple[Axes, ...]:
    """Draw all loads over time, and return the axes.

    Args:
        result: of a case with loads.
        ax: axes to draw in, one for each load; None makes a new figure of pyplot.

    Raises:
        OutputError: if there are no loads, or axes are missing.
    """
    from fretfe.report.figures.history import draw_loads
    from fretfe.report.theme import LOAD, draw_in

    count = len(result.loads.channels)
    if not count:
        raise OutputError("expected loads, found none")

    def draw(panels: list[Axes]) -> None:
        draw_loads(panels, result.case, result.loads)

    return draw_in(ax, count, 1, LOAD * (1 + 0.4 / count), draw, sharex=True)


def plot_scatter(
    sweep: Sweep, quantity: str, ax: Axes | Iterable[Axes] | None = None
) -> tuple[Axes, ...]:
    """Draw a number of all edges, with its error bars, over each key of a sweep.

    Args:
        sweep: with cases that were solved.
        quantity: name of a column of its records.
        ax: axes to draw in, one for each key; None makes a new figure of pyplot.

    Returns:
        The axes.

    Raises:
        OutputError: if there is no such number, or axes are missing.
    """
    from fretfe.report.theme import SINGLE, draw_in
    from fretfe.sweeps.figures import draw_scatter, solved_records

    records, label = solved_records(sweep.records(), quantity, sweep.units)
    count = len(sweep.keys)

    def draw(panels: list[Axes]) -> None:
        draw_scatter(panels, sweep.keys, records, quantity, label)

    return draw_in(ax, count, min(2, count), SINGLE, draw)


def plot_tornado(sweep: Sweep, quantity: str, ax: Axes | None = None) -> Axes:
    """Draw how much each key of a sweep changes the largest value of all edges.

    A linear function of the keys is fitted to the cases; a bar is its change over the range of one
    key. The title has the part of the variance that it explains.

    Args:
        sweep: with numbers as values, and more cases than keys; `sample` gives good ones.
        quantity: name of a column of its records.
        ax: to draw in; None makes a new figure of pyplot.

    Raises:
        OutputError: if there is no such number, a value is none, or cases do not tell keys apart.
    """
    from fretfe.report.theme import SINGLE, draw_in
    from fretfe.sweeps.figures import draw_tornado, linear_effects, solved_records

    records, label = solved_records(sweep.records(), quantity, sweep.units)
    effects, explained = linear_effects(sweep.keys, records, quantity)
    return draw_in(
        ax, 1, 1, SINGLE, lambda panels: draw_tornado(panels[0], effects, explained, label)
    )[0]


# An argument of a wrong type is named, by all of them.
globals().update(
    (name, typed(globals()[name])) for name in fretfe.__all__ if inspect.isfunction(globals()[name])
)
