# SPDX-License-Identifier: LGPL-3.0-or-later
"""The interface problem: elastic bodies reduced to their contact nodes and rigid boundaries."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fretfe._core import _kernels
from fretfe._typing import Array, Bools, Indices
from fretfe.contact import dense
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.mortar import SlidGap

# Relative size below which a motion is resisted by nothing but round-off.
UNRESISTED = 1e-9


# Part of the largest gap of a pair in place that is round-off of projections: 1e-10 of a facet.
GAP_ROUND_OFF = 1e-11


# Nodes (n,), and a vector (n, 3) at each of them.
Directions = tuple[Indices, Array]


class Compliance(Protocol):
    """Relative displacements by tractions: (N*d, N*d), symmetric, positive semi-definite."""

    @property
    def diagonal(self) -> Array:
        """(N*d,) displacement of each component by its own unit traction."""

    @property
    def level(self) -> float:
        """Mean of the diagonal: the scale of the compliance."""

    def apply(self, traction: Array) -> Array:
        """(N*d,) displacements by tractions (N*d,)."""

    def block(self, rows: Indices, columns: Indices) -> Array:
        """(rows, columns) displacements of some components by unit tractions at others; a copy."""

    def combine(
        self, rows: Directions, columns: Directions, found: NDArray[np.floating[Any]]
    ) -> None:
        """Write to (r, c) the displacements of nodes in directions by tractions in others; d = 3.

        Args:
            rows: of the displacements.
            columns: of the tractions.
            found: numbers of any precision.
        """


class DenseCompliance:
    """A compliance that is known as a matrix.

    Args:
        matrix: (N*d, N*d), symmetric.
    """

    def __init__(self, matrix: Array) -> None:
        self._matrix = matrix

    @cached_property
    def diagonal(self) -> Array:
        """(N*d,) displacement of each component by its own unit traction."""
        return np.diagonal(self._matrix)

    @cached_property
    def level(self) -> float:
        """Mean of the diagonal: the scale of the compliance."""
        return float(np.trace(self._matrix) / len(self._matrix))

    def apply(self, traction: Array) -> Array:
        """(N*d,) displacements by tractions (N*d,)."""
        return dense.multiply_symmetric(self._matrix, traction)

    def block(self, rows: Indices, columns: Indices) -> Array:
        """(rows, columns) displacements of some components by unit tractions at others; a copy."""
        return dense.gather(self._matrix, rows, columns)

    def combine(
        self, rows: Directions, columns: Directions, found: NDArray[np.floating[Any]]
    ) -> None:
        """Write to (r, c) the displacements of nodes in directions by tractions in others."""
        _kernels.combine_blocks(self._matrix, *rows, *columns, found)


def add_layers(
    matrix: Array, contacts: Mapping[str, slice], layers: Mapping[str, Array], d: int
) -> None:
    """Add to a compliance (N*d, N*d), in place, what layers between the surfaces give.

    In weighted quantities both are the same: (√W u) / (√W τ) = u / τ.

    Args:
        matrix: of the bodies.
        contacts: node range of each contact.
        layers: (N, 2) approach per pressure, and displacement along the surface per shear, at the
            nodes of each contact.
        d: components.
    """
    diagonal = np.einsum("ii->i", matrix).reshape(-1, d)
    for name, nodes in contacts.items():
        diagonal[nodes, :1] += layers[name][:, :1]
        diagonal[nodes, 1:] += layers[name][:, 1:]


@dataclass(frozen=True, eq=False)
class Course:
    """An amplitude by the position in another run: linear between its steps.

    Attributes:
        positions: (n,) of the steps, increasing from 0, which is unloaded.
        values: (n,) amplitudes, the first one 0.
    """

    positions: Array
    values: Array

    def at(self, positions: Array) -> Array:
        """(m,) amplitudes at positions (m,)."""
        return np.interp(positions, self.positions, self.values)


class Resultant(NamedTuple):
    """A force or moment on a boundary that moves by the field of another run.

    Attributes:
        load: name of the load with that field.
        kind: of resultant.
    """

    load: str
    kind: Literal["force", "moment"]


@dataclass(frozen=True)
class Coordinate:
    """One amplitude c_j of the interface problem.

    Attributes:
        label: name in messages and results.
        body: name of the body.
        control: "force" or "displacement" (driven by a channel), "fixed", or "free" (a rigid mode
            restrained only by contact; no force acts on it).
        channel: name of the load that drives it, "" if none.
        course: of its amplitude over the values of that load; None if they are the amplitude.
        resultant: that it gives, whose motion is held; None of what moves or carries by itself.
    """

    label: str
    body: str
    control: str
    channel: str = ""
    course: Course | None = None
    resultant: Resultant | None = None

    def amplitudes(self, values: Array) -> Array:
        """(T,) amplitudes, or forces, by values (T,) of its load."""
        return values if self.course is None else self.course.at(values)

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
        laws: (2, n) pressures, and approach of the surfaces at these beyond that of the compliance,
            of contacts whose layer does not give linearly.
        slid: the gaps of contacts between curved surfaces, once they have slid.
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
    laws: Mapping[str, Array] = field(default_factory=dict)
    slid: Mapping[str, SlidGap] = field(default_factory=dict)

    @property
    def gives(self) -> bool:
        """True if gaps depend on the state beyond what the compliance and the loads tell."""
        return bool(self.laws or self.slid)

    def approach(self, traction: Array, relative: Array) -> Array:
        """(N,) weighted gap beyond that of the compliance, by laws and by what has slid.

        Args:
            traction: (N, d) y.
            relative: (N, d) w.
        """
        found = np.zeros(self.size)
        for name, law in self.laws.items():
            nodes = self.contacts[name]
            roots = self.roots[nodes]
            pressure = np.maximum(traction[nodes, 0] / roots, 0.0)
            found[nodes] = roots * np.interp(pressure, *law)
        for name, gap in self.slid.items():
            nodes = self.contacts[name]
            roots = self.roots[nodes]
            moved = relative[nodes, 1:] / roots[:, None]
            found[nodes] += gap.opened(moved, roots * traction[nodes, 0]) / roots
        return found

    @cached_property
    def gap_round_off(self) -> float:
        """Weighted gaps of that size are round-off where profiles slide."""
        return GAP_ROUND_OFF * float(np.abs(self.gap).max()) if self.slid else 0.0

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


class Averaging(Protocol):
    """A linear map of nodal values, such as a sparse matrix."""

    def __matmul__(self, values: Array) -> Array:
        """Return the mapped values."""


@dataclass(frozen=True)
class Place:
    """One contact.

    Attributes:
        name: of the contact in the case.
        body1, body2: names of its bodies.
        surface: its N nodes.
        averaging: (N, N) from nodal values to means around the nodes.
    """

    name: str
    body1: str
    body2: str
    surface: ContactSurface
    averaging: Averaging


def digest_of(places: Sequence[Place]) -> str:
    """Text that is equal for the same contacts with the same nodes."""
    found = hashlib.sha256()
    for place in places:
        surface = place.surface
        found.update(repr((place.name, place.body1, place.body2, surface.points.shape)).encode())
        for values in (surface.points, surface.weights, surface.facets):
            found.update(b"" if values is None else np.ascontiguousarray(values).tobytes())
    return found.hexdigest()
