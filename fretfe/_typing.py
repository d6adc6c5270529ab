# SPDX-License-Identifier: LGPL-3.0-or-later
"""Types of NumPy arrays; their shapes stand in the docstrings of those who use them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]
# What NumPy's searches return; the same as Indices on 64-bit systems.
Positions = NDArray[np.intp]
