# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slip of the nodes around a station of a solid between two states, in the direction it has."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.edges.sector_slip import sector_border
from fretfe.edges.sectors import Sector
from fretfe.edges.slip import SlipBorder
from fretfe.edges.slip_zones import SMALLEST_SLIP, FindBorder
from fretfe.results.solution import OPEN, SLIP, ContactHistory
from fretfe.results.states import blocks


class SlipBetween:
    """Slip increments of a contact's nodes in steps, read once for all stations.

    Args:
        contact: one contact.
    """

    def __init__(self, contact: ContactHistory) -> None:
        self._contact = contact
        self._read: dict[tuple[int, int], tuple[Array, Bools]] = {}

    def steps(self, start: int, end: int) -> tuple[Array, Bools]:
        """(k, N, 3) slip in each step between two states, and (N,) nodes in contact at the end."""
        if (start, end) not in self._read:
            contact, parts = self._contact, []
            for part in blocks(end - start, contact.points.size):
                first, last = start + part.start, start + part.stop
                slipping = contact.status[first + 1 : last + 1] == SLIP
                slip = np.diff(contact.slip[first : last + 1], axis=0)
                slip = np.where(slipping[..., None], slip, 0.0)
                parts.append(np.einsum("knt,ntd->knd", slip, contact.frames[:, 1:]))
            closed = np.asarray(contact.status[end] != OPEN)
            self._read[start, end] = np.concatenate(parts), closed
        return self._read[start, end]

    def border_of(
        self, sector: Sector, place: Array, depth: float, outer: Bools | None = None
    ) -> FindBorder:
        """Slip zones at a station.

        Args:
            sector: around it.
            place: (T,) of the front, inward from the reference.
            depth: half of the width of the contact.
            outer: (T,) whether the slip in the step to each state counts; None if all of it does.
        """
        area = self._contact.weights[sector.nodes]

        def find(start: int, end: int) -> SlipBorder:
            steps, closed = self.steps(start, end)
            own = steps[:, sector.nodes]
            if outer is not None:
                own = own[outer[start + 1 : end + 1]]
            slip = _forward(own, (sector.fade * area)[closed[sector.nodes]], closed[sector.nodes])
            moved = closed[sector.nodes] & (slip > SMALLEST_SLIP * slip.max(initial=0.0))
            return sector_border(sector, float(place[end]), depth, slip, moved, area)

        return find


def _forward(steps: Array, weights: Array, closed: Bools) -> Array:
    """(m,) slip in the direction of the mean of it; increments the other way do not count.

    The step in which slip turns round still holds slip of the half cycle before.

    Args:
        steps: (k, m, 3) slip in each step.
        weights: (n,) of the nodes in contact.
        closed: (m,) which these are.
    """
    total = weights @ steps[:, closed].sum(axis=0)
    size = float(np.linalg.norm(total))
    if size == 0:
        return np.zeros(steps.shape[1])
    return np.asarray(np.maximum(steps @ (total / size), 0.0).sum(axis=0))
