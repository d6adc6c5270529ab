# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacements of a cut, or temperatures, from another run: interpolated, then reduced in time.

Displacements u(x, t_k) of the steps k of a run become a few shapes and amplitudes, u = sum of
phi_r(x) a_r(t), by a singular value decomposition.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.bodies.point_values import OUTSIDE, PointValues
from fretfe.case import Case, FieldLoad, TemperatureFieldLoad, complaint
from fretfe.case.base import ABSOLUTE_ZERO
from fretfe.contact.interface import Course
from fretfe.errors import CaseError
from fretfe.fields.change_of_shape import doubt_of_unit
from fretfe.loads import History
from fretfe.mesh.contained import Opened, arrays_of, reading_seconds
from fretfe.mesh.mesh import place_text

if TYPE_CHECKING:
    from fretfe.fields.field import Cells, Field, Quantity

# Names of arrays beside those of the loads, whose names have no blanks.
TIMES = "times of steps"
ROUNDING = "rounding of values"
NUMBERED = "numbers of steps"
# Shapes are taken until the rest is below this part of the field,
EXACT = 1e-10
# or its rounding; or, where it has few digits, with so many of them below that.
ROUNDED = 1e-6
FEW = 20
# Random sums of the steps that stand for all of them if they leave out less than this part of that.
SUMS = 64
SPANNED = 0.1
# What is wanted of a load, and what to do if there is none of it.
AT_REST = ("displacement", "hold a boundary at rest by a support instead, fix = ['x', 'y']")
UNCHANGED = ("change of temperature", "leave the load out")
# Positions that differ by less than this part of the whole run are the same.
SAME = 1e-6
# Changes of temperature below this part of the temperatures are rounding.
ROUND_OFF = 1e-13
# Seconds that finding a place may take, and beginning to read a step, on a busy machine: a hundred
# times what is usual.
PLACE = 0.02
STEP = 1.0
# Points of a field without elements that are looked at around each place, by dimension; if those do
# not surround all places, as in long elements.
AROUND = {2: 12, 3: 32}
FAR_AROUND = 256
# Parts of its size that a field may miss a cut by as a part does; farther away it is another unit.
ELSEWHERE = 5.0


@dataclass(frozen=True, eq=False)
class Cut:
    """Displacements of a cut boundary, or temperatures of bodies, as a few shapes.

    Attributes:
        channel: name of the load.
        positions: (T,) of the steps of the run.
        shapes: (r, m, d) displacements or (r, m, 1) changes of temperature at the nodes; the
            largest amplitude of each is 1.
        courses: of their amplitudes.
        rest: root of the sum of squares of what is left out over that of everything.
        what: is left out, in words.
        numbered: whether the positions are numbers of steps, where none may be missing.
        doubt: of the unit of displacements, in words; empty if there is none.
    """

    channel: str
    positions: Array
    shapes: Array
    courses: tuple[Course, ...]
    rest: float
    what: str = "displacements of the cut"
    numbered: bool = False
    doubt: str = ""

    @property
    def notes(self) -> Iterator[str]:
        """Fate of the field, and what is doubtful about it, in words."""
        count, steps = len(self.shapes), len(self.positions)
        yield (
            f"loads.{self.channel}: {steps} step{'s' if steps > 1 else ''} of the run, up to "
            f"{self.positions[-1]:g}, as {count} shape{'s' if count > 1 else ''}; "
            f"{self.rest:.1e} of the {self.what} is left out"
        )
        if self.doubt:
            yield f"loads.{self.channel}: {self.doubt}"

    def require_steps(self, case: Case, history: History) -> None:
        """Check that a history stays within the run and leaves none of its steps out.

        Raises:
            CaseError: says where it does not.
        """
        values = history.values[:, history.channels.index(self.channel)]
        key, last = ("loads", self.channel, "history"), float(self.positions[-1])
        off = np.flatnonzero((values < -SAME * last) | (values > last * (1 + SAME)))
        if off.size:
            text = (
                f"expected positions in the run, from 0 (unloaded) to {last:g} (its last step), "
                f"found {values[off[0]]:g} at time {history.times[off[0]]:g}"
            )
            raise CaseError(complaint(case.source, key, text))
        if self.numbered:
            self._require_no_gap(case, history.times, values)
        low, high = np.sort(np.stack([values[:-1], values[1:]]), axis=0)
        first = np.searchsorted(self.positions, low + SAME * last, side="right")
        passed = np.flatnonzero(first < np.searchsorted(self.positions, high - SAME * last))
        if passed.size:
            step = int(passed[0])
            text = (
                f"expected a load step at every step of the run, found none at "
                f"{self.positions[first[step]]:g}, between {values[step]:g} at time "
                f"{history.times[step]:g} and {values[step + 1]:g} at time "
                f"{history.times[step + 1]:g}"
            )
            raise CaseError(complaint(case.source, key, text))

    def _require_no_gap(self, case: Case, times: Array, values: Array) -> None:
        """Check that positions (T,) at times (T,) are not where numbers of steps are missing."""
        steps, near = np.append(0.0, self.positions), SAME * self.positions[-1]
        after = np.clip(np.searchsorted(steps, values - near), 1, len(steps) - 1)
        between = (values > steps[after - 1] + near) & (values < steps[after] - near)
        missing = np.flatnonzero(between & (np.diff(steps)[after - 1] > 1 + near))
        if missing.size:
            state = int(missing[0])
            text = (
                f"expected positions at steps that the run has, found {values[state]:g} at time "
                f"{times[state]:g}, between {steps[after[state] - 1]:g} and "
                f"{steps[after[state]]:g} (steps: {', '.join(f'{x:g}' for x in steps[1:11])}"
                f"{', ...' if len(steps) > 11 else ''}); what lies between is not known, unless "
                "the column 'step' has times and is called 'time'"
            )
            raise CaseError(complaint(case.source, ("loads", self.channel, "history"), text))


@dataclass(frozen=True, eq=False)
class Asked:
    """Places at which a load asks for a field.

    Attributes:
        channel: name of the load.
        load: it.
        body: that the places are of.
        places: (m, d).
    """

    channel: str
    load: FieldLoad | TemperatureFieldLoad
    body: str
    places: Array


def read_cuts(path: Path, asked: Sequence[Asked]) -> dict[str, Cut]:
    """Displacements of cut boundaries in another run, by the names of their loads.

    Args:
        path: of a file with displacements, or a results folder, which is read once.
        asked: nodes of the boundaries, and the same arrays of the file.

    Raises:
        FretfeError: if the field is not as expected, or does not reach the places.
    """
    read, values = _read(path, "displacements", asked)
    cuts = {}
    for each, found in zip(asked, values, strict=True):
        assert isinstance(each.load, FieldLoad)
        scale = each.load.displacement_scale
        moved = scale * found[:, :, : each.places.shape[1]]
        doubt = doubt_of_unit(each.places, moved, scale, float(read[ROUNDING]))
        cuts[each.channel] = replace(_counted(path, each, read, moved, AT_REST), doubt=doubt)
    return cuts


def read_temperatures(
    path: Path, load: TemperatureFieldLoad, channel: str, places: Mapping[str, Array], start: Array
) -> Cut:
    """Changes of the temperature of bodies in another run.

    Args:
        path: of a file with temperatures.
        load: of the bodies.
        channel: name of the load.
        places: (m, d) nodes of each body, of m in all.
        start: (m,) their reference temperatures.

    Raises:
        FretfeError: if the field is not as expected, or does not reach the places.
    """
    asked = Asked(channel, load, "", np.concatenate(list(places.values())))
    read, (found,) = _read(path, "temperatures", [asked])
    coldest = float(found.min())
    if coldest < ABSOLUTE_ZERO:
        raise CaseError(
            f"{path}: expected temperatures >= {ABSOLUTE_ZERO:g} (absolute zero, in degrees "
            f"Celsius), found {coldest:g}"
        )
    change = found - start[:, None]
    # Interpolation rounds: without this, bodies at their reference temperature would be heated.
    change[np.abs(change) < ROUND_OFF * np.abs(found).max()] = 0
    cut = _counted(path, asked, read, change, UNCHANGED)
    return replace(cut, what="changes of temperature")


def _read(
    path: Path, quantity: Quantity, asked: Sequence[Asked]
) -> tuple[Mapping[str, Array], list[Array]]:
    """The steps as `_values_at` tells of them, and values (T, m, c) at all that is asked for."""
    # Imported where it is needed: most cases have no fields, and HDF5 takes a while.
    from fretfe.fields.field import field_file

    path = field_file(path, quantity)
    found = arrays_of(partial(_values_at, path, quantity, tuple(asked)), path)
    return found, [found[each.channel] for each in asked]


def _counted(
    path: Path, asked: Asked, read: Mapping[str, Array], values: Array, instead: tuple[str, str]
) -> Cut:
    """Values (T, m, c) of the loaded steps, reduced; what they are, and what to do without them."""
    times, (what, advice) = read[TIMES], instead
    numbers = asked.load.position == "number"
    if numbers:
        times = np.arange(1.0, len(times) + 1)
    elif times[0] == 0:
        if np.abs(values[0]).max() > SAME * np.abs(values).max():
            raise CaseError(
                f"{path}: expected no {what} at time 0, the unloaded state, found "
                f"{np.abs(values[0]).max():.3g}: count the steps instead (position = 'number')"
            )
        times, values = times[1:], values[1:]
    if not len(times) or not np.abs(values).max():
        raise CaseError(f"{path}: expected a {what} in some step, found none but 0: {advice}")
    cut = reduce_in_time(asked.channel, times, values, float(read[ROUNDING]))
    return replace(cut, numbered=bool(read[NUMBERED]) and not numbers)


def reduce_in_time(channel: str, positions: Array, moved: Array, rounding: float = 0.0) -> Cut:
    """Reduce displacements (T, m, d) at positions (T,) > 0 in a run to a few shapes.

    What is smaller than the rounding of the displacements, relative, is none of them.
    """
    steps = moved.reshape(len(moved), -1)
    basis, beyond = _spanning(steps)
    left, sizes, right = np.linalg.svd((steps @ basis).T, full_matrices=False)
    square = np.cumsum(np.append(sizes**2, beyond**2)[::-1])[::-1]
    rests = np.sqrt(np.append(square[1:], 0.0) / max(square[0], np.finfo(float).tiny))
    count = 1 + int(np.argmax(rests < max(EXACT, rounding)))
    if count > FEW:
        count = max(FEW, 1 + int(np.argmax(rests < ROUNDED)))
    amplitudes = sizes[:count, None] * right[:count]
    largest = np.maximum(np.abs(amplitudes).max(axis=1), np.finfo(float).tiny)
    shapes = ((basis @ left[:, :count]) * largest).T.reshape(count, *moved.shape[1:])
    whole = np.concatenate([[0.0], positions])
    courses = tuple(
        Course(whole, np.concatenate([[0.0], each])) for each in amplitudes / largest[:, None]
    )
    return Cut(channel, positions, shapes, courses, float(rests[count - 1]))


def _spanning(steps: Array) -> tuple[Array, float]:
    """Orthonormal columns (n, k) that span displacements (T, n), and the norm of what they do not.

    Many steps have a rank of ten or twenty, so that a few random sums of them, iterated once, have
    the same span (Halko, Martinsson, Tropp 2011, SIAM Review 53, section 4.5), and decomposing all
    of them would take longer than the run. If they leave too much out, it is the span of all steps.
    """
    if min(steps.shape) > 2 * SUMS:
        sums = np.random.default_rng(0).standard_normal((SUMS, len(steps))) @ steps
        sums = (steps @ np.linalg.qr(sums.T)[0]).T @ steps
        basis = np.linalg.qr(sums.T)[0]
        beyond = float(np.linalg.norm(steps - (steps @ basis) @ basis.T))
        if beyond < SPANNED * ROUNDED * np.linalg.norm(steps):
            return basis, beyond
    return np.linalg.qr(steps.T)[0], 0.0


def _values_at(
    path: Path, quantity: Quantity, asked: tuple[Asked, ...], opened: Opened
) -> Mapping[str, Array]:
    """Times (T,) of the steps, and values (T, m, 3) or (T, m, 1) at places (m, d), by their loads.

    This is done in another process, which the file may crash.
    """
    from fretfe.fields.field import read_field
    from fretfe.fields.sizes import bytes_of

    field = read_field(path, quantity, asked[0].load.arrays or ())
    work = PLACE * sum(len(each.places) for each in asked) + STEP * len(field.times)
    opened(reading_seconds(bytes_of(path)) + work)
    if asked[0].places.shape[1] == 2:
        field = _in_plane(path, quantity, field)
    chosen, between = zip(*(_interpolation(path, field, each) for each in asked), strict=True)
    # All of them from one pass through the file, most of whose time is that of unpacking.
    read = map(field.values, range(len(field.times)))
    steps = zip(*([values[rows] for rows in chosen] for values in read), strict=True)
    arrays = {}
    for each, interpolate, own in zip(asked, between, steps, strict=True):
        arrays[each.channel] = interpolate(np.stack(own))
        wrong = np.argwhere(~np.isfinite(arrays[each.channel]))
        if len(wrong):
            raise CaseError(
                f"{path}: expected finite {quantity}, found others near "
                f"{place_text(each.places[wrong[0, 1]])} in step {wrong[0, 0] + 1}"
            )
    told = {ROUNDING: np.array(field.rounding), NUMBERED: np.array(field.numbered)}
    return {TIMES: field.times, **told, **arrays}


def _in_plane(path: Path, quantity: Quantity, field: Field) -> Field:
    """A field of a plane mesh, moved to z = 0 as the mesh of a case is."""
    low, high = field.points[:, 2].min(), field.points[:, 2].max()
    if high > low:
        raise CaseError(
            f"{path}: expected {quantity} in one plane z, found points from z = {low:g} to "
            f"{high:g}; CalculiX writes plane elements without a thickness if its card *NODE FILE "
            "says OUTPUT=2D"
        )
    return replace(field, points=field.points * [1.0, 1.0, 0.0])


def _interpolation(
    path: Path, field: Field, asked: Asked
) -> tuple[Indices, Callable[[Array], Array]]:
    """Points (n,) of a field near places (m, d), and values there (T, m, c) by those (T, n, c)."""
    places = asked.places
    own = np.pad(places / asked.load.factor, ((0, 0), (0, 3 - places.shape[1])))
    if field.cells is None:
        if isinstance(asked.load, FieldLoad) and asked.load.part is not None:
            raise CaseError(
                f"{path}: expected no 'part' of points without elements, as in a table, found "
                f"{asked.load.part!r}"
            )
        return _between_points(path, field.points[:, : places.shape[1]], own, places)
    weights = _element_weights(path, field, field.cells, asked, own)
    chosen, columns = np.unique(weights.indices, return_inverse=True)
    near = sparse.csr_matrix((weights.data, columns, weights.indptr))
    return chosen, lambda steps: np.stack([near @ values for values in steps])


def _element_weights(
    path: Path, field: Field, cells: Cells, asked: Asked, own: Array
) -> sparse.csr_matrix:
    """(m, n) weights by shape functions, at places by the lengths of the file (m, 3)."""
    from fretfe.fields.field import elements_of_part
    from fretfe.fields.vtk import body_weights, element_weights

    part = asked.load.part if isinstance(asked.load, FieldLoad) else None
    if isinstance(asked.load, FieldLoad) and part is None and not cells.names:
        weights, away = body_weights(field, own, OUTSIDE)
    else:
        chosen = elements_of_part(path, cells, part, asked.body)
        weights, away = element_weights(field, chosen, own)
    sums = np.asarray(weights.sum(axis=1)).ravel()
    if (wrong := ~(np.abs(sums - 1) < SAME)).any():
        node = int(np.flatnonzero(wrong)[0])
        raise CaseError(
            f"{path}: expected weights of nodes of an element that add up to 1, found "
            f"{sums[node]:g} at {place_text(asked.places[node])}: is the element there inverted?"
        )
    farthest = int(np.argmax(away))
    if not away[farthest] <= OUTSIDE:
        raise CaseError(
            f"{path}: expected elements at all nodes, found the node at "
            f"{place_text(asked.places[farthest])} away from the nearest of them by "
            f"{100 * away[farthest]:.3g} % of its size{_hint(away[farthest])}"
        )
    return weights


def _between_points(
    path: Path, points: Array, own: Array, places: Array
) -> tuple[Indices, Callable[[Array], Array]]:
    """Interpolation that is linear in a Delaunay triangulation of points (n, d) near places."""
    dimension = points.shape[1]
    local = own[:, :dimension]
    if len(points) < 2:
        raise CaseError(f"{path}: expected at least 2 points, found {len(points)}")
    tree = cKDTree(points)
    for count in (AROUND[dimension], FAR_AROUND, len(points)):
        # Far fewer than all: their triangulation would take minutes.
        near = tree.query(local, count)[1] if count < len(points) else np.arange(len(points))
        chosen = np.unique(near)
        fault = _fault_of(points[chosen], local, places)
        if not fault:
            break
    if fault:
        raise CaseError(f"{path}: expected points around all nodes, found {fault}")
    # With points around those that were chosen, which may be the border of a hole only.
    around = np.unique(tree.query(points[chosen], min(AROUND[dimension], len(points)))[1])
    if hole := PointValues(points[around], np.zeros(len(around))).hole(local):
        node, away, apart = hole
        raise CaseError(
            f"{path}: expected points near all nodes, found the node at {place_text(places[node])} "
            f"in a hole: the nearest point is {away:.3g} away, where points are {apart:.3g} apart "
            "(lengths as in the file)"
        )

    def between(steps: Array) -> Array:
        """All steps at once: finding the triangles takes most of the time."""
        given = PointValues(points[chosen], np.concatenate(list(steps), axis=1))
        return given.at(local).reshape(len(places), len(steps), -1).swapaxes(0, 1)

    return chosen, between


def _fault_of(points: Array, local: Array, places: Array) -> str:
    """The node (m, d) at a place that points (n, d) do not surround, in words; "" without one."""
    given = PointValues(points, np.zeros(len(points)))
    found = {"beside": given.beside(local), "outside of": given.outside(local)}
    for where, (farthest, excess) in found.items():
        if excess > OUTSIDE:
            return (
                f"the node at {place_text(places[farthest])} {where} them by "
                f"{100 * excess:.3g} % of their extent{_hint(excess)}"
            )
    return ""


def _hint(excess: float) -> str:
    """Likely reason if a field ends so far away from a cut, over its size."""
    return "; are its coordinates in another unit (factor)?" if excess > ELSEWHERE else ""
