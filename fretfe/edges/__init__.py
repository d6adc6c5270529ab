# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors and slip zones from sampled tractions, whatever computed them.

A contact is sampled at arc positions ``x`` (n,), increasing; ``p``, ``q`` (n,) are the nodal values
of piecewise-linear pressure and shear, zero at nodes out of contact. Conventions of
``fretfe.analytic.edges``. ``analyse_tractions`` does everything for one state of any contact; the
functions that fit take many states or increments at once, as leading axes.

Next to an edge nodal values oscillate, integrals do not. Fits of the pressure weight the nodes by
that error and by the noise; singular tractions are fitted through the cumulative force. Each fit is
made over many windows and in several orders. Those of the pressure and of the slip are averaged by
their estimated errors (``average``), those of bonded increments agree on a median (``consensus``).
Where no window holds enough nodes, the result is NaN with an infinite spread.
"""

from __future__ import annotations

from fretfe.analytic._arguments import Side
from fretfe.edges.full_stick import (
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
from fretfe.edges.tractions import (
    EdgeAnalysis,
    Estimate,
    TractionAnalysis,
    analyse_tractions,
)

__all__ = [
    "OVERHANG",
    "BondedFit",
    "EdgeAnalysis",
    "EdgeFit",
    "Estimate",
    "Patch",
    "PredictedSlip",
    "Resultants",
    "Side",
    "SlipBorder",
    "TractionAnalysis",
    "analyse_tractions",
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
