# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parts of a comparison of two results: pairs of numbers, of curves, of histories."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from fretfe._typing import Array


@dataclass(frozen=True)
class QuantityPair:
    """A number in both results.

    Attributes:
        contact: its name in the first result.
        edge: left or right; of solids a front, empty for a number of the whole contact.
        quantity: what it is.
        unit: of it.
        first, second: the two; NaN where unknown.
        first_spread, second_spread: error bars, half the width of a 95 % interval; NaN where
            unknown.
    """

    contact: str
    edge: str
    quantity: str
    unit: str
    first: float
    second: float
    first_spread: float = math.nan
    second_spread: float = math.nan

    @property
    def difference(self) -> float:
        """Of the second from the first one, relative to that; NaN if one is unknown or zero."""
        return self.second / self.first - 1 if self.first else math.nan

    @property
    def difference_spread(self) -> float:
        """Error bar of it by those of the two, as if they were independent."""
        if not self.first:
            return math.nan
        relative = self.second * self.first_spread / self.first
        return math.hypot(relative, self.second_spread) / abs(self.first)

    @property
    def agrees(self) -> bool | None:
        """True if the difference is within its error bar; None if that cannot be told."""
        if not (math.isfinite(self.difference) and math.isfinite(self.difference_spread)):
            return None
        return abs(self.difference) <= self.difference_spread

    def record(self) -> dict[str, Any]:
        """Everything by name."""
        return {
            **vars(self),
            "difference": self.difference,
            "difference_spread": self.difference_spread,
            "agrees": self.agrees,
        }


@dataclass(frozen=True)
class Curve:
    """Tractions of one result along a contact in one state; n nodes.

    Attributes:
        time: of the state.
        friction: coefficient in the step to the state.
        x: (n,) place along the contact.
        pressure, shear: (n,) means around the nodes.
    """

    time: float
    friction: float
    x: Array
    pressure: Array
    shear: Array


@dataclass(frozen=True)
class TractionPair:
    """Tractions of both results along a contact at a load extreme.

    Attributes:
        contact: its name in the first result.
        extreme: which one, in words.
        first, second: the two.
        pressure_difference: root of the integral of the squared difference of p, over that of p of
            the first one; NaN where the two do not overlap.
        shear_difference: the same of q, over that of f p of the first one; NaN without friction.
    """

    contact: str
    extreme: str
    first: Curve
    second: Curve
    pressure_difference: float
    shear_difference: float


@dataclass(frozen=True)
class HistoryPair:
    """A history in both results.

    Attributes:
        contact, edge, quantity, unit: as of `QuantityPair`.
        first_times, second_times: (T,) of each result.
        first, second: (T,) of each result.
        common: number of times that both results have, where both values are known.
        difference: largest difference at these times, over the largest value of the first one
            there; NaN without any.
    """

    contact: str
    edge: str
    quantity: str
    unit: str
    first_times: Array
    second_times: Array
    first: Array
    second: Array
    common: int
    difference: float
