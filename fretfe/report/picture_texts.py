# SPDX-License-Identifier: LGPL-3.0-or-later
"""States and numbers in titles and captions of pictures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# More loads than this are not named in a title.
MOST_LOADS = 3
# Waves pass through zero up to this fraction of their amplitude.
ROUND_OFF = 1e-12


def rounded(value: float) -> str:
    """A number with three digits; no exponent where it can do without."""
    return f"{float(f'{value:.3g}'):.6g}"


def time_text(numbers: Mapping[str, Any], state: int) -> str:
    """The time of a state, with its unit."""
    return f"t = {numbers['times'][state]:.6g} {numbers['units']['time']}"


def load_text(numbers: Mapping[str, Any], state: int) -> str:
    """The values of the loads at a state, if they are not too many."""
    loads = numbers["loads"]
    if len(loads) > MOST_LOADS:
        return ""
    largest = {name: max(map(abs, values)) for name, values in loads.items()}
    shown = {
        name: values[state] if abs(values[state]) > ROUND_OFF * largest[name] else 0.0
        for name, values in loads.items()
    }
    return ", ".join(f"{name} = {value:.5g}" for name, value in shown.items())
