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
from fretfe.case import Case, unit_vector
from fretfe.case.loads import Push
from fretfe.errors import MeshError
from fretfe.loads import History
from fretfe.loads.friction import read_coefficients
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.checks import InitialGap, initial_gaps
from fretfe.surface.surface import build_surface

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
                return np.asarray(sign * self._on(body) @ normal)
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
        everything = np.eye(dimension)
        if any(sector.boundary1 in own for sector in self.case.symmetry.values()):
            return everything
        held = [
            unit_vector(axis, 3)[:dimension]
            for support in self.case.supports.values()
            if support.boundary in own
            for axis in (*support.fix, support.direction)
            if axis is not None
        ]
        platens: dict[str, list[tuple[float, ...]]] = {}
        for load in self.case.loads.values():
            if load.on not in own or not (load.moves or load.rigid):
                continue
            if load.by_shape:
                return everything
            direction = [] if load.along is None else [unit_vector(load.along, 3)[:dimension]]
            if load.push is None:
                held += direction
            if load.rigid:
                platens.setdefault(load.on, []).extend(direction)
        # A platen is guided in whatever directions no load moves it.
        guided = [_across(np.reshape(own, (-1, dimension))) for own in platens.values()]
        return np.concatenate([np.reshape(held, (-1, dimension)), *guided])

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

    def _on(self, body: str) -> Array:
        """(T, d) sum of the forces on a body, in the plane per unit thickness."""
        total = np.zeros((len(self.history.times), self.mesh.dimension))
        own = self.mesh.bodies[body].boundaries
        for name, load in self.case.loads.items():
            if load.push is None or load.on not in own:
                continue
            force = _resultant(load.push, self.mesh.bodies[body], load.on)
            if load.push.total:
                force = np.array(unit_vector(load.push.direction, 3)[: self.mesh.dimension])
                force /= self.case.model.thickness
            total += np.outer(self.history.values[:, self.history.channels.index(name)], force)
        return total


def _across(directions: Array) -> Array:
    """(d-k, d) unit directions across k independent ones of (n, d)."""
    if not len(directions):
        return np.eye(directions.shape[1])
    _, sizes, axes = np.linalg.svd(directions)
    return np.asarray(axes[np.count_nonzero(sizes > PARALLEL) :])


def _resultant(push: Push, body: BodyMesh, boundary: str) -> Array:
    """(d,) force of a unit traction; NaN if it varies, or its boundary is no single surface."""
    dimension = body.points.shape[1]
    if not push.uniform:
        return np.full(dimension, np.nan)
    try:
        surface = build_surface(body, boundary)
    except MeshError:
        return np.full(dimension, np.nan)
    if push.direction == "normal":
        return np.asarray(surface.measures @ surface.normals.mean(axis=1))
    return surface.measures.sum() * np.array(unit_vector(push.direction, 3)[:dimension])
