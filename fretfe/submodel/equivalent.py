# SPDX-License-Identifier: LGPL-3.0-or-later
"""The cylinder on a half-plane whose edge has the factors of a station of solids.

Lengths, stresses and forces are in the units of the case, forces per unit thickness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.case import Case, contact_modulus
from fretfe.errors import ModelError
from fretfe.evaluate.contacts import (
    Contact,
    SlipZone,
    Station,
    fronts_of,
    reported,
)
from fretfe.history.solution import ContactHistory
from fretfe.results.model import Result

# Steps in which the cylinder is pressed on, without friction, before the history of the station.
PRESSING = 4
# Smallest half-width over that of the reference state for which the history is taken over.
NARROWEST = 0.2
# Sizes of the bodies and of the surface that may touch, in half-widths.
BODIES, ZONE = 60.0, 2.0
TOP = {"type": "platen", "boundary": "upper_top", "control": "force"}


@dataclass(frozen=True)
class Equivalent:
    """A cylinder pressed on a half-plane and sheared, its left edge in place of a station.

    n states are taken over from the results of solids, after the first of them the friction acts.

    Attributes:
        states: (n,) of the results.
        radius: of the cylinder.
        half_width: of the contact in the reference state, the last one of the cycle or of all.
        k: (n,) the vector (K_T, K_S) along the direction in which it varies most.
        k_i: (n,)
        normal_force, shear_force: (n,) P and Q.
        friction: coefficient.
        bars: relative error bars of the factors of the station. With the half-width as it is,
            radius and P have that of K_N, Q that of the range of (K_T, K_S).
    """

    states: Indices
    radius: float
    half_width: float
    k: Array
    k_i: Array
    normal_force: Array
    shear_force: Array
    friction: float
    bars: Bars

    @property
    def plane_states(self) -> Indices:
        """(n,) the states of the plane problem that these are."""
        return np.arange(len(self.states)) + PRESSING

    def case(self, result: Result, contact: ContactHistory, title: str) -> dict[str, Any]:
        """The plane case, as tables, of results of solids."""
        times, cycle = result.loads.times[self.states].tolist(), result.loads.cycle
        size = BODIES * self.half_width
        bodies = result.case.bodies
        press = [{"ramp": -float(self.normal_force[0]), "until": times[0], "steps": PRESSING}]
        return {
            "title": title,
            "units": result.case.units.model_dump(),
            "geometry": {
                "template": "cylinder",
                "parameters": {
                    "upper_radius": self.radius, "lower_radius": 0.0,
                    "upper_width": min(size, 0.9 * self.radius), "lower_width": size,
                    "upper_height": size, "lower_height": size,
                    "zone": ZONE * self.half_width, "size": 0.01 * self.half_width,
                },
            },
            "bodies": {
                name: {"young": bodies[own].young, "poisson": bodies[own].poisson}
                for name, own in (("upper", contact.body1), ("lower", contact.body2))
            },
            "contacts": {
                contact.name: {
                    "surface1": "upper_contact", "surface2": "lower_contact",
                    "friction": self.friction, "friction_from": times[0],
                },
            },
            "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
            "loads": {
                "press": TOP | {
                    "direction": "y", "history": press + _points(times, -self.normal_force),
                },
                "shear": TOP | {
                    "direction": "x",
                    "history": [
                        {"hold": True, "until": times[0]}, *_points(times, self.shear_force),
                    ],
                },
            },
            **({"cycle": {"start": times[-_length(cycle)], "end": times[-1]}} if cycle else {}),
        }  # fmt: skip


def _points(times: list[float], values: Array) -> list[dict[str, Any]]:
    return [{"times": times[1:], "values": values[1:].tolist()}]


def _length(cycle: tuple[int, int]) -> int:
    """Number of states of a cycle."""
    return cycle[1] - cycle[0] + 1


def equivalent(result: Result, contact: ContactHistory, station: Station) -> Equivalent:
    """The cylinder on a half-plane for a station.

    Its contact is as wide as makes the slip zone grow as at the station, to second order: that of
    a Hertzian contact whose pressure falls behind K_N sqrt(s) as fast, and less where the front is
    convex. Radius and load give K_N in the reference state; P and Q then follow K_I and K.

    Raises:
        ModelError: if there is no such plane problem.
    """
    last = result.loads.cycle[1] if result.loads.cycle else len(result.loads.times) - 1
    k_n = reported(float(station.k_n[last]), float(station.k_n_spread[last]))
    _require(station, k_n)
    e_star = _modulus(result.case, contact)
    half_width = _half_width(station)
    radius = e_star * np.sqrt(2 * half_width) / (2 * k_n)
    k = station.k_along
    # K_I = E*/(3 sqrt(2) R) a^(3/2) of a cylinder.
    powers = half_width**1.5 + 3 * np.sqrt(2) * radius / e_star * (station.k_i - station.k_i[last])
    usable = np.isfinite(k) & (powers >= (NARROWEST * half_width) ** 1.5)
    states = _states(result, contact, station, usable[: last + 1])
    widths = powers[states] ** (2 / 3)
    # As K is added up: by the mean of the factors before and after each step.
    units = 1 / (np.pi * np.sqrt(2 * widths))
    shear = np.append(0.0, np.cumsum(np.diff(k[states]) / ((units[1:] + units[:-1]) / 2)))
    shear[1:] += k[states[0]] / units[0]
    return Equivalent(
        states=states,
        radius=radius,
        half_width=half_width,
        k=k[states],
        k_i=station.k_i[states],
        normal_force=np.pi * e_star * widths**2 / (4 * radius),
        shear_force=shear,
        friction=float(contact.friction[last]),
        bars=bars_of(station, last),
    )


def _states(result: Result, contact: ContactHistory, station: Station, usable: Bools) -> Indices:
    """The states to take over, up to the last one; of a cycle all.

    Raises:
        ModelError: if there are too few that can be used.
    """
    last, cycle = len(usable) - 1, result.loads.cycle
    # Nothing touches in state 0; friction acts after the first state that is taken over.
    first = max(1, int(np.argmax(contact.friction > 0)) - 1, *(np.flatnonzero(~usable) + 1))
    if first >= last or (cycle is not None and first > cycle[0]):
        raise ModelError(
            f"{_name(station)}: expected a history that a cylinder on a half-plane can follow, "
            f"found K_T, K_S or K_I unknown, or a contact that nearly opens, up to state "
            f"{first - 1} of {last}"
        )
    k = station.k_along[first:]
    if not (contact.friction[last] > 0 and np.ptp(k[1 : last + 1 - first]) > 0):
        raise ModelError(
            f"{_name(station)}: expected friction, and K_T or K_S that vary, found none of it"
        )
    return np.arange(first, last + 1)


def _name(station: Station) -> str:
    return f"station {station.number} of {station.front}"


def _require(station: Station, k_n: float) -> None:
    """Check that a station is that of an edge with known factors."""
    if station.end:
        raise ModelError(
            f"{_name(station)}: expected a station with the fields of an edge, found one within a "
            "local length of a free end"
        )
    if not np.isfinite(k_n):
        raise ModelError(
            f"{_name(station)}: expected a known K_N, found none, or an error bar of more than "
            "half of it"
        )


def _modulus(case: Case, contact: ContactHistory) -> float:
    """E* in plane strain, as next to a front."""
    return contact_modulus(case.bodies[contact.body1], case.bodies[contact.body2], "strain")


def _half_width(station: Station) -> float:
    """Half-width of a cylinder's contact whose slip zone grows like that of a station.

    Of a cylinder d = d1 (1 + d1/(2 a)), of a sphere d1 (1 + d1/a), d1 the first order: their
    pressures are the same, the latter's front is bent. Between these two in proportion.
    """
    length = min(station.depth, station.length)
    return float(length / (1 + max(station.curvature, 0.0) * length))


@dataclass(frozen=True)
class Bars:
    """Relative error bars of the factors of a station.

    Attributes:
        k_n: of K_N in the reference state.
        k_range: of the range of (K_T, K_S); NaN where it has none.
    """

    k_n: float
    k_range: float

    @property
    def slip(self) -> float:
        """That of slip zones; by K_N alone where nothing is known of the range."""
        return math.hypot(self.k_n, self.k_range if math.isfinite(self.k_range) else 0.0)

    @property
    def note(self) -> str:
        """Contents of the error bars, in words."""
        if math.isfinite(self.k_range):
            return (
                f"error bars hold those of the station: {self.k_n:.1%} of K_N, "
                f"{self.k_range:.1%} of the range of (K_T, K_S)"
            )
        return (
            f"error bars hold {self.k_n:.1%} of K_N of the station; its range of (K_T, K_S) has no "
            "error bar, so that those of slip zones are too small"
        )


def bars_of(station: Station, state: int) -> Bars:
    """The bars of a station whose K_N is that of a state."""
    size = station.k_range
    return Bars(
        k_n=float(station.k_n_spread[state] / station.k_n[state]),
        k_range=float(station.k_range_spread / size) if size > 0 else math.nan,
    )


def with_bars(plane: Result, bars: Bars) -> Result:
    """The plane problem with error bars that hold those of the station."""
    contacts = tuple(_wider_contact(each, bars) for each in plane.contacts)
    return replace(plane, contacts=contacts, notes=(*plane.notes, bars.note))


def _wider_contact(contact: Contact, bars: Bars) -> Contact:
    return replace(contact, fronts=fronts_of(_wider(each, bars) for each in contact.stations))


def _wider(station: Station, bars: Bars) -> Station:
    parts = station.k_range_parts
    own = math.hypot(parts.discretisation, bars.k_range * station.k_t_range)
    parts = replace(parts, discretisation=own)
    return replace(
        station,
        k_n_spread=(station.k_n_spread**2 + (bars.k_n * station.k_n) ** 2) ** 0.5,
        k_range_spread=parts.total,
        k_range_parts=parts,
        slip_zones=tuple(_wider_zone(zone, bars) for zone in station.slip_zones),
    )


def _wider_zone(zone: SlipZone, bars: Bars) -> SlipZone:
    if zone.gross:
        return zone
    return replace(zone, spread=math.hypot(zone.spread, bars.slip * zone.length))
