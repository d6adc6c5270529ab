# SPDX-License-Identifier: LGPL-3.0-or-later
"""`python -m fretfe.mesh.child FOLDER`: reads a geometry or mesh file for `contained`."""

from __future__ import annotations

import os
import pickle
import sys
import threading
from pathlib import Path

from fretfe.environment import machine_memory, memory_shortage
from fretfe.errors import FretfeError
from fretfe.mesh.contained import ERROR, MESH, OPENED, WORK, Work, write_raw


def main(folder: Path) -> None:
    """Do the work in a folder and leave the mesh, or the error, there."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _limit_memory()
    try:
        # Written by the process that started this one, into a folder that is its own.
        work: Work = pickle.loads((folder / WORK).read_bytes())
        write_raw(folder / MESH, work((folder / OPENED).touch))
    except FretfeError as error:
        (folder / ERROR).write_text(f"{type(error).__name__}\n{error}", encoding="utf-8")
    except Exception as error:
        if not memory_shortage(error):
            raise
        (folder / ERROR).write_text(f"{MemoryError.__name__}\n", encoding="utf-8")


def _end_with_parent() -> None:
    os.read(0, 1)  # nothing is written there
    os._exit(1)


def _limit_memory() -> None:
    """No more memory than the machine has: a damaged count must not make others suffer."""
    memory = machine_memory()
    if memory is None:
        return
    try:
        import resource  # not on Windows
    except ImportError:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = int(memory) if hard == resource.RLIM_INFINITY else min(int(memory), hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
