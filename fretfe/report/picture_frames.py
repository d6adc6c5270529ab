# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels with axes and a colour bar, exactly as many pixels large as the images in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image as Pillow

from fretfe._typing import Array

Pixels = npt.NDArray[np.uint8]

STYLE: Any = {"font.size": 9, "axes.linewidth": 0.6, "axes.formatter.useoffset": False}
DPI = 150
# Panels that are this part of the largest ones will do.
SLIGHTLY = 0.9
# Tones of a colour map and of grey in a file: finer ones are not seen, and it is much smaller.
TONES, GREYS = 216, 40

# Inches: the whole picture, and what is around and between its panels.
WIDTH, HIGHEST = 10.4, 8.4
LEFT, RIGHT, GAP, HEADING, TITLE, BELOW = 0.75, 0.3, 0.8, 0.35, 0.42, 0.48
BAR_GAP, BAR_WIDTH, BAR_TEXT = 0.25, 0.16, 0.6


@dataclass(frozen=True)
class Grid:
    """Equal panels in rows, read like a text.

    Attributes:
        columns: number of them.
        rows: number of them.
        panel: width and height of a panel in pixels.
        bar: whether there is a colour bar on the right.
    """

    columns: int
    rows: int
    panel: tuple[int, int]
    bar: bool = False

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture in pixels."""
        right = RIGHT + (BAR_GAP + BAR_WIDTH + BAR_TEXT if self.bar else 0.0)
        width = round((LEFT + right + (self.columns - 1) * GAP) * DPI)
        height = round((HEADING + self.rows * (TITLE + BELOW)) * DPI)
        return width + self.columns * self.panel[0], height + self.rows * self.panel[1]

    def corner(self, number: int) -> tuple[int, int]:
        """Left and lower end of a panel in pixels."""
        row, column = divmod(number, self.columns)
        top = round(HEADING * DPI) + row * (self.panel[1] + round((TITLE + BELOW) * DPI))
        left = round(LEFT * DPI) + column * (self.panel[0] + round(GAP * DPI))
        return left, self.size[1] - top - round(TITLE * DPI) - self.panel[1]


def largest_grid(
    count: int,
    aspect: float,
    *,
    bar: bool = False,
    only: int | None = None,
    most: float = WIDTH,
) -> Grid:
    """The grid for some panels of an aspect in which these are largest.

    Args:
        count: number of panels.
        aspect: height of a panel over its width.
        bar: whether there is a colour bar.
        only: the number of columns, if there is no choice.
        most: width of the picture in inches.
    """
    grids = []
    for columns in range(1, count + 1) if only is None else (only,):
        rows = -(-count // columns)
        around = LEFT + RIGHT + (BAR_GAP + BAR_WIDTH + BAR_TEXT if bar else 0.0)
        width = (most - around - (columns - 1) * GAP) / columns
        height = (HIGHEST - HEADING) / rows - TITLE - BELOW
        width = min(width, height / aspect)
        grids.append(Grid(columns, rows, (round(width * DPI), round(width * aspect * DPI)), bar))
    largest = max(grid.panel[0] for grid in grids)
    # A low picture is better than a slightly larger panel.
    good = [grid for grid in grids if grid.panel[0] > SLIGHTLY * largest]
    return min(good, key=lambda grid: grid.size[1])


def panels(grid: Grid, count: int, heading: str) -> tuple[Figure, list[Axes]]:
    """A picture with empty panels."""
    width, height = grid.size
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
    FigureCanvasAgg(figure)
    left, top = round(LEFT * DPI) / width, 1 - 0.1 * DPI / height
    figure.text(left, top, heading, fontsize=11, ha="left", va="top")
    return figure, [_panel(figure, grid, number) for number in range(count)]


def _panel(figure: Figure, grid: Grid, number: int) -> Axes:
    (width, height), (left, low) = grid.size, grid.corner(number)
    box = (left / width, low / height, grid.panel[0] / width, grid.panel[1] / height)
    axes = figure.add_axes(box)
    axes.xaxis.set_major_locator(MaxNLocator(5, min_n_ticks=2))
    axes.yaxis.set_major_locator(MaxNLocator(6, min_n_ticks=2))
    axes.tick_params(length=2.5, width=0.6, labelsize=8)
    return axes


def name_axes(axes: Axes, x: str, y: str, unit: str) -> None:
    """Names and unit of both axes."""
    axes.set_xlabel(f"{x} [{unit}]", labelpad=2)
    axes.set_ylabel(f"{y} [{unit}]", labelpad=2)


def set_title(axes: Axes, title: str, remark: str) -> None:
    """What a panel shows, in two lines."""
    axes.set_title(f"{title}\n{remark}", loc="left", fontsize=9, linespacing=1.2, pad=4)


def set_limits(axes: Axes, centre: Array, half_size: Array) -> None:
    """What a panel shows: the middle (2,) and half the size (2,)."""
    axes.set_xlim(centre[0] - half_size[0], centre[0] + half_size[0])
    axes.set_ylim(centre[1] - half_size[1], centre[1] + half_size[1])


def show_image(axes: Axes, image: Pixels) -> None:
    """An image (height, width, 3) that fills the panel, whose limits stay."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    axes.imshow(image, extent=(left, right, low, high), interpolation="nearest", aspect="auto")


def draw_lines(axes: Axes, lines: Sequence[Array], **style: Any) -> None:
    """Lines (n, k, 2), several arrays of them."""
    for each in lines:
        axes.add_collection(LineCollection(list(each), **style), autolim=False)


def draw_bar(figure: Figure, grid: Grid, colours: str, limit: float, label: str) -> None:
    """The colour bar of all panels; colours end where stresses may go on."""
    width, height = grid.size
    low, high = grid.corner(grid.columns * grid.rows - 1)[1], grid.corner(0)[1] + grid.panel[1]
    left = width - round((RIGHT + BAR_TEXT + BAR_WIDTH) * DPI)
    # At most as high as it is useful.
    low = max(low, high - round(4.5 * DPI))
    box = (left / width, low / height, BAR_WIDTH * DPI / width, (high - low) / height)
    bar = Colorbar(
        figure.add_axes(box),
        ScalarMappable(Normalize(0.0, limit), colours),
        extend="max",
        label=label,
    )
    bar.ax.tick_params(length=2.5, width=0.6, labelsize=8)


def save_png(figure: Figure, path: Path, colours: str | None = None) -> tuple[int, int]:
    """Write a picture as a small file.

    Args:
        figure: the picture.
        path: file to write.
        colours: the colour map that it has besides greys; None for any colours.

    Returns:
        Its width and height in pixels.
    """
    image = pixels(figure, colours)
    image.save(path, optimize=True)
    return image.size


def pixels(figure: Figure, colours: str | None = None) -> Pillow.Image:
    """A picture as an image; arguments as for `save_png`."""
    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
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
