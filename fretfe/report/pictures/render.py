# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of the stress in the bodies, drawn where OpenGL works.

`python -m fretfe.report.pictures.render DIR FILE ...` is a process of its own: where OpenGL
does not work VTK does not raise errors but ends the process. Each file is reported on standard
output, as a line of JSON, once it is written. The stress is that at the load extremes, and enlarged
at the contact edges; solids are drawn as a whole, and cut open at a contact.
"""

from __future__ import annotations

import json
import math
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.environment import memory_shortage, missing_package
from fretfe.errors import FretfeError
from fretfe.faults import said, trace_of
from fretfe.files import disk_reason
from fretfe.history.solution import OPEN
from fretfe.report.pictures.fields import BodyField, Fields, Scene, open_fields
from fretfe.report.pictures.looks import (
    BODIES_PERCENTAGE,
    EDGE_ASPECT,
    EDGES_PERCENTAGE,
    EdgePlace,
    Look,
    Wanted,
    colour_limit,
    edge_view,
    edges_left_out,
    find_look,
    plan_pictures,
    round_down,
)
from fretfe.report.pictures.panels import (
    BAR_ASPECT,
    SpaceView,
    View,
    draw_lines,
    name_axes,
    panel_pixels,
    panels,
    save_png,
    set_limits,
    settle,
    show_image,
)
from fretfe.report.plotting import Axes, Figure, Normalize, ScalarMappable, mpl
from fretfe.report.source import folder_of, loading, state_title, times_text, when
from fretfe.report.texts import direction_text, number, rounded
from fretfe.report.theme import COLOURS, ELEMENTS, FRAMED, HALO, OUTLINE, UNDEFORMED, VERMILLION
from fretfe.results.field_files import FIELDS
from fretfe.results.writer import PICTURES

ARROW: dict[str, Any] = {"arrowstyle": "->", "lw": 1.0, "path_effects": HALO}


@mpl.rc_context(FRAMED)
def draw_bodies(source: Fields, states: Sequence[int], look: Look, scene: Scene) -> Figure:
    """All bodies at some states.

    One panel each; of solids one column, as a whole above cut open.
    """
    run, units = source.run, source.run.case.units
    shown = [(view, state) for view in look.views for state in states]
    aspect = look.views[0].aspect
    columns = None if source.dimension == 2 else len(states)
    figure, axes = panels(len(shown), aspect, columns=columns)
    for panel, (view, state) in zip(axes, shown, strict=True):
        set_limits(panel, view)
        if isinstance(view, View):
            name_axes(panel, "x", "y", units.length)
            panel.set_title(f"{when(run, state)}\n{loading(run, state)}")
        else:
            panel.set_xticks([])
            panel.set_yticks([])
            panel.set_title(state_title(run, state) if view.cut is None else "")
    _add_bar(figure, axes, look.limit, units.stress)
    settle(figure, axes, aspect, f"Von Mises stress, displacements × {look.scale:g}")
    for panel, (view, state) in zip(axes, shown, strict=True):
        bodies = list(source.bodies(state).values())
        show_image(panel, scene.image(bodies, look.scale, view, panel_pixels(panel)))
        if isinstance(view, SpaceView):
            _draw_axes(panel, view)
            _draw_scale(panel, view, units.length)
            if view.cut is None:
                _name_parts(panel, source, state, look.scale, view)
        else:
            before = [body.grid.points[body.grid.outline] for body in bodies]
            draw_lines(panel, before, **UNDEFORMED)
            after = [body.deformed(look.scale)[body.grid.outline] for body in bodies]
            draw_lines(panel, after, **OUTLINE)
    return figure


def bodies_caption(source: Fields, states: Sequence[int], look: Look) -> str:
    """Caption of the picture of `draw_bodies`."""
    times = times_text(source.run, states)
    drawn = f"enlarged {look.scale:g} times" if look.scale > 1 else "in true size"
    text = f"Von Mises equivalent stress of the bodies at {times}; displacements {drawn}"
    limits = look.limit, look.largest, BODIES_PERCENTAGE
    if not look.contact:
        ends = _colour_text(source, *limits, "area shown")
        return f"{text}, dotted: before deformation. {ends}"
    cut = look.views[-1]
    assert isinstance(cut, SpaceView)
    assert cut.cut is not None
    place = ", ".join(number(float(value) + 0.0) for value in cut.centre)
    return (
        f"{text}. Red dots: nodes in contact, seen through the bodies. Below: cut open at the "
        f"contact {look.contact}, through its largest pressure at ({place}) "
        f"{source.run.case.units.length} and across {direction_text(cut.cut)}. "
        f"{_colour_text(source, *limits, 'volume around the contact')} Outer surfaces are shaded, "
        "the cut is not."
    )


@mpl.rc_context(FRAMED)
def draw_edges(source: Fields, edges: Sequence[EdgePlace]) -> tuple[Figure, str]:
    """The surroundings of some contact edges with their elements, and the caption."""
    run = source.run
    states = sorted({edge.state for edge in edges})
    contacts = {contact.name: contact for contact in run.solution.contacts}
    views = [edge_view(contacts[edge.contact], edge, source.bodies(edge.state)) for edge in edges]
    shown = [(body, view) for view, moved in views for body in moved.values()]
    limit, largest = colour_limit(shown, EDGES_PERCENTAGE)
    columns = len(states) if len(states) > 1 else None
    figure, axes = panels(len(edges), EDGE_ASPECT, columns=columns)
    unit = run.case.units.length
    for panel, edge, (view, _) in zip(axes, edges, views, strict=True):
        set_limits(panel, view)
        name_axes(panel, "from the edge along x", "along y", unit)
        slip = f"longest slip zone {rounded(edge.slip)} {unit}" if edge.slip > 0 else "no slip zone"
        slip = "slip zone unknown" if math.isnan(edge.slip) else slip
        slip = "gross slip" if edge.gross else slip
        panel.set_title(f"{edge.title}, {when(run, edge.state)}\n{slip}")
    _add_bar(figure, axes, limit, run.case.units.stress)
    settle(figure, axes, EDGE_ASPECT, "Von Mises stress at the contact edges")
    scene = Scene(limit)
    for panel, (view, moved) in zip(axes, views, strict=True):
        show_image(panel, scene.image(list(moved.values()), 1.0, view, panel_pixels(panel)))
        for body in moved.values():
            _draw_elements(panel, body, view)
    scene.close()
    missing = edges_left_out(run)
    why = "contacts without both edges found at a load extreme"
    left_out = f" Left out ({why}): {'; '.join(missing)}." if missing else ""
    return figure, (
        f"Von Mises equivalent stress and elements around the contact edges at "
        f"{times_text(run, states)}, displacements in true size. Each panel is turned into the "
        "frame of its contact, with body 2 below; its origin is the edge, on both bodies, so "
        "neither sliding of a whole body along x nor an interference is visible. "
        f"{_colour_text(source, limit, largest, EDGES_PERCENTAGE, 'area shown, panels alike')}"
        f"{left_out}"
    )


def _draw_elements(panel: Axes, body: BodyField, view: View) -> None:
    """Outlines of the elements that are seen, and of the body."""
    places = body.deformed(1.0)
    points = view.local(places)
    for edges, style in ((body.grid.edges, ELEMENTS), (body.grid.outline, OUTLINE)):
        draw_lines(panel, [points[edges[view.overlaps(places[edges])]]], **style)


def _colour_text(
    source: Fields, limit: float, largest: float, percentage: float, where: str
) -> str:
    unit = source.run.case.units.stress
    if largest <= limit:
        return f"The largest stress is {rounded(largest)} {unit}."
    return (
        f"Colours end at {rounded(limit)} {unit}, which is not exceeded in {percentage:g} % of the "
        f"{where}; the largest value in an element is {rounded(largest)} {unit}."
    )


def _add_bar(figure: Figure, axes: Sequence[Axes], limit: float, unit: str) -> None:
    """The colour bar of all panels; colours end where stresses may go on."""
    colours = ScalarMappable(Normalize(0.0, limit), COLOURS)
    bar = figure.colorbar(colours, ax=axes, extend="max", aspect=BAR_ASPECT, pad=0.02)
    bar.set_label(f"von Mises stress [{unit}]", labelpad=6)


def _draw_axes(panel: Axes, view: SpaceView) -> None:
    """The axes of the case as arrows in a corner of a panel."""
    pixels = 0.07 * panel.get_window_extent().width
    origin = np.array([0.1, 0.1 / view.aspect])
    scale = pixels / np.array(panel.get_window_extent().size)
    for name, axis in zip("xyz", np.eye(3), strict=True):
        seen = view.across @ axis
        if np.linalg.norm(seen) < 0.1:
            continue
        x, y = origin + seen * scale
        panel.annotate(
            "", xy=(x, y), xytext=(origin[0], origin[1]), xycoords="axes fraction",
            textcoords="axes fraction", arrowprops=ARROW,
        )  # fmt: skip
        x, y = origin + seen * scale * (1 + 0.22 / np.linalg.norm(seen))
        panel.text(
            x, y, name, transform=panel.transAxes, ha="center", va="center", path_effects=HALO
        )


def _draw_scale(panel: Axes, view: SpaceView, unit: str) -> None:
    """A bar of round length in a lower corner of a panel."""
    half_width, half_height = view.half_size
    length = round_down(0.5 * float(half_width))
    right, low = 0.94 * half_width, -0.92 * half_height
    panel.plot(
        [right - length, right], [low, low], color="black", lw=2.0, path_effects=HALO,
        solid_capstyle="butt",
    )  # fmt: skip
    panel.annotate(
        f"{length:g} {unit}", (right - length / 2, low), (0.0, 3.0), textcoords="offset points",
        ha="center", va="bottom", path_effects=HALO,
    )  # fmt: skip


def _name_parts(panel: Axes, source: Fields, state: int, scale: float, view: SpaceView) -> None:
    """Mark the nodes in contact, which bodies may hide, and write the names of the bodies."""
    for contact in source.run.solution.contacts:
        closed = contact.surface.points[contact.status[state] != OPEN]
        x, y = ((closed - view.centre) @ view.across.T).T
        panel.plot(x, y, ls="", marker=".", ms=1.0, mew=0.0, alpha=0.6, color=VERMILLION)
    middles = [contact.surface.points.mean(axis=0) for contact in source.run.solution.contacts]
    for name, body in source.bodies(state).items():
        # Between the middle of the body and what of it is farthest from all contacts.
        places = body.deformed(scale)
        distances = [np.linalg.norm(places - middle, axis=1) for middle in middles]
        farthest = places[int(np.min(distances, axis=0).argmax())]
        x, y = ((places.mean(axis=0) + 2 * farthest) / 3 - view.centre) @ view.across.T
        panel.text(x, y, name, ha="center", va="center", path_effects=HALO)


def draw_pictures(directory: Path, files: list[str]) -> None:
    """Draw some of the pictures of a results folder.

    Args:
        directory: results folder.
        files: names of the pictures.
    """
    source = open_fields(directory)
    for wanted in plan_pictures(source.run):
        if wanted.file in files:
            _report(wanted.file, partial(_draw_picture, source, wanted))


def _report(file: str, write: Callable[[], dict[str, Any]]) -> None:
    """Write a file, and report it, or why there is none."""
    try:
        found = write()
    except OSError as error:
        found = {"reason": f"{file} cannot be written: {disk_reason(error)}"}
    except Exception as error:
        if isinstance(error, FretfeError) or memory_shortage(error) or missing_package(error):
            raise
        found = {"error": said(error), "trace": trace_of(error)}
    print(json.dumps({"file": file, **found}), flush=True)


def _draw_picture(source: Fields, wanted: Wanted) -> dict[str, Any]:
    """Caption and size, and why states are missing."""
    states = source.available(wanted.states)
    absent = [when(source.run, each) for each in wanted.states if each not in states]
    report: dict[str, Any] = {}
    if absent:
        report["reason"] = f"no fields of {' and '.join(absent)} in {FIELDS}"
    if not states:
        return report
    path = folder_of(source.run) / PICTURES / wanted.file
    if wanted.kind == "bodies":
        look = find_look(source, states)
        scene = Scene(look.limit)
        figure = draw_bodies(source, states, look, scene)
        caption = bodies_caption(source, states, look)
        scene.close()
    else:
        figure, caption = draw_edges(source, [e for e in wanted.edges if e.state in states])
    # Shades of solids have other colours too.
    width, height = save_png(figure, path, COLOURS if source.dimension == 2 else None)
    return {**report, "caption": caption, "width": width, "height": height}


# Before 0.45 PyVista says so where VTK then ends the process; that is found out without it.
NO_DISPLAY = r"\s*This system does not appear to be running an xserver"


if __name__ == "__main__":
    warnings.filterwarnings("ignore", NO_DISPLAY)
    draw_pictures(Path(sys.argv[1]), sys.argv[2:])
