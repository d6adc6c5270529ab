# SPDX-License-Identifier: LGPL-3.0-or-later
"""Completion in shells, by the command as it is installed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(sys.executable).parent
# Completion must not depend on who started the tests, and needs no login shell.
ENVIRONMENT = {"PATH": f"{FOLDER}:{os.environ['PATH']}", "HOME": "/nowhere"}


def shell(*command: str, **more: str) -> str:
    done = subprocess.run(
        command,
        env={**ENVIRONMENT, **more},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    return done.stdout


@pytest.mark.parametrize(
    ("words", "place", "expected"),
    [
        ("fretfe ru", 1, ["run"]),
        ("fretfe run --rep", 2, ["--report"]),
    ],
)
def test_bash_completes_commands_and_options(words: str, place: int, expected: list[str]) -> None:
    script = shell("fretfe", _FRETFE_COMPLETE="source_bash")
    ask = f"COMP_WORDS=({words}) COMP_CWORD={place}; _fretfe_completion fretfe"
    show = 'echo "${COMPREPLY[*]}"'
    assert shell("bash", "-c", f"{script}\n{ask}; {show}").split() == expected


@pytest.mark.parametrize(
    ("name", "registers"),
    [("zsh", "compdef _fretfe_completion fretfe"), ("fish", "complete --command fretfe ")],
)
def test_scripts_for_other_shells_are_printed(name: str, registers: str) -> None:
    script = shell("fretfe", _FRETFE_COMPLETE=f"source_{name}")
    assert registers in script and f"_FRETFE_COMPLETE=complete_{name}" in script
