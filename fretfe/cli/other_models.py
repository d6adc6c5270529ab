# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands that give numbers to models of other programs: `forces`, `joint`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import AsJson, Results, decimal, examples, positive
from fretfe.environment import rank_from_environment
from fretfe.files import json_value
from fretfe.report.texts import number, percent, plain_table, print_whole

if TYPE_CHECKING:
    from fretfe._typing import Array

# Numbers of a loop, with what they are called and the kind of their unit.
JOINT_ROWS = {
    "force_range": ("range of the force", "force"),
    "displacement_range": ("of the displacement", "length"),
    "stiffness": ("secant stiffness", "stiffness"),
    "stuck_stiffness": ("of the bodies stuck together", "stiffness"),
    "joint_stiffness": ("of the contacts by slip", "stiffness"),
    "loss_factor": ("loss factor", ""),
    "slip_range": ("displacement by slip", "length"),
}

JOINT_EXAMPLES = examples("fretfe joint pad", "fretfe joint pad --csv loops.csv")


def joint(
    results: Results,
    loops: Annotated[
        Path | None, typer.Option("--csv", help="File for the loops of force over displacement.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Stiffness and damping of the contacts, for models of vibrations.

    Force and displacement of each driven boundary in the evaluated cycle, the part by slip, secant
    stiffnesses, and the loss factor.
    """
    if rank_from_environment() > 0:
        return
    from fretfe.api import load_result
    from fretfe.exchange.joint import joint_loops, write_loops

    result = load_result(results)
    found = joint_loops(result)
    if loops is not None:
        write_loops(loops, found)
    if as_json:
        rows = [{key: json_value(getattr(each, key)) for key in JOINT_ROWS} for each in found]
        print(json.dumps(rows, indent=2, allow_nan=False))
        return
    force, length = result.case.units.force, result.case.units.length
    units = {"force": force, "length": length, "stiffness": f"{force}/{length}"}
    table = plain_table("Evaluated cycle", ("", "unit", *(each.driver for each in found)), text=2)
    for key, (title, kind) in JOINT_ROWS.items():
        table.add_row(title, units.get(kind, ""), *(number(getattr(each, key)) for each in found))
    bars = (number(each.slip_bar, 2) for each in found)
    table.add_row("  its error bar", length, *bars)
    for name in found[0].slip:
        cells = (number(each.swing(each.slip[name])) for each in found)
        table.add_row(f"  by slip in {name}", length, *cells)
    print_whole(table)
    if loops is not None:
        print(loops)


FORCES_EXAMPLES = examples(
    "fretfe forces pad model.inp SURF-1 --body block -o pad_forces",
    "fretfe forces pad model.inp SURF-1 --body block --time 1.25 --factor 1000 -o pad_forces",
)


def forces(
    results: Results,
    mesh: Annotated[Path, typer.Argument(metavar="MESH", help="Model (.inp).", show_default=False)],
    surface: Annotated[
        str, typer.Argument(metavar="SURFACE", help="Surface or set in it.", show_default=False)
    ],
    body: Annotated[str, typer.Option(help="Body on which the tractions act.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for the files; made if missing.")
    ],
    contact: Annotated[
        str | None, typer.Option(help="Contact, if there are several.", show_default=False)
    ] = None,
    time: Annotated[
        float | None,
        typer.Option(parser=decimal, help="Time of a state.", show_default="the last one"),
    ] = None,
    factor: Annotated[
        float,
        typer.Option(parser=positive, help="Length unit of the model, in that of the results."),
    ] = 1.0,
) -> None:
    """Write contact tractions as forces at the nodes of another model.

    Force and moment are kept.
    """
    if rank_from_environment() > 0:
        return
    from fretfe.api import load_result
    from fretfe.exchange.nodal_force_files import Wanted, export_forces

    result = load_result(results)
    wanted = Wanted(body, contact, time, factor)
    made = export_forces(result, mesh, surface, wanted, output)
    found, unit, length = made.found, result.case.units.force, result.case.units.length
    print(
        f"Contact {made.contact} on {made.body} at t = {made.time:.6g}: forces at {made.nodes} "
        "nodes"
        + (f", for the whole thickness of {made.thickness:g} {length}" if made.thickness else "")
    )
    whole = made.thickness or 1.0
    print(f"force {_components(whole * found.force)} {unit}")
    print(f"moment about the origin {_components(whole * found.moment)} {unit}·{length}")
    print(
        f"both kept to {max(found.imbalance, 1e-16):.0e}; the surface is up to "
        f"{found.distance:.3g} {length} away from the contact, for which forces up to "
        f"{percent(found.added)} of the largest one were added"
    )
    if found.size > 1:
        print(
            f"Note: the facets of the surface are {found.size:.2g} times as long as the contact: "
            "is the unit of length right (--factor)?"
        )
    for path in made.files:
        print(path)
    if result.failure is not None:
        print(f"Note: the run is not complete: {result.failure}")


def _components(values: Array) -> str:
    return f"({', '.join(f'{value:.6g}' for value in values)})"
