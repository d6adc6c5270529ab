# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe check`; the first process prints."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fretfe.cli.options import CaseFile, Overrides, TrustGeo, examples
from fretfe.environment import rank_from_environment

if TYPE_CHECKING:
    from fretfe.checked import Checked

EXAMPLES = examples(
    "fretfe check pad.toml", "fretfe check pad.toml --set geometry.parameters.size=0.02"
)


def check(case: CaseFile, overrides: Overrides = None, trust_geo: TrustGeo = False) -> None:
    """Check a case and its mesh, and list what would be solved."""
    from fretfe.case import load_case, parse_assignments
    from fretfe.checked import check as check_case

    if rank_from_environment() > 0:
        return
    checked = check_case(load_case(case, parse_assignments(overrides or ()), trust_geo=trust_geo))
    if checked is not None:
        _print(checked)


def _print(checked: Checked) -> None:
    from rich.console import Console

    from fretfe.cli.mesh_report import print_mesh
    from fretfe.evaluate.resolution import coarse_contacts
    from fretfe.mesh.cost import SLOW_FACTORS, needs_symmetric_factors

    case, history = checked.case, checked.history
    console = Console()
    print_mesh(console, case, checked.mesh)
    if case.edges.tolerance is None and checked.mesh.dimension == 2:
        for warning in coarse_contacts(case, checked.mesh, history):
            console.print(f"Warning: {warning}", highlight=False, markup=False)
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
    for name, motion in checked.restrained_modes.items():
        text = f"Note: without contact {name} is free {motion}."
        console.print(text, highlight=False, markup=False)
    cycle = "no cycle to evaluate"
    if history.cycle is not None:
        first, last = (history.times[state] for state in history.cycle)
        cycle = f"evaluated cycle t = {first:g} to {last:g} {case.units.time}"
    if case.edges.tolerance is not None:
        text = f"the mesh refines itself to a tolerance of {case.edges.tolerance:g}: first mesh"
        console.print(text, highlight=False)
    console.print(f"{len(history.times) - 1} steps to t = {history.times[-1]:g}, {cycle}")
    console.print(f"Estimate: {checked.cost.text}", highlight=False, soft_wrap=True)
    if needs_symmetric_factors(checked.cost):
        console.print(f"Note: {SLOW_FACTORS}", highlight=False)
    console.print("The case is valid.")
