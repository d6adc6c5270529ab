# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results that were written are read back as they were; what is none gets a clear message."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from cases.stored_runs import RUNS, edit_numbers, solved, write_run

from fretfe.errors import OutputError
from fretfe.evaluate.refinement import Change, Pass, Refinement, StationValues
from fretfe.history.solution import ContactHistory
from fretfe.history.state_array import StateArray
from fretfe.results.reader import load_result, restored
from fretfe.results.run_folder import KEY
from fretfe.results.writer import as_numbers


@pytest.mark.parametrize("name", RUNS)
def test_what_is_read_is_what_was_written(tmp_path: Path, name: str) -> None:
    folder = write_run(tmp_path, name)
    found = load_result(folder)
    written = json.loads((folder / "results.json").read_text("utf-8"))
    del written[KEY]
    # Everything once more, in the same words: no key is lost, none changes.
    assert as_numbers(found, {}) == written
    result = solved(name)
    assert (found.case.model_dump(), found.backend) == (result.case.model_dump(), result.backend)
    assert (found.directory, result.directory) == (folder, None)
    assert str(found.failure) == str(result.failure)
    for mine, other in zip(found.contacts, result.contacts, strict=True):
        assert isinstance(mine.half_width, np.ndarray)
        np.testing.assert_array_equal(mine.half_width, other.half_width)
        assert mine.stations[1].slip_zones[0].length == other.stations[1].slip_zones[0].length


@pytest.mark.parametrize("name", ["halfplane", "incomplete"])
def test_arrays_are_read(tmp_path: Path, name: str) -> None:
    found = load_result(write_run(tmp_path, name)).solution
    result = solved(name)
    assert found is not None
    np.testing.assert_array_equal(found.driver_values, result.solution.driver_values)
    np.testing.assert_array_equal(found.amplitudes, result.solution.amplitudes)
    (mine,), (other,) = found.contacts, result.solution.contacts
    for each in fields(ContactHistory):
        if isinstance(getattr(other, each.name), np.ndarray | StateArray):
            np.testing.assert_array_equal(getattr(mine, each.name), getattr(other, each.name))
    np.testing.assert_array_equal(mine.full_stick.fields, other.full_stick.fields)
    np.testing.assert_array_equal(mine.full_stick.area, other.full_stick.area)


def test_a_refinement_is_restored() -> None:
    edge = StationValues("main", "left", 1239.0, 35.6, (0.077, 0.076), 0.3, 0.4)
    change = Change("main", "left", "K_N", 0, 1239.0, 0.5)
    refinement = Refinement(0.01, (Pass(6000, 0.01, (edge,), True, (change,)),), False, "enough")
    numbers = as_numbers(replace(solved("halfplane"), refinement=refinement), {})
    assert restored(Refinement, numbers["refinement"]) == refinement


def remove(*keys: str) -> Callable[[dict[str, Any]], object]:
    def edit(numbers: dict[str, Any]) -> None:
        for key in keys[:-1]:
            numbers = numbers[key]
        del numbers[keys[-1]]

    return edit


# What is wrong with a folder, and words that the message must have.
DAMAGE: dict[str, tuple[Callable[[Path], object], list[str]]] = {
    "nothing there": (lambda f: (f / "results.json").unlink(), ["folder", "results.json"]),
    "no JSON": (lambda f: (f / "results.json").write_text("{"), ["results.json", "line 1"]),
    "a list": (lambda f: (f / "results.json").write_text("[]"), ["schema", "None"]),
    "a digit changed": (
        lambda f: change_bytes(f / "results.json", b'"ranks": 1', b'"ranks": 2'),
        ["results.json", "changed"],
    ),
    "a value of the arrays changed": (
        lambda f: change_bytes(f / "results.h5", solved("halfplane").loads.times.tobytes()[-24:]),
        ["results.h5", "damaged values"],
    ),
    "a header of the arrays changed": (
        lambda f: change_bytes(f / "results.h5", header(f / "results.h5")),
        ["results.h5", "checksum"],
    ),
    "other version": (
        lambda f: edit_numbers(f, lambda n: n["schema"].update(version=99)),
        ["schema", "99", "run the case again"],
    ),
    "key missing": (lambda f: edit_numbers(f, remove("contacts", "main", "fronts")), ["'fronts'"]),
    "no cycle key": (lambda f: edit_numbers(f, remove("cycle")), ["'cycle'"]),
    "edge not a table": (
        lambda f: edit_numbers(f, lambda n: n["contacts"]["main"].update(fronts=[1, 2])),
        ["results.json"],
    ),
    "histories of different lengths": (
        lambda f: edit_numbers(f, lambda n: n["loads"]["shear"].pop()),
        ["results.json"],
    ),
    "case that is none": (
        lambda f: edit_numbers(f, lambda n: n["case"].update(bodies={})),
        ["bodies"],
    ),
    "no arrays": (lambda f: (f / "results.h5").unlink(), ["results.h5", "no such file"]),
    "arrays cut off": (
        lambda f: (f / "results.h5").write_bytes((f / "results.h5").read_bytes()[:1000]),
        ["results.h5"],
    ),
    "arrays of another run": (
        lambda f: write_other_arrays(f),
        ["results.h5", "21 states", "different runs"],
    ),
    "arrays of another version": (lambda f: set_version(f, 99), ["results.h5", "99"]),
}


def header(path: Path) -> bytes:
    """The begin of the second of the headers of groups and data sets."""
    return path.read_bytes().split(b"OHDR")[2][:20]


def change_bytes(path: Path, old: bytes, new: bytes | None = None) -> None:
    """Change some bytes of a file, of which the last one if nothing else is said."""
    data = path.read_bytes()
    assert data.count(old) >= 1
    path.write_bytes(data.replace(old, new or old[:-1] + bytes([old[-1] ^ 1])))


def write_other_arrays(folder: Path) -> None:
    other = write_run(folder / "other", "no cycle")
    (folder / "results.h5").write_bytes((other / "results.h5").read_bytes())


def set_version(folder: Path, version: int) -> None:
    with h5py.File(folder / "results.h5", "r+") as arrays:
        arrays.attrs["version"] = version


@pytest.mark.parametrize("damage", DAMAGE)
def test_results_that_are_none_get_a_clear_message(tmp_path: Path, damage: str) -> None:
    folder = write_run(tmp_path, "halfplane")
    change, words = DAMAGE[damage]
    change(folder)
    with pytest.raises(OutputError) as caught:
        load_result(folder)
    assert all(word in str(caught.value) for word in (str(folder), *words)), caught.value
