# SPDX-License-Identifier: LGPL-3.0-or-later
"""Documents: what is short, what is listed, what links lead to."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
DOCUMENTS = sorted(DOCS.glob("*.md"))
PAGES = [*(ROOT / f"{name}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG")), *DOCUMENTS]
MADE_BY_CODE = re.compile(r"<!-- (?:parameters of|measured) .*?<!-- end -->", re.DOTALL)
# What is no sentence: code, formulas, headings, tables, pictures and lines of commands.
NO_PROSE = re.compile(
    r"```.*?```|\$\$.*?\$\$|^ *#.*?$|^ *\|.*?$|^ *!\[.*?$|^\n(?: {4,}[^\n]*\n)+$",
    re.DOTALL | re.MULTILINE,
)
# Blank lines and items of lists part what full stops do not.
PARTS = re.compile(r"\n\s*\n|\n\s*(?:[*-]|\d+\.) |(?<=[.?!])\**\s+(?=\W*[A-ZΔΣ])")
LINK = re.compile(r"\]\(([^()\s]+)\)")


def words(text: str) -> int:
    """What has a letter or a digit: borders of tables, dashes and signs are none."""
    return sum(re.search(r"\w", each) is not None for each in text.split())


def sentence_lengths(page: Path) -> list[int]:
    """Words of the sentences of a page, without tables, code and what code has made."""
    text = NO_PROSE.sub("\n\n", MADE_BY_CODE.sub("", page.read_text("utf-8")))
    return [count for each in PARTS.split(text) if (count := words(each))]


def anchors(page: Path) -> set[str]:
    """Names of the headings of a page, as GitHub makes them."""
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", each.lower()).replace(" ", "-") for each in headings}


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= 130


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    for link in LINK.findall(text):
        if link.startswith("http"):
            continue
        file, _, anchor = link.partition("#")
        target = (page.parent / file) if file else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_every_page_is_in_a_section_of_the_site() -> None:
    text = (ROOT / "tools" / "site" / "prepare.py").read_text("utf-8")
    listed = set(re.findall(r'"([\w-]+)"', text[text.index("SECTIONS") : text.index("def ")]))
    assert {page.stem for page in DOCS.glob("*.md")} <= listed


def test_words_of_the_glossary_are_linked() -> None:
    linked = [page for page in PAGES if "glossary.md" in page.read_text("utf-8")]
    assert len(linked) >= 8


def test_the_pages_are_short() -> None:
    counted = {page.name: words(page.read_text("utf-8")) for page in DOCUMENTS}
    assert sum(counted.values()) <= 55_000
    assert max(counted.values()) <= 4_000, counted


def test_sentences_are_short() -> None:
    lengths = sorted(length for page in DOCUMENTS for length in sentence_lengths(page))
    assert lengths[9 * len(lengths) // 10] <= 30


@pytest.mark.parametrize("page", [*DOCUMENTS, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_a_page_begins_with_what_a_reader_can_do_after_it(page: Path) -> None:
    title, _, rest = page.read_text("utf-8").partition("\n\n")
    assert re.fullmatch(r"# [^\n]+", title)
    first = rest.partition("\n\n")[0]
    assert first.startswith("After this page you ") and len(PARTS.split(first)) == 1


def test_keys_and_columns_of_results_are_those_of_the_code() -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "results_docs.py"))
    for name, written in tool["PAGES"].items():
        page = (DOCS / name).read_text("utf-8")
        assert written(page) == page and page.count("<!-- end -->") >= 3
        # A key without a row gets one; columns that are wrong are replaced.
        cut = re.sub(r"^\| `k_n_moved_reason` .*\n", "", page, flags=re.MULTILINE)
        cut = cut.replace("`k_n_moved_reason`, ", "")
        assert cut != page and "`k_n_moved_reason`" in written(cut)
