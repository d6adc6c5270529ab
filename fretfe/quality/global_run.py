# SPDX-License-Identifier: LGPL-3.0-or-later
"""Agreement of a part with the run whose displacements move its cuts, and a second cut inside.

What a part carries follows from the displacements of its cuts, which nothing forces to be those of
bodies in equilibrium: the forces through its contact tell whether they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.case import Case, parse_case
from fretfe.case.loads import FieldLoad
from fretfe.errors import FretfeError
from fretfe.evaluate.limits import surface_notes
from fretfe.fields.field import Field, run_field
from fretfe.fields.vtk import element_weights
from fretfe.history.solution import ContactHistory, Solution
from fretfe.history.state_array import states_in_block
from fretfe.mesh.elements import KINDS, shape_values
from fretfe.mesh.mesh import BodyMesh
from fretfe.mesh.part import cut_name, seen
from fretfe.quality.rows import Place, Row
from fretfe.results.field_files import DISPLACEMENTS, FIELDS
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.surface.surface import normal_vectors

# Distance of the second cut over that of the first one, and over that of the edges at least.
NEARER = 2 / 3
ROOM = 1.1
# Times of states that differ by less than this part of the whole run are the same.
SAME_STATE = 1e-6
# Largest difference of force and moment, relative to their largest value; from which it is warned.
SAME_FORCE = 0.02


@dataclass(frozen=True)
class Carried:
    """Forces through a contact of a part and through that of the run that drives it.

    Attributes:
        load: name of a load that the run drives.
        contact: name of the contact.
        forces: (2, T, d) on body 2, of the part and of the run.
        moments: (2, T, 1 or 3) about the middle of the surface of the part.
        arm: largest distance of its nodes under pressure from there.
        reason: why there is nothing to compare, in words; empty if there is.
    """

    load: str
    contact: str
    forces: Array
    moments: Array
    arm: float
    reason: str = ""

    @property
    def differences(self) -> tuple[float, float]:
        """Largest difference of force, and of moment, over the largest force (times the arm)."""
        most = float(np.linalg.norm(self.forces[1], axis=1).max()) or math.nan
        force, moment = (
            float(np.linalg.norm(each[0] - each[1], axis=1).max())
            for each in (self.forces, self.moments)
        )
        return force / most, moment / (most * self.arm)


def carried(result: Result) -> Iterator[Carried]:
    """Compare what the contacts of a part carry with those of the results folder that drives it.

    Runs of other programs have no contacts that could be read: nothing is said of them.
    """
    case, known = result.case, set()
    for name, load in case.cut_loads.items():
        folder = case.resolve(load.file)
        if not folder.is_dir() or folder in known:
            continue
        known.add(folder)
        try:
            run = load_result(folder)
        except FretfeError as error:
            yield _unknown(name, "", f"its results cannot be read: {error}")
            continue
        for contact in dict.fromkeys(each.pair for each in result.solution.contacts):
            yield _carried(result, run, name, load, contact)


def _unknown(load: str, contact: str, reason: str) -> Carried:
    none = np.full((2, 1, 1), np.nan)
    return Carried(load, contact, none, none, math.nan, reason)


def _carried(result: Result, run: Result, name: str, load: FieldLoad, pair: str) -> Carried:
    """Forces through one contact at the states of the part, which are positions in the run."""
    one, other = (_patches(each.solution, pair) for each in (result, run))
    if not other:
        return _unknown(name, pair, f"the run has no contact {pair!r}")
    if not _same_units(load):
        return _unknown(name, pair, "the run has another unit of length")
    if result.solution.kept is not None or run.solution.kept is not None:
        return _unknown(name, pair, "the tractions of all states are not kept")
    # At the states of the part, by those of the run at its positions.
    positions = result.solution.values[:, result.solution.channels.index(name)]
    times = run.solution.times
    if load.position == "number":
        times = np.arange(len(times), dtype=float)
    own = one[0].surface.points
    pressed = pressed_nodes(other)
    away, nearest = cKDTree(own).query(other[0].surface.points[pressed])
    if (away > _reaches(one[0])[nearest]).any():
        return _unknown(name, pair, "the cut runs through the contact of the run")
    middle = (own.min(axis=0) + own.max(axis=0)) / 2
    forces, moments = zip(*(_resultants(each, middle) for each in (one, other)), strict=True)
    by_run = [
        np.stack([np.interp(positions, times, column) for column in each[1].T], axis=1)
        for each in (forces, moments)
    ]
    arm = float(np.linalg.norm(own[pressed_nodes(one)] - middle, axis=1).max(initial=0.0))
    return Carried(
        name,
        pair,
        np.stack([forces[0], by_run[0]]),
        np.stack([moments[0], by_run[1]]),
        arm or math.nan,
    )


def _same_units(load: FieldLoad) -> bool:
    """True if lengths of the run are in the unit of the case."""
    return load.factor == load.displacement_scale == 1


def _patches(solution: Solution, pair: str) -> list[ContactHistory]:
    return [each for each in solution.contacts if each.pair == pair]


def pressed_nodes(patches: list[ContactHistory]) -> Indices:
    """Nodes of a pair of surfaces that are under pressure in some state."""
    found = np.zeros(len(patches[0].surface.points), dtype=bool)
    for patch in patches:
        for states in _blocks(patch):
            found |= (patch.traction[states, :, 0] > 0).any(axis=0)
    return np.flatnonzero(found)


def _reaches(contact: ContactHistory) -> Array:
    """(N,) largest extent of the facets of a surface around each of its nodes."""
    count = len(contact.surface.points)
    facets = contact.surface.facets
    if facets is None:
        facets = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    extents = np.linalg.norm(np.ptp(contact.surface.points[facets], axis=1), axis=1)
    found = np.zeros(count)
    for column in facets.T:
        np.maximum.at(found, column, extents)
    return found


def _blocks(patch: ContactHistory) -> Iterator[slice]:
    """States that are read at a time: a file is opened for each of them."""
    count, each = len(patch.traction), states_in_block(patch.traction[0].nbytes)
    return (slice(first, first + each) for first in range(0, count, each))


def _resultants(patches: list[ContactHistory], about: Array) -> tuple[Array, Array]:
    """(T, d) force on body 2 and (T, 1 or 3) moment about a point, through a pair of surfaces."""
    arms, forces, moments = patches[0].surface.points - about, [], []
    for states in _blocks(patches[0]):
        nodes = np.sum([_nodal_forces(patch, states) for patch in patches], axis=0)
        if arms.shape[1] == 2:
            turning = (arms[:, 0] * nodes[..., 1] - arms[:, 1] * nodes[..., 0])[..., None]
        else:
            turning = np.cross(arms, nodes)
        forces.append(nodes.sum(axis=1))
        moments.append(turning.sum(axis=1))
    return np.concatenate(forces), np.concatenate(moments)


def _nodal_forces(patch: ContactHistory, states: slice) -> Array:
    """(n, N, d) on body 2: against its normal by the pressure, along its tangents by shear."""
    traction = patch.mean_traction[states] * np.where(
        np.arange(patch.surface.points.shape[1]) == 0, -1, 1
    )
    nodes = np.einsum("snk,nkd->snd", traction, patch.surface.frames)
    return np.asarray(patch.surface.weights[:, None] * nodes)


@dataclass(frozen=True)
class CutTractions:
    """Tractions on a cut of a part, by its own stress and by that of the run that drives it.

    Attributes:
        load: name of the load of the cut.
        times: (S,) of the states whose stress both have.
        sizes: (S,) roots of mean squares of the tractions of the run over the cut.
        differences: (S,) of those of the part from them, as roots of mean squares.
    """

    load: str
    times: Array
    sizes: Array
    differences: Array


def cut_tractions(result: Result) -> Iterator[CutTractions]:
    """Compare the stress on cuts with that of the results folders that drive them.

    At the middles of the facets, in the elements of either run. Stress converges more slowly than
    displacements: the elements of the run are the coarser ones.
    """
    case = result.case
    if result.directory is None:
        return
    own = result.directory / FIELDS
    for name, load in case.cut_loads.items():
        if load.position != "time" or not _same_units(load):
            continue
        path = case.resolve(load.file) / FIELDS
        owners = [each for each in result.bodies.values() if load.boundary in each.boundaries]
        if not (own.is_file() and path.is_file() and owners):
            continue
        fields = run_field(own, "stress"), run_field(path, "stress")
        places, areas = _middles(owners[0], load.boundary)
        parts = owners[0].name, load.part or owners[0].name
        weights = [
            element_weights(field, _elements(field, part), places)[0]
            for field, part in zip(fields, parts, strict=True)
        ]
        positions = np.interp(
            fields[0].times, result.loads.times,
            result.loads.values[:, result.loads.channels.index(name)],
        )  # fmt: skip
        found = []
        for step, position in enumerate(positions):
            other = int(np.abs(fields[1].times - position).argmin())
            if abs(fields[1].times[other] - position) > SAME_STATE * fields[1].times[-1]:
                continue
            mine, theirs = (
                _tractions(weight @ field.values(number), areas)
                for weight, field, number in zip(weights, fields, (step, other), strict=True)
            )
            found.append((fields[0].times[step], _size(theirs, areas), _size(mine - theirs, areas)))
        if found:
            yield CutTractions(name, *np.array(found).T)


def _elements(field: Field, part: str) -> Indices:
    """Numbers of the elements of a body in the field of a run."""
    assert field.cells is not None
    return np.flatnonzero(field.cells.parts == field.cells.names.index(part))


def _middles(body: BodyMesh, boundary: str) -> tuple[Array, Array]:
    """Places (m, 3) in the middle of the facets of a boundary, and their normals times areas."""
    facets = body.boundaries[boundary]
    shape, order = KINDS[body.points.shape[1], facets.shape[1]]
    middle = np.full((1, body.points.shape[1] - 1), 1 / 3 if shape == "triangle" else 0.5)
    nodes = body.points[facets]
    places = np.einsum("qk,fkd->fd", shape_values(shape, order, middle), nodes)
    normals = normal_vectors(nodes, shape, order, middle)[:, 0]
    missing = ((0, 0), (0, 3 - places.shape[1]))
    return np.pad(places, missing), np.pad(normals, missing)


def _tractions(stress: Array, areas: Array) -> Array:
    """(m, 3) tractions by stress (m, 6) on facets with normals times areas (m, 3)."""
    tensors = stress[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    normals = areas / np.linalg.norm(areas, axis=1, keepdims=True)
    return np.asarray(np.einsum("mij,mj->mi", tensors, normals))


def _size(tractions: Array, areas: Array) -> float:
    """Root of the mean square of tractions (m, 3) over facets."""
    weights = np.linalg.norm(areas, axis=1)
    return float(np.sqrt(weights @ (tractions**2).sum(axis=1) / weights.sum()))


def traction_notes(result: Result) -> Iterator[str]:
    """Differences of the tractions on cuts from those of the run, in words."""
    for cut in cut_tractions(result):
        worst = int(cut.differences.argmax())
        yield (
            f"loads.{cut.load}: the tractions on the cut differ from those of the run by up to "
            f"{cut.differences[worst] / cut.sizes.max():.2g} of the largest ones (roots of mean "
            f"squares over the cut, {len(cut.times)} states), at time {cut.times[worst]:g}"
        )


def carried_notes(result: Result) -> Iterator[str]:
    """Differences of the forces through the contacts of a part from those of the run, in words."""
    for each in carried(result):
        if each.reason:
            yield f"loads.{each.load}: not compared with the forces of the run, as {each.reason}"
            continue
        force, moment = each.differences
        text = (
            f"loads.{each.load}: through contact {each.contact} the force differs from that of the "
            f"run by up to {force:.2g} of the largest one, its moment about the middle of the "
            f"surface by up to {moment:.2g} of that force times {each.arm:.3g}"
        )
        if max(force, moment) > SAME_FORCE:
            text += (
                ". The part does not carry what the run carries: its displacements near the cuts "
                "are not those of bodies in equilibrium with these materials, loads and friction"
            )
        yield text


def followed_notes(result: Result) -> Iterator[str]:
    """Difference that another program makes where it follows the deformed surfaces, in words."""
    case, histories = result.case, result.solution.contacts
    files = [case.resolve(each.file) for each in case.cut_loads.values()]
    if not all(each.is_dir() or each.name in (FIELDS, DISPLACEMENTS) for each in files):
        bodies, plane = case.bodies, case.model.plane
        yield from surface_notes(bodies, plane, histories, result.contacts, result.limits)


def carried_rows(result: Result) -> Iterator[Row]:
    """Rows for forces and moments through the contacts of a part, against those of the run."""
    for each in carried(result):
        at, what = Place(each.contact or "all"), "force, against the run that drives the cuts"
        if each.reason:
            yield at.missing(what, each.reason)
            continue
        reason = (
            "in the state of the largest difference; bodies in equilibrium carry the same on every "
            f"section, tolerance {SAME_FORCE:.0%} of the largest force"
        )
        most = float(np.linalg.norm(each.forces[1], axis=1).max())
        for name, values, scale in (
            (what, each.forces, most),
            ("moment" + what.removeprefix("force"), each.moments, most * each.arm),
        ):
            off = np.abs(values[0] - values[1])
            state, axis = np.unravel_index(off.argmax(), off.shape)
            yield at.compared(
                name,
                float(values[0, state, axis]),
                float(values[1, state, axis]),
                SAME_FORCE * scale,
                reason,
            )


def second_cut(result: Result) -> Case | str:
    """The case of a part with cuts nearer to its contact; the reason if there is none.

    The displacements of the run move the new cuts, too.
    """
    case = result.case
    fields = case.cut_loads
    if len(result.contacts) != 1 and case.geometry.part is None:
        return "there are several contacts, and no circle or ball around one of them"
    pressed = np.concatenate(
        [each.surface.points[pressed_nodes([each])] for each in result.solution.contacts]
    )
    owners = {
        load.boundary: body
        for load in fields.values()
        for body, mesh in result.bodies.items()
        if load.boundary in mesh.boundaries
    }
    part = case.geometry.part
    if part is not None:
        centre, radius = np.array(part.centre), part.radius
    else:
        centre = (pressed.min(axis=0) + pressed.max(axis=0)) / 2
        radius = min(
            float(np.linalg.norm(mesh.points[mesh.boundaries[name]] - centre, axis=-1).min())
            for name, body in owners.items()
            for mesh in [result.bodies[body]]
        )
    reach = float(np.linalg.norm(seen(case, pressed, len(centre)) - centre, axis=1).max())
    if NEARER * radius < ROOM * reach:
        return (
            f"no room: the contact reaches {reach:.3g} from the middle of the part, the cuts are "
            f"at {radius:.3g}"
        )
    data = case.as_tables()
    data["geometry"]["part"] = {"centre": centre.tolist(), "radius": NEARER * radius}
    for name, load in fields.items():
        data["loads"][name]["boundary"] = cut_name(owners[load.boundary])
    return parse_case(data, source=case.source, trust_geo=case.trust_geo)
