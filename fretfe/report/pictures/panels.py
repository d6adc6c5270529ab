# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels that show a part of the plane, laid out by Matplotlib and set to whole pixels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from fretfe._typing import Array, Bools
from fretfe.files import replacing
from fretfe.report.plotting import (
    Axes,
    Bbox,
    ConstrainedLayoutEngine,
    Figure,
    FigureCanvasAgg,
    MaxNLocator,
    Outline,
    PathCollection,
    colormaps,
    mpl,
)
from fretfe.report.theme import PICTURE_DPI, PICTURE_HEIGHT, PICTURE_WIDTH

Pixels = npt.NDArray[np.uint8]

# Panels that are this part of the largest ones will do.
SLIGHTLY = 0.9
# Inches that the texts around a panel take, roughly: enough to choose the number of columns.
TEXTS = 0.7
# Layouts until a picture has its size: colour bars change a little with it.
PASSES = 3
# Height of a colour bar over its width.
BAR_ASPECT = 28
# Tones of a colour map and of grey in a file: finer ones are not seen, and it is much smaller.
TONES = 216
GREYS = 40


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

    @property
    def aspect(self) -> float:
        """Height over width."""
        return float(self.half_size[1] / self.half_size[0])

    def local(self, points: Array) -> Array:
        """Places (..., 2) in the picture, along its axes."""
        turned = (points - self.centre) @ np.stack([self.tangent, self.normal], axis=1)
        return turned + self.origin

    def overlaps(self, shapes: Array) -> Bools:
        """Find shapes (m, k, 2) whose boxes reach into the rectangle."""
        local = self.local(shapes) - self.origin
        low, high = local.min(axis=1), local.max(axis=1)
        return ((low < self.half_size) & (high > -self.half_size)).all(axis=1)


@dataclass(frozen=True)
class SpaceView:
    """A view of solids.

    Attributes:
        centre: (3,) what is in the middle.
        viewer: (3,) unit vector towards the viewer.
        up: (3,) unit vector that points up in the picture, across `viewer`.
        half_size: (2,) half the width and height of what is seen.
        cut: (3,) unit normal of the plane through `centre` that cuts off what lies before it, or
            None.
    """

    centre: Array
    viewer: Array
    up: Array
    half_size: Array
    cut: Array | None = None

    @property
    def across(self) -> Array:
        """(2, 3) unit vectors to the right and up."""
        return np.stack([np.cross(self.up, self.viewer), self.up])

    @property
    def aspect(self) -> float:
        """Height over width."""
        return float(self.half_size[1] / self.half_size[0])


def panels(count: int, aspect: float, *, columns: int | None = None) -> tuple[Figure, list[Axes]]:
    """A picture with empty panels, read like a text.

    Args:
        count: number of panels.
        aspect: height of a panel over its width.
        columns: of panels; None for as many as make the panels large and the picture low.
    """
    columns = columns or _columns(count, aspect)
    rows = -(-count // columns)
    figure = Figure(figsize=(PICTURE_WIDTH, PICTURE_HEIGHT), dpi=PICTURE_DPI, layout="constrained")
    axes = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for each in axes:
        few_ticks(each)
    for each in axes[count:]:
        each.remove()
    return figure, axes[:count]


def _columns(count: int, aspect: float) -> int:
    """Number of columns with the largest panels; a low picture is better than slightly larger."""
    sizes = {}
    for columns in range(1, count + 1):
        height = PICTURE_HEIGHT / -(-count // columns) - TEXTS
        sizes[columns] = min(PICTURE_WIDTH / columns - TEXTS, height / aspect)
    good = [each for each, size in sizes.items() if size > SLIGHTLY * max(sizes.values())]
    return min(good, key=lambda each: -(-count // each) * (sizes[each] * aspect + TEXTS))


def few_ticks(axes: Axes) -> None:
    """Four to six ticks on each axis."""
    axes.xaxis.set_major_locator(MaxNLocator(5, min_n_ticks=2))
    axes.yaxis.set_major_locator(MaxNLocator(6, min_n_ticks=2))


def settle(figure: Figure, axes: Sequence[Axes], aspect: float, heading: str) -> None:
    """Give panels with all their texts, but no images, their places at whole pixels.

    Args:
        figure: shrunk until its panels have their aspect and no room is left over.
        axes: the panels.
        aspect: height of a panel over its width.
        heading: of the picture, above its first panel.
    """
    title = figure.suptitle(heading, ha="left")
    figure.align_labels()
    for each in axes:
        for spine in each.spines.values():
            # It ends where its panel does.
            spine.set_in_layout(False)
    grid = axes[0].get_gridspec()
    assert grid is not None
    layout = figure.get_layout_engine()
    assert isinstance(layout, ConstrainedLayoutEngine)
    for _ in range(PASSES):
        layout.execute(figure)
        _make_room(figure, axes, layout, grid.ncols)
        panel = panel_inches(axes[0])
        spare = panel - min(panel[0], panel[1] / aspect) * np.array([1.0, aspect])
        pixels = np.ceil((figure.get_size_inches() - spare * (grid.ncols, grid.nrows)) * figure.dpi)
        # A little more, or the size in inches may be rounded to a pixel less.
        figure.set_size_inches((pixels + 0.01) / figure.dpi)
    layout.execute(figure)
    figure.set_layout_engine("none")
    size = panel_pixels(axes[0])
    for each in axes:
        corner = np.round(each.get_window_extent().min)
        each.set_position(Bbox(np.array([corner, corner + size]) / figure.bbox.size))
    title.set_x(axes[0].get_position().x0)


def _make_room(
    figure: Figure, axes: Sequence[Axes], layout: ConstrainedLayoutEngine, columns: int
) -> None:
    """Put columns of panels so far apart that titles end before the next one, and the picture."""
    panels = [each.get_window_extent() for each in axes]
    boxes = [each.get_tightbbox() or panel for each, panel in zip(axes, panels, strict=True)]
    over = 0.0
    for panel, box in zip(panels, boxes, strict=True):
        next_ones = [b.x0 for p, b in zip(panels, boxes, strict=True) if p.x0 > panel.x0 + 1]
        over = max(over, box.x1 - min([*next_ones, figure.bbox.x1]))
    if over > 0:
        over = over / figure.dpi + mpl.rcParams["figure.constrained_layout.w_pad"]
        layout.set(w_pad=layout.get()["w_pad"] + over)
        figure.set_size_inches(figure.get_size_inches() + np.array([2 * columns * over, 0.0]))
        layout.execute(figure)


def panel_inches(axes: Axes) -> Array:
    """(2,) width and height of a panel in inches."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return np.array(axes.get_window_extent().size) / figure.dpi


def panel_pixels(axes: Axes) -> tuple[int, int]:
    """Width and height of a panel in pixels."""
    width, height = np.round(axes.get_window_extent().size)
    return int(width), int(height)


def name_axes(axes: Axes, x: str, y: str, unit: str) -> None:
    """Names and unit of both axes."""
    axes.set_xlabel(f"{x} [{unit}]")
    axes.set_ylabel(f"{y} [{unit}]")


def set_limits(axes: Axes, view: View | SpaceView) -> None:
    """Let a panel show a view; in space its axes begin in the middle."""
    origin = view.origin if isinstance(view, View) else np.zeros(2)
    (left, low), (right, high) = origin - view.half_size, origin + view.half_size
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)


def show_image(axes: Axes, image: Pixels) -> None:
    """An image (height, width, 3) that fills the panel, whose limits stay."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    axes.imshow(image, extent=(left, right, low, high), interpolation="nearest", aspect="auto")


def draw_lines(axes: Axes, lines: Sequence[Array], *, colors: str, **style: Any) -> None:
    """Lines (n, k, 2), several arrays of them."""
    for each in lines:
        _draw(axes, _joined(each, closed=False), facecolors="none", edgecolors=colors, **style)


def draw_cells(axes: Axes, cells: Array, colour: str) -> None:
    """Polygons (n, k, 2) that cover a part of a body, without seams between them."""
    _draw(axes, _joined(cells, closed=True), facecolors=colour, edgecolors=colour, linewidths=0.3)


def _draw(axes: Axes, paths: list[Outline], **style: Any) -> None:
    axes.add_collection(PathCollection(paths, **style), autolim=False)


def _joined(lines: Array, closed: bool) -> list[Outline]:
    """Many lines (n, k, 2) as few paths: to make one of each takes longer than to draw it."""
    if closed:
        lines = np.concatenate([lines, lines[:, :1]], axis=1)
    codes = np.full(lines.shape[1], Outline.LINETO, dtype=np.uint8)
    codes[0] = Outline.MOVETO
    if closed:
        codes[-1] = Outline.CLOSEPOLY
    # Parts that are far below what Agg takes.
    parts = np.split(lines, range(2000, len(lines), 2000))
    return [Outline(part.reshape(-1, 2), np.tile(codes, len(part))) for part in parts]


def plural(style: Mapping[str, Any]) -> dict[str, Any]:
    """The style of a line as arguments of a collection of lines."""
    return {f"{key}s": value for key, value in style.items()}


def save_png(figure: Figure, path: Path, colours: str | None = None) -> tuple[int, int]:
    """Write a picture as a small file.

    Args:
        figure: the picture.
        path: file to write.
        colours: the colour map that it has besides greys; None for any colours.

    Returns:
        Its width and height in pixels.

    Raises:
        OSError: if it cannot be written.
    """
    image = pixels(figure, colours)
    with replacing(path, path.suffix) as new:
        # Level 9 makes it a fortieth smaller, and takes four times as long.
        image.save(new, compress_level=6)
    return image.size


def pixels(figure: Figure, colours: str | None = None) -> Pillow.Image:
    """A picture as an image; arguments as for `save_png`."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    image = Pillow.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    if colours is None:
        return image
    return image.quantize(palette=_palette(colours), dither=Pillow.Dither.NONE)


def _palette(colours: str) -> Pillow.Image:
    tones = colormaps[colours](np.linspace(0.0, 1.0, TONES))[:, :3]
    greys = np.linspace(0.0, 1.0, GREYS)[:, None] * np.ones(3)
    palette = Pillow.new("P", (1, 1))
    palette.putpalette(np.round(255 * np.concatenate([tones, greys])).astype(int).ravel().tolist())
    return palette
