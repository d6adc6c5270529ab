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
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np

from fretfe.errors import CaseError
from fretfe.files import MOST_BYTES, MOST_ROWS, MOST_STATED, file_fault

# What a .pvd file may name.
PIECES = (".vtu", ".vtk")
# Components of a value at a node: a tensor has 9.
MOST_COMPONENTS = 100
# Digits of a whole number.
LONGEST_COUNT = 20
# Bytes that are read from a file at a time.
CHUNK = 1 << 20
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


@dataclass
class _Block:
    """An array of a file of VTK in XML: where its bytes are, and how many it states."""

    stated: int
    offset: int | None
    head: bytes = b""


@dataclass
class _Xml:
    """Sizes in the elements of a file of VTK in XML, up to the bytes that are appended to it."""

    path: Path
    pieces: list[str] = field(default_factory=list)
    blocks: list[_Block] = field(default_factory=list)
    compressed: bool = False
    word: str = "I"
    order: str = "<"
    appended: int = -1
    encoding: str = "raw"
    _counts: dict[str, int] = field(default_factory=dict)
    _within: list[str] = field(default_factory=list)

    def read(self) -> None:
        """Go through the elements, without entities of any kind."""
        parser = self._parser = expat.ParserCreate()
        parser.StartDoctypeDeclHandler = self._refuse
        parser.StartElementHandler, parser.EndElementHandler = self._start, self._end
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
        of_points = self._within[-2:-1] in (["Points"], ["PointData"])
        count = self._counts.get("NumberOfPoints" if of_points else "NumberOfCells", 0)
        offset = None
        if words.get("format") == "appended":
            offset = self._whole("offset", words.get("offset", "0"))
        # The largest kind of numbers has 8 bytes.
        self.blocks.append(_Block(8 * components * count, offset))
        if self.compressed and words.get("format") == "binary":
            self._parser.CharacterDataHandler = self._characters

    def _characters(self, text: str) -> None:
        """The first characters of an array, which tell the sizes of its blocks."""
        block = self.blocks[-1]
        block.head += "".join(text.split()).encode("ascii", "replace")
        if len(block.head) >= self.head_size * 4 // 3:
            self._parser.CharacterDataHandler = None

    def _end(self, name: str) -> None:
        self._within.pop()
        self._parser.CharacterDataHandler = None

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
            yield max(block.stated, self._unpacked(block) if self.compressed else 0)

    def _unpacked(self, block: _Block) -> int:
        head = block.head if block.offset is None else self._appended_head(block.offset)
        if block.offset is None or self.encoding == "base64":
            try:
                head = base64.b64decode(head[: self.head_size * 4 // 3])
            except binascii.Error:
                return 0  # VTK reads none of it
        if len(head) < self.head_size:
            return 0
        count, size, last = struct.unpack(f"{self.order}3{self.word}", head[: self.head_size])
        return max(count, 1) * max(size, last)

    def _appended_head(self, offset: int) -> bytes:
        with self.path.open("rb") as file:
            file.seek(self.appended)
            start = self.appended + file.read(CHUNK).find(b"_") + 1
            file.seek(start + offset)
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


def _collection(path: Path) -> None:
    """A file that names those of its steps."""
    found = _Xml(path)
    found.read()
    require_count(path, "files", len(found.pieces), MOST_ROWS)
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
            tables: dict[str, Any] = {}
            file.visititems(lambda name, node: tables.update({name: node}))
            for name, table in tables.items():
                if isinstance(table, h5py.Dataset):
                    _require_table(path, name, table)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
        raise CaseError(f"{path}: expected a VTKHDF file, found: {error}") from None


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
    ".pvd": _collection,
    ".hdf": _hdf,
    ".vtkhdf": _hdf,
}
