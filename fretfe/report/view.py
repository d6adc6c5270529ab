# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rectangles of the plane to look at, turned as needed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fretfe._typing import Array, Bools


@dataclass(frozen=True)
class View:
    """A rectangle to look at.

    Attributes:
        centre: (2,) its middle.
        half_size: (2,) half its width and height.
        normal: (2,) unit vector that points up in the picture.
        origin: (2,) what the axes of the picture say in the middle.
    """

    centre: Array
    half_size: Array
    normal: Array
    origin: Array = field(default_factory=lambda: np.zeros(2))

    @property
    def tangent(self) -> Array:
        """(2,) unit vector that points to the right."""
        return np.array([self.normal[1], -self.normal[0]])

    def local(self, points: Array) -> Array:
        """Places (..., 2) in the picture, along its axes."""
        turned = (points - self.centre) @ np.stack([self.tangent, self.normal], axis=1)
        return turned + self.origin

    def overlaps(self, shapes: Array) -> Bools:
        """Whether the boxes around shapes (m, k, 2) reach into the rectangle."""
        local = self.local(shapes) - self.origin
        low, high = local.min(axis=1), local.max(axis=1)
        return ((low < self.half_size) & (high > -self.half_size)).all(axis=1)


def view_of_box(low: Array, high: Array) -> View:
    """The upright view of a box with these corners (2,)."""
    centre = (low + high) / 2
    return View(centre, (high - low) / 2, np.array([0.0, 1.0]), centre)
