# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts with known edge factors, for the tests of the extraction; a = 1, E* = 1."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from reference.halfplane_galerkin import Contact, graded_nodes, press, uniform_nodes

from fretfe._typing import Array
from fretfe.analytic._numerics import Side
from fretfe.analytic.profiles import FlatRounded, Hertz, edge_factor_k_n
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.plane.pressure_fit import fit_edge
from fretfe.evaluate.plane.section import plane_front, plane_sections

HERTZ = Hertz(radius=1.0, e_star=1.0)
HERTZ_LOAD = float(HERTZ.load(1.0))
K_N_HERTZ = float(edge_factor_k_n(HERTZ, 1.0))
FRICTION = 0.5
# Of the exact Galerkin solution, from its rigid motion: ln(a_eff/2) = -pi u/(2Q).
GALERKIN = 0.53
SIDES: tuple[Side, Side] = ("left", "right")
SIGN = {"left": -1.0, "right": 1.0}
both_sides = pytest.mark.parametrize("side", SIDES)
both_sizes = pytest.mark.parametrize("h", [0.02, 0.01])
phases = pytest.mark.parametrize("phase", [0.0, 0.3, 0.55, 0.8])


@cache
def hertz(h: float, phase: float) -> Contact:
    return press(uniform_nodes(h, phase), lambda x: x**4 / 24, HERTZ_LOAD)


@cache
def flat_rounded(flat: float, relative_h: float, phase: float) -> Contact:
    load = float(FlatRounded(flat, 1.0, 1.0).load(1.0))
    nodes = graded_nodes(relative_h * (1 - flat), 0.05, phase)
    return press(nodes, lambda x: np.maximum(np.abs(x) - flat, 0) ** 4 / 24, load)


def fitted(x: Array, p: Array, side: Side, *, solved: bool = False) -> EdgeFit:
    """The fit at one front; numbers for p (n,), arrays (...) for p (..., n)."""
    section = plane_sections(x, p.reshape(-1, x.size))[plane_front(side).number]
    fit = fit_edge(section, solved=solved)
    parts = (part.reshape(p.shape[:-1])[()] for part in vars(fit).values())
    return EdgeFit(*parts)


def fitted_edges(contact: Contact) -> tuple[float, float]:
    left, right = (fitted(contact.x, contact.pressure, side) for side in SIDES)
    return float(left.position), float(right.position)
