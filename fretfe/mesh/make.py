# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a Gmsh model or a mesh file to one mesh per body, checked, and back; its expected size."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Set
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from fretfe.environment import machine_memory
from fretfe.errors import MeshError, OutputError
from fretfe.files import cut_off, replacing, require_file, writing
from fretfe.mesh.contained import MESHING, raw_mesh_of
from fretfe.mesh.elements import FACET_SHAPES, NUMBERS
from fretfe.mesh.gmsh import RawMesh, gmsh_model, link_to, raw_mesh, script_model
from fretfe.mesh.templates import Template

# Not loaded by the process that reads a file and no more: it reads no cases.
if TYPE_CHECKING:
    from fretfe.mesh.mesh import BodyMesh, Mesh

# The size of a model over its smallest elements up to which there are not many, in the plane and in
# space.
HARMLESS = {2: 1e5, 3: 5e2}
# The same up to which lines along the curves of a template are counted at once.
FEW_LINES = 1e7
# More elements than any case needs.
MOST_ELEMENTS = 5e6
# Factors of all element sizes: for a first look at the curves, and for meshes that become finer.
FIRST = 4096.0
COARSE = 256.0
STEP = 4.0
FINEST = 4.0
# Elements along all curves that a coarse mesh may have; cells from which their number tells enough.
ALONG_CURVES = 2000
ENOUGH = 5000
# Cells of a mesh over those of one that is coarser by a step, from which their sizes count.
GROWING = 1.5
# Equilateral triangles on the square of their side.
PER_SQUARE = 4 / math.sqrt(3)
FACTOR = "Mesh.MeshSizeFactor"
# End of a file of Gmsh.
LAST = b"$EndElements\n"
# Sets the element sizes of the current Gmsh model.
SetSizes = Callable[[ModuleType], None]
# Growth of the element size per distance from fine curves, where no other one is known.
GROWTH = 0.2
# Opens a Gmsh model, and closes it.
OpenModel = Callable[[], AbstractContextManager[ModuleType]]


def require_room(gmsh: ModuleType, source: str, smallest: float, growth: float) -> None:
    """Check that the mesh of the current model is not larger than this machine can solve.

    Args:
        gmsh: the library, with a model whose element sizes are set.
        source: file or template, for messages.
        smallest: size of the smallest elements; 0 if that is not known.
        growth: of the size per distance from fine curves.

    Raises:
        MeshError: with an estimate of elements and memory, before the mesh is made.
    """
    from fretfe.mesh.cost import MATRICES, least_memory

    low_high = gmsh.model.getBoundingBox(-1, -1)
    extent = math.dist(low_high[:3], low_high[3:])
    dimension = gmsh.model.getDimension()
    if extent <= HARMLESS[dimension] * smallest or gmsh.model.mesh.getElementTypes().size:
        return
    memory, few = machine_memory(), dimension == 2 and extent <= FEW_LINES * smallest
    elements, lines = _most_in_rows(gmsh, growth) if few else (math.inf, 0.0)
    # Contact surfaces have the finest lines; their tractions need full matrices.
    dense = 8.0 * MATRICES[2] * (2 * lines) ** 2

    def fits() -> bool:
        needed = least_memory(elements, dimension) + dense
        return elements <= MOST_ELEMENTS and needed <= (memory or math.inf)

    # Meshes of templates grow from their curves, whose lines take a tenth of the time of triangles.
    if not fits() and dense <= (memory or math.inf):
        elements = expected_elements(gmsh, growth)
    if not fits():
        there = f" (there are {memory / 2**30:.0f} GB)" if memory else ""
        needed = (least_memory(elements, dimension) + dense) / 2**30
        along = f", {lines:.1g} of them along a contact" if dense > (memory or math.inf) else ""
        raise MeshError(
            f"{source}: expected at most {MOST_ELEMENTS:.0e} elements that this machine can solve, "
            f"found sizes that would make about {elements:.1g}{along}, which take {needed:.0f} GB "
            f"of memory or more{there}: make the elements larger, or let them grow faster away "
            "from the contact. Nothing was meshed"
        )


def _most_in_rows(gmsh: ModuleType, growth: float) -> tuple[float, float]:
    """Most triangles of a mesh whose sizes grow from those along its curves, by their lines alone.

    Sizes that are some times as large make as many times fewer lines, in whole numbers.

    Returns:
        Triangles, and the lines of the boundary that has most of them.
    """
    before = gmsh.option.getNumber(FACTOR)
    lines = _count(gmsh, 1, COARSE * before)
    longest = 0.0
    for _, group in gmsh.model.getPhysicalGroups(1):
        curves = gmsh.model.getEntitiesForPhysicalGroup(1, group)
        counts = (sum(map(len, gmsh.model.mesh.getElements(1, curve)[1])) for curve in curves)
        # A curve has a line at least, however short it is.
        longest = max(longest, COARSE * sum(count - 1 for count in counts))
    gmsh.option.setNumber(FACTOR, before)
    gmsh.model.mesh.clear()
    return COARSE * lines * PER_SQUARE / growth, longest


def expected_elements(gmsh: ModuleType, growth: float) -> float:
    """Number of cells of the mesh to come; 0 for one that is small, or that coarse meshes fail for.

    Args:
        gmsh: the library, with a model whose element sizes are set.
        growth: of the size per distance from fine curves, as these need many rows of triangles.
    """
    dimension = gmsh.model.getDimension()
    before = gmsh.option.getNumber(FACTOR)
    try:
        curves = len(gmsh.model.getEntities(1))
        along = FIRST * max(_count(gmsh, 1, FIRST * before) - curves, 0)
        # sizes s + g d over a line of length l: the integral of 1/h² over the area is l/(s g)
        in_rows = along * PER_SQUARE / growth if dimension == 2 else 0.0
        if in_rows > MOST_ELEMENTS:
            return in_rows
        factor = max(COARSE, along / ALONG_CURVES)
        coarser = _count(gmsh, dimension, STEP * factor * before)
        found = _count(gmsh, dimension, factor * before)
        # Layers of swept bodies, and lines that are counted, are the same whatever the sizes.
        while factor > FINEST and (found < ENOUGH or found < GROWING * coarser):
            factor /= STEP
            coarser, found = found, _count(gmsh, dimension, factor * before)
        if found < ENOUGH:
            return 0.0
    except Exception:
        # Gmsh raises nothing more special. Quadrilaterals, for instance, need even numbers of sides
        # along each curve, which coarse meshes may not have.
        return 0.0
    finally:
        gmsh.option.setNumber(FACTOR, before)
        gmsh.model.mesh.clear()
    power = math.log(found / max(coarser, 1)) / math.log(STEP)
    return max(in_rows, float(found * factor ** min(max(power, 1.0), dimension)))


def _count(gmsh: ModuleType, dimension: int, factor: float) -> int:
    """Cells of a dimension in a mesh whose sizes are multiplied by a factor."""
    gmsh.model.mesh.clear()
    gmsh.option.setNumber(FACTOR, factor)
    gmsh.model.mesh.generate(dimension)
    return sum(len(tags) for tags in gmsh.model.mesh.getElements(dimension)[1])


def read_mesh(
    path: str | os.PathLike[str], merge: float | None = None, tied: Set[str] = frozenset()
) -> Mesh:
    """Read a Gmsh file (.msh, format 2.2 or 4.1) whose physical groups have names.

    Args:
        path: of the file.
        merge: distance up to which nodes of a body become one; None merges none.
        tied: boundaries at which bodies hang together although they have no common nodes.

    Raises:
        MeshError: The file is missing or unreadable, or the mesh in it is not a set of separate
            plane or solid bodies with valid elements.
    """
    path = Path(path)
    _require_gmsh_file(path)
    raw = raw_mesh_of(partial(_merged, path), path)
    return _split(raw, str(path), merge, mergeable=True, tied=tied)


def mesh_template(
    template: Template,
    parameters: Mapping[str, float],
    order: int,
    size: SetSizes | None = None,
) -> Mesh:
    """Mesh a geometry template with elements of order 1 or 2 (curved edges).

    Args:
        template: What to mesh.
        parameters: Values that differ from the defaults of the template.
        order: Polynomial order of the elements.
        size: Sets element sizes in place of those of the template, or changes them.

    Raises:
        CaseError: A parameter is unknown, out of range or at odds with another.
        MeshError: Gmsh cannot mesh the geometry, or the mesh is not valid.
    """
    model = partial(script_model, template, parameters)
    known = {each.name: each.default for each in template.parameters} | {**parameters}
    smallest = min(known[each.name] for each in template.parameters if each.is_size)
    what = f"template '{template.name}'"
    # A plane mesh that refines itself begins with few elements, and counts them.
    smallest = smallest if size is None or template.solid else math.inf
    fineness = smallest, known["growth"]
    raw = _meshed(model, what, order, size, fineness, lambda: None)
    return _split(raw, what)


def mesh_script(
    template: Template, parameters: Mapping[str, float], order: int, size: SetSizes | None
) -> Mesh:
    """Mesh a Gmsh script of the user in a process of its own, which the script may end.

    Arguments and errors are those of `mesh_template`.
    """
    model = partial(script_model, template, parameters)
    work = partial(_meshed, model, str(template.path), order, size, (0.0, GROWTH))
    # A script may build, and mesh, for long.
    return _split(raw_mesh_of(work, template.path, MESHING), str(template.path))


def mesh_model(model: OpenModel, path: Path, order: int, size: SetSizes, smallest: float) -> Mesh:
    """Mesh the model of a file in a process of its own; its physical groups have names.

    Args:
        model: Opens and closes the model.
        path: File that it comes from.
        order: Polynomial order of the elements.
        size: Sets element sizes.
        smallest: Size of the smallest elements; infinite if it is known that there are not many.

    Raises:
        MeshError: Gmsh cannot mesh the geometry, or the mesh is not valid.
    """
    raw = raw_mesh_of(partial(_meshed, model, str(path), order, size, (smallest, GROWTH)), path)
    return _split(raw, str(path))


def _split(
    raw: RawMesh,
    source: str,
    merge: float | None = None,
    *,
    mergeable: bool = False,
    tied: Set[str] = frozenset(),
) -> Mesh:
    # Not loaded by the process that reads a file and no more: SciPy takes as long as that.
    from fretfe.mesh.split import mesh_from_raw

    return mesh_from_raw(raw, source, merge, mergeable=mergeable, tied=tied)


def _meshed(
    model: OpenModel,
    source: str,
    order: int,
    size: SetSizes | None,
    fineness: tuple[float, float],
    opened: Callable[[], None],
) -> RawMesh:
    """The mesh of a model, if it is not too large by its smallest elements and their growth."""
    with model() as gmsh:
        opened()
        if size is not None:
            size(gmsh)
        require_room(gmsh, source, *fineness)
        gmsh.model.mesh.generate(gmsh.model.getDimension())
        gmsh.model.mesh.setOrder(order)
        return raw_mesh(gmsh, Path(source))


def _merged(path: Path, opened: Callable[[], None]) -> RawMesh:
    with gmsh_model(path) as gmsh:
        with link_to(path) as link:
            gmsh.merge(str(link))
        opened()
        return raw_mesh(gmsh, path)


def _require_gmsh_file(path: Path) -> None:
    """Gmsh executes a file that is not a mesh as a script: only a mesh may get that far."""
    require_file(path, "a mesh file", MeshError)
    try:
        with path.open("rb") as file:
            start = file.read(200)
    except OSError as error:
        raise MeshError(f"{path}: cannot read the mesh file: {error.strerror}") from error
    if not start.lstrip().startswith((b"$MeshFormat", b"$Comments")):
        deck = start.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"*")
        raise MeshError(
            f"{path}: expected a Gmsh mesh file (.msh) that starts with $MeshFormat,"
            f" found {start[:20]!r}"
            + (
                "; this is an input file of Abaqus or CalculiX, which CalculiX GraphiX calls .msh:"
                " give it a name that ends in .inp"
                if deck
                else ""
            )
        )


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write a `.msh` file that `read_mesh` reads back.

    Raises:
        OutputError: if the file does not end in .msh or cannot be written.
    """
    if path.suffix != ".msh":
        raise OutputError(f"{path}: expected a mesh file that ends in .msh, found {path.suffix!r}")
    with writing(path, "the mesh"):
        with replacing(path, path.suffix) as new:
            _write(mesh, new)


def _write(mesh: Mesh, new: Path) -> None:
    """Write a file.

    Raises:
        OSError: if it cannot be written, of which Gmsh says nothing.
    """
    with gmsh_model(new) as gmsh:
        first_node = 1
        facet_dimension, boundary = mesh.dimension - 1, 1
        for entity, body in enumerate(mesh.bodies.values(), start=1):
            _add_body(gmsh, body, entity, first_node)
            for name, facets in body.boundaries.items():
                gmsh.model.addDiscreteEntity(facet_dimension, boundary, [])
                gmsh.model.mesh.addElementsByType(
                    boundary,
                    NUMBERS[FACET_SHAPES[body.cell], body.order],
                    [],
                    (facets + first_node).ravel(),
                )
                gmsh.model.addPhysicalGroup(facet_dimension, [boundary], name=name)
                boundary += 1
            first_node += len(body.points)
        gmsh.write(str(new))
        with new.open("rb") as file:
            file.seek(max(new.stat().st_size - len(LAST), 0))
            if file.read() != LAST:
                raise cut_off(new)


def _add_body(gmsh: Any, body: BodyMesh, entity: int, first_node: int) -> None:
    """Nodes and cells of one body as a discrete surface or volume with its name."""
    dimension = body.points.shape[1]
    gmsh.model.addDiscreteEntity(dimension, entity, [])
    points = np.zeros((len(body.points), 3))
    points[:, :dimension] = body.points
    tags = np.arange(first_node, first_node + len(points))
    gmsh.model.mesh.addNodes(dimension, entity, tags, points.ravel())
    number = NUMBERS[body.cell, body.order]
    cells = (body.cells + first_node).ravel()
    gmsh.model.mesh.addElementsByType(entity, number, [], cells)
    gmsh.model.addPhysicalGroup(dimension, [entity], name=body.name)
