# SPDX-License-Identifier: LGPL-3.0-or-later
"""Steps within which a contact turns from one way of sliding to another, or parts.

A flank that slid under its load jams when that falls: it sticks, P grows, and only then does it
slide back. Both ends of the step know nothing of that. Where P is constant they know all of it.
"""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.contact.state import STICK, ContactState, lengths

# Changes of P below this part of it are none, and so much of what P was is no load.
SAME_FORCE = 1e-6
# Sliding goes on if the shear before did so much of the work that friction may do on the way.
GOES_ON = 0.99
# Part of the largest P from which on a contact may lose all of it at once.
LAST_FORCE = 0.03


def turns(
    before: ContactState, after: ContactState, bound: Array, nodes: slice, normal: Array
) -> bool:
    """True if a contact begins to slide as a whole between two states, or parts, while P changes.

    Args:
        before: weighted tractions and displacements.
        after: the later ones.
        bound: (N,) weighted f p before.
        nodes: of the contact.
        normal: (3,) P before and after, and the largest one.
    """
    begin, end, largest = normal
    if abs(end - begin) <= SAME_FORCE * max(begin, end):
        return False
    if end <= SAME_FORCE * largest:
        return bool(begin > LAST_FORCE * largest)
    if np.any(after.status[nodes] == STICK):
        return False
    way = before.relative[nodes, 1:] - after.relative[nodes, 1:]
    done, possible = np.sum(before.traction[nodes, 1:] * way), bound[nodes] @ lengths(way)
    return bool(not done >= GOES_ON * possible > 0)
