# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arrays that go to a file row by row while a history is solved, and the note to continue it from.

What is in memory does not grow with the number of rows. Blocks of rows are appended to the file and
never changed: whatever ends the process, the rows before are there. Each block has a checksum, by
which one sees that it was damaged since.

A checkpoint beside the rows has all else that is needed to continue the history. It is replaced as
a whole, when the rows that it counts are on the disk. The one before stays: it counts fewer rows,
and is good for those that damage at the end of the file has left.
"""

from __future__ import annotations

import bisect
import json
import math
import os
import tempfile
import weakref
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Indices
from fretfe.errors import OutputError
from fretfe.files import disk_reason, make_folder, open_own, replacing, sync, writing
from fretfe.history.state_array import StateArray, states_in_block

# Folder of the states in that of the results, and the file in it.
STATES = "states"
FILE = "states.rows"
# Part of a block that waits to be written, as one over this.
PENDING = 8


@dataclass(frozen=True)
class RowKind:
    """Rows of an array, all of one shape and type, and where in the file they are.

    Attributes:
        shape: of a row.
        dtype: of its elements.
        blocks: place in the file, in bytes, number of rows and checksum of each block of rows.
    """

    shape: tuple[int, ...]
    dtype: str
    blocks: tuple[tuple[int, int, int], ...] = ()

    @property
    def size(self) -> int:
        """Bytes of a row."""
        return math.prod(self.shape) * np.dtype(self.dtype).itemsize


@dataclass
class _Rows:
    """An array that grows block by block; the last rows wait to be written."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    blocks: list[tuple[int, int, int]]
    starts: list[int]
    count: int
    waiting: list[Any] = field(default_factory=list)

    @classmethod
    def of(cls, kind: RowKind) -> _Rows:
        """The array with the rows that are there."""
        counts = [rows for _, rows, _ in kind.blocks]
        starts = [0, *np.cumsum(counts, dtype=int).tolist()]
        return cls(kind.shape, np.dtype(kind.dtype), list(kind.blocks), starts[:-1], starts[-1])

    @property
    def size(self) -> int:
        """Bytes of a row."""
        return math.prod(self.shape) * self.dtype.itemsize

    def parts(self, begin: int, end: int) -> Iterator[tuple[int, int]]:
        """Place and length in bytes of all that some successive rows are made of."""
        number = bisect.bisect_right(self.starts, begin) - 1
        while begin < end:
            (place, rows, _), start = self.blocks[number], self.starts[number]
            last = min(end, start + rows)
            yield place + (begin - start) * self.size, (last - begin) * self.size
            begin, number = last, number + 1


class StateStream:
    """Growing arrays in one file.

    Args:
        directory: folder for the file, made if missing; None for a file without a name, which takes
            no care.
        kinds: arrays that are there, as `damage` has found, and are continued, by name; what else
            is in the file goes.

    Raises:
        OutputError: if there is no place to write; so do all methods.
    """

    def __init__(
        self, directory: Path | None = None, kinds: Mapping[str, RowKind] | None = None
    ) -> None:
        self._directory = directory
        self._rows = {name: _Rows.of(kind) for name, kind in (kinds or {}).items()}
        self._end = max((end for _, end, _ in _blocks(kinds or {})), default=0)
        try:
            self._file = self._open()
            weakref.finalize(self, os.close, self._file)
            os.ftruncate(self._file, self._end)
        except OSError as error:
            raise self._error(error) from error

    def _open(self) -> int:
        if self._directory is not None:
            make_folder(self._directory)
            return open_own(self._directory / FILE, os.O_RDWR)
        file, name = tempfile.mkstemp()
        os.unlink(name)
        return file

    def append(self, rows: Mapping[str, Any]) -> None:
        """Add a row to each of some arrays."""
        for name, row in rows.items():
            row = np.ascontiguousarray(row)
            if name not in self._rows:
                self._rows[name] = _Rows.of(RowKind(row.shape, row.dtype.str))
            each = self._rows[name]
            each.waiting.append(row)
            if len(each.waiting) == states_in_block(PENDING * row.nbytes):
                self._write(each)

    def count(self, name: str) -> int:
        """Number of rows of an array, those that wait included."""
        each = self._rows.get(name)
        return each.count + len(each.waiting) if each is not None else 0

    def _write(self, rows: _Rows) -> None:
        """Write the rows that wait; those that a full disk cuts off wait on."""
        if not rows.waiting:
            return
        data = memoryview(b"".join(row.tobytes() for row in rows.waiting))
        checksum, place = zlib.crc32(data), self._end
        try:
            while data:
                done = os.pwrite(self._file, data, place)
                data, place = data[done:], place + done
        except OSError as error:
            raise self._error(error) from error
        rows.blocks.append((self._end, len(rows.waiting), checksum))
        rows.starts.append(rows.count)
        rows.count += len(rows.waiting)
        rows.waiting.clear()
        self._end = place

    def settle(self) -> None:
        """Write all rows."""
        for each in self._rows.values():
            self._write(each)

    def flush(self) -> dict[str, RowKind]:
        """Write all rows, and have them on the disk; return what there is then."""
        self.settle()
        try:
            sync(self._file)
        except OSError as error:
            raise self._error(error) from error
        return {
            name: RowKind(each.shape, each.dtype.str, tuple(each.blocks))
            for name, each in self._rows.items()
        }

    def read(self, name: str, rows: Indices, part: slice = slice(None)) -> Any:
        """Return (n, ...) some rows, in any order, of one array.

        Args:
            name: of the array.
            rows: (n,) their numbers.
            part: of the axis behind that of the rows.
        """
        each = self._rows[name]
        if len(rows) == 1 and rows[0] >= each.count:  # one of the last, as while states are solved
            return each.waiting[rows[0] - each.count][None, part].copy()
        self._write(each)
        return select_rows(_Reader(self, each), rows, part)

    def between(self, rows: _Rows, begin: int, end: int) -> Any:
        """Return rows from one number to another of an array that is written."""
        data = bytearray((end - begin) * rows.size)
        view = memoryview(data)
        try:
            for place, length in rows.parts(begin, end):
                while length:
                    done = os.preadv(self._file, [view[:length]], place)
                    if not done:
                        raise OSError(f"{FILE} has been cut")
                    view, place, length = view[done:], place + done, length - done
        except OSError as error:
            raise self._error(error) from error
        return np.frombuffer(data, rows.dtype).reshape(end - begin, *rows.shape)

    def rows(self, name: str, rows: Indices, part: slice) -> StateArray:
        """Return some rows of an array as one that is read where it is needed.

        Args:
            name: of the array.
            rows: (T,) their numbers.
            part: of the axis behind that of the rows.
        """
        each = self._rows[name]
        shape = (len(rows), len(range(*part.indices(each.shape[0]))), *each.shape[1:])
        return StateArray(shape, each.dtype, lambda states: self.read(name, rows[states], part))

    def _error(self, error: OSError) -> OutputError:
        place = self._directory or tempfile.gettempdir()
        return OutputError(
            f"{place}: expected a place for the states of the history, found: {disk_reason(error)}"
        )


def damage(directory: Path, kinds: Mapping[str, RowKind]) -> str:
    """Say what is wrong with rows that were written to a file; empty if they are as they were.

    Args:
        directory: folder of the file.
        kinds: the rows, by name.
    """
    path = directory / FILE
    try:
        with path.open("rb") as file:
            for begin, end, checksum in sorted(_blocks(kinds)):
                file.seek(begin)
                data = file.read(end - begin)
                if len(data) < end - begin:
                    return f"{path} has been cut at byte {begin + len(data)}"
                if zlib.crc32(data) != checksum:
                    return f"{path} has changed between bytes {begin} and {end}"
    except OSError as error:
        return f"{path} cannot be read: {error.strerror}"
    return ""


def _blocks(kinds: Mapping[str, RowKind]) -> Iterator[tuple[int, int, int]]:
    """Begin, end and checksum of every block of rows."""
    for kind in kinds.values():
        for begin, rows, checksum in kind.blocks:
            yield begin, begin + rows * kind.size, checksum


@dataclass(frozen=True)
class _Reader:
    """Rows that are read like those of a data set of HDF5."""

    stream: StateStream
    rows: _Rows

    def __getitem__(self, key: tuple[slice, slice]) -> Any:
        """Rows one after the other, and a part of the axis behind."""
        where, part = key
        begin, end, _ = where.indices(self.rows.count)
        found = self.stream.between(self.rows, begin, end)
        return found if part == slice(None) else found[:, part]


def select_rows(dataset: Any, rows: Indices, part: slice = slice(None)) -> Any:
    """Return (n, ...) some rows, in any order, of a data set.

    Args:
        dataset: of a file of HDF5 that is open, or what is read like one.
        rows: (n,) their numbers.
        part: of the axis behind that of the rows.
    """
    if len(rows) and np.array_equal(rows, np.arange(rows[0], rows[0] + len(rows))):
        return dataset[rows[0] : rows[-1] + 1, part]
    wanted, places = np.unique(rows, return_inverse=True)
    runs = np.split(wanted, np.flatnonzero(np.diff(wanted) > 1) + 1)
    found = [dataset[run[0] : run[-1] + 1, part] for run in runs if len(run)]
    if not found:
        return dataset[:0, part]
    values = found[0] if len(found) == 1 else np.concatenate(found)
    same = len(wanted) == len(rows) and np.array_equal(wanted, rows)
    return values if same else values[places]


CHECKPOINT = "checkpoint.npz"
BEFORE = "checkpoint-before.npz"
# Name of the text among the arrays.
TEXT = "text"


@dataclass(frozen=True)
class Checkpoint:
    """All that is known besides the states.

    Attributes:
        identity: of the problem that they belong to, by what it says, such as ``mesh``.
        kinds: rows of the states that count.
        arrays: everything else.
    """

    identity: Mapping[str, str]
    kinds: Mapping[str, RowKind]
    arrays: Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Storage:
    """The file for the states of a history.

    Attributes:
        directory: folder for them; None for files without names.
        resume: whether those that are there already are continued.
        identity: of the problem, by what it says, such as ``mesh``.
        say: gets a line if states cannot be gone on from.
    """

    directory: Path | None = None
    resume: bool = False
    identity: Mapping[str, str] = field(default_factory=dict)
    say: Callable[[str], None] = lambda _: None

    def continued(self, identity: Mapping[str, str]) -> Checkpoint | None:
        """The last checkpoint of a problem with this identity whose states are whole; None if none.

        Raises:
            OutputError: if it belongs to something else.
        """
        if self.directory is None or not self.resume:
            return None
        fault = ""
        for name in (CHECKPOINT, BEFORE):
            try:
                found = read_checkpoint(self.directory / name)
            except OutputError as error:
                fault = fault or str(error)
                continue
            if found is None:
                continue
            _require_same(self.directory, found.identity, identity)
            damaged = damage(self.directory, found.kinds)
            if not damaged:
                if fault:
                    self.say(f"{fault}. States before that are whole: the run goes on from them")
                return found
            fault = fault or damaged
        if fault:
            self.say(f"{fault}. No states before that are left: the first step is solved again")
        return None


UNSEEN = Storage()


def write_checkpoint(directory: Path, checkpoint: Checkpoint) -> None:
    """Write a checkpoint; the one before gets another name.

    Raises:
        OutputError: if that fails; the one before stays.
    """
    kinds = {name: asdict(kind) for name, kind in checkpoint.kinds.items()}
    text = json.dumps({"identity": dict(checkpoint.identity), "kinds": kinds})
    arrays: dict[str, Any] = {**checkpoint.arrays, TEXT: np.array(text)}
    file = BytesIO()
    np.savez(file, **arrays)
    # A copy: collecting a view of its buffer, which an error may keep, has crashed Python 3.12.
    data = file.getvalue()
    last = directory / CHECKPOINT
    with writing(last, "the states of the history"), replacing(last) as new:
        with new.open("wb") as out:
            out.write(data)
            out.write(sha256(data).digest())
        if last.exists():
            last.replace(directory / BEFORE)


def read_checkpoint(path: Path) -> Checkpoint | None:
    """A checkpoint that was written; None if there is none.

    Raises:
        OutputError: if it is not as it was written.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise OutputError(f"{path} cannot be read: {error.strerror}") from error
    size = sha256().digest_size
    if sha256(data[:-size]).digest() != data[-size:]:
        raise OutputError(f"{path} has changed since it was written")
    with np.load(BytesIO(data[:-size]), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    text = json.loads(str(arrays.pop(TEXT)))
    kinds = {
        name: RowKind(tuple(kind["shape"]), kind["dtype"], tuple(map(tuple, kind["blocks"])))
        for name, kind in text["kinds"].items()
    }
    return Checkpoint(text["identity"], kinds, arrays)


def _require_same(directory: Path, then: Mapping[str, str], now: Mapping[str, str]) -> None:
    """Check that states are of the problem that goes on with them.

    Raises:
        OutputError: if they are not; says what has changed.
    """
    changed = [name for name in {**then, **now} if then.get(name) != now.get(name)]
    if changed:
        told = (_change(name, then.get(name, ""), now.get(name, "")) for name in changed)
        raise OutputError(
            f"{directory}: the run cannot be continued, as these have changed since: "
            f"{', '.join(told)}. Run the case again without --resume"
        )


def _change(name: str, then: str, now: str) -> str:
    """A change in words; digests say nothing to anybody."""
    return f"{name} ({then or 'none'} then, {now or 'none'} now)" if len(then + now) < 64 else name
