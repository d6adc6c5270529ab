# SPDX-License-Identifier: LGPL-3.0-or-later
"""Only fretfe.fem._compat knows that there is more than one version of DOLFINx.

Ruff bans the functions that are not the same in 0.9 and later (pyproject.toml). What it cannot
see is found here: questions about versions, and differences in attributes and arguments.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COMPAT = ROOT / "fretfe" / "fem" / "_compat.py"
COMPAT_TESTS = ROOT / "tests" / "fem" / "test_compat.py"
SOURCES = [
    path
    for folder in ("fretfe", "tests", "tools", "demos")
    for path in sorted((ROOT / folder).rglob("*.py"))
    if path not in (COMPAT, COMPAT_TESTS)
]
LIBRARIES = {"basix", "dolfinx", "dolfinx_solver", "ffcx", "mpi4py", "petsc4py", "ufl"}
# By their number of arguments: getattr without a default fails where a name is missing.
PROBING_ARGUMENTS = {"getattr": 3, "hasattr": 2, "signature": 1}
PROBING_ERRORS = {"AttributeError", "ImportError", "ModuleNotFoundError", "TypeError"}
VERSION_ATTRIBUTES = {"VERSION", "__version__", "git_commit_hash", "getVersion"}
# Of meshes, elements and expressions: renamed, or once a method and once a property.
CHANGED_ATTRIBUTES = {
    "argument_function_space",
    "argument_space",
    "cmap",
    "cmaps",
    "dofmaps",
    "geometric_dimension",
    "interpolation_points",
    "value_shape",
}
# Arguments that have the same place and meaning in all versions; those behind them do not.
SHARED_ARGUMENTS = {"form": 1, "functionspace": 2}


def names_of_libraries(tree: ast.AST) -> set[str]:
    """Return the names that imports bind to the libraries, or to something from them."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules = [(alias.asname or alias.name, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            modules = [(alias.asname or alias.name, node.module or "") for alias in node.names]
        else:
            continue
        found |= {
            name.split(".")[0]
            for name, module in modules
            if module.split(".")[0] in LIBRARIES or module == "fretfe.fem._compat"
        }
    return found | LIBRARIES


def mentions(node: ast.AST, names: set[str]) -> bool:
    """Whether a name of the libraries occurs, or an import from them."""
    for each in ast.walk(node):
        modules = [alias.name for alias in each.names] if isinstance(each, ast.Import) else []
        if isinstance(each, ast.ImportFrom):
            modules = [each.module or ""]
        if isinstance(each, ast.Name) and each.id in names:
            return True
        if any(module.split(".")[0] in LIBRARIES for module in modules):
            return True
    return False


def called(node: ast.Call) -> str:
    """Return the last part of the name of a called function."""
    if isinstance(node.func, ast.Attribute):
        return node.func.attr
    return node.func.id if isinstance(node.func, ast.Name) else ""


def is_changed(node: ast.Attribute) -> bool:
    of_geometry = isinstance(node.value, ast.Attribute) and node.value.attr == "geometry"
    return node.attr in CHANGED_ATTRIBUTES or (node.attr == "dofmap" and of_geometry)


def catches_probing(node: ast.Try) -> bool:
    """Whether the errors that a missing name or argument raises are caught."""
    for handler in node.handlers:
        if handler.type is None:
            return True
        caught = {each.id for each in ast.walk(handler.type) if isinstance(each, ast.Name)}
        if caught & (PROBING_ERRORS | {"Exception"}):
            return True
    return False


def offends(node: ast.AST, names: set[str]) -> bool:
    """Whether a piece of source asks for a version, or uses what only some versions have."""
    if isinstance(node, ast.Attribute):
        asks = node.attr in VERSION_ATTRIBUTES and mentions(node.value, names | {"_compat"})
        return asks or is_changed(node)
    if isinstance(node, ast.alias):
        return node.name in VERSION_ATTRIBUTES
    if isinstance(node, ast.Call):
        name, arguments = called(node), len(node.args) + len(node.keywords)
        if name in PROBING_ARGUMENTS and arguments == PROBING_ARGUMENTS[name]:
            return mentions(node.args[0], names)
        return name in SHARED_ARGUMENTS and arguments > SHARED_ARGUMENTS[name]
    if isinstance(node, ast.Try):
        return catches_probing(node) and any(mentions(each, names) for each in node.body)
    return False


def offences(source: str) -> list[str]:
    """Return the pieces of a source that only fretfe.fem._compat may have."""
    tree = ast.parse(source)
    names = names_of_libraries(tree)
    return [ast.unparse(node) for node in ast.walk(tree) if offends(node, names)]


def test_nothing_else_looks_at_versions() -> None:
    found = {str(path): offences(path.read_text("utf-8")) for path in SOURCES}
    assert {path: pieces for path, pieces in found.items() if pieces} == {}


@pytest.mark.parametrize(
    "source",
    [
        "import dolfinx\nif dolfinx.__version__ > '0.10': pass",
        "from dolfinx import __version__",
        "from fretfe.fem._compat import VERSION",
        "from fretfe.fem import _compat\nnew = _compat.VERSION > (0, 9)",
        "from fretfe.fem._compat import PETSc\nPETSc.Sys.getVersion()",
        "from dolfinx import fem\nhasattr(fem, 'interpolate')",
        "from dolfinx import fem\ngetattr(fem.Function, 'eval', None)",
        "import inspect\nfrom dolfinx.fem import Function\ninspect.signature(Function.eval)",
        "try:\n    from dolfinx.io import gmsh\nexcept ImportError:\n    gmsh = None",
        "from dolfinx import mesh\ntry:\n    mesh.refine(1)\nexcept (TypeError, OSError): pass",
        "import ufl\ntry:\n    ufl.Mesh()\nexcept Exception:\n    pass",
        "points = space.element.interpolation_points()",
        "nodes = mesh.geometry.dofmap",
        "fem.form(energy, entity_maps=maps)",
        "functionspace(mesh, element, options)",
    ],
)
def test_the_rule_catches(source: str) -> None:
    assert len(offences(source)) == 1


@pytest.mark.parametrize(
    "source",
    [
        "import dolfinx\nfrom dolfinx import fem\nfem.functionspace(mesh, ('DG', 1))",
        "try:\n    import gmsh\nexcept ImportError:\n    pass",
        "dofs = space.dofmap.index_map",
        "import numpy\nnumpy.__version__",
    ],
)
def test_the_rule_allows(source: str) -> None:
    assert offences(source) == []
