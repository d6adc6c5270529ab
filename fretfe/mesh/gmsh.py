# SPDX-License-Identifier: LGPL-3.0-or-later
"""The Gmsh session: its library, and the groups, nodes and elements of its model."""

from __future__ import annotations

import contextlib
import importlib.util
import re
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Indices
from fretfe.environment import memory_shortage
from fretfe.errors import DependencyError, MeshError
from fretfe.libraries import elsewhere
from fretfe.mesh.templates import Template, check_parameters, parameter_error

# What Gmsh's library takes from Python, and what PETSc would.
TAKEN_SIGNALS = frozenset(
    {signal.SIGHUP, signal.SIGINT, signal.SIGPIPE, signal.SIGQUIT, signal.SIGTERM}
)
# Debian and Ubuntu package of each library that libgmsh.so of the wheel needs and a small image may
# lack.
PACKAGES = {
    "libGL.so.1": "libgl1",
    "libGLU.so.1": "libglu1-mesa",
    "libX11.so.6": "libx11-6",
    "libXcursor.so.1": "libxcursor1",
    "libXext.so.6": "libxext6",
    "libXfixes.so.3": "libxfixes3",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libXrender.so.1": "libxrender1",
    "libfontconfig.so.1": "libfontconfig1",
    "libgomp.so.1": "libgomp1",
}
# What the loader says of a library that is not there.
NOT_THERE = re.compile(r"^(lib\S+\.so\S*): cannot open shared object file")
# Gmsh's own build without windows, which needs no X libraries.
WITHOUT_ROOT = (
    "-m pip install --force-reinstall --no-deps -i https://gmsh.info/python-packages-dev-nox gmsh"
)
# What Gmsh calls the groups of bodies and of boundaries, by dimension of the mesh.
BODY_KINDS = {2: "surface", 3: "volume"}
BOUNDARY_KINDS = {2: "curve", 3: "surface"}


def import_gmsh() -> ModuleType:
    """Import gmsh.

    Raises:
        DependencyError: gmsh is not installed, or does not load; all shared libraries that it lacks
            are named.
        MemoryError: there is no room for a library.
    """
    try:
        import gmsh
    except (ImportError, OSError) as error:
        if memory_shortage(error):
            raise MemoryError from error
        if isinstance(error, OSError):
            raise DependencyError(_remedy(error)) from error
        raise DependencyError(
            f"reading and making meshes needs the Python package gmsh, which does not import"
            f" ({error}). Install it with `pip install gmsh` or from your distribution (Debian:"
            " python3-gmsh)"
        ) from error
    return gmsh


def missing_libraries(library: Path) -> list[str]:
    """Names of the shared libraries that a library needs and the dynamic linker does not find."""
    try:
        listing = subprocess.run(["ldd", library], capture_output=True, text=True, check=False)
    except OSError:  # a system without ldd
        return []
    return sorted(set(re.findall(r"^\s*(\S+) => not found", listing.stdout, re.MULTILINE)))


def _gmsh_libraries() -> list[Path]:
    """Gmsh's library beside its Python module: pip puts it two folders above, conda may not."""
    spec = importlib.util.find_spec("gmsh")
    if spec is None or spec.origin is None:
        return []
    above = list(Path(spec.origin).resolve().parents)[:3]
    folders = [folder / sub for folder in above for sub in (".", "lib")]
    return [path for folder in folders for path in folder.glob("libgmsh.so*")]


def _remedy(error: OSError) -> str:
    """All that Gmsh lacks, and the commands that bring it."""
    missing = [name for library in _gmsh_libraries() for name in missing_libraries(library)]
    # The loader stops at the first one.
    missing = sorted({*missing, *NOT_THERE.findall(str(error))})
    if not missing:
        return f"gmsh is installed but does not load ({error}). Install it anew"
    known = [PACKAGES[name] for name in missing if name in PACKAGES]
    unknown = [f"the package that has {name}" for name in missing if name not in PACKAGES]
    packages = " and ".join(filter(None, [" ".join(known), *unknown]))
    return (
        f"gmsh is installed but needs shared libraries that were not found: {', '.join(missing)}.\n"
        f"Debian, Ubuntu:  apt install {packages}\n"
        f"Without root:    {sys.executable} {WITHOUT_ROOT}"
    )


@dataclass(frozen=True)
class ElementBlock:
    """Elements of one Gmsh type: indices (m, k) into the points of the mesh, in Gmsh order."""

    gmsh_type: int
    nodes: Indices


@dataclass(frozen=True)
class RawMesh:
    """Contents of a mesh file or of a Gmsh model.

    Attributes:
        points: (n, 3) coordinates.
        dimension: 2 where the bodies are plane, 3 where they are solid.
        bodies: their cells, by name.
        boundaries: lines along plane bodies or facets of solid ones, by name.
        notes: what in the file was not used, in words.
    """

    points: Array
    dimension: int
    bodies: dict[str, list[ElementBlock]]
    boundaries: dict[str, list[ElementBlock]]
    notes: tuple[str, ...] = ()


@contextlib.contextmanager
def _kept_signals() -> Iterator[None]:
    """Leave signals to those who handle or ignore them: Gmsh's library takes them away."""
    if threading.current_thread() is not threading.main_thread():  # no other may set a handler
        yield
        return
    before = {each: signal.getsignal(each) for each in TAKEN_SIGNALS}
    yield
    for number, handler in before.items():
        if handler is not None:  # set from Python
            signal.signal(number, handler)


@contextlib.contextmanager
def gmsh_model(source: Path) -> Iterator[ModuleType]:
    """An empty Gmsh model for `source`; what another user of Gmsh in this process had stays.

    Gmsh errors inside the block are raised as MeshError.
    """
    with elsewhere(home=True):  # Gmsh has a PETSc of its own
        gmsh = import_gmsh()
        owner = not gmsh.isInitialized()
        if owner:
            with _kept_signals():
                # no configuration files: the mesh must not depend on the user's Gmsh GUI settings
                gmsh.initialize([], readConfigFiles=False, interruptible=False)
    previous_model = "" if owner else gmsh.model.getCurrent()
    previous_terminal = gmsh.option.getNumber("General.Terminal")
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        gmsh.model.add(f"fretfe {source.name}")
        yield gmsh
    except UnicodeDecodeError as error:
        raise MeshError(
            f"{source}: expected names of groups and parts in UTF-8, found {error.object!r}, as in "
            "a file that was saved with another encoding (latin-1); save it as UTF-8"
        ) from error
    except Exception as error:
        # Gmsh raises bare Exception; anything more specific is a mistake of ours
        if type(error) is not Exception:
            raise
        raise MeshError(f"{source}: Gmsh reports: {error}") from error
    finally:
        if owner:
            gmsh.finalize()
        else:
            gmsh.model.remove()
            gmsh.model.setCurrent(previous_model)
            gmsh.option.setNumber("General.Terminal", previous_terminal)


@contextlib.contextmanager
def link_to(path: Path) -> Iterator[Path]:
    """A link to a file, without the file of options beside it, which Gmsh would execute.

    Meanwhile OpenCASCADE finds no settings in the working folder.
    """
    with tempfile.TemporaryDirectory(prefix="fretfe-") as folder:
        link = Path(folder, path.name)
        link.symlink_to(path.absolute())
        with elsewhere():
            yield link


@contextlib.contextmanager
def script_model(template: Template, parameters: Mapping[str, float]) -> Iterator[ModuleType]:
    """The model that a Gmsh script (.geo) describes.

    Args:
        template: the script; one of fretfe's or one of the user's.
        parameters: values that differ from the defaults of the script.

    Raises:
        CaseError: a parameter is unknown or out of range, or the script itself says, with
            `Error("NAME: ...")`, that the parameters do not fit together.
        MeshError: any other error of Gmsh, here or inside the block.
    """
    values = check_parameters(template, parameters)
    with gmsh_model(template.path) as gmsh:
        # all parameters, defaults too: what an earlier script left in this process does not count
        for name, value in values.items():
            gmsh.parser.setNumber(name, [value])
        errors = _merge(gmsh, template.path)
        if wrong := [error for error in errors if error.partition(":")[0] in values]:
            raise parameter_error(template, wrong)
        if errors:
            raise MeshError(f"{template.path}: Gmsh reports: {errors[0]}")
        yield gmsh


def _merge(gmsh: ModuleType, script: Path) -> list[str]:
    """Read a script to its end, past errors, and return the errors."""
    wanted = {"General.AbortOnError": 0, "General.Verbosity": 1}
    before = {option: gmsh.option.getNumber(option) for option in wanted}
    for option, value in wanted.items():
        gmsh.option.setNumber(option, value)
    gmsh.logger.start()
    known = len(gmsh.logger.get())
    try:
        # merge, not open: open forgets the numbers that were set
        gmsh.merge(str(script))
        messages = gmsh.logger.get()[known:]
    finally:
        gmsh.logger.stop()
        for option, value in before.items():
            gmsh.option.setNumber(option, value)
    return [text.removeprefix("Error: ") for text in messages if text.startswith("Error: ")]


def tags_of_groups(gmsh: ModuleType, dim: int) -> dict[str, list[int]]:
    """Entities of a dimension in each named physical group of the current model."""
    tags: dict[str, list[int]] = {}
    for _, group in gmsh.model.getPhysicalGroups(dim):
        own = gmsh.model.getEntitiesForPhysicalGroup(dim, group)
        tags.setdefault(gmsh.model.getPhysicalName(dim, group), []).extend(map(int, own))
    return tags


def raw_mesh(gmsh: ModuleType, source: Path) -> RawMesh:
    """The named physical groups of the current model, with their nodes and elements.

    A model with volume elements is one of solid bodies; its surfaces are boundaries.

    Raises:
        MeshError: surfaces, or volumes where there are any, without a named physical group.
    """
    dimension = 3 if gmsh.model.mesh.getElementTypes(3).size else 2
    _require_named_bodies(gmsh, dimension, source)
    for dim in (dimension, dimension - 1):
        _require_names_once(gmsh, dim, source)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags, kind="stable")
    return RawMesh(
        points=coordinates.reshape(-1, 3)[order],
        dimension=dimension,
        bodies=_blocks_by_name(gmsh, dimension, tags[order]),
        boundaries=_blocks_by_name(gmsh, dimension - 1, tags[order]),
    )


def _require_named_bodies(gmsh: ModuleType, dim: int, source: Path) -> None:
    """Every surface, or volume, that is meshed must be in a physical group that has a name."""
    what = BODY_KINDS[dim]
    named = {
        entity
        for _, group in gmsh.model.getPhysicalGroups(dim)
        if gmsh.model.getPhysicalName(dim, group)
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, group)
    }
    if not named:
        raise MeshError(
            f"{source}: expected one named physical {what} per body, found none."
            f' In a .geo file: Physical {what.capitalize()}("pad") = {{1}};'
        )
    meshed = {
        tag
        for _, tag in gmsh.model.getEntities(dim)
        if gmsh.model.mesh.getElementTypes(dim, tag).size
    }
    if loose := sorted(meshed - named):
        raise MeshError(
            f"{source}: expected every meshed {what} in a named physical {what};"
            f" {what} {', '.join(map(str, loose))} is in none"
        )


def _require_names_once(gmsh: ModuleType, dim: int, source: Path) -> None:
    """Groups of the same name may be meant as one, or be a slip."""
    groups = gmsh.model.getPhysicalGroups(dim)
    names = [name for _, group in groups if (name := gmsh.model.getPhysicalName(dim, group))]
    kinds = {1: "curve", 2: "surface", 3: "volume"}
    if twice := [name for name in dict.fromkeys(names) if names.count(name) > 1]:
        raise MeshError(
            f"{source}: expected one physical {kinds[dim]} of each name, found "
            f"{names.count(twice[0])} called '{twice[0]}'; give others other names, or make them "
            "one group"
        )


def _blocks_by_name(
    gmsh: ModuleType, dim: int, sorted_tags: NDArray[np.uint64]
) -> dict[str, list[ElementBlock]]:
    """Elements of each named physical group."""
    blocks: dict[str, list[ElementBlock]] = {}
    for _, group in gmsh.model.getPhysicalGroups(dim):
        name = gmsh.model.getPhysicalName(dim, group)
        if not name:
            continue
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, group):
            blocks.setdefault(name, []).extend(_entity_blocks(gmsh, dim, entity, sorted_tags))
    return {name: parts for name, parts in blocks.items() if parts}


def _entity_blocks(
    gmsh: ModuleType, dim: int, entity: int, sorted_tags: NDArray[np.uint64]
) -> list[ElementBlock]:
    types, _, node_tags = gmsh.model.mesh.getElements(dim, entity)
    counts = [gmsh.model.mesh.getElementProperties(kind)[3] for kind in types]
    return [
        ElementBlock(int(kind), np.searchsorted(sorted_tags, tags).reshape(-1, count))
        for kind, tags, count in zip(types, node_tags, counts, strict=True)
    ]
