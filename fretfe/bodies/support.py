# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that finite elements cannot solve yet."""

from __future__ import annotations

from fretfe.case import Case

NO_REFINEMENT = (
    "edges: expected a plane case, found a solid: a mesh of solids does not refine itself yet; "
    "leave the table [edges] out and set the element sizes of the geometry"
)


def unsupported(case: Case) -> tuple[str, ...]:
    """Reasons why finite elements cannot solve a case; empty if they can."""
    solid = case.geometry.solid is not None
    return (NO_REFINEMENT,) if solid and case.edges is not None else ()
