# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that a backend cannot solve, those of finite elements among them."""

from __future__ import annotations

from collections.abc import Sequence

from fretfe.case import Case
from fretfe.errors import ModelError

NO_SOLIDS = (
    "geometry.solid: expected a plane case, found a solid: contact in three dimensions is not "
    "solved yet; `fretfe mesh` writes the mesh",
)


def unsupported(case: Case) -> tuple[str, ...]:
    """Reasons why finite elements cannot solve a case; empty if they can."""
    return NO_SOLIDS if case.geometry.solid is not None else ()


def require_support(backend: str, case: Case, reasons: Sequence[str]) -> None:
    """Raise the reasons why a backend cannot solve a case, if there are any.

    Raises:
        ModelError: with all of them.
    """
    if reasons:
        raise ModelError(
            f"{case.source}: the backend {backend!r} cannot solve this case:\n"
            + "\n".join(f"  {reason}" for reason in reasons)
        )
