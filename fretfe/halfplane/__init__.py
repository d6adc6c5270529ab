# SPDX-License-Identifier: LGPL-3.0-or-later
"""A semi-analytical solution of fretting contacts between half-planes. NumPy and SciPy only."""

from __future__ import annotations

from fretfe.halfplane.solver import HalfPlaneOutcome, contact_grid, solve_half_planes

__all__ = ["HalfPlaneOutcome", "contact_grid", "solve_half_planes"]
