# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders that are damaged, incomplete or hostile."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from random import Random
from typing import Any

import h5py
import numpy as np
from cases.stored_runs import edit_numbers
from faults.fault import Fault, Prepare, damaged
from faults.originals import leaves

REPORT = ("report", "run")
# Words that would be code in a page.
SCRIPT = "<script>document.title='escaped'</script>"
VALUES: dict[str, Any] = {
    "null": None,
    "text": "a",
    "script": SCRIPT,
    "minus": -1,
    "huge": 10**400,
    "nan": float("nan"),
    "inf": float("inf"),
    "list": [],
    "table": {},
    "deep": json.loads("[" * 200 + "]" * 200),
    "true": True,
}
# Texts of results that may be anything.
TEXTS = {
    "title": SCRIPT,
    "notes": [SCRIPT],
    "units/length": SCRIPT,
    "versions/python": SCRIPT,
    "contacts/main/warnings": [
        {
            "kind": "fault",
            "subject": {"contact": SCRIPT, "front": SCRIPT},
            "text": SCRIPT,
            "partly": False,
        }
    ],
    "case/title": SCRIPT,
}


def faults() -> Iterator[Fault]:
    """All of them."""
    for seed in range(24):
        yield Fault(f"results.json/damaged/{seed}", REPORT, _bytes("results.json", seed))
    for seed in range(24):
        yield Fault(f"results.h5/damaged/{seed}", REPORT, _bytes("results.h5", seed))
    yield from _values()
    yield from _arrays()
    yield from _pictures()
    for file in ("results.json", "results.h5"):
        for make in ("pipe", "folder", "/dev/zero"):
            yield Fault(f"{file}/{make}", REPORT, _no_file(file, make), True)


def _copied(change: Callable[[Path], object]) -> Prepare:
    def write(good: Path, here: Path) -> None:
        shutil.copytree(good / "run", here / "run")
        change(here / "run")

    return write


def _bytes(name: str, seed: int) -> Prepare:
    def change(folder: Path) -> None:
        path = folder / name
        path.write_bytes(damaged(path.read_bytes(), seed))

    return _copied(change)


def _no_file(name: str, make: str) -> Prepare:
    def change(folder: Path) -> None:
        path = folder / name
        path.unlink()
        if make == "pipe":
            os.mkfifo(path)
        elif make == "folder":
            path.mkdir()
        else:
            path.symlink_to(make)

    return _copied(change)


def _values() -> Iterator[Fault]:
    """Other values in results.json, and texts that a run could have written."""
    for seed in range(70):

        def edit(numbers: dict[str, Any], seed: int = seed) -> None:
            random = Random(seed)
            *keys, last = random.choice(leaves(numbers))
            table = _at(numbers, keys)
            old = json.dumps(table[last])
            others = [value for value in VALUES.values() if json.dumps(value) != old]
            table[last] = random.choice(others)

        yield Fault(f"results.json/value/{seed}", REPORT, _copied(_plainly(edit)), True)
    for seed in range(16):

        def remove(numbers: dict[str, Any], seed: int = seed) -> None:
            table = numbers if seed < 10 else numbers["contacts"]["main"]
            del table[Random(seed).choice(sorted(table))]

        yield Fault(f"results.json/key missing/{seed}", REPORT, _copied(_plainly(remove)), True)
    for key, value in TEXTS.items():

        def write(folder: Path, key: str = key, value: Any = value) -> None:
            *keys, last = key.split("/")
            edit_numbers(folder, lambda numbers: _at(numbers, keys).update({last: value}))

        yield Fault(f"results.json/text/{key}", REPORT, _copied(write), False)
    yield Fault(
        "results.json/deep", REPORT,
        _copied(lambda f: (f / "results.json").write_text("[" * 100000 + "]" * 100000)), True,
    )  # fmt: skip


def _at(numbers: Any, keys: Sequence[Any]) -> Any:
    for key in keys:
        numbers = numbers[key]
    return numbers


def _plainly(edit: Callable[[dict[str, Any]], object]) -> Callable[[Path], object]:
    """Change the numbers in a folder, and not their digest."""

    def change(folder: Path) -> None:
        path = folder / "results.json"
        numbers = json.loads(path.read_text())
        edit(numbers)
        path.write_text(json.dumps(numbers))

    return change


def _arrays() -> Iterator[Fault]:
    def edit(work: Callable[[h5py.File], object]) -> Prepare:
        def change(folder: Path) -> None:
            with h5py.File(folder / "results.h5", "r+") as file:
                work(file)

        return _copied(change)

    def replace(file: h5py.File, name: str, value: Any) -> None:
        del file[name]
        file[name] = value

    for name in ("times", "contacts/main/pressure", "contacts/main/x", "states"):
        for kind, value in (
            ("nan", np.full(3, np.nan)),
            ("empty", np.empty(0)),
            ("text", "a"),
            ("outside", h5py.ExternalLink("/etc/passwd", "/x")),
            ("itself", h5py.SoftLink(f"/{name}")),
        ):

            def work(file: h5py.File, name: str = name, value: Any = value) -> None:
                if name not in file:
                    group = file["contacts/main"]
                    name = f"contacts/main/{sorted(group)[len(name) % len(group)]}"
                replace(file, name, value)

            yield Fault(f"results.h5/{name}: {kind}", REPORT, edit(work))


def _pictures() -> Iterator[Fault]:
    """Lists of pictures that name files elsewhere."""
    for name in ("../../secret", "/etc/passwd", "pipe", "missing.png"):

        def change(folder: Path, name: str = name) -> None:
            pictures = folder / "pictures"
            pictures.mkdir(exist_ok=True)
            os.mkfifo(pictures / "pipe")
            entry = {"file": name, "title": SCRIPT, "caption": SCRIPT, "width": 1, "height": 1}
            listed = {"pictures": [entry], "missing": []}
            (pictures / "pictures.json").write_text(json.dumps(listed))

        yield Fault(f"pictures.json/{name}", REPORT, _copied(change))
