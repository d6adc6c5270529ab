# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe check`; the first process prints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.api import Checked, check
from fretfe.cli.mesh_report import print_mesh
from fretfe.runner import fem_runner


def check_case(path: Path, overrides: Sequence[str] = (), *, trust_geo: bool = False) -> None:
    """Print what a case would solve. Collective."""
    checked = check(fem_runner().read_case(path, overrides, trust_geo=trust_geo))
    if checked is not None:
        _print(checked)


def _print(checked: Checked) -> None:
    case, history = checked.case, checked.history
    console = Console()
    print_mesh(console, case, checked.mesh)
    for body in checked.definition.bodies:
        console.print(f"{body.name}: E = {body.material.young:g}, ν = {body.material.poisson:g}")
        for coordinate in body.coordinates:
            console.print(f"  {coordinate.label}: {coordinate.control}", highlight=False)
    for pair in checked.pairs:
        console.print(
            f"contact {pair.name}: {pair.body1} (1) on {pair.body2} (2), "
            f"{len(pair.coupling.weights)} multiplier nodes",
            highlight=False,
        )
    for name, motion in checked.free_motions.items():
        text = f"Note: without contact {name} is free {motion}."
        console.print(text, highlight=False, markup=False)
    cycle = "no cycle to evaluate"
    if history.cycle is not None:
        first, last = (history.times[state] for state in history.cycle)
        cycle = f"evaluated cycle t = {first:g} to {last:g} {case.units.time}"
    if case.edges is not None:
        text = f"the mesh refines itself to a tolerance of {case.edges.tolerance:g}: first mesh"
        console.print(text, highlight=False)
    console.print(f"{len(history.times) - 1} steps to t = {history.times[-1]:g}, {cycle}")
    console.print("The case is valid.")
