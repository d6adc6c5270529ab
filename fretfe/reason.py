# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reasons for which numbers are not known, or not to be trusted.

`Kind` is the one table of their words: whoever needs to know what a reason says asks for its kind,
and nobody reads its text.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Self


class Kind(StrEnum):
    """Kinds of reasons: their name in `results.json`, heading, what to do, what is seen.

    Attributes:
        heading: of cautions, in a few words.
        remedy: end of the sentence; empty where what is seen says what to do, or nothing can be
            done.
        seen: the sentence, with places for numbers; the heading unless there is another one.
            Cautions may have words of their own.
    """

    heading: str
    remedy: str
    seen: str

    def __new__(cls, name: str, heading: str = "", remedy: str = "", seen: str = "") -> Self:
        """A member, which is its name, with what it declares."""
        member = str.__new__(cls, name)
        member._value_ = name
        member.heading, member.remedy, member.seen = heading, remedy, seen or heading
        return member

    def found(self, **numbers: object) -> Finding:
        """The kind with what is seen, by its numbers."""
        return self, self.seen.format(**numbers)

    # Of the run.
    NOT_CONVERGED = (
        "mesh not converged",
        "the mesh is not fine enough for edges.tolerance",
        "",
        "the mesh is not fine enough for edges.tolerance: {why}",
    )
    FAULT = ("fault", "fretfe itself failed")
    # Of a contact as a whole.
    NEVER_TOUCH = (
        "never touch",
        "the surfaces never touch",
        "",
        "the surfaces never touch; the smallest gap is {gap:.4g}. {hint}",
    )
    PARTED = (
        "parted",
        "the bodies do not touch in the evaluated cycle, or at the end",
        "either the loads lift them off, and another cycle is to be evaluated, or what should "
        "press them together ends too early",
    )
    FEW_NODES = (
        "few nodes",
        "few nodes in contact",
        "",
        "{found} node{s_are} in contact, {wanted} are wanted: make the elements at least {finer:g} "
        "times smaller",
    )
    NO_FRONTS = (
        "no fronts",
        "no front is known",
        "",
        "no front of the contact is known at the end of the cycle: {known}, because {why}",
    )
    UNSTEADY = ("unsteady", "not in steady state")
    PATCH_EVENTS = (
        "patch events",
        "a patch that is not there all the time",
        "it has edges only where it exists, and K_T and K_I begin anew whenever it appears",
    )
    PATCH_FORCES = ("patch forces", "forces of a patch are unknown")
    NODES_APART = (
        "nodes apart",
        "single nodes apart from the patch",
        "make the elements smaller there",
    )
    SURFACE_BORDER = (
        "surface border",
        "the contact reaches the border of its surface",
        "extend the physical group there. If one of the bodies ends there with an edge, that "
        "presses into the other one, and the edge formulas do not hold",
    )
    # Of an edge, or of a front of solids.
    SURFACE_END = (
        "surface end",
        "the contact reaches the end of its surface",
        "if the bodies go on behind it, extend the physical group; if both end there, the pressure "
        "does not fall to zero and there is no edge with a K_N; if one of them ends there, it is a "
        "sharp corner, where K_N does not exist",
    )
    CUT_END = (
        "cut end",
        "the contact reaches an end of its surface behind which both bodies go on",
        "the edge found there is not a true contact edge",
        "the contact reaches the end of its surface, behind which both bodies go on",
    )
    NOTHING_KNOWN = ("nothing known", "unknown", "", "{stations}unknown, because {why}")
    FACTORS_UNKNOWN = ("factors unknown", "K_N or the range of K_T is unknown")
    WITHHELD = ("withheld", "K_N or the range of K_T and K_S is withheld")
    UNCOUNTED = ("cycles uncounted", "cycles are not counted", "", "cycles are not counted: {why}")
    K_N_UNCERTAIN = (
        "K_N uncertain",
        "K_N is uncertain",
        "refine the mesh there, or let edges.tolerance do so where fretfe makes the mesh",
    )
    K_N_LINEAR = (
        "K_N uncertain, linear elements",
        "K_N is uncertain",
        "where bodies have linear elements take [model] degree = 2, then refine the mesh there",
    )
    STEPS_TOO_LONG = (
        "steps too long",
        "the range of K_T is uncertain",
        "take more steps per cycle",
    )
    WITHIN_STEP = (
        "within a step",
        "P is largest within a step",
        "K_N and figures are those of the ends of steps",
    )
    GROSS_SLIP = (
        "gross slip",
        "gross slip",
        "there is no slip zone then, and K_T is no measure of what happens; finer elements do not "
        "change that",
        "the whole contact slides{when}",
    )
    NOT_RESOLVED = (
        "slip zone not resolved",
        "a slip zone is not resolved",
        "refine the mesh there",
    )
    BESIDE_FINE_MESH = (
        "beside fine mesh",
        "the fine mesh ends before the front",
        "let the fine mesh reach farther (`edge_zone` of templates, or `edges.tolerance`, which "
        "places it); with finer elements alone K_N and slip zones get no better there",
    )
    # Limits of the model, of a contact.
    UNITS = (
        "units",
        "units are doubted",
        "check the units of Young's moduli, loads and lengths before anything else",
    )
    BALANCE = ("balance", "forces do not balance", "round-off has destroyed the solution")
    SLIDING = (
        "sliding",
        "large sliding",
        "points are paired in the undeformed position, which is no longer a good pairing; use "
        "smaller loads or more friction, or a code for large sliding",
    )
    PRESSURE = (
        "pressure",
        "large pressure",
        "strains of this size are not small; check units and loads",
    )
    TURNING_NORMAL = (
        "turning normal",
        "sliding along curved surfaces",
        "the contact normal turns by this angle, and with it the normal force; use smaller loads",
    )
    SHIFTED = (
        "shifted pairs",
        "sliding beside roundings",
        "points stay paired as before deformation, so that tractions act beside their places on "
        "one of the bodies; use smaller loads, more friction or larger radii",
    )
    ROTATION = (
        "rotation",
        "large rotation",
        "forces keep their directions in this model and turn against the contact; hold the body, "
        "or use a code for large rotations",
    )
    SLOPE = ("slope", "large slope", "angles of this size are not small; check units and loads")
    STRETCH = (
        "stretch",
        "large stretch",
        "strains of this size are not small; check units and loads",
    )
    OVERLAP = (
        "overlap",
        "large overlap",
        "surfaces are offset by the overlap and keep their radii, so their gap is wrong by this "
        "part; draw them with the radii that they have, and check units",
    )
    PAIRING = (
        "pairing",
        "bodies turn under the loads of the cycle",
        "the bodies turn under the loads of the cycle; apply the shear nearer to the contact, or "
        "use lower or wider bodies",
    )
    PENETRATION = (
        "penetration",
        "penetration",
        "contact is looked for only between points that face each other before deformation, up to "
        "half the length of the shorter surface apart: put the bodies where they touch, or make a "
        "contact of these parts",
    )
    TEMPERATURE = (
        "temperature",
        "stiffness at another temperature",
        "areas and edge factors are wrong by about half of this; take a temperature nearer to "
        "those",
    )
    TEMPERATURE_TABLE = (
        "temperature table",
        "temperatures beyond the table",
        "the stiffness there is unknown; continue the table",
    )
    DUNDURS = (
        "unlike bodies",
        "unlike bodies",
        "the slip-zone formulas were not measured so far; rely on tractions and slip zones",
    )
    LAYER = (
        "layer",
        "a layer rounds off the tractions next to the edges",
        "K_N, ΔK_T and predicted slip zones describe the field farther from the edge than that, or "
        "are unknown; rely on tractions and slip zones",
    )
    GAP_MISSED = (
        "gap missed",
        "elements miss a gap",
        "make the elements there shorter than its waves, or smooth it",
    )
    OSCILLATION = (
        "oscillation",
        "crystals whose tractions oscillate",
        "the tractions of full stick oscillate next to an edge, which K_T, K_I and what follows "
        "from them neglect; rely on tractions and slip zones",
    )
    CROSS_COMPLIANCE = (
        "cross compliance",
        "cross compliance of crystals",
        "shear changes the pressure next to an edge, which slip zones predicted from the edge "
        "factors neglect; rely on the computed ones",
    )
    BODY_SIZE = (
        "body size",
        "bodies are no half-planes",
        "the bodies are too low, too narrow or too steep for the contact; use the backend 'fem'",
    )
    BODY_STRETCH = (
        "body stretch",
        "different bodies stretch differently under P",
        "half-planes leave out the shear by it, which falls with the size of the bodies; use the "
        "backend 'fem'",
    )
    FRICTION_VARIES = (
        "friction varies",
        "friction changes in slip zones",
        "slip zones are predicted with the coefficient as they end, and found from the slip; where "
        "friction falls points slip though no load changes, and d is unknown",
    )
    # Of an edge as the target of tests, by `fretfe match`.
    TARGET_UNSTEADY = ("target not steady", "the cycle is not steady", "the test will be")
    TARGET_UNCERTAIN = (
        "target uncertain",
        "factors are uncertain",
        "",
        "K_N or the range of K_T is known to less than a twentieth",
    )
    TARGET_OUT_OF_STEP = (
        "target out of step",
        "K_I does not vary in step with K_T",
        "no test here follows that",
    )
    TARGET_DIRECTION = ("target direction", "(K_T, K_S) is not inward", "that of a test is inward")
    TARGET_TURNS = ("target turns", "(K_T, K_S) turns", "no test here follows that")
    TARGET_AT_END = (
        "target at an end",
        "the station is next to a free end",
        "a plane test stands for that station alone",
    )
    # Why factors of an edge or station are not known; `FEW_NODES` and `FAULT` too.
    NOTHING = "nothing"
    ABSENT = (
        "patch absent",
        "the patch exists in {found} of the {wanted} states of the cycle, and K_T begins anew "
        "whenever it appears",
        "have loads return to idle in place of zero, or give a [cycle] in which it stays",
    )
    NO_CONTACT = (
        "bodies part",
        "the bodies touch in {found} of the {wanted} states of the cycle: without contact there is "
        "no edge, and K_T begins anew when they touch again",
    )
    SURFACE_ENDS = ("surface ends", "the surface, or the rows, end inside the contact there")
    STEEP = (
        "steep rise",
        "the pressure rises to its largest value within {found} node{s} of the edge, {wanted} are "
        "wanted at least",
        "make the elements there at least {finer:g} times smaller, and some over a rounding there; "
        "if that does not help, the edge is a sharp corner, where K_N does not exist",
    )
    NO_ROOT = (
        "no root",
        "the pressure does not fall to zero like a root there, over the {found} nodes from its "
        "largest value to the edge",
    )
    NO_TRACTIONS = (
        "no tractions",
        "the tractions of full stick cannot be told next to the edge",
        "refine the mesh there",
    )
    FREE_END = (
        "free end",
        "the station is nearer to a free end than the length of an element along the front",
        "make elements shorter there (of layers by end_size)",
    )
    NO_FIT = ("no fit", "the pressure next to the front has no fit")
    NO_BAR = ("no error bar", "it has no error bar")
    WIDE_BAR = ("wide error bar", "its error bar is more than half of it")
    NO_CYCLE = ("no cycle", "there is no evaluated cycle")
    NEAR_END = (
        "near an end",
        "within a local length of a free end, where the fields are not those of an edge",
    )
    LOST_STATES = (
        "lost states",
        "the front cannot be found there, or moves to where nothing was integrated",
    )
    NO_EDGE = "no edge"
    LOST = "front lost"
    # Why a contact between solids that carries a force has no fronts.
    NO_BORDER = (
        "no border",
        "all of its surface is in contact but for rows at its border, which is no contact edge",
        "where the bodies go on, let the surfaces reach farther",
    )
    NARROW = (
        "narrow contact",
        "it has about {found} elements over its width, {wanted} are wanted at least",
        "make them at least {finer:g} times smaller",
    )
    CUT = (
        "cut by ends",
        "the ends of its surface cut its boundary to a length of {found} elements, less than its "
        "width of {wanted}: nothing is known of such corners",
    )
    SHORT_BORDER = (
        "short border",
        "its boundary crosses no more than {found} elements between the ends of the surface, "
        "{wanted} are wanted at least",
    )
    NO_CURVE = (
        "no curve",
        "the pressure falls to zero like a root at too few places of its boundary, though it has "
        "about {found} elements over its width",
        "most likely they are larger there than the pressed part of a rounding, which fretfe check "
        "tells of bodies that sweep a section, or than those inside; make them smaller. At a sharp "
        "corner there is no K_N",
    )
    # Why the stress around an edge or station is not known.
    NOT_PLANE = ("not plane", "the bodies are solids, or move along z")
    INCOMPLETE = ("incomplete", "the run is not complete")
    CRYSTAL = ("crystal", "a body is a crystal")
    UNLIKE = ("unlike materials", "the bodies are of unlike materials")
    NOT_KEPT = ("not kept", "the tractions of some states of the cycle are not kept")
    NO_PLACE = ("no place", "its place is not known in all states of the cycle with contact")
    NO_STRESS = (
        "no stress",
        "the run has no stress of the bodies: [output] stress_depths asks for it",
    )


# A kind of reason and its text.
Finding = tuple[Kind, str]


@dataclass(frozen=True)
class Reason:
    """Reason why factors of an edge or station, or the fronts of a contact, are not known.

    Attributes:
        kind: of reason; `Kind.NOTHING` where everything is known.
        found: nodes, states or elements that there are, by the kind.
        wanted: number of them that would do, or of all states.
        words: the reason, where it has its own.
    """

    kind: Kind = Kind.NOTHING
    found: int = 0
    wanted: int = 0
    words: str = ""

    @classmethod
    def first(cls, checks: Mapping[Kind, bool]) -> Reason:
        """The first of some kinds that holds; what is hardest to change comes first."""
        return next((cls(kind) for kind, holds in checks.items() if holds), cls())

    def __bool__(self) -> bool:
        """True if something is not known."""
        return self.kind is not Kind.NOTHING

    @property
    def whole(self) -> bool:
        """True if nothing at all is known: it is no edge or no front, or fretfe failed."""
        return self.kind in (Kind.NO_EDGE, Kind.LOST, Kind.FAULT)

    @property
    def lost(self) -> bool:
        """True if a contact of solids has a border, but no front can be followed along it."""
        kinds = Kind.LOST, Kind.NARROW, Kind.CUT, Kind.SHORT_BORDER, Kind.NO_CURVE
        return self.kind in kinds

    @property
    def by_loads(self) -> bool:
        """True if the loads are the reason for no range, which no mesh mends."""
        return self.kind in (Kind.ABSENT, Kind.NO_CONTACT)

    @property
    def finer(self) -> float:
        """Factor by which elements at the edge are to be smaller; 0 without need."""
        return self._smaller if self.kind in (Kind.FEW_NODES, Kind.STEEP) else 0.0

    @property
    def _smaller(self) -> float:
        """Ratio of what is wanted to what is found, as the next half of a whole number above."""
        return math.ceil(2 * self.wanted / max(self.found, 1)) / 2

    @property
    def advice(self) -> str:
        """Remedy of its kind, with numbers."""
        return self._filled(self.kind.remedy)

    @property
    def text(self) -> str:
        """The reason as a part of a sentence after "because"; empty without one."""
        if self.kind is Kind.NO_CONTACT and not self.found:
            return f"the bodies do not touch {'in the cycle' if self.wanted > 1 else 'at the end'}"
        return self.words or joined(self._filled(self.kind.seen), self.advice)

    def _filled(self, text: str) -> str:
        one = self.found == 1
        counts = {"found": self.found, "wanted": self.wanted, "finer": self._smaller}
        return text.format(**counts, s="" if one else "s", s_are=" is" if one else "s are")


TOLD = Reason()


def joined(*parts: str) -> str:
    """Parts of a sentence with colons between them, but for empty ones."""
    return ": ".join(filter(None, parts))
