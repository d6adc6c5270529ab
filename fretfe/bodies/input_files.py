# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files whose contents decide what a case computes, and digests of them.

A run that goes on, and a sweep that does, are of the same files as before. Constants of materials
are numbers in the case already.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from hashlib import file_digest
from pathlib import Path

from fretfe.case import Case
from fretfe.case.reading import named_files
from fretfe.errors import FretfeError
from fretfe.files import file_fault
from fretfe.mesh.inp_cards import included_files
from fretfe.mesh.templates import template_directory, template_file
from fretfe.plugins import LOAD_FUNCTIONS, plug_in
from fretfe.results.field_files import FIELDS
from fretfe.results.writer import ARRAYS

# Names of other files in an XDMF file, in a collection of VTK files, and in a script of Gmsh.
XDMF = re.compile(rb">\s*([^<>:]{1,4096}?):/")
COLLECTION = re.compile(rb"""\bfile\s*=\s*["']([^"'<>]{1,4096})["']""")
SCRIPT = re.compile(rb"""(?i)\b(?:merge|include|shapefromfile)\b[\s(]*"([^"\n]{1,4096})\"""")


def input_files(case: Case) -> dict[Path, str]:
    """Files that a case names, and those that are named in these; the key of each, in words.

    Files that are missing, or cannot be read, are for their readers to complain about.
    """
    found: dict[Path, str] = {}
    for key, named in named_files(case).items():
        path = named / (ARRAYS if key[0] == "start" else FIELDS) if named.is_dir() else named
        for each in (path, *_within(path)):
            if not file_fault(each):
                found.setdefault(each.resolve(), ".".join(map(str, key)))
    template = case.geometry.template
    script = template_file(template) if template else None
    if script is not None and script.parent != template_directory():
        found.setdefault(script.resolve(), "geometry.template")
    for name, load in case.loads.items():
        function = getattr(load, "function", None)
        plugged = plug_in(LOAD_FUNCTIONS, function) if function else None
        if plugged is not None and plugged.file is not None:
            found.setdefault(plugged.file.resolve(), f"loads.{name}.function")
    return found


def _within(path: Path) -> Iterator[Path]:
    """Files that are named in another one."""
    if file_fault(path):
        return
    try:
        yield from WITHIN.get(path.suffix.lower(), lambda _: ())(path)
    except (OSError, ValueError, FretfeError):
        return


def _named_by(pattern: re.Pattern[bytes]) -> Callable[[Path], Iterator[Path]]:
    def names(path: Path) -> Iterator[Path]:
        for name in dict.fromkeys(pattern.findall(path.read_bytes())):
            yield path.parent / name.decode("utf-8", "surrogateescape").strip()

    return names


WITHIN: Mapping[str, Callable[[Path], Iterator[Path]]] = {
    ".inp": included_files,
    ".xdmf": _named_by(XDMF),
    ".pvd": _named_by(COLLECTION),
    ".geo": _named_by(SCRIPT),
}


def input_digests(case: Case) -> dict[str, str]:
    """SHA-256 of the files of `input_files`, by their full names."""
    found = {}
    for path in input_files(case):
        try:
            stamp = path.stat()
            found[str(path)] = _digest(path, stamp.st_mtime_ns, stamp.st_size, stamp.st_ino)
        except OSError as error:
            found[str(path)] = f"cannot be read: {error.strerror}"
    return found


@lru_cache(maxsize=1000)
def _digest(path: Path, modified: int, size: int, node: int) -> str:
    """The digest of a file; cases of a sweep name the same ones."""
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()
