# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of a disc that are none: sides, axes, numbers, loads and supports."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from cases import sectors
from faults.fault import CHECK, FEM, HALFPLANE, Fault

from fretfe._typing import Array
from fretfe.case import Solid
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.make import write_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh

Tables = dict[str, Any]
OUTSIDE = {"boundary": "ring_right"}
PUSH = {"type": "traction", **OUTSIDE, "direction": "x", "history": sectors.ramp(1e-3)}

# Keys of the sides, tables besides those of the case; must it be refused?
SIDES: dict[str, tuple[Tables, bool | None]] = {
    "as they are": ({}, False),
    "exchanged": ({"boundary1": "ring_top", "boundary2": "ring_bottom"}, False),
    "one sector": ({"sectors": 1}, True),
    "no sectors": ({"sectors": 0}, True),
    "-4 sectors": ({"sectors": -4}, True),
    "5 sectors": ({"sectors": 5}, True),
    "4.0 sectors": ({"sectors": 4.0}, True),
    "1e9 sectors": ({"sectors": 10**9}, True),
    "sectors in words": ({"sectors": "four"}, True),
    "mirror": ({"type": "mirror"}, True),
    "same side twice": ({"boundary2": "ring_bottom"}, True),
    "a side that is not there": ({"boundary2": "nothing"}, True),
    "a side that is a body": ({"boundary2": "ring"}, True),
    "a side of another body": ({"boundary2": "pad_top"}, True),
    "a side that is no image": ({"boundary2": "ring_right"}, True),
    "a side that is a contact surface": ({"boundary2": "ring_seat"}, True),
    "another centre": ({"centre": [0.1, 0.0]}, True),
    "a centre far away": ({"centre": [1e12, 0.0]}, True),
    "a centre of nan": ({"centre": [float("nan"), 0.0]}, True),
    "a centre in space": ({"centre": [0.0, 0.0, 0.0]}, True),
    "an axis in the plane": ({"axis": [1, 0, 0]}, True),
    "an axis of no length": ({"axis": [0, 0, 0]}, True),
    "an axis backwards": ({"axis": [0, 0, -1]}, False),
}
TABLES: dict[str, tuple[Tables, bool | None]] = {
    "acceleration": (
        {"loads": {"more": {"type": "acceleration", "direction": "x",
                            "history": sectors.ramp(1.0)}}}, True,
    ),
    "rotation about another axis": (
        {"loads": {"more": {"type": "rotation", "centre": [1.0, 0.0],
                            "history": sectors.ramp(1.0)}}}, True,
    ),
    "roller at both sides": ({"supports": {"a": {**OUTSIDE, "direction": [1.0, 0.0]}}}, True),
    "held along x": ({"supports": {"a": {**OUTSIDE, "fix": ["x"]}}}, True),
    "held": ({"supports": {"a": {**OUTSIDE, "fix": ["x", "y"]}}}, False),
    "support of a side": ({"supports": {"a": {"boundary": "ring_top", "fix": ["x"]}}}, True),
    "platen": (
        {"loads": {"more": {**PUSH, "type": "platen", "control": "force"}}}, True,
    ),
    "pushed outwards": ({"loads": {"more": {**PUSH, "direction": "normal"}}}, False),
    "sides twice": ({"symmetry": {"again": sectors.cyclic()["sides"]}}, True),
}  # fmt: skip


def moved(where: Callable[[Array, Array], Array]) -> BodyMesh:
    """The sector with radii by a function of the part of the way to the top, and of radii."""
    ring = sectors.ring()
    radius = np.hypot(*ring.points.T)
    angle = np.arctan2(ring.points[:, 1], ring.points[:, 0])
    part = (np.degrees(angle) + 45) / 90
    size = where(part, radius) / radius
    return replace(ring, points=ring.points * size[:, None])


def part_of_side(name: str) -> BodyMesh:
    """The sector with only a part of a side in its group."""
    ring = sectors.ring()
    return replace(ring, boundaries={**ring.boundaries, name: ring.boundaries[name][:2]})


# Sectors; must they be refused?
MESHES: dict[str, tuple[Callable[[], BodyMesh], bool]] = {
    "nodes of one side elsewhere": (
        lambda: moved(lambda part, r: r + 0.2 * part * (r - sectors.BORE) * (sectors.OUTSIDE - r)),
        False,
    ),
    "one side longer": (
        lambda: moved(lambda part, r: r + 0.1 * part * (r - sectors.BORE)), True,
    ),
    "one side farther out": (lambda: moved(lambda part, r: r + 0.1 * part), True),
    "one side a little longer": (
        lambda: moved(lambda part, r: r + 1e-4 * part * (r - sectors.BORE)), True,
    ),
    "a part of a side": (lambda: part_of_side("ring_top"), True),
    "a part of the other side": (lambda: part_of_side("ring_bottom"), True),
    "a contact at a side": (lambda: sectors.ring(seat=(-50.0, 30.0)), True),
    "a contact from side to side": (lambda: sectors.ring(seat=(-50.0, 50.0)), True),
    "a sector around the axis": (lambda: shifted(-1.2), True),
    "a sector with the axis on its bore": (lambda: shifted(-1.0), True),
}  # fmt: skip


def shifted(along: float) -> BodyMesh:
    """The sector moved so that the axis of the case is elsewhere in it."""
    ring = sectors.ring()
    return replace(ring, points=ring.points + np.array([along, 0.0]))


def turning() -> Tables:
    """A traction on the sector of which nothing takes the moment about the axis."""
    return {"loads": {"more": {**PUSH, "direction": "y"}}}


def faults() -> Iterator[Fault]:
    """All of them."""
    for name, (keys, refused) in SIDES.items():
        yield from _both(f"sides/{name}", sectors.cyclic(**keys), {}, refused)
    for name, (tables, refused) in TABLES.items():
        yield from _both(f"tables/{name}", sectors.cyclic(), tables, refused)
    yield _fault("tables/turned by a traction", FEM, sectors.cyclic(), turning(), True)
    yield _fault("half-planes", HALFPLANE, sectors.cyclic(), {}, True)
    for name, skew in (("solid", 0.0), ("solid that leans", 20.0)):
        sides = sectors.cyclic(centre=[0, 0, 0])
        back = {each: {"boundary": f"{each}_back", "fix": ["z"]} for each in ("ring", "pad")}
        yield _fault(name, CHECK, sides, {"supports": back}, skew > 0, skew)
    yield _fault("solid that nothing holds", CHECK, sides, {}, True, 0.0)
    for name, (mesh, refused) in MESHES.items():
        for command in (CHECK, FEM):
            yield _fault(
                f"meshes/{name}/{command[0]}", command, sectors.cyclic(), {}, refused, ring=mesh
            )


def _both(name: str, sides: Tables, tables: Tables, refused: bool | None) -> Iterator[Fault]:
    yield _fault(f"{name}/check", CHECK, sides, tables, refused)
    yield _fault(f"{name}/run", FEM, sides, tables, refused)


def _fault(
    name: str,
    command: tuple[str, ...],
    sides: Tables,
    tables: Tables,
    refused: bool | None,
    skew: float | None = None,
    ring: Callable[[], BodyMesh] = sectors.ring,
) -> Fault:
    axis = () if skew is None else (0, 0, 1)
    data = copy.deepcopy(sectors.spinning(1, axis, symmetry=sides))
    data |= {key: data.get(key, {}) | table for key, table in tables.items()}
    data["geometry"] = {"file": "sector.msh"}

    def write(good: Path, here: Path) -> None:
        mesh = Mesh({each.name: each for each in bodies(ring())})
        if skew is not None:
            mesh = extrude(mesh, Solid(length=0.5, layers=1, skew=skew))
        write_mesh(mesh, here / "sector.msh")
        (here / "case.toml").write_text(tomli_w.dumps(data))

    return Fault(f"disc/{name}", command, write, refused)


def bodies(ring: BodyMesh) -> list[BodyMesh]:
    """The sector and its block, all of their boundaries of one group each."""
    outside = {name: ring.boundaries[name] for name in ("ring_bottom", "ring_top", "ring_right")}
    return [replace(ring, boundaries={**outside, "ring_seat": ring.boundaries["ring_seat"]}),
            sectors.pad()]  # fmt: skip
