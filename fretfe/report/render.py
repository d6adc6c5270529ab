# SPDX-License-Identifier: LGPL-3.0-or-later
"""Draws the pictures that need OpenGL: `python -m fretfe.report.render TASK DIR FILE ...`.

A process of its own: where OpenGL does not work VTK does not raise errors but ends the process.
Each file is reported on standard output, as a line of JSON, once it is written.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from fretfe.report.picture_frames import save_png
from fretfe.report.picture_plan import FOLDER, Wanted, plan_pictures
from fretfe.report.picture_source import Source, open_source
from fretfe.report.picture_texts import time_text
from fretfe.report.scene import COLOURS
from fretfe.report.stress_pictures import draw_bodies, draw_edges


def draw_pictures(directory: Path, files: list[str]) -> None:
    """Draw some of the pictures of a results folder.

    Args:
        directory: results folder.
        files: names of the pictures.
    """
    source = open_source(directory)
    for wanted in plan_pictures(source.numbers):
        if wanted.file in files:
            print(json.dumps({"file": wanted.file, **_draw(source, wanted)}), flush=True)


def _draw(source: Source, wanted: Wanted) -> dict[str, Any]:
    """Caption and size, and why states are missing."""
    states = source.available(wanted.states)
    absent = [time_text(source.numbers, each) for each in wanted.states if each not in states]
    report: dict[str, Any] = {}
    if absent:
        report["reason"] = f"no fields of {' and '.join(absent)} in fields"
    if not states:
        return report
    figure, caption = (
        draw_bodies(source, states)
        if wanted.kind == "bodies"
        else draw_edges(source, states[-1], wanted.edges)
    )
    width, height = save_png(figure, source.folder / FOLDER / wanted.file, COLOURS)
    return {**report, "caption": caption, "width": width, "height": height}


TASKS = {"pictures": draw_pictures}

if __name__ == "__main__":
    TASKS[sys.argv[1]](Path(sys.argv[2]), sys.argv[3:])
