# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pages as a reader follows them: files are saved, commands and examples run, one after the other.

What a page may hold: fenced blocks of `toml` (a file if `<!-- file: NAME -->` stands before it, new
values of one after `<!-- change: OLD to NEW -->`), of `python` (with the `text` that it prints, if
one follows) and of `sh`, and lines of commands that are set in.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from harness import launch

ROOT = Path(__file__).parents[2]
# These make or leave the environment in which the tests run.
SET_UP = ("make", "source", "pip")
BLOCK = re.compile(
    r"(?:<!-- (?:file: (?P<file>\S+)|change: (?P<old>\S+) to (?P<new>\S+)) -->\n+)?"
    r"^ *```(?P<kind>\w*)\n(?P<fenced>.*?)^ *```$"
    r"|^\n(?P<set_in>(?: {4,6}\S[^\n]*\n)+)$",
    re.DOTALL | re.MULTILINE,
)


@dataclass(frozen=True)
class Block:
    """A block of a page: its kind, its lines, the file to save it as, and the file it changes."""

    kind: str
    text: str
    file: str
    change_of: str = ""


def blocks(page: Path) -> Iterator[Block]:
    """All blocks of a page."""
    for found in BLOCK.finditer(page.read_text("utf-8")):
        if found["set_in"] is not None:
            yield Block("sh", textwrap.dedent(found["set_in"]), "")
        else:
            file = found["file"] or found["new"] or ""
            yield Block(found["kind"], found["fenced"], file, found["old"] or "")


def changed(text: str, lines: str) -> str:
    """A case with other values of some keys; keys and tables that it lacks come last."""
    for line in lines.splitlines():
        key, equals, _ = line.partition("=")
        text, count = (
            re.subn(rf"^{key}=.*$", line, text, flags=re.MULTILINE) if equals else (text, 0)
        )
        text += "" if count else f"{line}\n"
    return text


@dataclass
class Reader:
    """Follows a page in a folder.

    Attributes:
        folder: what the page calls the present folder.
        coarser: replaced in files, examples and commands, so that they are solved in seconds.
        names: those of the Python examples.
        printed: by the last example; None if it has been compared.
    """

    folder: Path
    coarser: Mapping[str, str]
    names: dict[str, Any] = field(default_factory=dict)
    printed: str | None = None
    done: int = 0

    def follow(self, page: Path) -> None:
        """Do what the page says."""
        for block in blocks(page):
            self._follow(block)

    def save(self, name: str, text: str) -> None:
        """Save a file, made coarser."""
        (self.folder / name).write_text(self._coarser(text))

    def _coarser(self, text: str) -> str:
        for fine, coarse in self.coarser.items():
            text = text.replace(fine, coarse)
        return text

    def _follow(self, block: Block) -> None:
        if block.change_of:
            text = (self.folder / block.change_of).read_text()
            self.save(block.file, changed(text, block.text))
        elif block.file:
            self.save(block.file, block.text)
        elif block.kind == "python":
            self._example(block.text)
        elif block.kind == "sh":
            for line in self._coarser(block.text).replace("\\\n", " ").splitlines():
                self._command(shlex.split(line, comments=True))
        elif block.kind == "text" and self.printed:
            assert block.text == self.printed
            self.printed = None
        else:
            assert block.kind in ("text", "", "toml"), block
            return
        self.done += 1

    def _example(self, text: str) -> None:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(self._coarser(text), "example.py", "exec"), self.names)
        self.printed = printed.getvalue()

    def _command(self, words: list[str]) -> None:
        if not words or words[0] in SET_UP:
            return
        if words[0] == "cp":
            for source in words[1:-1]:
                target = self.folder / words[-1]
                target = target / Path(source).name if target.is_dir() else target
                self.save(target.name, (ROOT / source).read_text("utf-8"))
            return
        ranks = 1
        if words[0] == "mpirun":
            ranks, words = int(words[2]), words[3:]
        assert words[0] == "fretfe", words
        if ranks > 1 or "--ranks" in words:  # which starts mpirun in place of its process
            ended = launch.python("-m", *words, ranks=ranks)
        else:
            ended = launch.fretfe(*words[1:])
        # A mesh that was made coarser fails its validation, rightly.
        fine = (0, 1) if words[1] == "validate" else (0,)
        assert ended.returncode in fine, (words, ended.stdout[-2000:], ended.stderr[-2000:])
