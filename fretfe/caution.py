# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cautions: what a reader of results must know. They are printed as "Warning: ...".

Not called `Warning`, which is a class of Python for something else. Each kind is one declaration in
`Kind`; whoever needs to know what a caution says asks for its kind, and nobody reads its text.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Self

# Names of the fronts of plane contacts, which are called edges.
EDGES = ("left", "right")
# Different findings of one kind that a line has in full; of further ones it has the places.
SHOWN = 2


class Kind(StrEnum):
    """Kinds of cautions: their name in `results.json`, heading, when they are given, what to do.

    Attributes:
        heading: in a few words.
        when: a caution is given.
        remedy: end of its sentence, the same for all of its kind; empty where the finding itself
            says what to do, or nothing can be done.
    """

    heading: str
    when: str
    remedy: str

    def __new__(cls, name: str, heading: str, when: str, remedy: str = "") -> Self:
        """A member, which is its name, with what it declares."""
        member = str.__new__(cls, name)
        member._value_ = name
        member.heading, member.when, member.remedy = heading, when, remedy
        return member

    # Of the run.
    NOT_CONVERGED = (
        "mesh not converged",
        "the mesh is not fine enough for edges.tolerance",
        "the mesh stopped refining itself before edges.tolerance was reached",
    )
    FAULT = ("fault", "fretfe itself failed", "an error of fretfe left numbers unknown")
    # Of a contact as a whole.
    NEVER_TOUCH = ("never touch", "the surfaces never touch", "no node ever carries pressure")
    PARTED = (
        "parted",
        "the bodies do not touch in the evaluated cycle, or at the end",
        "a contact carries no force there, but did before",
        "either the loads lift them off, and another cycle is to be evaluated, or what should "
        "press them together ends too early",
    )
    FEW_NODES = (
        "few nodes",
        "few nodes in contact",
        "fewer nodes of solids are in contact than pressures and areas need",
    )
    NO_FRONTS = ("no fronts", "no front is known", "solids carry a force, but no front was found")
    UNSTEADY = ("unsteady", "not in steady state", "the shear changes over the evaluated cycle")
    PATCH_EVENTS = (
        "patch events",
        "a patch that is not there all the time",
        "one of several patches appears, vanishes, merges or parts",
        "it has edges only where it exists, and K_T and K_I begin anew whenever it appears",
    )
    PATCH_FORCES = (
        "patch forces",
        "forces of a patch are unknown",
        "the forces of merging patches of solids cannot be separated",
    )
    NODES_APART = (
        "nodes apart",
        "single nodes apart from the patch",
        "a part of P is on too few nodes for edges of their own",
        "make the elements smaller there",
    )
    SURFACE_BORDER = (
        "surface border",
        "the contact reaches the border of its surface",
        "solids touch at a border of the surface where not both of them end",
        "extend the physical group there. If one of the bodies ends there with an edge, that "
        "presses into the other one, and the edge formulas do not hold",
    )
    # Of an edge, or of a front of solids.
    SURFACE_END = (
        "surface end",
        "the contact reaches the end of its surface",
        "the last node of a plane contact surface is in contact",
        "if the bodies go on behind it, extend the physical group; if both end there, the pressure "
        "does not fall to zero and there is no edge with a K_N; if one of them ends there, it is a "
        "sharp corner, where K_N does not exist",
    )
    CUT_END = (
        "cut end",
        "the contact reaches an end of its surface behind which both bodies go on",
        "a contact goes on behind a plane of symmetry or a cut",
        "the edge found there is not a true contact edge",
    )
    NOTHING_KNOWN = ("nothing known", "unknown", "nothing is known of an edge or of stations")
    FACTORS_UNKNOWN = (
        "factors unknown",
        "K_N or the range of K_T is unknown",
        "a factor of a plane edge cannot be found, or its bar is more than half of it",
    )
    WITHHELD = (
        "withheld",
        "K_N or the range of K_T and K_S is withheld",
        "most stations of a front have no K_N or range, or bars of more than half of it",
    )
    UNCOUNTED = (
        "cycles uncounted",
        "cycles are not counted",
        "K_T under irregular loads is not known in all states",
    )
    K_N_UNCERTAIN = (
        "K_N uncertain",
        "K_N is uncertain",
        "the error bar of K_N is more than a twentieth of it",
        "refine the mesh there, or let edges.tolerance do so where fretfe makes the mesh",
    )
    K_N_LINEAR = (
        "K_N uncertain, linear elements",
        "K_N is uncertain",
        "the same, and the model has elements of degree 1",
        "where bodies have linear elements take [model] degree = 2, then refine the mesh there",
    )
    STEPS_TOO_LONG = (
        "steps too long",
        "the range of K_T is uncertain",
        "more than 2 % of the range of K_T may lie between the steps",
        "take more steps per cycle",
    )
    WITHIN_STEP = (
        "within a step",
        "P is largest within a step",
        "P within a divided step exceeds that at the ends of steps by more than a twentieth",
        "K_N and figures are those of the ends of steps",
    )
    GROSS_SLIP = (
        "gross slip",
        "gross slip",
        "the whole contact slips in a half cycle",
        "there is no slip zone then, and K_T is no measure of what happens; finer elements do not "
        "change that",
    )
    NOT_RESOLVED = (
        "slip zone not resolved",
        "a slip zone is not resolved",
        "too few nodes slip, or the inner end of a slip zone cannot be located",
        "refine the mesh there",
    )
    BESIDE_FINE_MESH = (
        "beside fine mesh",
        "the fine mesh ends before the front",
        "the elements at a front are much longer than the finest ones beside it",
        "let the fine mesh reach farther (`edge_zone` of templates, or `edges.tolerance`, which "
        "places it); with finer elements alone K_N and slip zones get no better there",
    )
    # Limits of the model, of a contact.
    UNITS = (
        "units",
        "units are doubted",
        "the largest pressure over the plane modulus is below 1e-5 or above .1",
        "check the units of Young's moduli, loads and lengths before anything else",
    )
    BALANCE = (
        "balance",
        "forces do not balance",
        "the sum of forces or moments on a body is not zero",
        "round-off has destroyed the solution",
    )
    SLIDING = (
        "sliding",
        "large sliding",
        "points slide over a tenth of the width of the contact",
        "points are paired in the undeformed position, which is no longer a good pairing; use "
        "smaller loads or more friction, or a code for large sliding",
    )
    PRESSURE = (
        "pressure",
        "large pressure",
        "the largest pressure is above 2 % of the plane modulus",
        "strains of this size are not small; check units and loads",
    )
    TURNING_NORMAL = (
        "turning normal",
        "sliding along curved surfaces",
        "points slide so far that the contact normal turns",
        "the contact normal turns by this angle, and with it the normal force; use smaller loads",
    )
    SHIFTED = (
        "shifted pairs",
        "sliding beside roundings",
        "points slide over a tenth of the smaller radius of the surfaces",
        "points stay paired as before deformation, so that tractions act beside their places on "
        "one of the bodies; use smaller loads, more friction or larger radii",
    )
    ROTATION = (
        "rotation",
        "large rotation",
        "a body turns at the contact",
        "forces keep their directions in this model and turn against the contact; hold the body, "
        "or use a code for large rotations",
    )
    SLOPE = (
        "slope",
        "large slope",
        "a surface takes a large slope in the contact",
        "angles of this size are not small; check units and loads",
    )
    STRETCH = (
        "stretch",
        "large stretch",
        "a surface is stretched in the contact",
        "strains of this size are not small; check units and loads",
    )
    OVERLAP = (
        "overlap",
        "large overlap",
        "an interference is no small part of the radius of a surface",
        "surfaces are offset by the overlap and keep their radii, so their gap is wrong by this "
        "part; draw them with the radii that they have, and check units",
    )
    PAIRING = (
        "pairing",
        "bodies turn under the loads of the cycle",
        "a gap times a rotation is no small part of ΔK_T",
        "the bodies turn under the loads of the cycle; apply the shear nearer to the contact, or "
        "use lower or wider bodies",
    )
    PENETRATION = (
        "penetration",
        "penetration",
        "surfaces penetrate each other where nothing is paired",
        "contact is looked for only between points that face each other before deformation, up to "
        "half the length of the shorter surface apart: put the bodies where they touch, or make a "
        "contact of these parts",
    )
    TEMPERATURE = (
        "temperature",
        "stiffness at another temperature",
        "Young's modulus at the temperature of the surface is another than the one used",
        "areas and edge factors are wrong by about half of this; take a temperature nearer to "
        "those",
    )
    TEMPERATURE_TABLE = (
        "temperature table",
        "temperatures beyond the table",
        "the surface gets hotter or colder than the table of Young's modulus reaches",
        "the stiffness there is unknown; continue the table",
    )
    DUNDURS = (
        "unlike bodies",
        "unlike bodies",
        "Dundurs' beta is larger than where the formulas were measured",
        "the slip-zone formulas were not measured so far; rely on tractions and slip zones",
    )
    LAYER = (
        "layer",
        "a layer rounds off the tractions next to the edges",
        "E* over the stiffness of a layer is more than a hundredth of the half-width",
        "K_N, ΔK_T and predicted slip zones describe the field farther from the edge than that, or "
        "are unknown; rely on tractions and slip zones",
    )
    GAP_MISSED = (
        "gap missed",
        "elements miss a gap",
        "straight lines between the nodes miss a given gap by more than a twentieth of its range",
        "make the elements there shorter than its waves, or smooth it",
    )
    OSCILLATION = (
        "oscillation",
        "crystals whose tractions oscillate",
        "pressure and shear of crystals depend on each other as between unlike bodies",
        "the tractions of full stick oscillate next to an edge, which K_T, K_I and what follows "
        "from them neglect; rely on tractions and slip zones",
    )
    CROSS_COMPLIANCE = (
        "cross compliance",
        "cross compliance of crystals",
        "pressure and shear of crystals depend on each other without oscillating",
        "shear changes the pressure next to an edge, which slip zones predicted from the edge "
        "factors neglect; rely on the computed ones",
    )
    BODY_SIZE = (
        "body size",
        "bodies are no half-planes",
        "the size or slope of the bodies changes K_N or ΔK_T by more than a hundredth",
        "the bodies are too low, too narrow or too steep for the contact; use the backend 'fem'",
    )
    BODY_STRETCH = (
        "body stretch",
        "different bodies stretch differently under P",
        "that changes slip zones by more than a twentieth",
        "half-planes leave out the shear by it, which falls with the size of the bodies; use the "
        "backend 'fem'",
    )
    FRICTION_VARIES = (
        "friction varies",
        "friction changes in slip zones",
        "the coefficient of a place in a slip zone changes by more than 2 % within the cycle",
        "slip zones are predicted with the coefficient as they end, and found from the slip; where "
        "friction falls points slip though no load changes, and d is unknown",
    )
    # Of an edge as the target of tests, by `fretfe match`.
    TARGET_UNSTEADY = (
        "target not steady",
        "the cycle is not steady",
        "the evaluated cycle of a component is not steady",
        "the test will be",
    )
    TARGET_UNCERTAIN = (
        "target uncertain",
        "factors are uncertain",
        "K_N or the range of K_T of a component is known to less than a twentieth",
    )
    TARGET_OUT_OF_STEP = (
        "target out of step",
        "K_I does not vary in step with K_T",
        "K_I of a component counts, and does not follow K_T",
        "no test here follows that",
    )
    TARGET_DIRECTION = (
        "target direction",
        "(K_T, K_S) is not inward",
        "(K_T, K_S) of a component varies along a direction that is not inward",
        "that of a test is inward",
    )
    TARGET_TURNS = (
        "target turns",
        "(K_T, K_S) turns",
        "(K_T, K_S) of a component does not stay on a line",
        "no test here follows that",
    )
    TARGET_AT_END = (
        "target at an end",
        "the station is next to a free end",
        "the station of a component is next to a free end, towards which |ΔK| varies",
        "a plane test stands for that station alone",
    )


@dataclass(frozen=True)
class Subject:
    """Subject of a caution: the run, a contact, or an edge or front of it.

    Attributes:
        contact: its name, or that of one of its patches; empty for the run.
        front: "left" or "right" in the plane; of solids a front; empty for all of the contact.
    """

    contact: str = ""
    front: str = ""


@dataclass(frozen=True)
class Caution:
    """Something that a reader of results must know.

    Attributes:
        kind: of caution.
        subject: what it is about.
        text: what was found, with its numbers: a part of a sentence without subject and remedy.
        partly: true if the number in question is there, if badly known.
    """

    kind: Kind
    subject: Subject
    text: str
    partly: bool = False

    @property
    def sentence(self) -> str:
        """Edge or front, what was found, and what to do; without the name of the contact."""
        return _joined(places([Subject(front=self.subject.front)]), self.text, self.kind.remedy)


@dataclass(frozen=True)
class Group:
    """All cautions of one kind in a run, at least one.

    Attributes:
        kind: of them.
        cautions: in the order in which they were found.
    """

    kind: Kind
    cautions: tuple[Caution, ...]

    @property
    def findings(self) -> tuple[tuple[str, str], ...]:
        """Places and what was found there; places where the same was found stand together."""
        subjects: dict[str, list[Subject]] = {}
        for each in self.cautions:
            subjects.setdefault(each.text, []).append(each.subject)
        return tuple((places(found), text) for text, found in subjects.items())

    @property
    def advice(self) -> str:
        """The remedy as a sentence; empty where the findings say that."""
        remedy = self.kind.remedy
        return f"{remedy[0].upper()}{remedy[1:]}." if remedy else ""

    @property
    def line(self) -> str:
        """All of it in one line, without what was found at places beyond the first ones.

        What is known badly and what is unknown stand by themselves.
        """
        texts = []
        for partly in dict.fromkeys(each.partly for each in self.cautions):
            alike = Group(self.kind, tuple(c for c in self.cautions if c.partly is partly))
            texts += [_joined(where, text) for where, text in alike.findings[:SHOWN]]
            shown = {text for _, text in alike.findings[:SHOWN]}
            left = [each.subject for each in alike.cautions if each.text not in shown]
            if left:
                texts.append(f"likewise at {places(left)}")
        return _joined("; ".join(texts), self.kind.remedy)


def grouped(cautions: Iterable[Caution]) -> tuple[Group, ...]:
    """Cautions by their kinds, in the order in which the kinds come first."""
    found: dict[Kind, list[Caution]] = {}
    for each in cautions:
        found.setdefault(each.kind, []).append(each)
    return tuple(Group(kind, tuple(each)) for kind, each in found.items())


def about(contact: str, front: str, found: Iterable[tuple[Kind, str]]) -> Iterator[Caution]:
    """Cautions of some kinds, with their texts, about one contact or one of its fronts."""
    yield from (Caution(kind, Subject(contact, front), text) for kind, text in found)


def places(subjects: Iterable[Subject]) -> str:
    """Contacts and their edges or fronts as a list; empty for the run."""
    fronts: dict[str, list[str]] = {}
    for each in subjects:
        fronts.setdefault(each.contact, [])
        if each.front and each.front not in fronts[each.contact]:
            fronts[each.contact].append(each.front)
    return "; ".join(
        ", ".join(filter(None, (contact, _fronts(names)))) for contact, names in fronts.items()
    )


def _fronts(names: list[str]) -> str:
    edges = " and ".join(name for name in names if name in EDGES)
    others = ", ".join(name for name in names if name not in EDGES)
    return f"{edges} edge{'s' if ' ' in edges else ''}" if edges else others


def _joined(*parts: str) -> str:
    return ": ".join(filter(None, parts))
