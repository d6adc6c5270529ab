# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random pairs of unlike half-planes: what is drawn."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

import numpy as np

from fretfe.case.bodies import Body
from fretfe.idealise.bodies import NORMAL, SIMILAR, dissimilarity


@dataclass(frozen=True)
class UnlikeDraw:
    """One pair, pressed on and then sheared about a mean.

    Attributes:
        number: of the pair; the seed of its draws.
        beta: Dundurs' second constant, of the largest magnitude for which limits are told.
        friction: coefficient.
        gripping: whether friction acts from the start; else only when the pair is pressed on.
        mean, amplitude: of Q over f P.
        tension: its amplitude, in phase with Q, over f p0.
        guided: whether the upper body is held against rotation.
        elements: of the grid.
    """

    number: int
    beta: float
    friction: float
    gripping: bool
    mean: float
    amplitude: float
    tension: float
    guided: bool
    elements: int

    @property
    def per_half_width(self) -> float:
        """Elements over the half-width."""
        return self.elements / 2


def draw_unlike(number: int) -> UnlikeDraw:
    """The pair of a number, of Young's moduli up to 5 apart and Poisson's ratios of .1 to .45."""
    random = np.random.default_rng(9000 + number)
    beta = next(found for found in (_beta(random) for _ in count()) if SIMILAR < abs(found) < 0.25)
    amplitude = float(random.uniform(0.05, 0.4))
    pulled = random.random() < 0.3
    return UnlikeDraw(
        number=number,
        beta=beta,
        friction=float(random.uniform(0.1, 1.0)),
        gripping=bool(random.random() < 0.4),
        mean=float(random.uniform(-1, 1) * (0.8 - amplitude)),
        amplitude=amplitude,
        tension=float(random.uniform(-0.3, 0.3)) if pulled else 0.0,
        guided=bool(random.random() < 0.7),
        elements=int(random.choice([100, 150, 220, 300])),
    )


def _beta(random: np.random.Generator) -> float:
    upper, lower = (
        Body(young=each, poisson=float(random.uniform(0.1, 0.45)))
        for each in (1e5, 1e5 * 5 ** random.uniform(-1.0, 1.0))
    )
    return dissimilarity(upper, lower, "strain", NORMAL)
