# SPDX-License-Identifier: LGPL-3.0-or-later
"""The Python interface: `fretfe.load_case`, `fretfe.run`, `fretfe.sweep` and others.

Under MPI every process calls these functions, with the same arguments. All get the same numbers and
histories; tractions, meshes and files are those of process 0.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from fretfe.backends import Observer
from fretfe.backends.observer import SILENT
from fretfe.case import Case, load_case
from fretfe.errors import OutputError
from fretfe.loads import History, build_history
from fretfe.mesh.mesh import Mesh
from fretfe.quality.validate import Validation
from fretfe.quality.verify.run import Verification, verify
from fretfe.report.figures.history import draw_factors, draw_loads
from fretfe.report.figures.tractions import draw_tractions
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.runner import Runner, draw_report, fem_runner
from fretfe.sweeps import Sweep

if TYPE_CHECKING:
    from fretfe.fem.definition import ModelDefinition
    from fretfe.fem.model import Pair

__all__ = [
    "Checked",
    "Observer",
    "Result",
    "Sweep",
    "Validation",
    "Verification",
    "check",
    "load_case",
    "load_result",
    "make_mesh",
    "plot_factors",
    "plot_loads",
    "plot_tractions",
    "run",
    "sweep",
    "validate",
    "verify",
]


def run(
    case: Case,
    backend: str = "fem",
    output: Path | str | None = None,
    observer: Observer = SILENT,
) -> Result:
    """Solve a case.

    Args:
        case: from `load_case`.
        backend: name of what solves it.
        output: folder for what `fretfe run` writes; None writes nothing.
        observer: follows the run, and may end it.

    Raises:
        FretfeError: if the case cannot be solved; what was solved is written before. Its message
            is that of the command line.
    """
    runner = Runner.find(backend)
    result = runner.run(case, _folder(output), observer)
    directory = result.directory
    if directory is not None:
        drawn = runner.write(lambda: draw_report(directory))
        for problem in drawn.problems if drawn is not None and not runner.processes.rank else ():
            warnings.warn(problem, stacklevel=2)
    if result.failure is not None:
        raise result.failure
    return result


def sweep(
    case: Case,
    vary: Mapping[str, Sequence[Any]],
    backend: str = "fem",
    output: Path | str | None = None,
    observer: Observer = SILENT,
) -> Sweep:
    """Solve all combinations of values of some keys; what they share is computed once.

    Args:
        case: with all that does not vary.
        vary: values by key, such as ``{"contacts.main.friction": [0.4, 0.6]}``.
        backend: name of what solves them.
        output: folder for what `fretfe sweep` writes; None writes nothing.
        observer: follows the runs; each case is announced when it is done.

    Returns:
        All cases, the last key varying fastest; one that could not be solved says why.

    Raises:
        FretfeError: before any work, if a combination is not a valid case.
    """
    return Runner.find(backend).sweep(case, vary, _folder(output), observer)


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


@dataclass(frozen=True)
class Checked:
    """A case that finite elements could solve.

    Attributes:
        case: as it was checked.
        history: its loads.
        mesh: of its bodies, the first one if it refines itself.
        definition: bodies, coordinates and loads of the model.
        pairs: coupled contact surfaces.
        restrained_modes: by body, a rigid motion that only contact prevents, in words.
    """

    case: Case
    history: History
    mesh: Mesh
    definition: ModelDefinition
    pairs: Sequence[Pair]
    restrained_modes: Mapping[str, str]


def check(case: Case) -> Checked | None:
    """Check a case and its mesh without solving it; None on processes other than 0.

    Raises:
        FretfeError: if there is no history, no mesh or no model for the case.
    """
    from fretfe.fem._compat import MPI
    from fretfe.fem.parallel import on_root

    fem_runner().require_support(case)
    return on_root(MPI.COMM_WORLD, lambda: _check(case), share=False)


def _check(case: Case) -> Checked:
    from fretfe.fem.definition import define_model
    from fretfe.fem.model import contact_surfaces, couple_contacts
    from fretfe.fem.refine import starting_mesh
    from fretfe.fem.rigid_modes import modes_restrained_by_contact

    history, mesh = build_history(case), starting_mesh(case)
    definition = define_model(case, mesh)
    pairs = couple_contacts(case, contact_surfaces(definition, mesh))
    restrained = modes_restrained_by_contact(definition, mesh)
    return Checked(case, history, mesh, definition, pairs, restrained)


def make_mesh(case: Case) -> Mesh | None:
    """Make the mesh of a case, the first one if it refines itself; None on processes other than 0.

    Raises:
        FretfeError: if there is no mesh for the case.
    """
    from fretfe.fem._compat import MPI
    from fretfe.fem.parallel import on_root
    from fretfe.fem.refine import starting_mesh

    return on_root(MPI.COMM_WORLD, lambda: starting_mesh(case), share=False)


def plot_tractions(result: Result) -> Figure:
    """Draw pressure and shear along every contact at the two load extremes.

    Raises:
        OutputError: if the backend has no tractions, or this is not process 0.
    """
    if result.solution is None:
        raise OutputError(
            f"expected tractions, found none: {result.backend!r} has none, or this process is "
            "not the first one"
        )
    return draw_tractions(result.case, result.solution, result.contacts)


def plot_factors(result: Result) -> Figure:
    """Draw K_N and K_T of every edge over time."""
    return draw_factors(result.case, result.loads, result.contacts)


def plot_loads(result: Result) -> Figure:
    """Draw all loads over time."""
    return draw_loads(result.case, result.loads)
