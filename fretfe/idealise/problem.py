# SPDX-License-Identifier: LGPL-3.0-or-later
"""The half-plane problem: what closed forms and the half-plane solution need to know of a case."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.analytic.profiles import Profile
from fretfe.errors import ModelError
from fretfe.loads import History


@dataclass(frozen=True)
class HalfPlaneProblem:
    """Two elastically similar half-planes, one of them with a symmetric profile.

    Signs and names as in `fretfe.analytic.edges`; forces per unit thickness.

    Attributes:
        contact: name of the contact.
        body1, body2: names of the bodies.
        profile: initial gap and composite modulus.
        history: loads of the case; state 0 is unloaded.
        friction: (T,) coefficient in the step that ends at each state.
        normal_force: (T,) P.
        shear_force: (T,) Q.
        moment: (T,) M of the pressure about the axis of the profile.
        bulk_tension: (T,) sigma0.
        k_n_error, k_t_error: relative errors of K_N and K_T to expect because the bodies of the
            case are finite.
        notes: what was assumed, in words.
    """

    contact: str
    body1: str
    body2: str
    profile: Profile
    history: History
    friction: Array
    normal_force: Array
    shear_force: Array
    moment: Array
    bulk_tension: Array
    k_n_error: float = 0.0
    k_t_error: float = 0.0
    notes: tuple[str, ...] = ()

    def with_notes(self, notes: Iterable[str]) -> HalfPlaneProblem:
        """The same problem with other notes."""
        return replace(self, notes=tuple(notes))

    def with_errors(self, k_n: float, k_t: float) -> HalfPlaneProblem:
        """The same problem with other errors of K_N and K_T."""
        return replace(self, k_n_error=k_n, k_t_error=k_t)

    def scaled(self, factor: float) -> HalfPlaneProblem:
        """The same problem with all loads multiplied."""
        return replace(
            self,
            normal_force=factor * self.normal_force,
            shear_force=factor * self.shear_force,
            moment=factor * self.moment,
            bulk_tension=factor * self.bulk_tension,
        )

    def require_partial_slip(self) -> None:
        """Check that the contact stays closed and never slides as a whole.

        Raises:
            ModelError: names every time at which it does not.
        """
        problems = list(self._problems())
        if problems:
            raise ModelError(
                f"contact {self.contact!r}: half-planes have no solution for these loads:\n"
                + "\n".join(problems)
            )

    def _problems(self) -> Iterator[str]:
        loaded = self.history.times > 0
        opened = np.flatnonzero(loaded & (self.normal_force <= 0))
        if opened.size:
            time, force = self.history.times[opened[0]], self.normal_force[opened[0]]
            yield (
                f"  expected a normal force P > 0 in every step, found {force:g} at time {time:g}: "
                "the contact is open"
            )
            return
        limit = self.friction * self.normal_force
        sliding = np.flatnonzero(loaded & (np.abs(self.shear_force) >= limit) & self._sheared)
        if sliding.size:
            state = sliding[0]
            yield (
                f"  expected |Q| < f P in every step, found Q = {self.shear_force[state]:g} and "
                f"f P = {limit[state]:g} at time {self.history.times[state]:g}: the contact slides"
            )

    @property
    def _sheared(self) -> Bools:
        """(T,) whether a shear force acts that is not round-off."""
        return np.abs(self.shear_force) > 1e-12 * self.normal_force.max()
