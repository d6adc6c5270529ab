# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of edges and fronts that are not told: kinds of reasons, and one sentence for each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from fretfe._typing import Array
from fretfe.faults import Fault

# Gap over the length of an element up to which chords of a curved surface may have made it: h/(8 R)
# at R = 2.5 h, as coarse as anything round is meshed.
CHORDS = 0.05


class Lack(StrEnum):
    """Kind of reason why the factors of an edge, or the fronts of a contact, are not known."""

    NOTHING = "nothing"
    ABSENT = "patch absent"
    PARTED = "bodies part"
    FEW_NODES = "few nodes"
    SURFACE_ENDS = "surface ends"
    STEEP = "steep rise"
    NO_ROOT = "no root"
    NO_TRACTIONS = "no tractions"
    NO_BORDER = "no border"
    NARROW = "narrow contact"
    CUT = "cut by ends"
    SHORT_BORDER = "short border"
    NO_CURVE = "no curve"
    FREE_END = "free end"
    NO_EDGE = "no edge"
    LOST = "front lost"
    FAULT = "fault"


@dataclass(frozen=True)
class Withheld:
    """Reason why something is not told.

    Attributes:
        kind: of reason; `Lack.NOTHING` where everything is told.
        found: nodes, states or elements that there are, by the kind.
        wanted: number of them that would do, or of all states.
        words: the reason, of kinds that are whole: each has its own.
    """

    kind: Lack = Lack.NOTHING
    found: int = 0
    wanted: int = 0
    words: str = ""

    @property
    def whole(self) -> bool:
        """True if nothing at all is known: it is no edge or no front, or fretfe failed."""
        return self.kind in (Lack.NO_EDGE, Lack.LOST, Lack.FAULT)

    @property
    def lost(self) -> bool:
        """True if a contact of solids has a border, but no front can be followed along it."""
        kinds = Lack.LOST, Lack.NARROW, Lack.CUT, Lack.SHORT_BORDER, Lack.NO_CURVE
        return self.kind in kinds

    @property
    def by_loads(self) -> bool:
        """True if the loads are the reason for no range, which no mesh mends."""
        return self.kind in (Lack.ABSENT, Lack.PARTED)

    @property
    def finer(self) -> float:
        """Factor by which elements at the edge are to be smaller; 0 without need."""
        few = self.kind in (Lack.FEW_NODES, Lack.STEEP)
        return _halves(self.wanted / max(self.found, 1)) if few else 0.0

    @property
    def text(self) -> str:
        """The reason as a part of a sentence after "because"; empty without one."""
        found, wanted = self.found, self.wanted
        match self.kind:
            case Lack.NOTHING:
                return ""
            case Lack.NO_EDGE | Lack.LOST | Lack.FAULT:
                return self.words
            case Lack.ABSENT:
                return (
                    f"the patch exists in {found} of the {wanted} states of the cycle, and K_T "
                    "begins anew whenever it appears: have loads return to idle in place of zero, "
                    "or give a [cycle] in which it stays"
                )
            case Lack.PARTED:
                if not found:
                    which = "in the cycle" if wanted > 1 else "at the end"
                    return f"the bodies do not touch {which}"
                return (
                    f"the bodies touch in {found} of the {wanted} states of the cycle: without "
                    "contact there is no edge, and K_T begins anew when they touch again"
                )
            case Lack.FEW_NODES:
                return (
                    f"{found} node{' is' if found == 1 else 's are'} in contact, {wanted} are "
                    f"wanted: make the elements at least {self.finer:g} times smaller"
                )
            case Lack.SURFACE_ENDS:
                return "the surface, or the rows, end inside the contact there"
            case Lack.STEEP:
                return (
                    f"the pressure rises to its largest value within {found} "
                    f"node{'' if found == 1 else 's'} of the edge, {wanted} are wanted at least: "
                    f"make the elements there at least {self.finer:g} times smaller, and some over "
                    "a rounding there; if that does not help, the edge is a sharp corner, where "
                    "K_N does not exist"
                )
            case Lack.NO_ROOT:
                return (
                    f"the pressure does not fall to zero like a root there, over the {found} nodes "
                    "from its largest value to the edge"
                )
            case Lack.NO_TRACTIONS:
                return (
                    "the tractions of full stick cannot be told next to the edge: refine the mesh "
                    "there"
                )
            case Lack.FREE_END:
                return (
                    "the station is nearer to a free end than the length of an element along the "
                    "front: make elements shorter there (of layers by end_size)"
                )
        return _of_fronts(self)


TOLD = Withheld()


def failed(fault: Fault) -> Withheld:
    """The reason where fretfe itself failed."""
    return Withheld(Lack.FAULT, words=fault.reason)


def lost_front(place: Array, found: int, wanted: int) -> Withheld:
    """The reason where there is no front along a border of the contact.

    Args:
        place: (3,) in the middle of the border.
        found: elements in which the pressure rises from the border to its largest value.
        wanted: elements that would do.
    """
    why = "the pressure falls to zero like a root at too few places of it"
    if found < wanted:
        why = (
            f"the pressure rises to its largest value within {found} "
            f"element{'' if found == 1 else 's'} of it, {wanted} are wanted at least: make the "
            f"elements there at least {_halves(wanted / found):g} times smaller, and some over a "
            "rounding there; if that does not help, it is a sharp corner, where K_N does not exist"
        )
    at = ", ".join(f"{value:.3g}" for value in place)
    words = f"no front can be followed along this border of the contact, around ({at}): {why}"
    return Withheld(Lack.LOST, found, wanted, words)


def _of_fronts(lack: Withheld) -> str:
    """Reason why a contact between solids that carries a force has no fronts."""
    match lack.kind:
        case Lack.NO_BORDER:
            return (
                "all of its surface is in contact but for rows at its border, which is no contact "
                "edge: where the bodies go on, let the surfaces reach farther"
            )
        case Lack.NARROW:
            return (
                f"it has about {lack.found} elements over its width, {lack.wanted} are wanted at "
                f"least: make them at least {_halves(lack.wanted / max(lack.found, 1)):g} times "
                "smaller"
            )
        case Lack.CUT:
            return (
                f"the ends of its surface cut its boundary to a length of {lack.found} elements, "
                f"less than its width of {lack.wanted}: nothing is known of such corners"
            )
        case Lack.SHORT_BORDER:
            return (
                f"its boundary crosses no more than {lack.found} elements between the ends of the "
                f"surface, {lack.wanted} are wanted at least"
            )
    return (
        "the pressure falls to zero like a root at too few places of its boundary, though it has "
        f"about {lack.found} elements over its width: most likely they are larger there than the "
        "pressed part of a rounding, which fretfe check tells of bodies that sweep a section, or "
        "than those inside; make them smaller. At a sharp corner there is no K_N"
    )


def _halves(ratio: float) -> float:
    """The next half of a whole number above."""
    return math.ceil(2 * ratio) / 2


def untouched_hint(first: float, smallest: float, weights: Array, dimension: int) -> str:
    """Remedy for surfaces that never touch.

    Args:
        first: smallest gap without load.
        smallest: of all states.
        weights: (N,) of nodes.
        dimension: of the bodies.
    """
    spacing = float(np.median(weights)) ** (1 / (dimension - 1))
    if 0 < smallest < CHORDS * spacing:
        return (
            f"That is {smallest / spacing:.1%} of an element: chords of curved surfaces leave such "
            "gaps. Use curved elements (order 2), smaller ones there, or more load"
        )
    if smallest < first:
        return (
            f"The loads bring the bodies together, from a gap of {first:.4g} without them, but not "
            "far enough: check their sizes, or the place of the bodies in the mesh"
        )
    return (
        "No load brings the bodies together: check the signs of those that should, and what holds "
        "the bodies"
    )
