# SPDX-License-Identifier: LGPL-3.0-or-later
"""Supports and loads that hold boundaries, and what they carry of other loads there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from fretfe.case.base import AXES, unit_vector
from fretfe.case.loads import Along, Load
from fretfe.case.tables import Support

# Sine of the angle by which two platen directions may miss a right angle: vectors typed with six
# digits pass, a slip of a degree does not.
ORTHOGONALITY = 1e-5


class Holder(NamedTuple):
    """A table that holds a boundary, or moves it by more than a force.

    Attributes:
        key: of the table.
        boundary: that is held.
        directions: unit vectors (3,) at right angles along which it is held, or of a platen those
            in which forces move it.
        platen: whether it is held across its directions, not along them.
    """

    key: str
    boundary: str
    directions: tuple[tuple[float, ...], ...]
    platen: bool = False

    def carries(self, force: tuple[float, ...]) -> tuple[float, ...]:
        """The part (3,) of a force (3,) that it carries."""
        rest = force
        for each in self.directions:
            size = sum(a * b for a, b in zip(force, each, strict=True))
            rest = tuple(a - size * b for a, b in zip(rest, each, strict=True))
        return rest if self.platen else tuple(a - b for a, b in zip(force, rest, strict=True))

    def carried(self, direction: Along) -> str:
        """Complaint about a load on its boundary along a direction that it holds; else empty."""
        part = self.carries(unit_vector(direction, 3))
        if not (share := round(math.hypot(*part), 2)):  # of digits that were typed
            return ""
        axes = [axis for axis, size in zip(AXES, part, strict=True) if abs(size) > ORTHOGONALITY]
        return (
            f"expected a load that moves its boundary, found that it acts on {self.boundary!r}, "
            f"which {self.key} holds along {axes[0] if len(axes) == 1 else shown(part)}: that "
            f"carries {share:.0%} of it; let it go there, or load another boundary"
        )


def holders(supports: Mapping[str, Support], loads: Mapping[str, Load]) -> Iterator[Holder]:
    """All that holds a boundary along directions that are the same everywhere."""
    for name, support in supports.items():
        own = [axis for axis in support.fix if axis in AXES]
        vectors = [unit_vector(each, 3) for each in (*own, support.direction) if each is not None]
        yield Holder(f"supports.{name}", support.boundary, tuple(vectors))
    for on, name in platens(loads).items():
        platen = [each for each in loads.values() if each.rigid and each.on == on]
        forces = tuple(unit_vector(each.push, 3) for each in platen if each.push)
        yield Holder(f"loads.{name}", on, forces, platen=True)
    for name, load in loads.items():
        if load.moves and load.on:
            along = () if load.along is None else (unit_vector(load.along, 3),)
            yield Holder(f"loads.{name}", load.on, along, platen=load.along is None)


def platens(loads: Mapping[str, Load]) -> dict[str, str]:
    """Platen boundaries and the first load of each."""
    platens: dict[str, str] = {}
    for name, load in loads.items():
        if load.rigid:
            platens.setdefault(load.on, name)
    return platens


def shown(direction: Along) -> str:
    """A direction as a case file has it, with six digits."""
    if isinstance(direction, str):
        return repr(direction)
    return "[" + ", ".join(f"{component:.6g}" for component in direction) + "]"
