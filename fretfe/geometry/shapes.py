# SPDX-License-Identifier: LGPL-3.0-or-later
"""Choosing curves, faces and volumes of a CAD file by point, label and colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np

from fretfe._typing import Array
from fretfe.case import Selector
from fretfe.errors import MeshError

# A point may be this far from what it chooses, as a fraction of the size of the geometry.
REACH = 0.01
# Distances that differ by less, on the same scale, are equal.
TIE = 1e-6
# Colours are fractions in a file and whole numbers from 0 to 255 here: they may be rounded.
COLOUR_ROUNDING = 1
KINDS = {1: "curve", 2: "face", 3: "volume"}


@dataclass(frozen=True)
class Shape:
    """A curve (dim 1), face (2) or volume (3) of the model; label and colour may be empty.

    Its centre has as many coordinates as the space of the model.
    """

    dim: int
    tag: int
    label: str
    colour: str
    centre: tuple[float, ...]

    @classmethod
    def of(cls, gmsh: ModuleType, dim: int, tag: int) -> Shape:
        """What Gmsh knows of an entity of its model."""
        *rgb, alpha = gmsh.model.getColor(dim, tag)
        # without a colour of its own an entity has a transparent default
        colour = "#" + "".join(f"{value:02x}" for value in rgb) if alpha else ""
        return cls(dim, tag, gmsh.model.getEntityName(dim, tag), colour, _middle(gmsh, dim, tag))


def dimension_of(gmsh: ModuleType) -> int:
    """Number of coordinates of the bodies of the model: 3 where there are volumes, else 2."""
    return 3 if gmsh.model.getEntities(3) else 2


def _middle(gmsh: ModuleType, dim: int, tag: int) -> tuple[float, ...]:
    """A point on a curve half-way in its parameter; the middle of the box around anything else."""
    if dim == 1:
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, tag)
        place = gmsh.model.getValue(1, tag, [(low + high) / 2])
    else:
        place = np.reshape(gmsh.model.getBoundingBox(dim, tag), (2, 3)).mean(axis=0)
    return tuple(float(value) for value in place[: dimension_of(gmsh)])


def shape_text(shape: Shape) -> str:
    """A shape in words, so that a user finds it."""
    # rounded as a coordinate is, so that zero is not shown as 1e-16
    place = ", ".join(f"{round(value, 9) + 0.0:.6g}" for value in shape.centre)
    text = f"{KINDS[shape.dim]} {shape.tag} around ({place})"
    text += f", label '{shape.label}'" if shape.label else ""
    return text + (f", colour {shape.colour}" if shape.colour else "")


class Shapes:
    """All curves, faces or volumes of the model."""

    def __init__(self, gmsh: ModuleType, path: Path, dim: int) -> None:
        self._gmsh = gmsh
        self.path = path
        self.shapes = [Shape.of(gmsh, dim, int(tag)) for _, tag in gmsh.model.getEntities(dim)]
        self._kind = KINDS[dim]
        box = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
        self._dimension = dimension_of(gmsh)
        self._size = float(np.linalg.norm((box[1] - box[0])[: self._dimension]))

    def select(self, key: str, selector: Selector, allowed: Sequence[Shape]) -> list[Shape]:
        """The shapes among those allowed that a selector chooses, at least one.

        Args:
            key: of the selector in the case file, for messages.
            selector: what to choose.
            allowed: shapes to choose from.

        Raises:
            MeshError: it chooses none, or a point cannot choose between several.
        """
        if selector.all_points:
            chosen = [self._nearest(key, point, allowed) for point in selector.all_points]
            return list(dict.fromkeys(chosen))
        if selector.label is not None:
            chosen = [each for each in allowed if _has_label(each, selector.label)]
            what, known = f"label '{selector.label}'", [each.label for each in allowed]
        else:
            assert selector.color is not None
            chosen = [each for each in allowed if _has_colour(each, selector.color)]
            what, known = f"colour {selector.color}", [each.colour for each in allowed]
        if not chosen:
            there = ", ".join(sorted({each for each in known if each})) or "none"
            raise MeshError(
                f"{self.path}: {key}: no {self._kind} has the {what}; {what.split()[0]}s of "
                f"{self._kind}s in the file: {there}"
            )
        return chosen

    def _nearest(self, key: str, point: tuple[float, ...], allowed: Sequence[Shape]) -> Shape:
        place = f"the point ({', '.join(f'{value:.6g}' for value in point)})"
        if len(point) != self._dimension:
            raise MeshError(
                f"{self.path}: {key}: expected {self._dimension} coordinates, as the bodies are "
                f"{'plane' if self._dimension == 2 else 'solid'}, found {place}"
            )
        at = np.array([*point, 0.0][:3])
        distances = np.array([self._distance(shape, at) for shape in allowed])
        nearest = allowed[int(distances.argmin())]
        if distances.min() > REACH * self._size:
            raise MeshError(
                f"{self.path}: {key}: {place} is {distances.min():.3g} away from the nearest "
                f"{self._kind} ({shape_text(nearest)}); expected at most {REACH * self._size:.3g}, "
                f"{REACH:.0%} of the size of the geometry"
            )
        equal = [
            shape
            for shape, distance in zip(allowed, distances, strict=True)
            if distance < distances.min() + TIE * self._size
        ]
        if len(equal) > 1:
            named = nearest.dim == self._dimension
            advice = "" if named else ", or say which with body = NAME"
            raise MeshError(
                f"{self.path}: {key}: {place} does not tell between "
                f"{' and '.join(map(shape_text, equal))}; take one in the middle of the "
                f"{self._kind} and away from others{advice}"
            )
        return nearest

    def _distance(self, shape: Shape, point: Array) -> float:
        """Distance of a point (3,) from a shape; 0 inside a volume or a plane face."""
        if shape.dim == 1:
            return _curve_distance(self._gmsh, shape.tag, point)
        if shape.dim == 2:
            return _face_distance(self._gmsh, shape.tag, point)
        if self._gmsh.model.isInside(3, shape.tag, point):
            return 0.0
        border = self._gmsh.model.getAdjacencies(3, shape.tag)[1]
        return min(_face_distance(self._gmsh, int(face), point) for face in border)


def _face_distance(gmsh: ModuleType, face: int, point: Array) -> float:
    """From the foot of the perpendicular, if it is in the face, or from the border."""
    foot = gmsh.model.getClosestPoint(2, face, point)[0]
    if gmsh.model.isInside(2, face, foot):
        return float(np.linalg.norm(foot - point))
    border = gmsh.model.getAdjacencies(2, face)[1]
    return min(_curve_distance(gmsh, int(curve), point) for curve in border)


def _curve_distance(gmsh: ModuleType, curve: int, point: Array) -> float:
    """From the foot of the perpendicular or from an end, whichever is nearer."""
    bounds = np.ravel(gmsh.model.getParametrizationBounds(1, curve))
    ends = np.reshape(gmsh.model.getValue(1, curve, bounds), (-1, 3))
    foot = gmsh.model.getClosestPoint(1, curve, point)[0]
    return float(np.linalg.norm(np.vstack([ends, foot]) - point, axis=1).min())


def _has_label(shape: Shape, label: str) -> bool:
    """Whether a label is the whole path of a part in the file, or the last name in it."""
    return label in (shape.label, shape.label.rpartition("/")[2])


def _has_colour(shape: Shape, colour: str) -> bool:
    if not shape.colour:
        return False
    pair = (bytes.fromhex(each.removeprefix("#")) for each in (shape.colour, colour))
    return all(abs(a - b) <= COLOUR_ROUNDING for a, b in zip(*pair, strict=True))
