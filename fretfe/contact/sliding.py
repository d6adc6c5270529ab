# SPDX-License-Identifier: LGPL-3.0-or-later
"""Direct solution of contact conditions in the plane, for contacts most of which slide.

The shear of a slipping node is its pressure times `pull`: it is no unknown. What is left are the
pressures of slipping nodes, the tractions of stuck ones and the coordinates.
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.contact.interface import Interface, coordinate_scale
from fretfe.contact.operator import Conditions, Response
from fretfe.contact.state import SLIP, STICK


def unknown_tractions(conditions: Conditions) -> int:
    """Number of traction components that are unknown once slip has been eliminated."""
    d = conditions.pull.shape[1] + 1
    stuck = np.count_nonzero(conditions.status == STICK)
    return int(d * stuck + np.count_nonzero(conditions.status == SLIP))


def solve_directly(
    interface: Interface, conditions: Conditions, free: Array, forces: Array
) -> Response:
    """Solve linear contact conditions of a plane problem; see `StuckContact.release`.

    Args:
        interface: the interface problem, d = 2.
        conditions: contact conditions; bodies do not float.
        free: (N, 2, J) gap and increment without tractions and coordinates.
        forces: (m, J) forces on the coordinates, R + H a.

    Raises:
        numpy.linalg.LinAlgError: if the conditions leave a motion without any resistance.
    """
    stuck, slipping = (conditions.status == each for each in (STICK, SLIP))
    level, scale = interface.compliance.level, coordinate_scale(interface)
    normal = 2 * np.flatnonzero(slipping)
    held = np.concatenate([(2 * np.flatnonzero(stuck)[:, None] + [0, 1]).ravel(), normal])
    pull = conditions.pull[slipping]
    split = len(held)
    matrix = np.empty((split + len(scale), split + len(scale)))
    matrix[:split, :split] = interface.compliance.block(held, held)
    sliding = slice(split - len(normal), split)
    if pull.any():
        matrix[:split, sliding] += interface.compliance.block(held, normal + 1) * pull.T
    matrix[:split, :split] /= level
    motion = interface.motion * scale
    work = motion[held]
    work[sliding] += pull * motion[normal + 1]
    matrix[:split, split:] = motion[held]
    matrix[split:, :split] = work.T
    matrix[split:, split:] = -interface.stiffness * np.outer(scale, scale) * level
    flat = free.reshape(-1, free.shape[-1])
    target = np.vstack([-flat[held], -forces * scale[:, None] * level])
    known = split + np.flatnonzero(conditions.known)
    matrix[known] = 0.0
    matrix[known, known] = 1.0
    target[known] = conditions.amplitudes / scale[conditions.known, None]
    solved = np.linalg.solve(matrix, target)
    coordinates = solved[split:] * scale[:, None]
    traction = np.zeros_like(flat)
    traction[held] = solved[:split] / level
    traction[normal + 1] = pull * traction[normal]
    relative = interface.motion @ coordinates + flat
    for case, column in enumerate(traction.T):
        relative[:, case] += interface.compliance.apply(np.ascontiguousarray(column))
    relative[held] = 0.0
    return Response(traction.reshape(free.shape), relative.reshape(free.shape), coordinates)
