# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of a plane body around an edge of a contact, without cracks, through the cycle.

Near an edge the stress falls within a slip zone, which elements of a body resolve poorly. But it is
that of the tractions, which are known well, and these act next to a straight piece of surface: it
is the stress of a half-plane under the tractions of the contact, in closed form, and of what is
missing, which is smooth. Of a case of half-planes that is the bulk stress. Of meshed bodies it is
the difference from the stress of the elements at depths of two elements and more, as a polynomial
of the place around the edge that is in balance, whose residual is the error bar.

Points are (x, y) from the mouth, the outermost place of the edge in the cycle, with x along the
surface inward and y along the outward normal of the body: y <= 0, whichever body and edge it is.
Components of stress are xx, yy, zz, xy there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.special import comb

from fretfe._typing import Array, Indices
from fretfe.case import isotropic
from fretfe.decision.near_field import (
    ContactTractions,
    NearField,
    Side,
    edge_places,
    element_size,
    every_other,
)
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.stress import SHALLOW, StressHistory, judged_states
from fretfe.evaluate.withheld import withheld
from fretfe.history.solution import ContactHistory
from fretfe.materials.moduli import plane_modulus
from fretfe.reason import Kind, Reason
from fretfe.results.model import Result

# Relative error of the stress of tractions within an element of the edge, as of `_finest`.
WITHIN_ELEMENT = 0.02
# Power of the polynomial.
POWER = 3
FEWEST_ROWS = 2
# Least power of the depth of xx, yy, zz, xy, yz, xz: the surface is free of what the tractions do
# not make, and so is the slope of yy, by the balance of forces.
FREE = (0, 2, 0, 1, 1, 0)
# xx, yy, xy of a plane body.
PLANE = [0, 1, 3]


@dataclass(frozen=True)
class SmoothStress:
    """A polynomial of the place, through n states.

    Attributes:
        powers: (k, 2) of x and y.
        scale: length by which places are divided.
        values: (n, k, c) its coefficients.
        spread: half the width of an interval that holds most of what it misses; 0 where it is
            exact.
        deepest: largest depth at which it is known.
        widest: largest distances from the edge along the surface, outward and inward.
    """

    powers: Indices
    scale: float
    values: Array
    spread: float
    deepest: float
    widest: tuple[float, float]

    def at(self, points: Array) -> Array:
        """(n, M, c) stress at points (M, 2)."""
        return np.asarray(_terms(points / self.scale, self.powers) @ self.values)

    def through(self, some: Indices) -> SmoothStress:
        """The same through some of the states, by their places among these."""
        return replace(self, values=self.values[some])

    @classmethod
    def of(cls, points: Array, stress: Array, rows: int, power: int) -> SmoothStress | str:
        """A fit, or why there is none.

        Args:
            points: (M, 2).
            stress: (n, M, c) there.
            rows: number of depths at which there are points.
            power: of the polynomial.
        """
        solid = stress.shape[2] == len(FREE)
        most = min(power, rows - 1) if solid else power
        powers = np.array([(i, j) for j in range(most + 1) for i in range(power + 1 - j)])
        if len(points) < 2 * len(powers):
            return "the stress of the elements is known at too few places around the edge"
        deepest = float(-points[:, 1].min())
        terms = _terms(points / deepest, powers)
        values = np.zeros((len(stress), len(powers), stress.shape[2]))
        for components, shapes in _free(powers) if solid else _balanced(powers):
            fields = np.einsum("mkc,pk->pcm", shapes, terms).reshape(-1, len(shapes))
            known = stress[..., components].reshape(len(stress), -1).T
            fit = np.linalg.lstsq(fields, known, rcond=None)[0]
            values[..., components] = np.einsum("mkc,mn->nkc", shapes, fit)
        missed = 2 * float(np.sqrt(np.mean((terms @ values - stress) ** 2, axis=1)).max())
        ends = -points[:, 0].min(), points[:, 0].max()
        outward, inward = (float(np.clip(each, 0.0, deepest)) for each in ends)
        return cls(powers, deepest, values, missed, deepest, (outward, inward))


def _terms(points: Array, powers: Indices) -> Array:
    return np.asarray(np.prod(points[:, None] ** powers, axis=2))


# Components of stress, and (m, k, c) polynomials of them by k powers: m free numbers.
Shapes = Iterator[tuple[list[int], Array]]


def _free(powers: Indices) -> Shapes:
    """Of solids each component for itself: what varies along the front is not in balance here."""
    for component, least in enumerate(FREE):
        yield [component], np.eye(len(powers))[powers[:, 1] >= least][..., None]


def _balanced(powers: Indices) -> Shapes:
    """In the plane those that are elastic and in balance below a free surface, and harmonic zz.

    By Muskhelishvili's (Some Basic Problems of the Mathematical Theory of Elasticity, chapter 16)
    Phi = A z^n: xx + yy = 4 Re Phi(z), yy - i xy = Phi(z) - Phi(z̄) + (z - z̄) conj(Phi'(z)). Valid
    where body forces over the depth, and the bend of the surface over it, are small.
    """
    order, power = powers.sum(axis=1), powers[:, 1]
    count = comb(order, power)
    plane, harmonic = [], []
    for n, factor in product(range(order.max() + 1), (1.0, 1j)):
        own = np.where(order == n, count, 0)
        phi = factor * own * 1j**power
        mirrored = own * (-1j) ** power
        across = phi - mirrored * (factor + 2 * power * np.conj(factor))
        if n or factor == 1:  # the other one is a rotation
            plane.append([4 * phi.real - across.real, across.real, -across.imag])
            harmonic.append([phi.real])
    yield PLANE, np.array(plane).swapaxes(1, 2)
    yield [2], np.array(harmonic).swapaxes(1, 2)


@dataclass(frozen=True)
class EdgeField:
    """The stress of a body around an edge, without cracks, through n states.

    Of plane bodies it has c = 4 components, around a station of solids yz and xz too.

    Attributes:
        contact, edge, body: their names; of a station that of its front and its number.
        states: (n,) numbers of the states.
        finest: distance from the mouth from which on the stress is known [length]: 0 where slip
            zones are resolved, else an element.
        near: the stress by the tractions.
        smooth: what is missing to that of the body.
        size: of an element at the edge [length].
        start: x along the surface where rays start: the mouth, unless another one is set.
        pulled: x of the place that the edge takes when the surface is pulled most there; 0 unless
            that is more than at the mouth.
        other: places of every other state, as of `every_other`.
    """

    contact: str
    edge: str
    body: str
    states: Indices
    finest: float
    near: NearField
    smooth: SmoothStress
    size: float = 0.0
    start: float = 0.0
    pulled: float = 0.0
    other: Indices | None = None

    @property
    def coarser(self) -> EdgeField | None:
        """The field through every other state; None if they are too few to tell anything."""
        if self.other is None:
            return None
        near, smooth = self.near.through(self.other), self.smooth.through(self.other)
        return replace(self, states=self.states[self.other], near=near, smooth=smooth)

    @property
    def starts(self) -> tuple[EdgeField, ...]:
        """With rays from the mouth, and from the place that is pulled most if it is another."""
        return tuple(replace(self, start=each) for each in dict.fromkeys((0.0, self.pulled)))

    def reach(self, angle: float) -> float:
        """Length of a ray at an angle from the inward normal, inside of what is known."""
        aside = math.sin(angle)
        inside = self.smooth.widest[aside > 0] + (-self.start if aside > 0 else self.start)
        lateral = max(inside, 0.0) / abs(aside) if aside else math.inf
        return min(self.smooth.deepest / math.cos(angle), lateral)

    def stress(self, points: Array) -> Array:
        """(n, M, c) stress at points (M, 2)."""
        return self.near.at(points) + self.smooth.at(points)

    def along(self, angle: float, distances: Array) -> Array:
        """(n, D, c) stress on a ray from its start.

        Args:
            angle: from the inward normal, positive under the contact.
            distances: (D,) from there, up to `reach`.
        """
        ray = np.outer(distances, [math.sin(angle), -math.cos(angle)])
        return self.stress(ray + np.array([self.start, 0.0]))


def edge_field(
    result: Result, contact: Contact, station: Station, number: int, states: Indices | None = None
) -> EdgeField | str:
    """The stress around an edge, or the reason why it is not known.

    Args:
        result: of plane bodies.
        contact: of it.
        station: edge of the contact.
        number: of the body, 0 or 1.
        states: of half-planes, others than those of the evaluated or worst cycle.
    """
    if reason := _obstacle(result, contact, station):
        return reason
    pair, judged = _pair(result, contact), states is None
    history = result.stress_history(contact.pair) if result.has_stress else None
    if history is not None:
        states = history.states
    elif states is None:
        states = judged_states(result.solution, result.contacts)
    place = edge_places(contact, station, states)
    if not np.isfinite(place).all():
        return Kind.NO_PLACE.seen
    if history is None and not result.solution.keeps(int(states[0]), int(states[-1])):
        return Kind.NOT_KEPT.seen
    side = Side(number, station.inward, float(np.min(station.inward * place)))
    tractions = _tractions(result, contact, states, side, history)
    near = tractions.near(np.zeros(1))
    if history is None:
        smooth: SmoothStress | str = _bulk(result, contact, states, number)
    else:
        smooth = _rest(history, near, side, element_size(history.arc, side.place))
    if isinstance(smooth, str):
        return smooth
    body, size = (pair.body1, pair.body2)[number], element_size(pair.surface.arc, side.place)
    finest = _finest(station, size)
    other = every_other(result.solution.values[states], contact.normal_force[states])
    field = EdgeField(
        contact.name, station.front, body, states, finest, near, smooth, size, other=other
    )
    return _pulled(tractions, field, side.x(place)) if judged else field


def _finest(station: Station, size: float) -> float:
    """Distance from the edge from which on the stress of the tractions is right.

    On a cylinder with d = ΔK_T/(f K_N) of 3.0, 2.6, 2.2, 1.4 elements the tension at the edge is
    1.9, 2.2, 2.7, 5 % too small, a tenth of an element below it 1.2, 1.5, 2, 5 %. From one element
    on the stress is right to 0.6 % of p0.
    """
    return 0.0 if station.slip_by_range >= 2.5 * size else size


def error_of_tractions(station: Station) -> float:
    """Relative error of stresses at an edge by the bars of ΔK_T and K_N; NaN where unknown."""
    k_n, spread = station.decisive_k_n
    return math.hypot(station.range_error, spread / k_n)


def _obstacle(result: Result, contact: Contact, station: Station) -> str:
    """Reason why the stress is not known, or an empty text."""
    pair = _pair(result, contact)
    moves = pair.surface.frames.shape[1] > len(pair.surface.points[0])
    checks = {
        Kind.NOT_PLANE: contact.solid or moves,
        Kind.INCOMPLETE: result.failure is not None,
        Kind.CRYSTAL: not all(isotropic(result.case.bodies[n]) for n in (pair.body1, pair.body2)),
    }
    unstressed = result.backend != "halfplane" and not result.has_stress
    found = Reason.first(checks) or withheld(station, ranged=False)
    return (found or Reason.first({Kind.NO_STRESS: unstressed})).text


def edgeless(contact: Contact) -> str:
    """Reason why a contact has nothing to be judged; empty if it has edges or stations."""
    if contact.edges:
        return ""
    reason = contact.lacks[0].text if contact.lacks else "it carries no force"
    return f"no edge or front is known: {reason}"


def _pair(result: Result, contact: Contact) -> ContactHistory:
    """A contact, or any of the patches of its pair: all of them have its surface and bodies."""
    return next(each for each in result.solution.contacts if each.pair == contact.pair)


def _tractions(
    result: Result, contact: Contact, states: Indices, side: Side, history: StressHistory | None
) -> ContactTractions:
    """Those of a result, in the states of its stress if there is one."""
    pair = _pair(result, contact)
    body = isotropic(result.case.bodies[(pair.body1, pair.body2)[side.body]])
    assert body is not None
    own = [each for each in result.contacts if each.pair == contact.pair]
    ends = np.array([edge_places(patch, each, states) for patch in own for each in patch.stations])
    if history is None:
        patches = [each for each in result.solution.contacts if each.pair == contact.pair]
        values = np.sum([each.mean_traction[states] for each in patches], axis=0)
    else:
        values = history.traction
    across = body.poisson if result.case.model.plane == "strain" else 0.0
    return ContactTractions(side, pair.surface.arc, values, ends, across)


def _pulled(tractions: ContactTractions, field: EdgeField, edges: Array) -> EdgeField:
    """A field that knows where the edge is, of its places x (n,), when it is pulled most."""
    places = np.stack([edges, np.zeros_like(edges)], axis=1)
    near = [
        tractions.at(state).near(place[:1]).at(place[None])[0, 0, 0]
        for state, place in enumerate(places)
    ]
    found = pulled_most(field, edges, near + field.smooth.at(places)[..., 0].diagonal())
    looked = np.array([0.0, found.pulled])
    return replace(found, near=tractions.near(looked)) if found.pulled else field


def pulled_most(field: EdgeField, edges: Array, tension: Array) -> EdgeField:
    """A field that knows the place that the edge takes when the surface is pulled most there.

    Args:
        field: in n states.
        edges: (n,) x of the edge.
        tension: (n,) stress along the surface at the edge.
    """
    mouth = field.along(0.0, np.zeros(1))[:, 0, 0].max()
    at = int(np.argmax(tension))
    more = tension[at] > (1 + WITHIN_ELEMENT) * max(mouth, 0.0)
    return replace(field, pulled=float(edges[at]) if more else 0.0)


def _bulk(result: Result, contact: Contact, states: Indices, number: int) -> SmoothStress:
    """The bulk stress of a half-plane: a tension of body 2.

    The driver makes surface 2 stretch by sigma0/(2 E*) more than surface 1; it is a load of body 2.
    """
    pair, solution, plane = _pair(result, contact), result.solution, result.case.model.plane
    moduli = [plane_modulus(result.case.bodies[name], plane) for name in (pair.body1, pair.body2)]
    values = np.zeros((len(states), 1, 4))
    if number == 1:
        share = moduli[1] * sum(1 / each for each in moduli) / 2
        place = solution.drivers.index("tension")
        values[:, 0, 0] = share * solution.driver_values[states, place]
    body = isotropic(result.case.bodies[(pair.body1, pair.body2)[number]])
    assert body is not None
    values[:, 0, 2] = (body.poisson if plane == "strain" else 0.0) * values[:, 0, 0]
    # Half-planes are asked for the stress up to four half-widths from the edge.
    width = 4 * float(np.nanmax(contact.half_width[states]))
    return SmoothStress(np.zeros((1, 2), dtype=np.int64), 1.0, values, 0.0, width, (width, width))


def _rest(history: StressHistory, near: NearField, side: Side, size: float) -> SmoothStress | str:
    """The stress of elements less that of the tractions, or why it is not known."""
    rows = _deep_rows(history.depths, size)
    if isinstance(rows, str):
        return rows
    body, x = history.bodies[side.body], side.x(history.arc)
    stress = _turned(body.stress[:, rows], history.frames[:, 1], body.normals, side.inward)
    places = np.stack(np.broadcast_arrays(x, -history.depths[rows, None]), axis=-1)
    beside = np.abs(x) <= history.depths[rows].max() + size
    used = beside & np.isfinite(stress).all(axis=(0, 3))
    return SmoothStress.of(places[used], stress[:, used] - near.at(places[used]), len(rows), POWER)


def _deep_rows(depths: Array, size: float) -> Indices | str:
    """Numbers of the depths (D,) at which the stress of elements is used, or why that will not do.

    Args:
        depths: of the stress.
        size: of an element.
    """
    rows = np.flatnonzero(depths >= SHALLOW * size)
    if len(rows) < FEWEST_ROWS:
        return (
            f"[output] stress_depths has {len(rows)} depths of {SHALLOW:g} elements, "
            f"{SHALLOW * size:.3g}, and more: {FEWEST_ROWS} are needed"
        )
    return rows


def _turned(stress: Array, tangents: Array, normals: Array, inward: int) -> Array:
    """(n, D, N, 4) components xx, yy, zz, xy with x along the surface inward and y outward."""
    xx, yy, zz, xy = np.moveaxis(stress, -1, 0)
    (t1, t2), (n1, n2) = tangents.T, normals.T
    along = xx * t1**2 + yy * t2**2 + 2 * xy * t1 * t2
    across = xx * n1**2 + yy * n2**2 + 2 * xy * n1 * n2
    sheared = xx * t1 * n1 + yy * t2 * n2 + xy * (t1 * n2 + t2 * n1)
    return np.stack([along, across, zz, inward * sheared], axis=-1)
