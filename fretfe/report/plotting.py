# SPDX-License-Identifier: LGPL-3.0-or-later
"""Matplotlib without settings of a folder: all other modules take from here what they use of it."""

from __future__ import annotations

from fretfe.libraries import elsewhere

with elsewhere(home=True):
    import matplotlib as mpl
    from matplotlib import colormaps
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection, PathCollection, PolyCollection
    from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.path import Path as Outline
    from matplotlib.patheffects import withStroke
    from matplotlib.ticker import (
        AutoLocator,
        FuncFormatter,
        LogLocator,
        MaxNLocator,
        NullFormatter,
        NullLocator,
    )
    from matplotlib.transforms import Affine2D, Bbox
    from matplotlib.tri import Triangulation

    # It looks for its folder once.
    mpl.get_configdir()

__all__ = (
    "Affine2D",
    "AutoLocator",
    "Axes",
    "Bbox",
    "BoundaryNorm",
    "ConstrainedLayoutEngine",
    "Figure",
    "FigureCanvasAgg",
    "FigureCanvasSVG",
    "FuncFormatter",
    "Line2D",
    "LineCollection",
    "ListedColormap",
    "LogLocator",
    "LogNorm",
    "MaxNLocator",
    "Normalize",
    "NullFormatter",
    "NullLocator",
    "Outline",
    "Patch",
    "PathCollection",
    "PolyCollection",
    "ScalarMappable",
    "Triangulation",
    "colormaps",
    "mpl",
    "withStroke",
)
