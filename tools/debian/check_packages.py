# SPDX-License-Identifier: LGPL-3.0-or-later
"""Check on Debian that all that fretfe needs is there, and name the packages that bring it.

docs/install.md lists packages. Everything here is to be on that list, even where another package
brings it by chance: `python3 tools/debian/check_packages.py`, in the checkout.
"""

from __future__ import annotations

import importlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

ROOT = Path(__file__).parents[2]
PYPROJECT = ROOT / "pyproject.toml"
PAGE = ROOT / "docs" / "install.md"

# The extra `fem` names the wheel; Debian has DOLFINx itself.
FEM = ["fenics-dolfinx>=0.9", "gmsh>=4.11", "mpi4py>=4"]
# Debian packages that are not called python3-NAME, and modules not called as on PyPI.
PACKAGES = {"fenics-dolfinx": "python3-dolfinx-real"}
MODULES = {"fenics-dolfinx": "dolfinx.fem.petsc", "pytest-xdist": "xdist"}


def blas_is_fast() -> None:
    """Whether libblas.so.3, which PETSc and SciPy are linked with, is OpenBLAS."""
    listing = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, check=True).stdout
    found = re.findall(r"libblas\.so\.3 .*=> (.*)", listing)
    if not any("openblas" in str(Path(path).resolve()) for path in found):
        raise LookupError(f"libblas.so.3 is {found[0] if found else 'missing'}, not OpenBLAS")


def command(*names: str) -> Callable[[], None]:
    """A check that these commands exist."""

    def check() -> None:
        for name in names:
            if shutil.which(name, path="/usr/local/bin:/usr/bin:/bin") is None:
                raise LookupError(f"there is no command {name}")

    return check


def headers() -> None:
    """Whether C code can be compiled against this Python; DOLFINx does that for every form."""
    header = Path(sysconfig.get_path("include"), "Python.h")
    if not header.exists():
        raise LookupError(f"there is no {header}")


def module(name: str) -> Callable[[], None]:
    """A check that a module can be imported."""

    def check() -> None:
        importlib.import_module(name)

    return check


# Besides Python packages: what each Debian package is for.
OTHERS: dict[str, Callable[[], None]] = {
    "libopenblas0-pthread": blas_is_fast,
    "openmpi-bin": command("mpirun"),
    "xvfb": command("xvfb-run", "Xvfb"),
    "xauth": command("xauth"),
    "g++": command("g++"),
    "cmake": command("cmake"),
    "ninja-build": command("ninja"),
    "python3-dev": headers,
    "python3-venv": module("ensurepip"),
}


def requirements() -> list[str]:
    """What pyproject.toml requires to build, to run and to test, with Debian's DOLFINx."""
    content = tomllib.loads(PYPROJECT.read_text("utf-8"))
    extras = content["project"]["optional-dependencies"]
    return [
        *content["project"]["dependencies"],
        *FEM,
        *extras["report"],
        *content["build-system"]["requires"],
        *extras["test"],
    ]


def name_of(requirement: str) -> str:
    """The name in a requirement such as "numpy>=1.26"."""
    return re.split(r"[<>=!~;\[ ]", requirement)[0]


def package_of(requirement: str) -> str:
    """The Debian package that brings a requirement."""
    name = name_of(requirement)
    return PACKAGES.get(name, f"python3-{name}")


def packages_needed() -> set[str]:
    """All packages that docs/install.md must name."""
    return {package_of(each) for each in requirements()} | set(OTHERS)


def packages_named() -> set[str]:
    """All packages that docs/install.md tells to install."""
    block = re.search(
        r"<!-- debian: packages -->\n+```sh\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL
    )
    if block is None:
        sys.exit(f"{PAGE}: expected a code block after <!-- debian: packages -->")
    text = re.sub(r"#.*|\\\n", "", block[1])
    words = [word for line in text.splitlines() for word in line.split()[2:]]
    return {word for word in words if not word.startswith("-")}


def check_requirement(requirement: str) -> None:
    """Raise an error unless a Python package is there, in a version that fits, and works."""
    from packaging.specifiers import SpecifierSet  # comes with scikit-build-core

    name = name_of(requirement)
    found = version(name)
    if not SpecifierSet(requirement.removeprefix(name)).contains(found, prereleases=True):
        raise LookupError(f"expected {requirement}, found {found}")
    importlib.import_module(MODULES.get(name, name.replace("-", "_")))


def problems() -> Iterator[str]:
    """What is missing, each with the package that brings it."""
    for package in sorted(packages_needed() - packages_named()):
        yield f"{package}: not on the list of docs/install.md of packages"
    checks = [
        (package_of(each), lambda each=each: check_requirement(each)) for each in requirements()
    ]
    for package, check in (*checks, *OTHERS.items()):
        try:
            check()
        except PackageNotFoundError as error:
            yield f"{package}: not installed ({error})"
        except (LookupError, ImportError, OSError) as error:
            yield f"{package}: {error}"


if __name__ == "__main__":
    found = list(problems())
    sys.exit("\n".join(["Debian packages that fretfe needs and lacks:", *found]) if found else 0)
