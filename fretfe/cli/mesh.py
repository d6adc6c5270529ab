# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe mesh`; the first process writes and prints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.api import make_mesh
from fretfe.case import Case
from fretfe.cli.mesh_report import print_mesh
from fretfe.mesh.extrude import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.writer import write_mesh
from fretfe.report.mesh_picture import write_mesh_picture
from fretfe.results.writer import prepare_directory
from fretfe.runner import fem_runner


def write_mesh_file(
    path: Path, target: Path, overrides: Sequence[str] = (), *, trust_geo: bool = False
) -> None:
    """Write the mesh of a case. Collective."""
    processes = fem_runner().processes
    case = fem_runner().read_case(path, overrides, trust_geo=trust_geo)
    processes.on_root(lambda: prepare_directory(target.parent))
    mesh = make_mesh(case)
    processes.on_root(lambda: _write(case, mesh, target))


def _write(case: Case, mesh: Mesh | None, target: Path) -> None:
    assert mesh is not None
    console = Console()
    print_mesh(console, case, mesh)
    solid = case.geometry.solid
    if solid is not None:
        mesh = extrude(mesh, solid)
        _print_solid(console, mesh)
    write_mesh(mesh, target)
    console.print(f"Mesh in {target}", highlight=False, soft_wrap=True)
    if mesh.dimension == 2:
        picture = target.with_suffix(".png")
        write_mesh_picture(picture, case, mesh.bodies)
        console.print(f"Picture in {picture}", highlight=False, soft_wrap=True)
    else:
        console.print("Note: a picture is drawn of plane meshes only.")


def _print_solid(console: Console, mesh: Mesh) -> None:
    """What the plane mesh that the table describes became."""
    for body in mesh.bodies.values():
        text = f"{body.name}, extruded: {len(body.cells)} tetrahedra, {len(body.points)} nodes"
        console.print(text, highlight=False)
