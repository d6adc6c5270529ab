# SPDX-License-Identifier: LGPL-3.0-or-later
"""The interface problem: elastic bodies reduced to their contact nodes and rigid motions.

Everything is written in weighted nodal quantities of N multiplier nodes with d components each
(normal, then tangents). With W_i the integral of hat function i and λ_i
the nodal traction (p_i, q_i),

    y_i = √W_i λ_i,        w_i = (∫ φ_i w) / √W_i

so that y·w is work, both are of comparable size on graded meshes, and the friction cone of a node
is the same in y as in λ. w_i/√W_i is the nodal mean of gap and tangential displacement. The bodies
turn into

    w = w0 + A y + G c + L a            (A symmetric, positive semi-definite)
    R + H a = −Gᵀ y + K c

with the coordinates c (amplitudes of rigid boundaries, and of rigid modes that only contact
restrains), the forces R on them and the load amplitudes a. The number of space dimensions appears
only as d.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.contact.compliance import Compliance

# Relative size below which a motion is resisted by nothing but round-off.
UNRESISTED = 1e-9


@dataclass(frozen=True)
class Coordinate:
    """One amplitude c_j of the interface problem.

    Attributes:
        label: name in messages and results.
        body: name of the body.
        control: "force" or "displacement" (driven by a channel), "fixed", or "free" (a rigid mode
            restrained only by contact; no force acts on it).
        channel: name of the load that drives it, "" if none.
    """

    label: str
    body: str
    control: str
    channel: str = ""

    @property
    def prescribed(self) -> bool:
        """True if the amplitude is known and the force is not."""
        return self.control in ("displacement", "fixed")


@dataclass(frozen=True)
class Interface:
    """Operators of the interface problem; see the module's docstring.

    Attributes:
        components: d.
        compliance: A, (N*d, N*d).
        gap: (N*d,) w0 of the unloaded bodies.
        motion: (N*d, m) G.
        stiffness: (m, m) K.
        loads: (N*d, l) L.
        coordinate_loads: (m, l) H.
        roots: (N,) √W.
        coordinates: the m coordinates.
        contacts: node range of each contact, by name, in the order of the case.
    """

    components: int
    compliance: Compliance
    gap: Array
    motion: Array
    stiffness: Array
    loads: Array
    coordinate_loads: Array
    roots: Array
    coordinates: tuple[Coordinate, ...]
    contacts: dict[str, slice]

    @property
    def size(self) -> int:
        """Number of multiplier nodes N."""
        return len(self.roots)

    @property
    def prescribed(self) -> Bools:
        """(m,) coordinates of known amplitude."""
        return np.array([c.prescribed for c in self.coordinates], dtype=bool)

    @cached_property
    def reach(self) -> Array:
        """(m,) largest displacement of a node (length) by a unit of each coordinate."""
        lengths = self.motion / np.repeat(self.roots, self.components)[:, None]
        return np.asarray(np.abs(lengths).max(axis=0, initial=0.0))


def coordinate_range(coordinates: list[Coordinate] | tuple[Coordinate, ...], body: str) -> slice:
    """Range of the coordinates of a body, which follow each other."""
    own = [number for number, c in enumerate(coordinates) if c.body == body]
    return slice(own[0], own[-1] + 1) if own else slice(0, 0)


def unresisted_motions(
    interface: Interface, released: Bools, resisting: Bools | None = None
) -> Array:
    """Combinations of released coordinates that neither contact nor stiffness resists.

    Args:
        interface: the interface problem.
        released: (m,) coordinates that may move.
        resisting: (N*d,) displacements that contact resists; None for all of them: every node
            stuck, so that nothing at all resists a motion that remains.

    Returns:
        (m, k) motions, orthonormal after scaling each coordinate with its effect on the contact.
    """
    chosen = np.flatnonzero(released)
    if not len(chosen):
        return np.zeros((len(released), 0))
    scale = coordinate_scale(interface)
    stiffness = interface.compliance.level * interface.stiffness
    motion = interface.motion if resisting is None else interface.motion[resisting]
    resisted = np.vstack([motion * scale, stiffness * scale * scale[:, None]])[:, chosen]
    _, values, rows = np.linalg.svd(resisted, full_matrices=False)
    null = rows[values < UNRESISTED * max(values[0], 1e-300)].T
    motions = np.zeros((len(released), null.shape[1]))
    motions[chosen] = null * scale[chosen, None]
    return motions


def coordinate_scale(interface: Interface) -> Array:
    """(m,) amplitudes by which each coordinate moves the contact by about one."""
    effect = np.linalg.norm(interface.motion, axis=0)
    return 1 / np.where(effect > 0, effect, 1.0)
