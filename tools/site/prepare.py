# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gather the source of the site: the README, docs/, the API reference and the gallery.

Usage: prepare.py FOLDER      the folder is made anew
"""

from __future__ import annotations

import re
import shutil
import sys
from importlib.metadata import metadata
from pathlib import Path

import api
import book
import gallery

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
# Sections of the site, in the order in which they are listed.
SECTIONS = {
    "Begin": (
        "install",
        "tutorial-dovetail",
        "tutorial-sector",
        "tutorial-solids",
        "tutorial-decision",
        "gallery",
        "glossary",
    ),
    "How to": (
        "how-own-mesh",
        "new-geometry",
        "how-load-history",
        "how-interface",
        "how-global-model",
        "from-abaqus",
        "sweep",
        "how-mpi",
        "how-notebook",
        "how-report",
    ),
    "Input": (
        "case-file",
        "histories",
        "materials",
        "templates",
        "geometry",
        "solids",
        "ends",
        "refinement",
        "mesh",
    ),
    "Output": ("report", "results", "results-files", "exchange", "match", "strength", "local"),
    "Use": ("command-line", "python", "api/index", "edges", "backends"),
    "Trust": (
        "theory",
        "memory",
        "unlike",
        "applicability",
        "method",
        "validate",
        "verify",
        "book",
        "reference/README",
        "security",
    ),
    "Behind it": ("contributing", "architecture", "performance", "changes"),
}
# Where links from the root lead in the site.
ROOT_LINKS = {
    "demos": "gallery.md",
    "demos/README.md": "gallery.md",
    "CHANGELOG.md": "changes.md",
    "CONTRIBUTING.md": "contributing.md",
}


def root_page(name: str) -> str:
    """A page that stands beside docs/."""
    text = (ROOT / name).read_text("utf-8").replace("](docs/", "](")
    for link, page in ROOT_LINKS.items():
        text = text.replace(f"]({link})", f"]({page})")
    return titled(text)


def titled(text: str) -> str:
    """A page in which a link whose text is a file name has the title it leads to as its text."""
    return re.sub(r"\[(?:docs/)?[\w-]+\.md\]\(([^)]*\.md[^)]*)\)", r"[](\1)", text)


def front_page() -> str:
    """The README with the version and the addresses of the package, and the list of all pages."""
    lists = [
        f"```{{toctree}}\n:caption: {section}\n:hidden:\n\n" + "\n".join(pages) + "\n```\n"
        for section, pages in SECTIONS.items()
    ]
    title, _, text = root_page("README.md").partition("\n\n")
    found = metadata("fretfe")
    urls = [each.split(", ", 1) for each in found.get_all("Project-URL") or ()]
    links = [f"[{name}]({url})" for name, url in urls]
    head = " · ".join([f"Version {found['Version']}", *links])
    return f"{title}\n\n{head}\n\n{text}\n" + "\n".join(lists)


def site_page(text: str) -> str:
    """A page of docs/, with the README as the front page of the site."""
    text = text.replace("](../README.md", "](index.md")
    return titled(re.sub(r"\]\(\.\./(demos/[^)]*)\)", r"](\1)", text))


def write(folder: Path) -> None:
    """Make the folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "index.md").write_text(front_page())
    for page in DOCS.glob("*.md"):
        (folder / page.name).write_text(site_page(page.read_text("utf-8")))
    shutil.copytree(DOCS / "images", folder / "images")
    shutil.copytree(ROOT / "demos", folder / "demos")
    shutil.copytree(DOCS / "reference", folder / "reference")
    for name in ("CHANGELOG.md", "CONTRIBUTING.md"):
        (folder / ROOT_LINKS[name]).write_text(root_page(name))
    for name in ("LICENSE", "LICENSE.GPL"):
        shutil.copy(ROOT / name, folder / name)
    api.write_pages(folder / "api")
    gallery.write(folder, folder.with_name("gallery"))
    book.write(folder, folder.with_name("book"))


if __name__ == "__main__":
    write(Path(sys.argv[1]))
