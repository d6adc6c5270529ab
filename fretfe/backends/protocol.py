# SPDX-License-Identifier: LGPL-3.0-or-later
"""The interface of a backend, and which backends are installed.

A backend turns a case into the histories of its contacts.
"""

from __future__ import annotations

import logging
import signal
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from fretfe.case import Case
from fretfe.environment import rank_from_environment
from fretfe.errors import CaseError, DependencyError, FretfeError, StoppedError
from fretfe.history.stream import Storage
from fretfe.loads import History
from fretfe.mesh.mesh import Mesh
from fretfe.plugins import PlugIn, plug_ins
from fretfe.results.model import Result

T = TypeVar("T")
GROUP = "fretfe.backends"
# What an observer notes goes here too; without a handler of the program nothing is printed.
LOG = logging.getLogger("fretfe")
LOG.addHandler(logging.NullHandler())
OWN = ("halfplane", "fem")
# What solves a case if nobody chooses.
DEFAULT = "fem"
# What takes the place of a backend of earlier versions.
GONE = {"analytic": "'halfplane' solves the same cases, and fretfe.analytic has closed forms"}


class Observer:
    """Follows a run without a word: override what is of interest.

    All methods are called on process 0, and only there; `stop` also on the others.
    """

    def step(self, number: int, count: int, text: str) -> None:
        """Note a finished step: its number from 1, the number of steps, and a text about it."""

    def phase(self, text: str) -> None:
        """Note that one of several runs begins, such as a companion run of `validate`."""

    def announce(self, text: str) -> None:
        """Note what begins or has ended besides steps: a mesh, a case of a sweep."""

    def doing(self, text: str) -> None:
        """Note what is being done from now on besides steps, such as edge factors."""

    def stop(self) -> signal.Signals | None:
        """Return the signal by which a run is to end after the step that was just noted.

        Everything that was computed is kept, and the run ends with a `StoppedError`.
        """
        return None


class StopOnly(Observer):
    """Says nothing, but ends a run when another observer does; on processes other than 0.

    Args:
        observer: the other one.
    """

    def __init__(self, observer: Observer) -> None:
        self._observer = observer

    def stop(self) -> signal.Signals | None:
        """Return the signal that the other one was told of."""
        return self._observer.stop()


SILENT = Observer()


@dataclass(frozen=True)
class RunOptions:
    """Wishes of a caller besides the results.

    Attributes:
        fields: file for the fields that the case asks for; None for no fields. Backends without
            fields ignore it.
        stress: file for the stress near the contacts, if the case asks for it; None for none.
        states: folder to which states go while they are solved; None for files without names.
        resume: whether the history goes on from the last state in that folder, if there is one.
        before: numbers that an earlier run with the same folder kept last, or None.
        keep: called on all ranks with a result when its numbers are there, before its fields are
            written.
        history: loads in place of those of the case; None for those.
        mesh: gives the mesh of a case on process 0; None for `fretfe.surface.checks.load_mesh`.
        observer: follows the run, on rank 0.
    """

    fields: Path | None = None
    stress: Path | None = None
    states: Path | None = None
    resume: bool = False
    before: Result | None = None
    keep: Callable[[Result], None] = lambda _: None
    history: History | None = None
    mesh: Callable[[Case], Mesh] | None = None
    observer: Observer = SILENT

    def progress(self, number: int, count: int, text: str) -> None:
        """Report a finished step, on rank 0.

        Args:
            number: of the step, from 1.
            count: of all steps.
            text: what to say about it.

        Raises:
            StoppedError: if the observer wants the history to end here; the steps are kept.
        """
        LOG.debug("step %d of %d: %s", number, count, text)
        self.observer.step(number, count, text)
        reason = self.observer.stop() if number < count else None
        if reason is not None:
            raise StoppedError(reason, f"after step {number} of {count}, which are kept")

    def storage(self, identity: Mapping[str, str]) -> Storage:
        """The file that states go to.

        Args:
            identity: of the problem, by what it says.
        """
        return Storage(self.states, self.resume, identity, self.announce)

    def doing(self, text: str) -> None:
        """Report what is being done besides steps, on rank 0."""
        LOG.info("%s", text)
        self.observer.doing(text)

    def phase(self, text: str) -> None:
        """Report that one of several runs begins, on rank 0."""
        LOG.info("%s", text)
        self.observer.phase(text)

    def announce(self, text: str) -> None:
        """Report what begins or has ended besides steps, on rank 0."""
        LOG.info("%s", text)
        self.observer.announce(text)


DEFAULTS = RunOptions()


class Processes:
    """The processes that a backend runs on: one, unless a subclass has others."""

    # Whether errors may happen on one process alone, for which the others would wait.
    shared = False

    @property
    def rank(self) -> int:
        """Number of this process, as the launcher announces it."""
        return rank_from_environment()

    @property
    def idle(self) -> bool:
        """True on processes that a launcher has started beside a backend that runs on one."""
        return self.rank > 0

    def on_root(self, work: Callable[[], T]) -> T:
        """Do `work` on rank 0 and give its result, or its error, to all processes. Collective."""
        return work()


class Backend(ABC):
    """Turns cases into results.

    Attributes:
        summary: kind of cases that it solves, in one line.
        processes: each of which has to call `solve`.
    """

    summary: str
    processes: Processes = Processes()

    @abstractmethod
    def supports(self, case: Case) -> tuple[str, ...]:
        """Reasons why this backend cannot solve a case; empty if it can. Does no heavy work."""

    def refusal(self, case: Case) -> type[FretfeError]:
        """The error that these reasons are: of the case, which asks for what there is not."""
        return CaseError

    @abstractmethod
    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """Solve the load history of a case; the name of the backend is left empty.

        Raises:
            FretfeError: for whatever keeps the history from being started; see
                `Result.failure` for a history that was not finished.
        """

    def session(self) -> Session:
        """A session for cases in a row, which has nothing yet."""
        return Session(self)


class Session:
    """Cases that are solved one after the other; a subclass shares what can be shared.

    Args:
        backend: that solves them.
    """

    def __init__(self, backend: Backend) -> None:
        self._backend = backend

    def group(self, case: Case) -> str:
        """Equal for cases that share the most; they are best solved in a row."""
        return ""

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """As `Backend.solve`."""
        return self._backend.solve(case, options)

    def copies(self) -> int:
        """Number of forked copies of this process that may solve cases beside one another.

        One is this process alone. Settles for them what is kept.
        """
        return 1

    def close(self) -> None:
        """Give back what is kept. Collective if the backend is."""


def field_obstacles(case: Case) -> tuple[str, ...]:
    """Reasons why a backend without fields cannot do what a case asks for."""
    if not case.output.stress_depths:
        return ()
    return ("output.stress_depths: only the backend 'fem' computes the stress near the contacts",)


@dataclass(frozen=True)
class Installed:
    """An installed backend.

    Attributes:
        name: by which it is chosen.
        package: name and version of the package that brings it.
        backend: the backend, or None if it cannot be used.
        reason: why it cannot be used; empty if it can.
    """

    name: str
    package: str
    backend: Backend | None
    reason: str = ""

    @property
    def processes(self) -> Processes:
        """Those of the backend; one if it cannot be used."""
        return Processes() if self.backend is None else self.backend.processes


def backend_names() -> tuple[str, ...]:
    """Names of all installed backends: those of fretfe first, others in alphabetical order."""
    return tuple(dict.fromkeys(entry.name for entry in _entries()))


def installed_backends() -> tuple[Installed, ...]:
    """All installed backends; those that cannot be used with the reason."""
    found: dict[str, Installed] = {}
    clashes = []
    for entry in _entries():
        if entry.name in found:
            reason = f"the name is taken by {found[entry.name].package}"
            clashes.append(Installed(entry.name, entry.package, None, reason))
        else:
            found[entry.name] = _load(entry)
    return (*found.values(), *clashes)


def find_backend(name: str) -> Backend:
    """The backend of this name.

    Raises:
        CaseError: if no backend of this name is installed.
        DependencyError: if it cannot be used.
    """
    entry = next((entry for entry in _entries() if entry.name == name), None)
    if entry is None:
        instead = f"; {GONE[name]}" if name in GONE else ""
        raise CaseError(
            f"no backend is called {name!r}; installed: {', '.join(backend_names())}{instead}"
        )
    found = _load(entry)
    if found.backend is None:
        raise DependencyError(f"the backend {name!r} cannot be used: {found.reason}")
    return found.backend


def _entries() -> list[PlugIn]:
    return plug_ins(GROUP, OWN)


def _load(entry: PlugIn) -> Installed:
    backend, reason = entry.load()
    if not reason and not isinstance(backend, Backend):
        expected = f"{entry.entry.value}: expected a fretfe.backends.Backend"
        backend, reason = None, f"{expected}, found {type(backend).__name__}"
    return Installed(entry.name, entry.package, backend, reason)
