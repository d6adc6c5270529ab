# SPDX-License-Identifier: LGPL-3.0-or-later
"""The interface operator: the linear algebra that contact is solved with, as named operations.

Newton's method, its fallback and the full-stick increments state conditions on nodes and
coordinates. Whoever implements these protocols decides how the linear systems behind them are
factorised and solved, and what is kept from one contact area to the next; the only implementation
is `fretfe.contact.factored`.

Right-hand sides and solutions have a last axis of J cases that are solved at once. N, d and m are
those of `fretfe.contact.interface`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import NDArray

from fretfe._typing import Array, Bools
from fretfe.contact.interface import Interface
from fretfe.contact.state import Status


@dataclass(frozen=True)
class Conditions:
    """Linear conditions that take the place of full stick.

    A node with pressure p, shear q, gap g and increment Δ is

    * open: p = 0, q = 0;
    * stuck: g = 0, Δ = 0;
    * slipping: g = 0, q = p `pull` + `turning` (q − r Δ).

    Attributes:
        status: (N,) OPEN, STICK or SLIP.
        pull: (N, d-1) friction coefficient times direction of the shear; read at slipping nodes.
        turning: (N, d-1, d-1) derivative of the direction times the friction bound; read at
            slipping nodes, in three dimensions only: in the plane a direction cannot turn.
        penalty: (N,) r.
        known: (m,) coordinates of known amplitude; on the others the force is known.
        amplitudes: (k, J) the known amplitudes.
        floating: True if bodies can move without any resistance. The loads must then be in
            equilibrium, and the solution is one of many that differ in such motions only.
    """

    status: Status
    pull: Array
    turning: Array
    penalty: Array
    known: Bools
    amplitudes: Array
    floating: bool = False


@dataclass(frozen=True)
class Response:
    """Solution of linear contact conditions.

    Attributes:
        traction: (N, d, J) y.
        relative: (N, d, J) gap and increment Δ; where they are released or stuck as the conditions
            have it, not as the bodies' displacements give it.
        coordinates: (m, J) c.
        residual: what is left of the right-hand sides, relative to them, if bodies can move without
            any resistance: zero but for round-off if the loads are in equilibrium.
    """

    traction: Array
    relative: Array
    coordinates: Array
    residual: float = 0.0


class StuckContact(Protocol):
    """A loaded interface in full stick."""

    @property
    def coordinates(self) -> Array:
        """(m, J) c with the prescribed ones at rest; of many solutions the smallest."""

    def release(self, conditions: Conditions) -> Response:
        """Let go of whatever the conditions do not hold.

        Args:
            conditions: stick or slip within the contact area only.

        Raises:
            numpy.linalg.LinAlgError: if the conditions leave a motion without any resistance. Where
                round-off resists it, it is out of all proportion to that in full stick.
        """


class ContactArea(Protocol):
    """The nodes in contact, and open ones that may close soon."""

    def stuck(self, free: Array, forces: Array) -> StuckContact:
        """Full stick of the area under loads.

        Args:
            free: (N, d, J) gap and increment without tractions and coordinates.
            forces: (m, J) forces on the coordinates, R + H a; where the amplitude is known they
                make no difference.
        """


class Regularised(Protocol):
    """The bodies with an elastic layer between them, every node sticking to it.

    Prescribed coordinates do not move; the layer's compliance is the penalty.
    """

    def tractions(self, displacement: Array, forces: Array) -> Array:
        """(N*d,) tractions that give a displacement.

        Args:
            displacement: (N*d,) w − w0 of bodies and layer together.
            forces: (k,) forces on the k coordinates that are not prescribed, −(R + H a).
        """


class InterfaceOperator(Protocol):
    """Solves linear systems of an interface problem; see the module's docstring."""

    @property
    def interface(self) -> Interface:
        """The interface problem."""

    def area(self, closed: Bools, gap: Array) -> ContactArea:
        """Stuck system of a contact area; the same object while it serves this area too.

        Args:
            closed: (N,) nodes in contact.
            gap: (N,) tells which of the other nodes are likely to close next.
        """

    def regularised(self, penalty: float) -> Regularised:
        """Bodies with an elastic layer between them.

        Args:
            penalty: compliance of the layer, in the unit of A.
        """

    def memory(self) -> dict[str, NDArray[Any]]:
        """Numbers by name that say with which round-off it goes on."""

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Go on as the operator, of the same interface, whose `memory` is given."""
