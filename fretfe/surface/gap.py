# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gap that a case adds at the nodes of a contact: measured profiles, crowning."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.errors import CaseError
from fretfe.loads.over_surface import OverSurface
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.placed import nearest, require_arc

# Part of the range of a gap by which elements may miss it.
LARGEST_MISS = 0.05


def gap_at_nodes(given: OverSurface, surface: ContactSurface) -> Array:
    """(N,) gap at the nodes of a surface.

    Raises:
        CaseError: it is not given all over the surface.
    """
    try:
        return _at_nodes(given, surface)
    except CaseError as error:
        raise CaseError(f"{given.key}: {error}") from None


def _at_nodes(given: OverSurface, surface: ContactSurface) -> Array:
    if given.arc is not None:
        require_arc(given.arc, surface)
        return _along(given.arc, given.values[:, 0], surface.arc)
    assert given.points is not None
    nearest(given.points, surface)
    dimension = surface.points.shape[1]
    if (surface.frames[:, 0, :dimension] @ surface.mean_normal).min() < 0.5:
        expected = "a gap over a surface that turns by less than 60 degrees from its mean"
        raise CaseError(f"expected {expected}, found one that turns farther: divide the contact")
    places = _flat(given.points, surface), _flat(surface.points, surface)
    return _over(places[0], given.values[:, 0], places[1])


def gap_missed(given: OverSurface, surface: ContactSurface, counted: Bools | None = None) -> float:
    """Largest distance of a gap from straight lines between the nodes, over its range.

    Args:
        given: the gap.
        surface: of the contact.
        counted: (N,) nodes next to which it counts; None for all.
    """
    nodes, scale = gap_at_nodes(given, surface), float(np.ptp(given.values))
    if not scale:
        return 0.0
    if given.arc is not None:
        next_to = surface.nodes_at(given.arc)
        found = np.interp(given.arc, surface.arc, nodes)
        away = np.abs(given.arc - surface.arc[next_to])
    else:
        assert given.points is not None
        away, next_to = surface.tree.query(given.points)
        found = _over(_flat(surface.points, surface), nodes, _flat(given.points, surface))
    sizes = surface.weights ** (1 / (surface.points.shape[1] - 1))
    near = away <= sizes[next_to]
    if counted is not None:
        near &= counted[next_to]
    return float(np.abs(found - given.values[:, 0])[near].max(initial=0.0)) / scale


def _flat(points: Array, surface: ContactSurface) -> Array:
    """(n, d - 1) places (n, d) along the mean tangents of a surface."""
    return np.asarray(points @ np.linalg.svd(surface.mean_normal[None])[2][1:].T)


def _along(places: Array, values: Array, wanted: Array) -> Array:
    """(m,) values at arc lengths (m,), smooth between some without leaving their range by much."""
    # Imported where it is needed: SciPy's interpolation takes a second.
    from scipy.interpolate import Akima1DInterpolator

    within = np.clip(wanted, places[0], places[-1])
    if len(places) < 4:  # too few for a curve
        return np.interp(within, places, values)
    return np.asarray(Akima1DInterpolator(places, values)(within))


def _over(places: Array, values: Array, wanted: Array) -> Array:
    """(m,) values at places (m, d - 1) by a paraboloid and a thin plate through others.

    Raises:
        CaseError: those around a place do not tell a paraboloid.
    """
    from scipy.interpolate import RBFInterpolator

    if places.shape[1] == 1:
        order = np.argsort(places[:, 0])
        return _along(places[order, 0], values[order], wanted[:, 0])
    # Through all points at once, of more than a few thousand through those around each place.
    around = None if len(places) <= 2000 else 200
    try:
        return np.asarray(RBFInterpolator(places, values, neighbors=around, degree=2)(wanted))
    except (np.linalg.LinAlgError, ValueError):
        expected = "six points or more, on three lines or more, each another one"
        raise CaseError(f"expected {expected}, found others around a node") from None
