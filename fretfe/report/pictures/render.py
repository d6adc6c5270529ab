# SPDX-License-Identifier: LGPL-3.0-or-later
"""Draws the pictures that need OpenGL: `python -m fretfe.report.pictures.render TASK DIR FILE ...`.

A process of its own: where OpenGL does not work VTK does not raise errors but ends the process.
Each file is reported on standard output, as a line of JSON, once it is written.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from PIL.Image import Image

from fretfe.files import disk_reason, replacing
from fretfe.report.pictures.fields import Fields, Scene, open_fields
from fretfe.report.pictures.looks import Look, find_look
from fretfe.report.pictures.panels import pixels, save_png
from fretfe.report.pictures.plan import Wanted, plan_pictures
from fretfe.report.pictures.stress import bodies_caption, draw_bodies, draw_edges
from fretfe.report.source import cycle_states, extremes, folder_of, when
from fretfe.report.theme import COLOURS, DURATION, FRAME_WIDTH
from fretfe.results.field_files import FIELDS
from fretfe.results.writer import PICTURES


def draw_pictures(directory: Path, files: list[str]) -> None:
    """Draw some of the pictures of a results folder.

    Args:
        directory: results folder.
        files: names of the pictures.
    """
    source = open_fields(directory)
    for wanted in plan_pictures(source.run):
        if wanted.file in files:
            _report(wanted.file, partial(_draw, source, wanted))


def _report(file: str, write: Callable[[], dict[str, Any]]) -> None:
    """Write a file, and report it, or why there is none."""
    try:
        found = write()
    except OSError as error:
        found = {"reason": f"{file} cannot be written: {disk_reason(error)}"}
    print(json.dumps({"file": file, **found}), flush=True)


def _draw(source: Fields, wanted: Wanted) -> dict[str, Any]:
    """Caption and size, and why states are missing."""
    states = source.available(wanted.states)
    absent = [when(source.run, each) for each in wanted.states if each not in states]
    report: dict[str, Any] = {}
    if absent:
        report["reason"] = f"no fields of {' and '.join(absent)} in {FIELDS}"
    if not states:
        return report
    path = folder_of(source.run) / PICTURES / wanted.file
    if wanted.kind == "scene":
        look = _export(source, states[-1], path)
        unit = source.run.case.units.stress
        caption = (
            f"The bodies at {when(source.run, states[-1])} with von Mises stress from 0 to "
            f"{look.limit:g} {unit}, displacements × {look.scale:g}: glTF, for ParaView, Blender "
            "and viewers in a browser."
        )
        return {**report, "caption": caption}
    if wanted.kind == "bodies":
        look = find_look(source, states)
        scene = Scene(look.limit)
        figure = draw_bodies(source, states, look, scene)
        caption = bodies_caption(source, states, look)
        scene.close()
    else:
        figure, caption = draw_edges(source, states[-1], wanted.edges)
    # Shades of solids have other colours too.
    width, height = save_png(figure, path, COLOURS if source.dimension == 2 else None)
    return {**report, "caption": caption, "width": width, "height": height}


def draw_animation(directory: Path, files: list[str]) -> None:
    """Draw the evaluated cycle as a GIF file.

    Args:
        directory: results folder.
        files: the one to write.
    """
    source = open_fields(directory)
    states = cycle_states(source.run)
    found = len(source.available(states))
    if found < len(states):
        reason = (
            f"expected fields of all {len(states)} states of the cycle, found {found}: run the "
            "case with 'fields = \"all\"' in its table [output]"
        )
        print(json.dumps({"file": files[0], "reason": reason}), flush=True)
        return
    look = find_look(source, extremes(source.run))
    scene = Scene(look.limit)
    frames = []
    for state in states:
        frames.append(pixels(draw_bodies(source, [state], look, scene, FRAME_WIDTH), COLOURS))
        source.forget()
    scene.close()
    duration = round(DURATION / len(frames))
    _report(files[0], partial(_write_frames, Path(files[0]), frames, duration))


def _write_frames(path: Path, frames: Sequence[Image], duration: int) -> dict[str, Any]:
    with replacing(path, path.suffix) as new:
        frames[0].save(new, save_all=True, append_images=frames[1:], duration=duration, loop=0)
    return {}


def export_scene(directory: Path, files: list[str]) -> None:
    """Write the bodies at the last state as a glTF file.

    Args:
        directory: results folder.
        files: the one to write.
    """
    source = open_fields(directory)
    states = source.available(range(len(source.run.loads.times)))
    if not states:
        print(json.dumps({"file": files[0], "reason": "there are no fields"}), flush=True)
        return

    def write() -> dict[str, Any]:
        look = _export(source, states[-1], Path(files[0]))
        return {"scale": look.scale, "limit": look.limit}

    _report(files[0], write)


def _export(source: Fields, state: int, path: Path) -> Look:
    """Write the bodies at a state as a glTF file, and return their look."""
    look = find_look(source, [state])
    scene = Scene(look.limit)
    scene.export(list(source.bodies(state).values()), look.scale, path)
    scene.close()
    return look


TASKS = {"pictures": draw_pictures, "animation": draw_animation, "scene": export_scene}

# Before 0.45 PyVista says so where VTK then ends the process; that is found out without it.
NO_DISPLAY = r"\s*This system does not appear to be running an xserver"

if __name__ == "__main__":
    warnings.filterwarnings("ignore", NO_DISPLAY)
    TASKS[sys.argv[1]](Path(sys.argv[2]), sys.argv[3:])
