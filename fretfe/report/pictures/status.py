# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of contacts that stick, slip and are open. They need no fields and no OpenGL."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretfe.history.solution import OPEN, SLIP, STICK, ContactHistory
from fretfe.report.pictures.mesh import cell_outlines
from fretfe.report.pictures.panels import View, name_axes, panels, plural, set_limits, settle
from fretfe.report.source import state_title, times_text
from fretfe.report.theme import BLUE, FRAMED, GREY, ORANGE, PALE
from fretfe.results.model import BodyArrays, Result

# Height of a panel over its width.
ASPECT = 0.36
# Around the part of the surfaces that is closed in any of the states, as a fraction of it.
BORDER = 0.06
BODIES = (PALE, "#F0F0F0")
# Width and darkness tell them apart in grey.
STATUS: dict[int, dict[str, Any]] = {
    OPEN: {"color": GREY, "linewidth": 0.9, "linestyle": (0, (1.0, 1.5))},
    STICK: {"color": BLUE, "linewidth": 2.2},
    SLIP: {"color": ORANGE, "linewidth": 6.5},
}
# Slip in a step, over the largest slip in the history, that is round-off.
ROUND_OFF = 1e-9
NAMES = {SLIP: "slip", STICK: "stick", OPEN: "open"}


@mpl.rc_context(FRAMED)
def draw_status(run: Result, contacts: Sequence[str], states: Sequence[int]) -> tuple[Figure, str]:
    """One row of panels for each contact, a column for each state, and the caption."""
    assert run.solution is not None
    shown = [each for each in run.solution.contacts if each.name in contacts]
    columns = len(states)
    figure, axes = panels(columns * len(contacts), ASPECT, columns=columns)
    handles = [Line2D([], [], label=NAMES[kind], **STATUS[kind]) for kind in NAMES]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    for row, contact in enumerate(shown):
        view = contact_view(contact, states)
        for panel, state in zip(axes[row * columns :], states, strict=False):
            set_limits(panel, view)
            _draw_bodies(panel, run.bodies.values(), view)
            _draw_contact(panel, contact, state, view)
            name_axes(panel, "along x", "along y", run.case.units.length)
            title = f"{contact.name}, {state_title(run, state)}"
            panel.set_title(f"{title}\n{shares_text(contact, state)}")
    settle(figure, axes, ASPECT, "Where the contacts stick and slip")
    return figure, (
        f"Status of the contacts in the steps that end at {times_text(run, states)}, drawn on "
        "the bodies before deformation: wide and light where they slip, narrow and dark where "
        "they stick, dotted where they are open. Each panel is turned into the frame of its "
        "contact, with body 2 below."
    )


def contact_view(contact: ContactHistory, states: Sequence[int]) -> View:
    """The part of a contact that is closed in any of the states, or all of it if none is."""
    closed = (contact.status[list(states)] != OPEN).any(axis=0)
    points = contact.points[closed] if closed.any() else contact.points
    middle = len(points) // 2
    normal = (contact.frames[closed] if closed.any() else contact.frames)[middle, 0]
    upright = View(points[middle], np.ones(2), normal)
    local = upright.local(points)
    low, high = local.min(axis=0), local.max(axis=0)
    size = (high - low) * (1 + 2 * BORDER)
    half = max(size[0], size[1] / ASPECT, np.ptp(contact.arc) * 1e-3) / 2
    shift = (low + high) / 2
    centre = points[middle] + shift @ np.stack([upright.tangent, normal])
    # The axis has the numbers of the arc, as the results have.
    arc = (contact.arc[closed] if closed.any() else contact.arc)[middle]
    origin = np.array([arc + shift[0], 0.0])
    return View(centre, np.array([half, ASPECT * half]), normal, origin)


def visible_status(contact: ContactHistory, state: int) -> npt.NDArray[np.int8]:
    """(N,) status at a state; nodes at the limit of friction that do not move count as sticking.

    Which of them count as slipping in the solution is a matter of round-off.
    """
    status = contact.status[state].copy()
    before, after = contact.slip[max(state - 1, 0)], contact.slip[state]
    moved, largest = np.abs(after - before).max(axis=-1), np.abs([before, after]).max()
    status[(status == SLIP) & (moved <= ROUND_OFF * largest)] = STICK
    return status


def shares_text(contact: ContactHistory, state: int) -> str:
    """Shares of the closed contact that stick and slip."""
    status = visible_status(contact, state)
    lengths = {kind: contact.weights[status == kind].sum() for kind in (STICK, SLIP)}
    total = sum(lengths.values())
    if total == 0:
        return "open"
    return ", ".join(f"{NAMES[kind]} {length / total:.1%}" for kind, length in lengths.items())


def _draw_bodies(panel: Axes, bodies: Iterable[BodyArrays], view: View) -> None:
    """Light grey, one a little darker than the other."""
    for number, body in enumerate(bodies):
        colour = BODIES[number % len(BODIES)]
        for part in cell_outlines(body)[0]:
            cells = list(view.local(part[view.overlaps(part)]))
            # Lines of the same colour close the seams between the elements.
            panel.add_collection(
                PolyCollection(cells, facecolors=colour, edgecolors=colour, linewidths=0.3),
                autolim=False,
            )


def _draw_contact(panel: Axes, contact: ContactHistory, state: int, view: View) -> None:
    """The contact line, in pieces around the nodes that have the same status."""
    points = view.local(contact.points)
    middles = (points[1:] + points[:-1]) / 2
    starts = np.concatenate([points[:1], middles])
    ends = np.concatenate([middles, points[-1:]])
    status = visible_status(contact, state)
    # Narrow lines end upon wide ones.
    for order, (kind, style) in enumerate(sorted(STATUS.items(), key=lambda s: -s[0])):
        chosen = status == kind
        pieces = [
            np.concatenate([starts[run[:1]], points[run], ends[run[-1:]]])
            for run in np.split(np.arange(len(points)), np.flatnonzero(np.diff(chosen)) + 1)
            if chosen[run[0]]
        ]
        lines = LineCollection(pieces, capstyle="butt", zorder=2 + order, **plural(style))
        panel.add_collection(lines, autolim=False)
