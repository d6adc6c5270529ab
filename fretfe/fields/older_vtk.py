# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arrays of a file of VTK's older format: as long as their heads state.

VTK takes for the rest of an array that ends too soon what is in memory, and says nothing. The
grammar is that of the VTK User's Guide, "Legacy file formats", versions 1 to 5.
"""

from __future__ import annotations

import mmap
import re
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from fretfe.errors import CaseError

# Bytes of a value.
SIZES = {
    b"char": 1, b"unsigned_char": 1, b"vtktypeint8": 1, b"vtktypeuint8": 1,
    b"short": 2, b"unsigned_short": 2, b"vtktypeint16": 2, b"vtktypeuint16": 2,
    b"int": 4, b"unsigned_int": 4, b"float": 4, b"vtktypeint32": 4, b"vtktypeuint32": 4,
    b"long": 8, b"unsigned_long": 8, b"double": 8, b"vtkidtype": 4,
    b"vtktypeint64": 8, b"vtktypeuint64": 8, b"long_long": 8, b"unsigned_long_long": 8,
}  # fmt: skip
# Components of the attributes that have always so many.
WIDTHS = {
    b"vectors": 3, b"normals": 3, b"tensors": 9, b"tensors6": 6, b"global_ids": 1,
    b"pedigree_ids": 1, b"edge_flags": 1,
}  # fmt: skip
# Heads without values.
EMPTY = (b"dataset", b"dimensions", b"origin", b"spacing", b"aspect_ratio", b"extent")
# Heads of numbers of nodes.
ELEMENTS = (b"cells", b"polygons", b"lines", b"vertices", b"triangle_strips")
# Longest line of a head.
LONGEST = 1000
WORD = re.compile(rb"\S+")


@dataclass
class _Walk:
    """Goes through a file from head to head.

    Attributes:
        path: for messages.
        data: the file.
        binary: whether values are binary.
        place: what is read next.
        rows: values of one component at the nodes, or of the elements.
    """

    path: Path
    data: mmap.mmap
    binary: bool
    place: int
    rows: int = 0

    def run(self) -> None:
        while (words := self._head()) is not None:
            self._pass(words)

    def _head(self) -> list[bytes] | None:
        """Words of the next line that is not blank; None at the end."""
        while self.place < len(self.data):
            end = self.data.find(b"\n", self.place, self.place + LONGEST)
            end = min(self.place + LONGEST, len(self.data)) if end < 0 else end
            words = self.data[self.place : end].split()
            self.place = end + 1
            if words:
                return words
        return None

    def _pass(self, words: list[bytes]) -> None:
        """Pass over the values of a head."""
        key, size = words[0].lower(), len(words)
        if key == b"points" and size == 3:
            self._values(words, 3 * self._count(words[1]), words[2])
        elif key in (b"x_coordinates", b"y_coordinates", b"z_coordinates") and size == 3:
            self._values(words, self._count(words[1]), words[2])
        elif (
            key in (b"cells", b"polygons", b"lines", b"vertices", b"triangle_strips") and size == 3
        ):
            self._cells(words)
        elif key == b"cell_types" and size == 2:
            self._values(words, self._count(words[1]), b"int")
        elif key in (b"point_data", b"cell_data") and size == 2:
            self.rows = self._count(words[1])
        elif key in WIDTHS and size == 3:
            self._values(words, WIDTHS[key] * self.rows, words[2])
        elif key == b"scalars" and size in (3, 4):
            self._scalars(words)
        elif key == b"texture_coordinates" and size == 4:
            self._values(words, self._count(words[2]) * self.rows, words[3])
        elif key == b"lookup_table" and size == 3:
            kind = b"unsigned_char" if self.binary else b"float"
            self._values(words, 4 * self._count(words[2]), kind)
        elif key == b"color_scalars" and size == 3:
            kind = b"unsigned_char" if self.binary else b"float"
            self._values(words, self._count(words[2]) * self.rows, kind)
        elif key == b"field" and size == 3:
            self._field(self._count(words[2]))
        elif key == b"metadata":
            self._metadata()
        elif key not in EMPTY:
            text = words[0][:40].decode("ascii", "replace")
            raise self._error(f"expected the head of an array, found {text!r}")

    def _cells(self, words: list[bytes]) -> None:
        """Of version 5 the offsets and the nodes apart."""
        first, second = self._count(words[1]), self._count(words[2])
        begin, head = self.place, self._head()
        if head and head[0].lower() == b"offsets" and len(head) == 2:
            self._values(head, first, head[1])
            head = self._head()
            if not head or head[0].lower() != b"connectivity" or len(head) != 2:
                raise self._error("expected CONNECTIVITY after OFFSETS")
            self._values(head, second, head[1])
        else:
            self.place = begin
            self._values(words, second, b"int")

    def _scalars(self, words: list[bytes]) -> None:
        width = self._count(words[3]) if len(words) == 4 else 1
        begin, head = self.place, self._head()
        if not head or head[0].lower() != b"lookup_table":
            self.place = begin
        self._values(words, width * self.rows, words[2])

    def _field(self, count: int) -> None:
        for _ in range(count):
            head = self._head()
            if head and head[0].lower() == b"metadata":
                self._metadata()
                head = self._head()
            if head is None or len(head) != 4:
                raise self._error(f"expected {count} arrays of a field, found the file to end")
            self._values(head, self._count(head[1]) * self._count(head[2]), head[3])

    def _metadata(self) -> None:
        """Up to a blank line."""
        while self.place < len(self.data):
            end = self.data.find(b"\n", self.place)
            end = len(self.data) if end < 0 else end
            line, self.place = self.data[self.place : end].strip(), end + 1
            if not line:
                return

    def _values(self, words: list[bytes], count: int, kind: bytes) -> None:
        """Pass over so many values of a type."""
        name = b" ".join(words[:2])[:60].decode("ascii", "replace")
        if kind.lower() == b"string" and not self.binary:  # each in a line of its own
            for _ in range(count):
                self._head()
            return
        size = SIZES.get(kind.lower())
        if size is None:
            raise self._error(f"{name}: expected a type of numbers, found {kind[:30]!r}")
        if self.binary:
            self.place += count * size
            if self.place > len(self.data):
                raise self._error(f"{name}: expected {count} values, found the file to end before")
            return
        begin, found = self.place, -1
        for found, word in enumerate(islice(WORD.finditer(self.data, begin), count)):
            if not _number(word[0]):
                raise self._error(f"{name}: expected {count} values, found {found}")
            self.place = word.end()
        if found + 1 < count:
            raise self._error(f"{name}: expected {count} values, found {found + 1}")

    def _count(self, text: bytes) -> int:
        if not text.isdigit() or len(text) > 12:
            raise self._error(f"expected a number of values, found {text[:30]!r}")
        return int(text)

    def _error(self, text: str) -> CaseError:
        return CaseError(f"{self.path}: byte {min(self.place, len(self.data))}: {text}")


def _number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def require_whole(path: Path, data: mmap.mmap) -> None:
    """Check that the arrays of a file have as many values as their heads state.

    Raises:
        CaseError: names the array that has not.
    """
    place = 0
    for _ in range(2):  # version and title
        place = data.find(b"\n", place) + 1
    end = data.find(b"\n", place)
    form = data[place : end if end > 0 else len(data)].strip().lower()
    if form not in (b"ascii", b"binary"):
        raise CaseError(f"{path}: line 3: expected ASCII or BINARY, found {form[:30]!r}")
    _Walk(path, data, form == b"binary", end + 1).run()
