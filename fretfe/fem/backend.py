# SPDX-License-Identifier: LGPL-3.0-or-later
"""The backend `fem`: finite elements, any geometry; collective over all ranks."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache, partial
from typing import Any, TypeVar

import numpy as np
import scipy.linalg

from fretfe._typing import Array
from fretfe.backends.protocol import DEFAULTS, Backend, Processes, RunOptions, Session
from fretfe.bodies.continued import coupled_contacts, half_middles
from fretfe.bodies.definition import contact_surfaces, define_model
from fretfe.bodies.expected import coarse_contacts, pressure_doubts
from fretfe.bodies.free_ends import end_warning
from fretfe.case import Case, stiffness_doubts
from fretfe.environment import (
    address_room,
    idle_cores,
    machine_memory,
    peak_memory,
    threads_asked_for,
    too_little_room,
)
from fretfe.errors import MemoryShortError
from fretfe.fem._compat import MPI, WORK_SPACE, PETSc, basix
from fretfe.fem.model import LoadMesh, Prepared, build_model
from fretfe.fem.parallel import on_root, release
from fretfe.fem.refine import refine
from fretfe.fem.run import load_history, solve, solve_prepared
from fretfe.fem.timing import Clock
from fretfe.loads import History, build_history
from fretfe.mesh.cost import Amount, BodySizes, estimate_cost
from fretfe.mesh.mesh import Mesh, count_unknowns
from fretfe.results.model import Result
from fretfe.surface.checks import load_mesh

T = TypeVar("T")
SolveCase = Callable[[Case, RunOptions, LoadMesh], Result]

# Part of the memory of the machine that copies of the process may take with it.
OF_MEMORY = 0.8
# Keys of a case that do not enter its model.
FREE: dict[str, Any] = {
    "title": True,
    "units": True,
    "cycle": True,
    "start": True,
    "output": True,
    "contacts": {"__all__": {"friction", "friction_from"}},
    "loads": {"__all__": {"history"}},
}


def secure_work_space(comm: MPI.Comm) -> None:
    """Have the linear algebra take its work space now, before anything is solved. Collective.

    Raises:
        MemoryShortError: if the address space of a process is limited, and too little is left.
    """
    room = comm.allreduce(address_room(), MPI.MIN)
    what = "the linear algebra may take, and more for the case itself"
    shortage = too_little_room(WORK_SPACE, what, room)
    if shortage and take_work_space.cache_info().currsize == 0:
        raise MemoryShortError(shortage)
    take_work_space()


@cache
def take_work_space() -> None:
    """Call each copy of OpenBLAS once in a process."""
    one = np.eye(2)
    np.linalg.solve(one, one)
    scipy.linalg.solve(one, one)
    basix.create_element(basix.ElementFamily.P, basix.CellType.triangle, 2)
    matrix = PETSc.Mat().createDense((2, 2), array=one, comm=MPI.COMM_SELF)
    matrix.assemble()
    solver = PETSc.KSP().create(MPI.COMM_SELF)
    solver.setOperators(matrix)
    solver.setType("preonly")
    solver.getPC().setType("lu")
    right = matrix.createVecRight()
    solver.solve(right, matrix.createVecRight())
    for each in (solver, matrix, right):
        each.destroy()


class MpiProcesses(Processes):
    """All processes of MPI's world, none of which is idle."""

    shared = MPI.COMM_WORLD.size > 1
    idle = False

    @property
    def rank(self) -> int:
        """Number of this process."""
        return int(MPI.COMM_WORLD.rank)

    def on_root(self, work: Callable[[], T]) -> T:
        """Do `work` on rank 0 and give its result, or its error, to all. Collective."""
        return on_root(MPI.COMM_WORLD, work)


class FemBackend(Backend):
    """The augmented-Lagrangian contact model in DOLFINx."""

    summary = "finite elements (DOLFINx): any two-body geometry"
    processes = MpiProcesses()

    def supports(self, case: Case) -> tuple[str, ...]:
        """Every case; what is wrong with a mesh is found when it is read."""
        return ()

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """Solve a case. Collective.

        Raises:
            FretfeError: for whatever keeps the history from being started, on all ranks.
        """
        return _solve(case, options, partial(solve, MPI.COMM_WORLD))

    def session(self) -> Session:
        """Solves cases one after the other, with one model as long as it fits."""
        return FemSession(self)


class FemSession(Session):
    """Cases that share a model: it is built anew only if the one that is there does not fit.

    Args:
        backend: that solves them.
    """

    def __init__(self, backend: Backend) -> None:
        super().__init__(backend)
        self._comm = MPI.COMM_WORLD
        self._key = ""
        self._prepared: Prepared | None = None

    def group(self, case: Case) -> str:
        """Equal for cases that share a model."""
        return model_key(case)

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """As `FemBackend.solve`. Collective."""
        return _solve(case, options, self._solve_on)

    def _solve_on(self, case: Case, options: RunOptions, load: LoadMesh) -> Result:
        """Solve a case on one mesh; arguments and errors as `fretfe.fem.run.solve`."""
        clock, key = Clock(options.doing), model_key(case)
        history = load_history(self._comm, case, options)
        if self._prepared is None or key != self._key:
            self.close()
            self._prepared = build_model(self._comm, case, clock, load)
            self._key = key
        return solve_prepared(self._prepared, case, history, options, clock)

    def copies(self) -> int:
        """Number of copies of this process that may solve cases with the model that is there.

        One, so none besides this process, on several ranks, and where they would share the place in
        a file of factors. Each takes less than what this process has had at most.
        """
        ready = self._prepared
        if self._comm.size > 1 or sys.platform != "linux" or ready is None or ready.model.on_disk:
            return 1
        ready.settle()
        room = OF_MEMORY * (machine_memory() or 0.0) / peak_memory() - 1
        cores = (idle_cores() + 1) // (threads_asked_for() or 1)
        return max(1, min(cores, int(room)))

    def close(self) -> None:
        """Give the model back. Collective."""
        meshes = self._prepared.meshes if self._prepared is not None else []
        self._prepared = None
        release(meshes)


def _solve(case: Case, options: RunOptions, solve_case: SolveCase) -> Result:
    """Solve and evaluate a case, on one mesh by `solve_case`. Collective."""
    secure_work_space(MPI.COMM_WORLD)
    if case.edges.tolerance is not None:
        return refine(MPI.COMM_WORLD, case, options)
    return solve_case(case, options, partial(_load, case, options))


def _load(case: Case, options: RunOptions) -> Mesh:
    """The mesh of a case; its size tells how long it takes until the first step is solved."""
    mesh = (options.mesh or load_mesh)(case)
    unknowns = count_unknowns(mesh, case.model.degree, case.components(mesh.dimension))
    options.announce(f"mesh: {unknowns} unknowns; the bodies are condensed before the first step")
    history = options.history or build_history(case)
    if advice := _advice(case, mesh, history):
        options.announce(advice)
    # Of bodies in another unit nothing can be expected.
    doubts = tuple(stiffness_doubts(case))
    if not doubts:
        middles = _middles(case, mesh)
        doubts = tuple(pressure_doubts(case, mesh, history, middles))
    for warning in doubts or coarse_contacts(case, mesh, history, middles):
        options.announce(f"Warning: {warning}")
    for warning in end_warning(case, mesh):
        options.announce(f"Warning: {warning}")
    return mesh


def _advice(case: Case, mesh: Mesh, history: History) -> str:
    """The number of processes that a long run on one had better have, in words; or nothing.

    Tractions, which are not known yet, add to both.
    """
    ranks, amount = idle_cores() + 1, Amount(len(history.times) - 1)
    if MPI.COMM_WORLD.size > 1 or ranks == 1:
        return ""
    bodies = BodySizes.of(mesh, case.model.degree, case.components(mesh.dimension))
    several, alone = (estimate_cost(bodies, 0, amount, n) for n in (ranks, 1))
    if not several.pays_beside(alone):
        return ""
    return (
        f"{ranks} cores are there: --ranks {ranks} takes less time; fretfe check estimates how much"
    )


def _middles(case: Case, mesh: Mesh) -> dict[str, Array]:
    """(2,) middles of contacts of which a plane model has a half, by name."""
    held = any(len(each.fix) == 1 or each.direction for each in case.supports.values())
    if mesh.dimension == 3 or not held:
        return {}
    model = define_model(case, mesh)
    return half_middles(coupled_contacts(case, model, mesh, contact_surfaces(model, mesh)))


BACKEND = FemBackend()


def model_key(case: Case) -> str:
    """Text that is equal for two cases that can be solved with one model."""
    files = (case.geometry.file, *(getattr(load, "file", None) for load in case.loads.values()))
    places = [str(case.resolve(file).absolute()) for file in files if file is not None]
    # The label of the unit of length decides how a STEP file is read.
    place = f"{' '.join(places)} {case.units.length} " if places else ""
    return place + repr(case.model_dump(mode="json", exclude=FREE))
