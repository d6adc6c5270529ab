# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a backend is: it turns a case into the histories of its contact edges.

A backend is an object with this module's `Backend` interface, named by an entry point of the group
``fretfe.backends`` (see docs/backends.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, TypeVar, runtime_checkable

from fretfe._typing import Array, Indices
from fretfe.case import Case
from fretfe.edges.front import ContactSummary
from fretfe.edges.refinement import Refinement
from fretfe.errors import ConvergenceError
from fretfe.loads import History
from fretfe.results.solution import Solution

T = TypeVar("T")
# Called with each finished step: its number, the number of steps, and what to say about it.
Progress = Callable[[int, int, str], None]
# Called with what begins or has ended, in words.
Announce = Callable[[str], None]


class BodyArrays(Protocol):
    """The mesh of one body, whoever made it."""

    @property
    def points(self) -> Array:
        """(n, d) coordinates of the nodes."""

    @property
    def cells(self) -> Indices:
        """(m, k) nodes of the cells, in Gmsh's order."""

    @property
    def cell(self) -> str:
        """Shape of the cells."""

    @property
    def order(self) -> int:
        """Polynomial order of the geometry."""

    @property
    def boundaries(self) -> dict[str, Indices]:
        """Facets (f, order + 1) of each boundary."""


@dataclass(frozen=True)
class EdgeHistories:
    """What every backend returns; T states, state 0 unloaded.

    Attributes:
        history: the T states that were solved, fewer than the case has if `failure` is set; its
            cycle is then None.
        contacts: fronts, resultants and slip zones of each contact.
        notes: what was assumed, in words.
        failure: why not all steps were solved, or None.
        solution: tractions along the contacts; None if the backend has none, or on ranks other
            than 0.
        bodies: the meshes, by body; empty without meshes, or on ranks other than 0.
        versions: of what the backend is made of.
        seconds: wall time by phase.
        ranks: number of processes.
        refinement: how the mesh refined itself, or None.
    """

    history: History
    contacts: tuple[ContactSummary, ...]
    notes: tuple[str, ...] = ()
    failure: ConvergenceError | None = None
    solution: Solution | None = None
    bodies: Mapping[str, BodyArrays] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    ranks: int = 1
    refinement: Refinement | None = None


def silent(number: int, count: int, text: str) -> None:
    """Report no progress."""


def mute(text: str) -> None:
    """Announce nothing."""


@dataclass(frozen=True)
class RunOptions:
    """What a caller may want besides the edge histories.

    Attributes:
        fields: folder for the fields that the case asks for; None for no fields. Backends without
            fields ignore it.
        progress: called with each finished step, on rank 0.
        history: loads in place of those of the case; None for those.
        announce: called with what begins or has ended besides steps, on rank 0.
    """

    fields: Path | None = None
    progress: Progress = silent
    history: History | None = None
    announce: Announce = mute


DEFAULTS = RunOptions()


@runtime_checkable
class Backend(Protocol):
    """Turns cases into edge histories."""

    @property
    def summary(self) -> str:
        """What it solves, in one line."""

    def supports(self, case: Case) -> tuple[str, ...]:
        """Reasons why this backend cannot solve a case; empty if it can. Does no heavy work."""

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> EdgeHistories:
        """Solve the load history of a case.

        Raises:
            FretfeError: for whatever keeps the history from being started; see
                `EdgeHistories.failure` for a history that was not finished.
        """


class Processes(Protocol):
    """The processes that a backend runs on."""

    @property
    def rank(self) -> int:
        """Number of this process."""

    def on_root(self, work: Callable[[], T]) -> T | None:
        """Do `work` on rank 0 and give its result, or its error, to all processes. Collective."""


@runtime_checkable
class ParallelBackend(Backend, Protocol):
    """A backend whose `solve` is collective over several processes."""

    @property
    def processes(self) -> Processes:
        """All processes, each of which has to call `solve`."""


class Session(Protocol):
    """Cases that are solved one after the other and share what can be shared."""

    def group(self, case: Case) -> str:
        """Equal for cases that share the most; they are best solved in a row."""

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> EdgeHistories:
        """As `Backend.solve`."""

    def close(self) -> None:
        """Give back what is kept."""


@runtime_checkable
class SharingBackend(Backend, Protocol):
    """A backend that needs less than the sum of their times for several cases."""

    def session(self) -> Session:
        """A session that has nothing yet."""
