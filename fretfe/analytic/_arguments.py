# SPDX-License-Identifier: LGPL-3.0-or-later
"""Range checks of arguments: each error names the argument, its valid range and the value found."""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array

Side = Literal["left", "right"]


def check_range(
    name: str,
    value: ArrayLike,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    open_low: bool = False,
) -> Array:
    """Return ``value`` as a float array if every entry lies in the range.

    Args:
        name: name of the argument, used in the message.
        value: scalar or array of any shape.
        low: smallest valid value.
        high: largest valid value (included).
        open_low: whether ``low`` itself is excluded.

    Raises:
        ValueError: if an entry is outside the range or not a number.
    """
    array = np.asarray(value, dtype=np.float64)
    above = array > low if open_low else array >= low
    valid = above & (array <= high)
    if not np.all(valid):
        found = array[~valid].flat[0]
        bracket = "(" if open_low or low == -math.inf else "["
        close = ")" if high == math.inf else "]"
        raise ValueError(f"{name} must lie in {bracket}{low:g}, {high:g}{close}, found {found:g}")
    return array


def check_positive(name: str, value: ArrayLike) -> Array:
    """Return ``value`` as a float array of any shape if every entry is positive.

    Raises:
        ValueError: if an entry is zero, negative or not a number.
    """
    return check_range(name, value, low=0.0, open_low=True)


def side_sign(side: Side) -> float:
    """Return +1 at the left edge and -1 at the right one: the direction inward along x.

    Raises:
        ValueError: if ``side`` is neither "left" nor "right".
    """
    if side not in get_args(Side):
        raise ValueError(f"side must be 'left' or 'right', found {side!r}")
    return 1.0 if side == "left" else -1.0
