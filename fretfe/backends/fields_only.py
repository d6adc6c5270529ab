# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a case asks for that takes fields of the bodies."""

from __future__ import annotations

from fretfe.case import Case


def field_obstacles(case: Case) -> tuple[str, ...]:
    """Reasons why a backend without fields cannot do what a case asks for."""
    if not case.output.stress_depths:
        return ()
    return ("output.stress_depths: only the backend 'fem' computes the stress near the contacts",)
