# SPDX-License-Identifier: LGPL-3.0-or-later
"""Memory and time that a case takes, estimated from the sizes of its problems.

Measured with one thread on a 2026 server processor (AVX-512, 25 GFlop/s in dense products). In the
plane on meshes from 2 000 to 330 000 unknowns with 60 to 1 900 contact tractions: memory is right
within a third, time within a factor of two on a quiet machine of that kind. In space on pairs of
bodies of order 2 with 42 000 to 178 000 unknowns and 760 to 4 700 contact tractions (spheres, a
dovetail and a nose of tetrahedra, a skewed dovetail): memory within 20 %, processor time within
40 %. There a step takes from a tenth of what is estimated, where most nodes stick, to ten times
that, where the contact slides as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.environment import machine_memory
from fretfe.errors import ModelError
from fretfe.mesh.elements import CORNERS, FACETS, SIMPLICES
from fretfe.mesh.mesh import BodyMesh, Mesh, body_unknowns
from fretfe.mesh.shares import share_out

# Entries of a symmetric factor in the plane over the unknowns, by the binary logarithm of these.
ENTRIES = 12.0
FEWER = 90.0
FEWEST = 20.0
# Entries of a symmetric factor in space over the squares of the separators of nested dissection,
# summed over so many levels, and over the unknowns; unknowns of a separator over its corner nodes,
# for each component, by the degree of the displacements.
PER_SQUARE = 0.84
LEVELS = 6
REST = 420.0
PER_CORNER = {1: 1.0, 2: 4.0}
# The same over the unknowns to the power of 4/3 for bodies about as long as wide and high.
ENTRIES_IN_SPACE = 27.0
POWER_IN_SPACE = 4 / 3
# Bytes for an entry of a factor, those included that MUMPS needs until it is done; for an unknown's
# rows of the stiffness, mesh and spaces; for everything that does not grow.
PER_ENTRY = 10.0
PER_UNKNOWN = {2: 1200.0, 3: 2000.0}
ALWAYS = 2.7e8
# Displacements of degree 1 over elements, in large meshes of triangles and of tetrahedra; unknowns
# of meshes that fit everywhere.
UNKNOWNS_PER_ELEMENT = {2: 1.0, 3: 0.54}
FEWEST_UNKNOWNS = 1000
# Full matrices of the size of the interface that are held at the same time, of 8 bytes an entry:
# those of the steps, and dense fronts of that size, which MUMPS keeps room for beside each factor.
MATRICES = {2: 4.0, 3: 5.0}
# Part of the memory of the machine from which on factors go to disk: two ranks condense two bodies
# at the same time, each with the fronts of its own, and the system keeps the files in what is left.
IN_MEMORY = 0.5
# Part of the memory from which on it is mostly theirs.
MOST = 0.5
# With factors on disk: bytes for an unknown; the largest fronts, over the square of the unknowns of
# the last one, the contact tractions among them; full matrices in the steps.
PER_UNKNOWN_ON_DISK = {2: 1000.0, 3: 2200.0}
FRONTS = 1.6
MATRICES_ON_DISK = 4.0
# Seconds: a factor by n^1.5 in the plane and, as separators of s unknowns take s^3 operations for
# s^2 entries, by those to the power of 1.5 in space; what is done cell by cell by n, start-up and
# what does not grow.
FACTORISING = {2: 3.0e-8, 3: 1.0e-11}
ASSEMBLING = {2: 1.2e-5, 3: 5.5e-5}
STARTING = 5.0
# Seconds by powers of the number of contact tractions: a factorisation of the interface, of which a
# history needs a few; a step, its evaluation included.
INTERFACE = 3.0e-11
ORDERS = 3
STEP_SQUARED = {2: 8.0e-9, 3: 2.5e-8}
STEP = 5.0e-3
# Seconds behind the last step: for each station of a front its edge factors and local problem, and
# for each unknown besides; for each unknown and state its fields; pictures and report, and for each
# unknown.
STATION = {2: 0.0, 3: 0.12}
EDGES = {2: 4.0e-6, 3: 1.2e-6}
FIELDS = {2: 2.0e-6, 3: 6.5e-6}
DRAWING = {2: 4.0, 3: 6.0}
PICTURES = {2: 3.0e-5, 3: 4.0e-5}
# On several processes: operations of the busiest of them for a body, by their number to this power
# (measured with eight); part of the operations on full matrices that all share, and of edge
# factors, local problems and fields that bodies share.
SPREADING = -0.9
SHARED_STEPS = 0.75
SHARED_BEHIND = 0.6
# Growth of sizes within an element of a solid.
WITHIN = 0.4
# What makes a model smaller, in the plane and in space.
PROPOSALS = {
    2: "make the elements larger away from the contact edges (growth, body_size), or use "
    "model.degree = 1",
    3: "take fewer, longer layers along the edge (layers, length_size), make the elements larger "
    "away from the contact (growth), or use model.degree = 1",
}
# The same where the full matrices of the contact tractions take most of the memory.
FEWER_TRACTIONS = {
    2: "make the elements along the contact larger, or fine over a shorter part of it (edge_size, "
    "edge_zone)",
    3: "take fewer, longer layers along the edge (layers, length_size), or make the elements along "
    "the contact larger, or fine over a shorter part of it (edge_size, edge_zone)",
}
# Seconds from which on a run is long, and part of them that makes more processes worth a line.
LONG_RUN = 60.0
SAVED = 0.25


@dataclass(frozen=True)
class Amount:
    """Amount of what is solved and written with a model.

    Attributes:
        steps: of the load history, those of cycles that are likely to be added among them; those
            of one mesh if it refines itself.
        stations: of all fronts.
        states: whose fields are written.
    """

    steps: int = 0
    stations: int = 0
    states: int = 0


@dataclass(frozen=True)
class Cost:
    """Estimate of what a run takes.

    Attributes:
        unknowns: displacements of all bodies.
        tractions: unknown tractions at the contact nodes.
        steps: of the load history and of cycles that are likely to be added.
        memory: bytes, of the largest process.
        dense: those of them for the full matrices of the contact tractions.
        on_disk: whether the factors of the bodies are to be kept on disk.
        seconds: with one thread for each process, pictures and report included.
        behind: those of them behind the last step.
        dimension: 2 of a plane case, 3 of a solid one.
        stations: of all fronts, with edge factors and slip zones.
        added: steps that are in cycles which are likely to be added.
        step: seconds of a step that is solved as a whole.
        unloaded: steps behind the first one that begin or end without load, where contacts touch or
            part with friction.
        divided: parts that each of those is solved in at most.
        others: bytes of all processes but the largest.
    """

    unknowns: int
    tractions: int
    steps: int
    memory: float
    dense: float
    on_disk: bool
    seconds: float
    behind: float
    dimension: int
    stations: int = 0
    added: int = 0
    step: float = 0.0
    unloaded: int = 0
    divided: int = 1
    others: float = 0.0

    @property
    def longest(self) -> float:
        """Seconds if all steps without load at one end are divided as far as may be.

        Their parts take ten times as long as steps, about: contacts change in each.
        """
        return self.seconds + 10 * self.unloaded * self.divided * self.step

    @property
    def text(self) -> str:
        """The estimate in words."""
        disk = " (factors on disk)" if self.on_disk else ""
        if self.dense > MOST * self.memory:
            disk += f", {_rounded(self.dense / 2**30)} GB of them for the contact tractions,"
        added = f" ({self.added} of them in cycles likely to be added)" if self.added else ""
        edges = f", {self.stations} {'edges' if self.dimension == 2 else 'stations'}"
        return (
            f"{self.unknowns} unknowns, {self.tractions} contact tractions, {self.steps} steps"
            f"{added}{edges if self.stations else ''}: about {_rounded(self.memory / 2**30)} "
            f"GB{disk} and {_duration(self.seconds)}, "
            f"{_duration(self.behind)} of them for edge factors, fields and pictures{self._more}"
        )

    def pays_beside(self, alone: Cost) -> bool:
        """Tell whether several processes save enough of a long run on one to be worth a line."""
        return alone.seconds > LONG_RUN and self.seconds < (1 - SAVED) * alone.seconds

    def beside(self, alone: Cost) -> str:
        """The estimate for several processes beside that for one, in words."""
        return (
            f"about {_rounded(self.memory / 2**30)} GB for the largest of them, "
            f"{_rounded((self.memory + self.others) / 2**30)} GB for all, and "
            f"{_duration(self.seconds)}, {self.seconds / alone.seconds:.2g} of that"
        )

    @property
    def fits(self) -> bool:
        """True if all processes fit into the memory of this machine."""
        there = machine_memory()
        return there is None or self.memory + self.others <= there

    @property
    def _more(self) -> str:
        """Time that steps which are divided may take, in words; empty if that is little."""
        if self.longest < 1.5 * self.seconds:
            return ""
        steps = "step begins or ends" if self.unloaded == 1 else "steps begin or end"
        return (
            f"; up to {_duration(self.longest)}, as {self.unloaded} later {steps} without load, to "
            f"be divided into up to {self.divided} parts"
        )


@dataclass(frozen=True)
class BodySizes:
    """The sizes of the bodies of a mesh, one after the other, by which costs are estimated.

    Attributes:
        dimension: 2 or 3.
        components: of displacements and tractions.
        unknowns: displacements.
        entries: of the symmetric factors.
        separators: unknowns that separate the halves of a body.
    """

    dimension: int
    components: int
    unknowns: tuple[int, ...]
    entries: tuple[float, ...]
    separators: tuple[float, ...]

    @classmethod
    def of(cls, mesh: Mesh, degree: int, components: int | None = None) -> BodySizes:
        """Those of a mesh.

        Args:
            mesh: of all bodies.
            degree: of the displacements.
            components: without it as many as coordinates.
        """
        size, bodies = components or mesh.dimension, tuple(mesh.bodies.values())
        unknowns = tuple(body_unknowns(body, degree, size) for body in bodies)
        found = tuple(_factor_size(body, degree, size) for body in bodies)
        entries, separators = zip(*found, strict=True)
        return cls(mesh.dimension, size, unknowns, entries, separators)


def estimate_cost(bodies: BodySizes, nodes: int, amount: Amount, ranks: int = 1) -> Cost:
    """Estimate memory and time of a case.

    Args:
        bodies: their sizes.
        nodes: multiplier nodes of all contacts.
        amount: of what is solved and written with it.
        ranks: processes, on cores of their own.
    """
    dimension, tractions = bodies.dimension, bodies.components * nodes
    dense = 8.0 * MATRICES[dimension] * tractions**2
    grown = bodies.unknowns if dimension == 2 else bodies.entries
    work = [n**1.5 for n in grown]
    groups = share_out(work, ranks)

    def spread(of_bodies: Sequence[float]) -> list[tuple[float, int]]:
        """For each group the share of its busiest process, and how many it has."""
        return [(sum(of_bodies[each] for each in own) * n**SPREADING, n) for own, n in groups]

    def busiest(of_bodies: Sequence[float]) -> float:
        return max(spread(of_bodies))[0]

    # Process 0 has the matrices of the interface beside its part of a body.
    each_body = zip(bodies.entries, bodies.unknowns, strict=True)
    parts = [PER_ENTRY * own + PER_UNKNOWN[dimension] * n for own, n in each_body]
    there, condensing = machine_memory(), [0.0]
    on_disk = there is not None and ranks * ALWAYS + sum(parts) + dense > IN_MEMORY * there
    if on_disk:
        condensing = [_condensing_on_disk(bodies, own, tractions) for own, _ in groups]
        dense = max(*condensing, 8.0 * MATRICES_ON_DISK * tractions**2)
        parts = [PER_UNKNOWN_ON_DISK[dimension] * n for n in bodies.unknowns]
    memory = ALWAYS + busiest(parts) + dense
    others = (ranks - 1) * ALWAYS + sum(own * n for own, n in spread(parts)) - busiest(parts)
    others += max(sum(condensing) - dense, 0.0)
    preparation = FACTORISING[dimension] * busiest(work) + ASSEMBLING[dimension] * busiest(
        bodies.unknowns
    )
    steps_of_one = 1 - SHARED_STEPS + SHARED_STEPS / ranks
    interface = ORDERS * INTERFACE * tractions**3 * steps_of_one
    step = STEP + STEP_SQUARED[dimension] * tractions**2 * steps_of_one
    unknowns = sum(bodies.unknowns)
    behind = unknowns * (EDGES[dimension] * amount.stations + FIELDS[dimension] * amount.states)
    behind += STATION[dimension] * amount.stations
    behind *= 1 - SHARED_BEHIND + SHARED_BEHIND / min(ranks, len(bodies.unknowns))
    behind += DRAWING[dimension] + PICTURES[dimension] * unknowns
    seconds = STARTING + preparation + interface + amount.steps * step + behind
    return Cost(
        unknowns, tractions, amount.steps, memory, dense, on_disk, seconds, behind, dimension,
        amount.stations, step=step, others=others,
    )  # fmt: skip


def finer_model(mesh: Mesh, cost: Cost, surfaces: Iterable[str], sizes: tuple[float, float]) -> str:
    """Unknowns and memory of a solid mesh that is finer at its contacts, in words, without meshing.

    Sizes grow with the distance from the finest elements: elsewhere all elements are shorter by the
    same length. Layers of extruded bodies stay.

    Args:
        mesh: as it is.
        cost: of its model.
        surfaces: names of the contact surfaces.
        sizes: of the finest elements now and then.
    """
    wanted, cells, facets = set(surfaces), [], []
    for body in mesh.bodies.values():
        loops = np.array(FACETS[body.cell])
        power = 3 if body.cell in SIMPLICES else 2
        # Of the sides of a cell, each of which two of its faces have, most lie across layers.
        corners = body.points[body.cells[:, loops]]
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=2), axis=3)
        cells.append(_more(np.median(sides.reshape(len(sides), -1), axis=1), sizes, power))
        for name in wanted & set(body.boundaries):
            corners = body.points[body.boundaries[name][:, : loops.shape[1]]]
            sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
            facets.append(_more(sides.min(axis=1), sizes, power - 1))
    more, tractions = (
        sum(mean * count for mean, count in each) / sum(count for _, count in each)
        for each in (cells, facets)
    )
    factors = cost.memory - cost.dense - ALWAYS - PER_UNKNOWN[3] * cost.unknowns
    unknowns = more * cost.unknowns
    memory = ALWAYS + max(factors, 0.0) * more**POWER_IN_SPACE + PER_UNKNOWN[3] * unknowns
    full = 8.0 * (tractions * cost.tractions) ** 2
    memory += MATRICES[3] * full
    there = machine_memory()
    if cost.on_disk or (there is not None and memory > IN_MEMORY * there):
        memory = ALWAYS + PER_UNKNOWN_ON_DISK[3] * unknowns + MATRICES_ON_DISK * full
    text = f"about {_whole(unknowns)} unknowns, {_rounded(memory / 2**30)} GB"
    if there is not None and memory > there:
        text += ", more than this machine has; with edges.tolerance only fronts get finer elements"
    return text


def _more(lengths: Array, sizes: tuple[float, float], power: int) -> tuple[float, int]:
    """Mean number of elements in place of one of these lengths (n,), and how many these are."""
    now, then = sizes
    # Over an element, whose own length is in its middle, sizes grow by a part of it.
    inside = lengths[:, None] * (1 + WITHIN * np.array([-0.4, -0.2, 0.0, 0.2, 0.4]))
    shorter = np.maximum(inside - (now - then), lengths[:, None] * then / now)
    return float(np.mean((lengths[:, None] / shorter) ** power)), len(lengths)


def _condensing_on_disk(bodies: BodySizes, group: Sequence[int], tractions: int) -> float:
    """Bytes of full matrices while the last body of a group is condensed with factors on disk."""
    # Halves of the bodies before, the complement of this one, and its last fronts.
    last = tractions + max(bodies.separators[number] for number in group)
    return 8.0 * tractions**2 * (len(group) + 1) / 2 + 8.0 * FRONTS * last**2


def least_memory(elements: float, dimension: int) -> float:
    """Bytes that a mesh of triangles or tetrahedra takes at least, with displacements of degree 1.

    Args:
        elements: of two bodies of about the same size.
        dimension: 2 in the plane, 3 in space.
    """
    unknowns = elements * UNKNOWNS_PER_ELEMENT[dimension]
    if unknowns < FEWEST_UNKNOWNS:
        return ALWAYS
    half = unknowns / 2
    entries = _plane_entries(half) if dimension == 2 else ENTRIES_IN_SPACE * half**POWER_IN_SPACE
    return ALWAYS + 2 * PER_ENTRY * entries + PER_UNKNOWN[dimension] * unknowns


def _factor_size(body: BodyMesh, degree: int, components: int) -> tuple[float, float]:
    """Entries of the symmetric factor of a body, and unknowns that separate its halves."""
    if body.points.shape[1] == 2:
        # Blocks of a pair of nodes: as in the plane, with the square of the components.
        return _plane_entries(body_unknowns(body, degree)) * (components / 2) ** 2, 0.0
    corners, nodes = body.cells[:, : CORNERS[body.cell]], 3 * PER_CORNER[degree]
    first, more = _squared_separators(body.points, corners, LEVELS)
    entries = PER_SQUARE * nodes**2 * (first**2 + more) + REST * body_unknowns(body, degree)
    return entries, nodes * first


def _plane_entries(unknowns: float) -> float:
    return unknowns * max(ENTRIES * math.log2(unknowns) - FEWER, FEWEST)


def _squared_separators(points: Array, cells: Indices, levels: int) -> tuple[int, int]:
    """Number of nodes that separate the halves of cells; sum of its squares for halves of halves...

    Args:
        points: (n, d).
        cells: (m, k) corner nodes. They are halved across the axis along which that takes fewest.
        levels: of halves.
    """
    if levels == 0 or len(cells) < 2:
        return 0, 0
    middles = points[cells].mean(axis=1)
    halves = []
    for middle in middles.T:
        first = middle < np.median(middle)
        both = np.zeros((2, len(points)), dtype=bool)
        both[0, cells[first]] = both[1, cells[~first]] = True
        halves.append((int(np.count_nonzero(both.all(axis=0))), first))
    count, first = min(halves, key=lambda half: half[0])
    parts = [_squared_separators(points, cells[each], levels - 1) for each in (first, ~first)]
    return count, sum(own**2 + more for own, more in parts)


def refuse_too_large(cost: Cost) -> None:
    """Refuse a run whose processes do not fit into the memory of this machine.

    Raises:
        ModelError: says what would fit.
    """
    there, needed = machine_memory(), cost.memory + cost.others
    if there is None or cost.fits:
        return
    if cost.dense > MOST * needed:
        left = max(there - (needed - cost.dense), 0.0)
        fits = f"{_whole(cost.tractions * math.sqrt(left / cost.dense))} contact tractions"
        proposal = FEWER_TRACTIONS[cost.dimension]
    else:
        power = 1.0 if cost.dimension == 2 else 1 / POWER_IN_SPACE
        fits = f"{_whole(cost.unknowns * (there / needed) ** power)} unknowns"
        proposal = PROPOSALS[cost.dimension]
    raise ModelError(
        f"expected a model that fits into the memory of this machine ({_rounded(there / 2**30)} "
        f"GB), found one that needs about {_rounded(needed / 2**30)} GB ({cost.unknowns} "
        f"unknowns; {cost.tractions} contact tractions, whose full matrices take "
        f"{_rounded(cost.dense / 2**30)} GB). About {fits} would fit: {proposal}"
    )


def _rounded(value: float) -> str:
    return f"{value:.2g}" if value < 100 else f"{value:.0f}"


def _whole(value: float) -> str:
    """A whole number by its first two digits: no estimate is better."""
    return f"{float(f'{value:.2g}'):.0f}"


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{_rounded(seconds)} s"
    if seconds < 6000:
        return f"{_rounded(seconds / 60)} min"
    return f"{_rounded(seconds / 3600)} h"
