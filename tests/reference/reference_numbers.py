# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results of two cases on stored meshes, to compare DOLFINx versions and MPI libraries.

`cd tests; python -m reference.reference_numbers` writes the file of references anew. They are
regression numbers: exact values are checked elsewhere. Each version of Gmsh makes another mesh, so
the meshes are stored, in tests/data: `b1` is `write_b1(order=2, h=0.02, growth=0.3)`, `dovetail`
the template of the demo with a shorter flank and coarser (`flank_length = 2`, `edge_size = 0.005`,
`edge_zone = 0.12`, `growth = 0.5`, `flank_size = 0.1`), both by Gmsh 4.15 with coordinates rounded
to 1e-9.
"""

from __future__ import annotations

import gzip
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from cases.b1 import b1_case

from fretfe.case import Case, parse_case
from fretfe.evaluate.contacts import Contact, Station
from fretfe.fem._compat import MPI, versions
from fretfe.fem.run import solve
from fretfe.history.solution import ContactHistory

Numbers = dict[str, list[float]]

DATA = Path(__file__).parents[1] / "data"
REFERENCES = DATA / "reference_numbers.json"
DEMO = Path(__file__).parents[2] / "demos" / "dovetail.toml"
CASES = ("b1", "dovetail")


def stored_case(name: str, folder: Path) -> Case:
    """A case on its stored mesh, which is unpacked into a folder."""
    mesh = folder / f"{name}.msh"
    mesh.write_bytes(gzip.decompress((DATA / f"{name}.msh.gz").read_bytes()))
    if name == "b1":
        return parse_case(b1_case(mesh, degree=2, friction_from=5.0, multipliers="finer"))
    data: dict[str, Any] = tomllib.loads(DEMO.read_text("utf-8"))
    data["geometry"] = {"file": str(mesh)}
    data["output"] = {"fields": "none"}
    wave = data["loads"]["pull"]["history"][-1]
    wave.update(cycles=2, steps_per_cycle=16)
    return parse_case(data)


def solved_numbers(name: str, folder: Path) -> Numbers:
    """Solve a stored case: forces, lengths, edge factors, slip zones and norms of tractions.

    Args:
        name: one of CASES.
        folder: where the mesh is unpacked.
    """
    case = stored_case(name, folder)
    outcome = solve(MPI.COMM_SELF, case)
    assert outcome.failure is None
    solution = outcome.solution
    found = {"forces on boundaries": solution.forces.ravel()}
    for contact, summary in zip(solution.contacts, outcome.contacts, strict=True):
        values = [*_of_contact(contact, summary)]
        values += [
            (f"{e.front} {key}", value) for e in summary.stations for key, value in _of_edge(e)
        ]
        found |= {f"{contact.name} {key}": np.atleast_1d(value) for key, value in values}
    return {key: value.astype(float).tolist() for key, value in found.items()}


def _of_contact(contact: ContactHistory, summary: Contact) -> Iterator[tuple[str, Any]]:
    for key in ("normal_force", "shear_force", "moment", "half_width", "effective_tension"):
        yield key, getattr(summary, key)
    yield "friction work", np.sum(contact.dissipation, axis=1)
    for component, key in enumerate(("pressure", "shear")):
        yield (
            f"norm of {key}",
            np.sqrt(contact.traction[..., component] ** 2 @ contact.surface.weights),
        )
    yield "status", np.sum(contact.status * np.arange(1, 1 + contact.status.shape[1]), axis=1)


def _of_edge(edge: Station) -> Iterator[tuple[str, Any]]:
    for key in ("position", "k_n", "k_t", "k_i"):
        yield key, getattr(edge, key)
    for key in ("k_t_range", "k_t_range_fitted", "k_i_range"):
        yield key, getattr(edge, key)
    for key in ("start", "end", "length", "border", "predicted", "predicted_loop"):
        yield f"slip zones, {key}", np.array([getattr(zone, key) for zone in edge.slip_zones])


def read_references() -> dict[str, Numbers]:
    """Stored numbers of each case."""
    stored: dict[str, dict[str, Numbers]] = json.loads(REFERENCES.read_text("utf-8"))
    return stored["cases"]


def write_references() -> None:
    """Solve all cases with the libraries at hand and store the numbers."""
    with TemporaryDirectory() as folder:
        cases = {name: solved_numbers(name, Path(folder)) for name in CASES}
    text = json.dumps({"made with": versions(), "cases": cases}, indent=1)
    REFERENCES.write_text(text + "\n", "utf-8")


if __name__ == "__main__":
    write_references()
