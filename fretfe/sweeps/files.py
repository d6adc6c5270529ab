# SPDX-License-Identifier: LGPL-3.0-or-later
"""Table and picture of a sweep on disk."""

from __future__ import annotations

from pathlib import Path

from fretfe.errors import OutputError
from fretfe.report.figures.sweep import write_sweep
from fretfe.sweeps.engine import Sweep
from fretfe.sweeps.table import write_table

TABLE, FIGURE = "sweep.csv", "sweep.png"


def write_files(sweep: Sweep, directory: Path) -> bool:
    """Write table and picture; return True if there is a picture.

    Raises:
        OutputError: if a file cannot be written.
    """
    try:
        write_table(directory / TABLE, sweep)
        # A picture of an earlier sweep would not belong to this table.
        (directory / FIGURE).unlink(missing_ok=True)
        return write_sweep(directory / FIGURE, sweep.keys, sweep.records(), sweep.units)
    except OSError as error:
        raise OutputError(f"{directory}: cannot write the sweep: {error}") from error
