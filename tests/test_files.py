# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files are written nowhere but where they are meant to be."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

import fretfe
from fretfe.files import open_own, remove_unfinished, replace_text, replacing, stranger_in

SOURCES = Path(fretfe.__file__).parent
# What writes to a file by its name does it to the new one of `replacing`, to one that `open_own`
# opens, or in a folder that nobody else knows.
WRITES = re.compile(
    r"""\.(write_text|write_bytes|savefig|touch|save|savez)\(|\bopen\(.*["'][wax]b?\+?["']"""
)
SAFE = re.compile(r"\((new|buffer)\b|\bnew\.|opener=")
FREE = {
    "mesh/contained.py": 6,  # a folder of tempfile
    "history/stream.py": 1,  # to memory
}


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    path = tmp_path / "outside"
    path.write_text("of somebody else")
    return path


def test_a_new_file_is_beside_the_old_one_and_cannot_be_guessed(
    tmp_path: Path, outside: Path
) -> None:
    target = tmp_path / "report.html"
    target.symlink_to(outside)
    names = set()
    for number in range(3):
        with replacing(target, ".png") as new:
            assert new.parent == tmp_path and new.suffix == ".png" and not new.is_symlink()
            names.add(new.name)
            new.write_text(str(number))
    assert len(names) == 3
    # The link is replaced, not what it leads to.
    assert target.read_text() == "2" and not target.is_symlink()
    assert outside.read_text() == "of somebody else"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["outside", "report.html"]


def test_a_new_file_has_the_rights_of_any_other(tmp_path: Path) -> None:
    replace_text(tmp_path / "new", "")
    (tmp_path / "other").touch()
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "other").stat().st_mode


def test_what_a_killed_process_left_is_removed(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), replacing(tmp_path / "a"):
        raise KeyboardInterrupt
    assert not list(tmp_path.iterdir())
    (tmp_path / ".fretfe-new-0123456789abcdef.png").touch()
    (tmp_path / "mine").touch()
    remove_unfinished(tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == ["mine"]


def link(path: Path, outside: Path) -> None:
    path.symlink_to(outside)


def second_name(path: Path, outside: Path) -> None:
    path.hardlink_to(outside)


def pipe(path: Path, _: Path) -> None:
    os.mkfifo(path)


@pytest.mark.parametrize(
    ("make", "number"),
    [(link, errno.ELOOP), (second_name, errno.EMLINK), (pipe, errno.ENXIO)],
    ids=["link", "hard link", "pipe"],
)
def test_only_a_file_of_its_own_is_changed_in_place(
    tmp_path: Path, outside: Path, make: Callable[[Path, Path], None], number: int
) -> None:
    path = tmp_path / "run.lock"
    make(path, outside)
    with pytest.raises(OSError) as raised:
        open_own(path, os.O_RDWR | os.O_TRUNC)
    assert raised.value.errno == number
    assert outside.read_text() == "of somebody else"


def test_a_file_of_its_own_is_opened(tmp_path: Path) -> None:
    path = tmp_path / "rows"
    with open(path, "a", opener=open_own) as file:
        file.write("a")
    with open(path, "a", opener=open_own) as file:
        file.write("b")
    assert path.read_text() == "ab"
    with open(path, "w", opener=open_own) as file:
        file.write("c")
    assert path.read_text() == "c"


def test_strangers_in_a_folder(tmp_path: Path, outside: Path) -> None:
    folder = tmp_path / "states"
    assert stranger_in(folder) is None
    (folder / "variant-1").mkdir(parents=True)
    (folder / "variant-1" / "states.rows").touch()
    assert stranger_in(folder) is None
    (folder / "variant-1" / "checkpoint.npz").symlink_to(outside)
    assert stranger_in(folder) == folder / "variant-1" / "checkpoint.npz"
    (tmp_path / "linked").symlink_to(folder)
    assert stranger_in(tmp_path / "linked") == tmp_path / "linked"


def test_nothing_else_writes_to_files_by_their_names() -> None:
    found: dict[str, int] = {}
    for path in SOURCES.rglob("*.py"):
        lines = path.read_text("utf-8").splitlines()
        count = sum(1 for line in lines if WRITES.search(line) and not SAFE.search(line))
        if count and path.name != "files.py":
            found[path.relative_to(SOURCES).as_posix()] = count
    assert found == FREE
