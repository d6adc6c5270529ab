# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts as they are expected before anything is solved, and the elements that they need.

The normal force follows from the forces on a body that nothing else holds along the contact normal;
the width from the initial gap, as for half-planes with a symmetric profile, or for half-spaces with
a paraboloid. Nothing is said where one of them is not known.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.hertz import HertzContact, expected_contact, half_width
from fretfe.case import Case, unit_vector
from fretfe.case import Contact as ContactTable
from fretfe.case.loads import Push
from fretfe.errors import MeshError, ModelError
from fretfe.evaluate.factors import WANTED_NODES
from fretfe.evaluate.limits import DOUBTED
from fretfe.evaluate.resolution import BAR_TIMES_ELEMENTS
from fretfe.evaluate.slip import cycle_states
from fretfe.loads import History
from fretfe.materials.moduli import contact_modulus
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.report.texts import rounded
from fretfe.surface.checks import InitialGap, initial_gaps
from fretfe.surface.surface import Surface, build_surface

# Elements over the radius of a front below which there is no K_N.
PER_RADIUS = 6.0
# A direction is along the surface if its part along the normal is below this.
PARALLEL = 1e-3
# The estimate is good to about this fraction of the width: no warning if so much more is enough.
MARGIN = 0.85
# Gaps within so many elements of the lowest one are looked at in any case.
ELEMENTS = 2.5


def require_pressed(case: Case, mesh: Mesh, history: History) -> None:
    """Check that no contact is only ever pulled apart, where equilibrium gives its force.

    Raises:
        ModelError: names the first that is.
    """
    if case.geometry.part is not None:  # the run that drives it had contact
        return
    for name, initial in initial_gaps(mesh, case).items():
        normal = _normal(initial)
        facing = initial.surface2.normals[initial.facet2] @ normal
        force = _normal_force(case, mesh, history, name, initial, normal)
        # around a shaft forces along the normal say nothing
        if force is not None and force.max() <= 0.0 and force.min() < 0.0 and facing.min() > 0.0:
            bodies = f"{initial.surface1.body!r} and {initial.surface2.body!r}"
            raise ModelError(
                f"contact {name}: expected loads that press {bodies} together, found loads that "
                f"pull them apart all the time, by up to {rounded(-force.min())}: turn them round"
            )


def coarse_contacts(
    case: Case,
    mesh: Mesh,
    history: History,
    middles: Mapping[str, Array] | None = None,
    *,
    advise: bool = True,
) -> Iterator[str]:
    """Warnings of contacts that will be too narrow for their elements to be evaluated.

    Args:
        case: of the contacts.
        mesh: its mesh.
        history: its loads.
        middles: (2,) of contacts in the plane of which the model has a half, by name.
        advise: whether they say which elements are wanted.
    """
    for name, initial, normal, force in _pressed(case, mesh, history):
        if force > 0 and case.contacts[name].gap is None:
            middle = (middles or {}).get(name)
            yield from _warning(case, name, initial, normal, force, middle, advise=advise)


def pressure_doubts(
    case: Case, mesh: Mesh, history: History, middles: Mapping[str, Array] | None = None
) -> Iterator[str]:
    """Plane contacts whose mean pressure no material bears: a unit is likely to be wrong.

    Arguments as of `coarse_contacts`.
    """
    if mesh.dimension == 3:
        return
    for name, initial, normal, force in _pressed(case, mesh, history):
        own = case.contacts[name]
        if not force > 0 or own.gap is not None or own.layer is not None:
            continue
        load = _load(case, initial, normal, force)
        along, gap, load = _of_the_whole(initial, normal, load, (middles or {}).get(name))
        width, _ = half_width(along, gap, load)
        mean = load / min(2 * width, float(np.ptp(along)))
        if mean > DOUBTED[1]:
            bodies = (initial.surface1.body, initial.surface2.body)
            yield (
                f"contact {name}: P = {rounded(force)} means a pressure of {rounded(mean, 2)} E* "
                f"or more, where fretting contacts have 1e-4 to 1e-2: check "
                f"{' and '.join(f'bodies.{each}' for each in bodies)}, which are in "
                f"{case.units.stress}, and the loads on them"
            )


def _pressed(
    case: Case, mesh: Mesh, history: History
) -> Iterator[tuple[str, InitialGap, Array, float]]:
    """Each contact with its initial gap, its normal (d,), and its smallest P in the cycle.

    P is that at the end without a cycle, and NaN if equilibrium alone does not give it.
    """
    states = cycle_states(history.cycle)
    for name, initial in initial_gaps(mesh, case).items():
        normal = _normal(initial)
        force = _normal_force(case, mesh, history, name, initial, normal)
        smallest = np.nan if force is None else force[states if len(states) else [-1]].min()
        yield name, initial, normal, float(smallest)


def _normal(initial: InitialGap) -> Array:
    """(d,) unit normal of surface 2 where the gap is smallest."""
    nearest = int(np.argmin(initial.gap))
    normal = initial.surface2.normals[initial.facet2[nearest]].mean(axis=0)
    return np.asarray(normal / np.linalg.norm(normal))


@dataclass(frozen=True)
class Proposal:
    """Element size at the fronts of a contact of solids that a tolerance is likely to need.

    Attributes:
        contact: name.
        force: smallest P in the cycle.
        length: half-width expected there; of a rounding the one that grows as fast with P.
        size: of the elements; NaN where it is not known.
        reason: why it is not.
    """

    contact: str
    force: float
    length: float = math.nan
    size: float = math.nan
    reason: str = ""


def proposed_sizes(
    case: Case, mesh: Mesh, history: History, tolerance: float
) -> Iterator[Proposal]:
    """For each contact of solids the element size that K_N and |ΔK| are likely to need.

    Args:
        case: of the contacts.
        mesh: its mesh, of any element size that shows the gap.
        history: its loads.
        tolerance: wanted relative error bar at all stations.
    """
    for name, initial, normal, force in _pressed(case, mesh, history):
        if math.isnan(force):
            reason = "equilibrium alone does not give its normal force"
            yield Proposal(name, force, reason=reason)
        elif force <= 0:
            yield Proposal(name, force, reason="the loads do not press it together all the time")
        elif case.contacts[name].gap is not None:
            yield Proposal(name, force, reason="it has a gap of its own")
        else:
            yield _proposal(case, name, initial, normal, force, tolerance)


def _proposal(
    case: Case, name: str, initial: InitialGap, normal: Array, force: float, tolerance: float
) -> Proposal:
    load, carrier = _load(case, initial, normal, force), _carrier(case.contacts[name], initial)
    long, short = _hertz(initial, carrier, normal, load).half_axes
    # At its tips the front of an ellipse is bent more than it is wide: see `range_spread`.
    radius = short**2 / long if math.isfinite(long) else math.inf
    solid = case.geometry.solid
    if not math.isfinite(short) and solid is not None and not solid.skew and not normal[2]:
        # The section of a straight extrusion, as a cylinder with the same growth of its half-width.
        along = initial.points @ [normal[1], -normal[0], 0.0]
        load /= solid.shared(initial.surface1.body, initial.surface2.body)
        grown = [half_width(along, initial.gap, x * load)[0] for x in (1.0, 0.5)]
        short = (grown[0] - grown[1]) / (1 - math.sqrt(0.5))
    if not math.isfinite(short):
        reason = "its gap is neither that of a paraboloid nor of a section with one lowest place"
        return Proposal(name, force, reason=reason)
    size = min(min(short, radius) * tolerance / BAR_TIMES_ELEMENTS, radius / PER_RADIUS)
    return Proposal(name, force, short, float(f"{size:.2g}"))


def _load(case: Case, initial: InitialGap, normal: Array, force: float) -> float:
    """P/E* of a contact."""
    body1, body2 = case.bodies[initial.surface1.body], case.bodies[initial.surface2.body]
    return force / contact_modulus(body1, body2, case.model.plane, normal)


def _warning(
    case: Case,
    name: str,
    initial: InitialGap,
    normal: Array,
    force: float,
    middle: Array | None,
    *,
    advise: bool,
) -> Iterator[str]:
    for surface in (initial.surface1, initial.surface2):
        if len(surface.sizes) < 2:
            yield (
                f"contact {name}: the surface of the body {surface.body!r} is a single facet: that "
                f"is no contact surface, {WANTED_NODES} nodes in contact are wanted at least; mesh "
                "it finer, or look for the facets that its physical group lacks"
            )
            return
    load, carrier = _load(case, initial, normal, force), _carrier(case.contacts[name], initial)
    solid = len(normal) == 3
    if solid:
        width, count = _across_ellipse(initial, carrier, normal, load)
    else:
        width, count = _across_strip(initial, carrier, normal, load, middle)
    if not math.isfinite(width):
        return
    if count < MARGIN * WANTED_NODES:
        unit = case.units.length
        size = 2 * width / WANTED_NODES
        yield (
            f"contact {name}: about {count} nodes {'across the' if solid else 'in'} contact "
            f"expected at P = {force:.4g} (half-width {width:.2g} {unit}), {WANTED_NODES} wanted "
            "at least"
            + (f": make the elements there {size:.1g} {unit} long or less" if advise else "")
        )


def _carrier(contact: ContactTable, initial: InitialGap) -> Surface:
    """The surface that carries the tractions."""
    surfaces = {"surface1": initial.surface1, "surface2": initial.surface2}
    finer = min(surfaces.values(), key=lambda surface: float(np.median(surface.sizes)))
    return surfaces.get(contact.multipliers, finer)


def _across_strip(
    initial: InitialGap, carrier: Surface, normal: Array, load: float, middle: Array | None
) -> tuple[float, int]:
    """Half-width of a plane contact under P/E*, and the number of nodes in it."""
    tangent = np.array([normal[1], -normal[0]])
    nodes = carrier.vertices @ tangent
    along, gap, load = _of_the_whole(initial, normal, load, middle)
    if middle is not None:
        twice = 2 * float(middle @ tangent)
        nodes = np.append(nodes, np.delete(twice - nodes, np.abs(nodes - twice / 2).argmin()))
    width, centre = half_width(along, gap, load)
    return width, int(np.sum(np.abs(nodes - centre) < width))


def _of_the_whole(
    initial: InitialGap, normal: Array, load: float, middle: Array | None
) -> tuple[Array, Array, float]:
    """Places along a plane contact, gaps there, and P/E*: of a half the image carries as much."""
    tangent = np.array([normal[1], -normal[0]])
    along, gap = initial.points @ tangent, initial.gap
    if middle is None:
        return along, gap, load
    twice = 2 * float(middle @ tangent)
    return np.append(along, twice - along), np.append(gap, gap), 2 * load


def _across_ellipse(
    initial: InitialGap, carrier: Surface, normal: Array, load: float
) -> tuple[float, int]:
    """Half of the smallest width of a contact of solids under P/E*, and the nodes across it.

    Infinite where the gap is not that of a paraboloid or of a cylinder.
    """
    found = _hertz(initial, carrier, normal, load)
    width = found.half_axes[1]
    if not np.isfinite(width):
        return np.inf, WANTED_NODES
    from_lowest = _from_lowest(initial, carrier)
    near = from_lowest <= max(width, 2 * float(carrier.sizes[np.argmin(from_lowest)]))
    lengths = np.ptp(carrier.nodes[near] @ found.across, axis=1)
    return float(width), round(2 * width / float(np.median(lengths)))


def hertz_contact(case: Case, name: str, initial: InitialGap, force: float) -> HertzContact | None:
    """A contact of solids by Hertz under P; None where its gap is no paraboloid or cylinder."""
    nearest = int(np.argmin(initial.gap))
    normal = initial.surface2.normals[initial.facet2[nearest]].mean(axis=0)
    normal /= np.linalg.norm(normal)
    carrier = _carrier(case.contacts[name], initial)
    modulus = force / _load(case, initial, normal, force)
    found = _hertz(initial, carrier, normal, force / modulus)
    return replace(found, peak=found.peak * modulus) if math.isfinite(found.half_axes[1]) else None


def _hertz(initial: InitialGap, carrier: Surface, normal: Array, load: float) -> HertzContact:
    """A contact of solids under P/E* as of `expected_contact`, with the direction (3,) across."""
    plane = np.linalg.svd(normal[None])[2][1:]
    places = (initial.points - initial.points[np.argmin(initial.gap)]) @ plane.T
    size = float(carrier.sizes[np.argmin(_from_lowest(initial, carrier))])
    found = expected_contact(places, initial.gap, load, ELEMENTS * size)
    return replace(found, across=found.across @ plane)


def _from_lowest(initial: InitialGap, carrier: Surface) -> Array:
    """(f,) distances of facets from the place of the smallest gap."""
    lowest = initial.points[np.argmin(initial.gap)]
    return np.asarray(np.linalg.norm(carrier.nodes.mean(axis=1) - lowest, axis=1))


def _normal_force(
    case: Case, mesh: Mesh, history: History, contact: str, initial: InitialGap, normal: Array
) -> Array | None:
    """(T,) normal force P per unit thickness; None if equilibrium alone does not give it."""
    if any(each.body_force for each in case.loads.values()):
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
    """True if anything but forces moves or holds a body with these boundaries along the normal."""
    if any(sector.boundary1 in own for sector in case.symmetry.values()):
        return True
    normal = np.append(normal, 0.0)[:3]
    held = [
        unit_vector(axis, 3)
        for support in case.supports.values()
        if support.boundary in own
        for axis in support.fix
    ]
    platens: dict[str, Array] = {}
    for load in case.loads.values():
        if load.on not in own or not (load.moves or load.rigid):
            continue
        if load.by_shape:
            return True
        free = platens.get(load.on, normal)
        if load.along is not None:
            direction = np.array(unit_vector(load.along, 3))
            free = free - (free @ direction) * direction
            if load.push is None:
                held.append(tuple(direction))
        if load.rigid:
            platens[load.on] = free
    # What is left of the normal is a direction in which a platen is guided.
    directions = [*map(np.array, held), *platens.values()]
    return any(abs(float(normal @ direction)) > PARALLEL for direction in directions)


def _force(case: Case, mesh: Mesh, history: History, body: str) -> Array:
    """(T, d) sum of the forces on a body, in the plane per unit thickness."""
    total = np.zeros((len(history.times), mesh.dimension))
    own = mesh.bodies[body].boundaries
    for name, load in case.loads.items():
        if load.push is None or load.on not in own:
            continue
        force = (
            np.array(unit_vector(load.push.direction, 3)[: mesh.dimension]) / case.model.thickness
            if load.push.total
            else _resultant(load.push, mesh.bodies[body], load.on)
        )
        total += np.outer(history.values[:, history.channels.index(name)], force)
    return total


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
