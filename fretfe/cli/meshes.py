# SPDX-License-Identifier: LGPL-3.0-or-later
"""The commands `fretfe check` and `fretfe mesh`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import CaseFile, Overrides, TrustGeo, examples
from fretfe.environment import rank_from_environment

if TYPE_CHECKING:
    from fretfe.case import Case
    from fretfe.checked import Checked
    from fretfe.mesh.mesh import Mesh

CHECK_EXAMPLES = examples(
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
    from fretfe.loads import most_added
    from fretfe.mesh.cost import SLOW_FACTORS, needs_symmetric_factors

    case, history = checked.case, checked.history
    console = Console()
    print_mesh(console, case, checked.mesh)
    if case.edges.tolerance is None:
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
    if more := most_added(case, history, checked.mesh.dimension):
        cycle += f", {more} more at most until it is steady"
    if case.edges.tolerance is not None:
        text = f"the mesh refines itself to a tolerance of {case.edges.tolerance:g}: first mesh"
        console.print(text, highlight=False)
    steps = f"{len(history.times) - 1} steps to t = {history.times[-1]:g}"
    console.print(f"{steps}, {cycle}", soft_wrap=True)
    console.print(f"Estimate: {checked.cost.text}", highlight=False, soft_wrap=True)
    if needs_symmetric_factors(checked.cost):
        console.print(f"Note: {SLOW_FACTORS}", highlight=False)
    console.print("The case is valid.")


MESH_EXAMPLES = examples("fretfe mesh pad.toml -o pad.msh")


def mesh(
    case: CaseFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="Mesh file to write (.msh).")],
    overrides: Overrides = None,
    trust_geo: TrustGeo = False,
) -> None:
    """Make the mesh of a case and write it for Gmsh.

    With its named groups, and a picture beside it.
    """
    from fretfe.case import load_case, parse_assignments
    from fretfe.checked import make_mesh
    from fretfe.results.writer import prepare_directory

    if rank_from_environment() > 0:
        return
    read = load_case(case, parse_assignments(overrides or ()), trust_geo=trust_geo)
    prepare_directory(output.parent)
    made = make_mesh(read)
    if made is not None:
        _write(read, made, output)


def _write(case: Case, mesh: Mesh, target: Path) -> None:
    from rich.console import Console

    from fretfe.cli.mesh_report import print_mesh
    from fretfe.mesh.make import write_mesh
    from fretfe.report.pictures.mesh import write_mesh_picture

    console = Console()
    print_mesh(console, case, mesh)
    write_mesh(mesh, target)
    console.print(f"Mesh in {target}", highlight=False, soft_wrap=True)
    if mesh.dimension == 2:
        picture = target.with_suffix(".png")
        write_mesh_picture(picture, case, mesh.bodies)
        console.print(f"Picture in {picture}", highlight=False, soft_wrap=True)
    else:
        console.print("Note: a picture is drawn of plane meshes only.")
