# SPDX-License-Identifier: LGPL-3.0-or-later
"""Help, exit codes, verbosity and colour of the command line, and their description."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
import typer
from cases.pad_cases import HERTZ
from harness import launch
from typer.testing import CliRunner

import fretfe
from fretfe.cli import app as cli
from fretfe.errors import CaseError

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs" / "command-line.md").read_text("utf-8")
COMMANDS = typer.main.get_command(cli.app).commands  # type: ignore[attr-defined]


@pytest.fixture
def pad(tmp_path: Path) -> Path:
    (tmp_path / "pad.toml").write_text(HERTZ)
    return tmp_path / "pad.toml"


@dataclass(frozen=True)
class Done:
    """How a command ended, and what it printed."""

    code: int
    out: str
    err: str


class Command:
    """Calls the command line in this process."""

    def __init__(
        self, pad: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        self.pad, self._monkeypatch, self._capsys = pad, monkeypatch, capsys

    def __call__(self, *options: str, command: str = "run", backend: str = "halfplane") -> Done:
        arguments = ["fretfe", command, str(self.pad), "-o", str(self.pad.parent / "out")]
        self._monkeypatch.setattr(sys, "argv", [*arguments, "--backend", backend, *options])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        code = ended.value.code
        return Done(int(code or 0), *self._capsys.readouterr())


@pytest.fixture
def run(pad: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return Command(pad, monkeypatch, capsys)


LIGHT = """
import sys
import fretfe.cli.app
print(sorted({"numpy", "pydantic", "matplotlib", "dolfinx"} & set(sys.modules)))
"""


def test_the_help_needs_no_library_of_the_commands() -> None:
    assert launch.python("-c", LIGHT).stdout == "[]\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_guide_describes_every_command_with_every_option(command: str) -> None:
    section = GUIDE.split(f"\n## `fretfe {command}`\n")[1].split("\n## ")[0]
    for parameter in COMMANDS[command].params:
        if parameter.name == "help":
            continue
        for name in (*parameter.opts, *parameter.secondary_opts):
            shown = name if name.startswith("-") else str(parameter.metavar or name)
            assert f"`{shown}" in section or f", {shown}" in section, shown


def test_guide_has_no_other_commands() -> None:
    assert set(re.findall(r"^## `fretfe (\w+)`$", GUIDE, re.MULTILINE)) == set(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_examples_that_begin_with_the_command(command: str) -> None:
    epilog = COMMANDS[command].epilog
    assert f"\n  fretfe {command} " in epilog or f"\n  fretfe {command}\n" in epilog


def test_the_help_says_of_each_command_what_it_does_in_a_whole_sentence() -> None:
    printed = CliRunner().invoke(cli.app, ["--help"], env={"COLUMNS": "80"}).output
    lines = printed.partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    assert [line.split()[0] for line in lines] == list(COMMANDS)
    assert [line for line in lines if not line.endswith((".", "?")) or "..." in line] == []


def test_exit_codes_are_in_the_help_and_in_the_guide() -> None:
    codes = dict(re.findall(r"^  (\d[\d, ]*)  (.*)$", cli.EXIT_CODES, re.MULTILINE))
    assert list(codes) == [*map(str, range(10)), "129, 130, 143"]
    assert dict(re.findall(r"^\| (\d[\d, ]*) \| (.*) \|$", GUIDE, re.MULTILINE)) == codes
    printed = CliRunner().invoke(cli.app, ["--help"]).output
    assert all(f"    {code}  {text}\n" in printed for code, text in codes.items())


def test_quiet_prints_nothing_if_all_is_well(run: Command) -> None:
    assert run("--quiet") == Done(0, "", "")
    assert run("-q", "--vary", "contacts.main.friction=0.4,0.5", command="sweep") == Done(0, "", "")


def test_quiet_prints_warnings_and_errors(run: Command) -> None:
    # A cycle that begins with the virgin state is not the steady one.
    done = run("-q", "--set", "loads.shear.cycles=1", backend="halfplane")
    assert (done.code, done.out) == (0, "")
    assert "Warning: main: not in steady state" in done.err
    done = run("-q", "--set", "contacts.main.friction=-1")
    assert done.code == 2 and "friction: expected a number >= 0" in done.err


def test_a_sweep_says_what_failed_even_if_quiet(run: Command) -> None:
    done = run("-q", "--vary", "contacts.main.friction=0.05,0.4", command="sweep")
    assert (done.code, done.out) == (0, "")
    assert "Warning: contacts.main.friction = 0.05: " in done.err


def test_a_sweep_of_which_nothing_can_be_solved_ends_with_its_own_code(run: Command) -> None:
    done = run("--vary", "contacts.main.friction=0.01,0.05", command="sweep")
    assert done.code == 5 and "no variant could be solved; the first: " in done.err
    assert (run.pad.parent / "out" / "sweep.csv").exists()


def test_bad_ranges_are_refused_before_a_folder_is_made(run: Command) -> None:
    for text in ("contacts.main.friction=0.1:0.6", "contacts.mian.friction=0.1,0.2"):
        done = run("--vary", text, command="sweep")
        assert done.code == 2 and done.err.count("\n") == 1
    assert not (run.pad.parent / "out").exists()


def test_verbose_prints_timings(run: Command) -> None:
    done = run("--verbose", backend="halfplane")
    assert "Timings" in done.out and "step 20/20" in done.out
    assert "Timings" not in run().out


def test_quiet_and_verbose_contradict_each_other(run: Command) -> None:
    done = run("-q", "-v")
    assert done.code == 2 and "found both" in done.err


def on_terminal(pad: Path, **environment: str) -> bytes:
    """What the command prints when both of its streams are a terminal."""
    outer, inner = pty.openpty()
    arguments = ["run", str(pad), "-o", str(pad.parent / "out"), "--backend", "halfplane"]
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "fretfe", *arguments, "--no-report"],
        stdin=subprocess.DEVNULL,
        stdout=inner,
        stderr=inner,
        env={**launch.ENVIRONMENT, "TERM": "xterm-256color", **environment},
    )
    os.close(inner)
    printed = b""
    while True:
        try:
            part = os.read(outer, 4096)
        except OSError:  # Linux's way to say that nobody writes any more
            break
        if not part:
            break
        printed += part
    os.close(outer)
    assert process.wait(60) == 0, printed.decode()
    return printed


def test_colour_only_on_terminals_and_not_with_no_color(pad: Path, run: Command) -> None:
    coloured = re.compile(rb"\x1b\[[0-9;]*3[0-7]")
    assert b"\x1b[1" in on_terminal(pad)
    assert not coloured.search(on_terminal(pad, NO_COLOR="1"))
    assert "\x1b" not in run("--no-report").out


def test_completion() -> None:
    """What the script of `fretfe --install-completion` asks for."""
    asked = {"_FRETFE_COMPLETE": "complete_bash", "COMP_WORDS": "fretfe sw", "COMP_CWORD": "1"}
    done = subprocess.run(
        [Path(sys.executable).with_name("fretfe")],
        capture_output=True,
        text=True,
        timeout=60,
        env=launch.ENVIRONMENT | asked,
    )
    assert done.stdout.split() == ["sweep"]


@pytest.mark.parametrize("command", [(), ("run",), ("strength",)])
def test_short_help_is_the_long_one(command: tuple[str, ...]) -> None:
    short, long = (CliRunner().invoke(cli.app, [*command, each]) for each in ("-h", "--help"))
    assert short.exit_code == 0 and short.output == long.output and "Usage: " in short.output


def test_version() -> None:
    done = CliRunner().invoke(cli.app, ["--version"])
    assert (done.exit_code, done.output) == (0, f"fretfe {fretfe.__version__}\n")


@pytest.mark.parametrize(
    ("folder", "words"),
    [
        (b".", ["check", b"caf\xe9/pad.toml"]),
        (b".", ["run", b"caf\xe9/pad.toml", "-o", "out"]),
        (b".", ["run", "none.toml", "-o", b"caf\xe9/out", "--backend", "halfplane"]),
        (b".", ["report", b"caf\xe9"]),
        (b"caf\xe9", ["check", "pad.toml"]),
    ],
    ids=["check", "run", "output", "report", "working-folder"],
)
def test_names_that_are_not_utf8_are_refused(
    tmp_path: Path, folder: bytes, words: list[str | bytes]
) -> None:
    """Neither a case as it was run nor the libraries of meshes and fields can name them."""
    place = os.path.join(os.fsencode(tmp_path), folder)
    os.makedirs(os.path.join(place, b"caf\xe9"))
    done = subprocess.run([sys.executable, "-m", "fretfe", *words], cwd=place, capture_output=True)
    assert done.returncode == CaseError.exit_code
    text = done.stderr.decode()
    assert "expected names in UTF-8" in text and "caf\\udce9" in text
    assert "Traceback" not in text


def test_a_working_folder_without_utf8_has_help(tmp_path: Path) -> None:
    place = os.path.join(os.fsencode(tmp_path), b"caf\xe9")
    os.makedirs(place)
    words = [sys.executable, "-m", "fretfe", "run", "--help"]
    assert subprocess.run(words, cwd=place, capture_output=True).returncode == 0
