# SPDX-License-Identifier: LGPL-3.0-or-later
"""Exact partial slip under constant normal load, and the stress below its tractions.

Elastically similar half-planes, no bulk tension, any symmetric profile: first loading is
q = f [p(x; a) - p(x; c)], where ``c`` is the contact half-width at the load P - |Q|/f (Cattaneo
1938, Mindlin 1949 for Hertz; Ciavarella 1998 and Jäger 1998 for any profile). A reversal superposes
twice such a field of the opposite sign (Mindlin and Deresiewicz 1953). Signs as in
``fretfe.analytic.edges``; all quantities per unit thickness. ``x`` and the shear force may be
arrays that broadcast.

Moderate bulk tension, a Hertz contact, Q and sigma0 in proportion (Nowell and Hills 1987): slip at
both edges has the direction of Q, the tension only shifts the stick zone. In it the change of the
traction must bring the two surfaces the strain difference of the tension,
(1/pi) PV int q(t)/(t - x) dt = -sigma0/4. The bound |e| <= a - c on the centre e of the stick zone
is that of the state that is asked for. On the way there from zero, in proportion, slip at both
edges has one direction throughout if |sigma0| <= 4|Q|/(pi a), so that K_T of the two edges has
opposite signs (or one vanishes). Between this and the wider bound, an edge has slipped the other
way at first, and the solution is no longer exact.

Stress in body 2, at its surface y = 0 and at a depth h > 0 below it: with Flamant's solution the
traction (q, -p) dt at t gives the radial stress -(2/pi) F·r/r^2 (Johnson 1985, section 2.3), so
that everything follows from the Cauchy integrals

    I_g(z) = int g(t)/(z - t) dt,    z = x - i h,

of g = p and q:

    sigma_xx + sigma_yy = -(2/pi) [Re I_q + Im I_p]
    sigma_yy            =  (1/pi) [-Im I_p + y Re I_p' - y Im I_q']
    sigma_xy            =  (1/pi) [Im I_q + y Re I_q' + y Im I_p']

An ellipse g = g0 sqrt(1 - t^2/b^2) has I_g = (pi g0/b)(z - sqrt(z^2 - b^2)): McEwen's solution
(Johnson 1985, section 4.2) in one term. Partial slip is a sum of ellipses. A traction whose slope
jumps by m_j at the nodes t_j, straight between them and zero at both ends, has

    I_g(z) = sum m_j (z - t_j) ln(z - t_j),   I_g'(z) = sum m_j ln(z - t_j)

A shear g across the plane makes sigma_xz = -(1/pi) Re I_g and sigma_yz = (1/pi) Im I_g.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import xlog1py

from fretfe._typing import Array
from fretfe.analytic._numerics import check_positive, check_range
from fretfe.analytic.edges import tension_for_zero_factor
from fretfe.analytic.profiles import Hertz, Profile

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(80)
# Share of 4 f p0 by which round-off may take a tension beyond a bound: the bound itself is valid.
ROUND_OFF = 1e-12


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


def stick_zone_moderate_tension(
    contact: PartialSlip, shear_force: ArrayLike, bulk_tension: ArrayLike
) -> tuple[Array, Array]:
    """Return half-width c and centre e of the stick zone, first loading.

    c as without tension, e = a sigma0/(4 f p0) sign(Q): towards the edge where |K_T| is smaller.
    The slip zones are a - c + e long at the left and a - c - e at the right edge. For a steady
    cycle pass half the ranges.

    Raises:
        ValueError: if the contact is not a Hertz contact, |Q| exceeds f P, or |e| > a - c: the
            tension is then not moderate, slip at the edges has opposite signs.
    """
    a, scale = contact.half_width, _tension_scale(contact)
    c = contact.stick_half_width(shear_force)
    tension = np.asarray(bulk_tension, dtype=np.float64)
    excess = np.abs(tension) / scale - (1.0 - c / a)
    if np.any(excess > ROUND_OFF):
        raise ValueError(
            "bulk_tension must be moderate, else the stick zone reaches an edge and slip there has "
            f"the other sign: |e| <= a - c, found |e| - (a - c) = {a * np.max(excess):g}"
        )
    return c, np.sign(shear_force) * a * tension / scale


def shear_moderate_tension(
    contact: PartialSlip, x: ArrayLike, shear_force: ArrayLike, bulk_tension: ArrayLike
) -> Array:
    """Return q(x) of the first loading, Q and sigma0 in proportion.

    q = sign(Q) f [p(x; a) - p(x - e; c)], the second part that of a Hertz contact of half-width c
    around e, peak pressure p0 c/a.

    Raises:
        ValueError: as ``stick_zone_moderate_tension``.
    """
    c, e = stick_zone_moderate_tension(contact, shear_force, bulk_tension)
    full = contact.profile.pressure(x, contact.half_width)
    inner = contact.profile.pressure(np.asarray(x) - e, c)
    return np.sign(shear_force) * contact.friction * (full - inner)


def cyclic_shear_moderate_tension(
    contact: PartialSlip,
    x: ArrayLike,
    shear_force: ArrayLike,
    *,
    amplitude: float,
    tension_amplitude: float,
    rising: bool,
) -> Array:
    """Return q(x) in the steady cycle of Q between -Q1 and +Q1 and sigma0 = sigma1 Q/Q1.

    To the state at the last reversal comes twice the field of half the changes since.

    Args:
        contact: Hertz contact.
        x: positions.
        shear_force: present Q, |Q| <= Q1, of any shape that broadcasts with ``x``.
        amplitude: Q1 > 0.
        tension_amplitude: sigma1, positive if in phase with Q, negative if in anti-phase.
        rising: whether Q rises from -Q1 (else it falls from +Q1).

    Raises:
        ValueError: if the contact is not a Hertz contact, Q1 is outside (0, f P], Q outside
            [-Q1, Q1], or |sigma1| > 4 Q1/(pi a): slip at one edge is then against that at the
            other right after a reversal.
    """
    check_range("amplitude", amplitude, low=0.0, open_low=True)
    check_range("shear_force", shear_force, low=-amplitude, high=amplitude)
    limit = float(tension_for_zero_factor(amplitude, contact.half_width, "right"))
    if abs(tension_amplitude) > limit + ROUND_OFF * _tension_scale(contact):
        raise ValueError(
            f"tension_amplitude must lie in [-{limit:g}, {limit:g}], else the edges slip in "
            f"opposite directions after each reversal; found {tension_amplitude:g}"
        )
    extreme = -1.0 if rising else 1.0
    share = (np.asarray(shear_force, dtype=np.float64) / amplitude - extreme) / 2.0
    start = shear_moderate_tension(contact, x, extreme * amplitude, extreme * tension_amplitude)
    return start + 2.0 * shear_moderate_tension(
        contact, x, share * amplitude, share * tension_amplitude
    )


def _tension_scale(contact: PartialSlip) -> float:
    """Return 4 f p0, the tension that shifts the stick zone by a."""
    if not isinstance(contact.profile, Hertz):
        raise ValueError(f"contact must have a Hertz profile, found {contact.profile!r}")
    return 4.0 * contact.friction * float(contact.profile.peak_pressure(contact.half_width))


def linear_stress(
    x: ArrayLike,
    depth: ArrayLike,
    nodes: Array,
    pressure: Array,
    shear: Array,
    along: Array | None = None,
) -> Array:
    """Return the stress in body 2 under tractions that are straight between nodes.

    Exact for a half-plane, in plane strain as in plane stress. Finite everywhere.

    Args:
        x: (M,) positions.
        depth: (M,) distances below the surface, >= 0.
        nodes: (K,) increasing.
        pressure: (n, K) p there in n states, zero at the first and the last node.
        shear: (n, K) q on body 2, likewise.
        along: (n, K) traction along z, likewise; None without.

    Returns:
        (n, M, 3) sigma_xx, sigma_yy, sigma_xy; with a traction along z (n, M, 5), sigma_yz, which
        is that traction at the surface, and sigma_xz after them.

    Raises:
        ValueError: if a depth is negative.
    """
    place, below = np.asarray(x, dtype=np.float64), check_range("depth", depth, low=0.0)
    tractions = [pressure, shear] if along is None else [pressure, shear, along]
    jumps = np.stack([
        np.diff(np.diff(each) / np.diff(nodes), prepend=0.0, append=0.0) for each in tractions
    ])  # fmt: skip
    size = max(50_000 // len(nodes), 1)  # points at a time: their logarithms stay in the cache
    found = [
        _linear_part(place[start : start + size], below[start : start + size], nodes, jumps)
        for start in range(0, max(len(place), 1), size)
    ]
    return np.concatenate(found, axis=1)


def _linear_part(x: Array, depth: Array, nodes: Array, jumps: Array) -> Array:
    """As of `linear_stress`, by the jumps (2 or 3, n, K) of the slopes of the tractions."""
    aside, height = x[:, None] - nodes, -depth[:, None]
    # The logarithm in two parts, which is seven times as fast. At a node itself both terms vanish:
    # the depth is 0. On the surface the height is -0: below the cut of the logarithm.
    square = aside**2 + height**2
    size = np.log(np.maximum(square, np.finfo(float).tiny, out=square), out=square)
    size *= 0.5
    turn = np.arctan2(height, aside)
    real = jumps[1:] @ (aside * size - height * turn).T
    imaginary = jumps @ (aside * turn + height * size).T
    slope = height[:, 0] * (jumps[:2] @ size.T + 1j * (jumps[:2] @ turn.T))
    plane = _sum(1j * imaginary[0], slope[0], real[0] + 1j * imaginary[1], slope[1])
    if len(jumps) == 2:
        return plane
    sheared = np.stack([imaginary[2], -real[1]], axis=-1) / np.pi
    return np.concatenate([plane, sheared], axis=-1)


def _sum(normal: Any, normal_slope: Any, shear: Any, shear_slope: Any) -> Array:
    """(..., 3) stress from I_p, y I_p', I_q and y I_q'."""
    trace = -2 / np.pi * (shear.real + normal.imag)
    across = (-normal.imag + normal_slope.real - shear_slope.imag) / np.pi
    sheared = (shear.imag + shear_slope.real + normal_slope.imag) / np.pi
    return np.stack([trace - across, across, sheared], axis=-1)
