# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of a test, and their error bars by those of the factors that it is to have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fretfe._typing import Array
from fretfe.errors import ModelError
from fretfe.matching.casefile import pad_half_width
from fretfe.matching.pads import Factors, PadTest, pad_test
from fretfe.matching.rig import Rig
from fretfe.matching.target import Target

# The factors whose error bars are carried on.
FACTORS = ("k_n", "k_t_range", "k_i_range")


def numbers_of(test: PadTest, rig: Rig) -> dict[str, float]:
    """Numbers of a test, by name; NaN or infinite where it does not exist.

    Forces are per unit length of the pad; `slip_long` and `slip_short` are the slip zones at the
    high and at the low normal force.
    """
    long, short = test.slip
    return {
        "normal_force": test.normal_force,
        "normal_amplitude": test.normal_amplitude,
        "shear_amplitude": test.shear_amplitude,
        "half_width": test.half_width,
        "peak_pressure": test.peak_pressure,
        "shear_ratio": test.shear_ratio,
        "slip_long": long,
        "slip_short": short,
        "slip_over_length": long / test.governing_length,
        "asymptote_error": test.asymptote_error,
        "over_thickness": test.half_width / rig.specimen.thickness,
        "over_pad": test.half_width / pad_half_width(test, rig),
    }


def relative_bars(*targets: Target) -> dict[str, float]:
    """Relative error bars of the factors of edges, added as squares.

    ΔK_I comes from the same integrals as ΔK_T and is taken to have its relative error.
    """
    k_n = math.hypot(*(each.k_n_spread / each.k_n for each in targets))
    ranges = math.hypot(*(each.k_t_range_spread / each.k_t_range for each in targets))
    return {"k_n": k_n, "k_t_range": ranges, "k_i_range": ranges}


def number_spreads(test: PadTest, relative: Mapping[str, float], rig: Rig) -> dict[str, float]:
    """Error bars of the numbers of a test; NaN where they are not known.

    To first order, with the same pad: half of the difference between factors larger and smaller by
    their bars, of one factor after the other, added as squares.

    Args:
        test: pad and loads.
        relative: error bars of its factors, as those of `relative_bars`.
        rig: that it is for.
    """
    parts = []
    for name in FACTORS:
        value = getattr(test.factors, name)
        high, low = (
            _numbers_with(test, replace(test.factors, **{name: value * (1 + step)}), rig)
            for step in (relative[name], -relative[name])
        )
        with np.errstate(invalid="ignore"):
            parts.append((high - low) / 2)
    found = np.sqrt(np.sum(np.square(parts), axis=0))
    return dict(zip(numbers_of(test, rig), found.tolist(), strict=True))


def _numbers_with(test: PadTest, factors: Factors, rig: Rig) -> Array:
    """Numbers of the same pad with other factors; NaN where numbers cannot follow."""
    try:
        other = pad_test(test.profile, factors)
    except ModelError:
        return np.full(len(numbers_of(test, rig)), np.nan)
    return np.array(list(numbers_of(other, rig).values()))
