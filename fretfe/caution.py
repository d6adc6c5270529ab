# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cautions: reasons that a reader of results must know. They are printed as "Warning: ...".

Not called `Warning`, which is a class of Python for something else.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from fretfe.reason import Finding, Kind, joined

# Names of the fronts of plane contacts, which are called edges.
EDGES = ("left", "right")
# Different findings of one kind that a line has in full; of further ones it has the places.
SHOWN = 2


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
        return joined(places([Subject(front=self.subject.front)]), self.text, self.kind.remedy)


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
            texts += [joined(where, text) for where, text in alike.findings[:SHOWN]]
            shown = {text for _, text in alike.findings[:SHOWN]}
            left = [each.subject for each in alike.cautions if each.text not in shown]
            if left:
                texts.append(f"likewise at {places(left)}")
        return joined("; ".join(texts), self.kind.remedy)


def grouped(cautions: Iterable[Caution]) -> tuple[Group, ...]:
    """Cautions by their kinds, in the order in which the kinds come first."""
    found: dict[Kind, list[Caution]] = {}
    for each in cautions:
        found.setdefault(each.kind, []).append(each)
    return tuple(Group(kind, tuple(each)) for kind, each in found.items())


def about(contact: str, front: str, found: Iterable[Finding]) -> Iterator[Caution]:
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
