# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress histories of both bodies next to a contact, and local parameters of fretting fatigue.

They are those of the evaluated cycle or, under irregular loads, of the worst one. n is the number
of states, N that of the nodes of the contact, D that of the depths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Bools, Indices
from fretfe.case import AnyBody, Crystal
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.critical_planes import (
    PAIRS,
    Critical,
    Parameter,
    fatemi_socie,
    find_critical,
    smith_watson_topper,
)
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.surface_stress import EdgeValue
from fretfe.history.solution import OPEN, ContactHistory, Solution
from fretfe.history.state_array import blocks
from fretfe.materials.crystals import slip_systems
from fretfe.materials.moduli import compliance

# Stress of two states that differs by no more than this fraction is the same.
ROUNDING = 1e-6
# Elements above which the stress of elements is not used: half of the least largest depth.
SHALLOW = 2.0
# Largest depth over the smaller of the contact's half-width and the radius of the front.
PART_OF_WIDTH = 0.4
# Depths around a station.
ROWS = 5


@dataclass(frozen=True)
class BodyStress:
    """Stress of one body below the nodes of a contact.

    Attributes:
        name: of the body.
        points: (D, N, d) places before deformation; NaN where they are not in the body, or next to
            an edge and shallower than an element.
        normals: (N, d) outward unit normals of the body, against which the depths are counted.
        stress: (n, D, N, 4) xx, yy, zz, xy in the axes of the case, of bodies that move along z
            (n, D, N, 6) with yz, xz [stress].
    """

    name: str
    points: Array
    normals: Array
    stress: Array


@dataclass(frozen=True)
class EdgeStress:
    """Stress along the surface of one body at one edge.

    Attributes:
        contact: name of the contact, or of one of its patches.
        edge: "left" or "right".
        body: name of the body.
        value: (n,) sigma_t [stress]; NaN where it is not known.
        spread: (n,) its error bar [stress].
        near: (n,) sigma_t + p next to the edge, as of `near_edge` [stress].
        reason: why it is not known in most of the states in which it is not; empty if it is in all.
    """

    contact: str
    edge: str
    body: str
    value: Array
    spread: Array
    near: Array
    reason: str

    @property
    def at_largest(self) -> int:
        """Number of the state of the largest known value."""
        return int(np.argmax(np.nan_to_num(self.value, nan=-np.inf)))

    @property
    def largest(self) -> EdgeValue:
        """The largest value of all states, if none in which it is not known can be larger."""
        at, known = self.at_largest, np.isfinite(self.value)
        if not known.any():
            return EdgeValue(np.nan, np.nan, self.reason)
        fallen = self.near <= self.near[at] + ROUNDING * np.abs(self.near[at])
        if np.all(known | fallen):
            top = float(np.nanmax(self.value + self.spread))
            return EdgeValue(float(self.value[at]), top - float(self.value[at]))
        states = f"known in {known.sum()} of {len(known)} states only, and may be larger in others"
        return EdgeValue(np.nan, np.nan, f"{states} ({self.reason}): refine")


@dataclass(frozen=True)
class StressHistory:
    """The surroundings of a contact through a cycle.

    Attributes:
        contact: name of the contact in the case.
        depths: (D,) below the surfaces [length].
        states: (n,) numbers of the states.
        times: (n,) their times.
        arc: (N,) place along the contact [length].
        frames: (N, 2, 2) outward normal of body 2, tangent; (N, 3, 3) with z.
        traction: (n, N, 2) p and q, of bodies that move along z (n, N, 3) with q_z; means around
            the nodes [stress].
        slip: (n, N) of body 1 relative to body 2, of bodies that move along z (n, N, 2) [length].
        status: (n, N) as of `ContactHistory`.
        bodies: body 1 and body 2.
        edges: of both bodies.
    """

    contact: str
    depths: Array
    states: Indices
    times: Array
    arc: Array
    frames: Array
    traction: Array
    slip: Array
    status: npt.NDArray[np.int8]
    bodies: tuple[BodyStress, BodyStress]
    edges: tuple[EdgeStress, ...]

    def at(self, nodes: Indices) -> StressHistory:
        """The same at some of the nodes (m,)."""
        first, second = (
            BodyStress(
                each.name, each.points[:, nodes], each.normals[nodes], each.stress[:, :, nodes]
            )
            for each in self.bodies
        )
        return replace(
            self,
            arc=self.arc[nodes],
            frames=self.frames[nodes],
            traction=self.traction[:, nodes],
            slip=self.slip[:, nodes],
            status=self.status[:, nodes],
            bodies=(first, second),
        )


def station_depths(station: Station) -> Array:
    """(D,) depths at which the stress of elements around a station tells what bodies add.

    Shallower the stress is that of tractions between nodes. Deeper the bend of the front is no
    polynomial any more: on a sphere its error grows from 0.7 % of p0 with depths to 0.35 a to 2 and
    5 % with 0.8 and 2 a, of which a residual does not tell.
    """
    curved = abs(station.curvature)
    width = min(station.depth, 1 / curved if curved > 0 else station.depth)
    deepest = max(PART_OF_WIDTH * width, 2 * SHALLOW * station.size)
    return np.linspace(SHALLOW * station.size, deepest, ROWS)


def judged_states(solution: Solution, contacts: Sequence[Contact]) -> Indices:
    """(n,) states of the evaluated cycle, or of the whole history without one.

    Where loads are irregular, those on the way through the worst counted cycle of all edges.
    """
    worst = worst_states(solution, contacts)
    if len(worst):
        return worst
    first, last = solution.loads.evaluated
    return np.arange(first, last + 1)


def worst_counted(contacts: Sequence[Contact]) -> tuple[Contact, Station] | None:
    """The station with the largest counted cycle; None if the loads of all are regular."""
    every = [(c, edge) for c in contacts for edge in c.stations if len(edge.cycles.count)]
    irregular = any(edge.cycles.irregular for _, edge in every)
    return max(every, key=lambda each: each[1].cycles.k_t_range.max()) if irregular else None


def worst_states(solution: Solution, contacts: Sequence[Contact]) -> Indices:
    """(n,) states on the way through the worst counted cycle of the edges of some contacts.

    Empty if the loads are regular.
    """
    counted = worst_counted(contacts)
    if counted is None:
        return np.zeros(0, dtype=np.int64)
    contact, edge = counted
    # Of solids `last` is the state in which the front is followed.
    own = (edge.first, edge.last) if edge.first >= 0 else None
    own, places = (solution.cycle, edge.places) if contact.solid else (own, edge.position)
    history = next(each for each in solution.contacts if each.name == contact.name)
    friction = history.edge_friction(places)
    memory = EdgeMemory.of(edge, friction, own[1] if own else len(friction) - 1, edge.stiffening)
    halves = memory.longest(own or ()) if memory else ()
    return memory.path(halves) if memory and halves else np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class StressParameters:
    """Of one body at the N nodes of a contact and D depths below; NaN where it does not reach.

    Attributes:
        body: its name.
        depths: (D,) [length].
        largest_tension: (D, N) largest stress along the surface in the cycle [stress].
        ruiz2: (N,) second parameter of Ruiz, Boddington and Chen (Exp. Mech. 24, 1984) at the
            surface: the largest tension along it, zero if there is none, times the largest |q|
            times the largest distance between two places of the slip [stress^2 length]. NaN
            without the depth 0.
        swt: (D, N) Smith-Watson-Topper parameter [stress].
        swt_normal: (D, N, 3) normal of its plane.
        shear_strain: (D, N) largest amplitude of the shear strain on any plane [1].
        fatemi_socie: (D, N) Fatemi-Socie parameter [1]; None without its two numbers.
        octahedral_shear, cube_shear: (D, N) largest range of the resolved shear stress on the 12
            slip systems {111}<110> and the 6 {001}<110> [stress]; NaN if no cubic crystal.
    """

    body: str
    depths: Array
    largest_tension: Array
    ruiz2: Array
    swt: Array
    swt_normal: Array
    shear_strain: Array
    fatemi_socie: Array | None
    octahedral_shear: Array
    cube_shear: Array


def stress_parameters(
    history: StressHistory,
    number: int,
    material: AnyBody,
    shear_numbers: tuple[float, float] | None = None,
) -> StressParameters:
    """Parameters of one of the two bodies of a contact.

    Args:
        history: the stress near the contact.
        number: of the body, 0 or 1.
        material: of that body.
        shear_numbers: k and yield stress of Fatemi and Socie, if they are known.

    Raises:
        CaseError: as for `fatemi_socie`.
    """
    combined = fatemi_socie(*shear_numbers) if shear_numbers else None
    body = history.bodies[number]
    largest = tension(body.stress, history.frames[:, 1]).max(axis=0)
    normal = _critical(body.stress, material, smith_watson_topper)
    shape = body.stress.shape[1:3]

    def sheared(parameter: Parameter) -> Array:
        return _critical(body.stress, material, parameter).value.reshape(shape)

    octahedral, cube = resolved_shear(body.stress, material)
    return StressParameters(
        body=body.name,
        depths=history.depths,
        largest_tension=largest,
        ruiz2=_ruiz2(history, largest),
        swt=normal.value.reshape(shape),
        swt_normal=normal.normal.reshape(*shape, 3),
        # Without the normal stress there is nothing to be weighted by the yield stress.
        shear_strain=sheared(fatemi_socie(0.0, 1.0)),
        fatemi_socie=sheared(combined) if combined else None,
        octahedral_shear=octahedral,
        cube_shear=cube,
    )


def resolved_shear(stress: Array, material: AnyBody) -> tuple[Array, Array]:
    """Largest ranges (D, N) over the octahedral and over the cube systems of a cubic crystal.

    Args:
        stress: (n, D, N, c) as of `BodyStress` [stress].
        material: of the body; NaN of one that is no cubic crystal.
    """
    shape = stress.shape[1:3]
    if not isinstance(material, Crystal) or material.elastic.cubic is None:
        return np.full(shape, np.nan), np.full(shape, np.nan)
    tensors, found = _tensors(stress), []
    for systems in slip_systems(material.orientation.axes):
        factors = np.stack([systems[:, i, j] * (1 + (i != j)) for i, j in PAIRS])
        largest = np.full(tensors.shape[1], -np.inf)
        for each in factors.T:
            largest = np.maximum(largest, np.ptp(tensors @ each, axis=0))
        found.append(largest.reshape(shape))
    return found[0], found[1]


def _critical(stress: Array, material: AnyBody, parameter: Parameter) -> Critical:
    """Largest parameter at D * N points, of stresses (n, D, N, c)."""
    tensors = _tensors(stress)
    # Voigt's order of compliances is another one; half of a shear strain is the tensor's.
    order = [0, 1, 2, 5, 3, 4]
    matrix = compliance(material)[np.ix_(order, order)] / [[1], [1], [1], [2], [2], [2]]
    return find_critical(tensors, tensors @ matrix.T, parameter)


def _tensors(stress: Array) -> Array:
    """(n, D * N, 6) all components of stresses (n, D, N, c) as of `critical_planes.PAIRS`."""
    states, depths, nodes, own = stress.shape
    tensors = np.zeros((states, depths * nodes, 6))
    tensors[..., :own] = stress.reshape(states, depths * nodes, own)
    return tensors


def tension(stress: Array, tangents: Array) -> Array:
    """(..., N) stress along tangents (N, 2 or 3) in the plane, of stresses (..., N, 4 or 6)."""
    x, y = tangents[:, :2].T
    xx, yy, _, xy = np.moveaxis(stress[..., :4], -1, 0)
    return np.asarray(xx * x**2 + yy * y**2 + 2 * xy * x * y)


def _ruiz2(history: StressHistory, tension: Array) -> Array:
    at_surface = np.flatnonzero(history.depths == 0)
    if not len(at_surface):
        return np.full(len(history.arc), np.nan)
    touched: Bools = history.status != OPEN
    # The state before the first step belongs to the slip if the node is in contact after it.
    touched[0] = touched[min(1, len(touched) - 1)]
    slip = history.slip.reshape(*touched.shape, -1)
    shear = np.linalg.norm(history.traction[..., 1:], axis=2).max(axis=0)
    return np.asarray(np.maximum(tension[at_surface[0]], 0.0) * shear * _extent(slip, touched))


@dataclass(frozen=True)
class LocalParameters:
    """Of each of the N nodes of a contact, in the units of the case; zero where nothing slips.

    Attributes:
        slip_range: (N,) delta, largest distance between two places of the slip while in contact
            [length]. Its amplitude is half of that.
        path: (N,) length of the way that slips under pressure in the cycle [length].
        work: (N,) friction work per area in the cycle, the integral of q ds [force/length]. Its
            integral over the contact is the friction work of the cycle.
        pressed_path: (N,) integral of p |ds| [force/length]. Wear after Archard (1953): depth per
            cycle = k times this, k the specific wear rate (volume per force and way).
        ruiz: (N,) first parameter of Ruiz, Boddington and Chen (Exp. Mech. 24, 1984): largest |q|
            in the cycle times `slip_range` [force/length].
    """

    slip_range: Array
    path: Array
    work: Array
    pressed_path: Array
    ruiz: Array


def local_parameters(contact: ContactHistory, states: tuple[int, int]) -> LocalParameters:
    """Local parameters between two states.

    The traction in a step is the mean of that at its two ends, but for the friction work, which the
    solver gives. The pressure and shear of a node are means over the length that belongs to it: at
    an edge they are those of half an element.

    Args:
        contact: the contact; all states in between have to be kept.
        states: first and last state.
    """
    first, last = states
    count = contact.slip.shape[1]
    path, pressed, work, shear = (np.zeros(count) for _ in range(4))
    for part in blocks(last - first, count):
        steps = slice(first + part.start, first + part.stop + 1)
        traction = np.asarray(contact.mean_traction[steps])
        inside = np.asarray(contact.status[steps])[1:] != OPEN
        moved = inside * np.linalg.norm(np.diff(contact.slip[steps], axis=0), axis=2)
        path += moved.sum(axis=0)
        pressed += (moved * (traction[1:, :, 0] + traction[:-1, :, 0]) / 2).sum(axis=0)
        work += np.asarray(contact.dissipation[steps])[1:].sum(axis=0) / contact.surface.weights
        shear = np.maximum(shear, np.linalg.norm(traction[..., 1:], axis=2).max(axis=0))
    extent = np.zeros(count)
    if last > first:
        kept = slice(first, last + 1)
        touched = np.asarray(contact.status[kept]) != OPEN
        # The state before a step counts if the node is in contact after it, as for the work.
        touched[:-1] |= touched[1:]
        extent = _extent(np.asarray(contact.slip[kept]), touched)
    return LocalParameters(extent, path, work, pressed, shear * extent)


def _extent(slip: Array, touched: Bools) -> Array:
    """(N,) largest distance between two places of the slip (n, N, k), of the states in contact."""
    slip = np.where(touched[..., None], slip, np.nan)
    found = np.zeros(slip.shape[1])
    if slip.shape[2] == 1:
        low, high = np.fmin.reduce(slip[..., 0]), np.fmax.reduce(slip[..., 0])
        return np.nan_to_num(high - low)
    for later in range(1, len(slip)):
        distance = np.linalg.norm(slip[:later] - slip[later], axis=2)
        found = np.fmax(found, np.fmax.reduce(distance))
    return found
