# SPDX-License-Identifier: LGPL-3.0-or-later
"""Backends: one case, several fidelities."""

from __future__ import annotations

from fretfe.backends.protocol import (
    Backend,
    BodyArrays,
    EdgeHistories,
    ParallelBackend,
    Processes,
    Progress,
    RunOptions,
    Session,
    SharingBackend,
)
from fretfe.backends.registry import (
    Installed,
    backend_names,
    find_backend,
    installed_backends,
)

__all__ = [
    "Backend",
    "BodyArrays",
    "EdgeHistories",
    "Installed",
    "ParallelBackend",
    "Processes",
    "Progress",
    "RunOptions",
    "Session",
    "SharingBackend",
    "backend_names",
    "find_backend",
    "installed_backends",
]
