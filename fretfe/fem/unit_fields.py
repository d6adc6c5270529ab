# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacement fields that interaction integrals need, each asked for once."""

from __future__ import annotations

import numpy as np

from fretfe.contact.neighbours import FRACTION
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState
from fretfe.fem.model import Request


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
        self._areas: dict[int, tuple[int, ...]] = {}

    def difference(self, low: ContactState, high: ContactState) -> int:
        """Number of the field by which two neighbours of the last state differ."""
        amplitudes = 2 * FRACTION * self._recorder.last_loads.amplitudes
        traction = (high.traction - low.traction).ravel()
        coordinates = high.coordinates - low.coordinates
        self.requests.append(Request(traction, coordinates, amplitudes))
        return len(self.requests) - 1

    def of_area(self, area: int) -> tuple[int, ...]:
        """Numbers of the fields of a contact area, one for each driver."""
        if area not in self._areas:
            increments, drivers = self._recorder.increments(area), self._recorder.drivers
            first, count = len(self.requests), len(drivers.names)
            loads = len(self._recorder.last_loads.amplitudes)
            for j in range(count):
                amplitudes = np.zeros(loads)
                if drivers.loads[j] >= 0:
                    amplitudes[drivers.loads[j]] = 1.0
                traction = increments.traction[:, :, j].ravel()
                request = Request(traction, increments.coordinates[:, j], amplitudes)
                self.requests.append(request)
            self._areas[area] = tuple(range(first, first + count))
        return self._areas[area]
