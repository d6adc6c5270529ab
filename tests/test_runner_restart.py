# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders in which runs are cut off, refused, continued; half-planes, which are quick."""

from __future__ import annotations

import csv
import errno
import fcntl
import json
import os
import shutil
import socket
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from cases.pad_cases import HERTZ, pad, press, shear
from harness.launch import fretfe
from harness.restarts import cut_and_continued, largest_difference
from harness.told import Told

from fretfe import files
from fretfe.case import changed, parse_case
from fretfe.errors import OutputError, StoppedError
from fretfe.halfplane import solve_half_planes
from fretfe.history.stream import StateStream
from fretfe.results.reader import load_result
from fretfe.results.run_folder import locked, unfinished, write_mark
from fretfe.runner import Runner

CASE = parse_case(pad(loads={"press": press(steps=4), "shear": shear(steps=8)}))
RUNNER = Runner.find("halfplane")
FRICTION = "contacts.main.friction"


@pytest.fixture(scope="module", autouse=True)
def few_elements() -> Iterator[None]:
    with patch(
        "fretfe.backends.halfplane.solve_half_planes", partial(solve_half_planes, elements=60)
    ):
        yield


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("undisturbed")
    RUNNER.run(CASE, folder)
    return folder


@pytest.mark.parametrize("steps", [1, 4, 7, 13])
def test_a_continued_run_is_the_undisturbed_one(
    tmp_path: Path, undisturbed: Path, steps: int
) -> None:
    cut_and_continued(CASE, "halfplane", tmp_path, steps)
    # The same in all digits: the factorisation goes on as it was.
    assert largest_difference(undisturbed, tmp_path) < 1e-12
    mark = json.loads((tmp_path / "run.json").read_text())
    assert mark["complete"] and mark["doing"] == "finished"
    assert sorted(each.name for each in tmp_path.iterdir()) == sorted(
        each.name for each in undisturbed.iterdir()
    )


def test_a_complete_run_is_not_run_again(undisturbed: Path) -> None:
    told = Told()
    result = RUNNER.run(CASE, undisturbed, told, resume=True)
    assert not told.steps
    assert result.failure is None and result.directory == undisturbed


def test_another_case_is_not_continued(tmp_path: Path) -> None:
    RUNNER.run(CASE, tmp_path, Told(5))
    with pytest.raises(OutputError, match=r"another one: contacts.main.friction was 0.4, is 0.5"):
        RUNNER.run(changed(CASE, {FRICTION: 0.5}), tmp_path, resume=True)
    with pytest.raises(OutputError, match="backend was halfplane, is fem"):
        replace(RUNNER, name="fem").run(CASE, tmp_path, resume=True)
    # A title, or what is kept, makes no difference.
    assert RUNNER.run(changed(CASE, {"title": "other"}), tmp_path, resume=True).failure is None


@pytest.fixture(scope="module")
def cut_off(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that was stopped after step 13, with a checkpoint there and one at step 10."""
    folder = tmp_path_factory.mktemp("cut_off")
    with (
        patch("fretfe.contact.solve.NOTE_STEPS", 10),
        patch("fretfe.contact.solve.LEAST_SECONDS", 0.0),
        patch("fretfe.contact.solve.SPARING", 0.0),
    ):
        RUNNER.run(CASE, folder, Told(13))
    return folder


@pytest.mark.parametrize(
    ("name", "place", "size", "first"),
    [
        ("states.rows", 0.3, 1, 1),
        ("states.rows", 0.7, 1, 11),
        ("states.rows", 0.7, 0, 11),
        ("states.rows", -1.0, 0, 1),
        ("checkpoint.npz", 0.5, 1, 11),
        ("checkpoint.npz", -1.0, 0, 11),
        ("checkpoint-before.npz", 0.5, 1, 14),
    ],
)
def test_damaged_states_are_solved_again(
    tmp_path: Path, cut_off: Path, undisturbed: Path, name: str, place: float, size: int, first: int
) -> None:
    """One byte is another one, or the rest of the file is zeros; or the file is empty."""
    shutil.copytree(cut_off, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "states" / name
    data = path.read_bytes()
    begin = round(max(place, 0.0) * len(data))
    lost = [bytes(len(data) - begin), bytes([data[begin] ^ 16]) + data[begin + 1 :]][size]
    path.write_bytes(b"" if place < 0 else data[:begin] + lost)
    told = Told()
    RUNNER.run(CASE, tmp_path, told, resume=True)
    assert told.steps[0][0] == first
    assert largest_difference(undisturbed, tmp_path) < 1e-12
    said = "" if first == 14 else " ".join(told.announced)
    assert (f"{path} has " in said) == (first < 14)


def test_states_are_on_the_disk_before_what_names_them(tmp_path: Path) -> None:
    done: list[str] = []
    fsync, pwrite, replace = os.fsync, os.pwrite, Path.replace

    def name_of(descriptor: int) -> str:
        return Path(os.readlink(f"/proc/self/fd/{descriptor}")).name

    def synced(descriptor: int) -> None:
        fsync(descriptor)
        done.append(f"synced {name_of(descriptor)}")

    def written(descriptor: int, *rest: Any) -> int:
        done.append(f"wrote {name_of(descriptor)}")
        return pwrite(descriptor, *rest)

    def replaced(path: Path, target: Path) -> Path:
        # Nobody can guess the names of new files: they are called after what they replace here.
        done[:] = [each.replace(path.name, f"{target.name}.new") for each in done]
        done.append(f"replaced {target.name}")
        return replace(path, target)

    with (
        patch.object(os, "fsync", synced),
        patch.object(os, "pwrite", written),
        patch.object(Path, "replace", replaced),
    ):
        RUNNER.run(CASE, tmp_path)
    noted = done.index("replaced checkpoint.npz")
    assert done[:noted][-2:] == ["synced states.rows", "synced checkpoint.npz.new"]
    assert done[noted + 1] == "synced states"
    finished = len(done) - done[::-1].index("replaced run.json")
    before = done[:finished]
    for name in ("results.json", "results.h5"):
        assert before.index(f"synced {name}.new") < before.index(f"replaced {name}")


@pytest.mark.parametrize("key", ["step", "complete", "versions", "case", "schema"])
def test_a_changed_note_of_a_run_is_not_trusted(tmp_path: Path, cut_off: Path, key: str) -> None:
    shutil.copytree(cut_off, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "run.json"
    text = path.read_text()
    path.write_text(text.replace(f'"{key}"', f'"{key[:-1]}_"', 1))
    with pytest.raises(OutputError, match=r"run\.json: expected .*, found"):
        RUNNER.run(CASE, tmp_path, resume=True)


def test_a_continued_run_has_the_case_that_it_solves(tmp_path: Path, cut_off: Path) -> None:
    shutil.copytree(cut_off, tmp_path, dirs_exist_ok=True)
    copy = tmp_path / "case.toml"
    before = copy.read_text()
    copy.write_text(before.replace("0.4", "0.7"))
    RUNNER.run(CASE, tmp_path, resume=True)
    assert copy.read_text() == before


def test_what_a_killed_run_leaves_is_no_result(
    tmp_path: Path,
) -> None:
    RUNNER.run(CASE, tmp_path)

    class Killed(BaseException):
        """Ends a run as nothing that it catches does."""

    class Killing(Told):
        def step(self, number: int, count: int, text: str) -> None:
            if number == 9:
                raise Killed

    with pytest.raises(Killed):
        RUNNER.run(changed(CASE, {FRICTION: 0.5}), tmp_path, Killing())
    assert not (tmp_path / "results.json").exists()
    mark = json.loads((tmp_path / "run.json").read_text())
    assert (mark["complete"], mark["steps"], mark["case"]["contacts"]["main"]["friction"]) == (
        False,
        20,
        0.5,
    )
    done = fretfe("report", tmp_path)
    assert done.returncode == 6, done.stderr
    assert "was ended from outside" in done.stderr and "--resume" in done.stderr
    with pytest.raises(OutputError, match="ended from outside while solving"):
        load_result(tmp_path)


def test_a_second_run_is_refused(tmp_path: Path) -> None:
    with locked(tmp_path):
        who = f"process {os.getpid()} on host {socket.gethostname()}"
        with pytest.raises(OutputError, match=f"{who} at work in it"):
            RUNNER.run(CASE, tmp_path)
    assert RUNNER.run(CASE, tmp_path).failure is None
    assert not (tmp_path / "run.lock").exists()


def test_the_lock_of_a_dead_process_is_taken_over(tmp_path: Path) -> None:
    lock = {"process": 4_000_000, "host": socket.gethostname()}
    (tmp_path / "run.lock").write_text(json.dumps(lock))
    told = Told()
    RUNNER.run(CASE, tmp_path, told)
    assert "process 4000000, which has ended" in told.announced[0]


def test_the_lock_of_another_host_is_left(tmp_path: Path) -> None:
    (tmp_path / "run.lock").write_text(json.dumps({"process": 7, "host": "elsewhere"}))
    with pytest.raises(OutputError, match=r"process 7 on host elsewhere .* remove .*run.lock"):
        RUNNER.run(CASE, tmp_path)


def test_without_locks_processes_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: Any) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr(fcntl, "flock", none)
    lock = {"process": os.getppid(), "host": socket.gethostname()}
    (tmp_path / "run.lock").write_text(json.dumps(lock))
    with pytest.raises(OutputError, match=f"process {os.getppid()} on host"):
        RUNNER.run(CASE, tmp_path)


def test_a_sweep_goes_on_after_what_is_solved(tmp_path: Path) -> None:
    vary = {FRICTION: [0.3, 0.4, 0.5]}
    first = RUNNER.sweep(CASE, vary, tmp_path, Told(27))
    assert isinstance(first.stopped, StoppedError)
    assert [bool(each.failure) for each in first.variants] == [False, True, True]
    told = Told()
    sweep = RUNNER.sweep(CASE, vary, tmp_path, told, resume=True)
    # The first case is known, the second goes on after its seventh step.
    assert told.steps[0][0] == 8
    assert not sweep.failures and sweep.stopped is None
    with (tmp_path / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row[FRICTION] for row in rows] == ["0.3", "0.3", "0.4", "0.4", "0.5", "0.5"]
    single = RUNNER.run(changed(CASE, {FRICTION: 0.4}))
    for edge, row in zip(single.edges(), rows[2:4], strict=True):
        assert float(row["k_n"]) == pytest.approx(edge["k_n"], rel=1e-12)


def test_a_solved_case_that_was_changed_is_solved_again(tmp_path: Path) -> None:
    vary = {FRICTION: [0.3, 0.4]}
    before = RUNNER.sweep(CASE, vary, tmp_path)
    path = tmp_path / "variants.jsonl"
    first, second = path.read_bytes().splitlines()
    place = second.index(b'"k_n": ') + 8
    changed_line = second[:place] + bytes([second[place] ^ 1]) + second[place + 1 :]
    path.write_bytes(first + b"\n" + changed_line + b"\n\xff\n")
    mark = json.loads((tmp_path / "run.json").read_text())
    del mark["digest"]
    write_mark(tmp_path, {**mark, "complete": False})
    told = Told()
    after = RUNNER.sweep(CASE, vary, tmp_path, told, resume=True)
    # The first case is known.
    assert len(told.steps) == 20
    pairs = zip(before.records(), after.records(), strict=True)
    assert all(one["k_n"] == other["k_n"] for one, other in pairs)


def test_the_table_of_a_sweep_grows(tmp_path: Path) -> None:
    lines: list[int] = []

    class Counting(Told):
        def announce(self, text: str) -> None:
            lines.append(len((tmp_path / "sweep.csv").read_text().splitlines()))

    RUNNER.sweep(CASE, {FRICTION: [0.05, 0.3, 0.4]}, tmp_path, Counting())
    # A header and two rows for each case.
    assert lines == [3, 5, 7]


def test_a_validation_goes_on(tmp_path: Path) -> None:
    with pytest.raises(StoppedError):
        RUNNER.validate(CASE, tmp_path, Told(25))
    assert json.loads((tmp_path / "results.json").read_text())["complete"] is True
    with pytest.raises(OutputError, match="failed: stopped by SIGINT"):
        load_result(tmp_path)
    told = Told()
    found = RUNNER.validate(CASE, tmp_path, told, resume=True)
    assert told.steps[0][0] == 6
    assert len(found.rows) == len(RUNNER.validate(CASE).rows)
    assert load_result(tmp_path).failure is None


@pytest.mark.parametrize("place", ["states", "results.json", "results.h5", "sweep.csv"])
def test_a_full_disk_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    """The device /dev/full takes nothing, as a full disk."""
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")
    (tmp_path / "case.toml").write_text(HERTZ)
    words = ["run", "case.toml", "-o", "out", "--no-report"]
    if place == "sweep.csv":
        words = ["sweep", "case.toml", "-o", "out", "--vary", f"{FRICTION}=0.3,0.4"]
    if place == "states":
        opened = os.open("/dev/full", os.O_RDWR)
        monkeypatch.setattr(StateStream, "_open", lambda _: opened)
        monkeypatch.setattr(os, "ftruncate", lambda *_: None)
    else:
        make = files._new_file

        def new_file(path: Path, ending: str = "") -> Path:
            new = make(path, ending)
            if path.name == place:
                new.unlink()
                new.symlink_to("/dev/full")
            return new

        monkeypatch.setattr(files, "_new_file", new_file)
        followed = partial(os.open, mode=0o666)
        monkeypatch.setattr("fretfe.results.hdf5_file.open_own", followed)
    monkeypatch.chdir(tmp_path)
    done = fretfe(*words, "--backend", "halfplane")
    assert done.returncode == 6, done.stderr
    assert "Traceback" not in done.stderr
    assert "the disk is full" in done.stderr


def test_a_quota_that_is_used_up_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.EDQUOT, "")

    monkeypatch.setattr(os, "pwrite", full)
    with pytest.raises(OutputError, match="the disk quota is used up"):
        RUNNER.run(CASE, tmp_path)
    monkeypatch.undo()
    assert unfinished(tmp_path)
