# SPDX-License-Identifier: LGPL-3.0-or-later
"""Element sizes of a geometry that Gmsh meshes: fine at given places, growing with the distance.

Everything here works on the current Gmsh model, which has named physical groups, and replaces
whatever size field it had. Lengths are in the units of the geometry.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from types import ModuleType

import numpy as np

from fretfe._typing import Array
from fretfe.mesh.gmsh import tags_of_groups

Mirror = Callable[[Array], Array]

# Far away: elements over the diagonal of the geometry, and elements around a full circle.
FEWEST_ACROSS = 12
AROUND_CIRCLE = 16
# Elements between a corner of a contact surface and the nearest fine place.
TO_CORNER = 8
# Elements at corners of contacts whose gap is looked at, over the length of the shorter surface;
# their growth.
AT_CORNERS = 5e-4
STEEP = 0.3
# Corners: the tangent turns by more than this angle, or the curvature changes by more than this
# fraction of the larger one.
SHARP = 1e-3
KINK = 0.1
# Step of differences, as a fraction of the parameter range of a curve.
DIFFERENCE = 1e-3
# Points of each curve at which distances from it are taken.
SAMPLING = 200
# Fewest and most points across a face at which distances from it are taken.
POINTS_ACROSS = 20, 500
# Sizes come from the field alone. Curvature is in the field too: Gmsh's own way of taking account
# of it makes lines that need a steep growth very slow.
OPTIONS = {
    "MeshSizeFromPoints": 0,
    "MeshSizeFromCurvature": 0,
    "MeshSizeExtendFromBoundary": 0,
    "Algorithm": 6,
}
# Relative error of the integral of 1/size along a curve, which places its nodes. Gmsh's own of 1e-9
# takes nine tenths of the time of a mesh that is fine at many places.
ALONG_CURVES = 1e-5


@dataclass(frozen=True)
class Source:
    """A fine place: elements of `size` at points (n, 2), which are no farther apart than that."""

    points: Array
    size: float


@dataclass(frozen=True)
class FinePlaces:
    """Fine places of solids: elements of `sizes` (n,) at points (n, 3)."""

    points: Array
    sizes: Array


@dataclass(frozen=True)
class Sizes:
    """Element sizes of a geometry.

    Attributes:
        boundaries: largest element size along whole boundaries, by physical curve group.
        growth: of the element size per distance from the nearest fine place.
        sources: places that are finer.
    """

    boundaries: Mapping[str, float]
    growth: float
    sources: Sequence[Source] = ()


def apply_sizes(gmsh: ModuleType, sizes: Sizes) -> None:
    """Make the next mesh of the current model as fine as wanted.

    Besides, elements follow the curvature of all curves, and elements at the corners of the named
    boundaries are no larger than a fraction of the distance to the nearest of the sources.
    """
    curves = tags_of_groups(gmsh, 1)
    along = [(size, curves[name]) for name, size in sizes.boundaries.items()]
    places = [(source.size, source.points) for source in sizes.sources]
    places += _corner_places(gmsh, [curves[name] for name in sizes.boundaries], places)
    mirrors = _mirrors(gmsh)
    distances = [
        (_distance(gmsh, "CurvesList", tags), size) for size, tags in along + round_curves(gmsh)
    ]
    for size, points in places:
        tags = _add_points(gmsh, np.vstack([mirror(points) for mirror in mirrors]))
        distances.append((_distance(gmsh, "PointsList", tags), size))
    fields = [_graded(gmsh, distance, size, sizes.growth) for distance, size in distances]
    _use_smallest(gmsh, fields)
    gmsh.option.setNumber("Mesh.LcIntegrationPrecision", ALONG_CURVES)


def apply_fine_sizes(
    contacts: Sequence[tuple[str, str]],
    growth: float,
    sources: Sequence[Source],
    along: int,
    gmsh: ModuleType,
) -> None:
    """Make the next mesh of the current model even along contacts, and finer at some places.

    Args:
        contacts: names of both surfaces of each.
        growth: of the element size per distance from the nearest fine place.
        sources: places that are finer.
        along: elements along the shorter surface of a contact where nothing else makes them finer.
        gmsh: the library, with the model.
    """
    curves = tags_of_groups(gmsh, 1)
    sizes: dict[str, float] = {}
    for surfaces in contacts:
        names = [name for name in surfaces if name in curves]
        lengths = [length_of(gmsh, curves[name]) for name in names]
        sizes |= {name: min(lengths) / along for name in names}
    apply_sizes(gmsh, Sizes(sizes, growth, sources))


def apply_corner_sizes(contacts: Sequence[tuple[str, str]], gmsh: ModuleType) -> None:
    """Make the next mesh of the current model show the gap next to the corners of contacts.

    Arguments are those of `apply_fine_sizes`.
    """
    curves = tags_of_groups(gmsh, 1)
    named = [curves[name] for pair in contacts for name in pair if name in curves]
    corners = [corner for own in named for corner in corners_of(gmsh, own)]
    size = AT_CORNERS * min(length_of(gmsh, own) for own in named)
    sources = [Source(corner[None], size) for corner in corners]
    apply_fine_sizes(contacts, STEEP, sources, TO_CORNER, gmsh)


def apply_sizes_on_faces(gmsh: ModuleType, sizes: Mapping[str, float], growth: float) -> None:
    """Make the next mesh of the current solid model as fine as wanted.

    Args:
        gmsh: the library.
        sizes: largest element size on whole boundaries, by physical surface group.
        growth: of the element size per distance from them.
    """
    field, fields = gmsh.model.mesh.field, []
    for name, faces in tags_of_groups(gmsh, 2).items():
        size = sizes.get(name)
        if size is None:
            continue
        boxes = np.reshape([gmsh.model.getBoundingBox(2, face) for face in faces], (-1, 2, 3))
        longest = np.linalg.norm(boxes[:, 1] - boxes[:, 0], axis=1).max()
        # Points of a face are further apart than its elements are long where it has many of these.
        points = int(np.clip(longest / size, *POINTS_ACROSS))
        distance = _distance(gmsh, "SurfacesList", faces, points)
        on_faces = int(field.add("Constant"))
        field.setNumbers(on_faces, "SurfacesList", faces)
        field.setNumber(on_faces, "VIn", size)
        field.setNumber(on_faces, "VOut", max(_diagonal(gmsh) / FEWEST_ACROSS, size))
        fields += [on_faces, _graded(gmsh, distance, size, growth)]
    _use_smallest(gmsh, fields)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", AROUND_CIRCLE)


def refine_near(places: FinePlaces, growth: float, gmsh: ModuleType) -> None:
    """Make the next mesh of the current model finer near some places, and elsewhere as it was.

    Args:
        places: in the plane of the model if that is plane; the third coordinate is zero.
        growth: of the element size per distance from them.
        gmsh: the library, with a model whose element sizes are set in whatever way.
    """
    from scipy.spatial import cKDTree

    if not len(places.sizes):
        return
    points, own = places.points, places.sizes
    if gmsh.model.getDimension() == 2:
        mirrored = [mirror(points[:, :2]) for mirror in _mirrors(gmsh)]
        points = np.column_stack([np.vstack(mirrored), np.zeros(len(points) * len(mirrored))])
        # Places along a front that is swept are many in space, and few in the section.
        cells = np.round(points / (0.5 * places.sizes.min()))
        _, kept, number = np.unique(cells, axis=0, return_index=True, return_inverse=True)
        least = np.full(len(kept), np.inf)
        np.minimum.at(least, number.ravel(), np.tile(places.sizes, len(mirrored)))
        points, own = points[kept], least
    # So that the nearest place tells the size anywhere, near to others with finer elements too.
    sizes = [np.min(own + growth * np.linalg.norm(points - point, axis=1)) for point in points]
    smallest, tree = min(sizes), cKDTree(points)

    def size_at(_dim: int, _tag: int, x: float, y: float, z: float, before: float) -> float:
        reach = (before - smallest) / growth
        if reach <= 0:
            return before
        distance, nearest = tree.query((x, y, z), distance_upper_bound=reach)
        if nearest == len(sizes):
            return before
        return float(min(before, sizes[nearest] + growth * distance))

    gmsh.model.mesh.setSizeCallback(size_at)


def curve_points(gmsh: ModuleType, curve: int) -> Array:
    """(n, 2) points along a curve, evenly spaced in its parameter."""
    (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
    values = gmsh.model.getValue(1, curve, np.linspace(low, high, SAMPLING + 1))
    return _vectors(values)


def length_of(gmsh: ModuleType, curves: Iterable[int]) -> float:
    """Length of curves; chords of an arc of 90 degrees are short of it by 3e-6."""
    steps = [np.diff(curve_points(gmsh, curve), axis=0) for curve in curves]
    return float(np.linalg.norm(np.vstack(steps), axis=1).sum())


def round_curves(gmsh: ModuleType) -> list[tuple[float, list[int]]]:
    """Curves that are not straight, by the element size that their smallest radius allows."""
    found: dict[float, list[int]] = {}
    for _, curve in gmsh.model.getEntities(1):
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
        places = np.linspace(low, high, SAMPLING // 10)
        curvature = np.linalg.norm(_shape(gmsh, curve, places)[2], axis=1).max()
        if curvature * _diagonal(gmsh) > KINK:
            size = float(f"{2 * np.pi / (AROUND_CIRCLE * curvature):.3g}")
            found.setdefault(size, []).append(curve)
    return list(found.items())


def _corner_places(
    gmsh: ModuleType, boundaries: Iterable[list[int]], places: Sequence[tuple[float, Array]]
) -> list[tuple[float, Array]]:
    """Corners of boundaries, with the element size that the nearest fine place asks for there."""
    found = []
    for curves in boundaries if places else ():
        for corner in corners_of(gmsh, curves):
            distances = [
                (np.linalg.norm(points - corner, axis=1).min(), size) for size, points in places
            ]
            size = min(max(distance / TO_CORNER, size) for distance, size in distances)
            found.append((float(size), corner[None]))
    return found


def corners_of(gmsh: ModuleType, curves: Sequence[int]) -> list[Array]:
    """Points (2,) where two of the curves meet with a turn or with different curvatures."""
    ends = []
    for curve in curves:
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
        points, tangents, curvatures = _shape(gmsh, curve, np.array([low, high]))
        ends += list(zip(points, tangents * [[1], [-1]], curvatures, strict=True))
    close = 1e-9 * _diagonal(gmsh)
    corners = []
    for (point, tangent, curvature), (other, onward, beyond) in combinations(ends, 2):
        if np.linalg.norm(point - other) > close:
            continue
        turn = np.linalg.norm(tangent + onward)
        jump = np.linalg.norm(curvature - beyond)
        largest = max(np.linalg.norm(curvature), np.linalg.norm(beyond), KINK / _diagonal(gmsh))
        if turn > SHARP or jump > KINK * largest:
            corners.append(point)
    return corners


def _shape(gmsh: ModuleType, curve: int, places: Array) -> tuple[Array, Array, Array]:
    """Points, unit tangents and curvature vectors (n, 2) of a curve at its parameters (n,).

    Second derivatives are differences of first ones: Gmsh's own are wrong by factors on arcs.
    """
    (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
    step = DIFFERENCE * (high - low)
    before = np.clip(places - step, low, high - 2 * step)
    points = _vectors(gmsh.model.getValue(1, curve, places))
    first = _vectors(gmsh.model.getDerivative(1, curve, places))
    low_first = _vectors(gmsh.model.getDerivative(1, curve, before))
    second = (_vectors(gmsh.model.getDerivative(1, curve, before + 2 * step)) - low_first) / (
        2 * step
    )
    speed = np.linalg.norm(first, axis=1, keepdims=True)
    tangents = first / speed
    along = np.sum(second * tangents, axis=1, keepdims=True) * tangents
    return points, tangents, (second - along) / speed**2


def _vectors(values: Array) -> Array:
    """(n, 2) vectors in the plane from Gmsh's flat list of coordinates."""
    return np.reshape(values, (-1, 3))[:, :2]


def _mirrors(gmsh: ModuleType) -> list[Mirror]:
    """Identity, and the maps from surfaces that are meshed as copies to their masters.

    Only the master is meshed; what its copy needs has to be asked for there.
    """
    matrices = [np.eye(4)]
    for dim, surface in gmsh.model.getEntities(2):
        if gmsh.model.mesh.getPeriodic(dim, [surface])[0] != surface:
            affine = np.reshape(gmsh.model.mesh.getPeriodicNodes(dim, surface)[3], (4, 4))
            inverse = np.linalg.inv(affine)
            if not any(np.allclose(inverse, known) for known in matrices):
                matrices.append(inverse)
    return [partial(_mapped, matrix) for matrix in matrices]


def _mapped(matrix: Array, points: Array) -> Array:
    return points @ matrix[:2, :2].T + matrix[:2, 3]


def _add_points(gmsh: ModuleType, points: Array) -> list[int]:
    """Points that no mesh has to have as nodes."""
    tags = []
    for x, y in points:
        tag = gmsh.model.addDiscreteEntity(0)
        gmsh.model.setCoordinates(tag, x, y, 0.0)
        tags.append(tag)
    return tags


def _use_smallest(gmsh: ModuleType, fields: Sequence[int]) -> None:
    """Take element sizes from the smallest value of fields, and from nothing else."""
    smallest = int(gmsh.model.mesh.field.add("Min"))
    gmsh.model.mesh.field.setNumbers(smallest, "FieldsList", fields)
    gmsh.model.mesh.field.setAsBackgroundMesh(smallest)
    for option, value in OPTIONS.items():
        gmsh.option.setNumber(f"Mesh.{option}", value)


def _distance(gmsh: ModuleType, kind: str, tags: Sequence[int], sampling: int = SAMPLING) -> int:
    """A field: distance from points, or from so many of each curve or across each surface."""
    field = int(gmsh.model.mesh.field.add("Distance"))
    gmsh.model.mesh.field.setNumbers(field, kind, tags)
    gmsh.model.mesh.field.setNumber(field, "Sampling", sampling)
    return field


def _graded(gmsh: ModuleType, distance: int, size: float, growth: float) -> int:
    """A field: a size where a distance is zero, growing with it."""
    largest = max(_diagonal(gmsh) / FEWEST_ACROSS, size)
    field = int(gmsh.model.mesh.field.add("Threshold"))
    numbers = {
        "InField": distance,
        "DistMin": 0.0,
        "DistMax": (largest - size) / growth,
        "SizeMin": size,
        "SizeMax": largest,
    }
    for name, value in numbers.items():
        gmsh.model.mesh.field.setNumber(field, name, value)
    return field


def _diagonal(gmsh: ModuleType) -> float:
    box = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
    return float(np.linalg.norm(box[1] - box[0]))
