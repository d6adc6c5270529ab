# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write docs/reference: numbers and tractions of joints, for codes that have no K to compare with.

Run from anywhere: .venv/bin/python tools/reference_tables.py (some minutes).
"""

from __future__ import annotations

import csv
import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import chain
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import fretfe
from fretfe.case import Case, case_text, changed, parse_case
from fretfe.case.toml_file import read_tables
from fretfe.evaluate.resultants import load_extremes
from fretfe.mesh.templates import find_template

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "reference"
DIGESTS = "digests.json"
ANGLES = (50, 55, 60)
NUMBERS = ("k_n", "k_t_range", "slip_1", "slip_2")
BARRED = tuple(f"{name}{end}" for name in NUMBERS for end in ("", "_spread"))
EDGE = ("position", "half_width", *BARRED)
# Numbers of a mesh with elements of twice the size at the edges stand beside those of the mesh.
EDGES = ("case", "contact", "edge", *EDGE, *(f"{name}_coarse" for name in BARRED))
TRACTIONS = ("case", "contact", "time", "x", "point_x", "point_y", "p", "q")
DIGITS = 6
# Of the meshes that the tables were made with, beside the parameters of the demos.
GROWTH = 0.2


def cases() -> Iterator[tuple[str, Case]]:
    """Names of the files and cases, with all parameters of the geometry written out."""
    demos = ROOT / "demos"
    for angle in ANGLES:
        case = fretfe.load_case(demos / "dovetail.toml")
        title = f"Dovetail with flanks at {angle} degrees"
        keys = {"title": title, "geometry.parameters.flank_angle": float(angle)}
        yield f"dovetail_{angle}", _complete(changed(case, keys))
    tables = read_tables(demos / "firtree.toml", "a case file (TOML)")
    tables["title"] = "Firtree with two pairs of lobes"
    tables["geometry"]["parameters"]["lobes"] = 2
    tables["contacts"] = {k: v for k, v in tables["contacts"].items() if not k.endswith("3")}
    # Two thirds of the pull of three pairs.
    wave = {"wave": "sine", "mean": 2700.0, "amplitude": 650.0, "period": 1.0, "cycles": 2}
    first = [{"ramp": 3400.0, "until": 1.0, "steps": 8}, {"ramp": 2700.0, "until": 1.5, "steps": 4}]
    tables["loads"]["pull"]["history"] = [*first, {**wave, "steps_per_cycle": 16}]
    yield "firtree_2", _complete(parse_case(tables))


def _complete(case: Case) -> Case:
    assert case.geometry.template is not None
    known = find_template(case.geometry.template).parameters
    defaults = {each.name: each.default for each in known} | {"growth": GROWTH}
    values = defaults | dict(case.geometry.parameters)
    return changed(case, {f"geometry.parameters.{name}": value for name, value in values.items()})


def edge_rows(name: str, fine: fretfe.Result, coarse: fretfe.Result) -> Iterator[dict[str, Any]]:
    """A row for each edge."""
    for record, other in zip(fine.records(), coarse.records(), strict=True):
        own = {key: record[key] for key in ("contact", "edge", *EDGE)}
        yield {"case": name, **own, **{f"{key}_coarse": other[key] for key in BARRED}}


def traction_rows(name: str, result: fretfe.Result) -> Iterator[dict[str, Any]]:
    """A row for each node of the right contacts at the load extremes; the left ones mirror them."""
    for history, contact in zip(result.solution.contacts, result.contacts, strict=True):
        if "right" not in history.name:
            continue
        for state in load_extremes([contact], result.solution.cycle):
            surface, time = history.surface, result.loads.times[state]
            places = zip(surface.arc, *surface.points.T[:2], *history.mean_traction[state].T,
                         strict=True)  # fmt: skip
            for values in places:
                yield dict(zip(TRACTIONS, (name, history.name, time, *values), strict=True))


def write(path: Path, columns: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> None:
    """Write a table with numbers of six digits."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow(
                {k: v if isinstance(v, str) else f"{v:.{DIGITS}g}" for k, v in row.items()}
            )


def digests(folder: Path) -> dict[str, str]:
    """SHA-256 of all files but their list."""
    files = sorted(each for each in folder.iterdir() if each.name != DIGESTS)
    return {each.name: hashlib.sha256(each.read_bytes()).hexdigest() for each in files}


def solve(name: str) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Rows of both tables of a case, from two meshes."""
    case = dict(cases())[name]
    (FOLDER / f"{name}.toml").write_text(case_text(case))
    size = case.geometry.parameters["edge_size"]
    coarse = fretfe.run(changed(case, {"geometry.parameters.edge_size": 2 * size}))
    fine = fretfe.run(case)
    return list(edge_rows(name, fine, coarse)), list(traction_rows(name, fine))


def main() -> None:
    """Solve all cases, one on each core."""
    FOLDER.mkdir(exist_ok=True)
    with ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool:
        found = list(pool.map(solve, [name for name, _ in cases()]))
    for path, columns, rows in zip(
        ("edges.csv", "tractions.csv"), (EDGES, TRACTIONS), zip(*found, strict=True), strict=True
    ):
        write(FOLDER / path, columns, list(chain.from_iterable(rows)))
    (FOLDER / DIGESTS).write_text(json.dumps(digests(FOLDER), indent=1) + "\n")


if __name__ == "__main__":
    main()
