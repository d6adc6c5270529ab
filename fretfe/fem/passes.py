# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of a case that refines itself: base of those of plane bodies and of solids."""

from __future__ import annotations

import json
import math
import shutil
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from fretfe.backends.protocol import RunOptions
from fretfe.case import Case
from fretfe.edges.refinement import Pass, Refinement
from fretfe.errors import MeshError, OutputError
from fretfe.mesh.groups import count_unknowns
from fretfe.mesh.mesh import Mesh
from fretfe.results.files import disk_reason, replace_text
from fretfe.results.model import Result

# More passes than this do not help: the element size at the edges has been halved eight times.
MOST_PASSES = 12
# In the folder of the states: what makes the next mesh.
NOTE = "refinement.json"


class Passes(ABC):
    """The meshes of a case one after the other, and what they gave; rank 0 only.

    Args:
        case: that asks for an accuracy.
        announce: told of each mesh.
    """

    def __init__(self, case: Case, announce: Callable[[str], None]) -> None:
        assert case.edges.tolerance is not None
        self._case = case
        self._announce = announce
        self._edges, self._tolerance = case.edges, case.edges.tolerance
        self._done: tuple[Pass, ...] = ()
        self._mesh: Mesh | None = None

    @abstractmethod
    def _make_mesh(self) -> Mesh:
        """The next mesh."""

    @abstractmethod
    def _pass(self, result: Result, mesh: Mesh) -> Pass:
        """What a mesh gave."""

    @abstractmethod
    def _make_finer(self, result: Result, mesh: Mesh) -> None:
        """Plan the next mesh after a pass."""

    @abstractmethod
    def _noted(self) -> dict[str, Any]:
        """What makes the next mesh, for JSON."""

    @abstractmethod
    def _follow(self, note: dict[str, Any]) -> None:
        """Plan the next mesh as noted."""

    def options(self, options: RunOptions, keep: Callable[[Result], None]) -> RunOptions:
        """Options of the next pass, which has a folder of its own for its states."""
        states = options.states
        states = states / f"mesh-{len(self._done) + 1}" if states is not None else None
        return replace(options, states=states, before=None, keep=keep)

    def note(self, states: Path | None) -> None:
        """Write down what makes the next mesh, and remove the states of the last pass.

        Raises:
            OutputError: if that is not possible.
        """
        if states is None:
            return
        count = len(self._done)
        try:
            replace_text(states / NOTE, json.dumps({"passes": count, **self._noted()}))
            shutil.rmtree(states / f"mesh-{count}", ignore_errors=True)
        except OSError as error:
            raise OutputError(f"{states}: cannot be written: {disk_reason(error)}") from error

    def recall(self, last: Result | None, states: Path | None) -> bool:
        """Go on after the passes that an earlier run has noted; return False if there are none.

        Args:
            last: result of the last pass or, if the run ended between the two, one later.
            states: folder of the note.
        """
        refinement = last.refinement if last is not None else None
        if states is None or refinement is None or not (states / NOTE).is_file():
            return False
        note = json.loads((states / NOTE).read_text(encoding="utf-8"))
        self._done = refinement.passes[: note["passes"]]
        self._follow(note)
        return True

    def load(self) -> Mesh:
        """The next mesh.

        Raises:
            MeshError: if it is larger than the case allows, or as for `load_mesh`.
        """
        mesh = self._make_mesh()
        unknowns = self._unknowns(mesh)
        if unknowns > self._edges.unknowns:
            raise MeshError(
                f"{self._case.source}: edges.unknowns: mesh {len(self._done) + 1} would have "
                f"{unknowns} unknowns, expected at most {self._edges.unknowns}"
            )
        self._announce(f"mesh {len(self._done) + 1}: {unknowns} unknowns")
        self._mesh = mesh
        return mesh

    def _unknowns(self, mesh: Mesh) -> int:
        return count_unknowns(mesh, self._case.model.degree)

    def judge(self, result: Result) -> Refinement:
        """All passes so far, this one included; without a reason to end there is another."""
        mesh = self._mesh
        assert mesh is not None
        if result.failure is not None:
            return self._refinement(reason=str(result.failure))
        before = self._done[-1] if self._done else None
        self._done += (self._pass(result, mesh),)
        last = self._done[-1]
        self._announce(f"mesh {len(self._done)}: {_change_text(before, last)}")
        if before is not None and before.resolved and self._fine_enough(last):
            return self._refinement("the results no longer change", converged=True)
        if len(self._done) == MOST_PASSES:
            return self._refinement(f"{MOST_PASSES} meshes were not enough")
        self._make_finer(result, mesh)
        return self._refinement("")

    def _fine_enough(self, last: Pass) -> bool:
        return last.resolved and last.change <= self._tolerance

    def _refinement(self, reason: str, *, converged: bool = False) -> Refinement:
        return Refinement(self._tolerance, self._done, converged, reason)


def _change_text(before: Pass | None, last: Pass) -> str:
    if before is None and last.stations:
        return "shows where the contact edges are"
    if not math.isfinite(last.change):
        return "no edge factors yet"
    return f"edge factors and slip zones changed by up to {last.change:.2%}"
