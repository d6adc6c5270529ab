# SPDX-License-Identifier: LGPL-3.0-or-later
"""Terms of a report, explained as in the glossary of the documents, `docs/glossary.md`.

That has a heading of the third level for each term, below it the explanation. An installed package
has it in the folder of this module.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup, escape

# Terms of every page, of pages of plane bodies, and of pages of solids.
TERMS = {
    *("Body 1, body 2", "State, step, cycle", "Half cycle", "Pressure, shear", "Friction bound"),
    *("Stick and slip", "Partial slip, gross slip", "Full stick", "Patch", "Edge factor", "K_N"),
    *("K_T", "K_I", "Slip zone", "Error bar", "Resolved", "Certificate", "Friction work"),
    "Verdict",
}
PLANE_TERMS = {"Bulk tension", "Contact edge"}
SOLID_TERMS = {"Front", "Station", "K_S"}
# Headers of tables, with the terms that explain them.
HEADERS = {
    "edge": "Contact edge",
    "front": "Front",
    "K_N": "K_N",
    "K_T": "K_T",
    "ΔK_T": "K_T",
    "mean K_T": "K_T",
    "|ΔK|": "K_S",
    "half cycle": "Half cycle",
    "d found": "Slip zone",
    "d predicted": "Slip zone",
    "slip": "Slip zone",
    "slip zones": "Slip zone",
    "predicted": "Slip zone",
    "verdict": "Verdict",
    "P": "Pressure, shear",
    "Q": "Pressure, shear",
    "|Q|": "Pressure, shear",
    "sticks": "Stick and slip",
    "steady": "State, step, cycle",
    "Δq/(f p_max)": "Friction bound",
    "work": "Friction work",
}
# A reference to another page, which a report cannot lead to, and other links.
REFERENCE = re.compile(r"\s\(\[[^]]*\]\([^)]*\)\)")
LINK = re.compile(r"\[([^]]*)\]\([^)]*\)")


@dataclass(frozen=True)
class Term:
    """A term with its explanation.

    Attributes:
        name: the term.
        text: the explanation in Markdown, without links.
    """

    name: str
    text: str

    @property
    def anchor(self) -> str:
        """Id of the explanation on the page."""
        return "term-" + re.sub(r"\W+", "-", self.name.lower())

    @property
    def hint(self) -> str:
        """The explanation as plain text."""
        return re.sub(r"[*`]", "", self.text)

    @property
    def html(self) -> Markup:
        """The explanation."""
        text = re.sub(r"\*([^*]+)\*", r"<em>\1</em>", str(subscripts(self.text)))
        return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", text))


class Glossary:
    """The terms of a page, in the order of the glossary.

    Args:
        solid: whether the bodies are solids.
        across: whether plane bodies move along z.
    """

    def __init__(self, solid: bool, across: bool = False) -> None:
        wanted = TERMS | (SOLID_TERMS if solid else PLANE_TERMS) | ({"K_S"} if across else set())
        self.terms = tuple(term for term in _read_terms() if term.name in wanted)
        self._by_name = {term.name: term for term in self.terms}

    def linked(self, header: str, unit: str = "") -> Markup:
        """A header of a table, linked to the term that explains it if there is one."""
        shown = subscripts(header) + (f" [{unit}]" if unit else "")
        term = self._by_name.get(HEADERS.get(header, ""))
        if term is None:
            return shown
        link = Markup('<a class="term" href="#{}" title="{}">{}</a>')
        return link.format(term.anchor, term.hint, shown)


def subscripts(text: str) -> Markup:
    """Escaped text in which the index of a symbol such as K_N stands lower."""
    return Markup(re.sub(r"(?<![A-Za-z_])([Kp])_(\w+)", r"\1<sub>\2</sub>", str(escape(text))))


def _read_terms() -> list[Term]:
    installed = Path(__file__).with_name("glossary.md")
    beside = Path(__file__).parents[3] / "docs" / "glossary.md"
    text = (installed if installed.is_file() else beside).read_text(encoding="utf-8")
    text = LINK.sub(r"\1", REFERENCE.sub("", text))
    entries = re.split(r"^#{2,3} ", text, flags=re.MULTILINE)[1:]
    parts = (entry.partition("\n") for entry in entries)
    return [Term(name, " ".join(explanation.split())) for name, _, explanation in parts]
