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

from fretfe.analytic._arguments import FloatArray, check_positive, check_range
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

    def stick_half_width(self, shear_force: ArrayLike) -> FloatArray:
        """Return c of the first loading; also of a steady cycle, with the amplitude Q1.

        The slip zones reach a - c inward.
        """
        carried = np.abs(self._check("shear_force", shear_force)) / self.friction
        return self.profile.half_width(np.maximum(self.normal_force - carried, 0.0))

    def shear(self, x: ArrayLike, shear_force: ArrayLike) -> FloatArray:
        """Return q(x) of the first loading to Q."""
        force = np.asarray(shear_force, dtype=np.float64)
        inner = self.profile.pressure(x, self.stick_half_width(force))
        full = self.profile.pressure(x, self.half_width)
        return np.sign(force) * self.friction * (full - inner)

    def cyclic_shear(
        self, x: ArrayLike, shear_force: ArrayLike, amplitude: ArrayLike, *, rising: bool
    ) -> FloatArray:
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
    ) -> FloatArray:
        """Return the half-width that has not slipped since the last reversal of the steady cycle.

        Arguments and errors as in ``cyclic_shear``.
        """
        _, change = self._since_reversal(shear_force, amplitude, rising=rising)
        return self.stick_half_width(change / 2.0)

    def slip(self, x: ArrayLike, shear_force: ArrayLike) -> FloatArray:
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

    def _opening(self, x: FloatArray, stick: FloatArray) -> FloatArray:
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
    ) -> tuple[FloatArray, FloatArray]:
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

    def _check(self, name: str, value: ArrayLike) -> FloatArray:
        limit = self.friction * self.normal_force
        return check_range(name, value, low=-limit, high=limit)


def hertz_dissipation(
    profile: Hertz, normal_force: float, friction: float, amplitude: ArrayLike
) -> FloatArray:
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


def stick_zone_moderate_tension(
    contact: PartialSlip, shear_force: ArrayLike, bulk_tension: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return half-width c and centre e of the stick zone of a Hertz contact, first loading.

    Shear force and bulk tension rise in proportion (Nowell and Hills 1987): c as without tension,
    e = a sigma0/(4 f p0) sign(Q): towards the edge where |K_T| is smaller. For a steady cycle pass
    half the ranges.

    Raises:
        ValueError: if the contact is not a Hertz contact, or c + |e| > a: the tension is then not
            moderate, slip at the edges has opposite signs.
    """
    if not isinstance(contact.profile, Hertz):
        raise ValueError(f"contact must have a Hertz profile, found {contact.profile!r}")
    a = contact.half_width
    bound = 4.0 * contact.friction * contact.profile.peak_pressure(a)
    shift = a * np.asarray(bulk_tension, dtype=np.float64) / bound
    c = contact.stick_half_width(shear_force)
    if np.any(c + np.abs(shift) > a):
        raise ValueError(
            f"bulk_tension must be moderate, |e| <= a - c = {np.min(a - c):g}, "
            f"found e = {np.max(np.abs(shift)):g}"
        )
    return c, np.sign(shear_force) * shift
