# SPDX-License-Identifier: LGPL-3.0-or-later
"""Crack-tip fields around a contact front, straight or curved, in UFL.

Axes are ordered like the components of a traction: `across`, `inward` and, in space, `along` the
front; so are the modes. Around a curved front the axes turn with the nearest point of the circle
that osculates it, of curvature k: s is the distance inward from this circle, h the height over its
plane, bend = k/(1 - k s), and a field (V, U, W)(s, h) that is the same all along it has the
gradient, rows by component and columns by axis,

    V,h  V,s  0
    U,h  U,s  bend W
    W,h  W,s  -bend U

With the plane fields of Williams (1957) for V and U and that of mode III for W, the stress of a
straight front is in equilibrium; that of a curved one is not, and its divergence is returned.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl

from fretfe.fem.elasticity import Elasticity

# Distances below this fraction of the reach are zero.
SMALLEST = 1e-9
# Angles below this are equal to their tangents to round-off.
SMALL_ANGLE = 1e-4


@dataclass(frozen=True)
class FrontPlace:
    """A place in UFL as seen from the front; all lengths 0 along the front in the plane.

    Attributes:
        axes: rows across, inward, along of the nearest point of the osculating circle.
        height: over the tangent plane.
        ahead: distance from the circle in that plane, positive in the contact.
        arc: along the circle, from the station.
        bend: curvature of the circle through the place.
        stretch: arc of the station's circle per length along that through the place.
        radius: distance from the front, not quite zero.
    """

    axes: Any
    height: Any
    ahead: Any
    arc: Any
    bend: Any
    stretch: Any
    radius: Any


def front_place(offset: Any, frame: Any, curvature: Any, nothing: Any) -> FrontPlace:
    """Coordinates of a place around a front.

    Args:
        offset: (d,) place less station.
        frame: (d, d) rows across, inward, along of the station.
        curvature: of the front, positive where the contact is convex; of no use in the plane.
        nothing: a length that is zero.
    """
    local = frame * offset
    if len(offset) == 2:
        radius = ufl.sqrt(local[0] ** 2 + local[1] ** 2 + nothing**2)
        return FrontPlace(frame, local[0], local[1], 0.0, 0.0, 1.0, radius)
    height, deep, side = local[0], local[1], local[2]
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
        height=height,
        ahead=ahead,
        arc=2 * side / (root + left) * ratio,
        bend=curvature / root,
        stretch=1 / root,
        radius=ufl.sqrt(height**2 + ahead**2 + nothing**2),
    )


@dataclass(frozen=True)
class TipField:
    """Field of a unit stress intensity factor in one mode, in the axes of `FrontPlace`.

    Attributes:
        gradient: (d, d) of the displacement.
        stress: (d, d).
        divergence: (d,) of the stress.
    """

    gradient: Any
    stress: Any
    divergence: Any


def tip_fields(place: FrontPlace, side: Any, material: Elasticity, nothing: Any) -> list[TipField]:
    """Fields of all modes: opening, shear along `inward` and, in space, shear along `along`.

    Args:
        place: where.
        side: 1 in the body above the interface, -1 below.
        material: of the body.
        nothing: a length that is zero.
    """
    # The branch of the angle is cut through the other body: surfaces are never quite straight.
    lifted = side * place.height + nothing
    angle = ufl.variable(side * (ufl.pi / 2 + ufl.atan2(-place.ahead, lifted)))
    squared = place.ahead**2 + lifted**2
    turns = place.ahead / squared, -side * lifted / squared
    sine, cosine, k = ufl.sin(angle / 2), ufl.cos(angle / 2), material.kolosov
    shapes = [
        [sine * (k + 1 - 2 * cosine**2), cosine * (k - 1 + 2 * sine**2), ufl.as_ufl(0)],
        [cosine * (1 - k + 2 * sine**2), sine * (k + 1 + 2 * cosine**2), ufl.as_ufl(0)],
        [ufl.as_ufl(0), ufl.as_ufl(0), 4 * sine],
    ]
    size = place.axes.ufl_shape[0]
    fields = []
    for shape in shapes[:size]:
        slopes = [
            _slopes(place, each, ufl.diff(each, angle), turns, material) for each in shape[:size]
        ]
        values = [_size(place, material) * each for each in shape]
        fields.append(
            _plane(slopes, material) if size == 2 else _bent(place, values, slopes, material)
        )
    return fields


def _size(place: FrontPlace, material: Elasticity) -> Any:
    return ufl.sqrt(place.radius / (2 * ufl.pi)) / (2 * material.shear_modulus)


def _slopes(
    place: FrontPlace, shape: Any, turning: Any, turns: tuple[Any, Any], material: Elasticity
) -> list[Any]:
    """Slopes across and inward of a component sqrt(r/2 pi)/(2 mu) times a function of the angle.

    Args:
        place: where.
        shape: the function.
        turning: its derivative.
        turns: slopes of the angle.
        material: of the body.
    """
    growth = place.height, place.ahead
    return [
        _size(place, material) * (shape / 2 * grown / place.radius**2 + turning * turned)
        for grown, turned in zip(growth, turns, strict=True)
    ]


def _plane(slopes: list[list[Any]], material: Elasticity) -> TipField:
    """The field of a straight front in the plane."""
    gradient = ufl.as_matrix(slopes)
    return TipField(gradient, material.stress(ufl.sym(gradient)), ufl.as_vector([0, 0]))


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
    return TipField(gradient, stress, divergence)
