# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a check of template parameters is, and bounds on one of them with their reason."""

from __future__ import annotations

from collections.abc import Callable, Mapping

Check = Callable[[Mapping[str, float]], str | None]

# Bodies must stay apart by this fraction of the neck width outside the contact surfaces, far more
# than elastic displacements.
NECK_CLEARANCE = 0.01


def at_least(name: str, values: Mapping[str, float], bound: float, why: str) -> str | None:
    """What is wrong with a parameter that is below a bound, with the reason for the bound."""
    if values[name] >= bound:
        return None
    return f"{name}: expected at least {bound:.6g} ({why}), found {values[name]:g}"


def at_most(name: str, values: Mapping[str, float], bound: float, why: str) -> str | None:
    """What is wrong with a parameter that is above a bound, with the reason for the bound."""
    if values[name] <= bound:
        return None
    return f"{name}: expected at most {bound:.6g} ({why}), found {values[name]:g}"
