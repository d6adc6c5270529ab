# SPDX-License-Identifier: LGPL-3.0-or-later
"""A ring that blocks inside it press on when it spins: one sector of it, or all together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from cases import blocks

from fretfe._typing import Array
from fretfe.mesh.mesh import BodyMesh

BORE, OUTSIDE = 1.0, 1.4
SECTORS = 4
# Degrees; the block is not in the middle of its sector.
ANGLES = np.linspace(-45, 45, 13)
SEAT = (-15.0, 30.0)
STEEL = {"young": 200.0, "poisson": 0.3, "density": 1.0}


def polar(points: Array) -> Array:
    """Places of radii and angles in degrees (n, 2)."""
    radius, angle = points[:, 0], np.radians(points[:, 1])
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def turned(mesh: BodyMesh, degrees: float, name: str = "", number: str = "") -> BodyMesh:
    """A mesh turned about z through the origin; its boundaries end in a number."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    points = mesh.points.copy()
    points[:, :2] = points[:, :2] @ np.array([[c, s], [-s, c]])
    boundaries = {f"{key}{number}": facets for key, facets in mesh.boundaries.items()}
    return replace(mesh, name=name or mesh.name, points=points, boundaries=boundaries)


def ring(
    angles: Array = ANGLES,
    order: int = 2,
    seat: tuple[float, float] = SEAT,
    cell: str = "quadrilateral",
) -> BodyMesh:
    """A sector of the ring: sides ring_bottom and ring_top; ring_seat, where the block presses."""
    grid = blocks.block("ring", np.linspace(BORE, OUTSIDE, 4), angles, order=order, cell=cell)
    inner = grid.boundaries["ring_left"]
    middles = grid.points[inner[:, :2], 1].mean(axis=1)
    inside = (middles > seat[0]) & (middles < seat[1])
    boundaries = {**grid.boundaries, "ring_seat": inner[inside]}
    del boundaries["ring_left"]
    return replace(grid, points=polar(grid.points), boundaries=boundaries)


def pad(order: int = 2) -> BodyMesh:
    """A block with a slightly more curved outer side, which touches the ring in its middle."""
    middle = 4.0

    def mapping(points: Array) -> Array:
        radius, angle = points.T
        radius = radius - 0.02 * np.radians(angle - middle) ** 2 * (radius - 0.7) / (BORE - 0.7)
        return polar(np.column_stack([radius, angle]))

    angles = np.linspace(middle - 12, middle + 12, 9)
    return blocks.block("pad", np.linspace(0.7, BORE, 4), angles, order=order, mapping=mapping)


def joined(parts: list[BodyMesh], name: str) -> BodyMesh:
    """Parts with nodes in common as one body."""
    points = np.concatenate([part.points for part in parts])
    _, first, same = np.unique(
        np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    boundaries = {
        key: same[facets + start]
        for part, start in zip(parts, starts, strict=False)
        for key, facets in part.boundaries.items()
    }
    cells = [same[part.cells + start] for part, start in zip(parts, starts, strict=False)]
    whole = replace(parts[0], name=name, points=points[first], cells=np.concatenate(cells))
    return replace(whole, boundaries=boundaries)


def ramp(value: float) -> list[dict[str, Any]]:
    """History that goes to a value in one unit of time."""
    return [{"ramp": value, "until": 1.0, "steps": 2}]


def spinning(count: int, axis: Sequence[float] = (), **tables: Any) -> dict[str, Any]:
    """The case of so many blocks in one ring; of one block it is a sector."""
    names = ["pad"] if count == 1 else [f"pad{i}" for i in range(count)]
    line = {"axis": list(axis), "centre": [0, 0, 0]} if axis else {"centre": [0, 0]}
    suffixes = [name.removeprefix("pad") for name in names]
    return {
        "bodies": {name: STEEL for name in ("ring", *names)},
        "contacts": {
            f"main{suffix}": {
                "surface1": f"pad_right{suffix}",
                "surface2": f"ring_seat{suffix}",
                "friction": 0.4,
            }
            for suffix in suffixes
        },
        "loads": {"spin": {"type": "rotation", **line, "history": ramp(1.0)}},
        **tables,
    }


def cyclic(sectors: int = SECTORS, **keys: Any) -> dict[str, Any]:
    """The table of the sides of the ring."""
    sides = {"boundary1": "ring_bottom", "boundary2": "ring_top"}
    return {"sides": {"type": "cyclic", **sides, "sectors": sectors, "centre": [0, 0], **keys}}
