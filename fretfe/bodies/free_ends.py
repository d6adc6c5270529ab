# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements along the fronts of solid contacts at their free ends, judged before the solve.

A station nearer to a free end than one element along the front has no range, and |ΔK| may be
largest there. Evenly spaced stations begin half of their spacing from the end: elements that are
shorter leave none of them out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretfe._typing import Indices
from fretfe.bodies.continued import normals_behind
from fretfe.bodies.definition import ModelDefinition, define_model
from fretfe.case import Case
from fretfe.evaluate.contacts import NEAR_FREE_END
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.templates import find_template
from fretfe.report.texts import rounded
from fretfe.surface.checks import InitialGap, initial_gaps
from fretfe.surface.surface import Surface

# Gaps over the largest one of a contact up to which it is expected to close at an end.
CLOSES = 0.02
# Layer at an end over the distance of the first station: those behind grow by 1.4 each, and with .8
# of it a pad has no range there.
BELOW = 0.7
# The key of templates and of extrusions.
END_SIZE = "end_size"


@dataclass(frozen=True)
class ThickEnd:
    """Free ends of a contact at which elements are too long along the fronts.

    Attributes:
        contact: its name.
        size: length of the elements there.
        wanted: largest length with which all stations have ranges, beside elements across the front
            as they are: nearer to one another than those no stations count.
        fixed: likewise, whatever the elements across the front.
        left_out: stations at an end nearer to it than an element.
    """

    contact: str
    size: float
    wanted: float
    fixed: float
    left_out: int


def end_warning(case: Case, mesh: Mesh) -> Iterator[str]:
    """One warning of all free ends at which elements are too long along the fronts, if any.

    The fronts of a part of another run end where that is cut, too: nothing is said of them.
    """
    ends = () if case.geometry.part is not None else tuple(thick_ends(case, mesh))
    if not ends:
        return
    worst = max(ends, key=lambda each: each.size / each.wanted)
    now, unit = _end_size(case), case.units.length
    if now is not None:
        what = f"set {now[0]} = {rounded_down(worst.wanted / worst.size * now[1]):g}"
    else:  # smaller ones may be smaller across the front, too
        what = f"make them {rounded_down(worst.fixed):g} {unit} long there"
        if worst.fixed < worst.wanted:
            what += f", or {BELOW:g} times as long as across the front"
    yield (
        f"elements are {rounded(worst.size, 2)} {unit} long along the fronts at the free ends of "
        f"contact{'s' * (len(ends) > 1)} {', '.join(each.contact for each in ends)}: at "
        f"{worst.left_out} of {case.edges.stations} stations next to an end |ΔK| will be unknown, "
        f"and may be larger than anywhere else; {what}"
    )


def thick_ends(case: Case, mesh: Mesh) -> Iterator[ThickEnd]:
    """Contacts of solids whose elements are too long along the fronts at free ends."""
    if mesh.dimension == 2:
        return
    model = define_model(case, mesh)
    for name, initial in initial_gaps(mesh, case).items():
        found = [
            each
            for surface in (initial.surface1, initial.surface2)
            for each in _along_front(case, mesh, model, initial, surface)
        ]
        size, spacing, across = max(
            found, key=lambda each: each[0] / max(each[1:]), default=(0.0, math.inf, 0.0)
        )
        if size > 1.05 * BELOW * max(spacing, across) / 2:
            left_out, part = max(math.floor(size / spacing + 0.5), 1), BELOW * _share(case) / 2
            yield ThickEnd(name, size, part * max(spacing, across), part * spacing, left_out)


def _along_front(
    case: Case, mesh: Mesh, model: ModelDefinition, initial: InitialGap, surface: Surface
) -> Iterator[tuple[float, float, float]]:
    """For each free end of a surface lengths of elements along the front, stations, two across."""
    from scipy.spatial import cKDTree

    gap = initial.gap - initial.gap.min()
    if not len(surface.ends) or not gap.max() > 0:
        return
    middles = surface.points[surface.ends].mean(axis=1)
    own = np.sort(surface.ends, axis=1)
    facets = _facets_at(surface, own)
    sizes, across = surface.sizes[facets], surface.normals[facets].mean(axis=1)
    distance, nearest = cKDTree(initial.points).query(middles)
    closes = (gap[nearest] < CLOSES * gap.max()) & (distance < sizes + initial.gap[nearest])
    bodies = initial.surface1.body, initial.surface2.body
    free = np.isnan(normals_behind(case, model, mesh, bodies, (middles, across, sizes))).any(axis=1)
    kept = closes & free
    edges = np.diff(surface.points[own[kept]], axis=1)[:, 0]
    lengths = np.linalg.norm(edges, axis=1)
    inward = np.cross(across[kept], edges)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    from_end = surface.nodes[facets[kept], : surface.corners.shape[1]] - middles[kept, None]
    reach = np.einsum("ecd,ed->ec", from_end, inward)
    inward *= np.sign(reach.sum(axis=1))[:, None]
    closing = np.concatenate([initial.points[gap < CLOSES * gap.max()], middles[kept]])
    for outward in np.unique(np.round(inward, 1), axis=0):
        alike = inward @ outward > 0.5 * np.linalg.norm(outward)
        if alike.any():
            length = float(np.ptp(closing @ np.median(inward[alike], axis=0)))
            size = float(np.median(np.abs(reach[alike]).max(axis=1)))
            yield size, length / case.edges.stations, 2 * float(lengths[alike].min())


def _facets_at(surface: Surface, edges: Indices) -> Indices:
    """(e,) facets of a surface that have edges (e, 2), whose nodes are sorted, at its rim."""
    corners = surface.corners
    pairs = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2)
    keys = pairs.reshape(-1, 2) @ [len(surface.points), 1]
    order = np.argsort(keys)
    place = np.searchsorted(keys[order], edges @ [len(surface.points), 1])
    return np.asarray(order[place] // corners.shape[1])


def _share(case: Case) -> float:
    """Length of elements at an end over the distance of a station there, by the tolerance."""
    return math.sqrt(min((case.edges.tolerance or NEAR_FREE_END) / NEAR_FREE_END, 1.0))


def graded(case: Case) -> Case:
    """The case with layers at free ends as thin as its stations need, where it gives none."""
    geometry, now = case.geometry, _end_size(case)
    if now is None:
        return case
    solid, parameters = geometry.solid, dict(geometry.parameters)
    length = _template_values(case)["length"] if solid is None else solid.shared(*case.bodies)
    wanted = rounded_down(BELOW * _share(case) * length / case.edges.stations / 2)
    given = END_SIZE in parameters if solid is None else solid.end_size is not None
    if given or wanted >= now[1]:
        return case
    changed: dict[str, Any] = (
        {"parameters": parameters | {END_SIZE: wanted}}
        if solid is None
        else {"solid": solid.model_copy(update={END_SIZE: wanted})}
    )
    return case.model_copy(update={"geometry": geometry.model_copy(update=changed)})


def _end_size(case: Case) -> tuple[str, float] | None:
    """Key of the thickness of layers at free ends, and its value; None without such a key."""
    solid = case.geometry.solid
    if solid is not None:
        return f"geometry.solid.{END_SIZE}", solid.end_size or solid.length / solid.layers
    values = _template_values(case)
    return (f"geometry.parameters.{END_SIZE}", values[END_SIZE]) if END_SIZE in values else None


def _template_values(case: Case) -> dict[str, float]:
    """Parameters of a template; none without one."""
    if case.geometry.template is None:
        return {}
    known = find_template(case.geometry.template, length=case.units.length).parameters
    return {each.name: each.default for each in known} | dict(case.geometry.parameters)


def rounded_down(size: float) -> float:
    """A length with two digits, no larger than it is."""
    power = 10.0 ** (math.floor(math.log10(size)) - 1)
    return float(f"{math.floor(size / power + 1e-9) * power:.2g}")
