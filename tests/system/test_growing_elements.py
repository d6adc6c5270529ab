# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements that grow inward make bodies too stiff: the bars of K_N and of the edge hold that."""

from __future__ import annotations

import numpy as np
import pytest
from campaign.irregular_draw import IrregularDraw, irregular_case

import fretfe
from fretfe.analytic.profiles import edge_factor_k_n
from fretfe.case import parse_case


def pressed(
    profile: str, degree: int, growth: float, elements: float, tolerance: float | None
) -> IrregularDraw:
    """A contact of a = 1 that Q shears a little."""
    return IrregularDraw(
        number=0,
        profile=profile,
        flat=0.4,
        young=1e5,
        friction=0.5,
        varying="shear",
        repeats=False,
        points=((1.0, 0.1, 0.0),),
        steps=(1,),
        per_half_width=elements,
        degree=degree,
        growth=growth,
        zone=1.3,
        tolerance=tolerance,
    )


@pytest.mark.parametrize(
    ("profile", "degree", "growth", "elements", "tolerance", "largest"),
    # What the bars of K_N may be. They were .026 and the edges' .002 for errors of .04 and .02; on
    # meshes that refine themselves the edges' .0030 for .0033, and K_N's .0005 for .0009.
    [
        ("cylinder", 1, 0.45, 50.0, None, 0.1),
        ("flat_rounded", 1, 0.2, 50.0, None, 0.03),
        ("wedge", 2, 0.45, 50.0, None, 6e-3),
        ("cylinder", 1, 0.3, 10.0, 0.02, 0.02),
        ("wedge", 2, 0.3, 10.0, 0.05, 2e-3),
    ],
)
def test_bars_hold_the_stiffness_of_growing_elements(
    profile: str,
    degree: int,
    growth: float,
    elements: float,
    tolerance: float | None,
    largest: float,
) -> None:
    one = pressed(profile, degree, growth, elements, tolerance)
    stations = fretfe.run(parse_case(irregular_case(one))).contacts[0].stations
    exact = float(edge_factor_k_n(one.form, 1.0))
    half_width = np.ptp([station.position[-1] for station in stations]) / 2
    for station in stations:
        k_n, bar = station.decisive_k_n
        assert abs(k_n - exact) < bar < largest * exact
        assert abs(half_width - 1) < station.position_spread[-1]
