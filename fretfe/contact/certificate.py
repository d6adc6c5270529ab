# SPDX-License-Identifier: LGPL-3.0-or-later
"""Violations of the contact conditions in an accepted step, in physical units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.contact.interface import Interface
from fretfe.contact.state import OPEN, SLIP, STICK, ContactState, StepLoads


@dataclass(frozen=True)
class Certificate:
    """Largest violations of the contact conditions in one step; zero is perfect.

    Lengths in the length unit, tractions in the stress unit.

    Attributes:
        penetration: largest penetration of a nodal mean gap.
        adhesion: largest tension at a node.
        open_traction: largest traction at an open node.
        closed_gap: largest gap at a node in contact.
        cone: largest excess of the shear over f times the pressure.
        stuck_drift: largest movement of a stuck node in this step.
        slip_with_traction: largest slip increment along, or across, the traction it should oppose.
        dissipation: friction work of the step per unit thickness (must not be negative).
        pressure_scale: largest pressure, the scale of the tractions.
        gap_scale: largest gap or displacement by a coordinate, the scale of the lengths.
    """

    penetration: float
    adhesion: float
    open_traction: float
    closed_gap: float
    cone: float
    stuck_drift: float
    slip_with_traction: float
    dissipation: float
    pressure_scale: float
    gap_scale: float

    @property
    def worst(self) -> float:
        """Largest violation relative to its scale."""
        tractions = max(self.adhesion, self.open_traction, self.cone)
        lengths = max(self.penetration, self.closed_gap, self.stuck_drift, self.slip_with_traction)
        return max(tractions / self.pressure_scale, lengths / self.gap_scale)


def certify(
    interface: Interface, loads: StepLoads, state: ContactState, reference: Array
) -> Certificate:
    """Check a state against the contact conditions.

    Args:
        interface: the interface problem.
        loads: loads of the step.
        state: solution at the end of the step.
        reference: (N, d-1) tangential displacement before the step.
    """
    roots = interface.roots[:, None]
    traction, relative = state.traction / roots, state.relative / roots
    increment = relative[:, 1:] - reference / roots
    pressure, shear = traction[:, 0], np.linalg.norm(traction[:, 1:], axis=1)
    gap = relative[:, 0]
    motion = (interface.motion * state.coordinates).reshape(*relative.shape, -1) / roots[..., None]
    opened, stuck, slipping = (state.status == s for s in (OPEN, STICK, SLIP))
    along = np.einsum("ij,ij->i", increment, state.direction)
    directed = np.any(state.direction != 0, axis=1)  # without friction there is no direction
    across = np.linalg.norm(increment - along[:, None] * state.direction, axis=1)
    astray = np.where(directed, np.maximum(along, across), 0.0)
    return Certificate(
        penetration=_largest(-gap),
        adhesion=_largest(-pressure),
        open_traction=_largest(np.abs(traction[opened]).ravel()),
        closed_gap=_largest(np.abs(gap[~opened])),
        cone=_largest(shear - loads.friction * np.maximum(pressure, 0.0)),
        stuck_drift=_largest(np.abs(increment[stuck]).ravel()),
        slip_with_traction=_largest(astray[slipping]),
        dissipation=dissipation(state, reference).sum(),
        pressure_scale=max(_largest(pressure), np.finfo(float).tiny),
        gap_scale=max(
            _largest(np.abs(relative).ravel()),
            _largest(np.abs(motion).ravel()),
            np.finfo(float).tiny,
        ),
    )


def dissipation(state: ContactState, reference: Array) -> Array:
    """(N,) friction work done at each node while it moved from the reference, per unit thickness.

    The shear at the end of the step counts: a node slips only while its shear is on the bound.
    """
    increment = state.relative[:, 1:] - reference
    return -np.einsum("ij,ij->i", state.traction[:, 1:], increment)


def _largest(values: Array) -> float:
    return float(max(values.max(initial=0.0), 0.0))
