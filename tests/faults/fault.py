# SPDX-License-Identifier: LGPL-3.0-or-later
"""One malformed or hostile input: files in a folder, and the command that reads them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

# Writes the files of an input into an empty folder, from a folder of good files.
Prepare = Callable[[Path, Path], object]
CHECK = ("check", "case.toml")
HALFPLANE = ("run", "case.toml", "-o", "out", "--backend", "halfplane", "--no-report", "-q")
FEM = ("run", "case.toml", "-o", "out", "--no-report", "-q")


@dataclass(frozen=True)
class Fault:
    """An input.

    Attributes:
        name: for people; unique.
        command: words of the command, which runs in the folder of the files.
        prepare: writes the files.
        refused: whether it must not be accepted, or must be; None if that depends on chance.
    """

    name: str
    command: tuple[str, ...]
    prepare: Prepare
    refused: bool | None = None


def text_fault(
    name: str, command: tuple[str, ...], text: str | bytes, refused: bool | None = None
) -> Fault:
    """A case file of this text."""
    data = text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass")
    return Fault(name, command, lambda good, here: (here / "case.toml").write_bytes(data), refused)


def damaged(data: bytes, seed: int) -> bytes:
    """Bytes with a few mistakes: one of several kinds, by the seed."""
    random = Random(seed)
    kinds = (_cut, _flip, _zero, _random, _drop_lines, _repeat_lines, _swap_lines, _digits)
    for _ in range(random.randint(1, 3)):
        data = random.choice(kinds)(data, random)
    return data


def _place(data: bytes, random: Random) -> int:
    return random.randrange(max(len(data), 1))


def _cut(data: bytes, random: Random) -> bytes:
    return data[: _place(data, random)]


def _flip(data: bytes, random: Random) -> bytes:
    changed = bytearray(data)
    for _ in range(random.randint(1, 8) if data else 0):
        changed[_place(data, random)] ^= 1 << random.randrange(8)
    return bytes(changed)


def _zero(data: bytes, random: Random) -> bytes:
    start, count = _place(data, random), random.randint(1, 40)
    return data[:start] + bytes(count) + data[start + count :]


def _random(data: bytes, random: Random) -> bytes:
    start, count = _place(data, random), random.randint(1, 40)
    return data[:start] + random.randbytes(count) + data[start + count :]


def _drop_lines(data: bytes, random: Random) -> bytes:
    lines = data.splitlines(keepends=True)
    start = _place(lines, random)  # type: ignore[arg-type]
    return b"".join(lines[:start] + lines[start + random.randint(1, 3) :])


def _repeat_lines(data: bytes, random: Random) -> bytes:
    lines = data.splitlines(keepends=True)
    start = _place(lines, random)  # type: ignore[arg-type]
    return b"".join(lines[: start + 1] + lines[start:])


def _swap_lines(data: bytes, random: Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if lines:
        one, other = random.randrange(len(lines)), random.randrange(len(lines))
        lines[one], lines[other] = lines[other], lines[one]
    return b"".join(lines)


def _digits(data: bytes, random: Random) -> bytes:
    """Another number in place of one."""
    places = [i for i, byte in enumerate(data) if chr(byte).isdigit()]
    if not places:
        return data
    place = random.choice(places)
    other = random.choice((b"-", b"9", b"0", b"e99", b"nan", b"99999999999", b",", b"inf"))
    return data[:place] + other + data[place + 1 :]
