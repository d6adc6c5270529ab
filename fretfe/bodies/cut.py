# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacements of a cut, or temperatures, from another run: interpolated, then reduced in time.

Displacements u(x, t_k) of the steps k of a run become a few shapes and amplitudes, u = sum of
phi_r(x) a_r(t), by a singular value decomposition.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
from fretfe.loads import History
from fretfe.mesh.contained import arrays_of
from fretfe.mesh.mesh import place_text

if TYPE_CHECKING:
    from fretfe.fields.field import Cells, Field, Quantity

# Shapes are taken until the rest is below this part of the field,
EXACT = 1e-10
# or its rounding; or, where it has few digits, with so many of them below that.
ROUNDED, FEW = 1e-6, 20
# Random sums of the steps that stand for all of them if they leave out less than this part of that.
SUMS, SPANNED = 64, 0.1
# Positions that differ by less than this part of the whole run are the same.
SAME = 1e-6
# Changes of temperature below this part of the temperatures are rounding.
ROUND_OFF = 1e-13
# Points of a field without elements that are looked at around each place, by dimension; if those do
# not surround all places, as in long elements.
AROUND, FAR_AROUND = {2: 12, 3: 32}, 256


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
    """

    channel: str
    positions: Array
    shapes: Array
    courses: tuple[Course, ...]
    rest: float
    what: str = "displacements of the cut"

    @property
    def note(self) -> str:
        """Fate of the field, in words."""
        count, steps = len(self.shapes), len(self.positions)
        return (
            f"loads.{self.channel}: {steps} step{'s' if steps > 1 else ''} of the run, up to "
            f"{self.positions[-1]:g}, as {count} shape{'s' if count > 1 else ''}; "
            f"{self.rest:.1e} of the {self.what} is left out"
        )

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


def read_cut(path: Path, load: FieldLoad, channel: str, body: str, places: Array) -> Cut:
    """Displacements of a cut boundary in another run.

    Args:
        path: of a file with displacements, or a results folder.
        load: of the boundary.
        channel: name of the load.
        body: that the boundary is of.
        places: (m, d) its nodes.

    Raises:
        FretfeError: if the field is not as expected, or does not reach the places.
    """
    work = partial(_values_at, path, "displacements", places, load.part, body, load.factor)
    found = arrays_of(work, path)
    moved = load.factor * found["values"][:, :, : places.shape[1]]
    steps = _counted(path, load.position, found["times"], moved, "displacement")
    return reduce_in_time(channel, *steps, float(found["rounding"]))


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
    every = np.concatenate(list(places.values()))
    work = partial(_values_at, path, "temperatures", every, None, "", load.factor)
    found = arrays_of(work, path)
    coldest = float(found["values"].min())
    if coldest < ABSOLUTE_ZERO:
        raise CaseError(
            f"{path}: expected temperatures >= {ABSOLUTE_ZERO:g} (absolute zero, in degrees "
            f"Celsius), found {coldest:g}"
        )
    change = found["values"] - start[:, None]
    # Interpolation rounds: without this, bodies at their reference temperature would be heated.
    change[np.abs(change) < ROUND_OFF * np.abs(found["values"]).max()] = 0
    steps = _counted(path, load.position, found["times"], change, "change of temperature")
    cut = reduce_in_time(channel, *steps, float(found["rounding"]))
    return replace(cut, what="changes of temperature")


def _counted(
    path: Path, position: str, times: Array, values: Array, what: str
) -> tuple[Array, Array]:
    """Positions (T,) of loaded steps and their values (T, m, c)."""
    if position == "number":
        times = np.arange(1.0, len(times) + 1)
    elif times[0] == 0:
        if np.abs(values[0]).max() > SAME * np.abs(values).max():
            raise CaseError(
                f"{path}: expected no {what} at time 0, the unloaded state, found "
                f"{np.abs(values[0]).max():.3g}: count the steps instead (position = 'number')"
            )
        times, values = times[1:], values[1:]
    if not len(times) or not np.abs(values).max():
        raise CaseError(f"{path}: expected a {what} in some step, found none but 0")
    return times, values


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
    path: Path,
    quantity: Quantity,
    places: Array,
    part: str | None,
    body: str,
    factor: float,
    opened: Callable[[], None],
) -> Mapping[str, Array]:
    """Times (T,) of the steps, and values (T, m, 3) or (T, m, 1) at places (m, d) of a body.

    This is done in another process, which the file may crash.
    """
    # Imported where it is needed: most cases have no fields, and HDF5 takes a while.
    from fretfe.fields.field import read_field

    field = read_field(path, quantity)
    opened()
    dimension = places.shape[1]
    own = np.pad(places / factor, ((0, 0), (0, 3 - dimension)))
    if dimension == 2 and np.ptp(field.points[:, 2]) > 0:
        raise CaseError(f"{path}: expected {quantity} in the plane z = 0, found others")
    if field.cells is None:
        moved = _between_points(path, field, own, places)
    else:
        chosen = _of_part(path, field.cells, part, body)
        weights = _element_weights(path, field, chosen, own, places)
        moved = np.stack([weights @ field.values(step) for step in range(len(field.times))])
    wrong = np.argwhere(~np.isfinite(moved))
    if len(wrong):
        raise CaseError(
            f"{path}: expected finite {quantity}, found others near "
            f"{place_text(places[wrong[0, 1]])} in step {wrong[0, 0] + 1}"
        )
    return {
        "times": field.times,
        "values": moved,
        "rounding": np.array(field.rounding),
    }


def _element_weights(
    path: Path, field: Field, chosen: Indices, own: Array, places: Array
) -> sparse.csr_matrix:
    """(m, n) weights by the shape functions of some elements."""
    from fretfe.fields.vtk import element_weights

    weights, away = element_weights(field, chosen, own)
    farthest = int(np.argmax(away))
    if away[farthest] > OUTSIDE:
        raise CaseError(
            f"{path}: expected elements at all nodes, found the node at "
            f"{place_text(places[farthest])} away from the nearest of them by "
            f"{100 * away[farthest]:.3g} % of its size"
        )
    return weights


def _of_part(path: Path, cells: Cells, part: str | None, body: str) -> Indices:
    """Numbers of the elements of a part, or of that with the name of a body; all without parts."""
    chosen = body if part is None else part
    if chosen in cells.names:
        return np.flatnonzero(cells.parts == cells.names.index(chosen))
    if part is not None or cells.names:
        raise CaseError(
            f"{path}: expected one of its parts {', '.join(map(repr, cells.names)) or '(none)'}, "
            f"found {chosen!r}"
        )
    return np.arange(len(cells.shapes))


def _between_points(path: Path, field: Field, own: Array, places: Array) -> Array:
    """(T, m, c) values that are linear in a Delaunay triangulation of points near places."""
    dimension = places.shape[1]
    points, local = field.points[:, :dimension], own[:, :dimension]
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
    steps = [field.values(step)[chosen] for step in range(len(field.times))]
    given = PointValues(points[chosen], np.concatenate(steps, axis=1))
    return given.at(local).reshape(len(places), len(steps), -1).swapaxes(0, 1)


def _fault_of(points: Array, local: Array, places: Array) -> str:
    """The node (m, d) at a place that points (n, d) do not surround, in words; "" without one."""
    given = PointValues(points, np.zeros(len(points)))
    found = {"beside": given.beside(local), "outside of": given.outside(local)}
    for where, (farthest, excess) in found.items():
        if excess > OUTSIDE:
            return (
                f"the node at {place_text(places[farthest])} {where} them by "
                f"{100 * excess:.3g} % of their extent"
            )
    return ""
