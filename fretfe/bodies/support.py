# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that finite elements cannot solve yet."""

from __future__ import annotations

from fretfe.case import Case

NO_SOLIDS = (
    "geometry.solid: expected a plane case, found a solid: contact in three dimensions is not "
    "solved yet; `fretfe mesh` writes the mesh",
)


def unsupported(case: Case) -> tuple[str, ...]:
    """Reasons why finite elements cannot solve a case; empty if they can."""
    return NO_SOLIDS if case.geometry.solid is not None else ()
