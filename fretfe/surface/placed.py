# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers given along the arc of a surface, or at points, at the nodes of a contact."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case.base import AXES
from fretfe.errors import CaseError
from fretfe.loads.friction import BEYOND
from fretfe.loads.over_surface import OverSurface
from fretfe.mesh.mesh import place_text
from fretfe.surface.contact_surface import ContactSurface

# Points may be as far from the nodes as the surfaces are from one another, over their extent.
NEXT_TO = 0.02


def on_arc(places: Array, values: Array, surface: ContactSurface) -> Array:
    """(N,) values at the nodes of a plane contact, straight lines between those at arc lengths.

    Raises:
        CaseError: as for `require_arc`.
    """
    require_arc(places, surface)
    return np.interp(surface.arc, places, values)


def require_arc(places: Array, surface: ContactSurface) -> None:
    """Check that arc lengths reach over the whole surface.

    Raises:
        CaseError: they do not, or it is a surface of solids.
    """
    if surface.points.shape[1] == 3:
        raise CaseError("expected places x, y and z on a surface of solids, found arc lengths")
    arc = surface.arc
    slack = BEYOND * float(np.ptp(arc))
    if places[0] > arc[0] + slack or places[-1] < arc[-1] - slack:
        raise CaseError(
            f"expected values over the whole surface, arc lengths {arc[0]:.6g} to "
            f"{arc[-1]:.6g}, found them from {places[0]:g} to {places[-1]:g}"
        )


def nearest(points: Array, surface: ContactSurface) -> Indices:
    """(N,) number of the point nearest to each node, none farther than points are apart.

    Raises:
        CaseError: the surface has other coordinates, or nodes without points near them.
    """
    # Imported where it is needed: reports of plane contacts do without SciPy.
    from scipy.spatial import cKDTree

    dimension = surface.points.shape[1]
    if points.shape[1] != dimension:
        raise CaseError(
            f"expected the columns {', '.join(AXES[:dimension])}, found "
            f"{', '.join(AXES[: points.shape[1]])}"
        )
    tree = cKDTree(points)
    away, found = tree.query(surface.points)
    gaps = tree.query(points, k=2)[0][:, 1]
    farthest, apart = int(np.argmax(away)), float(gaps[np.isfinite(gaps)].max(initial=0.0))
    extent = float(np.linalg.norm(np.ptp(surface.points, axis=0)))
    if away[farthest] > max(apart, NEXT_TO * extent):
        raise CaseError(
            "expected points over the whole surface, found none nearer to "
            f"{place_text(surface.points[farthest])} than {away[farthest]:.3g}, where points are "
            f"up to {apart:.3g} apart"
        )
    return np.asarray(found)


def layer_at_nodes(given: OverSurface, surface: ContactSurface) -> Array:
    """(N, 2) compliances of a layer at the nodes of a surface: between arc lengths, of near points.

    Raises:
        CaseError: they are not given all over the surface.
    """
    try:
        if given.arc is not None:
            parts = [on_arc(given.arc, each, surface) for each in given.values.T]
            return np.column_stack(parts)
        assert given.points is not None
        return np.asarray(given.values[nearest(given.points, surface)])
    except CaseError as error:
        raise CaseError(f"{given.key}: {error}") from None
