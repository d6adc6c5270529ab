# SPDX-License-Identifier: LGPL-3.0-or-later
"""Result files of CalculiX (.frd): displacements and temperatures of a static run.

Records as in the manual of CalculiX GraphiX, in all their forms: text with numbers of nodes of 5 or
10 digits, and binary with single or double precision. The file is mapped: values of a step are read
when they are asked for.
"""

from __future__ import annotations

import mmap
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Indices
from fretfe.errors import CaseError
from fretfe.fields.sizes import require_count
from fretfe.files import require_file

# Forms of the numbers of a block, as the file has them.
SHORT, LONG, SINGLE, DOUBLE = range(4)
# Digits of the number of a node; precision of a binary value.
DIGITS = {SHORT: 5, LONG: 10}
PRECISION = {SINGLE: "<f4", DOUBLE: "<f8"}
# Columns of a value.
WIDTH = 12
# By CalculiX's number of a kind of element: VTK's number, and the nodes in VTK's order.
ELEMENTS = {
    1: (12, tuple(range(8))),
    2: (13, tuple(range(6))),
    3: (10, tuple(range(4))),
    4: (25, (*range(12), *range(16, 20), *range(12, 16))),
    5: (26, (*range(9), *range(12, 15), *range(9, 12))),
    6: (24, tuple(range(10))),
    7: (5, tuple(range(3))),
    8: (22, tuple(range(6))),
    9: (9, tuple(range(4))),
    10: (23, tuple(range(8))),
    11: (3, tuple(range(2))),
    12: (21, tuple(range(3))),
}
# Kinds of analyses whose values are those of a time: static, and transient.
IN_TIME = (0, 1)
# Results that can be read, and their components.
COLUMNS = {"DISP": 3, "NDTEMP": 1}
LONGEST_LINE = 1000
# An exponent has three digits where a number, or the end, follows the third.
NUMBER = (
    rb" *([-+]?\d\.\d+E[-+]?(?:\d{3}(?=\d\.|[-+ ]|nan|inf|$)|\d{2})"
    rb"|[-+]?(?:nan|inf)(?:\([^)]*\)|inity)?)"
)


@dataclass(frozen=True)
class _Block:
    """Rows of numbers in the file, one for each node."""

    name: str
    time: float
    form: int
    start: int
    end: int
    count: int
    columns: int


@dataclass(frozen=True)
class Frd:
    """A result file.

    Attributes:
        points: (n, 3) coordinates of the nodes.
        numbers: (n,) of the nodes in the file, increasing.
        nodes: (c,) places in `points` of the nodes of each element, in VTK's order.
        offsets: (m + 1,) where the elements begin in `nodes`, and the end.
        shapes: (m,) VTK's number of each element; none where the file has no elements.
        times: (T,) of the steps with the result that was asked for, increasing.
        notes: what in the file is not used, in words.
    """

    points: Array
    numbers: Indices
    nodes: Indices
    offsets: Indices
    shapes: Indices
    times: Array
    notes: tuple[str, ...]
    _source: _Source
    _blocks: tuple[_Block, ...]

    def values(self, step: int) -> Array:
        """(n, 3) displacements, or (n, 1) temperatures, in a step, by its number from 0.

        NaN at nodes without any.

        Raises:
            CaseError: if there are none that can be read.
        """
        return self._source.values(self._blocks[step], self.numbers)


def read_frd(path: Path, wanted: str = "DISP") -> Frd:
    """Open a result file of CalculiX.

    Args:
        path: the file, in text or binary form.
        wanted: its name of the result, "DISP" or "NDTEMP".

    Raises:
        CaseError: if it is not whole, or has no such result of a static or transient run.
    """
    require_file(path, "a result file of CalculiX (.frd)", CaseError)
    try:
        with path.open("rb") as file:
            mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except (OSError, ValueError) as error:  # ValueError: it is empty
        raise CaseError(f"{path}: cannot read the result file: {error}") from None
    return _Reader(_Source(path, mapped), wanted).read()


@dataclass
class _Source:
    """Bytes of the file, and the errors in them."""

    path: Path
    data: mmap.mmap

    def error(self, place: int, text: str) -> CaseError:
        return CaseError(f"{self.path}: byte {place}: {text}")

    def values(self, block: _Block, numbers: Indices) -> Array:
        """(n, columns) values of a block at all nodes; NaN at those that it has not."""
        nodes, values = self.rows(block)
        places = np.minimum(np.searchsorted(numbers, nodes), len(numbers) - 1)
        if (wrong := numbers[places] != nodes).any():
            found = f"values of node {nodes[wrong][0]}, which is not in the mesh"
            raise self.error(block.start, f"{block.name}: {found}")
        if (wrong := np.bincount(places, minlength=1) > 1).any():
            found = f"two values of node {numbers[wrong.argmax()]}"
            raise self.error(block.start, f"{block.name}: {found}")
        every = np.full((len(numbers), block.columns), np.nan)
        every[places] = values
        return every

    def rows(self, block: _Block) -> tuple[Indices, Array]:
        """Numbers (k,) of nodes, and their finite values (k, columns)."""
        data = self.data[block.start : block.end]
        if block.form in PRECISION:
            record = np.dtype([("n", "<i4"), ("v", PRECISION[block.form], (block.columns,))])
            table = np.frombuffer(data, record)
            nodes, values = table["n"].astype(np.int64), table["v"].astype(float)
        else:
            nodes, values = self._text_rows(block, data)
        if len(wrong := np.flatnonzero(~np.isfinite(values).all(axis=1))):
            found = f"{values[wrong[0]].sum()} at node {nodes[wrong[0]]}"
            raise self.error(block.start, f"{block.name}: expected finite numbers, found {found}")
        return nodes, values

    def _text_rows(self, block: _Block, data: bytes) -> tuple[Indices, Array]:
        lines = data.splitlines()
        if len(lines) != block.count:
            found = f"expected {block.count} rows of values, found {len(lines)}"
            raise self.error(block.start, f"{block.name}: {found}")
        first = 3 + DIGITS[block.form]
        width = first + block.columns * WIDTH
        try:
            if {len(line) for line in lines} == {width}:
                table = np.frombuffer(b"".join(lines), "S1").reshape(-1, width)
                listed = _numbers(table[:, first:].reshape(-1, WIDTH))
                numbers = _numbers(table[:, 3:first]).astype(np.int64)
                return numbers, listed.reshape(-1, block.columns)
            # Exponents of three digits need more room than a column has: always on Windows.
            row = re.compile(NUMBER * block.columns + rb" *", re.IGNORECASE)
            rows = [row.fullmatch(line[first:]) for line in lines]
            if None in rows:
                text = lines[rows.index(None)][:LONGEST_LINE].decode("ascii", "replace")
                raise ValueError(f"expected {block.columns} of them, found {text!r}")
            values = [[float(value) for value in found.groups()] for found in rows if found]
            numbers = np.array([int(line[3:first]) for line in lines], dtype=np.int64)
            return numbers, np.array(values).reshape(-1, block.columns)
        except ValueError as error:
            raise self.error(
                block.start, f"{block.name}: cannot read its numbers: {error}"
            ) from None


def _numbers(characters: NDArray[np.bytes_]) -> Array:
    """(n,) numbers from characters (n, k)."""
    texts = np.ascontiguousarray(characters).view(f"S{characters.shape[1]}")
    return texts[:, 0].astype(float)


@dataclass
class _Reader:
    """Goes through the records of a file."""

    source: _Source
    wanted: str
    place: int = 0
    nodes: _Block | None = None
    blocks: list[_Block] = field(default_factory=list)
    elements: list[tuple[int, Indices]] = field(default_factory=list)
    unused: Counter[str] = field(default_factory=Counter)

    def read(self) -> Frd:
        """Read all records but values."""
        line = self._line()
        if not line.startswith("    1C"):
            raise self.source.error(0, "expected a result file of CalculiX, which begins with 1C")
        while (key := line[:5].strip()) != "9999":
            if key == "2":
                self._begin_nodes(line)
            elif key == "3":
                self._read_elements(line)
            elif key == "100":
                self._begin_values(line)
            elif not key.startswith("1"):
                raise self.source.error(
                    self.place, f"expected a record of the file, found {line!r}"
                )
            line = self._line()
        return self._file()

    def _line(self) -> str:
        """The next line, without its end."""
        data = self.source.data
        end = data.find(b"\n", self.place, self.place + LONGEST_LINE)
        if end < 0:
            raise self.source.error(
                len(data) if len(data) - self.place < LONGEST_LINE else self.place,
                "expected a line, and 9999 in the last one, found none: the file is not whole "
                "(is the run complete?)",
            )
        line = data[self.place : end].decode("ascii", "replace").rstrip("\r")
        self.place = end + 1
        return line

    def _whole(self, line: str, first: int, last: int, what: str) -> int:
        """A number that is not negative in columns of a line."""
        text = line[first:last].strip()
        if not text.isascii() or not text.isdigit():
            raise self.source.error(self.place, f"expected {what}, found {text!r} in {line!r}")
        return int(text)

    def _form(self, line: str) -> int:
        form = self._whole(line, 73, 75, "the form of the numbers (0 to 3)")
        if form > DOUBLE:
            raise self.source.error(self.place, f"expected a form from 0 to 3, found {form}")
        return form

    def _block(self, name: str, time: float, line: str, columns: int) -> _Block:
        """The rows of values that follow, which are passed over."""
        form, count = self._form(line), self._whole(line, 24, 36, "a number of nodes")
        require_count(self.source.path, "nodes", count)
        start, data = self.place, self.source.data
        if form in PRECISION:
            self.place += count * (4 + columns * np.dtype(PRECISION[form]).itemsize)
            if self.place > len(data):
                raise self.source.error(
                    len(data), f"{name}: the file ends within the {count} rows that it states"
                )
            return _Block(name, time, form, start, self.place, count, columns)
        end = self._end_of_rows()
        return _Block(name, time, form, start, end, count, columns)

    def _end_of_rows(self) -> int:
        """The end of rows of text; what follows is read next."""
        data = self.source.data
        end = self.place if data[self.place : self.place + 3] == b" -3" else -1
        if end < 0:
            end = data.find(b"\n -3", self.place) + 1
        if end <= 0:
            raise self.source.error(len(data), "expected -3 at the end of rows, found none")
        self.place = end
        self._line()
        return end

    def _begin_nodes(self, line: str) -> None:
        if self.nodes is not None:
            raise self.source.error(self.place, "expected one block of nodes, found a second one")
        self.nodes = self._block("nodes", 0.0, line, 3)

    def _begin_values(self, line: str) -> None:
        time = line[12:24].strip()
        try:
            value = float(time)
        except ValueError:
            raise self.source.error(self.place, f"expected a time, found {time!r}") from None
        kind = self._whole(line, 56, 58, "the kind of analysis")
        head = self._line()
        name, stated = head[5:13].strip(), self._whole(head, 13, 18, "a number of components")
        if not head.startswith(" -4"):
            raise self.source.error(self.place, f"expected the name of a result, found {head!r}")
        names = [self._line() for _ in range(stated)]
        columns = sum(not each[33:38].strip() == "1" for each in names)
        if not all(each.startswith(" -5") for each in names):
            raise self.source.error(self.place, f"{name}: expected {stated} components")
        block = self._block(name, value, line, columns)
        if name == self.wanted and kind in IN_TIME:
            if columns != COLUMNS[name]:
                raise self.source.error(block.start, f"{name}: found {columns} components")
            self.blocks.append(block)
        else:
            self.unused.update([name])

    def _read_elements(self, line: str) -> None:
        form, count = self._form(line), self._whole(line, 24, 36, "a number of elements")
        require_count(self.source.path, "elements", count)
        alike = None if form in PRECISION else self._elements_of_one_kind(form, count)
        if alike is not None:
            self.elements.append(alike)
            return
        rows = self._binary_elements(count) if form in PRECISION else self._text_elements(form)
        found: dict[int, list[list[int]]] = {}
        for kind, nodes in rows:
            found.setdefault(kind, []).append(nodes)
        if (total := sum(map(len, found.values()))) != count:
            raise self.source.error(self.place, f"expected {count} elements, found {total}")
        self.elements += [(kind, np.array(nodes, dtype=np.int64)) for kind, nodes in found.items()]

    def _binary_elements(self, count: int) -> Iterator[tuple[int, list[int]]]:
        """Kinds and nodes; before these stand a number, the kind, a group and a material."""
        data = self.source.data
        words = memoryview(data[self.place : self.place + (len(data) - self.place) // 4 * 4]).cast(
            "i"
        )
        place = 0
        for _ in range(count):
            size = self._size(words[place + 1]) if place + 4 <= len(words) else 0
            nodes = words[place + 4 : place + 4 + size].tolist()
            if not size or len(nodes) < size:
                raise self.source.error(
                    len(data), f"the file ends within the {count} elements that it states"
                )
            yield words[place + 1], nodes
            place += 4 + size
        self.place += 4 * place

    def _elements_of_one_kind(self, form: int, count: int) -> tuple[int, Indices] | None:
        """Kind and nodes of text elements that are all alike, read at once; None if they are not.

        A million of them would take minutes one by one.
        """
        digits, begin = DIGITS[form], self.place
        end = self._end_of_rows()
        lines, after, self.place = self.source.data[begin:end].splitlines(), self.place, begin
        each = len(lines) // count if count else 0
        if each < 2 or len(lines) != each * count:
            return None
        tables = []
        for row in range(each):
            own = lines[row::each]
            if {len(line) for line in own} != {len(own[0])}:
                return None
            tables.append(np.frombuffer(b"".join(own), "S1").reshape(count, -1))
        heads, kind = tables[0], lines[0][3 + digits : 8 + digits].strip()
        same = (heads[:, 3 + digits : 8 + digits] == heads[0, 3 + digits : 8 + digits]).all()
        marks = [b" -1", *[b" -2"] * (each - 1)]
        good = all(
            line[:3] == mark and (table[:, :3] == table[0, :3]).all()
            for line, mark, table in zip(lines, marks, tables, strict=False)
        )
        if not (same and good and kind.isdigit()):
            return None
        if any((table.shape[1] - 3) % digits for table in tables[1:]):
            return None
        try:
            columns = [_numbers(table[:, 3:].reshape(-1, digits)) for table in tables[1:]]
        except ValueError:
            return None
        nodes = np.hstack([column.reshape(count, -1) for column in columns]).astype(np.int64)
        if nodes.shape[1] != self._size(int(kind)):
            return None
        self.place = after
        return int(kind), nodes

    def _text_elements(self, form: int) -> Iterator[tuple[int, list[int]]]:
        digits = DIGITS[form]
        start, end = self.place, self._end_of_rows()
        kind, nodes = 0, list[int]()
        for line in self.source.data[start:end].splitlines():
            try:
                if line.startswith(b" -1") and not nodes:
                    kind = int(line[3 + digits : 8 + digits])
                elif line.startswith(b" -2") and kind:
                    nodes += [
                        int(line[at : at + digits]) for at in range(3, len(line.rstrip()), digits)
                    ]
                else:
                    raise ValueError
            except ValueError:
                text = line[:80].decode("ascii", "replace")
                raise self.source.error(start, f"expected an element, found {text!r}") from None
            if len(nodes) >= self._size(kind):
                yield kind, nodes
                kind, nodes = 0, []

    def _size(self, kind: int) -> int:
        """The number of nodes of an element of a kind."""
        if kind not in ELEMENTS:
            known = f"{min(ELEMENTS)} to {max(ELEMENTS)}"
            raise self.source.error(self.place, f"expected elements of kinds {known}, found {kind}")
        return len(ELEMENTS[kind][1])

    def _file(self) -> Frd:
        source = self.source
        if self.nodes is None:
            raise source.error(self.place, "expected nodes, found none")
        numbers, points = source.rows(self.nodes)
        order = np.argsort(numbers, kind="stable")
        numbers, points = numbers[order], points[order]
        if (again := np.flatnonzero(np.diff(numbers) == 0)).size:
            raise source.error(self.nodes.start, f"found node {numbers[again[0]]} twice")
        times = np.array([block.time for block in self.blocks])
        if not self.blocks or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
            listed = ", ".join(f"{time:g}" for time in times[:10]) or "none"
            raise CaseError(
                f"{source.path}: expected results {self.wanted} of a static or transient run, at "
                f"times that increase, found {listed}"
            )
        return Frd(
            points, numbers, *self._cells(numbers), times, tuple(self._notes()), source,
            tuple(self.blocks),
        )  # fmt: skip

    def _cells(self, numbers: Indices) -> tuple[Indices, Indices, Indices]:
        """Nodes of the elements by their places, where each begins, and its kind for VTK."""
        nodes, sizes, shapes = (
            [np.zeros(0, np.int64)],
            [np.zeros(1, np.int64)],
            [np.zeros(0, np.int64)],
        )
        for kind, listed in self.elements:
            shape, order = ELEMENTS[kind]
            places = np.minimum(np.searchsorted(numbers, listed), len(numbers) - 1)
            if (wrong := numbers[places] != listed).any():
                raise self.source.error(
                    self.place, f"found an element of node {listed[wrong][0]}, which is not defined"
                )
            nodes.append(places[:, order].ravel())
            sizes.append(np.full(len(listed), len(order)))
            shapes.append(np.full(len(listed), shape))
        return np.concatenate(nodes), np.cumsum(np.concatenate(sizes)), np.concatenate(shapes)

    def _notes(self) -> Iterator[str]:
        if self.unused:
            listed = ", ".join(f"{count} {name}" for name, count in sorted(self.unused.items()))
            yield f"{self.source.path.name}: results that are not used: {listed}"
