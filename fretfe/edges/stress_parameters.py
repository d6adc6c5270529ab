# SPDX-License-Identifier: LGPL-3.0-or-later
"""Local parameters of fretting fatigue that need the stress in the bodies.

Of the evaluated cycle or, under irregular loads, of the worst one: of the states that a
`StressHistory` has.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.case import Body
from fretfe.edges.critical_planes import (
    Critical,
    Parameter,
    fatemi_socie,
    find_critical,
    smith_watson_topper,
)
from fretfe.edges.stress_history import StressHistory
from fretfe.results.solution import OPEN


@dataclass(frozen=True)
class StressParameters:
    """Of one body at the N nodes of a contact and D depths below; NaN where it does not reach.

    Attributes:
        body: its name.
        depths: (D,) [length].
        largest_tension: (D, N) largest stress along the surface in the cycle [stress].
        ruiz2: (N,) second parameter of Ruiz, Boddington and Chen (Exp. Mech. 24, 1984) at the
            surface: the largest tension along it, zero if there is none, times the largest |q|
            times the range of the slip [stress^2 length]. NaN without the depth 0.
        swt: (D, N) Smith-Watson-Topper parameter [stress].
        swt_normal: (D, N, 3) normal of its plane.
        shear_strain: (D, N) largest amplitude of the shear strain on any plane [1].
        fatemi_socie: (D, N) Fatemi-Socie parameter [1]; None without its two numbers.
    """

    body: str
    depths: Array
    largest_tension: Array
    ruiz2: Array
    swt: Array
    swt_normal: Array
    shear_strain: Array
    fatemi_socie: Array | None


def stress_parameters(
    history: StressHistory,
    number: int,
    material: Body,
    shear_numbers: tuple[float, float] | None = None,
) -> StressParameters:
    """Parameters of one of the two bodies of a contact.

    Args:
        history: the stress near the contact.
        number: of the body, 0 or 1.
        material: of that body.
        shear_numbers: k and yield stress of Fatemi and Socie, if they are known.

    Raises:
        CaseError: as for `fatemi_socie`.
    """
    combined = fatemi_socie(*shear_numbers) if shear_numbers else None
    body = history.bodies[number]
    tension = _along_surface(body.stress, history.frames).max(axis=0)
    normal = _critical(body.stress, material, smith_watson_topper)
    shape = body.stress.shape[1:3]

    def sheared(parameter: Parameter) -> Array:
        return _critical(body.stress, material, parameter).value.reshape(shape)

    return StressParameters(
        body=body.name,
        depths=history.depths,
        largest_tension=tension,
        ruiz2=_ruiz2(history, tension),
        swt=normal.value.reshape(shape),
        swt_normal=normal.normal.reshape(*shape, 3),
        # Without the normal stress there is nothing to be weighted by the yield stress.
        shear_strain=sheared(fatemi_socie(0.0, 1.0)),
        fatemi_socie=sheared(combined) if combined else None,
    )


def _critical(stress: Array, material: Body, parameter: Parameter) -> Critical:
    """Largest parameter at D * N points, of stresses (n, D, N, 4)."""
    states, depths, nodes, own = stress.shape
    tensors = np.zeros((states, depths * nodes, 6))
    tensors[..., :own] = stress.reshape(states, depths * nodes, own)
    return find_critical(tensors, material.young, material.poisson, parameter)


def _along_surface(stress: Array, frames: Array) -> Array:
    """(n, D, N) stress along the tangent of the contact, from (n, D, N, 4)."""
    x, y = frames[:, 1].T
    xx, yy, _, xy = np.moveaxis(stress, 3, 0)
    return np.asarray(xx * x**2 + yy * y**2 + 2 * xy * x * y)


def _ruiz2(history: StressHistory, tension: Array) -> Array:
    at_surface = np.flatnonzero(history.depths == 0)
    if not len(at_surface):
        return np.full(len(history.arc), np.nan)
    touched: Bools = history.status != OPEN
    # The state before the first step belongs to the slip if the node is in contact after it.
    touched[0] = touched[min(1, len(touched) - 1)]
    slip = np.where(touched, history.slip, np.nan)
    extent = np.nan_to_num(np.fmax.reduce(slip) - np.fmin.reduce(slip))
    shear = np.abs(history.traction[..., 1]).max(axis=0)
    return np.asarray(np.maximum(tension[at_surface[0]], 0.0) * shear * extent)
