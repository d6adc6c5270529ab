# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the commands that need a mesh or DOLFINx do; rank 0 prints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.case import Case
from fretfe.cli.mesh_report import print_mesh
from fretfe.environment import blas_libraries, reference_blas, versions
from fretfe.loads import History, build_history
from fretfe.mesh.extrude import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.writer import write_mesh
from fretfe.report.mesh_picture import write_mesh_picture
from fretfe.results.writer import prepare_directory
from fretfe.runner import read_case, require_supported


def _load(path: Path, overrides: Sequence[str], trust_geo: bool) -> Case:
    from fretfe.fem._compat import MPI
    from fretfe.fem.parallel import on_root

    case = on_root(MPI.COMM_WORLD, lambda: read_case(path, overrides, trust_geo=trust_geo))
    assert case is not None
    return case


def check_case(path: Path, overrides: Sequence[str] = (), *, trust_geo: bool = False) -> None:
    """Print what a case would solve."""
    from fretfe.fem._compat import MPI
    from fretfe.fem.backend import BACKEND
    from fretfe.fem.parallel import on_root
    from fretfe.fem.refine import starting_mesh

    case = _load(path, overrides, trust_geo)
    require_supported(BACKEND, "fem", case)
    history = on_root(MPI.COMM_WORLD, lambda: build_history(case))
    assert history is not None
    on_root(MPI.COMM_WORLD, lambda: _print_check(case, history, starting_mesh(case)))


def _print_check(case: Case, history: History, mesh: Mesh) -> None:
    from fretfe.fem.definition import plan_model
    from fretfe.fem.model import contact_surfaces, couple_contacts
    from fretfe.fem.rigid_modes import free_motions

    plan = plan_model(case, mesh)
    pairs = couple_contacts(case, contact_surfaces(plan, mesh))
    console = Console()
    print_mesh(console, case, mesh)
    for body in plan.bodies:
        console.print(f"{body.name}: E = {body.material.young:g}, ν = {body.material.poisson:g}")
        for coordinate in body.coordinates:
            console.print(f"  {coordinate.label}: {coordinate.control}", highlight=False)
    for pair in pairs:
        console.print(
            f"contact {pair.name}: {pair.body1} (1) on {pair.body2} (2), "
            f"{len(pair.coupling.weights)} multiplier nodes",
            highlight=False,
        )
    for name, motion in free_motions(plan, mesh).items():
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


def write_mesh_file(
    path: Path, target: Path, overrides: Sequence[str] = (), *, trust_geo: bool = False
) -> None:
    """Write the mesh of a case."""
    from fretfe.fem._compat import MPI
    from fretfe.fem.parallel import on_root

    case = _load(path, overrides, trust_geo)
    on_root(MPI.COMM_WORLD, lambda: _write_mesh(case, target))


def _write_mesh(case: Case, target: Path) -> None:
    from fretfe.fem.refine import starting_mesh

    prepare_directory(target.parent)
    mesh = starting_mesh(case)
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


def show_info() -> None:
    """Print versions and libraries."""
    from fretfe.fem import _compat
    from fretfe.fem._compat import MPI

    if MPI.COMM_WORLD.rank != 0:
        return
    console = Console()
    for name, version in {**versions(), **_compat.versions()}.items():
        console.print(f"{name:12s} {version}", highlight=False)
    console.print(f"{'MPI ranks':12s} {MPI.COMM_WORLD.size}", highlight=False)
    libraries = blas_libraries()
    for library in libraries:
        console.print(f"{'BLAS':12s} {library}", highlight=False, soft_wrap=True)
    for library in reference_blas(libraries):
        console.print(
            f"Warning: {library} is the reference BLAS, which makes factorisations about four "
            "times slower. Install OpenBLAS (Debian: libopenblas0-pthread).",
            highlight=False,
            soft_wrap=True,
        )
