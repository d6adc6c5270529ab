# SPDX-License-Identifier: LGPL-3.0-or-later
"""Backends: one case, several fidelities."""

from __future__ import annotations

from fretfe.backends.protocol import (
    SILENT,
    Backend,
    Installed,
    Observer,
    OneProcess,
    ParallelBackend,
    Processes,
    RunOptions,
    Session,
    SharingBackend,
    backend_names,
    find_backend,
    installed_backends,
    processes_of,
)

__all__ = [
    "SILENT",
    "Backend",
    "Installed",
    "Observer",
    "OneProcess",
    "ParallelBackend",
    "Processes",
    "RunOptions",
    "Session",
    "SharingBackend",
    "backend_names",
    "find_backend",
    "installed_backends",
    "processes_of",
]
