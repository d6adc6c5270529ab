# SPDX-License-Identifier: LGPL-3.0-or-later
"""`python -m fretfe`: the same as the command `fretfe`."""

from __future__ import annotations

import os
import sys
import warnings

from fretfe.environment import missing_package
from fretfe.errors import DependencyError

# What sets the number of threads of a BLAS; the last one is heeded by all of them.
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "OMP_NUM_THREADS")


def main() -> None:
    """Entry point of the command: without Typer there is no command line to say so."""
    # Matrices of a thousand rows gain nothing by threads, and lose much where another program wants
    # the cores. To be set before NumPy is imported.
    if not any(name in os.environ for name in THREADS):
        os.environ[THREADS[-1]] = "1"
    # What NumPy warns of is told by fretfe in its own words, or does not matter.
    if not sys.warnoptions:
        warnings.simplefilter("ignore", RuntimeWarning)
    try:
        from fretfe.cli.app import main as command_line
    except ImportError as error:
        if not (reason := missing_package(error)):
            raise
        print(f"fretfe: error: {reason}", file=sys.stderr)
        sys.exit(DependencyError.exit_code)
    command_line()


if __name__ == "__main__":
    main()
