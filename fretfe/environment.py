# SPDX-License-Identifier: LGPL-3.0-or-later
"""The environment of a run: versions and the linear-algebra library in use.

What is installed is looked up by functions that import `metadata` themselves: help needs none.
"""

from __future__ import annotations

import math
import os
import platform
import re
import resource
import shutil
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

PACKAGES = (
    "fretfe",
    "numpy",
    "scipy",
    "pydantic",
    "h5py",
    "gmsh",
    "jinja2",
    "matplotlib",
    "pyvista",
)

# What sets the number of threads of a BLAS; the last one is heeded by all of them.
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "OMP_NUM_THREADS")
PETSC_OUT_OF_MEMORY = 55
# What the loader says of a library for which there is no memory.
NO_ROOM = re.compile("failed to map segment|[Cc]annot allocate memory")
# Bytes of address space below which importing a module fails in ways that do not say why, or, with
# the OpenBLAS of Debian, waits for ever for memory.
LITTLE_ROOM = 400 * 2**20


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that take part in a run."""
    from importlib import metadata

    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def loaded_libraries(*words: str) -> list[str]:
    """Libraries in this process with one of the words in their names (Linux; empty elsewhere)."""
    maps = Path("/proc/self/maps")
    if not maps.exists():
        return []
    paths = {line.split(maxsplit=5)[-1].strip() for line in maps.read_text().splitlines()}
    names = {path: Path(path).name.lower() for path in paths}
    return sorted(
        path
        for path, name in names.items()
        if ".so" in name and any(word in name for word in words)
    )


def reference_blas(libraries: list[str]) -> list[str]:
    """Those of the loaded libraries that are the reference BLAS.

    All distributions call the library of the BLAS interface libblas, whoever wrote it; what it is
    can be read from the folder or from the file that the name leads to. An optimised BLAS beside it
    (NumPy's wheel has its own) does not make the one faster that PETSc is linked with.
    """
    optimised = ("openblas", "mkl", "blis", "atlas", "flexiblas")
    return [
        library
        for library in libraries
        if Path(library).name.startswith(("libblas.", "librefblas."))
        and not any(name in str(Path(library).resolve()).lower() for name in optimised)
    ]


def idle_cores() -> int:
    """Cores that this process may use besides the one it has."""
    allowed = getattr(os, "sched_getaffinity", None)  # Linux
    return (len(allowed(0)) if allowed else os.cpu_count() or 1) - 1


def threads_asked_for() -> int | None:
    """Threads of a BLAS by the environment; None if it gives no number."""
    numbers = (os.environ.get(name, "") for name in THREADS)
    return next((int(each) for each in numbers if each.isdecimal() and int(each)), None)


@contextmanager
def few_threads() -> Iterator[None]:
    """Have each BLAS of this process use one thread, unless the environment gives a number.

    Matrices of a thousand rows gain nothing by threads, and lose much where another program wants
    the cores. NumPy, SciPy and PETSc may each have a copy of a BLAS, which they load.
    """
    if threads_asked_for():
        yield
        return
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1, "blas"):
        yield


def peak_memory() -> float:
    """Bytes of memory that this process has had at most."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(peak) * (1 if sys.platform == "darwin" else 1024)


def machine_memory() -> float | None:
    """Bytes of memory that this machine, or the container, has; None if it does not tell."""
    found = []
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        found.append(float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
    for name in ("memory.max", "memory/memory.limit_in_bytes"):
        limit = Path("/sys/fs/cgroup") / name
        text = limit.read_text().strip() if limit.exists() else ""
        if text.isdecimal():
            found.append(float(text))
    return min(found, default=None)


def address_room() -> float:
    """Bytes of address space that this process may still take; infinite without a limit."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    used = Path("/proc/self/statm")
    if limit == resource.RLIM_INFINITY or not used.exists():
        return math.inf
    return limit - float(used.read_text().split()[0]) * resource.getpagesize()


def too_little_room(wanted: float, what: str, room: float | None = None) -> str:
    """Say that there is less address space than something needs; else empty.

    Args:
        wanted: bytes.
        what: takes them, in words.
        room: bytes; without them those that this process may still take.
    """
    room = address_room() if room is None else room
    if room >= wanted:
        return ""
    return (
        f"there is not enough memory: a process may take {room / 2**20:.0f} MiB more (its address "
        f"space is limited, see ulimit -v); expected {wanted / 2**20:.0f} MiB, which {what}"
    )


def missing_package(error: BaseException) -> str:
    """Advice on a module that fretfe requires and that is not there; empty for other errors."""
    if not isinstance(error, ModuleNotFoundError):
        return ""
    from importlib import metadata

    module = (error.name or "").partition(".")[0]
    required = metadata.requires("fretfe") or []
    for name in (re.split(r"[^\w-]", each)[0] for each in required if "extra ==" not in each):
        if module == name.replace("-", "_"):
            return (
                f"the Python package {name} is not installed. Install it with `pip install {name}` "
                f"or from your distribution (Debian: python3-{name})"
            )
    return ""


def missing_folder() -> str:
    """Say that the working folder has been removed; empty if it is there."""
    try:
        os.getcwd()
    except FileNotFoundError:
        return "the folder that fretfe was started in is no longer there: start it in another one"
    return ""


def memory_shortage(error: BaseException) -> str:
    """Say that there is not enough memory if that is what an error means; empty for others."""
    if not any(map(_means_no_memory, _causes(error))):
        return ""
    return (
        "there is not enough memory. What was solved before is kept if the run has a folder; "
        "--resume goes on from there on a machine with more"
    )


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """An error, the one that it comes from, and so on."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _means_no_memory(error: BaseException) -> bool:
    # PETSc's own error has the number in `ierr`.
    if isinstance(error, MemoryError) or getattr(error, "ierr", None) == PETSC_OUT_OF_MEMORY:
        return True
    kinds = (ImportError, OSError, RuntimeError, SystemError)
    if not isinstance(error, kinds) or missing_package(error):
        return False
    unsaid = not isinstance(error, OSError) and address_room() < LITTLE_ROOM
    return unsaid or NO_ROOM.search(str(error)) is not None


def without_launcher(environment: Mapping[str, str]) -> dict[str, str]:
    """Environment variables without those by which an MPI launcher speaks to its processes."""
    return {
        name: value
        for name, value in environment.items()
        if not name.startswith(("PMI_", "PMIX_", "OMPI_", "MPI_", "HYDI_"))
    }


RANKS = ("PMI_RANK", "OMPI_COMM_WORLD_RANK", "PMIX_RANK")


def rank_from_environment() -> int:
    """Rank that an MPI launcher announces; known before, and without, MPI."""
    return next((int(os.environ[name]) for name in RANKS if name in os.environ), 0)


def launched() -> bool:
    """True if an MPI launcher has started this process."""
    return any(name in os.environ for name in RANKS)


def launcher() -> str | None:
    """Path of the `mpirun` of this Python's MPI: a wheel's or Conda's stands beside it."""
    own = Path(sys.executable).with_name("mpirun")
    return str(own) if own.exists() else shutil.which("mpirun")
