# SPDX-License-Identifier: LGPL-3.0-or-later
"""The stuck interface: the operator that every iteration and every companion solution re-uses."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Indices
from fretfe.contact.interface import Interface, coordinate_scale


class StuckOperator:
    """Inverse of the interface problem with a set of nodes stuck.

    The unknowns are the tractions y of the nodes and all coordinates c. With all of them stuck,

        [ A   G ] [y]   [ w − w0 − L a ]
        [ Gᵀ −K ] [c] = [ −R − H a     ]

    Prescribed coordinates get a spring in K, so that the operator exists when they hold a body.
    Their forces R are then unknown up to the spring's, which the conditions of a step account for.
    What is not stuck enters as a few unknown right-hand sides: see `fretfe.contact.newton`.

    Args:
        interface: the whole interface problem.
        nodes: nodes that take part; all others have no traction.
    """

    def __init__(self, interface: Interface, nodes: Indices) -> None:
        d = interface.components
        self.nodes = nodes
        self.rows = (nodes[:, None] * d + np.arange(d)).ravel()
        count = len(interface.coordinates)
        level = np.trace(interface.compliance) / len(interface.compliance)
        scale = coordinate_scale(interface) * level
        #: (m,) stiffness of the springs on prescribed coordinates.
        self.springs = np.where(interface.prescribed, level / scale**2, 0.0)
        size = len(self.rows) + count
        matrix = np.empty((size, size))
        split = len(self.rows)
        matrix[:split, :split] = interface.compliance[np.ix_(self.rows, self.rows)]
        matrix[:split, split:] = interface.motion[self.rows]
        matrix[split:, :split] = interface.motion[self.rows].T
        matrix[split:, split:] = -interface.stiffness - np.diag(self.springs)
        # Equilibrated: every diagonal entry of A about 1, every column of G of comparable size.
        units = np.concatenate([np.full(split, level**-0.5), scale / level**0.5])
        matrix *= units
        matrix *= units[:, None]
        self.inverse = np.linalg.inv(matrix)
        self.inverse *= units
        self.inverse *= units[:, None]
        #: Components of w at nodes that take no part, and (k, n + m) effect of the unknowns there.
        self.others = np.delete(np.arange(len(interface.compliance)), self.rows)
        self.effect = np.hstack(
            [interface.compliance[np.ix_(self.others, self.rows)], interface.motion[self.others]]
        )

    @property
    def bytes(self) -> int:
        """Memory that the operator takes."""
        return int(self.inverse.nbytes + self.effect.nbytes)
