# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors and slip zones from sampled tractions, whatever computed them.

A contact is sampled at arc positions ``x`` (n,), increasing; ``p``, ``q`` (n,) are the nodal values
of piecewise-linear pressure and shear, zero at nodes out of contact. Conventions of
``fretfe.analytic.edges``. Next to an edge nodal values oscillate, integrals do not: singular
tractions are fitted through the cumulative force, and all fits leave out the outermost nodes.

Each fit is made over many windows. Those whose estimated error is within a factor 2 of the best are
kept, the result is their median, and the spread is made of their range and standard error
(``consensus``). It does not see an error that all windows share. Where no window holds enough
nodes, the result is NaN with an infinite spread.

The functions that fit take many states or increments at once, as leading axes.
"""

from __future__ import annotations

from fretfe.analytic._arguments import Side
from fretfe.edges.bonded import (
    OVERHANG,
    BondedFit,
    bonded_factors,
    edge_factor_k_t,
    effective_edges,
    effective_overhang,
)
from fretfe.edges.patches import Patch, Resultants, contact_patches, main_patch, resultants
from fretfe.edges.pressure import EdgeFit, fit_edge
from fretfe.edges.slip import (
    PredictedSlip,
    SlipBorder,
    cycle_change,
    predicted_slip,
    slip_border,
)

__all__ = [
    "OVERHANG",
    "BondedFit",
    "EdgeFit",
    "Patch",
    "PredictedSlip",
    "Resultants",
    "Side",
    "SlipBorder",
    "bonded_factors",
    "contact_patches",
    "cycle_change",
    "edge_factor_k_t",
    "effective_edges",
    "effective_overhang",
    "fit_edge",
    "main_patch",
    "predicted_slip",
    "resultants",
    "slip_border",
]
