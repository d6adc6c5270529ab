# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which BLAS is the slow one, how many threads it gets, what is said of a missing package."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import requires
from pathlib import Path

import pytest
from cases import pad_cases
from harness.launch import python
from threadpoolctl import threadpool_info, threadpool_limits

from fretfe import environment
from fretfe.__main__ import main
from fretfe.backends import Observer
from fretfe.case import load_case
from fretfe.environment import memory_shortage, missing_package, reference_blas
from fretfe.runner import Runner

DEBIAN = "/usr/lib/x86_64-linux-gnu"


def test_the_reference_blas_is_told_from_others() -> None:
    reference = f"{DEBIAN}/blas/libblas.so.3.12.1"
    others = [
        f"{DEBIAN}/openblas-pthread/libblas.so.3",
        f"{DEBIAN}/atlas/libblas.so.3",
        f"{DEBIAN}/libCombBLAS.so.2.0.0",
        "/venv/numpy.libs/libscipy_openblas64_-56d6093b.so",
        "/usr/lib/python3/dist-packages/scipy/linalg/_fblas.cpython-313-x86_64-linux-gnu.so",
    ]
    assert reference_blas(others) == []
    # An optimised one beside it is not that of PETSc.
    assert reference_blas([*others, reference]) == [reference]
    assert reference_blas(["/opt/lib/librefblas.so.3"]) == ["/opt/lib/librefblas.so.3"]


def test_a_link_to_an_optimised_blas_is_followed(tmp_path: Path) -> None:
    """Conda calls all of them libblas.so.3."""
    (tmp_path / "libopenblasp-r0.3.30.so").touch()
    (tmp_path / "libblas.so.3").symlink_to("libopenblasp-r0.3.30.so")
    assert reference_blas([str(tmp_path / "libblas.so.3")]) == []


def test_every_requirement_has_a_remedy() -> None:
    names = [each.split(">=")[0] for each in requires("fretfe") or [] if "extra ==" not in each]
    assert len(names) > 5
    for name in names:
        module = name.replace("-", "_")
        text = missing_package(ModuleNotFoundError("", name=f"{module}.sub"))
        assert f"pip install {name}`" in text and f"(Debian: python3-{name})" in text


@pytest.mark.parametrize("kind", [ImportError, ModuleNotFoundError])
def test_other_errors_have_none(kind: type[ImportError]) -> None:
    """A module of a user's own, and one that is there but broken."""
    assert missing_package(kind("", name="mine")) == missing_package(kind("broken")) == ""
    assert missing_package(ImportError("cannot import name", name="scipy")) == ""


def without(module: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command `fretfe` where a module is missing."""
    code = (
        f"import sys; sys.modules[{module!r}] = None; sys.argv = {['fretfe', *arguments]}; "
        "from fretfe.__main__ import main; main()"
    )
    return python("-c", code)


@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        ("typer", ["schema"]),
        ("pydantic", ["schema"]),
        ("h5py", ["run", "case.toml", "--backend", "halfplane", "-o", "out"]),
    ],
)
def test_a_package_that_is_missing_is_named(module: str, arguments: list[str]) -> None:
    done = without(module, *arguments)
    assert done.returncode == 7
    assert f"python3-{module}" in done.stderr and "Traceback" not in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(("given", "used"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, None)])
def test_one_thread_unless_the_user_says_otherwise(
    monkeypatch: pytest.MonkeyPatch, given: dict[str, str], used: str | None
) -> None:
    environment = dict(given)
    monkeypatch.setattr(os, "environ", environment)
    monkeypatch.setattr("fretfe.cli.app.main", lambda: None)
    main()
    assert environment.get("OMP_NUM_THREADS") == used


@pytest.mark.parametrize(("given", "used"), [({}, 1), ({"OMP_NUM_THREADS": "2"}, 2)])
def test_programs_solve_with_one_thread_too(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, given: dict[str, str], used: int
) -> None:
    """Each BLAS that is loaded; the program has its threads again after it."""
    for name in environment.THREADS:
        monkeypatch.delenv(name, raising=False)
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    (tmp_path / "case.toml").write_text(pad_cases.pad_text())
    case, seen = load_case(tmp_path / "case.toml"), list[list[int]]()

    class Threads(Observer):
        def step(self, number: int, count: int, text: str) -> None:
            seen.append(blas_threads())

    with threadpool_limits(2, "blas"):
        before = blas_threads()
        Runner.find("halfplane").run(case, observer=Threads())
        assert blas_threads() == before
    assert max(before) == 2 and max(map(max, seen)) == used


def blas_threads() -> list[int]:
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


def test_out_of_memory_is_told() -> None:
    petsc = RuntimeError("error code 55")
    petsc.ierr = 55  # type: ignore[attr-defined]
    for error in (MemoryError(), petsc):
        assert "there is not enough memory" in memory_shortage(error)
    assert not memory_shortage(RuntimeError())


@pytest.mark.parametrize(
    "error",
    [
        ImportError("libopenblas.so: failed to map segment from shared object"),
        OSError("libgmsh.so: cannot map: Cannot allocate memory"),
    ],
)
def test_a_library_without_room_is_told(error: Exception) -> None:
    """Also where another error is made of it."""
    outer = RuntimeError("cannot load")
    outer.__cause__ = error
    assert "there is not enough memory" in memory_shortage(outer)


def test_a_small_address_space(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not memory_shortage(SystemError("error return without exception set"))
    monkeypatch.setattr(environment, "address_room", lambda: 100 * 2.0**20)
    assert memory_shortage(SystemError("error return without exception set"))
    assert not memory_shortage(ModuleNotFoundError("numpy", name="numpy"))
    text = environment.too_little_room(2.0**30, "this takes")
    assert "may take 100 MiB more" in text
    assert "expected 1024 MiB, which this takes" in text


@pytest.mark.parametrize("limit", [100_000, 300_000])
def test_commands_in_a_small_address_space(tmp_path: Path, limit: int) -> None:
    (tmp_path / "case.toml").write_text(pad_cases.pad_text())
    words = f"ulimit -v {limit}; exec {sys.executable} -m fretfe run case.toml -o out -q"
    done = subprocess.run(["sh", "-c", words], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 8, done.stderr
    assert done.stderr.startswith("fretfe: error: there is not enough memory")
