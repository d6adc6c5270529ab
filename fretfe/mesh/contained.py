# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reads geometry and mesh files in a process of its own, which may crash."""

from __future__ import annotations

import contextlib
import json
import math
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np

from fretfe._typing import Array
from fretfe.environment import (
    NO_ROOM,
    address_room,
    machine_memory,
    memory_shortage,
    without_launcher,
)
from fretfe.errors import CaseError, DependencyError, FretfeError, MemoryShortError, MeshError
from fretfe.files import replace_text
from fretfe.mesh.gmsh import ElementBlock, RawMesh

Blocks = Mapping[str, list[ElementBlock]]
# Seconds for reading a file, and for each megabyte of it; in all, for meshing what was read.
READING = 20.0
READING_MEGABYTE = 20.0
MESHING = 3600.0
# Files in the folder that both processes know. The first process writes the work, nobody else.
WORK = "work"
OPENED = "opened"
MESH = "mesh.npz"
ERROR = "error"
MESSAGES = "messages"
ERRORS = {each.__name__: each for each in (CaseError, DependencyError, MeshError)}


class Opened(Protocol):
    """Called by work when the file has been read."""

    def __call__(self, seconds: float = MESHING) -> None:
        """Ask for so many seconds in all, from the start of the work."""


# Reads a file into a mesh, or into arrays.
Work = Callable[[Opened], RawMesh]
ArrayWork = Callable[[Opened], Mapping[str, Array]]
T = TypeVar("T")


def reading_seconds(size: int) -> float:
    """Seconds that reading so many bytes may take."""
    return READING + READING_MEGABYTE * size / 1e6


def write_raw(path: Path, raw: RawMesh) -> None:
    """Write a mesh; `read_raw` reads it back."""
    arrays: dict[str, Any] = {"points": raw.points}

    def listed(groups: Blocks) -> list[Any]:
        table: list[Any] = []
        for name, blocks in groups.items():
            table.append([name, []])
            for block in blocks:
                arrays[f"block{len(arrays)}"] = block.nodes
                table[-1][1].append([block.gmsh_type, f"block{len(arrays) - 1}"])
        return table

    head = {
        "dimension": raw.dimension,
        "bodies": listed(raw.bodies),
        "boundaries": listed(raw.boundaries),
    }
    np.savez(path, head=np.array(json.dumps(head)), **arrays)


def read_raw(path: Path) -> RawMesh:
    """Read what `write_raw` has written; nothing in such a file is executed."""
    with np.load(path, allow_pickle=False) as file:
        head = json.loads(str(file["head"]))

        def blocks(table: list[Any]) -> dict[str, list[ElementBlock]]:
            return {
                name: [ElementBlock(kind, file[key]) for kind, key in parts]
                for name, parts in table
            }

        points: Array = file["points"]
        bodies, boundaries = blocks(head["bodies"]), blocks(head["boundaries"])
    return RawMesh(points, head["dimension"], bodies, boundaries)


def read_arrays(path: Path) -> dict[str, Array]:
    """Read named arrays; nothing in such a file is executed."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def raw_mesh_of(work: Work, path: Path, reading: float | None = None) -> RawMesh:
    """Let another process read a file, and mesh what is in it.

    Args:
        work: done there; it must be possible to pickle it.
        path: the file, for its size and for messages.
        reading: seconds for reading it; without it they are from its size.

    Raises:
        FretfeError: as `work` raises it.
        MeshError: if the process crashes, ends early or takes longer than it may.
    """
    return _found_by(work, path, reading, read_raw)


def arrays_of(work: ArrayWork, path: Path) -> dict[str, Array]:
    """Let another process read arrays from a file, as `raw_mesh_of` does a mesh; same errors."""
    return _found_by(work, path, None, read_arrays)


def _found_by(
    work: Work | ArrayWork, path: Path, reading: float | None, read: Callable[[Path], T]
) -> T:
    if reading is None:
        reading = reading_seconds(path.stat().st_size)
    with tempfile.TemporaryDirectory(prefix="fretfe-") as name:
        folder = Path(name)
        (folder / WORK).write_bytes(pickle.dumps(work))
        with _process(folder) as process:
            code = _wait(process, folder, path, reading)
        if (folder / ERROR).exists():
            kind, _, text = (folder / ERROR).read_text(encoding="utf-8").partition("\n")
            if kind == MemoryError.__name__:
                raise _too_large(path)
            raise ERRORS[kind](text)
        if code == 0 and (folder / MESH).exists():
            return read(folder / MESH)
        raise _ended(path, code, (folder / MESSAGES).read_text(errors="replace"))


@contextlib.contextmanager
def _process(folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """The other process. It ends by itself when its standard input does, as this process ends."""
    command = [sys.executable, "-P", "-m", "fretfe.mesh.contained", str(folder)]
    with (folder / MESSAGES).open("wb") as messages:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=messages,
            stderr=messages,
            # Threads of small tasks wait for one another.
            env={**without_launcher(os.environ), "OMP_NUM_THREADS": "1"},
            start_new_session=True,
        )
    try:
        with process:
            try:
                yield process
            finally:
                process.kill()
    finally:
        # What a script has started.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def _wait(process: subprocess.Popen[bytes], folder: Path, path: Path, reading: float) -> int:
    """The exit code of the process."""
    begin = time.monotonic()
    with contextlib.suppress(subprocess.TimeoutExpired):
        return process.wait(reading)
    if (folder / OPENED).exists():
        limit = float((folder / OPENED).read_text(encoding="utf-8"))
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.wait(max(begin + limit - time.monotonic(), 0.0))
    raise MeshError(
        f"{path}: reading it, and using what is in it, was ended after "
        f"{time.monotonic() - begin:.0f} s: the file is damaged, or its geometry too complex"
    )


def _too_large(path: Path) -> FretfeError:
    """The error of a process without enough memory: a limit is the user's, a machine has an end."""
    if math.isfinite(address_room()):
        return MemoryShortError(
            f"{path}: there is not enough memory to read it: the address space of a process is "
            "limited (see ulimit -v)"
        )
    return MeshError(f"{path}: reading it takes more memory than the machine has")


def _ended(path: Path, code: int, messages: str) -> FretfeError:
    """The error of a process that has left no mesh."""
    if NO_ROOM.search(messages):
        return _too_large(path)
    if "Traceback (most recent call last)" in messages and code == 1:
        raise RuntimeError(f"reading {path} failed:\n{messages}")
    if code >= 0:
        return MeshError(
            f"{path}: expected a mesh, but the process that reads it ended (exit code {code}), as "
            "by Exit in a Gmsh script"
        )
    known = -code in set(signal.Signals)
    name = signal.Signals(-code).name if known else f"signal {-code}"
    return MeshError(
        f"{path}: the library that reads it crashed ({name}): the file is damaged, or there is not "
        "enough memory"
    )


def main(folder: Path) -> None:
    """Do the work in a folder and leave the mesh, or the error, there.

    This is what the other process does: `python -m fretfe.mesh.contained FOLDER`.
    """
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _limit_memory()
    try:
        # Written by the process that started this one, into a folder that is its own.
        work: Work | ArrayWork = pickle.loads((folder / WORK).read_bytes())
        found = work(partial(_note_opened, folder / OPENED))
        if isinstance(found, RawMesh):
            write_raw(folder / MESH, found)
        else:
            np.savez(folder / MESH, **found)  # type: ignore[arg-type]
    except FretfeError as error:
        (folder / ERROR).write_text(f"{type(error).__name__}\n{error}", encoding="utf-8")
    except Exception as error:
        if not memory_shortage(error):
            raise
        (folder / ERROR).write_text(f"{MemoryError.__name__}\n", encoding="utf-8")


def _note_opened(path: Path, seconds: float = MESHING) -> None:
    """Say that the file has been read, with the seconds for all; the text is there at once."""
    replace_text(path, f"{seconds}")


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
