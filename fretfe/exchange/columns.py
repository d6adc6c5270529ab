# SPDX-License-Identifier: LGPL-3.0-or-later
"""Columns of exported tables: names, units and meanings.

Units are written in ASCII, as they stand in the header of a file: ``k_n [MPa/mm^0.5]``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from fretfe.case import Units

# Kinds of quantities and their units, plane bodies per unit thickness. Solids differ in some.
PLANE_UNITS = {
    "": "",
    "length": "{length}",
    "time": "{time}",
    "stress": "{stress}",
    "force": "{force}/{length}",
    "moment": "{force}",
    "work": "{force}*{length}/{length}",
    "density": "{force}*{length}/{length}^2",
    "stress slip": "{stress}^2*{length}",
    "area": "{length}",
    "curvature": "1/{length}",
    "angle": "deg",
    "k_n": "{stress}/{length}^0.5",
    "k_t": "{stress}*{length}^0.5",
}
SOLID_UNITS = PLANE_UNITS | {
    "force": "{force}",
    "moment": "{force}*{length}",
    "work": "{force}*{length}",
    "area": "{length}^2",
}


@dataclass(frozen=True)
class Column:
    """A column of an exported table.

    Attributes:
        name: without its unit.
        kind: of quantity, a key of `PLANE_UNITS`.
        meaning: in words.
    """

    name: str
    kind: str
    meaning: str

    def components(self, axes: str) -> list[Column]:
        """The columns of a vector along axes."""
        return [
            Column(f"{self.name}_{axis}", self.kind, f"component {axis} of: {self.meaning}")
            for axis in axes
        ]


@dataclass(frozen=True)
class Heading:
    """A column with its unit."""

    name: str
    unit: str
    meaning: str

    @property
    def text(self) -> str:
        """As it stands in the header of a file."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def headings(columns: Iterable[Column], units: Units, *, solid: bool) -> list[Heading]:
    """Give columns the units of a case."""
    kinds = SOLID_UNITS if solid else PLANE_UNITS
    labels = units.model_dump()
    return [Heading(each.name, kinds[each.kind].format(**labels), each.meaning) for each in columns]


STATE = (
    Column("state", "", "number of the state; 0 is the unloaded one"),
    Column("time", "time", "the clock"),
)
CONTACT = Column("contact", "", "name of the contact, or of one of its patches")
EDGE = Column("edge", "", "left or right")
STATION = (
    CONTACT,
    Column("front", "", "name of the front, in the plane left or right"),
    Column("station", "", "number of the station along the front, from 0; 0 in the plane"),
)
CONTACTS = (
    Column("normal_force", "force", "P, integral of the pressure"),
    Column("shear_force", "force", "Q, integral of the shear on body 2"),
    Column("force", "force", "all on body 2"),
    Column("centre", "length", "middle between the two edges, of solids the centre of pressure"),
    Column("moment", "moment", "moment about the centre, in the plane of the pressure"),
    Column("half_width", "length", "half the distance between the edges"),
    Column("contact_area", "area", "of the nodes in contact, in the plane their width"),
    Column("stick_area", "area", "of those that stick"),
    Column("largest_pressure", "stress", "largest mean around a node"),
    Column("work", "work", "friction work in the step to the state"),
    Column("effective_tension", "stress", "bulk tension that half-planes need for these K_T"),
)
FACTORS = (
    *STATE,
    Column("position", "length", "of the edge; of solids from the point of the station, inward"),
    Column("position_spread", "length", "its error bar"),
    Column("k_n", "k_n", "K_N in the state"),
    Column("k_n_spread", "k_n", "its error bar"),
    Column("k_t", "k_t", "K_T, counted from the first state"),
    Column("k_s", "k_t", "K_S, the same along the edge; zero in the plane"),
    Column("k_i", "k_t", "K_I, the same of normal increments"),
)
EDGES = (
    CONTACT,
    EDGE,
    Column("position", "length", "of the edge in the last state"),
    Column("half_width", "length", "of the contact in the last state"),
    Column("k_n", "k_n", "K_N in the last state; empty if its bar is more than half of it"),
    Column("k_n_spread", "k_n", "error bar of K_N"),
    Column("k_t_range", "k_t", "range of K_T over the evaluated cycle; empty likewise"),
    Column("k_t_range_spread", "k_t", "its error bar"),
    Column("k_i_range", "k_t", "range of K_I"),
    Column("slip_1", "length", "slip zone of the last but one half cycle"),
    Column("slip_2", "length", "slip zone of the last half cycle"),
    Column("slip_1_spread", "length", "error bar of slip_1"),
    Column("slip_2_spread", "length", "error bar of slip_2"),
    Column("predicted_1", "length", "what the edge factors predict for slip_1"),
    Column("predicted_2", "length", "what the edge factors predict for slip_2"),
    Column("gross", "", "whether the whole contact slipped in one of them"),
    Column("resolved", "", "whether the mesh resolves both"),
    Column("dissipation", "work", "friction work at the edge in the cycle"),
    Column("steady", "", "whether the cycle is steady"),
    Column("warnings", "", "what a reader must know"),
)
CYCLES = (
    *STATION,
    Column("start", "", "state of the first reversal"),
    Column("end", "", "state of the second reversal"),
    Column("start_time", "time", "its time"),
    Column("end_time", "time", "its time"),
    Column("count", "", "1, or 0.5 for a range that nothing closes"),
    Column("k_t_start", "k_t", "K_T at the first reversal; of solids along k_angle"),
    Column("k_t_end", "k_t", "K_T at the second reversal"),
    Column("k_t_range", "k_t", "difference of the two, positive"),
    Column("k_t_mean", "k_t", "mean of the two"),
    Column("effective_range", "k_t", "the same with K_T - f K_I and K_T + f K_I: what is counted"),
    Column("slip", "length", "slip length by that range"),
    Column("worst", "", "whether it is the worst cycle of its edge"),
)
STATIONS = (
    *STATION,
    Column("arc", "length", "place along the front"),
    *(Column(axis, "length", "point of the station before deformation") for axis in "xyz"),
    *(Column(f"inward_{axis}", "", "direction into the contact") for axis in "xyz"),
    Column("position", "length", "along the arc at the end; of solids from the point, inward"),
    Column("position_spread", "length", "its error bar"),
    Column("curvature", "curvature", "of the front in the tangent plane"),
    Column("to_end", "length", "distance to the nearer end of the front; empty if it is closed"),
    Column("end", "", "whether the station is too near an end for a verdict"),
    Column("element_size", "length", "an element across the front"),
    Column("k_n", "k_n", "K_N in the last state"),
    Column("k_n_spread", "k_n", "its error bar"),
    Column("k_n_moved", "k_n", "K_N by the movement of the front"),
    Column("k_n_moved_spread", "k_n", "its error bar"),
    Column("k_n_moved_reason", "", "why that is not known"),
    Column("k_t", "k_t", "K_T in the last state"),
    Column("k_s", "k_t", "K_S in the last state"),
    Column("k_i", "k_t", "K_I in the last state"),
    Column("k_t_range", "k_t", "range of K_T over the evaluated cycle"),
    Column("k_s_range", "k_t", "range of K_S"),
    Column("k_i_range", "k_t", "range of K_I"),
    Column("k_range", "k_t", "range of (K_T, K_S) along the direction in which it varies most"),
    Column("k_range_spread", "k_t", "its error bar"),
    Column("k_angle", "angle", "that direction, from inward towards along"),
    Column("turning", "", "range across that direction over the one along it"),
    Column("slip", "length", "slip zone of the last half cycle"),
    Column("slip_spread", "length", "its error bar"),
    Column("predicted", "length", "what the factors predict for it"),
    Column("verdict", "", "comparison of the two"),
    Column("reason", "", "why there is no verdict"),
)
PLANE_TRACTIONS = (
    CONTACT,
    *STATE,
    Column("x", "length", "place along the contact"),
    Column("p", "stress", "pressure, mean around the node"),
    Column("q", "stress", "shear on body 2, mean around the node"),
    Column("slip", "length", "of body 1 relative to body 2 since state 0"),
    Column("gap", "length", "mean gap around the node"),
    Column("status", "", "0 open, 1 stuck, 2 slipping in the step to the state"),
    Column("dissipation", "density", "friction work in that step per area"),
)
SOLID_TRACTIONS = (
    CONTACT,
    *STATE,
    *(Column(axis, "length", "place of the node before deformation") for axis in "xyz"),
    *(Column(f"normal_{axis}", "", "outward normal of body 2") for axis in "xyz"),
    Column("p", "stress", "pressure, mean around the node"),
    *(Column(f"q_{axis}", "stress", "shear on body 2, mean around the node") for axis in "xyz"),
    *(
        Column(f"slip_{axis}", "length", "of body 1 relative to body 2 since state 0")
        for axis in "xyz"
    ),
    Column("gap", "length", "mean gap around the node"),
    Column("status", "", "0 open, 1 stuck, 2 slipping in the step to the state"),
    Column("dissipation", "density", "friction work in that step per area"),
)
PLANE_LOCAL = (
    CONTACT,
    Column("x", "length", "place along the contact"),
    Column("slip_range", "length", "range of the slip in the evaluated cycle"),
    Column("path", "length", "way that slips in it"),
    Column("work", "density", "friction work per area in it"),
    Column("pressed_path", "density", "integral of p |ds| in it: wear after Archard"),
    Column("ruiz", "density", "largest |q| times slip_range"),
)
STRESS = (
    CONTACT,
    Column("body", "", "name of the body"),
    Column("depth", "length", "below the surface of the body; 0 is the surface"),
    Column("x", "length", "place along the contact"),
    Column("largest_tension", "stress", "largest stress along the surface in the cycle"),
    Column("ruiz2", "stress slip", "that, if it is tension, times ruiz of local.csv; surface only"),
    Column("swt", "stress", "Smith-Watson-Topper parameter of the plane where it is largest"),
    Column("shear_strain", "", "largest amplitude of the shear strain on any plane"),
)
FATEMI_SOCIE = Column("fatemi_socie", "", "Fatemi-Socie parameter of the plane where it is largest")
EDGE_STRESS = (
    CONTACT,
    EDGE,
    Column("body", "", "name of the body"),
    Column(
        "largest_tension", "stress", "largest stress along the surface at the edge in the cycle"
    ),
    Column("largest_tension_spread", "stress", "its error bar"),
    Column("reason", "", "why it is not known"),
)
SOLID_LOCAL = (
    CONTACT,
    *(Column(axis, "length", "place of the node before deformation") for axis in "xyz"),
    *PLANE_LOCAL[2:],
)
