# SPDX-License-Identifier: LGPL-3.0-or-later
"""Good files of every kind that is read, to be damaged."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import gmsh
import h5py
import meshio
import numpy as np
import tomli_w
from cases.pad_cases import ROUGH, TOP, cylinder, pad, press, shear
from cases.solid_runs import solid_result
from cases.stored_runs import CYCLE, write_run
from cases.user_geometry import BODIES, BOUNDARIES, write_cad

from fretfe.backends import RunOptions
from fretfe.backends.halfplane import BACKEND as HALFPLANE
from fretfe.case import parse_case
from fretfe.loads import build_history
from fretfe.mesh.make import write_mesh
from fretfe.results.field_files import FieldWriter
from fretfe.results.writer import write_results
from fretfe.surface.checks import load_mesh

COARSE = {"size": 0.2, "growth": 0.5}
LOADS = {"press": press(steps=1), "shear": shear(steps=4, cycles=1)}
# Small, but with all kinds of tables.
PAD: dict[str, Any] = pad(
    geometry=cylinder(**COARSE),
    loads=LOADS,
    units={"length": "mm", "force": "N"},
    model={"plane": "strain", "thickness": 1.0, "degree": 1},
    cycle={"until_steady": True},
    title="pad",
)
SOLID: dict[str, Any] = {
    **PAD,
    "geometry": {**PAD["geometry"], "solid": {"length": 2.0, "layers": 1}, "order": 1},
    "model": {"degree": 1},
}
# With all that may lie between the surfaces.
BETWEEN: dict[str, Any] = {
    "friction": {"times": [0.0, 1.0, 3.0], "values": [0.4, 0.4, 0.5]},
    "layer": {"normal": 1e6, "tangential": 5e5},
    "gap": "gap.csv",
}
COATED: dict[str, Any] = {
    **PAD,
    "contacts": {"main": {**PAD["contacts"]["main"], **BETWEEN}},
}
# With friction that follows what happens, and a case that goes on from a run that is not there.
RUBBED: dict[str, dict[str, Any]] = (
    {
        over: {**PAD, "contacts": {"main": {**PAD["contacts"]["main"], "friction": table}}}
        for over, table in {
            "pressed": {"pressure": [0.0, 900.0], "values": [0.4, 0.2]},
            "heated": {"temperature": [20.0, 600.0], "values": [0.4, 0.2]},
        }.items()
    }
    | {"rough": {**PAD, "contacts": {"main": {**PAD["contacts"]["main"], "layer": ROUGH}}}}
    | {"branch": {**PAD, "start": {"from": "preload", "time": 1.0}}}
)
MESHES = ("pad.msh", "pad22.msh", "binary.msh", "binary22.msh", "solid.msh", "pad.inp")
GRIDS = ("pad.xdmf", "text.xdmf")
DRAWINGS = ("pad.step", "pad.brep", "cubes.step", "cubes.brep")
ROWS = [(i / 2, 60 * np.sin(i / 4)) for i in range(25)]
GROUPS = (
    {"upper": 1, "lower": 2},
    {"upper_contact": 3, "upper_top": 4, "lower_contact": 5, "lower_bottom": 6},
)
NUMBERS = {
    table: {name: {"tag": tag} for name, tag in tags.items()}
    for table, tags in zip(("bodies", "boundaries"), GROUPS, strict=True)
}
CUBES: dict[str, Any] = {
    "bodies": {"upper": {"point": [0.5, 0.5, 0.5]}, "lower": {"point": [0.5, -0.5, 0.5]}},
    "boundaries": {
        "upper_contact": {"point": [0.5, 0.0, 0.5], "body": "upper"},
        "upper_top": {"point": [0.5, 1.0, 0.5]},
        "lower_contact": {"point": [0.5, 0.0, 0.5], "body": "lower"},
        "lower_bottom": {"point": [0.5, -1.0, 0.5]},
    },
    "size": 0.7,
    "order": 1,
}


# A rig that can do what the edge of the run needs with two of three pads.
RIG_TEXT = """\
title = "rig"
process_zone = 0.05
[units]
length = "mm"
[pad]
shapes = ["cylinder", "flat_rounded", "wedge"]
young = 210e3
poisson = 0.3
radius = [30.0, 80.0]
flat_half_width = [0.2, 1.0]
angle = [0.2, 3.0]
half_width = 12.0
height = 12.0
[specimen]
young = 210e3
poisson = 0.3
thickness = 12.0
half_width = 12.0
yield_stress = 900.0
[forces]
normal = [100.0, 5000.0]
shear = [0.0, 500.0]
"""
# log10 N = 12.7 - 4 log10 ΔK_T - 0.3 log10 K_N, with a scatter; the last tests are run-outs.
FACTORS = [(k_t, k_n) for k_t in np.geomspace(64, 28, 8) for k_n in (900, 1240, 1600)]
LIVES = [
    10 ** (12.7 - 4 * np.log10(k_t) - 0.3 * np.log10(k_n) + 0.1 * np.sin(9 * i))
    for i, (k_t, k_n) in enumerate(FACTORS)
]
TESTS_TEXT = (
    "k_n [MPa/mm^0.5],dk_t [MPa*mm^0.5],life,runout,friction,young [MPa],poisson\n"
    + "".join(
        f"{k_n},{k_t:.4g},{life:.5g},{int(k_t < 30)},0.4,210e3,0.3\n"
        for (k_t, k_n), life in zip(FACTORS, LIVES, strict=True)
    )
)
# What a finite-element program writes: Hertz, and a shear in proportion.
FOREIGN_TEXT = "Node,COOR1,COOR2,CPRESS,CSHEAR1,CSHEAR2\n" + "".join(
    f"{number},{x:.6g},0,{400 * np.sqrt(max(1 - x**2, 0)):.6g},"
    f"{40 * np.sqrt(max(1 - x**2, 0)):.6g},0\n"
    for number, x in enumerate(np.linspace(-1.2, 1.2, 61), start=1)
)


def geometry_of(file: str) -> dict[str, Any]:
    """The table [geometry] of a good file."""
    if file in GRIDS:
        return {"file": file, **NUMBERS}
    if file.startswith("cubes"):
        return {"file": file, **CUBES}
    if file in DRAWINGS:
        names = {"bodies": BODIES, "boundaries": BOUNDARIES}
        return {"file": file, "size": 1.0, "order": 1, **names}
    return {"file": file}


def case_text(file: str) -> str:
    """A case with a good file as its geometry."""
    return tomli_w.dumps({**PAD, "model": {"degree": 1}, "geometry": geometry_of(file)})


def csv_case(**options: Any) -> str:
    """A case whose shear is in loads.csv."""
    table = {"csv": "loads.csv", "time": "t", "value": "q", **options}
    load = {**TOP, "direction": "x", "history": [table]}
    # Pressed before the first row, so that the contact carries shear in all of them.
    pressed = {**press(), "history": [{"ramp": -600.0, "until": 0.01, "steps": 1}]}
    contacts = {"main": {**PAD["contacts"]["main"], "friction_from": 0.0}}
    tables = {"loads": {"press": pressed, "shear": load}, "contacts": contacts}
    return tomli_w.dumps({**PAD, **tables})


def between_case(**keys: Any) -> str:
    """A case with keys of what lies between the surfaces of its contact."""
    contacts = {"main": {**PAD["contacts"]["main"], **keys}}
    return tomli_w.dumps({**PAD, "contacts": contacts})


def points_case() -> str:
    """A case whose temperatures are in points.csv."""
    warm = {"expansion": 1e-5, "reference_temperature": 20.0}
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    heat = {"type": "temperature", "file": "points.csv", "history": history}
    bodies = {name: {**each, **warm} for name, each in PAD["bodies"].items()}
    return tomli_w.dumps({**PAD, "bodies": bodies, "loads": {"press": press(), "heat": heat}})


MATERIAL = """source = "tests"
units = { stress = "GPa", density = "kg/m^3" }
young = { temperatures = [0, 100], values = [210.0, 190.0] }
poisson = 0.3
density = 7850.0
"""


def material_case() -> str:
    """A case whose bodies are of own.toml."""
    own = {"material": "own.toml", "temperature": 50.0}
    return tomli_w.dumps({**PAD, "bodies": dict.fromkeys(PAD["bodies"], own)})


def strain_case() -> str:
    """A case whose residual strain is in strain.csv."""
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    weld = {"type": "eigenstrain", "file": "strain.csv", "history": history}
    return tomli_w.dumps({**PAD, "loads": {"press": press(), "weld": weld}})


def factors_case() -> str:
    """A case whose traction varies as factors.csv says."""
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    pull = {"type": "traction", "boundary": "lower_right", "direction": "normal"}
    load = {**pull, "file": "factors.csv", "history": history}
    return tomli_w.dumps({**PAD, "loads": {"press": press(), "pull": load}})


def shape_case() -> str:
    """A case in which a boundary moves as shape.csv says."""
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    mode = {"type": "shape", "boundary": "lower_right", "file": "shape.csv", "history": history}
    return tomli_w.dumps({**PAD, "loads": {"press": press(), "mode": mode}})


def field_case(file: str) -> str:
    """A case in which another run moves a cut."""
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    cut = {"type": "field", "boundary": "lower_right", "file": file, "history": history}
    return tomli_w.dumps({**PAD, "loads": {"press": press(), "cut": cut}})


def heat_case(file: str) -> str:
    """A case whose temperatures are those of another run."""
    warm = {"expansion": 1e-5, "reference_temperature": 20.0}
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    heat = {"type": "temperature_field", "file": file, "history": history}
    bodies = {name: {**each, **warm} for name, each in PAD["bodies"].items()}
    return tomli_w.dumps({**PAD, "bodies": bodies, "loads": {"press": press(), "heat": heat}})


def write_originals(folder: Path) -> None:
    """Write all of them."""
    write_cad(folder / "pad.step")
    write_cad(folder / "pad.brep")
    for suffix in ("step", "brep"):
        _write_cubes(folder / f"cubes.{suffix}")
    write_mesh(load_mesh(parse_case(PAD)), folder / "pad.msh")
    write_mesh(load_mesh(parse_case(SOLID)), folder / "solid.msh")
    _convert(folder)
    _write_grids(folder)
    rows = "".join(f"{t:g},{q:.6g}\n" for t, q in ROWS)
    (folder / "loads.csv").write_text("t,q\n" + rows)
    arc = np.linspace(-3, 3, 31)
    rows = "".join(f"{a:.6g},{a**2 / 1000:.6g}\n" for a in arc)
    (folder / "gap.csv").write_text("arc,gap\n" + rows)
    rows = "".join(f"{a:.6g},{0.4 + a**2 / 100:.6g}\n" for a in arc)
    (folder / "friction.csv").write_text("arc,friction\n" + rows)
    corners = "".join(f"{x},{y},{x + y + 90}\n" for x in (-30, 0, 30) for y in (-40, 0, 40))
    (folder / "points.csv").write_text("x,y,T\n" + corners)
    rows = "".join(f"{x},{y},{y / 1e4},0\n" for x in (-30, 30) for y in (-40, -20, 0, 40))
    (folder / "shape.csv").write_text("# mode 1\nx,y,ux,uy\n" + rows)
    _write_grid_run(folder / "run.vtu")
    _write_field_run(folder / "run.hdf")
    x = np.linspace(-1.2, 1.2, 60)
    p = np.sqrt(np.clip(1 - x**2, 0, None)) * 400
    lines = [f"{a:.6g},{b:.6g},{0.1 * b:.6g}" for a, b in zip(x, p, strict=True)]
    (folder / "tractions.csv").write_text("x,p,q\n" + "\n".join(lines) + "\n")
    _write_runs(folder)


def _write_runs(folder: Path) -> None:
    """Results of the same case, of others, and of solids."""
    write_run(folder / "run", "halfplane")
    write_run(folder / "incomplete", "incomplete")
    write_run(folder / "no_cycle", "no cycle")
    # The labels of another set of units, whose numbers count as they are.
    metres = parse_case({**CYCLE, "units": {"length": "metre", "stress": "Pa"}})
    write_run(folder / "metres", "halfplane", metres)
    contact = CYCLE["contacts"]["main"]
    others = {
        "slippery": {"contacts": {"main": {**contact, "friction": 0.2}}},
        "other_load": {"loads": {"press": press(700), "shear": shear(70, steps=8)}},
    }
    for name, tables in others.items():
        case = parse_case({**CYCLE, **tables})
        result = HALFPLANE.solve(case, RunOptions(history=build_history(case)))
        (folder / name).mkdir()
        write_results(folder / name, replace(result, backend="halfplane"))
    (folder / "solid").mkdir()
    write_results(folder / "solid", replace(solid_result(), backend="fem"))


def leaves(table: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of all values in nested tables and lists; of long lists the first item."""
    if isinstance(table, dict) and table:
        return [found for key in table for found in leaves(table[key], (*path, key))]
    if isinstance(table, list) and table:
        return leaves(table[0], (*path, 0))
    return [path]


def _write_cubes(path: Path) -> None:
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("cubes")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.addBox(0, -1, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def _convert(folder: Path) -> None:
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(folder / "pad.msh"))
        for option in ("SaveGroupsOfNodes", "SaveGroupsOfElements"):
            gmsh.option.setNumber(f"Mesh.{option}", 1)
        gmsh.write(str(folder / "pad.inp"))
        for name, version, binary in (
            ("pad22", 2.2, 0), ("binary", 4.1, 1), ("binary22", 2.2, 1)
        ):  # fmt: skip
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.option.setNumber("Mesh.Binary", binary)
            gmsh.write(str(folder / f"{name}.msh"))
    finally:
        gmsh.finalize()


def _write_grid_run(path: Path) -> None:
    """Displacements of a rectangle around the bodies, as text."""
    import pyvista

    grid = pyvista.ImageData(dimensions=(3, 3, 1), spacing=(40, 50, 1), origin=(-40, -50, 0))
    grid = grid.cast_to_unstructured_grid()
    grid.point_data["U"] = 1e-5 * grid.points
    grid.save(path, binary=False)


def _write_field_run(path: Path) -> None:
    """The same as this program writes it, with a rectangle for each body."""
    corners = np.array([[[-40.0, -50], [40, -50], [40, 50], [-40, 50]]])
    moved = 1e-5 * np.pad(corners, ((0, 0), (0, 0), (0, 1)))
    with closing(FieldWriter(path, dict.fromkeys(PAD["bodies"], corners))) as writer:
        values = {"displacement": [moved] * 2, "stress": [np.zeros((1, 4, 6))] * 2}
        writer.add(1.0, values)


def _write_grids(folder: Path) -> None:
    """XDMF with its numbers in HDF5, and in the file itself."""
    mesh = meshio.read(folder / "pad22.msh")
    wanted = {(dim, name): tag for dim, tags in zip((2, 1), GROUPS, strict=True)
              for name, tag in tags.items()}  # fmt: skip
    numbers = {
        (int(dim), int(tag)): wanted.get((int(dim), name), 9)
        for name, (tag, dim) in mesh.field_data.items()
    }
    dims = [2 if block.type.startswith("triangle") else 1 for block in mesh.cells]
    tags = [
        np.array([numbers[dim, int(tag)] for tag in found])
        for dim, found in zip(dims, mesh.cell_data["gmsh:physical"], strict=True)
    ]
    grid = meshio.Mesh(mesh.points, mesh.cells, cell_data={"gmsh:physical": tags})
    grid.write(folder / "pad.xdmf", compression=None)
    grid.write(folder / "text.xdmf", data_format="XML")
    assert h5py.is_hdf5(folder / "pad.h5")
