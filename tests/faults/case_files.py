# SPDX-License-Identifier: LGPL-3.0-or-later
"""Case files that are damaged, have hostile values or are no files."""

from __future__ import annotations

import copy
import os
import shutil
from collections.abc import Iterator
from dataclasses import replace
from itertools import cycle, product
from pathlib import Path
from random import Random
from typing import Any

import tomli_w
from faults.fault import CHECK, HALFPLANE, Fault, Prepare, damaged, text_fault
from faults.originals import BETWEEN, COATED, PAD, RUBBED, SOLID, leaves

HUGE = 10**400
# Hostile values, as TOML has them.
VALUES: dict[str, str] = {
    "nan": "nan",
    "inf": "inf",
    "-inf": "-inf",
    "zero": "0",
    "minus": "-1",
    "1e308": "1e308",
    "1e-308": "1e-308",
    "1e40": "1e40",
    "400 digits": str(HUGE),
    "4400 digits": "1" + "0" * 4400,
    "2^63": str(2**63),
    "billion": "1000000000",
    "true": "true",
    "empty": '""',
    "path": '"../../escaped"',
    "long": f'"{"x" * 5000}"',
    "control": '"a\\u0000\\u001b[31m\\n"',
    "markup": '"<script>alert(1)</script>[red]"',
    "list": "[]",
    "table": "{}",
    "numbers": "[1, 2, 3, 4]",
    "deep": "[" * 300 + "]" * 300,
    "date": "1979-05-27T07:32:00Z",
}
KEYS = {
    "long": "x" * 5000,
    "path": "../../escaped",
    "dots": "a.b.c",
    "empty": "",
    "lines": "a\nb",
    "unicode": "Фланец",
    "lone dash": "-",
    "option": "--help",
    "star": "*",
    "tag": "::name",
}
PLACEHOLDER = "PLACEHOLDER-5d1c"


def faults() -> Iterator[Fault]:
    """All of them."""
    for command in (CHECK, HALFPLANE):
        yield text_fault(f"toml/whole/{' '.join(command)}", command, tomli_w.dumps(PAD), False)
    yield from _damaged()
    yield from _values()
    yield from _keys()
    yield from _special()
    yield from _no_files()
    yield from _overrides()


def _damaged() -> Iterator[Fault]:
    text = tomli_w.dumps(PAD).encode()
    commands = cycle((CHECK, HALFPLANE))
    for seed in range(60):
        yield text_fault(f"toml/damaged/{seed}", next(commands), damaged(text, seed))


def _set(tables: dict[str, Any], path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    changed: Any = copy.deepcopy(tables)
    place = changed
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return changed


def _values() -> Iterator[Fault]:
    random = Random(18)
    commands = cycle((HALFPLANE, CHECK, HALFPLANE))
    for kind, tables, count in (("plane", PAD, 190), ("solid", SOLID, 40)):
        for path, name in random.sample(list(product(leaves(tables), VALUES)), count):
            command = next(commands) if kind == "plane" else CHECK
            yield _with_value(kind, tables, path, name, command)
    between = [path for path in leaves(COATED) if set(path) & BETWEEN.keys()]
    for path, name in product(between, VALUES):
        fault = _with_value("coated", COATED, path, name, CHECK)
        yield replace(fault, prepare=beside("gap.csv", fault.prepare))
    for kind, tables in RUBBED.items():
        own = [path for path in leaves(tables) if {"friction", "start", "layer"} & {*path}]
        for path, name in product(own, VALUES):
            yield _with_value(kind, tables, path, name, CHECK)


def _with_value(
    kind: str, tables: dict[str, Any], path: tuple[Any, ...], name: str, command: tuple[str, ...]
) -> Fault:
    text = tomli_w.dumps(_set(tables, path, PLACEHOLDER))
    text = text.replace(f'"{PLACEHOLDER}"', VALUES[name])
    bad = name in ("nan", "inf", "-inf", "4400 digits", "deep", "date", "table")
    return text_fault(
        f"toml/{kind}/{'.'.join(map(str, path))} = {name}", command, text, bad or None
    )


def beside(file: str, prepare: Prepare) -> Prepare:
    """The same beside a good file."""

    def write(good: Path, here: Path) -> None:
        prepare(good, here)
        shutil.copy(good / file, here)

    return write


def _keys() -> Iterator[Fault]:
    for table in ("bodies", "contacts", "supports", "loads"):
        for name, key in KEYS.items():
            changed = copy.deepcopy(PAD)
            first = next(iter(changed[table]))
            changed[table][key] = changed[table].pop(first)
            refused = name != "lone dash" or None
            text = tomli_w.dumps(changed)
            yield text_fault(f"toml/key of {table}: {name}", HALFPLANE, text, refused)


def _special() -> Iterator[Fault]:
    text = tomli_w.dumps(PAD)
    specials: dict[str, str | bytes] = {
        "empty": "",
        "byte order mark alone": b"\xef\xbb\xbf",
        "UTF-16": text.encode("utf-16"),
        "NUL bytes": bytes(4000),
        "deep lists": "a = " + "[" * 20000 + "]" * 20000,
        "deep tables": "a = " + "{a=" * 5000 + "1" + "}" * 5000,
        "deep keys": ".".join("a" * 20000) + " = 1",
        "deep table name": "[" + ".".join("a" * 5000) + "]\n" + text,
        "deep title": "title" + ".a" * 3000 + " = 1\n" + text.replace('title = "pad"', ""),
        "many keys": "".join(f"k{i} = 1\n" for i in range(20000)),
        "a lone surrogate": text.replace("pad", "\ud800"),
        "a huge string": f'title = "{"x" * 3_000_000}"\n' + text.replace('title = "pad"', ""),
        "a list of a million": f"output.fields = [{'1,' * 1_000_000}]\n"
        + text.replace('[output]\nfields = "none"\n', ""),
        "hash bang": "#!/bin/sh\ntouch escaped\n" + text,
        "decimal comma": text.replace("0.4", "0,4"),
        "two tables": text + "\n[cycle]\n",
        "JSON": '{"geometry": {"template": "cylinder"}}',
        "YAML": "geometry:\n  template: cylinder\n",
        "pickle": b"\x80\x04\x8c\x05posix\x8c\x06system\x93\x8c\x0dtouch escaped\x85R.",
    }
    for name, content in specials.items():
        yield text_fault(f"toml/{name}", CHECK, content, name != "a list of a million" or None)
    for steps in (10**7, 10**12, 10**30, HUGE):
        for key in ("steps", "cycles", "steps_per_cycle"):
            changed = copy.deepcopy(PAD)
            press, wave = changed["loads"]["press"], changed["loads"]["shear"]["history"][1]
            (press["history"][0] if key == "steps" else wave)[key] = steps
            name = f"toml/{key} of 10^{len(str(steps)) - 1}"
            yield text_fault(name, HALFPLANE, tomli_w.dumps(changed), True)


def _no_files() -> Iterator[Fault]:
    def prepare(make: str) -> Any:
        def write(good: Path, here: Path) -> None:
            path = here / "case.toml"
            match make:
                case "folder":
                    path.mkdir()
                case "pipe":
                    os.mkfifo(path)
                case "loop":
                    path.symlink_to(path)
                case "nowhere":
                    path.symlink_to(here / "nothing")
                case "nothing":
                    pass
                case device:
                    path.symlink_to(device)

        return write

    for make in ("folder", "pipe", "loop", "nowhere", "nothing", "/dev/zero", "/dev/null"):
        yield Fault(f"toml/no file: {make}", CHECK, prepare(make), True)
    for name in ("a" * 5000, "nul\0.toml", "-", "", "case.toml/inside", "~/case.toml", "\udcff"):
        if "\0" not in name:
            yield Fault(f"toml/named {name[:9]!r}", ("check", name), prepare("nothing"), True)


def _overrides() -> Iterator[Fault]:
    text = tomli_w.dumps(PAD)
    options = [
        "loads.shear.amplitude=nan", "loads.shear.amplitude=1e999", "a" * 5000 + "=1",
        ".".join("a" * 3000) + "=1", "=", "=1", "x", "loads.*.history.*.steps=-1", "*=1",
        "*.*.*=1", "loads.shear.history.99999999999999999999.until=1", "loads.shear.history.0.x=1",
        "geometry.file=/etc/passwd", "geometry.template=../../etc/passwd",
        "title=" + "[" * 10000, "title=" + "9" * 5000, "contacts.main.friction=" + "9" * 400,
        "loads.shear.history=[]", "loads=1", "bodies.upper=[]", "bodies.upper.young=true",
        "output.fields=[1e400]", "geometry.parameters.size=1e-9", "geometry.parameters.size=nan",
        "loads.shear.history.²=1",
    ]  # fmt: skip
    for option in options:
        command = (*HALFPLANE, "--set", option)
        yield text_fault(f"toml/--set {option[:50]}", command, text)
    sweep = ("sweep", "case.toml", "-o", "out", "--backend", "halfplane")
    for words in (
        ("--vary", "contacts.main.friction=0.1:0.2:99999999999"),
        ("--vary", "contacts.main.friction=nan:1:3"),
        ("--vary", "contacts.main.friction=0:1:-3"),
        ("--vary", "contacts.main.friction=" + ":" * 50),
        ("--vary", "contacts.main.friction="),
        ("--vary", "title=a,b,,c"),
    ):
        refused = None if words[1].startswith("title") else True
        yield text_fault(f"toml/{' '.join(words)}", (*sweep, *words), text, refused)
