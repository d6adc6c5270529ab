# SPDX-License-Identifier: LGPL-3.0-or-later
"""State of the contact nodes, and loads of a step."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import overload

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.interface import Interface
from fretfe.results.solution import OPEN, SLIP, STICK

Status = npt.NDArray[np.int8]

__all__ = ["OPEN", "SLIP", "STICK", "ContactState", "StepLoads", "StepTable", "unloaded"]


@dataclass(frozen=True)
class StepLoads:
    """Loads, prescribed amplitudes and friction at the end of a step.

    Attributes:
        amplitudes: (l,) load amplitudes.
        values: (m,) amplitude of each prescribed coordinate, force on each of the others.
        friction: (N,) coefficient at each node.
    """

    amplitudes: Array
    values: Array
    friction: Array

    def between(self, later: StepLoads, fraction: float) -> StepLoads:
        """Loads at a fraction of the way to a later step, with the later step's friction."""
        return replace(
            later,
            amplitudes=(1 - fraction) * self.amplitudes + fraction * later.amplitudes,
            values=(1 - fraction) * self.values + fraction * later.values,
        )


@dataclass(frozen=True)
class StepTable(Sequence[StepLoads]):
    """Loads of all T steps, the unloaded state first.

    Attributes:
        amplitudes: (T, l) load amplitudes.
        values: (T, m) as of `StepLoads`.
        friction: (T, C) coefficient in each contact.
        sizes: (C,) number of nodes of each contact.
    """

    amplitudes: Array
    values: Array
    friction: Array
    sizes: Indices

    def __len__(self) -> int:
        """T."""
        return len(self.values)

    @property
    def digest(self) -> str:
        """Text that is equal for the same loads."""
        found = hashlib.sha256(repr((self.amplitudes.shape, self.values.shape)).encode())
        for each in (self.amplitudes, self.values, self.friction):
            found.update(np.ascontiguousarray(each).tobytes())
        return found.hexdigest()

    @overload
    def __getitem__(self, number: int) -> StepLoads: ...

    @overload
    def __getitem__(self, number: slice) -> StepTable: ...

    def __getitem__(self, number: int | slice) -> StepLoads | StepTable:
        """Loads of one step, or of some."""
        parts = self.amplitudes[number], self.values[number]
        if isinstance(number, slice):
            return StepTable(*parts, self.friction[number], self.sizes)
        return StepLoads(*parts, np.repeat(self.friction[number], self.sizes))


@dataclass(frozen=True)
class ContactState:
    """Solution of the interface problem, in the weighted quantities of `interface`.

    Attributes:
        status: (N,) OPEN, STICK or SLIP.
        direction: (N, d-1) unit vector of the shear traction at slipping nodes, else zero.
        traction: (N, d) y: pressure, then shear on body 2.
        relative: (N, d) w: gap, then tangential displacement of body 2 relative to body 1.
        coordinates: (m,) c.
        forces: (m,) R.
    """

    status: Status
    direction: Array
    traction: Array
    relative: Array
    coordinates: Array
    forces: Array

    @property
    def closed(self) -> Bools:
        """(N,) nodes in contact."""
        return self.status != OPEN


def unloaded(interface: Interface) -> ContactState:
    """The state before the first step: bodies in place, no traction anywhere."""
    n, d, m = interface.size, interface.components, len(interface.coordinates)
    return ContactState(
        status=np.full(n, OPEN, np.int8),
        direction=np.zeros((n, d - 1)),
        traction=np.zeros((n, d)),
        relative=interface.gap.reshape(n, d),
        coordinates=np.zeros(m),
        forces=np.zeros(m),
    )
