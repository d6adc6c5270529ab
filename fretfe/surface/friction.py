# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coulomb's coefficient on a contact surface; all stages ask here for it, by state and node."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.case.tables import Contact
from fretfe.surface.contact_surface import ContactSurface


def coefficients(contact: Contact, times: Array) -> Array:
    """(T,) coefficient of a contact of a case in the steps that end at some times (T,)."""
    return np.where(times > contact.friction_from, contact.friction, 0.0)


@dataclass(frozen=True, eq=False)
class Friction:
    """Coefficient in T states at the N nodes of a contact.

    That of a state acts in the step that ends there. Within a step it does not change, so that each
    step is an exact Coulomb problem.

    Attributes:
        fields: (U, N) coefficients at the nodes, for U different states of the surfaces.
        number: (T,) which of them each state has.
    """

    fields: Array
    number: Indices

    @classmethod
    def of(cls, contact: Contact, times: Array, surface: ContactSurface) -> Friction:
        """That of a contact of a case, for states at times (T,)."""
        return cls.uniform(coefficients(contact, times), len(surface.weights))

    @classmethod
    def uniform(cls, coefficients: Array, nodes: int) -> Friction:
        """The same coefficient (T,) at all of some nodes."""
        found, number = np.unique(coefficients, return_inverse=True)
        return cls(np.broadcast_to(found[:, None], (len(found), nodes)), number)

    def at(self, states: Any, nodes: Any = slice(None)) -> Array:
        """(S, N) coefficients in states (S,) at nodes (N,) or at all; (N,) in one state."""
        return np.asarray(self.fields[self.number[states]][..., nodes])

    def at_edge(self, nodes: Indices) -> Array:
        """(T,) coefficient at an edge that is at a node (T,) in each state."""
        return np.asarray(self.fields[self.number, nodes])

    def picked(self, states: Any) -> Friction:
        """Those of some states."""
        return replace(self, number=self.number[states])

    def of_nodes(self, nodes: Indices) -> Friction:
        """Those of some nodes, in their order."""
        return replace(self, fields=self.fields[:, nodes])

    def differs(self, other: Friction) -> Bools:
        """(T,) states in which the other one is different at some node."""
        pairs = (self.fields[:, None] != other.fields).any(axis=2)
        return np.asarray(pairs[self.number, other.number])

    @property
    def acts(self) -> Bools:
        """(T,) states in whose step there is friction at some node."""
        return np.asarray(self.fields.any(axis=1)[self.number])

    @property
    def largest(self) -> float:
        """Largest coefficient in any state."""
        return float(self.fields[self.number].max())
