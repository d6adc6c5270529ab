# SPDX-License-Identifier: LGPL-3.0-or-later
"""Compiles forms, or takes them from a folder where they are kept from run to run.

FFCx marks a form that is being compiled by its source file, and whoever needs the same form waits
for the end of that. If the process was killed there is no end. A lock, which the system takes away
with its process, tells such leftovers from work in progress.
"""

from __future__ import annotations

import fcntl
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO, TypeVar

from dolfinx.jit import get_options

from fretfe.fem._compat import MPI

T = TypeVar("T")

# Below the folder of DOLFINx: what is there belongs to processes that know the lock.
FOLDER, LOCK = "fretfe", "lock"
# Seconds to wait for another process that compiles the same form.
TIMEOUT = 120


def compiled(
    comm: MPI.Comm, compiler: Callable[..., T], *arguments: Any, flags: Sequence[str] = ()
) -> T:
    """Call a function of DOLFINx that compiles. Collective.

    Args:
        comm: communicator of what is compiled.
        compiler: `dolfinx.fem.form`, `compile_form` or `Expression`.
        arguments: of the function.
        flags: of the C compiler, in place of DOLFINx's.
    """
    folder = Path(get_options()["cache_dir"]) / FOLDER
    options: dict[str, Any] = {"cache_dir": str(folder), "timeout": TIMEOUT}
    if flags:
        options["cffi_extra_compile_args"] = list(flags)
    if comm.rank > 0:  # takes what the first process has compiled
        return compiler(*arguments, jit_options=options)
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK).open("w") as lock, _shared(lock, folder):
        return compiler(*arguments, jit_options=options)


@contextmanager
def _shared(lock: TextIO, folder: Path) -> Iterator[None]:
    """Hold a lock with all others that compile; if there are none, remove leftovers first."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        remove_leftovers(folder)
    except OSError:
        pass  # another process compiles, or this file system has no locks
    try:
        fcntl.flock(lock, fcntl.LOCK_SH)
    except OSError:
        pass
    yield


def remove_leftovers(folder: Path) -> None:
    """Remove the files of forms whose compilation did not end. No process may be compiling."""
    for source in folder.glob("*.c"):
        if not source.with_suffix(".c.cached").exists():
            for path in folder.glob(f"{source.stem}.*"):
                path.unlink(missing_ok=True)
