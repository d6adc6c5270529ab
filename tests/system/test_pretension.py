# SPDX-License-Identifier: LGPL-3.0-or-later
"""A bolt that clamps a plate, against two springs side by side."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fretfe
from fretfe.case import Case, parse_case
from fretfe.errors import CaseError

# The half of a bolt, a gap, and the plate; below the cut, above it, and the head, whose top is
# rigid. In N and mm.
BOLT, GAP, PLATE = 1.0, 0.25, 2.0
LENGTH, CUT, HEAD, YOUNG = 20.0, 8.0, 0.125, 200e3
X = np.arange(0.0, BOLT + GAP + PLATE + 1e-9, 0.125)
Y = np.concatenate([np.linspace(0, LENGTH, 41), [LENGTH + HEAD]])


def write(path: Path) -> None:
    """A structured mesh of the bolt in two parts, its cut at y = CUT, and of the plate under it."""
    nodes: dict[tuple[int, int, str], int] = {}
    cells: dict[str, list[str]] = {"BOLT": [], "PLATE": []}
    sides: dict[str, list[str]] = {}
    count = 0
    for j, (low, high) in enumerate(pairwise(Y)):
        for i, (left, right) in enumerate(pairwise(X)):
            head, in_bolt = low >= LENGTH, right <= BOLT + 1e-9
            if not (head or in_bolt or left >= BOLT + GAP - 1e-9):
                continue
            bolt = head or in_bolt
            part = "PLATE" if not bolt else "UPPER" if low >= CUT else "LOWER"
            count += 1
            around = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            numbers = [nodes.setdefault((*at, part), len(nodes) + 1) for at in around]
            cells["BOLT" if bolt else "PLATE"].append(", ".join(map(str, (count, *numbers))))
            edges = {
                "BASE": (low == 0, 1), "LOWERCUT": (bolt and high == CUT, 3),
                "UPPERCUT": (bolt and low == CUT, 1), "TOP": (head and high == Y[-1], 3),
                "UNDER": (head and left >= BOLT + GAP - 1e-9, 1),
                "PLATETOP": (not bolt and high == LENGTH, 3),
                "MIDDLE": (bolt and left == 0.0, 4),
            }  # fmt: skip
            for name, (there, side) in edges.items():
                own = f"{name}{part}" if name in ("BASE", "MIDDLE") else name
                if there:
                    sides.setdefault(own, []).append(f"{count}, S{side}")
    lines = ["*NODE", *(f"{n}, {X[i]!r}, {Y[j]!r}" for (i, j, _), n in nodes.items())]
    for body, rows in cells.items():
        lines += [f"*ELEMENT, TYPE=CPS4, ELSET={body}", *rows]
    for name, rows in sides.items():
        lines += [f"*SURFACE, NAME={name}", *rows]
    path.write_text("\n".join(lines).replace("np.float64(", "").replace(")", ""))


def clamped(folder: Path, tied: dict[str, str], **tighten: Any) -> Case:
    path = folder / "bolt.inp"
    write(path)
    body = {"young": YOUNG, "poisson": 0.0}
    pull = [{"hold": True, "until": 1.0}, {"ramp": 300.0, "until": 2.0, "steps": 2}]
    return parse_case(
        {
            "model": {"plane": "stress", "thickness": 2.0},
            "geometry": {"file": path.name},
            "bodies": {"bolt": body, "plate": body},
            "ties": {"cut": tied},
            "contacts": {"seat": {"surface1": "UNDER", "surface2": "PLATETOP", "friction": 0.0}},
            "supports": {
                "bolt": {"boundary": "BASELOWER", "fix": ["x", "y"]},
                "plate": {"boundary": "BASEPLATE", "fix": ["x", "y"]},
            },
            "loads": {
                "tighten": {"type": "pretension", "tie": "cut"} | tighten,
                "pull": {"type": "platen", "boundary": "TOP", "direction": "y", "control": "force",
                         "history": pull},
            },
            "output": {"fields": "none"},
        },
        path.with_suffix(".toml"),
    )  # fmt: skip


# Springs: of the bolt with the head over it, of the plate with the head over that, by thickness.
SOFT = (LENGTH + HEAD) / (YOUNG * BOLT), (LENGTH + HEAD) / (YOUNG * PLATE)
SIDES = {"boundary1": "LOWERCUT", "boundary2": "UPPERCUT"}


@pytest.mark.parametrize("turned", [pytest.param(False, marks=pytest.mark.mpi), True])
def test_a_bolt_that_is_shortened_and_then_pulled(tmp_path: Path, turned: bool) -> None:
    """Tension δ/(c_b + c_p); a pull divides itself between bolt and plate as their springs."""
    overlap, thickness = 0.02, 2.0
    tie = {f"boundary{3 - int(key[-1])}": name for key, name in SIDES.items()} if turned else SIDES
    history = [{"ramp": overlap, "until": 1.0, "steps": 1}]
    found = fretfe.run(clamped(tmp_path, tie, control="displacement", history=history))
    if found.root_solution is None:
        return  # on another rank than 0
    tension = thickness * found.solution.forces[:, found.solution.coordinates.index("tighten")]
    plate = found.contacts[0].normal_force * thickness
    expected = thickness * overlap / sum(SOFT)
    assert tension[1] == pytest.approx(expected, rel=0.01)
    assert plate[1] == pytest.approx(tension[1], rel=1e-8)
    share = SOFT[1] / sum(SOFT)
    assert tension[-1] - tension[1] == pytest.approx(share * 300.0, rel=0.01)
    assert plate[1] - plate[-1] == pytest.approx((1 - share) * 300.0, rel=0.01)
    assert max(found.solution.imbalance(kind).max() for kind in ("force", "moment")) < 1e-8


def test_a_bolt_with_a_force_as_history(tmp_path: Path) -> None:
    """The same tension by force and by overlap; the overlap is a result."""
    history = [{"ramp": 400.0, "until": 1.0, "steps": 1}]
    found = fretfe.run(clamped(tmp_path, SIDES, control="force", history=history))
    at = found.solution.coordinates.index("tighten")
    assert found.contacts[0].normal_force[1] * 2.0 == pytest.approx(400.0, rel=1e-8)
    assert found.solution.amplitudes[1, at] == pytest.approx(200.0 * sum(SOFT), rel=0.01)


def test_a_bolt_of_solids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same springs, in a layer of larger cells."""
    monkeypatch.setitem(globals(), "X", X[::2])
    monkeypatch.setitem(globals(), "Y", np.append(Y[:-1:4], Y[-1]))
    history = [{"ramp": 0.02, "until": 1.0, "steps": 1}]
    plane = clamped(tmp_path, SIDES, control="displacement", history=history)
    data = {**plane.as_tables(), "model": {}}
    data["geometry"]["solid"] = {"length": 2.0, "layers": 1}
    for support in data["supports"].values():
        support["fix"] = ["x", "y", "z"]
    found = fretfe.run(parse_case(data, plane.source))
    tension = found.solution.forces[:, found.solution.coordinates.index("tighten")]
    assert tension[1] == pytest.approx(2.0 * 0.02 / sum(SOFT), rel=0.01)
    assert found.contacts[0].normal_force[1] == pytest.approx(tension[1], rel=1e-8)
    assert tension[-1] - tension[1] == pytest.approx(SOFT[1] / sum(SOFT) * 300.0, rel=0.01)


def test_ties_that_are_not_there_and_twice(tmp_path: Path) -> None:
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    with pytest.raises(
        CaseError, match=r"loads.tighten.tie: expected one of the ties 'cut', found"
    ):
        clamped(tmp_path, SIDES, control="force", history=history, **{"tie": "none"})
