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
