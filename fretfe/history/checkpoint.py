# SPDX-License-Identifier: LGPL-3.0-or-later
"""A note, beside the states of a history, of all that is needed to continue it.

It is replaced as a whole, when the rows that it counts are on the disk. The one before stays: it
counts fewer rows, and is good for those that damage at the end of the file has left.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretfe.errors import OutputError
from fretfe.files import disk_reason, replacing
from fretfe.history.stream import RowKind, damage

CHECKPOINT, BEFORE = "checkpoint.npz", "checkpoint-before.npz"
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
    data = BytesIO()
    np.savez(data, **arrays)
    data.write(sha256(data.getbuffer()).digest())
    last = directory / CHECKPOINT
    try:
        with replacing(last) as new:
            new.write_bytes(data.getbuffer())
            if last.exists():
                last.replace(directory / BEFORE)
    except OSError as error:
        raise OutputError(
            f"{directory}: the states of the history cannot be noted: {disk_reason(error)}"
        ) from error


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
