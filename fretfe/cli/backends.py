# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe backends`."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from fretfe.backends import installed_backends
from fretfe.case import load_case
from fretfe.environment import rank_from_environment
from fretfe.report.tables import backend_table


def show_backends(path: Path | None) -> None:
    """List the installed backends and why one cannot be used, or cannot solve a case."""
    # On every rank: a backend that starts MPI when it is imported waits for the others.
    backends = installed_backends()
    if rank_from_environment() > 0:
        return
    case = load_case(path) if path is not None else None
    Console().print(backend_table(backends, case))
