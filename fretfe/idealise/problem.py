# SPDX-License-Identifier: LGPL-3.0-or-later
"""The half-plane problem: what closed forms and the half-plane solution take, and its edges."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.profiles import Profile, edge_factor_k_n
from fretfe.analytic.rocking import TiltedContact, tilted_contact
from fretfe.errors import ConvergenceError, ModelError
from fretfe.loads import History
from fretfe.loads.history import within_steps


@dataclass(frozen=True)
class HalfPlaneProblem:
    """Two half-planes, one of them with a symmetric profile.

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
        tangential: compliance to shear over that to pressure, 1/E* of the profile; that of crystals
            is not 1. Tractions do not depend on it, slip is in proportion.
        dundurs: Dundurs' second constant beta, by which pressure and shear depend on each other;
            body 1 is above.
        guided: whether body 1 does not turn although shear would turn it, as that of unlike bodies
            does: the moment is then a reaction.
        layer: approach of the surfaces per pressure, and displacement along them per shear, by a
            layer between them.
        between: (T-1, S, 4) P, Q, M and sigma0 within the steps, as `History.between`; None if they
            are straight lines there.
        stretch: bulk tension by a unit of P, as finite bodies stretch by different amounts under
            it; it is left out.
        k_n_error, k_t_error, slip_error: relative errors of K_N, K_T and slip zones to expect
            because the bodies of the case are finite and meet at a slope.
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
    tangential: float = 1.0
    dundurs: float = 0.0
    guided: bool = False
    layer: tuple[float, float] = (0.0, 0.0)
    between: Array | None = None
    stretch: float = 0.0
    k_n_error: float = 0.0
    k_t_error: float = 0.0
    slip_error: float = 0.0
    notes: tuple[str, ...] = ()

    def with_notes(self, notes: Iterable[str]) -> HalfPlaneProblem:
        """The same problem with other notes."""
        return replace(self, notes=tuple(notes))

    def with_errors(self, k_n: float, k_t: float, slip: float) -> HalfPlaneProblem:
        """The same problem with other errors of K_N, K_T and slip zones."""
        return replace(self, k_n_error=k_n, k_t_error=k_t, slip_error=slip)

    def divided(self, steps: Indices, shares: Array) -> HalfPlaneProblem:
        """The same problem on a finer clock; see `History.divided`."""
        loads = np.column_stack(
            [self.normal_force, self.shear_force, self.moment, self.bulk_tension]
        )
        normal, shear, moment, tension = within_steps(loads, self.between, steps, shares).T
        return replace(
            self,
            history=self.history.divided(steps, shares),
            friction=self.friction[steps],
            normal_force=normal,
            shear_force=shear,
            moment=moment,
            bulk_tension=tension,
            between=None,
        )

    def scaled(self, factor: float) -> HalfPlaneProblem:
        """The same problem with all loads multiplied."""
        return replace(
            self,
            normal_force=factor * self.normal_force,
            shear_force=factor * self.shear_force,
            moment=factor * self.moment,
            bulk_tension=factor * self.bulk_tension,
            between=None if self.between is None else factor * self.between,
        )

    def require_partial_slip(self) -> None:
        """Check that the contact stays closed and never slides as a whole.

        Raises:
            ModelError: nothing ever presses the bodies together.
            ConvergenceError: the contact opens or slides in a step; names the first time.
        """
        title = f"contact {self.contact!r}: half-planes have no solution for these loads:\n  "
        loaded, times = self.history.times > 0, self.history.times
        pressed = bool((self.normal_force > 0).any())
        opened = np.flatnonzero(loaded & ((self.normal_force < 0) | (not pressed)))
        if opened.size:
            wanted = ">= 0 in every step" if pressed else "> 0 in some step"
            raise (ConvergenceError if pressed else ModelError)(
                f"{title}expected a normal force P {wanted}, found "
                f"{self.normal_force[opened[0]]:g} at time {times[opened[0]]:g}: nothing holds "
                "the bodies together"
            )
        limit = self.friction * self.normal_force
        sliding = np.flatnonzero(loaded & (np.abs(self.shear_force) >= limit) & self.sheared)
        if sliding.size:
            state = sliding[0]
            raise ConvergenceError(
                f"{title}expected |Q| < f P in every step, found Q = {self.shear_force[state]:g} "
                f"and f P = {limit[state]:g} at time {times[state]:g}: the contact slides"
            )

    @property
    def sheared(self) -> Bools:
        """(T,) whether a shear force acts that is not round-off."""
        return np.abs(self.shear_force) > 1e-12 * self.normal_force.max()


def left_out_by_stretch(problem: HalfPlaneProblem) -> tuple[float, float]:
    """Range of K_T by `HalfPlaneProblem.stretch`, and by how much slip zones change with it.

    P matters as far as it varies while there is friction: in the cycle, or until the end without
    one. The lengths are those of (8') or (9) of the theory guide, with K_N of the last state, or
    of the largest P if nothing presses in that.
    """
    cycle, friction = problem.history.cycle, problem.friction
    if not friction.any():
        return 0.0, 0.0
    begin, last = cycle or (max(int(np.argmax(friction > 0)) - 1, 0), len(friction) - 1)
    if not friction[last] > 0:
        return 0.0, 0.0
    edges, force = contact_edges(problem), problem.normal_force[begin : last + 1]
    change = abs(problem.stretch) * float(np.ptp(force))
    last = last if force[-1] > 0 else begin + int(np.argmax(force))
    a = float(edges.right[last] - edges.left[last]) / 2
    k_t, k_n = change / 4 * math.sqrt(a / 2), min(edges.k_n_left[last], edges.k_n_right[last])
    return k_t, (1 if cycle else 2) * k_t / float(friction[last] * k_n)


def contact_edges(problem: HalfPlaneProblem) -> TiltedContact:
    """(T,) positions of both edges, tilt, and K_N at both edges; NaN in states without contact."""
    loaded = problem.normal_force > 0
    force, moment = problem.normal_force[loaded], problem.moment[loaded]
    if np.any(moment != 0):
        contact = tilted_contact(problem.profile, force, moment)
    else:
        a = problem.profile.half_width(force)
        k_n = edge_factor_k_n(problem.profile, a)
        contact = TiltedContact(-a, a, np.zeros_like(a), k_n, k_n)
    parts = np.full((len(fields(TiltedContact)), len(loaded)), np.nan)
    for part, field in zip(parts, fields(TiltedContact), strict=True):
        part[loaded] = getattr(contact, field.name)
    return TiltedContact(*parts)


def governing_length(problem: HalfPlaneProblem, half_width: float) -> float:
    """Length over which the edge description holds: a, or a - b of a flat-and-rounded profile."""
    inner = [kink for kink in problem.profile.kinks if kink < half_width]
    return half_width - max(inner, default=0.0)


def layer_reach(problem: HalfPlaneProblem) -> float:
    """Length by which a layer widens a contact at either edge, or more.

    On a thin layer a cylinder is wider by 1.2 E* c, with c its approach per pressure. If a thick
    one alone gives under the gap g, it carries P = (2/c) ∫ x g'(x) dx from 0 to the half-width,
    that of an even contact also where that is tilted.
    """
    # Imported where it is needed: most contacts have no layer.
    from scipy.optimize import brentq

    force, c = float(problem.normal_force.max()), problem.layer[0]
    if not c > 0:
        return 0.0
    # Many, as the profile may have a kink.
    places, weights = np.polynomial.legendre.leggauss(200)

    def excess(b: float) -> float:
        x = b * (places + 1) / 2
        return float(b * weights @ (x * problem.profile.gap_slope(x))) - c * force

    far = float(problem.profile.half_width(force))
    while excess(far) < 0:
        far *= 2
    return min(float(brentq(excess, 0.0, far)), 2 * c * problem.profile.e_star)
