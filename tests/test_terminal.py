# SPDX-License-Identifier: LGPL-3.0-or-later
"""Texts of others on the terminal, and standard streams that cannot take what is printed."""

from __future__ import annotations

import errno
import io
import os
import re
import signal
import socket
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from cases.pad_cases import HERTZ
from harness.launch import fretfe, python
from rich.progress import Progress

from fretfe import __main__ as entry
from fretfe.cli import app
from fretfe.console import Console
from fretfe.halfplane import solve_half_planes
from fretfe.terminal import one_line, patient_streams, shown

SOURCES = Path(entry.__file__).parent
FULL = Path("/dev/full")
# Clears the line above, sets the title of the terminal, goes back to the begin of the line.
HOSTILE = "\x1b[1A\x1b[2K\x1b]0;mine\x07\rResults in /root"
HARMLESS = "␛[1A␛[2K␛]0;mine␇␍Results in /root"
MATERIAL = """
source = "{source}"
young = 70e3
poisson = 0.3
[units]
stress = "MPa"
"""


def test_commands_to_a_terminal_are_shown() -> None:
    assert shown(HOSTILE) == HARMLESS
    assert shown("a\tb\nΔK_T·√mm") == "a\tb\nΔK_T·√mm"
    # C1 controls, which some terminals heed, and a text that is read from the right.
    assert shown("\x9b2J\u202egnp") == "\ufffd2J\ufffdgnp"


def test_a_text_in_one_line() -> None:
    assert one_line('a\n[edges]\r\n\treference = 1\x1b"') == 'a [edges] reference = 1␛"'


def test_tables_show_texts_of_others_in_colours_of_their_own() -> None:
    out = io.StringIO()
    console = Console(file=out, force_terminal=True, color_system="standard")
    console.print(HOSTILE, style="bold", markup=False, highlight=False)
    assert out.getvalue() == f"\x1b[1m{HARMLESS}\x1b[0m\n"


def test_a_bar_has_its_commands(monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes the place of both streams while it is there."""
    out = io.StringIO()
    monkeypatch.setattr(sys, "stderr", out)
    with patient_streams():
        console = Console(stderr=True, force_terminal=True, width=40)
        with Progress(console=console) as bar:
            bar.add_task("steps", total=2)
            bar.console.print(HOSTILE, markup=False, highlight=False)
    text = out.getvalue()
    assert "\x1b[2K" in text and "steps" in text
    assert HARMLESS in text and text.count("␛") == HARMLESS.count("␛")


def test_nobody_prints_otherwise() -> None:
    """The child that draws speaks to its parent in JSON."""
    own = re.compile(r"rich\.console|rich import print|std(out|err)\.write")
    prints = re.compile(r"^\s*print\(", re.MULTILINE)
    sources = {path: path.read_text("utf-8") for path in SOURCES.rglob("*.py")}
    assert {path.name for path, text in sources.items() if own.search(text)} == {"console.py"}
    folders = {path.parent.name for path, text in sources.items() if prints.search(text)}
    assert folders == {"cli", "fretfe", "pictures"}


def test_a_material_of_somebody_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its source is one line of a comment, and nothing to the terminal."""
    source = r"a book\n[edges]\nreference_length = 1\u001b[2K"
    (tmp_path / "own.toml").write_text(MATERIAL.format(source=source))
    steel = "young = 210e3, poisson = 0.3"
    text = HERTZ.replace(steel, 'material = "own.toml"', 1)
    (tmp_path / "case.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    few = partial(solve_half_planes, elements=40)
    monkeypatch.setattr("fretfe.backends.halfplane.solve_half_planes", few)
    done = fretfe("run", "case.toml", "-o", "out", "--backend", "halfplane", "--no-report")
    assert done.returncode == 0, done.stderr
    assert "\x1b" not in done.stdout + done.stderr
    copy = (tmp_path / "out" / "case.toml").read_text().splitlines()
    told = "(a book [edges] reference_length = 1␛[2K)"
    assert [told in line for line in copy if line.startswith("#")] == [False, True]
    assert not [line for line in copy if line.startswith(("reference_length", "[edges]"))]


def test_a_backend_of_somebody_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.toml").write_text(f'title = "{"x" * 3}"\n["\\u001b[2K"]\n')
    done = fretfe("run", "case.toml", "-o", "out", "--backend", "\x1b[2K")
    assert done.returncode == 2
    assert "\x1b" not in done.stderr


@pytest.fixture(name="standard")
def _standard(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., io.TextIOWrapper]:
    """Sets the standard output."""

    def place(path: Path, encoding: str = "utf-8") -> io.TextIOWrapper:
        stream = path.open("w", encoding=encoding)
        monkeypatch.setattr(sys, "stdout", stream)
        return stream

    return place


def test_what_cannot_be_encoded_is_escaped(
    tmp_path: Path, standard: Callable[..., io.TextIOWrapper]
) -> None:
    with standard(tmp_path / "log", "ascii"), patient_streams() as lost:
        print("ΔK_T", flush=True)
        Console().print("√")
        assert lost() is None
    assert (tmp_path / "log").read_text() == "\\u0394K_T\n\\u221a\n"


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")
def test_a_full_disk_ends_no_run_and_is_told(
    standard: Callable[..., io.TextIOWrapper],
) -> None:
    with standard(FULL), patient_streams() as lost:
        for _ in range(3):
            print("step", flush=True)
            Console().print("table")
        found = lost()
        assert found is not None and found.errno == errno.ENOSPC


def test_a_reader_that_has_ended_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as stream:
        monkeypatch.setattr(sys, "stdout", stream)
        with patient_streams() as lost:
            print("step", flush=True)
            assert lost() is None


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")
def test_the_command_line_says_that_its_output_is_lost(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["fretfe", "schema"])
    with FULL.open("w") as stream:
        monkeypatch.setattr(sys, "stdout", stream)
        with pytest.raises(SystemExit) as ended:
            app.main()
    assert ended.value.code == 6
    assert "the standard output cannot be written: the disk is full" in capfd.readouterr().err


def test_a_folder_that_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    done = fretfe("check", "case.toml")
    assert done.returncode == 6
    assert "the folder that fretfe was started in is no longer there" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("rank", [0, 1])
@pytest.mark.parametrize(("option", "code"), [("--nonsense", 2), ("--help", 0)])
def test_an_end_before_mpi_ends_all_processes(
    monkeypatch: pytest.MonkeyPatch, rank: int, option: str, code: int
) -> None:
    """MPICH's launcher is told so; it does not look at exit codes before MPI is in use."""
    ours, launcher = socket.socketpair()
    with ours, launcher:
        monkeypatch.setattr(app, "_communicator", lambda: None)
        monkeypatch.setattr(app, "ALIKE", 0.0)
        monkeypatch.setenv("PMI_RANK", str(rank))
        monkeypatch.setenv("PMI_FD", str(ours.fileno()))
        assert fretfe("run", option).returncode == code
        assert launcher.recv(100) == f"cmd=abort exitcode={code}\n".encode()


def test_a_channel_that_is_none_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process that a process of MPI has started knows the number of a channel it has not."""
    monkeypatch.setattr(app, "_communicator", lambda: None)
    with (tmp_path / "file").open("w") as other:
        monkeypatch.setenv("PMI_FD", str(other.fileno()))
        assert fretfe("run", "--nonsense").returncode == 2
    assert (tmp_path / "file").read_text() == ""


def test_ctrl_c_while_libraries_are_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []

    def load() -> Callable[[], None]:
        seen.append(signal.getsignal(signal.SIGINT))
        return lambda: seen.append(signal.getsignal(signal.SIGINT))

    monkeypatch.setattr(entry, "_load", load)
    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        entry.main()
    finally:
        signal.signal(signal.SIGINT, before)
    assert seen == [signal.SIG_DFL, signal.default_int_handler]


def test_the_entry_loads_nothing_slow_before_that() -> None:
    done = python("-c", "import fretfe.__main__, sys; print('typing' in sys.modules)")
    assert done.stdout.split() == ["False"], done.stderr
