# SPDX-License-Identifier: LGPL-3.0-or-later
"""A mesh as it was read, handed from one process to another by a file of plain arrays."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.geometry.gmsh_model import ElementBlock, RawMesh

Blocks = Mapping[str, list[ElementBlock]]


def write_raw(path: Path, raw: RawMesh) -> None:
    """Write a mesh; `read_raw` reads it back."""
    arrays: dict[str, Any] = {"points": raw.points}

    def listed(groups: Blocks) -> list[Any]:
        table: list[Any] = []
        for name, blocks in groups.items():
            table.append([name, []])
            for block in blocks:
                arrays[f"block{len(arrays)}"] = block.nodes
                table[-1][1].append([block.gmsh_type, f"block{len(arrays) - 1}"])
        return table

    head = {
        "dimension": raw.dimension,
        "bodies": listed(raw.bodies),
        "boundaries": listed(raw.boundaries),
    }
    np.savez(path, head=np.array(json.dumps(head)), **arrays)


def read_raw(path: Path) -> RawMesh:
    """Read what `write_raw` has written; nothing in such a file is executed."""
    with np.load(path, allow_pickle=False) as file:
        head = json.loads(str(file["head"]))

        def blocks(table: list[Any]) -> dict[str, list[ElementBlock]]:
            return {
                name: [ElementBlock(kind, file[key]) for kind, key in parts]
                for name, parts in table
            }

        points: Array = file["points"]
        bodies, boundaries = blocks(head["bodies"]), blocks(head["boundaries"])
    return RawMesh(points, head["dimension"], bodies, boundaries)
