# SPDX-License-Identifier: LGPL-3.0-or-later
"""Animations of the contact surfaces of solids through the evaluated cycle."""

from __future__ import annotations

import io
from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from PIL import Image

from fretfe.report.pictures.panels import panels, pixels
from fretfe.report.pictures.surfaces import (
    Sheet,
    draw_pressure,
    finish,
    frame,
    frame_title,
    lay_out,
    reading,
)
from fretfe.report.theme import COLOURS, FRAMED
from fretfe.results.model import Result

# Width in inches and dots per inch of a frame; frames and bytes at most; milliseconds of a cycle.
FRAME_WIDTH, FRAME_DPI = 6.4, 100
MOST_FRAMES, MOST_BYTES, DURATION = 60, 2_000_000, 4000


def cycle_frames(run: Result) -> list[int]:
    """States of the evaluated cycle, or of everything, to be drawn; none if some are not kept."""
    first, last = run.loads.evaluated
    # The last state of a cycle looks like the first one; nothing is loaded at the first of all.
    states = np.arange(first, last) if run.loads.cycle else np.arange(1, last + 1)
    assert run.solution is not None
    if not run.solution.keeps(int(states[0]), int(states[-1])):
        return []
    return _thinned(states.tolist(), MOST_FRAMES)


def _thinned(states: list[int], most: int) -> list[int]:
    """As many of the states at most, evenly."""
    if len(states) <= most:
        return states
    return [states[round(place)] for place in np.linspace(0, len(states) - 1, most)]


@mpl.rc_context(FRAMED)
def draw_cycle(run: Result, name: str) -> tuple[bytes, str]:
    """Pressure, shear and stick of a contact as a GIF file, and the caption."""
    states = cycle_frames(run)
    sheet = lay_out(run, name, states)
    images = _frames(sheet, states)
    data = _encoded(images)
    # Frames take about the same room each.
    while len(data) > MOST_BYTES and len(images) > 2:
        images = [images[i] for i in _thinned(list(range(len(images))), len(images) // 2)]
        data = _encoded(images)
    what = "the evaluated cycle" if run.loads.cycle else "the whole history"
    return data, f"Pressure and shear in {what}, {len(images)} states. {reading(sheet)}"


def _frames(sheet: Sheet, states: Sequence[int]) -> list[Image.Image]:
    figure, (panel,) = panels(1, sheet.aspect, width=FRAME_WIDTH)
    figure.set_dpi(FRAME_DPI)
    frame(panel, sheet)
    panel.set_title(frame_title(sheet, states[0]))
    finish(figure, [panel], sheet, [])
    images = []
    for state in states:
        for artist in list(panel.collections):
            artist.remove()
        panel.set_title(frame_title(sheet, state))
        draw_pressure(panel, sheet, state)
        images.append(pixels(figure, COLOURS))
    return images


def _encoded(images: Sequence[Image.Image]) -> bytes:
    first, *rest = images
    buffer = io.BytesIO()
    duration = round(DURATION / len(images))
    first.save(
        buffer, "GIF", save_all=True, append_images=rest, duration=duration, loop=0, optimize=True
    )
    return buffer.getvalue()
