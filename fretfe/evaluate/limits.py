# SPDX-License-Identifier: LGPL-3.0-or-later
"""Limits of the model, judged on a solved contact: sliding, strain, and the size of half-planes.

A limit compares a number without dimension, measured in the run, with the value from which the
small-displacement model, or the description of its edges, is wrong by about one per cent.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from fretfe.case import Case, normal_modulus
from fretfe.evaluate.contacts import Contact
from fretfe.history.solution import OPEN, ContactHistory
from fretfe.history.state_array import blocks

# Sliding over the width of the contact. The gap of round surfaces that slide by s has an error of
# s²/(4R) against the approach a²/R of two equal cylinders: (s/2a)², one hundredth.
LARGEST_SLIDING = 0.1
# Linear elasticity leaves out terms of the order of the strain; 2 % is beyond the yield strain of
# nearly all metals.
LARGEST_STRAIN = 0.02


@dataclass(frozen=True)
class ModelLimit:
    """A quantity that must be small for the model to hold.

    Attributes:
        contact: name of the contact; "" for all bodies.
        quantity: what is measured, over what.
        found: largest value in the run; NaN if it could not be measured.
        limit: value up to which the model holds.
        consequence: what is wrong beyond it, and what to do.
    """

    contact: str
    quantity: str
    found: float
    limit: float
    consequence: str

    @property
    def exceeded(self) -> bool:
        """True if the quantity is known and too large."""
        return self.found > self.limit

    @property
    def verdict(self) -> str:
        """The quantity against its limit: "within", "exceeded" or "not measured"."""
        if math.isnan(self.found):
            return "not measured"
        return "exceeded" if self.exceeded else "within"

    @property
    def warning(self) -> str:
        """The quantity, by how much it is too large, and what follows, in one line."""
        return (
            f"outside the model: {self.quantity} is {self.found:.2g}, expected at most "
            f"{self.limit:g}: {self.consequence}"
        )


def with_limit_warnings(
    contacts: Iterable[Contact], limits: Iterable[ModelLimit]
) -> tuple[Contact, ...]:
    """The contacts with a warning for each of their limits that is exceeded."""
    exceeded = [limit for limit in limits if limit.exceeded]

    def warned(contact: Contact) -> Contact:
        own = tuple(limit.warning for limit in exceeded if limit.contact == contact.name)
        return replace(contact, warnings=contact.warnings + own)

    return tuple(warned(each) for each in contacts)


def contact_limits(case: Case, contact: ContactHistory) -> Iterator[ModelLimit]:
    """Limits that the history of a contact tells by itself; none if it never closes."""
    extent = contact_extent(contact)
    if extent.width == 0:
        return
    yield ModelLimit(
        contact.name,
        "sliding over the width of the contact",
        extent.sliding / extent.width,
        LARGEST_SLIDING,
        "points are paired in the undeformed position, which is no longer a good pairing; "
        "use smaller loads or more friction, or a code for large sliding",
    )
    modulus = min(
        normal_modulus(case.bodies[body], case.model.plane, contact.mean_normal)
        for body in (contact.body1, contact.body2)
    )
    yield ModelLimit(
        contact.name,
        "largest pressure over the plane modulus",
        extent.pressure / modulus,
        LARGEST_STRAIN,
        "strains of this size are not small; check units and loads",
    )


def unlike_notes(case: Case, contacts: Collection[Contact]) -> Iterator[str]:
    """A line for each edge between unlike bodies: the length of its factors, lambda and epsilon."""
    chosen = case.edges.reference_length
    if chosen and not any(each.oscillation for contact in contacts for each in contact.stations):
        yield (
            "edges.reference_length has no effect: there is no plane edge between unlike bodies "
            "with friction"
        )
    origin = "the slip zone that they predict" if chosen is None else "as edges.reference_length"
    for contact in contacts:
        for station in contact.stations:
            if not station.oscillation:
                continue
            fall = 10 ** (station.exponent - 0.5) - 1
            turn = math.degrees(station.oscillation * math.log(10))
            yield (
                f"{contact.name}, {station.front} edge, unlike bodies: K_N at the length "
                f"{station.reference_length:.3g} ({origin}), K_T at a quarter and K_I at a "
                f"twentieth of it; lambda = {station.exponent:.4f}, epsilon = "
                f"{station.oscillation:.4f}: a length ten times as large changes K_N by "
                f"{fall:+.1%} and turns (K_T, K_I) by {turn:.2g} degrees"
            )


@dataclass(frozen=True)
class ContactExtent:
    """The largest of some quantities over all states of a contact.

    Attributes:
        sliding: tangential displacement between points of the two surfaces in contact.
        width: length over which the surfaces are in contact, of solids the root of the area; 0 if
            they never are.
        pressure: at a node.
    """

    sliding: float
    width: float
    pressure: float


def contact_extent(contact: ContactHistory) -> ContactExtent:
    """Largest sliding, width and pressure of a contact."""
    largest = np.zeros(3)
    for states in blocks(len(contact.status), contact.traction[0].size):
        closed = contact.status[states] != OPEN
        sliding = np.where(closed, np.linalg.norm(contact.slip[states], axis=2), 0.0)
        found = (
            sliding.max(),
            (closed @ contact.weights).max() ** (1 / (contact.points.shape[1] - 1)),
            contact.traction[states, :, 0].max(),
        )
        largest = np.maximum(largest, found)
    return ContactExtent(*map(float, largest))
