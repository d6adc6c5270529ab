# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs that are cut off and damaged before they are continued.

`cd tests; python -m harness.damage 200` damages one file of a folder in each of 200 tries and
prints a table of what became of them; `... 200 run sweep` those of these kinds only. A continued
run has the numbers of an undisturbed one, or ends with a message.
"""

from __future__ import annotations

import csv
import random
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

from cases.pad_cases import pad, press, shear
from harness.restarts import largest_difference
from harness.told import Told

from fretfe.case import Case, load_case, parse_case
from fretfe.errors import FretfeError, StoppedError
from fretfe.halfplane import solve_half_planes
from fretfe.runner import Runner

SEED = 27
PAD = {
    "template": "cylinder",
    "parameters": {"upper_radius": 50, "upper_width": 12, "lower_radius": 0, "lower_width": 12},
}
DOVETAIL = Path(__file__).parents[2] / "demos" / "dovetail.toml"
COARSE = {"geometry.parameters.edge_size": 0.1, "loads.pull.history.3.cycles": 1}
VARY = {"contacts.main.friction": [0.3, 0.4, 0.5]}
# Differences of continued runs on the same number of processes.
SAME = 1e-12
# Files that nobody reads again.
LEFT = ("run.lock",)


class Killed(BaseException):
    """Ends a run as nothing that it catches does."""


class Killing(Told):
    """Ends a run without a word to anybody after a number of steps."""

    def step(self, number: int, count: int, text: str) -> None:
        super().step(number, count, text)
        if len(self.steps) == self._most_steps:
            raise Killed


def _pad_case() -> Case:
    return parse_case(pad(loads={"press": press(steps=4), "shear": shear(steps=8)}))


def _refined_case() -> Case:
    history = {"press": press(steps=3), "shear": shear(20.0, steps=8)}
    return parse_case(pad(geometry=PAD, edges={"tolerance": 0.05}, loads=history))


@dataclass(frozen=True)
class Kind:
    """A command on a case.

    Attributes:
        backend: its name.
        case: gives the case.
        work: command, of a runner.
        steps: after which it is cut off.
    """

    backend: str
    case: Callable[[], Case]
    work: Callable[..., Any]
    steps: tuple[int, ...]

    def run(self, folder: Path, told: Told, *, resume: bool = False) -> None:
        """Run it, or go on with it.

        Raises:
            FretfeError: whatever the command would end with.
        """
        found = self.work(Runner.find(self.backend), self.case(), folder, told, resume=resume)
        failure = getattr(found, "failure", None) or getattr(found, "stopped", None)
        if failure is not None:
            raise failure


def _sweep(runner: Runner, case: Case, folder: Path, told: Told, *, resume: bool) -> Any:
    return runner.sweep(case, VARY, folder, told, resume=resume)


KINDS = {
    "run": Kind("halfplane", _pad_case, Runner.run, (3, 13, 19)),
    "sweep": Kind("halfplane", _pad_case, _sweep, (13, 27, 55)),
    "validate": Kind("halfplane", _pad_case, Runner.validate, (13, 25, 50)),
    "fem": Kind("fem", partial(load_case, DOVETAIL, COARSE), Runner.run, (7, 33)),
    "refined": Kind("fem", _refined_case, Runner.run, (17, 36, 50)),
}


def cut_off(kind: Kind, folder: Path, steps: int, *, killed: bool) -> None:
    """Leave the folder of a run that was stopped or killed after some steps."""
    try:
        kind.run(folder, (Killing if killed else Told)(steps))
    except (Killed, StoppedError):
        return
    raise AssertionError(f"expected a run with more than {steps} steps")


def damaged(folder: Path, chance: random.Random) -> str:
    """Damage a file of a folder; say which, and how."""
    files = [each for each in sorted(folder.rglob("*")) if each.is_file() and each.name not in LEFT]
    path = chance.choice([each for each in files if each.stat().st_size])
    data = bytearray(path.read_bytes())
    place = chance.randrange(len(data))
    how = chance.choice(("byte", "byte", "byte", "sector", "zeros behind", "cut"))
    if how == "byte":
        data[place] ^= chance.randrange(1, 256)
    elif how == "sector":
        data[place : place + 512] = chance.randbytes(len(data[place : place + 512]))
    elif how == "zeros behind":
        data[place:] = bytes(len(data) - place)
    else:
        del data[place:]
    path.write_bytes(data)
    return f"{path.relative_to(folder)}: {how} {place}"


def outcome(kind: Kind, folder: Path, undisturbed: Path) -> tuple[str, str]:
    """Go on with a run; say in a word what became of it, and the reason or difference."""
    try:
        kind.run(folder, Told(), resume=True)
    except FretfeError as error:
        return "refused", str(error)
    except BaseException:  # whatever it is, it is what is looked for
        return "TRACEBACK", traceback.format_exc()
    found = different(folder, undisturbed)
    return ("OTHER NUMBERS", found) if found else ("same", "")


def different(folder: Path, undisturbed: Path) -> str:
    """Say which files of two folders are not the same; empty if all are."""
    for name in ("case.toml", "validation.json", "sweep.csv"):
        one, other = (_lines(each / name) for each in (folder, undisturbed))
        if one != other:
            return name
    if not (undisturbed / "results.json").exists():
        return ""
    try:
        found = largest_difference(undisturbed, folder)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return f"difference {found:.1e}" if found > SAME else ""


def _lines(path: Path) -> list[Any]:
    """A file line by line, a table without wall times; empty if there is none."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        if path.suffix == ".csv":
            return [{**row, "seconds": ""} for row in csv.DictReader(file)]
        return list(file)


def tries(name: str, count: int, place: Path) -> Counter[tuple[str, str, str]]:
    """Damage folders of one kind; count kinds, files and outcomes."""
    kind, found = KINDS[name], Counter[tuple[str, str, str]]()
    kind.run(place / "undisturbed", Told())
    folders = []
    for steps in kind.steps:
        for killed in (False, True):
            folders.append(place / f"cut-{steps}-{killed}")
            cut_off(kind, folders[-1], steps, killed=killed)
    for number in range(count):
        chance = random.Random(f"{SEED} {name} {number}")
        folder = place / "try"
        shutil.copytree(chance.choice(folders), folder)
        where = damaged(folder, chance)
        word, text = outcome(kind, folder, place / "undisturbed")
        file = where.split(": ")[0].rsplit("/", 1)[-1]
        found[name, file, word] += 1
        print(f"{name} {number + 1}: {where}: {word} {text}", flush=True)
        shutil.rmtree(folder)
    return found


def main(count: int, kinds: list[str]) -> None:
    """Damage folders and print what became of them."""
    found: Counter[tuple[str, str, str]] = Counter()
    few = partial(solve_half_planes, elements=60)
    with (
        tempfile.TemporaryDirectory() as folder,
        patch("fretfe.backends.halfplane.solve_half_planes", few),
        # Checkpoints in histories of a few steps, too.
        patch("fretfe.contact.solve.NOTE_STEPS", 5),
        patch("fretfe.contact.solve.LEAST_SECONDS", 0.0),
        patch("fretfe.contact.solve.SPARING", 0.0),
    ):
        for number, name in enumerate(kinds):
            own = len(range(number, count, len(kinds)))
            found += tries(name, own, Path(folder) / name)
    for (name, file, word), times in sorted(found.items()):
        print(f"{name:10} {file:24} {word:14} {times}")
    print(dict(Counter(word for *_, word in found.elements())))


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:] or list(KINDS))
