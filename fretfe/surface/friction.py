# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coulomb's coefficient on a contact surface; all stages ask here for it, by state and node."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.errors import CaseError
from fretfe.loads.friction import Coefficients
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.placed import nearest, on_arc


@dataclass(frozen=True, eq=False)
class Friction:
    """Coefficient in T states at the N nodes of a contact.

    That of a state acts in the step that ends there. Within a step it does not change, so that each
    step is an exact Coulomb problem.

    Attributes:
        fields: (U, N) coefficients at the nodes, for U different states of the surfaces.
        number: (T,) which of them each state has.
        by_pressure: (2, n) pressures, and coefficients over the largest of these, by which the
            coefficient of a step is that of `fields` times the value at the pressure before it;
            None where `fields` are the coefficients.
    """

    fields: Array
    number: Indices
    by_pressure: Array | None = None

    @classmethod
    def of(
        cls,
        given: Coefficients,
        times: Array,
        surface: ContactSurface,
        temperature: Array | None = None,
    ) -> Friction:
        """That of a contact of a case, for states at times (T,), which covers the surface.

        Args:
            given: the coefficients.
            times: (T,) of the states.
            surface: of the contact.
            temperature: (T, N) of the surfaces at the nodes, where coefficients depend on it.
        """
        if given.temperature is not None:
            assert temperature is not None
            heated = np.interp(temperature, given.temperature, given.values)
            # Cycles that are the same have the same coefficients, whatever round-off leaves.
            heated = np.round(np.where(times[:, None] > given.begins, heated, 0.0), 12)
            fields, number = np.unique(heated, axis=0, return_inverse=True)
            return cls(fields, number.ravel())
        if given.even or given.pressure is not None:
            found = cls.uniform(given.over(times), len(surface.weights))
            if given.pressure is None:
                return found
            share = given.values / max(given.values.max(), np.finfo(float).tiny)
            return replace(found, by_pressure=np.array([given.pressure, share]))
        own = _along(given, surface)
        return cls(np.array([np.zeros_like(own), own]), (times > given.begins).astype(np.int64))

    @classmethod
    def uniform(cls, coefficients: Array, nodes: int) -> Friction:
        """The same coefficient (T,) at all of some nodes."""
        found, number = np.unique(coefficients, return_inverse=True)
        return cls(np.broadcast_to(found[:, None], (len(found), nodes)), number)

    def share(self, pressure: Array) -> Array:
        """(N,) part of the coefficients that acts in a step after a pressure (N,) at the nodes."""
        if self.by_pressure is None:
            return np.ones_like(pressure)
        return np.interp(pressure, *self.by_pressure)

    def at(self, states: Any, nodes: Any = slice(None)) -> Array:
        """(S, N) coefficients in states (S,) at nodes (N,) or at all; (N,) in one state."""
        return np.asarray(self.fields[self.number[states]][..., nodes])

    def among(self, states: Any) -> Array:
        """(U, N) different coefficients of all nodes in some states."""
        return self.fields[np.unique(self.number[states])]

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
        pairs, place = np.unique([self.number, other.number], axis=1, return_inverse=True)
        differ = (self.fields[pairs[0]] != other.fields[pairs[1]]).any(axis=1)
        if not np.array_equal(_known(self.by_pressure), _known(other.by_pressure)):
            differ[:] = True
        return np.asarray(differ[place.ravel()])

    @property
    def acts(self) -> Bools:
        """(T,) states in whose step there is friction at some node."""
        return np.asarray(self.fields.any(axis=1)[self.number])

    @property
    def largest(self) -> float:
        """Largest coefficient in any state."""
        return float(self.fields[self.number].max())


def _known(table: Array | None) -> Array:
    return np.empty(0) if table is None else table


def require_covered(given: Coefficients, surface: ContactSurface) -> None:
    """Check that coefficients are given all over a surface.

    Raises:
        CaseError: they are not, or those along an arc are for a surface of solids.
    """
    if not given.by_place:
        return
    try:
        _along(given, surface)
    except CaseError as error:
        raise CaseError(f"{given.key}: {error}") from None


def _along(table: Coefficients, surface: ContactSurface) -> Array:
    """(N,) coefficients of a table at the nodes of a surface."""
    if table.arc is not None:
        return on_arc(table.arc, table.values, surface)
    assert table.points is not None
    return table.values[nearest(table.points, surface)]
