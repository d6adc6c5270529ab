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
    fatemi_socie,
    find_critical,
    smith_watson_topper,
)
from fretfe.edges.stress_history import StressHistory
from fretfe.results.solution import OPEN


@dataclass(frozen=True)
class ShearModel:
    """The two numbers of Fatemi and Socie, from tests of the material.

    Attributes:
        k: weight of the normal stress [1]; 0 for the amplitude of the shear strain alone.
        yield_stress: sigma_y [stress].
    """

    k: float
    yield_stress: float

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ValueError: if k is negative or the yield stress not positive.
        """
        if not (np.isfinite(self.k) and self.k >= 0):
            raise ValueError(f"expected k >= 0, found {self.k:g}")
        if not (np.isfinite(self.yield_stress) and self.yield_stress > 0):
            raise ValueError(f"expected a yield stress > 0, found {self.yield_stress:g}")


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
    history: StressHistory, number: int, material: Body, shear: ShearModel | None = None
) -> StressParameters:
    """Parameters of one of the two bodies of a contact.

    Args:
        history: the stress near the contact.
        number: of the body, 0 or 1.
        material: of that body.
        shear: numbers of Fatemi and Socie, if they are known.
    """
    body = history.bodies[number]
    tension = _along_surface(body.stress, history.frames).max(axis=0)
    normal = _critical(body.stress, material)
    sheared = _critical(body.stress, material, ShearModel(0.0, 1.0))
    combined = _critical(body.stress, material, shear) if shear else None
    shape = body.stress.shape[1:3]
    return StressParameters(
        body=body.name,
        depths=history.depths,
        largest_tension=tension,
        ruiz2=_ruiz2(history, tension),
        swt=normal.value.reshape(shape),
        swt_normal=normal.normal.reshape(*shape, 3),
        shear_strain=sheared.value.reshape(shape),
        fatemi_socie=combined.value.reshape(shape) if combined else None,
    )


def _critical(stress: Array, material: Body, shear: ShearModel | None = None) -> Critical:
    """Largest parameter at D * N points, of stresses (n, D, N, 4)."""
    states, depths, nodes, own = stress.shape
    tensors = np.zeros((states, depths * nodes, 6))
    tensors[..., :own] = stress.reshape(states, depths * nodes, own)
    parameter = fatemi_socie(shear.k, shear.yield_stress) if shear else smith_watson_topper
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
