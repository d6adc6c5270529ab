# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs in an address space that is too small for them, or with cores to spare."""

from __future__ import annotations

import resource
import subprocess
from pathlib import Path

import pytest
from cases.pad_cases import pad
from harness.interruptions import arguments
from harness.launch import ENVIRONMENT, command_line

from fretfe.case import parse_case
from fretfe.environment import address_room
from fretfe.errors import MemoryShortError
from fretfe.fem import backend as room
from fretfe.loads import build_history
from fretfe.mesh import cost
from fretfe.runner import Runner
from fretfe.surface.checks import load_mesh

MIB = 2**20
# What a user's mistake, a missing library and a lack of memory may end with, and a run that fits.
TOLD = (0, 7, 8)


def limited(limit: int, *command: str) -> subprocess.CompletedProcess[str]:
    """A process with so many bytes of address space."""
    return subprocess.run(
        list(command),
        capture_output=True,
        text=True,
        timeout=240,
        env=ENVIRONMENT,
        stdin=subprocess.DEVNULL,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )


def test_the_room_of_a_process_is_what_its_limit_leaves() -> None:
    program = "from fretfe.environment import address_room; print(address_room())"
    done = limited(3000 * MIB, *command_line("-c", program))
    assert 1000 * MIB < float(done.stdout) < 3000 * MIB, done.stderr
    unlimited = resource.getrlimit(resource.RLIMIT_AS)[0] == resource.RLIM_INFINITY
    assert (address_room() == float("inf")) == unlimited


def test_no_run_begins_without_room_for_the_linear_algebra(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room.take_work_space.cache_clear()
    monkeypatch.setattr(room, "address_room", lambda: 100.0 * MIB)
    with pytest.raises(MemoryShortError, match=r"may take 100 MiB more .* expected 512 MiB"):
        Runner.find("fem").run(parse_case(pad()), None)


@pytest.mark.slow
@pytest.mark.parametrize("limit", [700, 1000, 1200])
def test_a_lack_of_memory_is_told(tmp_path: Path, limit: int) -> None:
    done = limited(limit * MIB, *command_line(*arguments(tmp_path / "run")))
    said = done.stdout + done.stderr
    assert done.returncode in TOLD, said
    assert "Traceback" not in said


def test_a_long_run_on_one_process_is_told_of_the_other_cores(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = parse_case(pad())
    mesh, history = load_mesh(case), build_history(case)
    told = []
    for cores, long in ((4, 0.0), (4, 60.0), (1, 0.0)):
        monkeypatch.setattr(room, "idle_cores", lambda cores=cores: cores - 1)
        monkeypatch.setattr(cost, "LONG_RUN", long)
        monkeypatch.setattr(cost, "STARTING", 0.0)
        monkeypatch.setattr(cost, "STEP", 0.0)
        monkeypatch.setattr(cost, "DRAWING", {2: 0.0})
        told.append(room._advice(case, mesh, history))
    assert "4 cores are there: --ranks 4" in told[0]
    assert told[1:] == ["", ""]
