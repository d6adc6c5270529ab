# SPDX-License-Identifier: LGPL-3.0-or-later
"""Matplotlib without settings of a folder: all other modules take from here what they use of it."""

from __future__ import annotations

from fretfe.libraries import elsewhere

with elsewhere(home=True):
    import matplotlib as mpl
    from matplotlib import colormaps
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection, PathCollection, PolyCollection
    from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize
    from matplotlib.figure import Figure
    from matplotlib.font_manager import FontProperties
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.lines import Line2D
    from matplotlib.markers import TICKDOWN, TICKLEFT
    from matplotlib.patches import Patch
    from matplotlib.path import Path as Outline
    from matplotlib.patheffects import withStroke
    from matplotlib.textpath import text_to_path
    from matplotlib.ticker import (
        AutoLocator,
        FuncFormatter,
        LogLocator,
        MaxNLocator,
        NullFormatter,
        NullLocator,
    )
    from matplotlib.transforms import Affine2D, Bbox, ScaledTranslation
    from matplotlib.tri import Triangulation

    # It looks for its folder once.
    mpl.get_configdir()

__all__ = (
    "TICKDOWN",
    "TICKLEFT",
    "Affine2D",
    "AutoLocator",
    "Axes",
    "Axis",
    "Bbox",
    "BoundaryNorm",
    "ConstrainedLayoutEngine",
    "Figure",
    "FigureCanvasAgg",
    "FigureCanvasSVG",
    "FontProperties",
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
    "ScaledTranslation",
    "Triangulation",
    "colormaps",
    "mpl",
    "text_to_path",
    "withStroke",
)
