# SPDX-License-Identifier: LGPL-3.0-or-later
"""Signals are not for PETSc, which prints a page about each of them."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from harness.launch import python

CAUGHT = """
import fretfe.fem._compat
mask = next(line for line in open("/proc/self/status") if line.startswith({key!r}))
print(mask.split()[1])
"""
IGNORING = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)"


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="there is no /proc")
@pytest.mark.parametrize(
    ("key", "before", "signals"),
    [("SigCgt", "", set()), ("SigIgn", IGNORING, {signal.SIGHUP, signal.SIGPIPE})],
    ids=["caught", "ignored"],
)
def test_petsc_takes_no_signal(key: str, before: str, signals: set[signal.Signals]) -> None:
    done = python("-c", before + CAUGHT.format(key=key))
    mask = int(done.stdout, 16)
    asked = {signal.SIGHUP, signal.SIGPIPE, signal.SIGQUIT, signal.SIGTERM}
    assert {each for each in asked if mask >> (each - 1) & 1} == signals
