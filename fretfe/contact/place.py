# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contacts that a record is about: their bodies and multiplier nodes."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fretfe._typing import Array, Indices


class Averaging(Protocol):
    """A linear map of nodal values, such as a sparse matrix."""

    def __matmul__(self, values: Array) -> Array:
        """Return the mapped values."""


class Nodes(Protocol):
    """The multiplier nodes of a contact; see `ContactHistory` for arrays of the same name."""

    @property
    def arc(self) -> Array:
        """(N,) arc length."""

    @property
    def points(self) -> Array:
        """(N, d) coordinates."""

    @property
    def frames(self) -> Array:
        """(N, d, d) normal and tangents."""

    @property
    def weights(self) -> Array:
        """(N,) length of each node."""

    @property
    def averaging(self) -> Averaging:
        """(N, N) from nodal values to means around the nodes."""


@dataclass(frozen=True)
class Place:
    """One contact: its name, its bodies and its nodes; of solids the facets between them."""

    name: str
    body1: str
    body2: str
    nodes: Nodes
    facets: Indices | None = None


def digest_of(places: Sequence[Place]) -> str:
    """Text that is equal for the same contacts with the same nodes."""
    found = hashlib.sha256()
    for place in places:
        found.update(
            repr((place.name, place.body1, place.body2, place.nodes.points.shape)).encode()
        )
        for values in (place.nodes.points, place.nodes.weights, place.facets):
            found.update(b"" if values is None else np.ascontiguousarray(values).tobytes())
    return found.hexdigest()
