# SPDX-License-Identifier: LGPL-3.0-or-later
"""Source package and wheel: what is in them, and that the wheel works where there is no DOLFINx.

`make test-light` runs `fretfe verify` where fretfe is installed so. Needs the network: pip gets the
build tools and what fretfe depends on.
"""

from __future__ import annotations

import email.parser
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email.message import Message
from pathlib import Path

import pytest
from cases.pad_cases import HERTZ
from project.test_layers import FEM_ONLY

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
# What neither belongs into a package nor into the copy that it is built from.
LEFT_OUT = shutil.ignore_patterns(".*", "build", "dist", "__pycache__", "*.so", "*.egg-info")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
# Another environment's packages must not be seen, and old pips warn.
ENVIRONMENT = {
    name: value
    for name, value in os.environ.items()
    if name not in ("PYTHONPATH", "PYTHONHOME", "PYTHONWARNINGS", "VIRTUAL_ENV")
}


def run(*command: str | Path, cwd: Path) -> str:
    done = subprocess.run(
        list(map(str, command)),
        cwd=cwd,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
        timeout=900,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def sources(folder: Path) -> set[str]:
    """Return all files below a folder of the repository, as `fretfe/...`."""
    return {
        str(path.relative_to(ROOT))
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and path.suffix not in (".pyc", ".so")
    }


def left_out(folder: str, names: list[str]) -> set[str]:
    """Return the names in a folder that are not copied; results stand in the root."""
    return LEFT_OUT(folder, names) | ({"results"} & set(names) if Path(folder) == ROOT else set())


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what `make wheels` makes for PyPI, without git."""
    copy = shutil.copytree(ROOT, tmp_path_factory.mktemp("packages") / "copy", ignore=left_out)
    run("tools/wheels.sh", sys.executable, cwd=copy)
    return Path(copy) / "build" / "dist"


@pytest.fixture(scope="module")
def source_files(packages: Path) -> set[str]:
    (path,) = packages.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        return {name.split("/", 1)[1] for name in archive.getnames()}


@pytest.fixture(scope="module")
def wheel(packages: Path) -> Path:
    (path,) = packages.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def wheel_files(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return {name for name in archive.namelist() if not name.endswith("/")}


@pytest.fixture(scope="module")
def metadata(wheel: Path) -> Message:
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return email.parser.Parser().parsestr(archive.read(name).decode())


@pytest.fixture(scope="module")
def clean(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the programs of an environment with the wheel and what it depends on."""
    folder = tmp_path_factory.mktemp("clean") / "venv"
    run(sys.executable, "-m", "venv", folder, cwd=wheel.parent)
    pip = (folder / "bin" / "python", "-m", "pip", "install", "--quiet", "--no-compile")
    run(*pip, wheel, cwd=wheel.parent)
    return folder / "bin"


def test_source_package_has_the_sources_and_no_more(source_files: set[str]) -> None:
    beside = {"CHANGELOG.md", "CITATION.cff", "CMakeLists.txt", "CONTRIBUTING.md", "LICENSE"}
    beside |= {"codemeta.json"}
    beside |= {"LICENSE.GPL", "PKG-INFO", "README.md", "pyproject.toml"}
    folders = ("fretfe", "meshes", "docs")
    assert source_files == beside.union(*(sources(Path(each)) for each in folders))


def test_wheel_has_the_package_and_no_more(wheel_files: set[str]) -> None:
    package = {name for name in wheel_files if ".dist-info/" not in name}
    libraries = {name for name in package if name.endswith(".so")}
    assert libraries == {f"fretfe/_core/{name}.so" for name in ("_kernels.abi3", "_gemmt")}
    python = {name for name in sources(Path("fretfe")) if not name.endswith((".cpp", ".hpp"))}
    data = {f"fretfe/{name}" for name in sources(Path("meshes"))}
    glossary = "fretfe/report/page/glossary.md"
    assert package == python | data | libraries | {glossary}
    # The report and a check read these files when they run.
    assert {"fretfe/report/page/report.css", "fretfe/report/page/report.html.j2"} < package
    assert {
        "fretfe/meshes/dovetail.geo",
        "fretfe/quality/sliding_wedge.msh",
        "fretfe/quality/pad.msh",
        "fretfe/quality/plate.msh",
    } < package


def test_wheel_is_for_all_pythons_from_3_12_on_and_glibc_from_2_34_on(wheel: Path) -> None:
    assert "-cp312-abi3-manylinux_2_34_" in wheel.name


def test_licences_are_in_the_wheel(wheel_files: set[str], metadata: Message) -> None:
    assert metadata["License-Expression"] == PROJECT["license"]
    assert metadata.get_all("License-File") == PROJECT["license-files"]
    licences = {name.rsplit("/", 1)[1] for name in wheel_files if "/licenses/" in name}
    assert licences == set(PROJECT["license-files"])


def test_metadata(metadata: Message) -> None:
    assert (metadata["Name"], metadata["Version"]) == (PROJECT["name"], PROJECT["version"])
    assert metadata["Requires-Python"] == PROJECT["requires-python"]
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert metadata.get_payload() == (ROOT / "README.md").read_text("utf-8")
    extras = set(metadata.get_all("Provides-Extra") or ())
    assert extras == set(PROJECT["optional-dependencies"])


def test_clean_environment_has_no_dolfinx(clean: Path, tmp_path: Path) -> None:
    run(clean / "python", "-m", "pip", "check", cwd=tmp_path)
    listing = json.loads(run(clean / "pip", "list", "--format", "json", cwd=tmp_path))
    assert FEM_ONLY.isdisjoint(each["name"].replace("-", "_") for each in listing)


def test_installed_wheel_lists_templates(clean: Path, tmp_path: Path) -> None:
    printed = run(clean / "fretfe", "templates", cwd=tmp_path)
    assert all(path.stem in printed for path in (ROOT / "meshes").glob("*.geo"))


def test_installed_wheel_solves_a_case(clean: Path, tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(HERTZ)
    run(clean / "fretfe", "run", "case.toml", "--backend", "halfplane", "-o", "out", cwd=tmp_path)
    assert json.loads((tmp_path / "out" / "results.json").read_text())["contacts"]
    assert "<html" in (tmp_path / "out" / "report.html").read_text("utf-8")
