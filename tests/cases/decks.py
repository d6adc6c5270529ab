# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of Abaqus decks."""

from __future__ import annotations

# Two rows of three squares, one on the other: x from 0 to 3, y from 0 to 1 and from 1 to 2.
NODES = "".join(
    f"{first + 4 * row + column}, {column}., {row + height}.\n"
    for first, height in ((1, 0), (21, 1))
    for row in range(2)
    for column in range(4)
)
LOW, UP = (
    "".join(f"{n}, {n}, {n + 1}, {n + 5}, {n + 4}\n" for n in range(first, first + 3))
    for first in (1, 21)
)


def solid_deck() -> str:
    """Two cubes, 1 and 2, one on the other along y: nodes 1 to 8, and 11 to 18."""
    square = ((0, 0), (1, 0), (1, 1), (0, 1))
    corners = [(x, y, z) for z in (0, 1) for x, y in square]
    nodes = "".join(
        f"{10 * body + number}, {x}., {y + body}., {z}.\n"
        for body in (0, 1)
        for number, (x, y, z) in enumerate(corners, start=1)
    )
    cells = "".join(
        f"*ELEMENT, TYPE=C3D8, ELSET={name}\n{body + 1}, "
        + ", ".join(str(10 * body + number) for number in range(1, 9))
        + "\n"
        for body, name in enumerate(("LOW", "UP"))
    )
    return f"*NODE\n{nodes}{cells}"
