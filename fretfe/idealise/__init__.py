# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a case to one of fewer dimensions: two half-planes, or the section that solids sweep."""

from __future__ import annotations

from fretfe.idealise.case import NotIdealisable, idealise, obstacles
from fretfe.idealise.problem import HalfPlaneProblem

__all__ = ["HalfPlaneProblem", "NotIdealisable", "idealise", "obstacles"]
