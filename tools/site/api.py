# SPDX-License-Identifier: LGPL-3.0-or-later
"""The public names of fretfe, and a page of the site for each module that has some."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path
from types import ModuleType

# By page: what it is about, and the modules whose names it has.
PAGES = {
    "fretfe": ("Run and evaluate cases", ("fretfe", "fretfe.api")),
    "results": (
        "Results",
        (
            "fretfe.history.solution",
            "fretfe.evaluate.stress",
            "fretfe.evaluate.critical_planes",
            "fretfe.exchange.comparison",
        ),
    ),
    "strength": ("Strength of edges", ("fretfe.strength.margins", "fretfe.strength.fit")),
    "errors": ("Errors", ("fretfe.errors",)),
    "case": ("Case files", ("fretfe.case", "fretfe.loads")),
    "backends": ("Backends", ("fretfe.backends", "fretfe.idealise", "fretfe.halfplane")),
    "edges": ("Edges in tractions of any code", ("fretfe.evaluate",)),
    "match": (
        "Matched laboratory tests",
        ("fretfe.matching.match", "fretfe.matching.choose", "fretfe.matching.rig"),
    ),
    "profiles": (
        "Closed forms: normal contact",
        ("fretfe.analytic.profiles", "fretfe.analytic.rocking"),
    ),
    "edge_formulas": (
        "Closed forms: contact edges",
        ("fretfe.analytic.edges", "fretfe.analytic.paths"),
    ),
    "partial_slip": (
        "Closed forms: partial slip",
        ("fretfe.analytic.partial_slip",),
    ),
}


def public_names(module: ModuleType) -> list[str]:
    """Names that a module offers: its list, or all classes and functions that it defines."""
    if hasattr(module, "__all__"):
        return sorted(module.__all__)
    return [
        name
        for name, each in vars(module).items()
        if not name.startswith("_")
        and (inspect.isclass(each) or inspect.isfunction(each))
        and each.__module__ == module.__name__
    ]


def documented() -> dict[str, list[str]]:
    """Names by module; a name that several modules offer belongs to the first one."""
    found: dict[str, list[str]] = {}
    seen: set[int] = set()
    for _, modules in PAGES.values():
        for module_name in modules:
            module = importlib.import_module(module_name)
            names = [name for name in public_names(module) if id(getattr(module, name)) not in seen]
            seen |= {id(getattr(module, name)) for name in names}
            found[module_name] = names
    return found


def directive(module: str, name: str) -> str:
    """The directive that documents a name."""
    each = getattr(importlib.import_module(module), name)
    if inspect.isclass(each):
        kind = "exception" if issubclass(each, BaseException) else "class"
        return f".. auto{kind}:: {module}.{name}\n   :members:\n\n"
    if inspect.isfunction(each):
        return f".. autofunction:: {module}.{name}\n\n"
    return f".. autodata:: {module}.{name}\n   :no-value:\n\n"


def write_pages(folder: Path) -> None:
    """Write a page for each entry of `PAGES`, and the page that leads to them."""
    folder.mkdir(parents=True)
    names = documented()
    toctree = "\n".join(f"   {page}" for page in PAGES)
    title = "API reference"
    text = "Generated from the docstrings. :doc:`The guide </python>` has examples.\n"
    (folder / "index.rst").write_text(
        f"{title}\n{'=' * len(title)}\n\n{text}\n.. toctree::\n   :maxdepth: 2\n\n{toctree}\n"
    )
    for page, (title, modules) in PAGES.items():
        parts = [f"{title}\n{'=' * len(title)}\n\n"]
        for module in modules:
            parts += [
                f"{module}\n{'-' * len(module)}\n\n.. automodule:: {module}\n   :no-members:\n\n"
            ]
            parts += [directive(module, name) for name in names[module]]
        (folder / f"{page}.rst").write_text("".join(parts))
