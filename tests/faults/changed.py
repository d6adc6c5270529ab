# SPDX-License-Identifier: LGPL-3.0-or-later
"""Inputs that are a file beside a case: damaged, in place of it something else, or a pipe."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from faults.fault import CHECK, Fault, Prepare, damaged
from faults.originals import GRIDS, case_text

Change = Callable[[bytes], bytes]


def with_file(
    file: str, change: Change = bytes, text: str | None = None, content: bytes | None = None
) -> Prepare:
    """A case with a changed file: that of the good ones, or of this content."""

    def write(good: Path, here: Path) -> None:
        (here / "case.toml").write_text(case_text(file) if text is None else text)
        data = (good / file).read_bytes() if content is None else content
        (here / file).write_bytes(change(data))
        if file in GRIDS and not (here / "pad.h5").exists():
            shutil.copy(good / "pad.h5", here)

    return write


def pipe(file: str, text: str | None = None) -> Prepare:
    """A case with a pipe in place of its file."""

    def write(good: Path, here: Path) -> None:
        (here / "case.toml").write_text(case_text(file) if text is None else text)
        os.mkfifo(here / file)

    return write


def damaging(seed: int) -> Change:
    """Mistakes that a seed chooses."""
    return lambda data: damaged(data, seed)


def seeded(
    file: str,
    seeds: range,
    text: str | None = None,
    content: bytes | None = None,
    command: tuple[str, ...] = CHECK,
) -> Iterator[Fault]:
    """A file with mistakes that the seeds choose."""
    for seed in seeds:
        prepare = with_file(file, damaging(seed), text, content)
        yield Fault(f"{file}/damaged/{seed}", command, prepare)


def file_faults(
    file: str,
    text: str,
    wrong: Mapping[str, str | bytes],
    seeds: int = 12,
    content: str | None = None,
    command: tuple[str, ...] = CHECK,
) -> Iterator[Fault]:
    """A file beside a case.

    Args:
        file: its name.
        text: the case.
        wrong: contents that must be refused, by a name.
        seeds: how often it is damaged.
        content: of the file as it should be; without it that of the good one.
        command: reads it.
    """
    good = None if content is None else content.encode()
    yield Fault(f"{file}/whole", command, with_file(file, text=text, content=good), False)
    yield from seeded(file, range(seeds), text, good, command)
    yield Fault(f"{file}/pipe", command, pipe(file, text), True)
    for name, each in wrong.items():
        data = each if isinstance(each, bytes) else each.encode()
        yield Fault(f"{file}/{name}", command, with_file(file, text=text, content=data), True)


def replaced(old: bytes, new: bytes) -> Change:
    """Another text at the first place of one that is there."""

    def change(data: bytes) -> bytes:
        assert old in data, old
        return data.replace(old, new, 1)

    return change
