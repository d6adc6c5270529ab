# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normal forces of contacts before anything is solved, by equilibrium of bodies.

A body that nothing else holds along the normal of its only contact tells the force exactly. Bodies
with several contacts, as roots with their flanks, leave it open: a first guess has them slide along
their load, and share it as evenly as equilibrium allows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.bodies.loads.kinds import spread_loads
from fretfe.bodies.loads.spread import SpreadLoad
from fretfe.case import Case, unit_vector
from fretfe.case.holders import holders
from fretfe.loads import History
from fretfe.loads.friction import read_coefficients
from fretfe.mesh.mesh import Mesh
from fretfe.surface.checks import InitialGap, initial_gaps
from fretfe.surface.surface import boundary_surface

# A direction is along the surface if its part along the normal is below this.
PARALLEL = 1e-3


def contact_normal(initial: InitialGap) -> Array:
    """(d,) unit normal of surface 2 where the gap is smallest."""
    nearest = int(np.argmin(initial.gap))
    normal = initial.surface2.normals[initial.facet2[nearest]].mean(axis=0)
    return np.asarray(normal / np.linalg.norm(normal))


@dataclass(frozen=True)
class ContactForces:
    """Normal forces P of the contacts of a case, per unit thickness in the plane.

    Attributes:
        case: of the contacts.
        mesh: its mesh.
        history: its loads.
    """

    case: Case
    mesh: Mesh
    history: History

    @cached_property
    def _normals(self) -> dict[str, Array]:
        """(d,) normal of each contact, by name."""
        gaps = initial_gaps(self.mesh, self.case)
        return {name: contact_normal(initial) for name, initial in gaps.items()}

    def exact(self, contact: str) -> Array | None:
        """(T,) P of a contact; None if equilibrium alone does not give it."""
        if any(each.body_force for each in self.case.loads.values()):
            return None
        normal = self._normals[contact]
        for body, sign in self._bodies(contact):
            alone = len(self._contacts(body)) == 1
            if alone and not (np.abs(self._held(body) @ normal) > PARALLEL).any():
                load = self._on(body)
                force, size = sign * load @ normal, np.linalg.norm(load, axis=1)
                return np.where(np.abs(force) <= PARALLEL * size, 0.0, force)
        return None

    def guessed(self, contact: str, states: Indices) -> Array | None:
        """(T,) P of a contact by a guess that holds in some states; None where there is none."""
        loads = self.case.loads.values()
        if not all(each.push or each.moves or each.rigid for each in loads):
            return None
        for body, _ in self._bodies(contact):
            shared = self._shared(body)
            if shared is not None and min(force[states].min() for force in shared.values()) > 0:
                return shared[contact]
        return None

    def _bodies(self, contact: str) -> tuple[tuple[str, float], tuple[str, float]]:
        """Both bodies of a contact, with the sign of what presses them along the normal."""
        own = self.case.contacts[contact]
        of = {name: body.name for body in self.mesh.bodies.values() for name in body.boundaries}
        return (of[own.surface1], -1.0), (of[own.surface2], 1.0)

    def _contacts(self, body: str) -> dict[str, float]:
        """Contacts of a body, with the sign of the normal that presses on it."""
        return {
            name: -sign
            for name in self.case.contacts
            for each, sign in self._bodies(name)
            if each == body
        }

    def _held(self, body: str) -> Array:
        """(k, d) unit directions in which anything but forces moves or holds a body."""
        own, dimension = self.mesh.bodies[body].boundaries, self.mesh.dimension
        if any(sector.boundary1 in own for sector in self.case.symmetry.values()):
            return np.eye(dimension)
        held = [np.zeros((0, dimension))]
        for holder in holders(self.case.supports, self.case.loads):
            if holder.boundary in own:
                along = np.reshape(holder.directions, (-1, 3))[:, :dimension]
                held.append(_across(along) if holder.platen else along)
        return np.concatenate(held)

    def _shared(self, body: str) -> dict[str, Array] | None:
        """(T,) P of all contacts of a body that share its load; None without equilibrium.

        They slide along the load up to its largest value, with the friction of a body that does;
        what it falls by then is taken off them as it acts, while they stick.
        """
        free, load = _across(self._held(body)), self._on(body)
        if not len(free) or not np.isfinite(load).all() or not load.any():
            return None
        size, own = np.linalg.norm(load, axis=1), self._contacts(body)
        peaks = np.where(size >= np.maximum.accumulate(size), np.arange(len(size)), 0)
        largest = load[np.maximum.accumulate(peaks)]
        acting = free @ self._pressing(own, largest[np.argmax(size)])
        forces = -np.linalg.pinv(acting) @ free @ largest.T
        # Meshes have round-off, and supports may be a little askew.
        if np.abs(acting @ forces + free @ largest.T).max() > 1e-6 * size.max():
            return None
        fallen = (load - largest) @ free.T @ free / len(own)
        return {
            name: force - sign * fallen @ self._normals[name]
            for (name, sign), force in zip(own.items(), forces, strict=True)
        }

    def _pressing(self, contacts: dict[str, float], load: Array) -> Array:
        """(d, n) forces on a body by P = 1 at each of its contacts, as it slides along a load."""
        columns = []
        for name, sign in contacts.items():
            normal = self._normals[name]
            along = load - (load @ normal) * normal
            size = float(np.linalg.norm(along))
            friction = read_coefficients(self.case, name).over(self.history.times).max()
            slides = size > PARALLEL * np.linalg.norm(load)
            columns.append(sign * normal - (friction / size * along if slides else 0.0))
        return np.stack(columns, axis=1)

    @cached_property
    def _spread(self) -> tuple[SpreadLoad, ...]:
        return spread_loads(self.case, self.mesh)

    def _on(self, body: str) -> Array:
        """(T, d) sum of the forces on a body, in the plane per unit thickness."""
        own, dimension = self.mesh.bodies[body], self.mesh.dimension
        values = dict(zip(self.history.channels, self.history.values.T, strict=True))
        total, thickness = np.zeros((len(self.history.times), dimension)), self.case.model.thickness
        for name, load in self.case.loads.items():
            if load.rigid and load.push is not None and load.on in own.boundaries:
                force = np.array(unit_vector(load.push, 3)[:dimension]) / thickness
                total += np.outer(values[name], force)
        for spread in self._spread:
            if (given := spread.traction) is not None and given.boundary in own.boundaries:
                force = given.forces(boundary_surface(own, given.boundary))[1].sum(axis=0)
                unit = 1 / thickness if spread.total else 1.0
                total += np.outer(unit * values[spread.channel], force[:dimension])
        return total


def _across(directions: Array) -> Array:
    """(d-k, d) unit directions across k independent ones of (n, d)."""
    if not len(directions):
        return np.eye(directions.shape[1])
    _, sizes, axes = np.linalg.svd(directions)
    return np.asarray(axes[np.count_nonzero(sizes > PARALLEL) :])
