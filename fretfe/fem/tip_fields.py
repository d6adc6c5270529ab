# SPDX-License-Identifier: LGPL-3.0-or-later
"""Crack-tip fields along straight and bent fronts, in UFL, for interaction integrals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from fretfe._typing import Array
from fretfe.fem.elasticity import (
    CrystalElasticity,
    Elasticity,
    of_dimension,
    padded,
)
from fretfe.materials.crystals import CrackTip, turned

# Angles below this are equal to their tangents to round-off.
SMALL_ANGLE = 1e-4


@dataclass(frozen=True)
class FrontPlace:
    """A place in UFL as seen from the front; all lengths 0 along the front in the plane.

    Attributes:
        axes: rows across, inward, along of the nearest point of the osculating circle, as many as
            the displacement has components.
        turn: the same in the axes of the station; None in the plane.
        height: over the tangent plane, lifted a little out of the other body.
        ahead: distance from the circle in that plane, positive in the contact.
        arc: along the circle, from the station.
        bend: curvature of the circle through the place.
        stretch: arc of the station's circle per length along that through the place.
        radius: distance from the front by these two, not quite zero.
    """

    axes: Any
    turn: Any
    height: Any
    ahead: Any
    arc: Any
    bend: Any
    stretch: Any
    radius: Any


def front_place(offset: Any, frame: Any, curvature: Any, lift: Any) -> FrontPlace:
    """Coordinates of a place around a front.

    Args:
        offset: (d,) place less station.
        frame: (c, c) rows across, inward, along of the station, c components of the displacement.
        curvature: of the front, positive where the contact is convex; of no use in the plane.
        lift: height to add, hardly more than zero, positive in the body above.
    """
    local = frame * padded(offset, frame.ufl_shape[0])
    height = local[0] + lift
    if len(offset) == 2:
        radius = ufl.sqrt(height**2 + local[1] ** 2)
        return FrontPlace(frame, None, height, local[1], 0.0, 0.0, 1.0, radius)
    deep, side = local[1], local[2]
    turned, left = curvature * side, 1 - curvature * deep
    # Distance from the centre of the circle over its radius.
    root = ufl.sqrt(turned**2 + left**2)
    ahead = (2 * deep - curvature * (deep**2 + side**2)) / (1 + root)
    # Half the angle: its tangent is finite but behind the centre.
    tangent = turned / (root + left)
    small = ufl.lt(abs(tangent), SMALL_ANGLE)
    ratio = ufl.conditional(
        small, 1 - tangent**2 / 3, ufl.atan(tangent) / ufl.conditional(small, 1.0, tangent)
    )
    cosine, sine = left / root, turned / root
    turn = ufl.as_matrix([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    return FrontPlace(
        axes=turn * frame,
        turn=turn,
        height=height,
        ahead=ahead,
        arc=2 * side / (root + left) * ratio,
        bend=curvature / root,
        stretch=1 / root,
        radius=ufl.sqrt(height**2 + ahead**2),
    )


@dataclass(frozen=True)
class TipField:
    """Field of a unit stress intensity factor in one mode, in the axes of `FrontPlace`.

    Attributes:
        gradient: (d, d) of the displacement.
        stress: (d, d).
        divergence: (d,) of the stress.
        inward: displacement along `inward`; of no use in the plane, and of crystals.
    """

    gradient: Any
    stress: Any
    divergence: Any
    inward: Any = 0


def tip_fields(
    place: FrontPlace, side: Any, material: Elasticity, epsilon: Any = None
) -> list[TipField]:
    """Fields of all modes: opening, shear along `inward`, and along `along` unless c is 2.

    Args:
        place: where.
        side: 1 in the body above the interface, -1 below.
        material: of the body.
        epsilon: of full stick between unlike bodies; None between similar ones.
    """
    # The branch of the angle is cut through the other body: surfaces are never quite straight.
    angle = ufl.variable(side * (ufl.pi / 2 + ufl.atan2(-place.ahead, side * place.height)))
    turns = place.ahead / place.radius**2, -place.height / place.radius**2
    sine, cosine, k = ufl.sin(angle / 2), ufl.cos(angle / 2), material.kolosov
    shapes = [
        [sine * (k + 1 - 2 * cosine**2), cosine * (k - 1 + 2 * sine**2), ufl.as_ufl(0)],
        [cosine * (1 - k + 2 * sine**2), sine * (k + 1 + 2 * cosine**2), ufl.as_ufl(0)],
        [ufl.as_ufl(0), ufl.as_ufl(0), 4 * sine],
    ]
    size = place.axes.ufl_shape[0]
    fields = []
    if epsilon is not None:
        fields = _bimaterial_fields(place, side, angle, turns, material, epsilon)
    for shape in shapes[len(fields) : size]:
        slopes = [
            _slopes(place, each, ufl.diff(each, angle), turns, material) for each in shape[:size]
        ]
        values = [_size(place, material) * each for each in shape]
        fields.append(
            _plane(slopes, material)
            if place.turn is None
            else _bent(place, values, slopes, material)
        )
    return fields


def _bimaterial_fields(
    place: FrontPlace,
    side: Any,
    angle: Any,
    turns: tuple[Any, Any],
    material: Elasticity,
    epsilon: Any,
) -> list[TipField]:
    """Fields of all modes at the edge of a bonded interface of unlike bodies.

    With z = x + i y inward and across, 2 mu (u_x + i u_y) = kappa phi(z) - omega(conj z)
    - (z - conj z) conj(phi'(z)), phi' = c e^(s pi epsilon) z^(-1/2 + i epsilon) and omega' =
    c e^(-s pi epsilon) z^(-1/2 + i epsilon), s the side and c = (K_I - i K_II)/(sqrt(8 pi)
    cosh(pi epsilon)): ahead s_yy - i s_xy = (K_I - i K_II) x^(-1/2 + i epsilon)/sqrt(2 pi)
    (Rice and Sih 1965), free of tractions behind. Shear along the front knows nothing of epsilon.
    """
    logarithm = ufl.variable(ufl.ln(place.radius))
    k, grown = material.kolosov, ufl.exp(epsilon * (side * ufl.pi - angle))
    real = (k * grown - 1 / grown) * ufl.cos(angle / 2)
    imaginary = (k * grown + 1 / grown) * ufl.sin(angle / 2)
    c, s = ufl.cos(epsilon * logarithm), ufl.sin(epsilon * logarithm)
    over = 0.25 + epsilon**2
    # e^(i epsilon ln r)/(1/2 + i epsilon) times both.
    g, h = (c / 2 + epsilon * s) / over, (s / 2 - epsilon * c) / over
    straight, across = g * real - h * imaginary, g * imaginary + h * real
    lag, apart = angle / 2 - epsilon * logarithm, 2 * ufl.sin(angle) * grown
    m, n = apart * ufl.sin(lag), -apart * ufl.cos(lag)
    scale, nought = 2 * ufl.cosh(ufl.pi * epsilon), ufl.as_ufl(0)
    shapes = [
        [(across + n) / scale, (straight + m) / scale, nought],
        [(m - straight) / scale, (across - n) / scale, nought],
        [nought, nought, 4 * ufl.sin(angle / 2)],
    ]
    size = place.axes.ufl_shape[0]
    fields = []
    for shape in shapes[:size]:
        slopes = [
            _slopes(place, each, ufl.diff(each, angle), turns, material, ufl.diff(each, logarithm))
            for each in shape[:size]
        ]
        values = [_size(place, material) * each for each in shape]
        fields.append(
            _plane(slopes, material)
            if place.turn is None
            else _bent(place, values, slopes, material)
        )
    return fields


def _size(place: FrontPlace, material: Elasticity) -> Any:
    return ufl.sqrt(place.radius / (2 * ufl.pi)) / (2 * material.shear_modulus)


def _slopes(
    place: FrontPlace,
    shape: Any,
    turning: Any,
    turns: tuple[Any, Any],
    material: Elasticity,
    growing: Any = 0,
) -> list[Any]:
    """Slopes across and inward of a component sqrt(r/2 pi)/(2 mu) times a function of the angle.

    Args:
        place: where.
        shape: the function.
        turning: its derivative.
        turns: slopes of the angle.
        material: of the body.
        growing: derivative of the function by ln r.
    """
    growth = place.height, place.ahead
    return [
        _size(place, material)
        * ((shape / 2 + growing) * grown / place.radius**2 + turning * turned)
        for grown, turned in zip(growth, turns, strict=True)
    ]


def _plane(slopes: list[list[Any]], material: Elasticity | CrystalElasticity) -> TipField:
    """The field of a straight front in the plane; slopes (c, 2) of c components."""
    size = len(slopes)
    gradient = ufl.as_matrix([[*row, *[0] * (size - len(row))] for row in slopes])
    return TipField(gradient, material.stress(ufl.sym(gradient)), ufl.as_vector([0] * size))


def _bent(
    place: FrontPlace, values: list[Any], slopes: list[list[Any]], material: Elasticity
) -> TipField:
    """The field along a front in space; values (3,) and slopes (3, 2) of its components."""
    bend, inward, along = place.bend, values[1], values[2]
    turned = (0, bend * along, -bend * inward)
    gradient = ufl.as_matrix([[*row, last] for row, last in zip(slopes, turned, strict=True)])
    stress = material.stress(ufl.sym(gradient))
    # Slopes of what the bend adds to the strain: a stretch along the front, and a shear.
    stretch_across = -bend * slopes[1][0]
    stretch_inward = -bend * (bend * inward + slopes[1][1])
    shear_inward = bend * (bend * along + slopes[2][1])
    divergence = ufl.as_vector(
        [
            material.first_lame * stretch_across - bend * stress[0, 1],
            material.first_lame * stretch_inward + bend * (stress[2, 2] - stress[1, 1]),
            material.shear_modulus * shear_inward - 2 * bend * stress[1, 2],
        ]
    )
    return TipField(gradient, stress, divergence, inward)


# A complex number in UFL, or of constants: real and imaginary part.
Complex = tuple[Any, Any]


class CrystalTip:
    """Constants of `CrackTip` at the station that is looked at, in UFL.

    Args:
        mesh: of the body.
        stiffness: (6, 6) of the body in the axes of the model.
        size: number of components of the displacement.
    """

    def __init__(self, mesh: Any, stiffness: Array, size: int) -> None:
        self._given, self._size = stiffness, size
        # In the axes of the station.
        self._stiffness = fem.Constant(mesh, of_dimension(stiffness, size))
        self._roots = fem.Constant(mesh, np.zeros((2, size)))
        # With powers 0, 1 and 2 of the roots: slopes along the normal bring one each.
        self._shapes = fem.Constant(mesh, np.zeros((3, 2, size, size, size)))

    def look_at(self, frame: Array) -> None:
        """Take the constants of a station with a frame (d, d)."""
        whole = np.eye(3)
        whole[: self._size, : self._size] = frame
        own = turned(self._given, whole)
        self._stiffness.value[:] = of_dimension(own, self._size)
        tip = CrackTip.of(own, self._size)
        powers = np.array([tip.shapes * tip.roots**power for power in range(3)])
        self._roots.value[:] = tip.roots.real, tip.roots.imag
        self._shapes.value[:] = np.stack([powers.real, powers.imag], axis=1)

    def elasticity(self, place: FrontPlace) -> CrystalElasticity:
        """Hooke's law in the axes of a place."""
        return CrystalElasticity(self._stiffness, place.turn)

    def fields(self, place: FrontPlace, side: Any) -> list[TipField]:
        """Fields of all modes; arguments as of `tip_fields`."""
        material = self.elasticity(place)
        roots = [self._square_root(place, side, a) for a in range(self._size)]
        inverses = [_inverse(root) for root in roots]
        cubes = [_product(each, _product(each, each)) for each in inverses]
        fields = []
        for mode in range(self._size):
            slopes = [
                [self._component(mode, i, power, inverses) / 2 for power in (1, 0)]
                for i in range(self._size)
            ]
            if place.turn is None:
                fields.append(_plane(slopes, material))
                continue
            values = [self._component(mode, i, 0, roots) for i in range(3)]
            curved = [
                [-self._component(mode, i, power, cubes) / 4 for power in (2, 1, 0)]
                for i in range(3)
            ]
            fields.append(_bent_crystal(place, values, slopes, curved, material))
        return fields

    def _square_root(self, place: FrontPlace, side: Any, root: int) -> Complex:
        """Root of x + p y, cut through the other body."""
        real = place.ahead + self._roots[0, root] * place.height
        imaginary = self._roots[1, root] * place.height
        size = ufl.sqrt(real**2 + imaginary**2)
        first = ufl.sqrt((size + side * imaginary) / 2)
        second = -side * real / (2 * first)
        return (first - side * second) / np.sqrt(2), (side * first + second) / np.sqrt(2)

    def _component(self, mode: int, component: int, power: int, values: list[Complex]) -> Any:
        """sqrt(2/pi) Re sum of c p^power times values of each root."""
        shapes = self._shapes
        return np.sqrt(2 / np.pi) * sum(
            shapes[power, 0, mode, component, a] * real - shapes[power, 1, mode, component, a] * im
            for a, (real, im) in enumerate(values)
        )


def _inverse(number: Complex) -> Complex:
    squared = number[0] ** 2 + number[1] ** 2
    return number[0] / squared, -number[1] / squared


def _product(one: Complex, other: Complex) -> Complex:
    return one[0] * other[0] - one[1] * other[1], one[0] * other[1] + one[1] * other[0]


def _bent_crystal(
    place: FrontPlace,
    values: list[Any],
    slopes: list[list[Any]],
    curved: list[list[Any]],
    material: CrystalElasticity,
) -> TipField:
    """The field along a front in space of a crystal, which does not turn with the front.

    Args:
        place: where.
        values: (3,) components of the displacement, the same all along the front.
        slopes: (3, 2) their slopes across and inward.
        curved: (3, 3) their second derivatives: twice across, across and inward, twice inward.
        material: of the body, in the axes of the place.
    """
    bend, (_, inward, along) = place.bend, values
    by_turning = [0, bend * along, -bend * inward]
    gradient = ufl.as_matrix([[*row, last] for row, last in zip(slopes, by_turning, strict=True)])
    strain = ufl.sym(gradient)
    stress = material.stress(strain)
    by_across = [0, bend * slopes[2][0], -bend * slopes[1][0]]
    by_inward = [
        0,
        bend * (bend * along + slopes[2][1]),
        -bend * (bend * inward + slopes[1][1]),
    ]
    across, ahead = (
        material.stress(ufl.sym(ufl.as_matrix(rows)))
        for rows in (
            [[two, mixed, last] for (two, mixed, _), last in zip(curved, by_across, strict=True)],
            [[mixed, two, last] for (_, mixed, two), last in zip(curved, by_inward, strict=True)],
        )
    )
    turn = bend * ufl.as_matrix([[0, 0, 0], [0, 0, 1], [0, -1, 0]])
    beside = material.stress(2 * ufl.sym(turn * strain))
    divergence = ufl.as_vector([across[i, 0] + ahead[i, 1] + beside[i, 2] for i in range(3)])
    return TipField(gradient, stress, divergence)
