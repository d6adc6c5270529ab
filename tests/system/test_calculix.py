# SPDX-License-Identifier: LGPL-3.0-or-later
"""A flank that a run of CalculiX drives, against a run of the whole in one piece.

CalculiX has the contact by a penalty, on elements fifty times as large as those of the flank: of
its run only the displacements of the cuts are used.
"""

from __future__ import annotations

import shutil
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fretfe.case import parse_case
from fretfe.evaluate.contacts import Contact
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.loads import build_history
from fretfe.mesh.load import grouped_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh

CCX = shutil.which("ccx")
DEMO = Path(__file__).parents[2] / "demos" / "dovetail.toml"
COARSE = {"edge_size": 0.1, "flank_size": 0.2, "growth": 0.5}
FINE = {"edge_size": 0.002}
CYCLE = {"start": 2.0, "end": 4.0}
# The middle of the left flank, and three half-widths of its contact.
CENTRE, RADIUS = (-10.663, -0.049), 6.5
# Penalty stiffnesses, MPa/mm. With 1e7 for both K_N changes by 0.06 % and ΔK_T by 0.4 %.
NORMAL, TANGENTIAL = 1e7, 3e6
HISTORY = [
    {"ramp": 3900.0, "until": 1.0, "steps": 2},
    {"ramp": 2400.0, "until": 2.0, "steps": 2},
    {"ramp": 3600.0, "until": 3.0, "steps": 2},
    {"ramp": 2400.0, "until": 4.0, "steps": 2},
]


def dovetail(sizes: dict[str, float]) -> dict[str, Any]:
    data: dict[str, Any] = tomllib.loads(DEMO.read_text())
    data["geometry"]["parameters"] |= sizes
    data["loads"]["pull"]["history"] = HISTORY
    data["cycle"] = dict(CYCLE)
    return data


def rows(numbers: Any) -> Iterator[str]:
    """Numbers, eight a line."""
    listed = [str(number) for number in numbers]
    for at in range(0, len(listed), 8):
        yield ", ".join(listed[at : at + 8])


def body_cards(body: BodyMesh, first: int, material: dict[str, float]) -> Iterator[str]:
    """Nodes, elements, surfaces and node sets of a body, numbered from `first`."""
    yield f"*NODE, NSET={body.name}"
    for number, (x, y) in enumerate(body.points.tolist()):
        yield f"{first + number}, {x:.12g}, {y:.12g}, 0."
    yield f"*ELEMENT, TYPE=CPE6, ELSET={body.name}"
    for number, nodes in enumerate((body.cells + first).tolist()):
        yield f"{first + number}, {', '.join(map(str, nodes))}"
    yield f"*MATERIAL, NAME={body.name}"
    yield f"*ELASTIC\n{material['young']}, {material['poisson']}"
    yield f"*SOLID SECTION, ELSET={body.name}, MATERIAL={body.name}\n1."
    sides = np.sort(body.cells[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    places = {tuple(ends): (cell, side) for cell, own in enumerate(sides.tolist())
              for side, ends in enumerate(own)}  # fmt: skip
    for name, facets in body.boundaries.items():
        if "flank" in name:
            yield f"*SURFACE, NAME={name}"
            for ends in np.sort(facets[:, :2], axis=1).tolist():
                cell, side = places[tuple(ends)]
                yield f"{first + cell}, S{side + 1}"
        else:
            yield f"*NSET, NSET={name}"
            yield from rows(np.unique(facets) + first)


def deck(mesh: Mesh, data: dict[str, Any]) -> str:
    """A step of CalculiX for each state of the case."""
    blade, disc = mesh.bodies["blade"], mesh.bodies["disc"]
    second = len(blade.points) + 1
    lines = [*body_cards(blade, 1, data["bodies"]["blade"]),
             *body_cards(disc, second, data["bodies"]["disc"])]  # fmt: skip
    top = np.unique(blade.boundaries["blade_top"]) + 1
    # The platen: one displacement along y.
    for node in top[1:]:
        lines += ["*EQUATION", "2", f"{node}, 2, 1., {top[0]}, 2, -1."]
    lines += ["*SURFACE INTERACTION, NAME=flanks", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
              f"{NORMAL}", "*FRICTION",
              f"{data['contacts']['left']['friction']}, {TANGENTIAL}"]  # fmt: skip
    for side in ("left", "right"):
        lines += ["*CONTACT PAIR, INTERACTION=flanks, TYPE=SURFACE TO SURFACE",
                  f"blade_flank_{side}, disc_flank_{side}"]  # fmt: skip
    lines += ["*BOUNDARY", "blade_top, 1, 1", "disc_bottom, 1, 2", "disc_side_left, 1, 1",
              "disc_side_right, 1, 1"]  # fmt: skip
    history = build_history(parse_case(data))
    for before, time, (pull,) in zip(
        history.times, history.times[1:], history.values[1:], strict=False
    ):
        length = time - before
        lines += ["*STEP, INC=100", "*STATIC", f"{length:.12g}, {length:.12g}", "*CLOAD",
                  f"{top[0]}, 2, {pull:.12g}", "*NODE FILE, OUTPUT=2D, FREQUENCY=1000", "U",
                  "*END STEP"]  # fmt: skip
    return "\n".join(lines) + "\n"


def run_calculix(folder: Path, data: dict[str, Any]) -> Path:
    (folder / "global.inp").write_text(deck(grouped_mesh(parse_case(data)), data))
    assert CCX is not None
    done = subprocess.run([CCX, "global"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:]
    return folder / "global.frd"


def flank(file: Path) -> dict[str, Any]:
    """The case of the part."""
    data = dovetail(FINE)
    times = build_history(parse_case(data)).times[1:].tolist()
    data["geometry"]["part"] = {"centre": list(CENTRE), "radius": RADIUS}
    data["contacts"].pop("right")
    data.pop("supports")
    moved = {"type": "field", "file": str(file), "history": [{"times": times, "values": times}]}
    data["loads"] = {f"{name}_cut": {"boundary": f"{name}_cut", **moved} for name in data["bodies"]}
    return data


def left_flank(data: dict[str, Any]) -> Contact:
    outcome = solve(MPI.COMM_WORLD, parse_case(data))
    assert outcome.failure is None
    return outcome.contacts[0]


@pytest.mark.slow
@pytest.mark.skipif(CCX is None, reason="needs CalculiX: ccx, of Debian's calculix-ccx")
def test_a_run_of_calculix_drives_a_flank(tmp_path: Path) -> None:
    """The 2 % are between programs.

    P is 1.5 % larger than in one piece, in proportion to the deformation: of bodies ten times as
    stiff it is 0.2 %.
    """
    found = left_flank(flank(run_calculix(tmp_path, dovetail(COARSE))))
    expected = left_flank(dovetail(FINE))
    np.testing.assert_allclose(found.normal_force[1:], expected.normal_force[1:], rtol=0.02)
    for own, whole in zip(found.stations, expected.stations, strict=True):
        np.testing.assert_allclose(own.k_n[1:], whole.k_n[1:], rtol=0.02)
        assert own.k_t_range == pytest.approx(whole.k_t_range, rel=0.02)
        zones = [[zone.length for zone in each.slip_zones[-2:]] for each in (own, whole)]
        np.testing.assert_allclose(zones[0], zones[1], rtol=0.02)
