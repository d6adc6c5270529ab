# SPDX-License-Identifier: LGPL-3.0-or-later
"""Partial slip next to edges of unlike bodies, whose pressure follows from the shear.

In the contact from c - b to c + b of bodies with Dundurs' beta and a gap f

    (1/pi) PV int p(t)/(x - t) dt = (E*/2) f'(x) + beta q(x) = sum of h_k T_k((x - c)/b),
    p = sum of h_k sin(k theta),   x = c + b cos(theta),   k > 0

(Muskhelishvili 1953; T_k are Chebyshev's polynomials). h_0 = 0 and the force, P = pi b h_1/2, tell
both edges: shear moves them, and no node has to be found in contact or not. Counted is what differs
from the closed form of similar bodies with the same edges. Pressure in turn moves points along x.
`coupled_slip` goes to and fro between both, which converges like a power of beta times the larger
one of beta and f.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.local.friction import Bound, Slipped, Stiffness, partial_slip
from fretfe.local.half_planes import WholeHalfPlanes

# Iterations until pressure and shear fit each other, change of the shear over the largest f p with
# which they do, and with which they will do after all of them.
MOST_ITERATIONS = 60
SETTLED = 1e-8
ACCEPTED = 1e-4
# Of the place of both edges meanwhile, which is found faster.
EDGE_ITERATIONS = 2
# Iterates that are mixed, and steps that count beside the largest of them.
KEPT = 5
SMALLEST_STEP = 1e-8
# Places at which the shear is taken, by angles: next to an edge they are nearer to one another.
ANGLES = 512


@dataclass(frozen=True)
class UnlikeContacts:
    """S contacts of unlike half-planes, with E* = 1; lengths over their outermost half-widths.

    Attributes:
        bodies: nodes and compliance.
        dundurs: beta.
        shapes: (S, k) as of `pressure_shapes`.
        powers: (S,) n of the gap, which grows with |x|^n.
        force: (S,) over the n-th power of the half-width, between similar bodies.
        half_width: (S,) between similar bodies under the same force.
    """

    bodies: WholeHalfPlanes
    dundurs: float
    shapes: Array
    powers: Array
    force: Array
    half_width: Array

    @classmethod
    def of(
        cls,
        bodies: WholeHalfPlanes,
        dundurs: float,
        shapes: Array,
        powers: Array,
        level: Array,
        half_width: Array,
    ) -> UnlikeContacts:
        """Contacts from the levels (S,) of the pressure between similar bodies."""
        force = np.pi * level / (powers * half_width ** (powers - 1))
        return cls(bodies, dundurs, shapes, powers, force, half_width)

    def pressed(self, shear: Array, last: Pressed) -> Pressed:
        """The contacts under a shear (S, n) along x, from others that are near."""
        theta, conjugate = _conjugate()
        steps = self.force / _mean_power(self.powers)
        half, centre = last.half_width[:, None], last.centre[:, None]
        n = self.powers[:, None]
        x = centre + half * np.cos(theta)
        bent = steps[:, None] * (_odd_power(x, n - 1) - _odd_power(x - centre, n - 1))
        order = np.argsort(self.bodies.s)
        places = self.bodies.s[order] - 1
        drive = bent + self.dundurs * np.array(
            [np.interp(at, places, own[order]) for at, own in zip(x, shear, strict=True)]
        )
        added = self._means(theta, drive @ conjugate, last)
        # Newton's step for h_0 = 0, and the width that carries the force.
        slope = steps * ((n - 1) * np.maximum(np.abs(x), 1e-3 * half) ** (n - 2)).mean(axis=1)
        moved = drive.mean(axis=1) / slope
        carried = last.half_width * np.pi * (drive * np.cos(theta)).mean(axis=1)
        power = self.half_width**self.powers - carried / self.force
        pressure = self.bodies.pressure(self.shapes, last.half_width, last.centre)
        pressure *= (self.force * last.half_width ** (self.powers - 1))[:, None]
        pressure *= (self.powers / np.pi)[:, None]
        return Pressed(
            np.maximum(pressure + added, 0.0),
            np.maximum(power, 0.0) ** (1 / self.powers),
            last.centre - moved,
        )

    def _means(self, theta: Array, values: Array, last: Pressed) -> Array:
        """(S, n) means around the nodes of values (S, k) at angles (k,)."""
        ends = np.concatenate([[0.0], theta, [np.pi]])
        at = (self.bodies.points - last.centre[:, None]) / last.half_width[:, None]
        angles = np.arccos(np.clip(at, -1.0, 1.0))
        found = [
            np.interp(angle, ends, np.concatenate([[0.0], own, [0.0]]))
            for angle, own in zip(angles, values, strict=True)
        ]
        return self.bodies.means(np.array(found))


@dataclass(frozen=True)
class Pressed:
    """Pressure of S contacts, and where they are.

    Attributes:
        pressure: (S, n) means around the nodes.
        half_width: (S,).
        centre: (S,) x of the middle.
    """

    pressure: Array
    half_width: Array
    centre: Array


@dataclass(frozen=True)
class Before:
    """S edges when a step begins.

    Attributes:
        pressed: pressure.
        slipping: (S, n) nodes that slipped in the step before.
        shear: (S, n, 2).
    """

    pressed: Pressed
    slipping: Bools
    shear: Array


@dataclass(frozen=True)
class CoupledSlip:
    """A solved step of S edges.

    Attributes:
        pressed: pressure.
        slipped: shear and slip.
        unsettled: (k,) edges whose pressure and shear do not settle.
    """

    pressed: Pressed
    slipped: Slipped
    unsettled: Indices


def coupled_slip(
    contacts: UnlikeContacts,
    stiffness: Stiffness,
    bound: Bound,
    stuck: Array,
    before: Before,
    tolerance: float,
) -> CoupledSlip:
    """Solve a step for pressure and shear.

    Args:
        contacts: how shear changes the pressure.
        stiffness: against slip.
        bound: of the shear by friction.
        stuck: (S, n, 2) shear if no node slips and the pressure stays.
        before: the beginning of the step.
        tolerance: error of the shear.
    """
    bodies, shear, slipping = contacts.bodies, before.shear, before.slipping
    pressed, counted = before.pressed, ~bound.lost[:, None]
    # Displacement along x is held by stuck nodes, as a slip would be.
    along = contacts.dundurs * stiffness.stiffness[:, 0]
    mixed = _Mixed()
    for _ in range(MOST_ITERATIONS):
        for _ in range(EDGE_ITERATIONS):
            pressed = contacts.pressed(counted * shear[..., 0], pressed)
        pressure = pressed.pressure
        moved = (pressure - before.pressed.pressure) @ bodies.coupling @ bodies.change
        held = stuck - moved[..., None] * along[:, None]
        slipped = partial_slip(stiffness, bound.of(pressure), held, slipping, tolerance)
        change = np.abs(slipped.shear - shear).max(axis=(1, 2))
        slipping = slipped.slipping
        change[slipped.unsolved] = np.inf
        change /= (bound.friction * pressure).max(axis=1)
        if not (change[~bound.lost] > SETTLED).any():
            break
        shear = mixed.next(shear, slipped.shear)
    return CoupledSlip(pressed, slipped, np.flatnonzero(~(change <= ACCEPTED) & ~bound.lost))


class _Mixed:
    """Anderson's mixture of iterates, for the border of slip settles slowly by itself.

    D. G. Anderson, J. ACM 12, 1965; type II, for S problems side by side.
    """

    def __init__(self) -> None:
        self._given: list[Array] = []
        self._found: list[Array] = []

    def next(self, given: Array, found: Array) -> Array:
        """(S, ...) where to go on from what an iteration made of what it was given."""
        count = len(given)
        self._given = [*self._given[-KEPT:], given.reshape(count, -1)]
        self._found = [*self._found[-KEPT:], found.reshape(count, -1)]
        if len(self._given) == 1:
            return found
        results = np.stack(self._found, axis=2)
        residuals = results - np.stack(self._given, axis=2)
        steps = np.diff(residuals, axis=2)
        shares = np.linalg.pinv(steps, rcond=SMALLEST_STEP) @ residuals[..., -1:]
        mixed = results[..., -1:] - np.diff(results, axis=2) @ shares
        return np.asarray(mixed[..., 0].reshape(given.shape))


def _odd_power(x: Array, power: Array) -> Array:
    return np.asarray(np.sign(x) * np.abs(x) ** power)


def _mean_power(powers: Array) -> Array:
    """(S,) integrals of |cos|^n over half a turn, by which a slope |x|^(n-1) carries its force."""
    theta, _ = _conjugate()
    return np.asarray(np.pi * (np.abs(np.cos(theta)) ** powers[:, None]).mean(axis=1))


@cache
def _conjugate() -> tuple[Array, Array]:
    """(k,) angles, and (k, k) from values there to the conjugate series: cosines to sines."""
    theta = (np.arange(ANGLES) + 0.5) * np.pi / ANGLES
    orders = np.arange(1, ANGLES)
    waves = np.outer(theta, orders)
    return theta, 2 / ANGLES * np.cos(waves) @ np.sin(waves).T
