# SPDX-License-Identifier: LGPL-3.0-or-later
"""Width of a contact before anything is solved, where loads and shape tell it: is the mesh fine?

The normal force follows from the forces on a body that nothing else holds along the contact normal;
the width from the initial gap, as for half-planes with a symmetric profile. Nothing is said where
one of them is not known.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, Contact, contact_modulus, unit_vector
from fretfe.case.channels import DisplacementLoad, PlatenLoad, RotationLoad, TractionLoad
from fretfe.edges.factors import WANTED_NODES
from fretfe.edges.slip_zones import cycle_states
from fretfe.errors import MeshError
from fretfe.loads import History
from fretfe.mesh.mesh import Mesh
from fretfe.surface.checks import initial_gaps
from fretfe.surface.gap import InitialGap
from fretfe.surface.surface import build_surface

# A direction is along the surface if its part along the normal is below this.
PARALLEL = 1e-3
# The estimate is good to about this fraction of the width: it must not cry wolf.
MARGIN = 0.85
WIDTHS, ANGLES = 400, 64


def coarse_contacts(case: Case, mesh: Mesh, history: History) -> Iterator[str]:
    """Warnings of contacts that will be too narrow for their elements to be evaluated.

    Args:
        case: of the contacts.
        mesh: its plane mesh.
        history: its loads.
    """
    for name, initial in initial_gaps(mesh, case).items():
        nearest = int(np.argmin(initial.gap))
        normal = initial.surface2.normals[initial.facet2[nearest]].mean(axis=0)
        normal /= np.linalg.norm(normal)
        force = _normal_force(case, mesh, history, name, initial, normal)
        states = cycle_states(history.cycle)
        pressed = force[states if len(states) else [-1]] if force is not None else np.zeros(1)
        if pressed.min() > 0:
            yield from _warning(case, name, initial, normal, float(pressed.min()))


def _warning(
    case: Case, name: str, initial: InitialGap, normal: Array, force: float
) -> Iterator[str]:
    body1, body2 = case.bodies[initial.surface1.body], case.bodies[initial.surface2.body]
    modulus = contact_modulus(body1, body2, case.model.plane)
    tangent = np.array([normal[1], -normal[0]])
    along = initial.points @ tangent
    half_width, centre = _half_width(along, initial.gap, force / modulus)
    nodes = _carrier_nodes(case.contacts[name], initial) @ tangent
    count = np.count_nonzero(np.abs(nodes - centre) < half_width)
    if count < MARGIN * WANTED_NODES:
        unit = case.units.length
        size = 2 * half_width / WANTED_NODES
        yield (
            f"contact {name}: about {count} nodes in contact expected at P = {force:.4g} "
            f"(half-width {half_width:.2g} {unit}), {WANTED_NODES} wanted at least: make the "
            f"elements there {size:.1g} {unit} long or less"
        )


def _carrier_nodes(contact: Contact, initial: InitialGap) -> Array:
    """(v, 2) nodes of the surface that carries the tractions."""
    surfaces = {"surface1": initial.surface1, "surface2": initial.surface2}
    finer = min(surfaces.values(), key=lambda surface: float(np.median(surface.sizes)))
    return surfaces.get(contact.multipliers, finer).vertices


def _half_width(along: Array, gap: Array, force: float) -> tuple[float, float]:
    """Half-width of the contact, infinite if it is wider than the surfaces, and its centre.

    With the gap g(x) made even about its lowest place, P/E* = a ∫ g'(a sin t) sin t dt over
    0 < t < pi/2 (half-planes).

    Args:
        along: (n,) places along the surface.
        gap: (n,) initial gap there.
        force: P/E*.
    """
    order = np.argsort(along)
    x, g = along[order], gap[order] - gap.min()
    centre = float(x[g <= 1e-6 * g.max()].mean()) if g.max() > 0 else float(x.mean())
    widest = min(centre - x[0], x[-1] - centre)
    widths = np.linspace(0.0, widest, WIDTHS + 1)[1:]
    even = (np.interp(centre + widths, x, g) + np.interp(centre - widths, x, g)) / 2
    slopes = np.diff(even, prepend=0.0) / widths[0]
    angles = (np.arange(ANGLES) + 0.5) * np.pi / 2 / ANGLES
    at = widths[:, None] * np.sin(angles)
    steps = np.minimum((at / widths[0]).astype(int), WIDTHS - 1)
    forces = widths * (slopes[steps] * np.sin(angles)).mean(axis=1) * np.pi / 2
    if force >= forces[-1]:
        return np.inf, centre
    return float(np.interp(force, np.maximum.accumulate(forces), widths)), centre


def _normal_force(
    case: Case, mesh: Mesh, history: History, contact: str, initial: InitialGap, normal: Array
) -> Array | None:
    """(T,) normal force P per unit thickness; None if equilibrium alone does not give it."""
    if any(isinstance(load, RotationLoad) for load in case.loads.values()):
        return None
    for surface, sign in ((initial.surface1, -1.0), (initial.surface2, 1.0)):
        own = mesh.bodies[surface.body].boundaries
        others = [
            each for name, each in case.contacts.items()
            if name != contact and {each.surface1, each.surface2} & set(own)
        ]  # fmt: skip
        if not others and not _held(case, set(own), normal):
            return sign * _force(case, mesh, history, surface.body) @ normal
    return None


def _held(case: Case, own: set[str], normal: Array) -> bool:
    """Whether anything but forces moves or holds a body with these boundaries along the normal."""
    held = [
        unit_vector(axis, 2)
        for support in case.supports.values()
        if support.boundary in own
        for axis in support.fix
    ]
    platens: dict[str, Array] = {}
    for load in case.loads.values():
        if not isinstance(load, DisplacementLoad | PlatenLoad) or load.boundary not in own:
            continue
        direction = np.array(unit_vector(load.direction, 2))
        if isinstance(load, DisplacementLoad) or load.control == "displacement":
            held.append(tuple(direction))
        if isinstance(load, PlatenLoad):
            free = platens.get(load.boundary, normal)
            platens[load.boundary] = free - (free @ direction) * direction
    # What is left of the normal is a direction in which a platen is guided.
    directions = [*map(np.array, held), *platens.values()]
    return any(abs(float(normal @ direction)) > PARALLEL for direction in directions)


def _force(case: Case, mesh: Mesh, history: History, body: str) -> Array:
    """(T, 2) sum of the forces on a body per unit thickness."""
    total = np.zeros((len(history.times), 2))
    own = mesh.bodies[body].boundaries
    for name, load in case.loads.items():
        if not isinstance(load, PlatenLoad | TractionLoad) or load.boundary not in own:
            continue
        values = history.values[:, history.channels.index(name)]
        if isinstance(load, PlatenLoad):
            if load.control == "force":
                direction = np.array(unit_vector(load.direction, 2)) / case.model.thickness
                total += np.outer(values, direction)
        else:
            total += np.outer(values, _resultant(load, mesh, body))
    return total


def _resultant(load: TractionLoad, mesh: Mesh, body: str) -> Array:
    """(2,) force of a unit traction; NaN if its boundary is no single curve."""
    try:
        surface = build_surface(mesh.bodies[body], load.boundary)
    except MeshError:
        return np.full(2, np.nan)
    if load.direction == "normal":
        return np.asarray(surface.measures @ surface.normals.mean(axis=1))
    return surface.extent * np.array(unit_vector(load.direction, 2))
