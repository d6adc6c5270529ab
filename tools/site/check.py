# SPDX-License-Identifier: LGPL-3.0-or-later
"""Check the finished site: every public name has a place, and a search finds the right page first.

Usage: check.py FOLDER      the search is tried where Node.js is installed
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import api
from sphinx.util.inventory import InventoryFile

SEARCH = Path(__file__).with_name("search.js")
# What is looked for, and pages that may come first.
EXPECTED = {
    "slip zone": ("glossary",),
    "K_N": ("glossary",),
    "mpirun": ("how-mpi",),
    "own mesh": ("how-own-mesh",),
    "load history": ("how-load-history",),
    "coating": ("how-interface", "case-file"),
    "global model": ("how-global-model",),
    "sweep": ("sweep", "glossary"),
    "notebook": ("how-notebook",),
    "edge factor": ("glossary",),
    "install": ("install",),
    "exit codes": ("command-line",),
    "tangential_factor": ("api/edge_formulas",),
}
# What engineers ask, and pages one of which is the first or the second.
QUESTIONS = {
    "mpi": ("how-mpi",),
    "memory": ("performance",),
    "crack initiation": ("strength",),
    "licence": ("index",),
    "wear": ("local", "how-interface"),
    "residual stress": ("case-file", "strength"),
    "shot peening": ("case-file",),
    "own mesh": ("how-own-mesh",),
    "abaqus": ("from-abaqus", "geometry"),
    "ansys": ("from-abaqus",),
    "restart": ("command-line",),
    "units": ("case-file",),
    "error bar": ("glossary",),
    "refinement": ("refinement",),
    "docker": ("install",),
    "temperature": ("case-file", "how-global-model", "materials"),
    "cite": ("index",),
    "logging": ("python",),
    "cyclic symmetry": ("case-file", "tutorial-sector"),
    "submodel": ("command-line", "how-global-model"),
    "convergence": ("refinement",),
    "gmsh": ("geometry",),
    "plasticity": ("from-abaqus",),
    "friction varying": ("case-file",),
    "sector": ("tutorial-sector",),
    "slip zone": ("glossary",),
    "json": ("results", "results-files", "command-line"),
    "step file": ("geometry",),
    "notebook": ("how-notebook",),
}


def names_without_place(site: Path) -> list[str]:
    """Public names that are not in the inventory of the site."""
    with (site / "objects.inv").open("rb") as file:
        inventory = InventoryFile.load(file, "", lambda _, place: place)
    placed = {
        name for kind, entries in inventory.items() if kind.startswith("py:") for name in entries
    }
    public = {f"{module}.{name}" for module, names in api.documented().items() for name in names}
    return sorted(public - placed)


def wrong_searches(site: Path) -> list[str]:
    """Queries whose first page, or first two pages, are not the expected ones."""
    node = shutil.which("node")
    if node is None:
        print("search not tried: there is no Node.js")
        return []
    done = subprocess.run(
        [node, SEARCH, site, *EXPECTED, *QUESTIONS], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    return [
        f"{query!r} finds {found[query]}, expected {' or '.join(pages)} among the first {count}"
        for count, wanted in ((1, EXPECTED), (2, QUESTIONS))
        for query, pages in wanted.items()
        if not set(pages) & set(found[query][:count]) or found[query][0] == "changes"
    ]


if __name__ == "__main__":
    site = Path(sys.argv[1])
    problems = [f"{name}: not in the API reference" for name in names_without_place(site)]
    problems += wrong_searches(site)
    sys.exit("\n".join(problems) or 0)
