# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which backends are installed, and which of them can be used."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points

from fretfe.backends.protocol import Backend
from fretfe.environment import memory_shortage, missing_package
from fretfe.errors import CaseError, DependencyError, MemoryShortError

GROUP = "fretfe.backends"
OWN = ("analytic", "halfplane", "fem")


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
            clashes.append(Installed(entry.name, _package(entry), None, reason))
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
        raise CaseError(f"no backend is called {name!r}; installed: {', '.join(backend_names())}")
    found = _load(entry)
    if found.backend is None:
        raise DependencyError(f"the backend {name!r} cannot be used: {found.reason}")
    return found.backend


def _entries() -> list[EntryPoint]:
    """Entry points in the order in which a name is given away: fretfe, then by package."""

    def order(entry: EntryPoint) -> tuple[bool, int, str, str]:
        own = entry.dist is not None and entry.dist.name == "fretfe"
        place = OWN.index(entry.name) if own and entry.name in OWN else len(OWN)
        return not own, place, entry.name, _package(entry)

    return sorted(entry_points(group=GROUP), key=order)


def _package(entry: EntryPoint) -> str:
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else ""


def _load(entry: EntryPoint) -> Installed:
    package = _package(entry)
    try:
        backend = entry.load()
    except (Exception, SystemExit) as error:  # what foreign modules raise is not ours to know
        if isinstance(error, MemoryShortError):
            raise
        if shortage := memory_shortage(error):
            raise MemoryShortError(shortage) from error
        reason = missing_package(error) or str(error) or type(error).__name__
        return Installed(entry.name, package, None, reason)
    if not isinstance(backend, Backend):
        reason = f"{entry.value}: expected an object with summary, supports and solve"
        return Installed(entry.name, package, None, f"{reason}, found {type(backend).__name__}")
    return Installed(entry.name, package, backend)
