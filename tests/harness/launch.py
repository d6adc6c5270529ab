# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands of fretfe in this process, and Python in processes of its own, on several ranks too."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import subprocess
import sys
from pathlib import Path
from unittest.mock import patch

from fretfe.environment import launcher

# The launcher's variables of an outer mpirun must not reach the child.
ENVIRONMENT = {
    name: value
    for name, value in os.environ.items()
    if not name.startswith(("PMI_", "PMIX_", "OMPI_", "MPI_", "HYDI_"))
}


def fretfe(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Return what `python("-m", "fretfe", ...)` does, without the start of another Python."""
    from fretfe.cli.app import main

    command = ["fretfe", *map(str, arguments)]
    code: object = 0
    out, err = io.StringIO(), io.StringIO()
    with (
        patch.object(sys, "argv", command),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as ended:
            code = ended.code or 0
    assert isinstance(code, int), code
    return subprocess.CompletedProcess(command, code, out.getvalue(), err.getvalue())


def command_line(*arguments: str | Path, ranks: int = 1) -> list[str]:
    """The interpreter of the tests with these arguments, perhaps on several ranks."""
    # Installed modules, not those of the folder that the tests are run from.
    safe = ["-P"] if arguments[0] in ("-c", "-m") else []
    command = [sys.executable, *safe, *map(str, arguments)]
    if ranks == 1:
        return command
    mpirun = launcher()
    assert mpirun, "mpirun is neither in the environment nor on the path"
    return [mpirun, "-n", str(ranks), *command]


def python(
    *arguments: str | Path, ranks: int = 1, timeout: float = 120, folder: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run the interpreter of the tests, perhaps in a folder, and return what it printed."""
    done = subprocess.run(
        command_line(*arguments, ranks=ranks),
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=timeout,
        env=ENVIRONMENT,
        stdin=subprocess.DEVNULL,
    )
    assert "PETSc DEPRECATION WARNING" not in done.stdout + done.stderr, done.stdout
    return done


def started(*arguments: str | Path, ranks: int = 1) -> subprocess.Popen[str]:
    """Start the interpreter of the tests; what it prints, errors too, is to be read."""
    return subprocess.Popen(
        command_line(*arguments, ranks=ranks),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=ENVIRONMENT,
        start_new_session=True,
        # A shell lets what it starts in the background ignore Ctrl-C.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
