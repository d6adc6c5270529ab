# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sizes that files of fields state: looked at before VTK or HDF5 allocate what they say.

A file of a few megabytes may state, or unpack to, more than any machine has.
"""

from __future__ import annotations

import base64
import binascii
import math
import mmap
import re
import struct
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np

from fretfe.errors import CaseError
from fretfe.fields.older_vtk import require_whole
from fretfe.files import MOST_BYTES, MOST_ROWS, MOST_STATED, file_fault

# A file that names those of its steps, and what it may name.
COLLECTION = ".pvd"
PIECES = (".vtu", ".vtk")
# Components of a value at a node: a tensor has 9.
MOST_COMPONENTS = 100
# Groups of an HDF5 file that are in one another.
DEEPEST = 20
# Counts of the parts of a grid in HDF5, a number for each of them.
PARTS = {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"}
# Its tables, or groups of them: the count of their rows, and rows more of each part.
ROWS = {
    "Points": ("NumberOfPoints", 0),
    "PointData": ("NumberOfPoints", 0),
    "Types": ("NumberOfCells", 0),
    "CellData": ("NumberOfCells", 0),
    "Offsets": ("NumberOfCells", 1),
    "Connectivity": ("NumberOfConnectivityIds", 0),
}
# Rows before those of a step, by the table; of values at nodes and elements each has its own.
OFFSETS = {
    "Points": "PointOffsets",
    "Types": "CellOffsets",
    "Connectivity": "ConnectivityIdOffsets",
}
# Digits of a whole number.
LONGEST_COUNT = 20
# Bytes that are read from a file at a time.
CHUNK = 1 << 20
# Bytes of values in XML by their type; what counts the values of arrays by the element they are in.
VALUE_BYTES = {
    f"{kind}{8 * size}": size for size in (1, 2, 4, 8) for kind in ("Int", "UInt", "Float")
}
COUNTED_BY = {
    "Points": "NumberOfPoints",
    "PointData": "NumberOfPoints",
    "Cells": "NumberOfCells",
    "CellData": "NumberOfCells",
}
# Of what compresses blocks: their number, their size, and that of the last one; by type.
WORDS = {"UInt32": "I", "UInt64": "Q"}
ORDERS = {"LittleEndian": "<", "BigEndian": ">"}
# Keywords of the older format of VTK, and what their numbers count.
COUNTED = re.compile(
    rb"^[ \t]*(POINTS|CELLS|CELL_TYPES|POINT_DATA|CELL_DATA)[ \t]+(\S+)",
    re.IGNORECASE | re.MULTILINE,
)


def require_count(path: Path, what: str, count: int, most: int = MOST_STATED) -> None:
    """Check how many of something a file states.

    Raises:
        CaseError: if they are more than any model has.
    """
    if not 0 <= count <= most:
        raise CaseError(f"{path}: expected at most {most:,} {what}, found {count:,}")


def require_sizes(path: Path) -> None:
    """Check the sizes that a file of fields states.

    Raises:
        CaseError: if they are too large, or none.
    """
    if check := CHECKS.get(path.suffix.lower()):
        check(path)


def bytes_of(path: Path) -> int:
    """Bytes of a file, and of those that it names; it has been checked by `require_sizes`."""
    own = path.stat().st_size
    if path.suffix.lower() != COLLECTION:
        return own
    found = _Xml(path)
    found.read()
    return own + sum((path.parent / name).stat().st_size for name in dict.fromkeys(found.pieces))


def _older_vtk(path: Path) -> None:
    """Counts of a file without compression, in which each takes some bytes of the file."""
    size = path.stat().st_size
    if not size:
        raise CaseError(f"{path}: expected a file that VTK reads, found an empty one")
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        for found in COUNTED.finditer(data):
            what = found[1].decode().lower()
            if not (found[2].isdigit() and len(found[2]) < LONGEST_COUNT):
                raise CaseError(f"{path}: expected a number of {what}, found {found[2][:20]!r}")
            require_count(path, what, int(found[2]), min(MOST_STATED, size))
        require_whole(path, data)


@dataclass
class _Block:
    """An array of a file of VTK in XML: what it states, and where its bytes are.

    Attributes:
        name: for messages.
        count: values that it states; None where another array tells.
        size: bytes of a value; 0 of kinds of values that are not numbers.
        offset: of the bytes that are appended to the file; None if they are in its element.
        text: whether the values are in the element as text.
        head: the first characters in its element.
        found: characters in its element that are not blank; of text, its values.
        open: whether the last character before was one of those.
    """

    name: str
    count: int | None
    size: int
    offset: int | None
    text: bool
    head: bytes = b""
    found: int = 0
    open: bool = False

    def add(self, text: str, head_size: int) -> None:
        """Characters of its element."""
        words = text.split()
        if self.text:
            self.found += len(words) - (self.open and bool(words) and not text[0].isspace())
            self.open = not text[-1:].isspace()
            return
        self.found += sum(map(len, words))
        if len(self.head) < head_size:
            self.head += "".join(words)[:head_size].encode("ascii", "replace")


@dataclass
class _Xml:
    """Sizes in the elements of a file of VTK in XML, up to the bytes that are appended to it."""

    path: Path
    pieces: list[str] = field(default_factory=list)
    steps: list[tuple[float, str, str]] = field(default_factory=list)
    blocks: list[_Block] = field(default_factory=list)
    compressed: bool = False
    word: str = "I"
    order: str = "<"
    appended: int = -1
    encoding: str = "raw"
    _counts: dict[str, int] = field(default_factory=dict)
    _within: list[str] = field(default_factory=list)
    _start_of_data: int = -1

    def read(self) -> None:
        """Go through the elements, without entities of any kind."""
        parser = self._parser = expat.ParserCreate()
        parser.StartDoctypeDeclHandler = self._refuse
        parser.StartElementHandler, parser.EndElementHandler = self._start, self._end
        parser.CharacterDataHandler, parser.buffer_text = self._characters, True
        try:
            with self.path.open("rb") as file:
                while self.appended < 0 and (data := file.read(CHUNK)):
                    parser.Parse(data)
        except expat.ExpatError as error:
            # What is appended need not be XML.
            if self.appended < 0:
                raise CaseError(f"{self.path}: expected XML, found {error}") from None

    def _refuse(self, *words: object) -> None:
        raise CaseError(f"{self.path}: expected no document type (DOCTYPE), found {words[0]!r}")

    def _start(self, name: str, words: dict[str, str]) -> None:
        self._within.append(name)
        if name == "VTKFile":
            self.compressed = "compressor" in words
            self.word = WORDS.get(words.get("header_type", "UInt32"), "I")
            self.order = ORDERS.get(words.get("byte_order", "LittleEndian"), "<")
        elif name == "DataSet":
            self.pieces.append(words.get("file", ""))
            time = self._number("timestep", words.get("timestep", "0"))
            self.steps.append((time, words.get("group", ""), words.get("part", "0")))
        elif name == "Piece":
            for key in ("NumberOfPoints", "NumberOfCells"):
                self._counts[key] = self._whole(key, words.get(key, "0"))
                require_count(self.path, key, self._counts[key])
        elif name == "DataArray":
            self._array(words)
        elif name == "AppendedData":
            self.appended = self._parser.CurrentByteIndex
            self.encoding = words.get("encoding", "raw")

    def _array(self, words: dict[str, str]) -> None:
        components = self._whole("NumberOfComponents", words.get("NumberOfComponents", "1"))
        require_count(self.path, "NumberOfComponents", components, MOST_COMPONENTS)
        within, name = self._within[-2:][0], words.get("Name", "")
        count = None
        if within in COUNTED_BY and (within, name) != ("Cells", "connectivity"):
            count = components * self._counts.get(COUNTED_BY[within], 0)
        form, offset = words.get("format", "ascii"), None
        if form == "appended":
            offset = self._whole("offset", words.get("offset", "0"))
        size = VALUE_BYTES.get(words.get("type", ""), 0)
        self.blocks.append(_Block(f"{within} {name}", count, size, offset, form == "ascii"))

    def _characters(self, text: str) -> None:
        if self._within[-1:] == ["DataArray"] and self.blocks[-1].offset is None:
            self.blocks[-1].add(text, self.head_size * 4 // 3)

    def _end(self, name: str) -> None:
        self._within.pop()

    def _number(self, key: str, text: str) -> float:
        try:
            return float(text)
        except ValueError:
            raise CaseError(f"{self.path}: {key}: expected a number, found {text[:20]!r}") from None

    def _whole(self, key: str, text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) < LONGEST_COUNT):
            raise CaseError(f"{self.path}: {key}: expected a whole number, found {text[:20]!r}")
        return int(text)

    @property
    def head_size(self) -> int:
        """Bytes in which an array that is compressed tells how large it is."""
        return 3 * struct.calcsize(self.word)

    def sizes(self) -> Iterator[int]:
        """Bytes of each array, as the counts state it, or its blocks."""
        for block in self.blocks:
            # The largest kind of numbers has 8 bytes.
            stated = 8 * (block.count or 0)
            yield stated if block.text else max(stated, self._head(block))

    def require_whole(self) -> None:
        """Check that arrays have as many values as the counts state: VTK takes what is in memory.

        Raises:
            CaseError: names the array that has not.
        """
        for block in self.blocks:
            if block.count is None or not block.size:
                continue
            per = 1 if block.text else block.size
            found = block.found if block.text else self._head(block)
            if found != per * block.count:
                raise CaseError(
                    f"{self.path}: {block.name}: expected {block.count} values, found "
                    f"{found / per:g}"
                )
            if not block.text and not self.compressed and not self._reaches(block, found):
                raise CaseError(
                    f"{self.path}: {block.name}: expected {block.count} values, found bytes of "
                    "another number of them"
                )

    def _reaches(self, block: _Block, size: int) -> bool:
        """True if so many bytes are there, after the word that tells their number."""
        word = struct.calcsize(self.word)
        # In base64 3 bytes have 4 characters; the word may be written for itself.
        together, apart = (
            sum(-(-each // 3) * 4 for each in parts) for parts in ((word + size,), (word, size))
        )
        if block.offset is None:
            return block.found in (together, apart)
        room = self.path.stat().st_size - self._begin - block.offset
        return room >= (together if self.encoding == "base64" else word + size)

    def _head(self, block: _Block) -> int:
        """Bytes of an array, unpacked, by what stands before it; 0 if VTK reads none of it."""
        word = struct.calcsize(self.word)
        head = block.head if block.offset is None else self._appended_head(block.offset)
        if block.offset is None or self.encoding == "base64":
            try:
                head = base64.b64decode(head[: self.head_size * 4 // 3])
            except binascii.Error:
                return 0
        size = word * (3 if self.compressed else 1)
        if len(head) < size:
            return 0
        first, *blocks = struct.unpack(f"{self.order}{size // word}{self.word}", head[:size])
        if not self.compressed:
            return int(first)
        full, last = blocks
        return int(first * full - (full - last if first and last else 0))

    @property
    def _begin(self) -> int:
        """Place in the file from which offsets of what is appended count."""
        if self._start_of_data < 0:
            with self.path.open("rb") as file:
                file.seek(max(self.appended, 0))
                self._start_of_data = max(self.appended, 0) + file.read(CHUNK).find(b"_") + 1
        return self._start_of_data

    def _appended_head(self, offset: int) -> bytes:
        with self.path.open("rb") as file:
            file.seek(self._begin + offset)
            return file.read(self.head_size * 4 // 3)


def _xml(path: Path) -> None:
    found = _Xml(path)
    found.read()
    total = sum(found.sizes())
    if total > MOST_BYTES:
        raise CaseError(
            f"{path}: expected arrays of at most {MOST_BYTES >> 30} GiB together, found "
            f"{total / 2**30:.3g} GiB"
        )
    found.require_whole()
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - CHUNK, 0))
        if b"</VTKFile>" not in file.read():
            raise CaseError(f"{path}: expected </VTKFile> at its end, found none: it is not whole")


def _collection(path: Path) -> None:
    """A file that names those of its steps: of each time one, or its parts."""
    found = _Xml(path)
    found.read()
    require_count(path, "files", len(found.pieces), MOST_ROWS)
    if again := [key for key, count in Counter(found.steps).items() if count > 1]:
        listed = [piece for key, piece in zip(found.steps, found.pieces, strict=True)
                  if key == again[0]]  # fmt: skip
        raise CaseError(
            f"{path}: expected one file of each time (timestep) and part, found "
            f"{', '.join(repr(name[:100]) for name in listed[:3])} at {again[0][0]:g}"
        )
    for name in dict.fromkeys(found.pieces):
        piece = path.parent / name
        if piece.suffix.lower() not in PIECES:
            raise CaseError(f"{path}: expected files {' and '.join(PIECES)}, found {name[:100]!r}")
        if fault := file_fault(piece):
            raise CaseError(f"{path}: expected the file {name[:100]!r}, found {fault}")
        require_sizes(piece)


def _hdf(path: Path) -> None:
    """Counts of a grid, and the shapes of its tables."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            tables = dict(_tables(path, file))
            for name, table in tables.items():
                _require_table(path, name, table)
            _require_rows(path, tables)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
        raise CaseError(f"{path}: expected a VTKHDF file, found: {error}") from None


def _tables(path: Path, group: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Tables by their names, also those that links within the file give."""
    import h5py

    for key in group:
        own = f"{name}/{key}".strip("/")
        link = group.get(key, getlink=True)
        if not isinstance(link, h5py.HardLink | h5py.SoftLink):
            raise CaseError(f"{path}: {own}: expected numbers, found a link to another file")
        if own.count("/") > DEEPEST:
            raise CaseError(f"{path}: expected groups in at most {DEEPEST} others, found {own!r}")
        node = group.get(key)
        if isinstance(node, h5py.Dataset):
            yield own, node
        elif isinstance(node, h5py.Group):
            yield from _tables(path, node, own)


def _require_rows(path: Path, tables: Mapping[str, Any]) -> None:
    """Check that tables have the rows of the steps of a grid: VTK reads what is in memory.

    Raises:
        CaseError: names the table that has not.
    """
    counts = {
        key: np.ravel(tables[f"VTKHDF/{key}"][()]).astype(np.int64)
        for key in PARTS
        if f"VTKHDF/{key}" in tables
    }
    if PARTS - counts.keys():  # no unstructured grid
        return
    steps, count = tables.get("VTKHDF/Steps/Values"), 1
    if steps is not None:
        count = len(steps)
    firsts = _of_steps(path, tables, "PartOffsets", count, 0)
    every = len(counts["NumberOfPoints"]) if steps is None else 1
    sizes = _of_steps(path, tables, "NumberOfParts", count, every)
    for name, table in tables.items():
        short = name.removeprefix("VTKHDF/")
        known = next((each for each in ROWS if short.split("/")[0] == each), None)
        if known is None:
            continue
        key, extra = ROWS[known]
        column = OFFSETS.get(short, short.replace("Data/", "DataOffsets/"))
        before = _of_steps(path, tables, column, count, 0)
        # Values without places of their steps are those of one.
        alone = steps is None or ("/" in short and f"VTKHDF/Steps/{column}" not in tables)
        for step, (first, size, start) in enumerate(zip(firsts, sizes, before, strict=True)):
            own = counts[key][max(first, 0) : max(first, 0) + size]
            need = start + int((own + extra).sum())
            short_of = min(first, size, start) < 0 or len(own) < size or need > len(table)
            if short_of or (alone and need != len(table)):
                raise CaseError(
                    f"{path}: {name}: expected {need} rows by the counts of step {step + 1}, found "
                    f"{len(table)}"
                )


def _of_steps(
    path: Path, tables: Mapping[str, Any], name: str, count: int, otherwise: int
) -> list[int]:
    """Numbers of each step of a grid; the same of all where the file has none."""
    table = tables.get(f"VTKHDF/Steps/{name}")
    if table is None:
        return [otherwise] * count
    found = np.asarray(table).reshape(len(table), -1)
    if len(found) < count or not found.shape[1]:
        raise CaseError(f"{path}: {name}: expected {count} steps, found {len(found)}")
    return [int(each) for each in found[:count, 0]]


def _require_table(path: Path, name: str, table: Any) -> None:
    """Check a table of a VTKHDF file; those of many steps may be long, as they are read in part."""
    if table.external or table.is_virtual:
        raise CaseError(f"{path}: {name}: expected numbers, found those of another file")
    shape, last = table.shape or (), name.split("/")[-1]
    wide = math.prod(shape[1:])
    require_count(path, f"components of {name}", wide, MOST_COMPONENTS)
    rows = shape[0] if shape else 1
    if last.startswith("NumberOf") or "/Steps/" in name:
        require_count(path, f"rows of {name}", rows, MOST_ROWS)
    if last in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
        for count in np.ravel(table[()]).tolist():
            require_count(path, name, int(count), MOST_BYTES // 8)
    elif "PointData" not in name:
        require_count(path, f"rows of {name}", rows, MOST_BYTES // (8 * max(wide, 1)))


CHECKS: Mapping[str, Callable[[Path], None]] = {
    ".vtk": _older_vtk,
    ".vtu": _xml,
    COLLECTION: _collection,
    ".hdf": _hdf,
    ".vtkhdf": _hdf,
}
