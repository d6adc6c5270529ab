# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write the tables of docs/templates.md and the pictures of the templates (needs gmsh).

Run from anywhere: .venv/bin/python tools/template_docs.py
"""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from fretfe._typing import Indices
from fretfe.cli.lists import parameter_rows
from fretfe.mesh.elements import directed_facets, exterior_facets
from fretfe.mesh.make import mesh_template
from fretfe.mesh.mesh import BodyMesh
from fretfe.mesh.templates import Template, find_template, template_names

DOCS = Path(__file__).parents[1] / "docs"
PAGE = DOCS / "templates.md"
# What stands between the two marks of a template is written by this script.
_TABLE = re.compile(r"(<!-- parameters of (\w+) -->\n).*?(<!-- end -->\n)", re.DOTALL)


def with_tables(page: str) -> str:
    """The page with all tables as the templates have them."""
    return _TABLE.sub(
        lambda match: match[1] + parameter_rows(find_template(match[2])) + match[3], page
    )


def draw(template: Template, path: Path) -> None:
    """The bodies of the meshed template with the names of their boundaries, contacts in red."""
    mesh = mesh_template(template, {}, 2)
    bodies = list(mesh.bodies.values())
    if mesh.dimension == 3:
        draw_solid(bodies, path)
        return
    points = np.vstack([body.points for body in bodies])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = 5.0 / max(high - low)
    figure, axes = plt.subplots(figsize=(scale * (high - low)[0] + 3.4, scale * (high - low)[1]))
    places: dict[tuple[float, float], list[str]] = {}
    for body, colour in zip(bodies, ("#c9dcee", "#f0dfc0"), strict=True):
        corners = body.points[body.cells[:, :3]]
        axes.add_collection(PolyCollection(list(corners), facecolors=colour, edgecolors=colour))
        outline, _ = exterior_facets(directed_facets(body.cells, body.cell, body.order), "line")
        lines = list(body.points[outline[:, [0, 2, 1]]])
        axes.add_collection(LineCollection(lines, colors="0.4", linewidths=0.6))
        for name, facets in body.boundaries.items():
            touching = "contact" in name or "flank" in name
            lines = list(body.points[facets[:, [0, 2, 1]]])
            colour = "#b01030" if touching else "black"
            axes.add_collection(LineCollection(lines, colors=colour, linewidths=2))
            # one label for surfaces that lie on each other
            ends = body.points[facets[:, :2]].reshape(-1, 2)
            x, y = ends.mean(axis=0).round(0)
            if not touching:
                # beside the lower part of a wall, where no contact has its label
                x, y = ends[:, 0].mean().round(6), ends[:, 1].min() + 0.2 * np.ptp(ends[:, 1])
            places.setdefault((float(x), float(y)), []).append(name)
        on_axis = body.points[np.abs(body.points[:, 0]) < 1e-9, 1]
        axes.text(0, (on_axis.min() + on_axis.max()) / 2, body.name, ha="center", weight="bold")
    _label(axes, places, float(low[0]), float(high[0]))
    axes.set(xlim=1.02 * np.array([low[0], high[0]]), ylim=(low[1], high[1]), aspect="equal")
    axes.axis("off")
    figure.savefig(path, dpi=90, bbox_inches="tight")
    plt.close(figure)


def draw_solid(bodies: list[BodyMesh], path: Path) -> None:
    """The outsides of the upper and the lower body, moved apart; the lower contact in red."""
    figure = plt.figure(figsize=(7, 7))
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    upper, lower = bodies
    apart = 0.4 * np.ptp(lower.points[:, 0])
    layers = [
        (lower, _outside(lower), 0.0, "#f0dfc0", 0.2),
        (lower, lower.boundaries["lower_contact"], 0.0, "#b01030", 0.0),
        (upper, _outside(upper), apart, "#c9dcee", 0.2),
    ]
    for place, (body, facets, shift, fill, width) in enumerate(layers):
        # x to the right, y upwards, z to the viewer
        corners = (body.points[facets[:, :3]] + [0, shift, 0])[:, :, [0, 2, 1]] * [1, -1, 1]
        collection = Poly3DCollection(
            corners, facecolors=fill, edgecolors="0.4", linewidths=width, zorder=place
        )
        axes.add_collection3d(collection)
    extent = np.ptp(np.vstack([body.points for body in bodies]), axis=0)
    axes.set(xlim=_around(extent[0]), ylim=_around(extent[2]))
    axes.set(zlim=(lower.points[:, 1].min(), upper.points[:, 1].max() + apart))
    axes.set_box_aspect((extent[0], extent[2], extent[1] + apart))
    axes.view_init(elev=24, azim=-60)
    axes.axis("off")
    figure.savefig(path, dpi=90, bbox_inches="tight")
    plt.close(figure)


def _outside(body: BodyMesh) -> Indices:
    return exterior_facets(directed_facets(body.cells, body.cell, body.order), "triangle")[0]


def _around(extent: float) -> tuple[float, float]:
    return -extent / 2, extent / 2


def _label(
    axes: Axes, places: dict[tuple[float, float], list[str]], left: float, right: float
) -> None:
    """Names beside the bodies, each with a line to its boundary."""
    for (x, y), names in places.items():
        side = left - 0.1 * right if x < 0 else right + 0.1 * right
        axes.annotate(
            "\n".join(names),
            (x, y),
            (side, y),
            ha="right" if x < 0 else "left",
            va="center",
            fontsize=8,
            arrowprops={"arrowstyle": "-", "linewidth": 0.5},
            annotation_clip=False,
        )


def main() -> None:
    """Write tables and pictures."""
    PAGE.write_text(with_tables(PAGE.read_text("utf-8")), "utf-8")
    for name in template_names():
        draw(find_template(name), DOCS / "images" / f"template_{name}.png")


if __name__ == "__main__":
    main()
