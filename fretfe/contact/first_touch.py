# SPDX-License-Identifier: LGPL-3.0-or-later
"""The first touch of bodies that nothing holds yet: rigid motion until contact stops it.

Loads do the most work on a loose body that they can before it penetrates another one,

    max F·c   such that   g + G c ≥ 0,

a linear programme in its few motions c, with the gap g that loads and supports alone leave.
Friction and the deformation by pressures are left out: this is a start for Newton's method, not a
solution.
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.contact.interface import Interface, unresisted_motions
from fretfe.contact.state import StepLoads


def displacement_at_first_touch(
    interface: Interface, loads: StepLoads, held: Bools
) -> Array | None:
    """(N, d) gap and tangential displacement when loose bodies have come to rest on others.

    Args:
        interface: the interface problem.
        loads: what moves them.
        held: (N,) nodes that hold bodies together already.

    Returns:
        Weighted, as without tractions; None if no body is loose, or if contact does not stop one.
    """
    # Imported where it is needed: most histories press bodies on that are held.
    from scipy.optimize import linprog

    released = ~interface.prescribed
    loose = unresisted_motions(interface, released, np.repeat(held, interface.components))
    if not loose.shape[1]:
        return None
    forces = interface.coordinate_loads @ loads.amplitudes + loads.values
    displacement = _without_contact(interface, loads, forces)
    shape = interface.size, interface.components
    moved = (interface.motion @ loose).reshape(*shape, -1)
    found = linprog(
        -(forces @ loose), A_ub=-moved[:, 0], b_ub=displacement[:, 0], bounds=(None, None)
    )
    return displacement + moved @ found.x if found.success else None


def _without_contact(interface: Interface, loads: StepLoads, forces: Array) -> Array:
    """(N, d) gap and tangential displacement by loads and supports alone.

    Of the motions that nothing resists the smallest is taken: the linear programme has the rest.

    Args:
        interface: the interface problem.
        loads: what acts.
        forces: (C,) of the loads on the coordinates.
    """
    released = ~interface.prescribed
    at_rest = np.where(released, 0.0, loads.values)
    stiff = interface.stiffness[np.ix_(released, released)]
    elastic = (forces - interface.stiffness @ at_rest)[released]
    at_rest[released] = np.linalg.lstsq(stiff, elastic, rcond=None)[0]
    shape = interface.size, interface.components
    moved: Array = (interface.motion @ at_rest).reshape(shape)
    return loads.without_traction(interface) + moved
