# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of solved contacts: edge factors and slip zones from tractions, whoever computed them.

A *front* is a boundary curve of a contact area, a *station* a point of it with a frame (inward,
along, across). In the plane a contact has two fronts, left and right, of one station each: its
edges. *Full stick* is the contact area of a state with all slip prevented; its tractions are
singular at the fronts, with the factors K_I, K_T and K_S of pressure, inward and along shear. Where
sticking nodes meet slipping ones is a *border*; between front and border lies a *slip zone*.

Fits take a *section*: distances s >= 0 from a front inward, and values there (``plane.section``).
They take many states or increments at once, as leading axes. ``analyse_tractions`` does everything
for one state of a plane contact, sampled at arc positions ``x`` (n,), increasing; ``p``, ``q`` (n,)
are nodal values of piecewise-linear pressure and shear, zero at nodes out of contact. Conventions
of ``fretfe.analytic.edges``. ``evaluate.evaluate`` does it for all states of a solved history.

Next to a front nodal values oscillate, integrals do not. Fits of the pressure weight the nodes by
that error and by the noise; singular tractions are fitted through the cumulative force. Each fit is
made over many windows and in several orders. Those of the pressure and of the slip are averaged by
their estimated errors, those of full stick agree on a median (``numerics``). Where no window holds
enough nodes, the result is NaN with an infinite spread.
"""

from __future__ import annotations

from fretfe.evaluate.sampled_tractions import (
    EdgeAnalysis,
    Estimate,
    TractionAnalysis,
    analyse_tractions,
)

__all__ = ["EdgeAnalysis", "Estimate", "TractionAnalysis", "analyse_tractions"]
