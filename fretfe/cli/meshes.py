# SPDX-License-Identifier: LGPL-3.0-or-later
"""The commands `fretfe check` and `fretfe mesh`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import CaseFile, Overrides, TrustGeo, count, examples
from fretfe.environment import idle_cores, rank_from_environment
from fretfe.report.texts import MISSING, plain_table, print_whole, rounded

if TYPE_CHECKING:
    from rich.table import Table

    from fretfe.case import Case
    from fretfe.checked import Checked
    from fretfe.console import Console
    from fretfe.mesh.mesh import BodySummary, Mesh
    from fretfe.surface.checks import ContactQuality, SurfaceQuality

CHECK_EXAMPLES = examples(
    "fretfe check pad.toml",
    "fretfe check pad.toml --set geometry.parameters.size=0.02",
    "fretfe check model.inp",
)


def check(
    case: CaseFile,
    overrides: Overrides = None,
    trust_geo: TrustGeo = False,
    ranks: Annotated[
        int | None,
        typer.Option(
            "--ranks",
            parser=count,
            metavar="N",
            show_default=False,
            help="Estimate the run on N processes, too; without it on all cores if that pays.",
        ),
    ] = None,
) -> None:
    """Check a case and its mesh, and list what would be solved.

    Of an Abaqus or CalculiX input file, print the case that it amounts to.
    """
    from fretfe.case import load_case, parse_assignments
    from fretfe.case.base import ABAQUS
    from fretfe.checked import check as check_case
    from fretfe.console import Console

    if rank_from_environment() > 0:
        return
    if case.suffix.lower() in ABAQUS.suffixes:
        _propose(case)
        return
    read = load_case(case, parse_assignments(overrides or ()), trust_geo=trust_geo)
    with Console(stderr=True).status("making the mesh, and looking at it"):
        checked = check_case(read)
    if checked is not None:
        _print(checked, ranks)


def _propose(deck: Path) -> None:
    """Print the case that a deck amounts to, and whether it could be solved.

    Raises:
        Exit: with the exit code that the case would have.
    """
    import tomllib

    from fretfe.case import parse_case
    from fretfe.checked import check as check_case
    from fretfe.errors import FretfeError
    from fretfe.mesh.inp_outline import outline

    found, source = outline(deck), deck.with_suffix(".toml")
    text, code = "\n".join(found.lines), 0
    print(text)
    try:
        check_case(parse_case(tomllib.loads(text), source))
    except FretfeError as error:
        print("# This case cannot be solved yet:\n#", str(error).replace("\n", "\n# "))
        code = error.exit_code
    else:
        print("# This case is valid: write it to a file beside the deck.")
    if found.lacks:
        many = f"{found.lacks} things of the deck are"
        things = "one thing of the deck is" if found.lacks == 1 else many
        print(f"# It is not the deck: {things} not in it, see 'not taken over'.")
    raise typer.Exit(code)


def _print(checked: Checked, ranks: int | None) -> None:
    from fretfe.bodies.continued import between_surfaces, missed_gaps
    from fretfe.bodies.expected import coarse_contacts, pressure_doubts
    from fretfe.bodies.free_ends import end_warning
    from fretfe.case import stiffness_doubts
    from fretfe.checked import propose
    from fretfe.console import Console
    from fretfe.loads import cycle_words, most_added
    from fretfe.mesh.cost import refuse_too_large

    case, history = checked.case, checked.history
    console = Console()
    _print_mesh(console, case, checked.mesh)
    # Of bodies in another unit, which a note tells, nothing can be expected.
    warnings: Iterable[str] = ()
    proposals = tuple(propose(checked))
    if not any(stiffness_doubts(case)):
        given = case, checked.mesh, history, checked.middles
        warnings = tuple(pressure_doubts(*given))
        if not warnings and case.edges.tolerance is None:
            coarse = coarse_contacts(*given, advise=not proposals)
            warnings = (*coarse, *end_warning(case, checked.mesh))
    for warning in (*warnings, *missed_gaps(case, checked.pairs)):
        console.print(f"Warning: {warning}", highlight=False, markup=False)
    for body in checked.definition.bodies:
        console.print(f"{body.name}: {body.material.text}")
        for coordinate, constraint in zip(body.coordinates, body.constraints, strict=True):
            what = "a result, of the whole boundary" if constraint.resultant else coordinate.control
            console.print(f"  {coordinate.label}: {what}", highlight=False)
    for pair in checked.pairs:
        console.print(
            f"contact {pair.name}: {pair.body1} (1) on {pair.body2} (2), "
            f"{len(pair.coupling.surface.weights)} multiplier nodes",
            highlight=False,
        )
        for text in between_surfaces(case, pair):
            console.print(f"  {text}", highlight=False, markup=False)
    modes = checked.restrained_modes
    free = []
    for motion in dict.fromkeys(modes.values()):
        names = [name for name, own in modes.items() if own == motion]
        free.append(f"{' and '.join(names)} {'is' if len(names) == 1 else 'are'} free {motion}")
    if free:
        console.print(f"Note: without contact {'; '.join(free)}.", highlight=False, markup=False)
    for note in checked.notes:
        console.print(f"Note: {note}.", highlight=False, markup=False)
    words = cycle_words(history, case.units.time)
    cycle = f"evaluated cycle {words}" if words else "no cycle to evaluate"
    if more := most_added(case, history, checked.mesh.dimension):
        cycle += f", {more} more at most until it is steady"
    if case.edges.tolerance is not None:
        text = f"the mesh refines itself to a tolerance of {case.edges.tolerance:g}: first mesh"
        console.print(text, highlight=False)
    print(f"{len(history.times) - 1} steps to t = {history.times[-1]:g}, {cycle}")
    print(f"Estimate: {checked.cost.text}")
    _print_on_ranks(checked, ranks)
    refuse_too_large(checked.cost)
    for proposal in proposals:
        console.print(f"Proposal: {proposal}", highlight=False, markup=False)
    console.print("The case is valid.")


def _print_on_ranks(checked: Checked, asked: int | None) -> None:
    """Print what a run takes on so many processes; by itself on all cores, if that pays."""
    alone, ranks = checked.cost, asked or idle_cores() + 1
    several = checked.cost_on(ranks)
    if ranks > 1 and (asked or several.pays_beside(alone)):
        print(f"On {ranks} processes (run --ranks {ranks}): {several.beside(alone)}")
    if asked:
        cores = idle_cores() + 1
        most = checked.most_ranks(cores)
        processes = "process" if most == 1 else "processes"
        print(f"This machine has {cores} cores, and memory for {most or 'no'} {processes} on them")


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
    from fretfe.bodies.input_files import input_files
    from fretfe.case import load_case, parse_assignments
    from fretfe.checked import make_mesh
    from fretfe.errors import CaseError
    from fretfe.results.writer import prepare_directory

    if rank_from_environment() > 0:
        return
    read = load_case(case, parse_assignments(overrides or ()), trust_geo=trust_geo)
    if output.resolve() in input_files(read):
        raise CaseError(f"--output: expected a new file, found {output}, which the case reads")
    prepare_directory(output.parent)
    made = make_mesh(read)
    if made is not None:
        _write(read, made, output)


def _write(case: Case, mesh: Mesh, target: Path) -> None:
    from fretfe.console import Console
    from fretfe.mesh.make import write_mesh
    from fretfe.report.pictures.mesh import write_mesh_picture

    console = Console()
    _print_mesh(console, case, mesh)
    write_mesh(mesh, target)
    print(f"Mesh in {target}")
    if mesh.dimension == 2:
        picture = target.with_suffix(".png")
        write_mesh_picture(picture, case, mesh.bodies)
        print(f"Picture in {picture}")
    else:
        console.print("Note: a picture is drawn of plane meshes only.")


def _print_mesh(console: Console, case: Case, mesh: Mesh) -> None:
    """Print size and quality of the bodies and the contacts, and what may spoil the results."""
    from fretfe.mesh.mesh import mesh_summary
    from fretfe.surface.checks import contact_quality, initial_gaps, mesh_warnings, other_sizes
    from fretfe.surface.unnamed import unnamed_contacts

    bodies = mesh_summary(mesh)
    unit = case.units.length
    print_whole(_body_table(bodies))
    contacts = contact_quality(initial_gaps(mesh, case))
    measure = "length" if mesh.dimension == 2 else "area"
    print_whole(_surface_table(contacts, unit, measure))
    print_whole(_gap_table(contacts, unit, measure))
    unnamed = unnamed_contacts(mesh, case.surface_names)
    for warning in (*mesh_warnings(bodies, contacts, unit), *unnamed):
        console.print(f"Warning: {warning}", highlight=False, markup=False)
    size = case.geometry.size if mesh.dimension == 3 and case.edges.tolerance is None else None
    other = other_sizes(contacts, size, unit) if size is not None else ()
    for note in (*mesh.notes, *other):
        console.print(f"Note: {note}", highlight=False, markup=False)


def _body_table(bodies: Sequence[BodySummary]) -> Table:
    from fretfe.mesh.elements import PLURALS

    headers = ("body", "elements", "nodes", "order", "smallest angle [°]")
    table = plain_table("Bodies", headers, text=1)
    for body in bodies:
        table.add_row(
            body.name,
            f"{body.elements} {PLURALS[body.cell]}",
            str(body.nodes),
            str(body.order),
            f"{body.smallest_angle:.1f}",
        )
    return table


def _surface_table(contacts: Sequence[ContactQuality], unit: str, measure: str) -> Table:
    title = f"Contact surfaces: {measure}s, element sizes h and radii of curvature R in {unit}"
    headers = ("contact", "surface", measure, "facing", "min h", "max h", "R", "R/h")
    table = plain_table(title, headers, text=2)
    for contact in contacts:
        for number, surface in enumerate(contact.surfaces):
            table.add_row("" if number else contact.name, surface.name, *_surface_cells(surface))
    return table


def _surface_cells(surface: SurfaceQuality) -> list[str]:
    straight = math.isinf(surface.radius)
    return [
        rounded(surface.measure, 4),
        f"{surface.opposite} of {surface.facets}",
        rounded(surface.smallest),
        rounded(surface.largest),
        "flat" if straight else rounded(surface.radius),
        MISSING if straight else rounded(surface.per_radius),
    ]


def _gap_table(contacts: Sequence[ContactQuality], unit: str, measure: str) -> Table:
    from fretfe.surface.checks import place

    headers = ("contact", measure, "gap", "overlap", "at", "size ratio")
    table = plain_table(
        f"Before any load: smallest gap or largest overlap in {unit}", headers, text=1
    )
    for contact in contacts:
        table.add_row(
            contact.name,
            rounded(contact.measure, 4),
            rounded(contact.gap),
            rounded(contact.interpenetration),
            place(contact.nearest, 4),
            f"{contact.size_ratio:.2f}",
        )
    return table
