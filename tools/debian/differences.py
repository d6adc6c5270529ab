# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tell what fails on Debian unstable though it passed on Debian 13, and which packages differ.

`python3 tools/debian/differences.py LOG OLD NEW`: what test.sh printed, and the lists of packages
that it left for Debian 13 and for unstable (lines of a name and a version).
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

# What runs Python's libraries and is none itself.
OTHERS = re.compile(
    r"python3|cmake|g\+\+|ninja-build|openmpi-bin|xvfb|lib(basix|dolfinx|gmsh|hdf|openblas|petsc|vtk).*"
)
# What fretfe and its tests use themselves.
USED = re.compile(
    r"python3-(basix|dolfinx|ffcx|gmsh|h5py|jinja2|matplotlib|meshio|mpi4py|nanobind|numpy|pandas|"
    r"petsc4py|pydantic|pytest|pytest-timeout|pytest-xdist|pyvista|rich|scipy|tomli-w|typer|ufl|vtk|"
    r"xarray)"
)
# Names of failures that are printed.
MOST = 20


def family(package: str) -> str:
    """The name of a package without what changes with its version: python3-vtk, libpetsc."""
    if package == "python3":
        return package
    prefix = "python3-" if package.startswith("python3-") else ""
    return prefix + re.sub(r"(-real.*|[0-9.]+(-.*)?)$", "", package.removeprefix(prefix))


def _python(name: str) -> bool:
    return name.startswith("python3-")


def upstream(version: str) -> str:
    """A version as those give it who are not Debian: 3.13.0 of 1:3.13.0+ds-1."""
    return re.sub(r"[+~].*", "", re.sub(r"^\d+:|-[^-]*$", "", version))


def libraries(listing: str) -> dict[str, str]:
    """Versions of the families of packages in a list."""
    lines = (line.split() for line in listing.splitlines())
    return {
        family(name): upstream(version)
        for name, version in lines
        if _python(name) or OTHERS.fullmatch(name)
    }


def failures(log: str) -> list[str]:
    """Names of the tests that failed, on any rank."""
    found = re.findall(r"^(?:FAILED|ERROR|rank \d+:) (\S+::.*?)(?: - .*)?$", log, re.MULTILINE)
    return list(dict.fromkeys(found))


def is_in_tracebacks(package: str, log: str) -> bool:
    """Whether a failure went through a package: its Python files, its library or its messages."""
    name = package.removeprefix("python3-").removeprefix("lib")
    module = re.escape(name.replace("-", "_"))
    marks = rf"dist-packages/{module}[a-z]*[/.]|\blib{module}\S*\.so|\b{module.upper()} ERROR"
    return name != package and re.search(marks, log) is not None


def differences(log: str, old: str, new: str) -> str:
    """What is to be said of the failures in a log, with the packages before and after."""
    before, after = libraries(old), libraries(new)
    newer = {
        name: f"{name} {version} (Debian 13: {before.get(name, 'none')})"
        for name, version in sorted(after.items())
        if before.get(name) != version
    }
    named = [text for name, text in newer.items() if is_in_tracebacks(name, log)]
    failed = failures(log)
    lines = [f"Failed on Debian unstable: {len(failed)} tests", *failed[:MOST]]
    if named:
        lines += ["Packages that differ and stand in the tracebacks:", *named]
    else:
        lines += ["No traceback names a package that differs. Of those that fretfe uses differ:"]
        lines += [text for name, text in newer.items() if USED.fullmatch(name) or not _python(name)]
    return "\n".join(lines)


if __name__ == "__main__":
    print(differences(*(Path(each).read_text("utf-8", "replace") for each in sys.argv[1:4])))
