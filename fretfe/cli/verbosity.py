# SPDX-License-Identifier: LGPL-3.0-or-later
"""How much the commands print."""

from __future__ import annotations

from enum import Enum


class Verbosity(Enum):
    """Warnings and errors only, the usual, or every step and all timings."""

    QUIET = "quiet"
    NORMAL = "normal"
    VERBOSE = "verbose"
