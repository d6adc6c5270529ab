# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe mesh`; the first process writes and prints."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import CaseFile, Overrides, TrustGeo, examples
from fretfe.environment import rank_from_environment

if TYPE_CHECKING:
    from fretfe.case import Case
    from fretfe.mesh.mesh import Mesh

EXAMPLES = examples("fretfe mesh pad.toml -o pad.msh")


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
    from fretfe.mesh.writer import write_mesh
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
