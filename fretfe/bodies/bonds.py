# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parts of a body that are bonded: the nodes of one boundary follow the other one, as in `cyclic`.

Nodes that match are one. Else ∫ φ_i (u_s − u_m) = 0 for all of them that nothing holds, so that
tractions that are even on one boundary are so on the other, wherever it ends.

The boundary that follows lies within the other one, has no displacement held that the other one has
not, and where that leaves a choice, has more nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fretfe._typing import Array
from fretfe.bodies.constraints import Constraint
from fretfe.bodies.cyclic import SAME, Mortar, Tie, bends, places_on
from fretfe.case import Case, complaint
from fretfe.contact.interface import Coordinate
from fretfe.errors import CaseError
from fretfe.mesh.elements import quadrature, shape_values
from fretfe.mesh.mesh import BodyMesh, place_text
from fretfe.surface.surface import Surface, boundary_surface


def bond_parts(
    case: Case,
    body: BodyMesh,
    surfaces: Sequence[str],
    constraints: Sequence[tuple[Constraint, Coordinate]],
) -> Tie | None:
    """Tie the parts of a body; None if it has no ties.

    Args:
        case: its ties, and the degree of the displacements.
        body: mesh.
        surfaces: contact surfaces of the body.
        constraints: of the body, each with its coordinate.

    Raises:
        CaseError: boundaries are apart, at a contact, or not held alike.
    """
    parts = []
    for name, tie in case.ties.items():
        if tie.boundary1 in body.boundaries:
            pair = boundary_surface(body, tie.boundary1), boundary_surface(body, tie.boundary2)
            parts.append(_bond(case, ("ties", name), body, pair, constraints))
    if not parts:
        return None
    bond = _together(case, body, parts)
    for surface in surfaces:
        points = boundary_surface(body, surface).displacement_points(case.model.degree)
        if any(bond.among(own, points).any() for own in (bond.followers, bond.leaders)):
            text = (
                f"expected tied boundaries that are nowhere at a contact, found the contact surface"
                f" {surface!r} at one of them: mesh the parts of {body.name!r} there as one"
            )
            raise CaseError(complaint(case.source, ("ties",), text))
    for number, part in enumerate(parts):
        for other in parts[number + 1 :]:
            if any(bond.among(each.points, one.points).any()
                   for each in part[:2] for one in other[:2]):  # fmt: skip
                text = f"expected ties that do not meet, found two of {body.name!r} that do"
                raise CaseError(complaint(case.source, ("ties",), text))
    return bond


# The boundary that follows, the one that leads, and the weights of a tie.
_Part = tuple[Surface, Surface, sparse.csr_matrix]


def _bond(
    case: Case,
    key: tuple[str, str],
    body: BodyMesh,
    pair: tuple[Surface, Surface],
    constraints: Sequence[tuple[Constraint, Coordinate]],
) -> _Part:
    """The boundary that follows, the one that leads, and displacements of its nodes by those."""
    size = float(np.ptp(body.points, axis=0).max())
    degree = case.model.degree
    orders = [pair, pair[::-1]]
    orders.sort(key=lambda each: -len(each[0].displacement_points(degree)))
    misses = [_miss(following, leading) for following, leading in orders]
    within = [each for each, miss in zip(orders, misses, strict=True) if miss[0] <= SAME * size]
    if not within:
        _, distance, place = min(misses, key=lambda each: each[0])
        text = (
            f"expected boundaries in the same place, found a place of one that is {distance:.4g} "
            f"from the other, {place_text(place)}: the nearer of the two ways"
        )
        raise CaseError(complaint(case.source, key, text))
    bare = 0
    for following, leading in within:
        held, by = (_held(body, each, constraints, degree) for each in (following, leading))
        pinned = np.array([len(each) > 0 for each in held])
        weights = Mortar(following, leading, degree, SAME * size, pinned).weights()
        rows, columns = sparse.find(abs(weights) > SAME)[:2]
        ends = zip(rows.tolist(), columns.tolist(), strict=True)
        wrong = [row for row, other in ends if not held[row] <= by[other]]
        if not wrong:
            return following, leading, weights
        bare = wrong[0]
    place = within[-1][0].displacement_points(degree)[bare]
    text = (
        f"expected a place where both parts are held alike, found {place_text(place)}, where a "
        "support or load holds one of them only: let its boundary reach over both"
    )
    raise CaseError(complaint(case.source, key, text))


def _miss(following: Surface, leading: Surface) -> tuple[float, float, Array]:
    """The place farthest from another boundary: beyond what bent facets explain, in all, where."""
    at = quadrature(following.shape, 1)[0]
    values = shape_values(following.shape, following.degree, at)
    middles = np.einsum("qk,fkd->fqd", values, following.nodes)[:, 0]
    points, own = np.concatenate([following.points, middles]), bends(following)
    place = places_on(points, leading, 1)
    bent = np.zeros(len(following.points))
    np.maximum.at(bent, following.facets, own[:, None])
    excess = place.distance - np.concatenate([bent, own]) - bends(leading)[place.facets]
    worst = int(np.argmax(excess))
    return float(excess[worst]), float(place.distance[worst]), points[worst]


def _held(
    body: BodyMesh,
    tied: Surface,
    constraints: Sequence[tuple[Constraint, Coordinate]],
    degree: int,
) -> list[set[tuple[str, str]]]:
    """Constraints at each node of a tied boundary: by what it is held, along which direction."""
    points = tied.displacement_points(degree)
    held: list[set[tuple[str, str]]] = [set() for _ in points]
    own = np.unique(body.boundaries[tied.name])
    same = SAME * float(np.ptp(body.points, axis=0).max())
    for constraint, coordinate in constraints:
        name, by = constraint.boundary, coordinate.channel or constraint.label
        facets = body.boundaries[name]
        # of the same part: nodes of both parts may be in one place
        facets = facets[np.isin(facets, own).any(axis=1)]
        if not len(facets):
            continue
        near = boundary_surface(replace(body, boundaries={name: facets}), name)
        places = near.displacement_points(degree)
        distance = cKDTree(places).query(points)[0]
        what = f"{constraint.roller} {[round(each, 9) for each in constraint.direction]}"
        for node in np.flatnonzero((distance < same) & constraint.holds(points)).tolist():
            held[node].add(("" if coordinate.control == "fixed" else by, what))
    return held


def _together(case: Case, body: BodyMesh, parts: Sequence[_Part]) -> Tie:
    """All ties of a body in one."""
    gdim, degree = body.points.shape[1], case.model.degree
    components = case.components(gdim)
    followers, leaders = (
        np.concatenate([part[place].displacement_points(degree) for part in parts])
        for place in (0, 1)
    )
    return Tie(
        followers,
        leaders,
        sparse.block_diag([weights for *_, weights in parts], format="csr"),
        turn=np.eye(components),
        on_axis=np.zeros((0, gdim)),
        across=np.zeros((2, components)),
        centre=np.zeros(gdim),
        size=float(np.ptp(body.points, axis=0).max()),
        source=parts[0][1].name,
        groups=(
            tuple(following.name for following, *_ in parts),
            tuple(leading.name for _, leading, _ in parts),
        ),
    )
