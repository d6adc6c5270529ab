# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane contacts of which the model has a half: the whole contact, mirrored at a plane of symmetry.

Fits see the pressure on both sides of the middle, as of a model of the whole bodies; the edge at
the end that is only an image is none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.plane.section import PLANE_FRONTS, PlaneFront
from fretfe.history.solution import ContactHistory
from fretfe.history.state_array import StateArray, blocks
from fretfe.reason import Kind, Reason

# Of a station where there is none.
NO_EDGE = Reason(
    Kind.NO_EDGE, words="both bodies go on behind this end of the surface: there is no edge"
)


@dataclass(frozen=True)
class WholeContact:
    """A contact as it is in the whole bodies.

    Attributes:
        contact: with the image of its nodes beside them; as it was without a plane of symmetry, or
            where it goes on at both ends.
        images: the fronts at which it goes on. Where both are, as of a ring on a shaft, there are
            no edges.
    """

    contact: ContactHistory
    images: tuple[PlaneFront, ...] = ()

    @property
    def endless(self) -> bool:
        """True if the contact goes on at both ends."""
        return len(self.images) == len(PLANE_FRONTS)


def whole_contact(contact: ContactHistory) -> WholeContact:
    """Mirror a plane contact at the plane of symmetry that it reaches at one of its ends.

    Only where it does so in all states in which it carries anything, and at one end alone.
    Contacts that always reach both ends, of planes of symmetry or of sides of a sector, have
    no edges.
    """
    if contact.surface.continued is None or contact.node_range is not None:
        return WholeContact(contact)
    ends = [front for front in PLANE_FRONTS if _always_reaches(contact, front)]
    normals = [contact.surface.continued[_end(front)] for front in ends]
    if len(ends) == len(PLANE_FRONTS):
        return WholeContact(contact, PLANE_FRONTS)
    if not ends or not normals[0].any():
        return WholeContact(contact)
    return WholeContact(_mirrored(contact, ends[0], normals[0]), (ends[0],))


def reaches_image(contact: ContactHistory, front: PlaneFront) -> bool:
    """True if the bodies go on behind the end of the surface at a front."""
    continued = contact.surface.continued
    return continued is not None and bool(np.isfinite(continued[_end(front)]).all())


def _end(front: PlaneFront) -> int:
    """Number of the last node of the surface outward from a front."""
    return 0 if front.inward > 0 else -1


def _always_reaches(contact: ContactHistory, front: PlaneFront) -> bool:
    """True if the bodies go on behind an end at which the contact is closed whenever it carries."""
    if not reaches_image(contact, front):
        return False
    pressed = False
    for states in blocks(len(contact.traction), contact.traction[0].size):
        nodes = contact.traction[states, :, 0] > 0
        pressed |= bool(nodes.any())
        if np.any(nodes.any(axis=1) & ~nodes[:, _end(front)]):
            return False
    return pressed


def _mirrored(contact: ContactHistory, front: PlaneFront, normal: Array) -> ContactHistory:
    """A contact with its image behind the end at a front, in the order along the arc."""
    count = len(contact.surface.arc)
    own = np.arange(count)
    beyond = own[:0:-1] if front.inward > 0 else own[-2::-1]
    images, there = np.ones(count - 1, dtype=bool), np.zeros(count, dtype=bool)
    if front.inward > 0:
        nodes, image = np.append(beyond, own), np.append(images, there)
    else:
        nodes, image = np.append(own, beyond), np.append(there, images)
    middle = int(own[_end(front)])
    shape = _Image(nodes, image, nodes == middle)
    surface = contact.surface
    away = surface.points - surface.points[middle]
    reflected = surface.points - 2 * (away @ normal)[:, None] * normal
    frames = surface.frames.copy()
    frames[..., : len(normal)] -= 2 * (frames[..., : len(normal)] @ normal)[..., None] * normal
    # The tangent goes on in the direction of the arc.
    frames[:, 1] *= -1
    units, nearby = contact.full_stick, contact.nearby_loads
    return replace(
        contact,
        surface=replace(
            surface,
            arc=np.where(image, 2 * surface.arc[middle] - surface.arc[nodes], surface.arc[nodes]),
            points=np.where(image[:, None], reflected[nodes], surface.points[nodes]),
            frames=np.where(image[:, None, None], frames[nodes], surface.frames[nodes]),
            weights=surface.weights[nodes] * np.where(shape.middle, 2.0, 1.0),
            continued=None,
            added_gap=None if surface.added_gap is None else surface.added_gap[nodes],
        ),
        friction=contact.friction.of_nodes(nodes),
        traction=shape.vectors(contact.traction, first=1),
        mean_traction=shape.vectors(contact.mean_traction, first=1),
        slip=shape.vectors(contact.slip, first=0),
        gap=shape.scalars(contact.gap),
        beside=None if contact.beside is None else shape.scalars(contact.beside),
        status=shape.scalars(contact.status),
        dissipation=shape.scalars(contact.dissipation, twice=True),
        full_stick=replace(units, fields=shape.vectors(units.fields, first=1)),
        nearby_loads=nearby and replace(nearby, pressure=nearby.pressure[:, nodes]),
    )


@dataclass(frozen=True)
class _Image:
    """Nodes of the whole contact.

    Attributes:
        nodes: (M,) numbers among those of the half.
        image: (M,) whether they are images.
        middle: (M,) whether they are in the plane of symmetry.
    """

    nodes: Indices
    image: Bools
    middle: Bools

    def scalars(self, values: StateArray | Any, *, twice: bool = False) -> StateArray:
        """Values (T, N) at the nodes; twice as large in the middle if they are sums."""
        factor = np.where(self.middle & twice, 2, 1).astype(values.dtype)
        shape = (values.shape[0], len(self.nodes))
        return StateArray(shape, values.dtype, lambda each: values[each][:, self.nodes] * factor)

    def vectors(self, values: StateArray | Any, first: int) -> StateArray:
        """Components (T, N, d, ...) of which that along the arc, the `first`, is odd."""
        sign = np.where(self.image, -1.0, np.where(self.middle, 0.0, 1.0))

        def read(states: Indices) -> Any:
            found = values[states][:, self.nodes].copy()
            found[:, :, first] *= sign.reshape(-1, *[1] * (found.ndim - 3))
            return found

        shape = (values.shape[0], len(self.nodes), *values.shape[2:])
        return StateArray(shape, values.dtype, read)
