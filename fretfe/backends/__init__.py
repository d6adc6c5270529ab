# SPDX-License-Identifier: LGPL-3.0-or-later
"""Backends: one case, several fidelities."""

from __future__ import annotations

from fretfe.backends.protocol import (
    SILENT,
    Backend,
    Installed,
    Observer,
    Processes,
    RunOptions,
    Session,
    backend_names,
    find_backend,
    installed_backends,
)

__all__ = [
    "SILENT",
    "Backend",
    "Installed",
    "Observer",
    "Processes",
    "RunOptions",
    "Session",
    "backend_names",
    "find_backend",
    "installed_backends",
]
