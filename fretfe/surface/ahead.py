# SPDX-License-Identifier: LGPL-3.0-or-later
"""A case whose mesh is begun before the backend is loaded that solves it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from queue import SimpleQueue

from fretfe.case import Case
from fretfe.errors import FretfeError
from fretfe.libraries import has_own_folder
from fretfe.mesh.gmsh import TAKEN_SIGNALS
from fretfe.mesh.mesh import Mesh
from fretfe.surface.checks import load_mesh


class CaseAhead:
    """A case, read on this process, and its mesh, which is made in a thread from now on.

    Gmsh, which runs without the lock of Python or in another process, takes as long as DOLFINx
    takes to load: one waits for the other no more. Errors wait until somebody asks.

    Args:
        read: reads it, as `load_case`.
    """

    def __init__(self, read: Callable[[], Case]) -> None:
        self._case: Case | FretfeError
        self._begun: _Begun | None = None
        try:
            self._case = read()
        except FretfeError as error:
            self._case = error
            return
        # Meshes that refine themselves are not those of `load_mesh`.
        if self._case.edges.tolerance is None:
            self._begun = _Begun(self._case)

    def case(self) -> Case:
        """Return the case, or raise why there is none."""
        if isinstance(self._case, FretfeError):
            raise self._case
        return self._case

    def mesh(self, case: Case) -> Mesh:
        """Return the mesh that was begun if it is that of this case, and make one if not."""
        return self._begun.mesh() if self._begun and case is self._case else load_mesh(case)


class _Begun(threading.Thread):
    """The mesh of a case in the making.

    Args:
        case: validated case.
    """

    def __init__(self, case: Case) -> None:
        # Templates are meshed in this process, which must not end meanwhile; files are read in
        # another one, which ends with it.
        super().__init__(daemon=case.geometry.template is None)
        self._case = case
        self._found: Mesh | BaseException
        self._alone: SimpleQueue[bool] = SimpleQueue()
        self.start()
        # DOLFINx is loaded in another folder, which this one must not take for its own.
        if not self._alone.get():
            self.join()

    def run(self) -> None:
        """Make it."""
        self._alone.put(has_own_folder())
        try:
            self._found = load_mesh(self._case)
        except BaseException as error:
            self._found = error

    def mesh(self) -> Mesh:
        """Wait for it; raises the errors of `load_mesh`."""
        self.join()
        # Gmsh's library takes signals from Python, and gives none back in a thread.
        if threading.current_thread() is threading.main_thread():
            for each in TAKEN_SIGNALS:
                handler = signal.getsignal(each)
                if handler is not None:  # set from Python
                    signal.signal(each, handler)
        if isinstance(self._found, BaseException):
            raise self._found
        return self._found
