# SPDX-License-Identifier: LGPL-3.0-or-later
"""Draws in a process of its own, which may crash: VTK ends it where OpenGL does not work."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fretfe.environment import without_launcher

# Seconds for all files of a call.
TIMEOUT = 600.0
CRASHES = (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGILL)

NO_PYVISTA = (
    "PyVista is not installed; `pip install pyvista` installs it, on Debian apt install "
    "python3-pyvista"
)
NO_OPENGL = (
    "the process that draws ended with {}, as it does where OpenGL does not work without a "
    "display. On Debian and Ubuntu install libegl1 and libgl1-mesa-dri (VTK 9.4 and later), or "
    "xvfb and xauth"
)
NOT_IMPORTED = (
    "PyVista cannot be imported ({}). On Debian and Ubuntu VTK needs libgl1 and libxrender1"
)


def draw_in_child(
    task: str, directory: Path, files: Sequence[str], timeout: float = TIMEOUT
) -> dict[str, dict[str, Any]]:
    """Let `fretfe.report.pictures.render` draw some files.

    Args:
        task: which function of it does that.
        directory: results folder.
        files: what to draw.
        timeout: seconds.

    Returns:
        What was said about each file; `reason` if there is none.
    """
    reports: dict[str, dict[str, Any]] = {}
    reason = ""
    for launcher in _launchers():
        rest = [file for file in files if file not in reports]
        if rest:
            module = [sys.executable, "-P", "-m", "fretfe.report.pictures.render"]
            found, reason = _run([*launcher, *module, task, str(directory), *rest], timeout)
            reports |= found
    return {file: reports.get(file, {"reason": reason}) for file in files}


def _launchers() -> list[list[str]]:
    """As it is; then with a display of its own, if that can be had."""
    xvfb = shutil.which("xvfb-run")
    # Debian only recommends xauth together with xvfb, but xvfb-run does nothing without it.
    return [[], [xvfb, "-a"]] if xvfb and shutil.which("xauth") else [[]]


def _run(command: list[str], timeout: float) -> tuple[dict[str, dict[str, Any]], str]:
    """Reports of a process on each file, and the reason if it did not say more."""
    # A child must not take itself for a process of an MPI run. Its own session: a launcher and
    # all that it starts can be ended together.
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env=without_launcher(os.environ),
        start_new_session=True,
    )
    try:
        output, messages = process.communicate(timeout=timeout)
        reason = _reason(process.returncode, messages)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        output, _ = process.communicate()
        reason = f"drawing took more than {timeout:g} s"
    return _reports(output), reason


def _reports(output: str) -> dict[str, dict[str, Any]]:
    """The lines of JSON in an output; a crash may cut the last one, libraries may add others."""
    reports = {}
    for line in output.splitlines():
        try:
            report = json.loads(line)
            reports[report.pop("file")] = report
        except (ValueError, AttributeError, KeyError, TypeError):
            continue
    return reports


def _reason(code: int, messages: str) -> str:
    """Reason why a process ended, in words."""
    # A shell between us and the process says 128 + n for signal n.
    number = -code if code < 0 else code - 128
    if number > 0:
        known = number in set(signal.Signals)
        name = signal.Signals(number).name if known else f"signal {number}"
        crashed = known and signal.Signals(number) in CRASHES
        return NO_OPENGL.format(name) if crashed else f"the process that draws ended with {name}"
    lines = [line for line in messages.splitlines() if line.strip()]
    last = lines[-1].strip() if lines else f"exit code {code}"
    if last.startswith("ModuleNotFoundError") and "'pyvista'" in last:
        return NO_PYVISTA
    return NOT_IMPORTED.format(last) if last.startswith(("ImportError", "ModuleNot")) else last
