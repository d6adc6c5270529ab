# SPDX-License-Identifier: LGPL-3.0-or-later
"""What all tests share: markers by folder, and pytest on several MPI ranks.

Under mpirun every rank runs the same tests. Rank 0 alone writes the usual report; a failure on
another rank is written to standard error when it happens and fails the run of rank 0 too.
"""

from __future__ import annotations

import gc
import importlib.util
import os
import signal
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest

PETSC_DEPRECATION = "PETSc DEPRECATION WARNING"
TESTS = Path(__file__).parent
FEM_TESTS = [TESTS / name for name in ("fem", "system")]
# What PyVista or Gmsh draws or does, in files that also run where they are missing.
PICTURE_TESTS = [
    TESTS / "report" / f"test_{name}.py"
    for name in ("pictures", "pictures_solids", "pictures_stress", "page_solids")
]
PICTURE_TESTS += [TESTS / "results" / "test_writer_solids.py", TESTS / "project" / "test_start.py"]
PICTURE_TESTS += [TESTS / "bodies" / "test_free_ends.py"]
PLACES = {"fem": FEM_TESTS, "pictures": PICTURE_TESTS}
# Each takes a process a minute or so: they begin first, so that at the end none is waited for.
LONGEST = [
    TESTS / f"{name}.py"
    for name in (
        *("system/test_demos", "system/test_pages", "system/test_sphere", "fem/test_refine_solids"),
        *("project/test_packages", "system/test_verify", "system/test_ellipsoid_and_cylinder"),
        *("system/test_plane_in_space", "system/test_front_ends", "system/test_unlike_contacts"),
        *("fem/test_interaction_integral_fronts", "system/test_campaign", "system/test_faults"),
        *("system/test_speed", "system/test_campaign_solids", "system/test_campaign_first_jobs"),
        *("cli/test_laboratory_verify", "campaign/test_first_jobs"),
    )
]
# A slow test that hangs is ended after so many seconds.
SLOW_TIMEOUT = 1800
HAS_DOLFINX = importlib.util.find_spec("dolfinx") is not None
# Set by the launchers of MPICH and Open MPI; asking MPI itself would need mpi4py.
MPI_SIZE = int(os.environ.get("PMI_SIZE") or os.environ.get("OMPI_COMM_WORLD_SIZE") or 1)

# pytest makes warnings errors (pyproject.toml); so do the processes that tests start.
os.environ["PYTHONWARNINGS"] = "error"

if HAS_DOLFINX:
    # Before any other module that is linked with MPI.
    importlib.import_module("fretfe.fem._compat")
    # For a form that another process of pytest-xdist compiles; by default 10 s, which may be short.
    options: dict[str, Any] = importlib.import_module("dolfinx.jit").DOLFINX_DEFAULT_JIT_OPTIONS
    options["timeout"] = (240, options["timeout"][1])

# After the modules that are linked with MPI.
importlib.import_module("harness.plots").leave_plots_empty()

collect_ignore = [] if HAS_DOLFINX else [str(each) for each in FEM_TESTS]


class RankReports:
    """Make one result of the results of all ranks."""

    def __init__(self, config: pytest.Config) -> None:
        from mpi4py import MPI

        self.config = config
        # Its own communicator: messages of a test that went wrong cannot be mixed up with ours.
        self.comm = MPI.COMM_WORLD.Dup()
        self.sum = MPI.SUM
        self.failures: list[str] = []
        self.failures_seen = 0

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._note(report)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        self._note(report)

    def _note(self, report: pytest.TestReport | pytest.CollectReport) -> None:
        if not report.failed:
            return
        name = f"rank {self.comm.rank}: {report.nodeid}"
        self.failures.append(name)
        if self.comm.rank > 0:
            # Now, not at the end: the other ranks may be waiting for this one for ever.
            print(f"\n--- FAILED on {name}\n{report.longreprtext}", file=sys.__stderr__, flush=True)

    def pytest_collection_finish(self) -> None:
        # The modules need not be looked through after each test: 0.1 s.
        gc.collect()
        gc.freeze()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Any:
        result = yield
        # PETSc objects are destroyed by all ranks together, so none may be left to chance.
        gc.collect()
        petsc = sys.modules.get("petsc4py.PETSc")
        if petsc is not None:
            petsc.garbage_cleanup()
        failures = self.comm.allreduce(len(self.failures), op=self.sum)
        if failures > self.failures_seen and self.config.getoption("maxfail"):
            item.session.shouldfail = "a test failed on one of the ranks"
        self.failures_seen = failures
        return result

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        gathered = self.comm.allgather(self.failures)
        self.failures = [name for names in gathered[1:] for name in names]
        if self.failures and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self.failures:
            terminalreporter.section("failed on other ranks than 0")
            for name in self.failures:
                terminalreporter.line(name)


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        # A shell lets what it starts in the background, and all that this starts, ignore Ctrl-C.
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if MPI_SIZE == 1:
        return
    reports = RankReports(config)
    config.pluginmanager.register(reports, "rank-reports")
    if reports.comm.rank > 0:
        shown: Any = config.pluginmanager.unregister(name="terminalreporter")
        silent = open(os.devnull, "w")
        config.add_cleanup(silent.close)
        reporter = type(shown)(config, silent)  # pytest has no public name for it before 8.4
        config.pluginmanager.register(reporter, "terminalreporter")


def pytest_report_header() -> str:
    dolfinx = "found" if HAS_DOLFINX else "none, tests/fem and tests/system are left out"
    return f"DOLFINx: {dolfinx}; ranks: {MPI_SIZE}"


@cache
def markers_of(file: Path) -> list[str]:
    """Markers of all tests in a file."""
    around = {file, *file.parents}
    return [marker for marker, paths in PLACES.items() if not around.isdisjoint(paths)]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        for marker in markers_of(item.path):
            item.add_marker(marker)
        if item.get_closest_marker("slow") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(SLOW_TIMEOUT))
        if item.get_closest_marker("mpi") and not item.get_closest_marker("fem"):
            raise pytest.UsageError(
                f"{item.nodeid}: expected tests for several ranks in fem or system"
            )
    places = {file: place for place, file in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path, len(places)))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Any:
    """Fail a test in which PETSc printed that something is deprecated: it has no other way."""
    report: pytest.TestReport = yield
    if report.passed and PETSC_DEPRECATION in report.capstdout + report.capstderr:
        report.outcome = "failed"
        report.longrepr = f"printed: {PETSC_DEPRECATION}"
    return report


@pytest.fixture
def shared_path(tmp_path: Path) -> Path:
    """A fresh folder that is the same on all ranks (tmp_path is another one on each)."""
    if MPI_SIZE == 1:
        return tmp_path
    from mpi4py import MPI

    path: Path = MPI.COMM_WORLD.bcast(tmp_path, root=0)
    return path
