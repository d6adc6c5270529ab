# SPDX-License-Identifier: LGPL-3.0-or-later
"""The paper: short, cites what it lists, and its numbers are those of the README."""

from __future__ import annotations

import json
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAPER = (ROOT / "docs" / "paper" / "paper.md").read_text("utf-8")
LIST = (ROOT / "docs" / "paper" / "paper.bib").read_text("utf-8")


def test_it_is_short() -> None:
    assert len(PAPER.split("---\n")[2].split()) <= 900


def test_what_is_cited_is_listed() -> None:
    cited = set(re.findall(r"@(\w+)", PAPER.split("---\n")[2]))
    assert cited == set(re.findall(r"^@\w+\{(\w+),", LIST, re.MULTILINE))


def test_its_numbers_are_those_of_the_readme() -> None:
    readme = (ROOT / "README.md").read_text("utf-8")
    found = re.findall(r"(?<![\d.])(?:\d+\.\d{3,}|\d{4}\.\d+)(?![\d.])", PAPER)
    assert len(found) == 6 and [each for each in found if each not in readme] == []


def test_files_for_citation_agree() -> None:
    codemeta = json.loads((ROOT / "codemeta.json").read_text("utf-8"))
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"version: {codemeta['version']}\n" in citation
    (name,) = (each["name"] for each in codemeta["author"])
    assert f"- name: {name}\n" in citation and f"- name: {name}\n" in PAPER
    words = re.findall(r"^  - ([\w ]+)$", citation.split("references:")[0], re.MULTILINE)
    assert words == codemeta["keywords"]
    assert codemeta["license"].endswith(re.findall(r"^license: (.*)$", citation, re.MULTILINE)[0])
