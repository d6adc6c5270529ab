# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacement fields that interaction integrals need, each asked for once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretfe._typing import Bools
from fretfe.contact.full_stick import Increments
from fretfe.contact.neighbours import FRACTION
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState
from fretfe.fem.model import Request


def state_requests(recorder: Recorder | None, states: list[int]) -> list[Request] | None:
    """Requests for the fields of solved states; None on ranks without a recorder, all but 0."""
    if recorder is None:
        return None
    return [Request.of(state, loads) for state, loads in recorder.requests(states)]


class UnitFields:
    """Requests for the full-stick fields of contact areas, numbered; rank 0 only.

    Args:
        recorder: the solved history.

    Attributes:
        requests: the fields.
    """

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self.requests: list[Request] = []
        self._known: dict[int, tuple[int, ...]] = {}

    def difference(self, low: ContactState, high: ContactState) -> int:
        """Number of the field by which two neighbours of the last state differ."""
        amplitudes = 2 * FRACTION * self._recorder.last_loads.amplitudes
        traction = (high.traction - low.traction).ravel()
        coordinates = high.coordinates - low.coordinates
        self.requests.append(Request(traction, coordinates, amplitudes))
        return len(self.requests) - 1

    def of_area(self, area: int) -> tuple[int, ...]:
        """Numbers of the fields of a contact area, one for each driver."""
        if area not in self._known:
            self._known[area] = self._add(self._recorder.increments(area))
        return self._known[area]

    def of_areas(self, state: int, areas: Sequence[Bools]) -> tuple[int, ...]:
        """Numbers of the mean fields of contact areas around that of a state, one per driver.

        Args:
            state: number of the state.
            areas: for each area the nodes in contact (N,), of all contacts.
        """
        return self._add(self._recorder.mean_increments(state, areas))

    def _add(self, increments: Increments) -> tuple[int, ...]:
        drivers, first = self._recorder.drivers, len(self.requests)
        for j, load in enumerate(drivers.loads):
            amplitudes = np.zeros(len(self._recorder.last_loads.amplitudes))
            if load >= 0:
                amplitudes[load] = 1.0
            traction = increments.traction[:, :, j].ravel()
            self.requests.append(Request(traction, increments.coordinates[:, j], amplitudes))
        return tuple(range(first, len(self.requests)))
