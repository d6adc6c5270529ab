# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dovetail of docs/reference by CalculiX: write the deck, run it, and compare its tractions.

Usage: .venv/bin/python tools/calculix.py FOLDER (about ten minutes; needs ccx, of Debian's
calculix-ccx). Writes docs/reference/calculix.csv.

The mesh is that of fretfe with elements of 0.01 mm at the edges, of second order; the contact is
surface to surface by a penalty, with friction. (CalculiX's mortar contact refuses the equations
that its plane elements make at every node.)
"""

from __future__ import annotations

import json
import runpy
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.loads import build_history
from fretfe.mesh.load import grouped_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh

TABLES = runpy.run_path(str(Path(__file__).with_name("reference_tables.py")))
FOLDER: Path = TABLES["FOLDER"]
CASE, CONTACT = "dovetail_55", "right"
# Penalty stiffnesses, MPa/mm. With 1e7 for both K_N of a flank that a coarse run drives changes by
# 0.06 % and ΔK_T by 0.4 %.
NORMAL, TANGENTIAL = 1e7, 3e6
EDGE_SIZE = 0.01
# To the first extremes of the last cycle of the tables; more cycles change nothing.
HISTORY = [
    {"ramp": 3900.0, "until": 1.0, "steps": 8},
    {"ramp": 3000.0, "until": 1.5, "steps": 2},
    {"ramp": 3600.0, "until": 1.75, "steps": 2},
    {"ramp": 2400.0, "until": 2.25, "steps": 4},
    {"ramp": 3600.0, "until": 2.75, "steps": 4},
]
# Steps counted from the last, by the times of the tables.
EXTREMES = {"3.75": 1, "4.25": 5}
MIDDLE, BESIDE_EDGES = 1.5, (0.1, 0.3)
COLUMNS = ("time", "x", "p", "q")


def rows(numbers: Any) -> Iterator[str]:
    """Numbers, eight a line."""
    listed = [str(number) for number in numbers]
    for at in range(0, len(listed), 8):
        yield ", ".join(listed[at : at + 8])


def body_cards(body: BodyMesh, first: int, material: Mapping[str, float]) -> Iterator[str]:
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


def deck(mesh: Mesh, data: Mapping[str, Any]) -> str:
    """A step of CalculiX for each state of the case of a dovetail."""
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
                  "*CONTACT FILE, FREQUENCY=1000", "CSTR", "*END STEP"]  # fmt: skip
    return "\n".join(lines) + "\n"


def run_calculix(folder: Path, data: Mapping[str, Any]) -> Path:
    """The result file of a dovetail."""
    (folder / "global.inp").write_text(deck(grouped_mesh(parse_case(data)), data))
    ccx = shutil.which("ccx")
    assert ccx is not None
    done = subprocess.run([ccx, "global"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:]
    return folder / "global.frd"


def contact_stresses(file: Path) -> tuple[dict[int, Array], list[dict[int, Array]]]:
    """Places of nodes, and in each step p and both shears at them, of a text result file."""
    places: dict[int, Array] = {}
    steps: list[dict[int, Array]] = []
    block: dict[int, Array] | None = None
    for line in file.read_text(errors="replace").splitlines():
        if line.startswith("    2C"):
            block = places
        elif line.startswith(" -4"):
            block = {} if line.split()[1] == "CONTACT" else None
            steps += [] if block is None else [block]
        elif line.startswith(" -1") and block is not None:
            numbers = [float(line[at : at + 12]) for at in range(13, len(line) - 11, 12)]
            block[int(line[3:13])] = np.array(numbers if block is places else numbers[-3:])
        elif line.startswith(" -3"):
            block = None
    return places, steps


def traction_rows(file: Path) -> Iterator[dict[str, Any]]:
    """Tractions along the right flank at both extremes; x and the sign of q as in the tables."""
    places, steps = contact_stresses(file)
    for time, back in EXTREMES.items():
        own = reference(time)
        points = np.stack([own["point_x"], own["point_y"]], axis=1)
        found = [(places[node][:2], stress) for node, stress in steps[-back].items()
                 if places[node][0] > 0 and stress[0] > 0]  # fmt: skip
        arc = np.array([_along(own["x"], points, place) for place, _ in found])
        stresses = np.array([stress for _, stress in found])
        shear = stresses[:, 1 + int(np.argmax(np.abs(stresses[:, 1:]).sum(axis=0)))]
        shear = shear * np.sign(shear.sum() * own["q"].sum())
        for at in np.argsort(arc):
            yield dict(zip(COLUMNS, (time, arc[at], stresses[at, 0], shear[at]), strict=True))


def _along(x: Array, points: Array, place: Array) -> float:
    """Position along the contact of a place next to it."""
    near = int(np.clip(np.argmin(((points - place) ** 2).sum(axis=1)), 1, len(x) - 2))
    tangent = (points[near + 1] - points[near - 1]) / (x[near + 1] - x[near - 1])
    return float(x[near] + (place - points[near]) @ tangent / (tangent @ tangent))


def table(name: str) -> list[dict[str, str]]:
    """Rows of a file of docs/reference."""
    with (FOLDER / name).open(newline="") as file:
        return list(TABLES["csv"].DictReader(file))


def reference(time: str) -> dict[str, Array]:
    """Columns of the tables at a time."""
    chosen = (CASE, CONTACT, time)
    rows = table("tractions.csv")
    wanted = [each for each in rows if (each["case"], each["contact"], each["time"]) == chosen]
    keys = ("x", "point_x", "point_y", "p", "q")
    return {key: np.array([float(each[key]) for each in wanted]) for key in keys}


def differences() -> Iterator[tuple[str, float]]:
    """What CalculiX's numbers are larger by, as fractions of those of the tables, in words."""
    rows = table("calculix.csv")
    both = {}
    for time in EXTREMES:
        own, other = reference(time), [each for each in rows if each["time"] == time]
        x, p, q = (np.array([float(each[key]) for each in other]) for key in COLUMNS[1:])
        for name, value, right in (("P", p, own["p"]), ("Q", q, own["q"])):
            yield f"{name} at {time}", np.trapezoid(value, x) / np.trapezoid(right, own["x"]) - 1
        places = own["x"]
        both[time] = [(np.interp(places, x, value), own[key]) for key, value in
                      (("p", p), ("q", q))]  # fmt: skip
        middle = np.abs(places) < MIDDLE
        for name, (value, right) in zip("pq", both[time], strict=True):
            ratio = value[middle] / right[middle] - 1
            yield f"{name} at {time}, mean within {MIDDLE} mm", float(ratio.mean())
            yield f"{name} at {time}, largest within {MIDDLE} mm", float(np.abs(ratio).max())
    high, low = both.values()
    for edge in table("edges.csv"):
        if (edge["case"], edge["contact"]) != (CASE, CONTACT):
            continue
        away = np.abs(places - float(edge["position"]))
        near = (away > BESIDE_EDGES[0]) & (away < BESIDE_EDGES[1])
        yield f"p beside the {edge['edge']} edge", _ratio(high[0], near)
        ranges = tuple(a - b for a, b in zip(high[1], low[1], strict=True))
        yield f"range of q beside the {edge['edge']} edge", _ratio(ranges, near)


def _ratio(pair: tuple[Array, Array], chosen: npt.NDArray[np.bool_]) -> float:
    return float(pair[0][chosen].sum() / pair[1][chosen].sum() - 1)


def main() -> None:
    """Run CalculiX and compare."""
    folder = Path(sys.argv[1])
    data = tomllib.loads((FOLDER / f"{CASE}.toml").read_text("utf-8"))
    data["geometry"]["parameters"]["edge_size"] = EDGE_SIZE
    data["loads"]["pull"]["history"] = HISTORY
    folder.mkdir(parents=True, exist_ok=True)
    TABLES["write"](
        FOLDER / "calculix.csv", COLUMNS, list(traction_rows(run_calculix(folder, data)))
    )
    digests = TABLES["digests"](FOLDER)
    (FOLDER / TABLES["DIGESTS"]).write_text(json.dumps(digests, indent=1) + "\n")
    for name, value in differences():
        print(f"{name}: {100 * value:+.2f} %")


if __name__ == "__main__":
    main()
