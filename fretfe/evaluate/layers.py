# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges of contacts with a layer between the surfaces, within whose length E*/k p is no root.

K_N describes the pressure farther away. Fits see it as far as elements are longer than the layer's
length; the movement of the edge gives it in any case, 2 dK_I/da.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array

# Over the half-width a, on half-planes: K_N by fits is .2 % low with E*/k of .001 a and, over
# elements of .001 a, which see little else, 10 and 31 % with .003 and .01 a; over elements of .02 a
# .5 % with .01 a. By the movement of the edge it is 3 % low with .01 a, .5 % high with .03 and .3,
# 2 % with .1 a.
BY_FITS = 20.0
SEEN = 0.5
ELEMENTS = 10.0
BY_MOVEMENT = 0.04
THICK = 0.1
# Ranges of K_T are .03, .4 and 1.2 % lower with .001, .01 and .03 a.
SHEARED = 0.5
# P that differs by less has the same ratio of both values of K_N.
SAME_FORCE = 0.01


@dataclass(frozen=True)
class LayerAtEdge:
    """Lengths E*/k of a layer across and along the surface, at an edge.

    Attributes:
        across: that of pressure, over the half-width.
        along: that of shear, over the half-width.
        elements: the former over an element.
    """

    across: float
    along: float
    elements: float

    @property
    def range_error(self) -> float:
        """Relative error of ranges of K_T."""
        return SHEARED * max(self.across, self.along)

    def k_n(
        self, fitted: Array, spread: Array, moved: tuple[float, float, int], force: Array
    ) -> tuple[Array, Array]:
        """K_N (T,) of the pressure farther away, and its error bar.

        Args:
            fitted: (T,) by fits.
            spread: (T,) their error bars.
            moved: K_N by the movement of the edge around a state, its bar, and that state.
            force: (T,) P.
        """
        if not self.across:
            return fitted, spread
        seen = SEEN * min(self.elements / ELEMENTS, 1.0)
        bars = np.hypot(spread, (BY_FITS * self.across + seen) * fitted)
        k_n, bar, state = moved
        ratio = k_n / fitted[state]
        own = math.hypot(bar / k_n, BY_MOVEMENT, THICK * self.across) if k_n else math.inf
        if not own < bars[state] / fitted[state]:
            return fitted, bars
        other = np.abs(force / force[state] - 1) > SAME_FORCE
        relative = np.hypot(own, other * abs(1 / ratio - 1))
        return ratio * fitted, relative * ratio * fitted
