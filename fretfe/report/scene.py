# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coloured bodies as an image of pixels, off screen. Needs PyVista and OpenGL.

Only what VTK is best at is left to it: axes, colour bars and texts are drawn around the image, and
lines upon it, by Matplotlib.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fretfe.report.field_files import PIECES, BodyField
from fretfe.report.view import View

Image = npt.NDArray[np.uint8]

# Perceptually uniform, and in order for colour-blind readers and in grey.
COLOURS = "viridis"


class Scene:
    """Draws bodies again and again, with the same colours.

    Args:
        limit: von Mises stress of the last colour; the first one is zero.
    """

    def __init__(self, limit: float) -> None:
        from pyvista import Plotter

        plotter: Any = Plotter
        self._limit = limit
        self._plotter = plotter(off_screen=True)
        self._plotter.set_background("white")
        self._plotter.enable_parallel_projection()

    def image(
        self, bodies: Sequence[BodyField], scale: float, view: View, pixels: tuple[int, int]
    ) -> Image:
        """Bodies in their deformed shape.

        Args:
            bodies: what to draw.
            scale: of the displacements.
            view: what is seen; of the same proportions as `pixels`.
            pixels: width and height.

        Returns:
            (height, width, 3) red, green and blue.
        """
        self._add(bodies, scale, smooth=True)
        distance = 10 * float(view.half_size.max())
        camera = self._plotter.camera
        camera.focal_point = (*view.centre, 0.0)
        camera.position = (*view.centre, distance)
        camera.up = (*view.normal, 0.0)
        camera.parallel_scale = float(view.half_size[1])
        camera.clipping_range = (0.5 * distance, 2.0 * distance)
        self._plotter.window_size = pixels
        self._plotter.render()
        return np.array(self._plotter.screenshot(return_img=True)[..., :3])

    def export(self, bodies: Sequence[BodyField], scale: float, path: Path) -> None:
        """Write bodies in their deformed shape as a glTF file with colours at the nodes."""
        self._add(bodies, scale, smooth=False)
        self._plotter.export_gltf(path)

    def _add(self, bodies: Sequence[BodyField], scale: float, *, smooth: bool) -> None:
        """Have these bodies and no others; smooth: colours follow stresses between nodes."""
        self._plotter.clear_actors()
        for body in bodies:
            actor = self._plotter.add_mesh(
                surface(body, scale),
                scalars="stress",
                cmap=COLOURS,
                clim=(0.0, self._limit),
                interpolate_before_map=smooth,
                lighting=False,
                show_scalar_bar=False,
                copy_mesh=False,
            )
            # Viewers of glTF multiply the colours by this one.
            actor.prop.color = "white"

    def close(self) -> None:
        """Give the memory back."""
        self._plotter.close()


def surface(body: BodyField, scale: float) -> Any:
    """A body as linear pieces with the point data `stress`; a `pyvista.PolyData`."""
    from pyvista import PolyData

    pieces = body.cells[:, PIECES[body.cells.shape[1]]]
    faces = pieces.reshape(-1, pieces.shape[-1])
    points = np.column_stack([body.deformed(scale), np.zeros(len(body.points))])
    mesh: Any = PolyData(points, np.insert(faces, 0, faces.shape[1], axis=1).ravel())
    mesh.point_data["stress"] = body.von_mises
    return mesh
