# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions of solids along a line across each contact."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.headline import worst_station
from fretfe.evaluate.resultants import load_extremes
from fretfe.report.figures.tractions import EXTREMES, draw_lines, finish_lines, name_contact
from fretfe.report.pictures.surfaces import Sheet, inward_in_plane, lay_out
from fretfe.report.plotting import Axes
from fretfe.report.source import edge_title, when
from fretfe.results.model import Result


@dataclass(frozen=True)
class Line:
    """The n places at which a line on a contact surface crosses sides of facets.

    Between them all that is linear on each facet is linear.

    Attributes:
        places: (n,) along it, increasing; zero in its beginning.
        direction: (2,) in the plane of the sheet.
        sides: (n, 2) nodes of the sides.
        shares: (n,) of their second nodes.
        beginning: in words.
    """

    places: Array
    direction: Array
    sides: Indices
    shares: Array
    beginning: str

    def at(self, values: Array) -> Array:
        """(n,) values of the nodes (N,) on the line."""
        first, second = values[self.sides].T
        return np.asarray((1 - self.shares) * first + self.shares * second)


def line_across(sheet: Sheet, contact: Contact, state: int) -> Line:
    """The line inward from the station with the largest |ΔK| of all fronts.

    Without one it leads from the facet of the largest pressure of a state across the shorter side.
    """
    worst = worst_station([contact])
    if worst is not None:
        station = worst[1]
        start, direction = inward_in_plane(sheet.contact, sheet.plane, station)
        return _crossed(sheet, start, direction, edge_title(station))
    facets = sheet.triangles.triangles
    most = facets[sheet.contact.mean_traction[state][facets, 0].mean(axis=1).argmax()]
    start = sheet.plane.places[most].mean(axis=0)
    return _crossed(sheet, start, np.array([0.0, 1.0]), "the largest pressure")


def _crossed(sheet: Sheet, start: Array, direction: Array, beginning: str) -> Line:
    offsets = sheet.plane.places - start
    along, aside = offsets @ direction, offsets @ [-direction[1], direction[0]]
    every = sheet.triangles.edges
    sides = every[(aside[every] >= 0).sum(axis=1) == 1]
    shares = aside[sides[:, 0]] / (aside[sides[:, 0]] - aside[sides[:, 1]])
    places = (1 - shares) * along[sides[:, 0]] + shares * along[sides[:, 1]]
    points = start + places[:, None] * direction
    order = np.argsort(places)
    order = order[((points >= sheet.low) & (points <= sheet.high)).all(axis=1)[order]]
    return Line(places[order], direction, sides[order], shares[order], beginning)


def state_lines(sheet: Sheet, line: Line, states: Sequence[int]) -> Iterator[tuple[Array, ...]]:
    """p, f p, and the shear along a line and across it, of some states; (n,) each."""
    turned = np.array([-line.direction[1], line.direction[0]])
    for state in states:
        pressure = sheet.contact.mean_traction[state][:, 0]
        bound = sheet.contact.friction.at(state) * pressure
        shear = sheet.shear_at(state)
        shears = shear @ line.direction, shear @ turned
        yield tuple(line.at(each) for each in (pressure, bound, *shears))


def draw_across(panels: Sequence[Axes], run: Result) -> None:
    """Draw p, ±f p, q along a line across every contact, and q⊥ across it, at the load extremes."""
    units = run.case.units
    for panel, contact in zip(panels, run.contacts, strict=True):
        states = load_extremes([contact], run.solution.cycle)
        sheet = lay_out(run, contact.name, states)
        line = line_across(sheet, contact, states[-1])
        drawn = zip(states, state_lines(sheet, line, states), EXTREMES, strict=False)
        for state, values, colour in drawn:
            draw_lines(panel, line.places, values, when(run, state), colour, "q⊥")
        finish_lines(panel, f"from {line.beginning} [{units.length}]", units)
        history = sheet.contact
        name_contact(panel, f"{contact.name}: {history.body1} on {history.body2}")
