# SPDX-License-Identifier: LGPL-3.0-or-later
"""One look for all figures and pictures: colours, fonts, line styles and sizes.

Colours are those of Okabe and Ito, which stay apart for colour-blind readers. Lines that mean
different things differ in their style too, for print in grey.
"""

from __future__ import annotations

from typing import Any

from matplotlib.patheffects import withStroke

BLUE, VERMILLION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
SKY, PURPLE, GREY, PALE = "#56B4E9", "#CC79A7", "#555555", "#E4E4E4"
# Of lines of equal rank; with more of them the colours begin again, with other markers.
CYCLE, MARKERS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY), "os^Dv"
# Perceptually uniform, and in order for colour-blind readers and in grey.
COLOURS = "viridis"
# Tints of bodies, which stay apart in grey; with more bodies they begin again.
TINTS = ("#CFE3F1", "#FBF0D9", "#DDDDDD")
# Lines of bodies and elements, as arguments of a LineCollection.
OUTLINE: dict[str, Any] = {"colors": "#202020", "linewidths": 0.7}
UNDEFORMED: dict[str, Any] = {"colors": "#808080", "linewidths": 0.6, "linestyles": "dotted"}
ELEMENTS: dict[str, Any] = {"colors": "#8A8A8A", "linewidths": 0.35}
# Dark and solid under light and dashed, so that both surfaces of a contact are seen in grey too.
SURFACES: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "linewidth": 3.4, "linestyle": "-"},
    {"color": ORANGE, "linewidth": 1.7, "linestyle": (0, (3.0, 1.5))},
)
BOUNDARY: dict[str, Any] = {"color": "#202020", "linewidth": 1.4, "linestyle": (0, (1.0, 1.0))}
# Light around dark lines and texts: they are seen on every colour.
HALO: Any = [withStroke(linewidth=2.4, foreground="white")]

# Inches. A plot of the page, of which two stand side by side (96 pixels an inch), and a picture.
WIDTH, PICTURE_WIDTH, PICTURE_HEIGHT = 5.6, 10.4, 8.4
# Of an animation: its width in inches, and how long a cycle takes in milliseconds.
FRAME_WIDTH, DURATION = 6.4, 4000
# Height of a plot with little in it, of one panel, of each load, of two and of three panels.
LOW, SINGLE, LOAD, DOUBLE, TRIPLE = 2.8, 3.6, 1.5, 5.4, 7.0
# Dots per inch of maps within plots, of pictures, and of figures that are files of their own.
MAP_DPI, PICTURE_DPI, FILE_DPI = 200, 150, 150
# Points: headings, and texts that come second.
HEADING, SMALL = 11.0, 8.5

STYLE: Any = {
    "font.size": 9.5,
    "font.family": "DejaVu Sans",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.titlesize": 9.5,
    "axes.formatter.useoffset": False,
    "figure.titlesize": HEADING,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
    "legend.fontsize": SMALL,
    "legend.columnspacing": 1.2,
    "legend.handlelength": 2.2,
    "lines.linewidth": 1.4,
    # Names and units are a user's: a dollar sign in them starts no formula.
    "text.parse_math": False,
    # Text as outlines: looks the same everywhere, whatever fonts there are.
    "svg.fonttype": "path",
    "svg.image_inline": True,
}
# Around maps and images of bodies: a frame, and small ticks.
FRAMED: Any = {
    **STYLE,
    "figure.constrained_layout.h_pad": 0.08,
    "figure.constrained_layout.w_pad": 0.08,
    "font.size": 9.0,
    "axes.spines.top": True,
    "axes.spines.right": True,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.titlepad": 4.0,
    "axes.labelpad": 2.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": 9.0,
    "legend.handlelength": 3.5,
}
