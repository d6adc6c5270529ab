# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case of the plane section that solid bodies sweep."""

from __future__ import annotations

from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, Load, Support, parse_case, unit_vector
from fretfe.case.base import AXES
from fretfe.case.tables import Symmetry
from fretfe.mesh.sections import Sweep


def section_case(case: Case, sweep: Sweep) -> Case:
    """The case of a section in plane strain, under the loads over the length that all bodies have.

    What acts somewhere along the sweep acts all along it.

    Args:
        case: of the solids.
        sweep: of its bodies.

    Raises:
        CaseError: plane bodies have no such loads or supports.
    """
    tables = case.as_tables()
    tables["geometry"].pop("solid", None)
    tables.get("cycle", {}).pop("more", None)  # no cycles are added in the plane
    tables["model"] = {**tables.get("model", {}), "thickness": sweep.solid.shared(*case.bodies)}
    tables["edges"], tables["output"] = {"tolerance": case.edges.tolerance}, {"fields": "none"}
    for key, own in (("loads", case.loads), ("symmetry", case.symmetry)):
        for name, each in own.items():
            tables[key][name] |= _in_plane(each, sweep)
    along = [each["direction"] for each in tables["loads"].values() if "direction" in each]
    across = any(each == AXES[2] or (isinstance(each, list) and each[2:]) for each in along)
    held = {name: _held(each, sweep, across=across) for name, each in case.supports.items()}
    tables["supports"] = {name: each for name, each in held.items() if each}
    return parse_case(tables, case.source)


def _in_plane(table: Load | Symmetry, sweep: Sweep) -> dict[str, Any]:
    """Directions and places of a table, in the plane."""
    given = {key: getattr(table, key, None) for key in ("direction", "axis", "centre", "through")}
    found: dict[str, Any] = {
        key: sweep.in_plane(np.array([place]))[0, :2].tolist()
        for key, place in given.items()
        if key in ("centre", "through") and place is not None
    }
    if given["direction"] is not None:
        found["direction"] = _way(given["direction"], sweep)
    if given["axis"] is not None:
        found["axis"] = _turned(given["axis"], sweep).tolist()
    return found


def _turned(direction: str | tuple[float, ...], sweep: Sweep) -> Array:
    """(3,) a direction by the axes of the plane and across it."""
    # With the six digits that vectors are typed with; no zero is negative.
    return np.asarray(np.round(sweep.axes @ unit_vector(direction, 3), 6) + 0.0)


def _way(direction: str | tuple[float, ...], sweep: Sweep, *, either: bool = False) -> Any:
    """A direction, or either sense of it, as cases have it: the name of an axis, or a vector."""
    if isinstance(direction, str) and direction not in AXES:
        return direction  # that of a surface
    found = _turned(direction, sweep)
    if either:
        found *= np.sign(found[np.argmax(np.abs(found))])
    if found.max() == 1.0:
        return AXES[int(np.argmax(found))]
    return found[: 3 if found[2] else 2].tolist()


def _held(support: Support, sweep: Sweep, *, across: bool) -> dict[str, Any]:
    """A support in the plane, which holds along the sweep only where loads move bodies that way."""
    given = support.fix or (support.direction or "",)
    ways = AXES if {*AXES} <= {*given} else [_way(each, sweep, either=True) for each in given]
    kept = [each for each in ways if each != AXES[2] or across]
    if len(kept) == 1 and kept[0] not in AXES:
        return {"boundary": support.boundary, "direction": kept[0]}
    return {"boundary": support.boundary, "fix": kept} if kept else {}
