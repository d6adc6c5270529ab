# SPDX-License-Identifier: LGPL-3.0-or-later
"""The two states between which a load cycle swings, which pictures and fields show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretfe._typing import Array

# Shear factors that vary by less than this fraction of the normal ones are round-off.
SMALLEST_SHEAR = 1e-3


def load_extremes(
    k_t: Sequence[Array], k_i: Sequence[Array], cycle: Sequence[int] | None
) -> list[int]:
    """States of the largest and the smallest load in the evaluated cycle.

    The load is K_T of the station where K_T varies most; where none feels shear, K_I likewise.

    Args:
        k_t: (T,) K_T of each station that is to be shown, stress·√length; NaN where there is none.
        k_i: (T,) K_I likewise.
        cycle: its first and last state; None for the whole history without the unloaded state.

    Returns:
        Two states in the order of time, or the last state alone if the load is constant: the last
        one in which it is known.
    """
    first, last = cycle or (1, len(k_t[0]) - 1)
    shear, normal = (np.array(each)[:, first : last + 1] for each in (k_t, k_i))
    ranges = [np.array([_range(each) for each in loads]) for loads in (shear, normal)]
    sheared = ranges[0].max() > SMALLEST_SHEAR * ranges[1].max()
    load = shear[ranges[0].argmax()] if sheared else normal[ranges[1].argmax()]
    known = first + np.flatnonzero(np.isfinite(load))
    if not len(known):
        return [last]
    load = load[known - first]
    states = {int(known[load.argmax()]), int(known[load.argmin()])}
    return sorted(states) if len(states) == 2 else [int(known[-1])]


def _range(load: Array) -> float:
    """Range where a load is known; below zero where it never is."""
    known = load[np.isfinite(load)]
    return float(np.ptp(known)) if len(known) else -1.0
