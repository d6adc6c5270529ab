# SPDX-License-Identifier: LGPL-3.0-or-later
"""Keywords of Abaqus and CalculiX input files with their data, those of included files in place."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from operator import length_hint
from pathlib import Path

from fretfe.errors import MeshError
from fretfe.files import DEEPEST_INCLUDE, MOST_BYTES, MOST_FILES, require_file
from fretfe.mesh.inp_language import squeezed, whole_keyword, whole_parameter, whole_value

# Begins a keyword that may include a file, in UTF-8 or UTF-16, with a byte order mark or without.
INCLUDING = re.compile(rb"^[\s\0\xef\xbb\xbf\xff\xfe]*\*[\s\0]*i", re.IGNORECASE | re.MULTILINE)
# First bytes of a file in UTF-16: a mark, a blank, or the star of a keyword.
LITTLE_ENDIAN = re.compile(rb"\xff\xfe|[\s*]\0")
BIG_ENDIAN = re.compile(rb"\xfe\xff|\0[\s*]")
# Stands for bytes that are not UTF-8; in comments they do not matter.
UNKNOWN = "\N{REPLACEMENT CHARACTER}"
# Characters of a line in a message.
LONGEST = 40
# Numbers as Fortran reads them: Python's own have underscores and digits of all scripts, too.
WHOLE = re.compile(r"[+-]?[0-9]+")
REAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:E[+-]?[0-9]+)?")


def whole(text: str) -> int:
    """A whole number; ValueError if it is none."""
    if not WHOLE.fullmatch(text):
        raise ValueError(f"expected a whole number, found {text or 'none'}")
    return int(text)


def real(text: str) -> float:
    """A number; Fortran writes 1.0D+00.

    Raises:
        ValueError: it is none, or not finite.
    """
    plain = text.upper().replace("D", "E")
    if not REAL.fullmatch(plain) or not math.isfinite(value := float(plain)):
        raise ValueError(f"expected a finite number, found {text or 'none'}")
    return value


@dataclass(frozen=True)
class Card:
    """A keyword with its parameters and its rows of data.

    Attributes:
        keyword: in capitals, as it is written.
        word: the whole keyword without blanks, whatever it is shortened to in the file.
        parameters: values by whole names without blanks, in capitals.
        rows: cells of the rows.
        place: file and line.
        lines: files and numbers of the lines of the rows.
    """

    keyword: str
    word: str
    parameters: dict[str, str]
    rows: list[list[str]]
    place: str
    lines: list[tuple[Path, int]] = field(default_factory=list)

    def name(self, parameter: str) -> str | None:
        """A name, in capitals, as case does not count; None without it."""
        value = self.parameters.get(parameter)
        return value.strip('"').upper() if value else None

    def required(self, parameter: str) -> str:
        """A name that must be there.

        Raises:
            ValueError: if it is missing.
        """
        name = self.name(parameter)
        if name is None:
            raise ValueError(f"the parameter {parameter} is missing")
        return name

    def choice(self, parameter: str, *choices: str) -> str:
        """The value of a parameter, the first of the choices without it; perhaps none of them.

        Raises:
            ValueError: it is short for several of them.
        """
        return whole_value(self.parameters.get(parameter) or choices[0], choices)

    @contextmanager
    def each_row(self) -> Iterator[Iterator[list[str]]]:
        """The rows, one after the other.

        Raises:
            MeshError: names the line of the row for each ValueError while it is read.
        """
        rows = iter(self.rows)
        try:
            yield rows
        except ValueError as error:
            file, line = self.lines[-1 - length_hint(rows)]  # of the last one that was taken
            raise MeshError(f"{file}, line {line}: cannot read *{self.keyword}: {error}") from None

    def pairs(self) -> list[tuple[str, str]]:
        """The first two names of each row, in capitals.

        Raises:
            ValueError: there is no row, or one without them.
        """
        found = [[value.strip('"').upper() for value in row[:2] if value] for row in self.rows]
        for names in found or [[]]:
            if len(names) != 2:
                raise ValueError(f"expected two surfaces, found {', '.join(names) or 'none'}")
        return [(one, other) for one, other in found]

    def refuse(self, *names: str) -> None:
        """Raise ValueError for parameters with which the keyword would mean something else."""
        for name in names:
            if name in self.parameters:
                raise ValueError(f"the parameter {name} is not supported")

    def require_text(self) -> None:
        """Raise ValueError for bytes that are not UTF-8: different names would be the same one."""
        texts = [*self.parameters.values(), *(value for row in self.rows for value in row)]
        if any(UNKNOWN in text for text in texts):
            raise ValueError("expected UTF-8 text, found other bytes in a name or a number")


def cards(path: Path) -> Iterator[Card]:
    """The keywords of a file in their order.

    Included files are looked for from the folder of the file that is read, as Abaqus and CalculiX
    do it where they are started there, and must be below it.

    Raises:
        MeshError: a file cannot be read, or the files include themselves, one elsewhere, or more
            than any model has.
    """
    card: Card | None = None
    for file, number, line in _Files(path.parent).lines(path, ()):
        if line.startswith("*"):
            if card is not None:
                yield card
            card = _card(line, f"{file}, line {number}")
        elif card is not None:
            card.rows.append([part.strip() for part in line.split(",")])
            card.lines.append((file, number))
        else:
            raise MeshError(
                f"{file}, line {number}: expected a keyword, which begins with *, found "
                f"{line[:LONGEST]!r}"
            )
    if card is not None:
        yield card


def included_files(path: Path) -> Iterator[Path]:
    """Files that an input file includes, and those that they include; as `cards`, also in errors.

    Args:
        path: of the file.
    """
    if INCLUDING.search(path.read_bytes()):
        files = _Files(path.parent)
        for _ in files.lines(path, ()):
            pass
        yield from files.read[1:]


@dataclass
class _Files:
    """Counts what was read, to end where files include each other without end."""

    folder: Path
    read: list[Path] = field(default_factory=list)
    size: int = 0

    def lines(self, path: Path, within: tuple[Path, ...]) -> Iterator[tuple[Path, int, str]]:
        """File, number and text of each line of a file that the files `within` include.

        The outermost is the first. Rows in an included file go on with the keyword before it.
        """
        for number, line in self._lines(path):
            begins = line[:2].upper() == "*I"
            card = _card(line, f"{path}, line {number}") if begins else None
            if card is not None and card.word == "INCLUDE":
                yield from self.lines(self._included(card, (*within, path)), (*within, path))
            else:
                yield path, number, line

    def _included(self, card: Card, within: tuple[Path, ...]) -> Path:
        """The file that a card includes."""
        card.require_text()
        name = card.parameters.get("INPUT", "").strip("\"'")
        path = self.folder / name
        if "\\" in name and not path.exists():  # as it is written on Windows
            path = self.folder / name.replace("\\", "/")
        if not name or not _is_below(path, self.folder):
            raise MeshError(
                f"{card.place}: expected a file in the folder of {within[0].name} or below it, "
                f"found {name!r}"
            )
        if path.resolve() in [each.resolve() for each in within]:
            raise MeshError(f"{card.place}: {name} includes itself")
        if len(within) > DEEPEST_INCLUDE:
            raise MeshError(
                f"{card.place}: files include each other more than {DEEPEST_INCLUDE} deep"
            )
        return path

    def _lines(self, path: Path) -> Iterator[tuple[int, str]]:
        """Lines with their number; no comments, no empty lines, keywords that go on in one line.

        A keyword that ends with a comma goes on in a line of parameters, whose names begin with
        letters; before data, or another keyword, the comma means nothing.
        """
        keyword, begun = "", 0
        for number, line in enumerate(self._text(path).splitlines(), 1):
            line = line.strip()
            if not line or line.startswith("**"):
                continue
            if keyword and not _parameters(line):
                yield begun, keyword
                keyword = ""
            line, first = keyword + line, begun if keyword else number
            keyword, begun = (line, first) if line.startswith("*") and line[-1] == "," else ("", 0)
            if not keyword:
                yield first, line
        if keyword:
            yield begun, keyword

    def _text(self, path: Path) -> str:
        require_file(path, "a mesh file", MeshError)
        try:
            self.read.append(path)
            self.size += path.stat().st_size
            if len(self.read) > MOST_FILES or self.size > MOST_BYTES:
                raise MeshError(
                    f"{path}: expected at most {MOST_FILES} files of {MOST_BYTES >> 30} GiB "
                    "together, found more"
                )
            return _decoded(path.read_bytes())
        except OSError as error:
            raise MeshError(f"{path}: cannot read the mesh file: {error.strerror}") from error


def _parameters(line: str) -> bool:
    """True if all items of a line begin as names of parameters do."""
    return all(each.strip()[:1].isalpha() for each in line.rstrip(",").split(","))


def _decoded(data: bytes) -> str:
    """The text of a file in UTF-8 or, as some programs on Windows write it, UTF-16."""
    encoding = "utf-8"
    if LITTLE_ENDIAN.match(data):
        encoding = "utf-16-le"
    elif BIG_ENDIAN.match(data):
        encoding = "utf-16-be"
    return data.decode(encoding, errors="replace").removeprefix("\N{BYTE ORDER MARK}")


def _card(line: str, place: str) -> Card:
    written, *parts = (part.strip() for part in line[1:].split(","))
    keyword = " ".join(written.upper().split())
    pairs = [part.partition("=") for part in parts if part]
    try:
        word = whole_keyword(squeezed(keyword))
        values = {whole_parameter(word, squeezed(name)): value.strip() for name, _, value in pairs}
    except ValueError as error:
        raise MeshError(f"{place}: cannot read *{keyword}: {error}") from None
    return Card(keyword, word, values, [], place)


def _is_below(path: Path, folder: Path) -> bool:
    try:
        return path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):  # too long, a NUL, links in a circle
        return False
