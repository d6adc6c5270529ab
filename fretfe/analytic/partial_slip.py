# SPDX-License-Identifier: LGPL-3.0-or-later
"""Exact partial slip under constant normal load and shear force, for any symmetric profile.

Elastically similar half-planes, no bulk tension. First loading: q = f [p(x; a) - p(x; c)], where
``c`` is the contact half-width at the load P - |Q|/f (Cattaneo 1938, Mindlin 1949 for Hertz;
Ciavarella 1998 and Jäger 1998 for any profile). A reversal superposes twice such a field of the
opposite sign (Mindlin and Deresiewicz 1953). Signs as in ``fretfe.analytic.edges``; all quantities
per unit thickness. ``x`` and the shear force may be arrays that broadcast.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import xlog1py

from fretfe._typing import Array
from fretfe.analytic._numerics import check_positive, check_range
from fretfe.analytic.profiles import Hertz, Profile

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(80)


@dataclass(frozen=True)
class PartialSlip:
    """A profile under a constant normal load, with Coulomb friction.

    Raises:
        ValueError: from any method if a shear force or amplitude exceeds f P.
    """

    profile: Profile
    normal_force: float
    friction: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("normal_force", self.normal_force)
        check_positive("friction", self.friction)

    @property
    def half_width(self) -> float:
        """Contact half-width a."""
        return float(self.profile.half_width(self.normal_force))

    def stick_half_width(self, shear_force: ArrayLike) -> Array:
        """Return c of the first loading; also of a steady cycle, with the amplitude Q1.

        The slip zones reach a - c inward.
        """
        carried = np.abs(self._check("shear_force", shear_force)) / self.friction
        return self.profile.half_width(np.maximum(self.normal_force - carried, 0.0))

    def shear(self, x: ArrayLike, shear_force: ArrayLike) -> Array:
        """Return q(x) of the first loading to Q."""
        force = np.asarray(shear_force, dtype=np.float64)
        inner = self.profile.pressure(x, self.stick_half_width(force))
        full = self.profile.pressure(x, self.half_width)
        return np.sign(force) * self.friction * (full - inner)

    def cyclic_shear(
        self, x: ArrayLike, shear_force: ArrayLike, amplitude: ArrayLike, *, rising: bool
    ) -> Array:
        """Return q(x) in the steady cycle between -Q1 and +Q1.

        Args:
            x: positions.
            shear_force: present Q, |Q| <= Q1.
            amplitude: Q1.
            rising: whether Q rises from -Q1 (else it falls from +Q1).

        Raises:
            ValueError: if Q1 is outside [0, f P] or Q outside [-Q1, Q1].
        """
        extreme, change = self._since_reversal(shear_force, amplitude, rising=rising)
        return self.shear(x, extreme) + 2.0 * self.shear(x, change / 2.0)

    def cyclic_stick_half_width(
        self, shear_force: ArrayLike, amplitude: ArrayLike, *, rising: bool
    ) -> Array:
        """Return the half-width that has not slipped since the last reversal of the steady cycle.

        Arguments and errors as in ``cyclic_shear``.
        """
        _, change = self._since_reversal(shear_force, amplitude, rising=rising)
        return self.stick_half_width(change / 2.0)

    def shear_after(self, x: ArrayLike, shear_forces: ArrayLike) -> Array:
        """Return q(x) after any sequence of shear forces.

        The first loading up to the first reversal that is still remembered, then for each change of
        Q between the remembered reversals twice the field of half the change. A loop that closes is
        forgotten with its reversals, and everything before where |Q| comes back to its maximum.

        Args:
            x: positions, any shape.
            shear_forces: (T,) values of Q one after the other, from the contact without shear. Only
                the turning points matter; q belongs to the last one.

        Raises:
            ValueError: if ``shear_forces`` is not (T,) with T >= 1, or one is outside [-f P, f P].
        """
        turns = self._remembered(shear_forces)
        changes = (self.shear(x, change / 2.0) for change in np.diff(turns))
        return self.shear(x, turns[0]) + 2.0 * sum(changes, np.zeros(()))

    def stick_half_width_after(self, shear_forces: ArrayLike) -> Array:
        """Return the half-width that has not slipped since the last reversal of the sequence.

        Arguments and errors as in ``shear_after``. Points that last slipped in an earlier part of
        the sequence count as stuck.
        """
        turns = self._remembered(shear_forces)
        return self.stick_half_width(turns[0] if len(turns) == 1 else (turns[-1] - turns[-2]) / 2.0)

    def _remembered(self, shear_forces: ArrayLike) -> list[float]:
        """Return the reversals that the contact remembers, in order, and the present Q."""
        forces = self._check("shear_forces", shear_forces)
        if forces.ndim != 1 or len(forces) == 0:
            raise ValueError(f"shear_forces must have the shape (T,), T >= 1, found {forces.shape}")
        turns: list[float] = []
        for force in forces.tolist():
            turns.append(force)
            while _forget(turns):
                pass
        return turns

    def slip(self, x: ArrayLike, shear_force: ArrayLike) -> Array:
        """Return the relative slip (body 1 to body 2) of the first loading inside the contact.

        f times the gap that opens at x when the half-width recedes from a to c; by quadrature.
        The range over a steady cycle of amplitude Q1 is twice the slip at Q1.
        """
        force = self._check("shear_force", shear_force)
        opened = self._opening(np.abs(x), self.stick_half_width(force))
        return np.sign(force) * self.friction * opened

    def dissipation(self, amplitude: float) -> float:
        """Return the energy dissipated per steady cycle between -Q1 and +Q1, both edges.

        8 f^2 int_c^a p(x) h(x) dx, with h the gap that opens when the half-width recedes to c.

        Raises:
            ValueError: if ``amplitude`` is outside [0, f P].
        """
        check_range("amplitude", amplitude, low=0.0)
        a, c = self.half_width, self.stick_half_width(self._check("amplitude", amplitude))
        # x = c + (a - c) sin^2: p and h have the powers 1/2 and 3/2 at the two ends.
        angle, weight = np.pi / 4 * (POINTS + 1), np.pi / 4 * WEIGHTS
        x = c + (a - c) * np.sin(angle) ** 2
        density = self.profile.pressure(x, a) * self._opening(x, c)
        return float(
            8.0 * self.friction**2 * (a - c) * np.sum(weight * density * np.sin(2 * angle))
        )

    def _opening(self, x: Array, stick: Array) -> Array:
        """Return h(x) = (2/(pi E*)) int_c^x P'(b) arcosh(x/b) db, the gap outside half-width c.

        Superposition of flat punches: the slope outside a punch is (2/(pi E*)) P'/sqrt(x^2 - b^2).
        """
        outside = np.maximum(x, stick)[..., None]
        reach = outside - np.asarray(stick)[..., None]
        # b = x - (x - c) v^2 takes away the square root of arcosh at b = x.
        v, weight = (POINTS + 1) / 2, WEIGHTS / 2
        b = outside - reach * v**2
        ratio = reach * v**2 / b
        arcosh = np.log1p(ratio + np.sqrt(ratio * (2.0 + ratio)))
        area = np.sum(weight * 2 * v * reach * self.profile.load_slope(b) * arcosh, axis=-1)
        return 2.0 / (np.pi * self.profile.e_star) * area

    def _since_reversal(
        self, shear_force: ArrayLike, amplitude: ArrayLike, *, rising: bool
    ) -> tuple[Array, Array]:
        """Return Q at the last reversal and the change of Q since."""
        peak = check_range("amplitude", self._check("amplitude", amplitude), low=0.0)
        force = self._check("shear_force", shear_force)
        if np.any(np.abs(force) > peak):
            raise ValueError(
                f"shear_force must lie within the amplitude {np.min(peak):g}, "
                f"found {force.flat[np.argmax(np.abs(force))]:g}"
            )
        extreme = -peak if rising else peak
        return extreme, force - extreme

    def _check(self, name: str, value: ArrayLike) -> Array:
        limit = self.friction * self.normal_force
        try:
            return check_range(name, value, low=-limit, high=limit)
        except ValueError as error:
            raise ValueError(f"{error}: beyond f P the contact slides") from None


def _forget(turns: list[float]) -> bool:
    """Remove from the turning points one that the last value wipes out; return whether there is."""
    last = turns[-1]
    if len(turns) > 1 and abs(last) >= abs(turns[0]):
        del turns[:-1]
        return True
    if len(turns) < 3:
        return False
    before, change = turns[-2] - turns[-3], last - turns[-2]
    goes_on, closes_loop = before * change >= 0.0, abs(change) >= abs(before)
    if goes_on or closes_loop:
        # The other end of a closed loop goes next: from there the last value goes on.
        del turns[-2]
    return goes_on or closes_loop


def hertz_dissipation(
    profile: Hertz, normal_force: float, friction: float, amplitude: ArrayLike
) -> Array:
    """Return the energy per steady cycle, both edges, of a Hertz contact in closed form.

    W = (4 (fP)^2/(pi E*)) [u (2 - u)/2 + (1 - u) ln(1 - u)] with u = Q1/(fP); the loop integral of
    Q over the tangential approach.

    Raises:
        ValueError: if ``amplitude`` is outside [0, f P] or another argument is not positive.
    """
    limit = check_positive("friction", friction) * check_positive("normal_force", normal_force)
    u = check_range("amplitude", amplitude, low=0.0, high=float(limit)) / limit
    shape = u * (2.0 - u) / 2.0 + xlog1py(1.0 - u, -u)
    return 4.0 * limit**2 / (np.pi * profile.e_star) * shape
