# SPDX-License-Identifier: LGPL-3.0-or-later
"""`python -m faults.worker GOOD DESCRIPTOR`: reads inputs for `judge`, in this process."""

from __future__ import annotations

import json
import math
import os
import sys
import warnings
from pathlib import Path
from typing import Any, TextIO
from unittest.mock import patch

import numpy as np
from faults.derived import wrong_numbers
from faults.every import all_faults
from faults.fault import Fault
from harness.launch import fretfe
from harness.mesh_server import mesh_server

# Exit codes that are documented, but for that of a bug; that of Typer is among them.
DOCUMENTED = (2, 3, 4, 5, 6, 7, 8)
# Part of the largest force of a load that a contact may miss.
EQUILIBRIUM = 1e-4
OUTPUTS = {"out", "run", "report.html", "m.msh", "m.png"}


def main(good: Path, answers: TextIO) -> None:
    """Judge the inputs whose numbers and folders come from the standard input."""
    faults = all_faults()
    import fretfe.api
    import fretfe.fem.run  # noqa: F401
    from fretfe.mesh import contained

    with mesh_server() as processes, patch.object(contained, "subprocess", processes):
        for line in sys.stdin:
            number, _, folder = line.strip().partition(" ")
            here = Path(folder)
            faults[int(number)].prepare(good, here)
            os.chdir(here)
            print("prepared", file=answers, flush=True)
            print(json.dumps(judged(faults[int(number)], here)), file=answers, flush=True)
            os.chdir("/")


def judged(fault: Fault, here: Path) -> tuple[str, str]:
    """Kind of verdict, and a text."""
    before = _names(here)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            done = fretfe(*fault.command)
        except BaseException as error:
            return "traceback", f"{type(error).__name__}: {error}"
    message = done.stderr.strip()
    if "Traceback (most recent call last)" in message + done.stdout or done.returncode == 1:
        return "traceback", message[-900:]
    if escaped := _names(here) - before:
        return "escaped", f"files that are no output: {sorted(escaped)}"
    found = [each for each in caught if issubclass(each.category, RuntimeWarning)]
    # Of results that were changed nothing is computed anew; the command keeps them from the user.
    if found and fault.command[0] != "report":
        return "warning", f"{found[0].filename}:{found[0].lineno}: {found[0].message}"
    if done.returncode in DOCUMENTED and fault.refused is False:
        return "nonsense", f"refused: {message}"
    if done.returncode in DOCUMENTED:
        return ("refused", message) if message else ("nonsense", "no message")
    if done.returncode != 0:
        return "nonsense", f"exit code {done.returncode}: {message}"
    if fault.refused:
        return "nonsense", f"accepted: {done.stdout[-500:]}"
    wrong = _wrong_numbers(here) or _wrong_page(here) or wrong_numbers(here, done.stdout)
    return ("nonsense", wrong) if wrong else ("accepted", done.stdout[-200:])


def _names(here: Path) -> set[str]:
    """What is in the folder and the one above, but for outputs and other inputs."""
    beside = {f"../{each.name}" for each in here.parent.iterdir() if not each.name.isdecimal()}
    return beside | {each.name for each in here.iterdir() if each.name not in OUTPUTS}


def _wrong_numbers(here: Path) -> str:
    """What is wrong with the numbers of a run that succeeded."""
    path = here / "out" / "results.json"
    if not path.exists():
        return ""

    def refuse(text: str) -> float:
        raise ValueError(text)

    numbers = json.loads(path.read_text(), parse_constant=refuse)
    if not numbers["complete"]:
        return "" if numbers["failure"] else "incomplete, and no word about it"
    press = _platen_force(numbers)
    if press is None:
        return ""
    for name, contact in numbers["contacts"].items():
        force = contact.get("normal_force")
        if force is None or any(each is None for each in force):
            return "" if contact["warnings"] else f"{name}: forces that are not known, unsaid"
        missed = np.abs(np.array(force) - press).max()
        if not missed <= EQUILIBRIUM * np.abs(press).max() and not contact["warnings"]:
            return f"{name}: the force misses that of the platen by {missed:g}"
    return ""


def _platen_force(numbers: dict[str, Any]) -> np.ndarray | None:
    """What presses, where that is one load in y and no other has a part in it."""
    case = numbers["case"]
    loads = {name: load for name, load in case["loads"].items() if load.get("direction") == "y"}
    others = [load for name, load in case["loads"].items() if name not in loads]
    if len(loads) != 1 or len(numbers["contacts"]) != 1:
        return None
    if any(load.get("direction") != "x" or load["type"] != "platen" for load in others):
        return None
    ((name, load),) = loads.items()
    if load["type"] != "platen" or load["control"] != "force":
        return None
    thickness = case.get("model", {}).get("thickness", 1.0)
    force = -np.array(numbers["loads"][name]) / thickness
    return force if force.max() > 0 and math.isfinite(force.max()) else None


def _wrong_page(here: Path) -> str:
    page = here / "run" / "report.html"
    if page.exists() and "<script>document" in page.read_text(errors="replace"):
        return "a script of the results is in the page"
    return ""


if __name__ == "__main__":
    # What libraries print in C does not mix with the answers.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with os.fdopen(int(sys.argv[2]), "w") as stream:
        main(Path(sys.argv[1]), stream)
