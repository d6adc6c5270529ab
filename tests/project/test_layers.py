# SPDX-License-Identifier: LGPL-3.0-or-later
"""Data flows one way: a module imports only what stands before it, and only fem knows DOLFINx."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import fretfe
from fretfe.bodies.loads.kinds import SPREAD
from fretfe.bodies.loads.spread import SpreadLoad
from fretfe.case.loads import KINDS

# In the order of the data. A new module has to be given its place here. The modules of a package
# that ends in ".*" may import one another.
LAYERS = (
    "fretfe",
    "fretfe.errors",
    "fretfe.results",
    "fretfe.files",
    "fretfe.results.run_folder",
    "fretfe.libraries",
    "fretfe.environment",
    "fretfe.plugins",
    "fretfe.faults",
    "fretfe.reason",
    "fretfe.caution",
    "fretfe.verdict",
    "fretfe.terminal",
    "fretfe.console",
    "fretfe._core",
    "fretfe._typing",
    "fretfe.report",
    "fretfe.report.texts",
    "fretfe.analytic.*",
    "fretfe.materials",
    "fretfe.materials.crystals",
    "fretfe.mesh.inp_language",
    "fretfe.mesh.inp_cards",
    "fretfe.mesh.inp",
    "fretfe.case.*",
    "fretfe.materials.*",
    "fretfe.loads.*",
    "fretfe.mesh.*",
    "fretfe.surface.*",
    "fretfe.idealise.*",
    "fretfe.local.*",
    "fretfe.history.*",
    "fretfe.contact.*",
    "fretfe.evaluate.*",
    "fretfe.results.*",
    "fretfe.fields.*",
    "fretfe.halfplane.*",
    "fretfe.bodies.*",
    "fretfe.backends.*",
    "fretfe.fem.*",
    "fretfe.quality.*",
    "fretfe.report.*",
    "fretfe.exchange.*",
    "fretfe.strength.*",
    "fretfe.decision.*",
    "fretfe.sweeps.*",
    "fretfe.work",
    "fretfe.runner",
    "fretfe.checked",
    "fretfe.matching.*",
    "fretfe.api",
    "fretfe.cli.*",
    "fretfe.__main__",
)
FEM_ONLY = {
    "basix", "dolfinx", "dolfinx_solver", "ffcx", "mpi4py", "petsc4py", "slepc4py", "ufl"
}  # fmt: skip
# A smaller module that one other imports belongs into that.
FEWEST_LINES = 60
ROOT = Path(fretfe.__file__).parent


def module_name(path: Path) -> str:
    parts = ("fretfe", *path.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in sorted(ROOT.rglob("*.py"))}
OUTSIDE_FEM = [name for name in MODULES if not f"{name}.".startswith("fretfe.fem.")]


def layer(module: str) -> int:
    """Return the place of a module in LAYERS; -1 if it has none."""
    places = [
        place
        for place, entry in enumerate(LAYERS)
        if module == entry or (entry.endswith(".*") and f"{module}.".startswith(entry[:-1]))
    ]
    return places[0] if places else -1


@cache
def imported(source: str) -> set[str]:
    """Return the full names of all modules that a source imports, inside functions too."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            package = node.module or ""
            members = {f"{package}.{alias.name}" for alias in node.names}
            submodules = {name for name in members if name in MODULES}
            # `from package import submodule` depends on the submodule, not on what follows it.
            names.update(submodules if submodules == members else submodules | {package})
    return names


def wrong_imports(module: str, source: str) -> set[str]:
    """Return what a module of the package imports from it although it stands at or behind it."""
    place = layer(module)
    free = LAYERS[place].endswith(".*")
    own = {name for name in imported(source) if name.split(".")[0] == "fretfe"}
    if module == "fretfe":  # for those who check types; nothing of it is imported when it runs
        own -= {"fretfe.api"}
    return {name for name in own if not (-1 < layer(name) < place + free)}


def fem_packages(source: str) -> set[str]:
    """Return the packages that only fem may import and this source does."""
    return {name.split(".")[0] for name in imported(source)} & FEM_ONLY


def imported_on_loading(source: str) -> set[str]:
    """Return the modules of fretfe that a source imports when it is loaded."""
    tree = ast.parse(source)
    top: list[ast.stmt] = [
        node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    return imported(ast.unparse(ast.Module(top, []))) & MODULES.keys()


def code_lines(source: str) -> int:
    """Return how many lines have code: no docstrings, comments, blanks or imports."""
    left_out: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        docstring = None
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            docstring = node.body[0] if ast.get_docstring(node) is not None else None
        for each in (docstring, node if isinstance(node, ast.Import | ast.ImportFrom) else None):
            if each is not None:
                left_out |= set(range(each.lineno, (each.end_lineno or each.lineno) + 1))
    lines = enumerate(source.splitlines(), start=1)
    return sum(
        bool(text.strip()) and not text.strip().startswith("#") and number not in left_out
        for number, text in lines
    )


def test_no_modules_import_one_another() -> None:
    graph = {
        name: {
            other
            for other in imported_on_loading(path.read_text("utf-8"))
            if not f"{name}.".startswith(f"{other}.")
        }
        for name, path in MODULES.items()
    }
    TopologicalSorter(graph).prepare()


def importers(module: str) -> set[str]:
    return {name for name, path in MODULES.items() if module in imported(path.read_text("utf-8"))}


def test_no_small_module_for_one_other() -> None:
    small = [
        name
        for name, path in MODULES.items()
        if path.stem != "__init__" and len(path.read_text("utf-8").splitlines()) < FEWEST_LINES
    ]
    assert [name for name in small if len(importers(name) - {"fretfe"}) == 1] == []


RIDDLES = re.compile(r'"""(What|How|Where|Whether|Why) ')


# A kind of load is looked at by its class only where it is made; all others ask the load.
OF_LOADS = ("fretfe.case.", "fretfe.bodies.loads.")


def looks_at_loads(source: str, kinds: set[str]) -> bool:
    """Return whether a source branches on the class of a load, or on its type in the case file."""
    for node in ast.walk(ast.parse(source)):
        called = isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "type")
        if called and kinds & {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}:
            return True
        if isinstance(node, ast.MatchClass) and ast.unparse(node.cls) in kinds:
            return True
        if isinstance(node, ast.Compare) and ast.unparse(node.left) in ("load.type", "load.kind"):
            return True
    return False


def test_only_loads_look_at_the_kinds_of_loads() -> None:
    kinds = {"SpreadLoad", "Load"} | {kind.__name__ for kind in KINDS}
    kinds |= {each.__name__ for each in SpreadLoad.__subclasses__()}
    others = [name for name in MODULES if not f"{name}.".startswith(OF_LOADS)]
    looking = [name for name in others if looks_at_loads(MODULES[name].read_text("utf-8"), kinds)]
    assert looking == []


def test_a_look_at_the_kind_of_a_load_is_found() -> None:
    kinds = {"FieldLoad"}
    assert looks_at_loads("if isinstance(each, int | FieldLoad): pass", kinds)
    assert looks_at_loads("match load:\n case FieldLoad(): pass", kinds)
    assert looks_at_loads("if load.type == 'field': pass", kinds)
    assert not looks_at_loads("isinstance(each, int)\nload: FieldLoad = each", kinds)


def test_every_kind_of_load_acts_on_bodies_in_one_way() -> None:
    moving = {kind for kind in KINDS if kind.moves or kind.rigid}
    assert moving | set(SPREAD) == set(KINDS) and not moving & set(SPREAD)


def test_no_docstring_opens_with_a_question() -> None:
    found = {name: RIDDLES.findall(path.read_text("utf-8")) for name, path in MODULES.items()}
    assert [name for name, riddles in found.items() if riddles] == []


def test_a_circle_and_lines_are_found() -> None:
    source = '"""Doc."""\n\nimport numpy\n\n# why\ndef f():\n    """Doc."""\n    return 1\n'
    assert code_lines(source) == 2
    assert imported_on_loading("from fretfe.errors import A\ndef f():\n import fretfe.case") == {
        "fretfe.errors"
    }


def test_every_module_has_a_place() -> None:
    assert [name for name in MODULES if layer(name) < 0] == []


def test_imports_only_what_stands_before() -> None:
    wrong = {name: wrong_imports(name, path.read_text("utf-8")) for name, path in MODULES.items()}
    assert {name: sorted(found) for name, found in wrong.items() if found} == {}


@pytest.mark.parametrize(
    ("module", "source", "wrong"),
    [
        ("fretfe.errors", "import fretfe.case", {"fretfe.case"}),
        ("fretfe.errors", "from fretfe import errors", {"fretfe.errors"}),
        ("fretfe.case", "def f():\n    from fretfe.cli.app import main", {"fretfe.cli.app"}),
        ("fretfe.case", "from fretfe.unplaced import name", {"fretfe.unplaced"}),
        ("fretfe.case", "from fretfe.errors import CaseError\nimport numpy", set()),
        ("fretfe.analytic.b", "from fretfe.analytic.a import name", set()),
        ("fretfe.analytic.b", "from fretfe.loads import History", {"fretfe.loads"}),
    ],
)
def test_the_rule_catches(module: str, source: str, wrong: set[str]) -> None:
    assert wrong_imports(module, source) == wrong


def test_only_fem_imports_dolfinx() -> None:
    wrong = {name: fem_packages(MODULES[name].read_text("utf-8")) for name in OUTSIDE_FEM}
    assert {name: sorted(found) for name, found in wrong.items() if found} == {}


def test_an_import_of_dolfinx_is_found() -> None:
    source = "import numpy, mpi4py\ndef f():\n    from dolfinx.fem import form"
    assert fem_packages(source) == {"dolfinx", "mpi4py"}


IMPORT_WITHOUT_DOLFINX = """
import importlib, sys
modules, blocked = sys.argv[1].split(","), set(sys.argv[2].split(","))
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in blocked or name == "fretfe.fem":
            raise ImportError(f"{name} is blocked in this test")
sys.meta_path.insert(0, Block())
for module in modules:
    importlib.import_module(module)
"""


def test_all_but_fem_can_be_imported_without_dolfinx() -> None:
    arguments = [",".join(OUTSIDE_FEM), ",".join(sorted(FEM_ONLY))]
    process = subprocess.run(
        [sys.executable, "-P", "-c", IMPORT_WITHOUT_DOLFINX, *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stderr
