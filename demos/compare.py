# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the scripts in this folder end with: computed against expected values.

Under MPI every process calls these, and the first one prints.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import dataclass

from fretfe.environment import rank_from_environment


@dataclass(frozen=True)
class Row:
    """A computed value, what it should be, and how far it may be off relative to that."""

    name: str
    computed: float
    expected: float
    tolerance: float

    @property
    def difference(self) -> float:
        """Relative difference."""
        return abs(self.computed - self.expected) / abs(self.expected)

    @property
    def agrees(self) -> bool:
        """Whether the difference is within the tolerance; never if a value is NaN."""
        return self.difference <= self.tolerance


def finish(rows: Iterable[Row]) -> None:
    """Print all rows and end the script, with status 1 if one of them is off."""
    listed = list(rows)
    if rank_from_environment() == 0:
        print(f"\n{'':44s} {'computed':>12s} {'expected':>12s} {'difference':>11s}  allowed")
        for row in listed:
            verdict = "" if row.agrees else "  <-- off"
            print(
                f"{row.name:44s} {row.computed:12.6g} {row.expected:12.6g} {row.difference:11.3%}"
                f"  {row.tolerance:.2%}{verdict}"
            )
    sys.exit(0 if all(row.agrees for row in listed) else 1)
