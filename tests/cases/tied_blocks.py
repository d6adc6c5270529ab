# SPDX-License-Identifier: LGPL-3.0-or-later
"""Decks of rectangular blocks of four-node elements, several of which may be one body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fretfe._typing import Array
from fretfe.case import Case, parse_case

# Numbers of nodes and elements of a block are larger than those of the blocks before it.
STRIDE = 10_000
SIDES = {"bottom": 1, "right": 2, "top": 3, "left": 4}


@dataclass(frozen=True)
class Block:
    """A rectangle with grid lines; its sides are `NAME_bottom`, `_right`, `_top` and `_left`."""

    body: str
    name: str
    x: Array
    y: Array


def write_deck(path: Path, blocks: Sequence[Block], more: str = "") -> None:
    """Write blocks as a deck, and what else it has."""
    nodes, elements, surfaces = [], [], []
    for place, block in enumerate(blocks, start=1):
        first, columns, rows = place * STRIDE, len(block.x), len(block.y)
        nodes += [
            f"{first + j * columns + i}, {float(x)!r}, {float(y)!r}"
            for j, y in enumerate(block.y) for i, x in enumerate(block.x)
        ]  # fmt: skip
        elements.append(f"*ELEMENT, TYPE=CPE4, ELSET={block.body}")
        numbers = {}
        for j in range(rows - 1):
            for i in range(columns - 1):
                corner = first + j * columns + i
                numbers[i, j] = corner
                around = (corner, corner + 1, corner + columns + 1, corner + columns)
                elements.append(", ".join(map(str, (corner, *around))))
        last = {"bottom": (1, 0), "top": (1, rows - 2), "left": (0, 0), "right": (0, columns - 2)}
        for side, number in SIDES.items():
            axis, place_of = last[side]
            surfaces.append(f"*SURFACE, NAME={block.name}_{side}")
            surfaces += [f"{n}, S{number}" for at, n in numbers.items() if at[axis] == place_of]
    path.write_text("\n".join(["*NODE", *nodes, *elements, *surfaces, more]))


def pressed_case(path: Path, top: str, **tables: Any) -> Case:
    """A pad with the lower side `low_bottom` on a block, pressed by 10 on its boundary `top`."""
    body = {"young": 200e3, "poisson": 0.3}
    contact = {"surface1": "low_bottom", "surface2": "block_top", "friction": 0.3}
    press = {"ramp": -10.0, "until": 1.0, "steps": 1}
    data = {
        "geometry": {"file": path.name},
        "bodies": {"pad": body, "block": body},
        "contacts": {"main": contact},
        "supports": {
            "base": {"boundary": "block_bottom", "fix": ["y"]},
            "side": {"boundary": "block_left", "fix": ["x"]},
        },
        "loads": {"press": {
            "type": "traction", "boundary": top, "direction": "normal", "history": [press]}},
        "output": {"fields": "none"},
    }  # fmt: skip
    return parse_case({**data, **tables}, path.with_suffix(".toml"))
