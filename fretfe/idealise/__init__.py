# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a case to the half-plane problem that it resembles, or the reasons why there is none."""

from __future__ import annotations

from fretfe.idealise.case import NotIdealisable, idealise, obstacles
from fretfe.idealise.problem import HalfPlaneProblem

__all__ = ["HalfPlaneProblem", "NotIdealisable", "idealise", "obstacles"]
