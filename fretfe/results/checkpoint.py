# SPDX-License-Identifier: LGPL-3.0-or-later
"""A note, beside the states of a history, of all that is needed to continue it.

It is replaced as a whole, when the rows that it counts have been written.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretfe.errors import OutputError
from fretfe.results.files import disk_reason, replacing
from fretfe.results.stream import RowKind

CHECKPOINT = "checkpoint.npz"
# Name of the text among the arrays.
TEXT = "text"


@dataclass(frozen=True)
class Checkpoint:
    """What is known besides the states.

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
    """Where the states of a history go.

    Attributes:
        directory: folder for them; None for files without names.
        resume: whether those that are there already are continued.
        identity: of the problem, by what it says, such as ``mesh``.
    """

    directory: Path | None = None
    resume: bool = False
    identity: Mapping[str, str] = field(default_factory=dict)

    def continued(self, identity: Mapping[str, str]) -> Checkpoint | None:
        """What there is to continue, of a problem with this identity; None if nothing.

        Raises:
            OutputError: as for `read_checkpoint`.
        """
        if self.directory is None or not self.resume:
            return None
        return read_checkpoint(self.directory, identity)


UNSEEN = Storage()


def write_checkpoint(directory: Path, checkpoint: Checkpoint) -> None:
    """Write a checkpoint in place of the one before.

    Raises:
        OutputError: if that fails; the one before stays.
    """
    kinds = {name: asdict(kind) for name, kind in checkpoint.kinds.items()}
    text = json.dumps({"identity": dict(checkpoint.identity), "kinds": kinds})
    arrays: dict[str, Any] = {**checkpoint.arrays, TEXT: np.array(text)}
    try:
        with replacing(directory / CHECKPOINT) as new, new.open("wb") as file:
            np.savez(file, **arrays)
    except OSError as error:
        raise OutputError(
            f"{directory}: the states of the history cannot be noted: {disk_reason(error)}"
        ) from error


def read_checkpoint(directory: Path, identity: Mapping[str, str]) -> Checkpoint | None:
    """The checkpoint in a folder; None if there is none.

    Args:
        directory: folder of the states.
        identity: what it has to belong to.

    Raises:
        OutputError: if it belongs to something else, or cannot be read.
    """
    path = directory / CHECKPOINT
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        text = json.loads(str(arrays.pop(TEXT)))
        kinds = {
            name: RowKind(
                tuple(kind["shape"]), kind["dtype"], tuple((at, n) for at, n in kind["blocks"])
            )
            for name, kind in text["kinds"].items()
        }
        found = {str(name): str(value) for name, value in text["identity"].items()}
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise OutputError(f"{path}: expected the checkpoint of a run, found: {error}") from error
    changed = [name for name in {**found, **identity} if found.get(name) != identity.get(name)]
    if changed:
        told = (_change(name, found.get(name, ""), identity.get(name, "")) for name in changed)
        raise OutputError(
            f"{directory}: the run cannot be continued, as these have changed since: "
            f"{', '.join(told)}. Run the case again without --resume"
        )
    return Checkpoint(found, kinds, arrays)


def _change(name: str, then: str, now: str) -> str:
    """A change in words; digests say nothing to anybody."""
    return f"{name} ({then or 'none'} then, {now or 'none'} now)" if len(then + now) < 64 else name
